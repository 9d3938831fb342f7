"""Closed-loop missions: navigator, sensor and robot, one sample period after another."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.missions.batches import Mapper, run_seeded
from octant.navigation.missions.records import Mission, MissionOutcome, MissionResult
from octant.navigation.missions.starts import Carried, Starts
from octant.navigation.navigators.interface import STILL, Decision, Navigator, Odometry
from octant.navigation.navigators.learned import Learned
from octant.navigation.navigators.map_navigator import MapNavigator
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import Blocked, Floor, check_start
from octant.navigation.robot.motion import AT_REST, Motion, move
from octant.navigation.robot.odometry import RollingWheels, wheel_travel
from octant.navigation.sensing.sensor import RssSensor, unknown_tag


def run_mission(
    mission: Mission,
    sensor: RssSensor,
    navigator: Navigator[Any],
    robot: DifferentialDrive,
    rng: np.random.Generator,
    *,
    blocked: Blocked | None = None,
    outside: Blocked | None = None,
    carried: Carried | None = None,
) -> MissionResult:
    """Return the record of one closed-loop run; a run that fails is a result too.

    A sensor that reads its antennas in turn does so on the last stretch of the way driven. After an
    arrival the next tag is read at once, in the same period, by the robot at rest.

    Parameters
    ----------
    mission : Start, tags and manner.
    sensor : What the robot reads.
    navigator : What decides; it gets readings and odometry and nothing else.
    robot : The robot.
    rng : Source of every random number; wheels and navigator draw from two children of it.
    blocked, outside : (m, 2) points [m] -> (m,) bool: where the robot's centre cannot be; where it
        has left the room, whose field is known inside only.
    carried : When somebody takes the robot elsewhere, unnoticed by its wheels; None: never.
    """
    _check_run(mission, sensor, robot)
    check_start(mission.start_m, blocked, outside)
    wheels_rng, navigator_rng = rng.spawn(2)
    carry_at_s, elsewhere = _carrying(carried, rng)
    wheels = RollingWheels(mission.rolling, robot, wheels_rng)
    floor = Floor(robot=robot, step=mission.motion, contact=mission.contact, blocked=blocked)
    heading_rad = float(wrap_angle(mission.heading_rad))
    pose = np.array([*mission.start_m, heading_rad])
    log = _Log(mission, robot)
    target, silent, touched = 0, 0, 0
    memory, odometry = navigator.begin(0, None, heading_rad=heading_rad), STILL
    driven = AT_REST
    period_s = mission.sample_time_s
    last = int(np.floor(mission.time_limit_s / period_s * (1.0 + 1e-12)))
    for k in range(last + 1):
        if k * period_s >= carry_at_s:
            pose, driven, carry_at_s = elsewhere, AT_REST, math.inf
        rss_w, told_w = _read(sensor, navigator, (pose, driven), mission.tag_ids[target], rng)
        decision = navigator.decide(memory, told_w, odometry, navigator_rng)
        while decision.reached:
            log.arrive(k, pose, target)
            if target + 1 == len(mission.tag_ids):
                log.row(k, pose, decision, target, rss_w)
                return log.result(
                    "completed", "all tags were declared reached",
                    _learned(navigator, decision.memory),
                )  # fmt: skip
            target, silent, touched = target + 1, 0, 0
            rss_w, told_w = _read(sensor, navigator, (pose, AT_REST), mission.tag_ids[target], rng)
            memory = navigator.begin(target, decision.memory, heading_rad=heading_rad)
            decision = navigator.decide(memory, told_w, STILL, navigator_rng)
        silent = 0 if float(told_w.max()) > 0.0 else silent + 1
        touched += odometry.contact
        ended = _ended(mission, target, silent=silent, touched=touched, out_of_time=k == last)
        if ended is not None:
            log.row(k, pose, replace(decision, mode="stopped"), target, rss_w)
            return log.result(*ended, _learned(navigator, decision.memory))
        log.row(k, pose, decision, target, rss_w)
        rotations = period_s * wheels.turn(decision.rates, period_s=period_s)
        rates = wheels.roll(rotations, period_s=period_s) / period_s
        pose, contact = floor.roll(pose, rates, period_s=period_s)
        log.contacts += contact
        speed_m_per_s, turn_rate_rad_per_s = robot.twist(rates)
        driven = AT_REST
        if not contact:
            driven = Motion(
                speed_m_per_s=float(speed_m_per_s), turn_rate_rad_per_s=float(turn_rate_rad_per_s)
            )
        distance_m, turn_rad = wheel_travel(wheels.count(rotations), robot)
        odometry = Odometry(distance_m=float(distance_m), turn_rad=float(turn_rad), contact=contact)
        log.rolled(odometry)
        if outside is not None and bool(outside(pose[None, :2])[0]):
            stopped = replace(decision, mode="stopped", place_m=None, pose=None)
            log.row(k + 1, pose, stopped, target, np.zeros(sensor.antennas))
            way = f"on its way to tag {mission.tag_ids[target]}"
            return log.result("left the room", f"the robot left the room {way}", None)
        memory = decision.memory
    raise AssertionError  # the last turn always ends the run


def _carrying(
    carried: Carried | None, rng: np.random.Generator
) -> tuple[float, npt.NDArray[np.float64]]:
    """Return when the robot is carried elsewhere [s], and the pose there [m], [rad]."""
    if carried is None:
        return math.inf, np.zeros(3)
    return carried.at_s, carried.to.draw(rng.spawn(1)[0])


def _read(
    sensor: RssSensor,
    navigator: Navigator[Any],
    place: tuple[npt.NDArray[np.float64], Motion],
    tag_id: str,
    rng: np.random.Generator,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the reading of the current tag, and what the navigator gets: of all tags, if it asks.

    A navigator with ``hears``, ids of tags, gets their readings (t, n) in that order.
    """
    pose, motion = place
    hears: tuple[str, ...] = getattr(navigator, "hears", ())
    if not hears:
        rss_w = sensor.read(pose, tag_id, rng, motion=motion)
        return rss_w, rss_w
    told_w = np.array([sensor.read(pose, one, rng, motion=motion) for one in hears])
    return told_w[hears.index(tag_id)], told_w


