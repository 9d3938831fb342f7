"""The stages of a docking mission: the drive under both, the coarse and the fine approach."""

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.control.docking_law import faded, latched, slip_compensated
from octant.navigation.control.polar import polar_state, pose_in_goal_frame
from octant.navigation.docking.task import (
    DockingOutcome,
    DockingResult,
    DockingSetting,
    DockingTask,
    Failure,
    Phase,
)
from octant.navigation.estimators.landmark_filters import PLACE, LandmarkTrack
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import Floor
from octant.navigation.robot.motion import AT_REST, Motion, move
from octant.navigation.robot.odometry import Rolling, RollingWheels
from octant.navigation.sensing.bearing import turn_towards, vector_sum_bearing
from octant.navigation.sensing.landmark_sensor import LandmarkSensor
from octant.navigation.sensing.sensor import RssSensor

FloatArray = npt.NDArray[np.float64]

MANOEUVRE_SPEED_M_PER_S = 0.15
"""Speed of short straight manoeuvres [m/s]."""

_MANOEUVRE_PERIOD_S = 0.4
_TURN_ON_SPOT_RAD = 0.6
_TURN_RATE_RAD_PER_S = 1.0
_SILENT_READINGS = 20
_OFFSET_M = 0.8
_EVADE_BACK_M = 0.3
_EVADE_ALONG_M = 0.6
_STILL = np.zeros(2)
_UNSURE_SD_M = 0.12
_PROGRESS_M = 0.005
_FULL_TURN_RAD = 2.3 * np.pi


class LeftTheRoom(Exception):  # noqa: N818  an outcome, not an error
    """Ends a run whose robot has left the room."""


