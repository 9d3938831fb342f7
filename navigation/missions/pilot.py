"""A navigator that is driven from outside, period by period: by a robot's own loop, or ROS."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.missions.run import MissionJob
from octant.navigation.navigators.interface import STILL, Mode, Odometry
from octant.navigation.robot.motion import AT_REST, Motion

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PilotStep:
    """What a navigator makes of one reading.

    Parameters
    ----------
    speed_m_per_s, turn_rate_rad_per_s : Command until the next reading [m/s], [rad/s].
    reached : The tag that is declared reached by this reading; None: none is. The robot stands, and
        the next tag is to be read at once.
    done : All tags are reached.
    mode : What the robot does.
    pose : (3,) float64 or None — Where the navigator believes itself, x, y [m], heading [rad].
    place_m : (2,) float64 or None — Where it believes the tag, ahead and to the left [m].
    """

    speed_m_per_s: float
    turn_rate_rad_per_s: float
    reached: str | None
    done: bool
    mode: Mode
    pose: FloatArray | None = None
    place_m: FloatArray | None = None


class Pilot:
    """The navigator of a mission, fed with readings and odometry of a robot that is elsewhere.

    Fed with what the robot of a simulated run reads and counts, it commands what that run does.

    Parameters
    ----------
    job : The mission: its navigator, robot and tags.
    seed : Of what the navigator draws.
    """

    def __init__(self, job: MissionJob, seed: np.random.SeedSequence) -> None:
        self._job = job
        mission = job.mission
        if job.starts is not None:
            x, y, heading = job.starts.start(seed)
            self.start = np.array([x, y, heading])
        else:
            self.start = np.array([*mission.start_m, mission.heading_rad])
        self._heading_rad = float(wrap_angle(self.start[2]))
        self._rng = np.random.default_rng(seed).spawn(2)[1]
        self._target = 0
        self._memory = job.navigator.begin(0, None, heading_rad=self._heading_rad)
        self.done = False

    @property
    def period_s(self) -> float:
        """Return the time from one reading to the next [s]."""
        return self._job.mission.sample_time_s

    @property
    def tag_id(self) -> str:
        """Return the tag that is to be reached."""
        return self._job.mission.tag_ids[self._target]

    @property
    def hears(self) -> tuple[str, ...]:
        """Return the tags that are to be read in each period, in this order."""
        heard: tuple[str, ...] = getattr(self._job.navigator, "hears", ())
        return heard or (self.tag_id,)

    def step(self, rss_w: npt.ArrayLike, odometry: Odometry = STILL) -> PilotStep:
        """Return the command for the coming period.

        Parameters
        ----------
        rss_w : (t, n) array_like — Reading of each tag of `hears`, 0 where nothing was received
            [W]; (n,) where it is one tag.
        odometry : What the wheels counted since the last reading; nothing after a tag was reached.
        """
        told_w = self._checked(rss_w)
        if self.done:
            msg = "all tags of the mission are reached, so that nothing is left to drive to."
            raise NavigationError(msg)
        decision = self._job.navigator.decide(self._memory, told_w, odometry, self._rng)
        reached = self.tag_id if decision.reached else None
        command = np.zeros(2)
        if not decision.reached:
            self._memory = decision.memory
            command = np.asarray(self._job.robot.twist(decision.rates), dtype=np.float64)
        elif self._target + 1 == len(self._job.mission.tag_ids):
            self.done = True
        else:
            self._target += 1
            self._memory = self._job.navigator.begin(
                self._target, decision.memory, heading_rad=self._heading_rad
            )
        return PilotStep(
            speed_m_per_s=float(command[0]),
            turn_rate_rad_per_s=float(command[1]),
            reached=reached,
            done=self.done,
            mode=decision.mode,
            pose=decision.pose,
            place_m=decision.place_m,
        )

    def _checked(self, rss_w: npt.ArrayLike) -> FloatArray:
        """Return the reading as the navigator takes it; refuse one of another shape or below 0."""
        tags, antennas = len(self.hears), self._job.sensor.antennas
        given = np.asarray(rss_w, dtype=np.float64)
        told_w = given.reshape(-1, given.shape[-1]) if given.ndim else given.reshape(1, 1)
        if told_w.shape != (tags, antennas) or not (told_w >= 0.0).all():
            msg = (
                f"rss_w has the shape {given.shape}, or values below 0 or without a number; give "
                f"{antennas} powers [W] for each of {', '.join(self.hears)}."
            )
            raise NavigationError(msg)
        several = bool(getattr(self._job.navigator, "hears", ()))
        return told_w if several else told_w[0]


class SimulatedReader:
    """What the mission's reader would receive in its room, with the noise of its receiver.

    Parameters
    ----------
    job : The mission: its tags, room and receiver.
    seed : Of the noise.
    """

    def __init__(self, job: MissionJob, seed: np.random.SeedSequence) -> None:
        self._sensor: Any = job.sensor
        self._rng = np.random.default_rng(seed)
        self.antennas = job.sensor.antennas
        self.azimuths_rad = job.sensor.azimuths_rad
        self.tag_ids = tuple(job.sensor.tag_ids)

    def read(
        self,
        pose: npt.ArrayLike,
        tag_id: str,
        *,
        speed_m_per_s: float = 0.0,
        turn_rate_rad_per_s: float = 0.0,
    ) -> FloatArray:
        """Return one reading of a tag, (n,); 0 where nothing is received [W].

        Parameters
        ----------
        pose : (3,) array_like — The robot's x, y [m] and heading [rad] in the room.
        tag_id : The tag.
        speed_m_per_s, turn_rate_rad_per_s : How it has driven since the last reading, on whose way
            a reader that switches its antennas reads them one after another [m/s], [rad/s].
        """
        place = np.asarray(pose, dtype=np.float64)
        if place.shape != (3,) or not np.isfinite(place).all():
            msg = f"pose is {pose!r:.60}, but x, y [m] and the heading [rad] are needed."
            raise NavigationError(msg)
        moving = speed_m_per_s != 0.0 or turn_rate_rad_per_s != 0.0
        motion = AT_REST
        if moving:
            motion = Motion(speed_m_per_s=speed_m_per_s, turn_rate_rad_per_s=turn_rate_rad_per_s)
        found: FloatArray = self._sensor.read(place, tag_id, self._rng, motion=motion)
        return found