def _learned(navigator: Navigator[Any], memory: object) -> Learned | None:
    """Return what a navigator that learns, with a method ``learned``, makes of its memory."""
    learns: Callable[[object], Learned | None] | None = getattr(navigator, "learned", None)
    return None if learns is None else learns(memory)


def _check_run(mission: Mission, sensor: RssSensor, robot: DifferentialDrive) -> None:
    for tag_id in mission.tag_ids:
        if tag_id not in sensor.tag_ids:
            raise unknown_tag(tag_id, sensor.tag_ids)
    if mission.cruise_speed_m_per_s > robot.max_wheel_speed_m_per_s:
        msg = (
            f"the cruise speed is {mission.cruise_speed_m_per_s:g} m/s, but the wheels reach "
            f"{robot.max_wheel_speed_m_per_s:g} m/s: take a smaller step or a longer period."
        )
        raise NavigationError(msg)


def _ended(
    mission: Mission, target: int, *, silent: int, touched: int, out_of_time: bool
) -> tuple[MissionOutcome, str] | None:
    tag_id = mission.tag_ids[target]
    if touched and mission.contact == "end":
        return "collision", f"the robot ran into an obstacle on its way to tag {tag_id}"
    if touched >= mission.contact_limit:
        return "stuck", f"the robot touched obstacles {touched} times on its way to tag {tag_id}"
    if silent >= mission.silent_limit:
        return "no signal", f"no antenna received tag {tag_id} in {silent} readings in a row"
    if out_of_time:
        limit_s = mission.time_limit_s
        shown = f"{limit_s:g}" if limit_s < 100.0 else f"{limit_s:.0f}"
        return "time-out", f"tag {tag_id} was not reached within {shown} s"
    return None