class DockingDrive:
    """The robot of one run, with its odometry and its record.

    Parameters
    ----------
    task : What is driven.
    setting : Robot and obstacles.
    pose : (3,) float64 — True x [m], y [m], heading [rad], for the world only.
    rng : Source of the random part of the motion.
    """

    def __init__(
        self,
        task: DockingTask,
        setting: DockingSetting,
        *,
        pose: FloatArray,
        rng: np.random.Generator,
    ) -> None:
        self._task, self._setting, self._rng = task, setting, rng
        self._floor = Floor(robot=setting.robot, blocked=setting.blocked)
        self._wheels = RollingWheels(setting.rolling, setting.robot, rng)
        # Wheels without motors, slip or counts do as commanded, and are believed to (paper, II).
        self._plain = type(setting.robot) is DifferentialDrive and setting.rolling == Rolling()
        self.pose = pose
        self.rolled, self.reckoned = np.zeros(2), np.zeros(2)
        self._times_s: list[float] = []
        self._phases: list[str] = []
        self._rows: list[FloatArray] = []
        self._seen: list[bool] = []
        self._reckoned: list[FloatArray] = []
        self._rss_w: list[FloatArray] = []
        self._silence = np.full(0 if setting.reader is None else setting.reader.antennas, np.nan)
        self.heard_w: FloatArray | None = None
        self.odometry = np.zeros(3)
        self.time_s = 0.0
        self.contacts = 0
        self.staged_m = np.nan

    @property
    def robot(self) -> DifferentialDrive:
        """Return the robot's kinematics."""
        return self._setting.robot

    @property
    def turn_rate_rad_per_s(self) -> float:
        """Return the greatest rate of turns between the drives [rad/s]."""
        limit = self.robot.turning_limit_rad_per_s(MANOEUVRE_SPEED_M_PER_S)
        return min(_TURN_RATE_RAD_PER_S, limit)

    @property
    def off_dock(self) -> tuple[float, float]:
        """Return how far the robot stands from the dock [m], and is turned from it [rad]."""
        x, y, heading = pose_in_goal_frame(self.pose, self._task.goal)
        return float(np.hypot(x, y)), abs(float(heading))

    @property
    def docked(self) -> bool:
        """Return whether the station makes contact with the robot."""
        away_m, turned_rad = self.off_dock
        return away_m <= self._task.tolerance_m and turned_rad <= self._task.tolerance_rad

    @property
    def worn_out(self) -> bool:
        """Return whether the robot has touched things more often than it may."""
        return self.contacts > self._task.max_contacts

    def step(
        self,
        phase: Phase,
        twist: FloatArray,
        *,
        period_s: float,
        seen: bool = False,
        polar: FloatArray | None = None,
        slips: FloatArray | None = None,
    ) -> bool:
        """Return whether the robot touches something, or raise `LeftTheRoom`; log, move, reckon.

        Parameters
        ----------
        phase : What the robot is doing.
        twist : (2,) float64 — Command v [m/s], ω [rad/s].
        period_s : Length of the period [s].
        seen : Whether the camera reported a landmark just now.
        polar, slips : (3,), (2,) float64 or None — As in `DockingResult`, for the record [m],
            [rad].
        """
        self._row(phase, twist, seen=seen, polar=polar, slips=slips)
        self._command(twist, period_s)
        self.pose, contact = self._floor.slip(
            self.pose, self.rolled, slip=self._task.slip, period_s=period_s, rng=self._rng
        )
        robot, outside = self._setting.robot, self._setting.outside
        speed, turn_rate = self.reckoned
        rates = robot.wheel_rates(speed_m_per_s=speed, turn_rate_rad_per_s=turn_rate)
        way_m, turn_rad = period_s * robot.twist(rates)
        self.odometry = move(
            self.odometry,
            distance_m=way_m,
            turn_rad=turn_rad,
            method=self._setting.odometry,
        )
        self.time_s += period_s
        self.contacts += contact
        if outside is not None and bool(outside(self.pose[None, :2])[0]):
            raise LeftTheRoom
        return contact

    def _command(self, twist: FloatArray, period_s: float) -> None:
        """Find how the wheels roll (`rolled`), and how they are seen to (`reckoned`)."""
        self.rolled = self.reckoned = twist
        if self._plain:
            return
        robot, wheels = self.robot, self._wheels
        rates = robot.saturate(
            robot.wheel_rates(speed_m_per_s=twist[0], turn_rate_rad_per_s=twist[1])
        )
        turned = wheels.turn(rates, period_s=period_s)
        # Of rates: rotations in a second.
        self.rolled = robot.twist(wheels.roll(turned, period_s=1.0))
        if self._setting.rolling.tick_rad > 0.0:
            rates = wheels.count(period_s * turned) / period_s
        self.reckoned = robot.twist(rates)

    def feel(self) -> bool:
        """Return whether the station makes contact here; the robot turns about on the spot for it.

        So near to the dock its camera sees no landmark. A car stays as it stands.
        """
        if self.docked or self.robot.least_radius_m > 0.0:
            return self.docked
        period_s = self._task.fine.period_s
        rate = min(_TURN_RATE_RAD_PER_S, self._task.tolerance_rad / period_s)
        for _ in range(int(np.ceil(2.0 * np.pi / rate / period_s))):
            if self.docked:
                return True
            self.step("search", np.array([0.0, rate]), period_s=period_s)
        return self.docked

    def straight(self, distance_m: float, phase: Phase) -> None:
        """Drive straight, backwards where negative, until something is touched.

        Parameters
        ----------
        distance_m : How far [m].
        phase : What the robot is doing.
        """
        speed = float(np.copysign(MANOEUVRE_SPEED_M_PER_S, distance_m))
        twist = np.array([speed, 0.0])
        for _ in range(int(np.ceil(distance_m / speed / _MANOEUVRE_PERIOD_S))):
            if self.step(phase, twist, period_s=_MANOEUVRE_PERIOD_S):
                return

    def result(self, outcome: DockingOutcome, reason: str, *, tries: int) -> DockingResult:
        """Return the record of the run, with one more row: where the robot stands now.

        Parameters
        ----------
        outcome, reason : How it ended; the same in a sentence.
        tries : Tries begun.
        """
        if self.worn_out:
            outcome, reason = "collision", f"{reason}; it touched things {self.contacts} times"
        self._row("dock", np.zeros(2), seen=False, polar=None, slips=None)
        rows = np.array(self._rows)
        return DockingResult(
            task=self._task,
            outcome=outcome,
            reason=reason,
            tries=tries,
            contacts=self.contacts,
            time_s=np.array(self._times_s),
            poses=rows[:, :3],
            phases=tuple(self._phases),
            twist=rows[:, 3:5],
            polar=rows[:, 5:8],
            slips=rows[:, 8:10],
            seen=np.array(self._seen),
            staged_m=self.staged_m,
            odometry=np.array(self._reckoned),
            rss_w=np.array(self._rss_w),
        )

    def _row(
        self,
        phase: Phase,
        twist: FloatArray,
        *,
        seen: bool,
        polar: FloatArray | None,
        slips: FloatArray | None,
    ) -> None:
        nothing = np.full(3, np.nan)
        self._times_s.append(self.time_s)
        self._phases.append(phase)
        self._seen.append(seen)
        estimated = nothing if polar is None else polar
        slipping = nothing[:2] if slips is None else slips
        self._rows.append(np.concatenate([self.pose, twist, estimated, slipping]))
        self._reckoned.append(self.odometry)
        self._rss_w.append(self._silence if self.heard_w is None else self.heard_w)
        self.heard_w = None