class _Log:
    """Collects the rows of one run."""

    def __init__(self, mission: Mission, robot: DifferentialDrive) -> None:
        self._mission, self._robot = mission, robot
        self._reckoned_now = np.array([*mission.start_m, float(wrap_angle(mission.heading_rad))])
        self._commands: list[npt.NDArray[np.float64]] = []
        self._reckoned: list[npt.NDArray[np.float64]] = []
        self._believed_poses: list[npt.NDArray[np.float64]] = []
        self._rows: list[tuple[float, npt.NDArray[np.float64], str, int]] = []
        self._rss_w: list[npt.NDArray[np.float64]] = []
        self._believed_m: list[npt.NDArray[np.float64]] = []
        tags = len(mission.tag_ids)
        self._arrival_times_s = np.full(tags, np.nan)
        self._arrival_points_m = np.full((tags, 2), np.nan)
        self.contacts = 0

    def row(
        self,
        k: int,
        pose: npt.NDArray[np.float64],
        decision: Decision[Any],
        target: int,
        rss_w: npt.NDArray[np.float64],
    ) -> None:
        self._rows.append((k * self._mission.sample_time_s, pose, decision.mode, target))
        self._rss_w.append(rss_w)
        place_m = np.full(2, np.nan) if decision.place_m is None else decision.place_m
        c, s = np.cos(pose[2]), np.sin(pose[2])
        self._believed_m.append(pose[:2] + np.array([[c, -s], [s, c]]) @ place_m)
        moving = np.zeros(2) if decision.mode == "stopped" else self._robot.twist(decision.rates)
        self._commands.append(np.asarray(moving, dtype=np.float64))
        self._reckoned.append(self._reckoned_now)
        self._believed_poses.append(np.full(3, np.nan) if decision.pose is None else decision.pose)

    def rolled(self, odometry: Odometry) -> None:
        self._reckoned_now = move(
            self._reckoned_now,
            distance_m=odometry.distance_m,
            turn_rad=odometry.turn_rad,
            method="euler" if self._mission.motion == "euler" else "exact",
        )

    def arrive(self, k: int, pose: npt.NDArray[np.float64], target: int) -> None:
        self._arrival_times_s[target] = k * self._mission.sample_time_s
        self._arrival_points_m[target] = pose[:2]

    def result(
        self, outcome: MissionOutcome, reason: str, learned: Learned | None
    ) -> MissionResult:
        times_s, poses, modes, targets = zip(*self._rows, strict=True)
        return MissionResult(
            mission=self._mission,
            outcome=outcome,
            reason=reason,
            time_s=np.array(times_s),
            poses=np.array(poses),
            modes=modes,
            targets=np.array(targets, dtype=np.int64),
            rss_w=np.array(self._rss_w),
            arrival_times_s=self._arrival_times_s,
            arrival_points_m=self._arrival_points_m,
            contacts=self.contacts,
            believed_points_m=np.array(self._believed_m),
            commands=np.array(self._commands),
            reckoned=np.array(self._reckoned),
            believed_poses=np.array(self._believed_poses),
            learned=learned,
        )


def run_missions(
    mission: Mission,
    sensor: RssSensor,
    navigator: Navigator[Any],
    robot: DifferentialDrive,
    *,
    runs: int,
    seed: int,
    mapper: Mapper = map,
    blocked: Blocked | None = None,
    outside: Blocked | None = None,
    starts: Starts | None = None,
    progress: Callable[[int], object] | None = None,
) -> tuple[MissionResult, ...]:
    """Return the records of many runs of one mission, run 0 first, each with own random numbers.

    Parameters
    ----------
    mission, sensor, navigator, robot, blocked, outside : As for `run_mission`.
    runs, seed, mapper, progress : As for `run_seeded`; other processes need picklable arguments.
    starts : Start of each run in place of the mission's own.
    """
    results = run_seeded(
        MissionJob(
            mission=mission,
            sensor=sensor,
            navigator=navigator,
            robot=robot,
            blocked=blocked,
            outside=outside,
            starts=starts,
        ),
        runs=runs,
        seed=seed,
        mapper=mapper,
        progress=progress,
    )
    # Unpickled arrays are writable and each result has its own copy of the mission: make them
    # whole again.
    return tuple(
        replace(result, mission=mission if starts is None else replace(result.mission))
        for result in results
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionJob:
    """Makes one run of a mission from its seed.

    Parameters
    ----------
    mission, sensor, navigator, robot, blocked, outside, starts : As for `run_missions`.
    carried : As for `run_mission`.
    earlier : How many missions a `MapNavigator` has driven before in the same world, each of which
        taught the next one; the last of all is the run.
    """

    mission: Mission
    sensor: RssSensor
    navigator: Navigator[Any]
    robot: DifferentialDrive
    blocked: Blocked | None = None
    outside: Blocked | None = None
    starts: Starts | None = None
    carried: Carried | None = None
    earlier: int = 0

    def __call__(self, seed: np.random.SeedSequence) -> MissionResult:
        """Return the run of a seed, from which its start and all its noise come."""
        mission = self.mission
        if self.starts is not None:
            x, y, heading = self.starts.start(seed)
            mission = replace(mission, start_m=np.array([x, y]), heading_rad=float(heading))
        navigator = self.navigator
        for child in seed.spawn(self.earlier):
            learned = self._run(mission, navigator, np.random.default_rng(child)).learned
            if learned is not None and isinstance(navigator, MapNavigator):
                navigator = navigator.taught(learned)
        return self._run(mission, navigator, np.random.default_rng(seed))

    def _run(
        self, mission: Mission, navigator: Navigator[Any], rng: np.random.Generator
    ) -> MissionResult:
        return run_mission(
            mission,
            self.sensor,
            navigator,
            self.robot,
            rng,
            blocked=self.blocked,
            outside=self.outside,
            carried=self.carried,
        )