class CoarseDrive:
    """The coarse stage of one run; it remembers what it learned of the tag's place.

    Parameters
    ----------
    task : Tag and manner.
    reader : The bearing-sensitive reader.
    drive : The robot.
    rng : Source of the reader's noise and of the detours.
    """

    def __init__(
        self, task: DockingTask, reader: RssSensor, drive: DockingDrive, rng: np.random.Generator
    ) -> None:
        self._task, self._reader, self._drive, self._rng = task, reader, drive, rng
        self._place = task.coarse.place_filter.start()
        self._driven = AT_REST
        self._heard = False

    def approach(self, attempt: int) -> Failure | None:
        """Return why the robot did not get to the tag, or None once it is there, or in the dock.

        It stands until it hears the tag; then it first turns about, in case that it is in the dock.

        Parameters
        ----------
        attempt : Number of the try, from 1; later ones aim beside the tag, to see more.
        """
        coarse = self._task.coarse
        offset = np.zeros(2)
        if attempt > 1:  # the last place showed no landmark: look from beside it
            side = self._rng.uniform(-np.pi, np.pi)
            offset = _OFFSET_M * np.array([np.cos(side), np.sin(side)])
        self._driven = AT_REST
        give_up_s = self._drive.time_s + coarse.max_time_s
        silent = 0
        while self._drive.time_s < give_up_s:
            bearing = self._bearing()
            silent = silent + 1 if np.isnan(bearing) else 0
            if silent == 0 and not self._heard:
                self._heard = True
                if self._drive.feel():
                    return None
                continue
            if silent > _SILENT_READINGS:
                return "tag not found", f"the reader received nothing in {silent} readings in a row"
            self._place = coarse.place_filter.observe(
                self._place, self._drive.odometry, bearing_rad=bearing
            )
            place, spread = self._place.place()
            ahead = place + offset - self._drive.odometry[:2]
            trusted = spread <= coarse.arrival_spread_m
            if np.hypot(*ahead) <= coarse.arrival_radius_m and trusted:
                return None
            twist = self._twist_towards(ahead) if self._heard else _STILL
            contact = self._drive.step("approach", twist, period_s=coarse.period_s)
            self._driven = AT_REST if contact else self._motion()
            if contact and not self._evade():
                return "collision", "the robot is stuck between obstacles on its way to the tag"
        return "tag not found", (
            f"the tag's place was not found within {coarse.max_time_s:g} s: its spread is still "
            f"{self._place.place()[1]:.1f} m"
        )

    def _bearing(self) -> float:
        rss_w = self._reader.read(
            self._drive.pose, self._task.tag_id, self._rng, motion=self._driven
        )
        self._drive.heard_w = rss_w
        return float(turn_towards(vector_sum_bearing(rss_w, self._reader.azimuths_rad)))

    def _motion(self) -> Motion:
        """Return how the robot really drove: a slow reader reads on that way."""
        slip, (speed, turn_rate) = self._task.slip, self._drive.rolled
        return Motion(
            speed_m_per_s=float(speed) + slip.linear_m_per_s,
            turn_rate_rad_per_s=float(turn_rate) + slip.angular_rad_per_s,
        )

    def _twist_towards(self, ahead: FloatArray) -> FloatArray:
        """Return the command towards a point given from the robot's place, in odometry's axes."""
        coarse = self._task.coarse
        distance = float(np.hypot(*ahead))
        if distance <= coarse.arrival_radius_m:
            # There, but not sure of it: drive across, bearings from new places decide.
            return np.array([coarse.speed_m_per_s, 0.3])
        error = float(wrap_angle(np.arctan2(ahead[1], ahead[0]) - self._drive.odometry[2]))
        robot, most = self._drive.robot, self._drive.turn_rate_rad_per_s
        rate = np.clip(error / coarse.period_s, -most, most)
        behind = robot.encircles(distance * np.cos(error), distance * np.sin(error))
        if abs(error) > _TURN_ON_SPOT_RAD or behind:
            return np.array(robot.turning(rate, reverse=behind))
        return np.array([min(coarse.speed_m_per_s, distance / coarse.period_s), 0.7 * rate])

    def _evade(self) -> bool:
        """Return whether the robot got away from what it touches, back and to one side."""
        if self._drive.worn_out:
            return False
        self._drive.straight(-_EVADE_BACK_M, "back off")
        turn = float(self._rng.choice([-1.0, 1.0]) * self._rng.uniform(np.pi / 3, 2 * np.pi / 3))
        rate = self._drive.turn_rate_rad_per_s
        twist = np.array(self._drive.robot.turning(np.copysign(rate, turn)))
        lasts_s = abs(turn) / rate
        # On the spot nothing can be touched; an arc is driven in steps.
        parts = 1 if twist[0] == 0.0 else int(np.ceil(lasts_s / _MANOEUVRE_PERIOD_S))
        for _ in range(parts):
            if self._drive.step("back off", twist, period_s=lasts_s / parts):
                break
        self._drive.straight(_EVADE_ALONG_M, "approach")
        return not self._drive.worn_out


class FineDrive:
    """The fine stage of one run.

    Parameters
    ----------
    task : Landmark, law, filter and manner.
    camera : The landmark's detector.
    drive : The robot.
    rng : Source of the camera's errors.
    """

    def __init__(
        self,
        task: DockingTask,
        camera: LandmarkSensor,
        drive: DockingDrive,
        rng: np.random.Generator,
    ) -> None:
        self._task, self._camera, self._drive, self._rng = task, camera, drive, rng
        self._error = task.fine.start_error

    def search(self) -> LandmarkTrack | None:
        """Return a first belief of the landmark on which detections agree; None without one."""
        fine = self._task.fine
        if self._error is not None:
            truth = self._task.landmark.in_body(self._drive.pose)
            return fine.filter.start(truth + np.array(self._error))
        rate = min(fine.search_rate_rad_per_s, self._drive.turn_rate_rad_per_s)
        twist = np.array(self._drive.robot.turning(rate))
        for _ in range(int(np.ceil(_FULL_TURN_RAD / twist[1] / fine.period_s))):
            detection = self._look()
            if np.isfinite(detection[0]):
                track = self._confirm(detection)
                if track is not None:
                    return track
            self._drive.step("search", twist, period_s=fine.period_s)
        return None

    def _confirm(self, detection: FloatArray) -> LandmarkTrack | None:
        fine = self._task.fine
        track = fine.filter.start(detection, covariance=fine.filter.noise.measurement)
        agreed = 0
        for _ in range(2 * fine.confirmations):
            self._drive.step("search", _STILL, period_s=fine.period_s, seen=True)
            seen = self._look()
            track = fine.filter.correct(track, seen)
            agreed += bool(np.isfinite(seen[0]) and track.rejected == 0)
            if agreed >= fine.confirmations:
                return track
        return None

    def _refine(self, track: LandmarkTrack) -> LandmarkTrack:
        """Turn the camera to the landmark, then stand and look."""
        fine, yaw = self._task.fine, self._camera.yaw_rad
        for _ in range(int(np.ceil(np.pi / fine.search_rate_rad_per_s / fine.period_s))):
            off_axis = float(wrap_angle(np.arctan2(*track.place_m[::-1]) - yaw))
            limit = min(fine.search_rate_rad_per_s, self._drive.turn_rate_rad_per_s)
            if abs(off_axis) < 0.5 * limit * fine.period_s:
                break
            turn = float(np.clip(off_axis / fine.period_s, -limit, limit))
            # A car turns by driving away from the landmark.
            turning = self._drive.robot.turning(turn, reverse=not self._task.in_reverse)
            track = self._step(track, np.array(turning), "refine")[0]
        return self._stand(track)

    def _stand(self, track: LandmarkTrack) -> LandmarkTrack:
        """Stand and look."""
        fine = self._task.fine
        for _ in range(int(np.ceil(fine.look_s / fine.period_s))):
            track = self._step(track, _STILL, "refine")[0]
        return track

    def _step(
        self,
        track: LandmarkTrack,
        twist: FloatArray,
        phase: Phase,
        polar: FloatArray | None = None,
    ) -> tuple[LandmarkTrack, bool]:
        fine = self._task.fine
        contact = self._drive.step(
            phase,
            twist,
            period_s=fine.period_s,
            seen=bool(np.isfinite(track.nis)),
            polar=polar,
            slips=track.slips,
        )
        track = fine.filter.predict(track, self._drive.reckoned, period_s=fine.period_s)
        return fine.filter.correct(track, self._look()), contact

    def dock(self, track: LandmarkTrack) -> Failure | None:
        """Return why the robot is not in the dock, or None once it is.

        Parameters
        ----------
        track : Belief from `search`.
        """
        fine = self._task.fine
        sure, self._error = self._error is None, None
        if sure:
            track = self._refine(track)
        give_up_s = self._drive.time_s + fine.max_time_s
        nearest, since_s = np.inf, self._drive.time_s
        polar, looked = None, False
        while self._drive.time_s < give_up_s:
            polar = polar_state(self._pose_in_goal_frame(track), previous=polar)
            if latched(polar, radius_m=fine.latch_radius_m, approach=fine.law.approach):
                return self._contact_of_the_station()
            if polar[0] < nearest - _PROGRESS_M:
                nearest, since_s = polar[0], self._drive.time_s
            if self._drive.time_s - since_s > fine.stall_s:
                return "stalled", f"the robot stalled {polar[0]:.3f} m before the dock"
            if polar[0] < fine.last_look_m and not looked:
                looked = True
                track = self._stand(track)
                since_s = self._drive.time_s
                continue
            if not sure and _spread_m(track) <= _UNSURE_SD_M:
                sure, polar = True, None  # the estimate has jumped: so do the angles
                nearest = np.inf
                continue
            if sure and _spread_m(track) > _UNSURE_SD_M:
                track = self._refine(track)
                if _spread_m(track) > _UNSURE_SD_M:
                    return "missed", "the landmark was lost from view while docking"
                polar, since_s = None, self._drive.time_s
                continue
            steered = faded(polar, radius_m=fine.fade_radius_m, approach=fine.law.approach)
            twist = fine.limits.apply(fine.law.twist(steered))
            if fine.compensate_slips:
                twist = slip_compensated(twist, track.slips)
            track, contact = self._step(track, twist, "dock", polar)
            if contact:
                return "collision", "the robot touched an obstacle while docking"
        return "missed", f"the robot did not arrive within {fine.max_time_s:g} s of docking"

    def _look(self) -> FloatArray:
        seen = self._camera.detect(self._drive.pose[None], self._task.landmark, self._rng)
        return np.asarray(seen[0])

    def _pose_in_goal_frame(self, track: LandmarkTrack) -> FloatArray:
        """Return the robot's estimated pose in the goal frame."""
        psi = float(track.attitude_rad)
        stand_off = self._task.stand_off_m * np.array([np.cos(psi), np.sin(psi)])
        heading = psi + np.pi * self._task.in_reverse
        goal_in_body = np.array([*(track.place_m - stand_off), heading])
        return pose_in_goal_frame(np.zeros(3), goal_in_body)

    def _contact_of_the_station(self) -> Failure | None:
        if self._drive.docked:
            return None
        away_m, turned_rad = self._drive.off_dock
        return "missed", (
            f"the robot stopped {away_m:.3f} m and {np.degrees(turned_rad):.1f} degrees off, but "
            f"the station makes contact within {self._task.tolerance_m:g} m and "
            f"{np.degrees(self._task.tolerance_rad):.3g} degrees"
        )


def _spread_m(track: LandmarkTrack) -> float:
    """Return the standard deviation of the landmark's estimated place [m]."""
    return float(np.sqrt(np.trace(track.belief.covariance[PLACE, PLACE])))
