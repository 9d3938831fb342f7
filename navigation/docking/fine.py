"""The fine stage of docking: find the landmark, look closely, follow the law on the estimate."""

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.control.docking_law import faded, latched, slip_compensated
from octant.navigation.control.polar import polar_state, pose_in_goal_frame
from octant.navigation.docking.drive import DockingDrive
from octant.navigation.docking.task import DockingTask, Failure, Phase
from octant.navigation.estimators.landmark_filters import PLACE, LandmarkTrack
from octant.navigation.sensing.landmark_sensor import LandmarkSensor

FloatArray = npt.NDArray[np.float64]

_STILL = np.zeros(2)
_UNSURE_SD_M = 0.12
_PROGRESS_M = 0.005
_FULL_TURN_RAD = 2.3 * np.pi


class FineDrive:
    """The fine stage of one run.

    Parameters
    ----------
    task : DockingTask
        Landmark, law, filter and manner.
    camera : LandmarkSensor
        The landmark's detector.
    drive : DockingDrive
        The robot.
    rng : numpy.random.Generator
        Source of the camera's errors.
    """

    def __init__(
        self,
        task: DockingTask,
        camera: LandmarkSensor,
        drive: DockingDrive,
        rng: np.random.Generator,
    ) -> None:
        self._task, self._camera, self._drive, self._rng = task, camera, drive, rng

    def search(self) -> LandmarkTrack | None:
        """Return the landmark on which detections agree, turning on the spot; None without.

        Returns
        -------
        LandmarkTrack or None
            First belief.
        """
        fine = self._task.fine
        twist = np.array([0.0, fine.search_rate_rad_per_s])
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
            limit = fine.search_rate_rad_per_s
            if abs(off_axis) < 0.5 * limit * fine.period_s:
                break
            turn = float(np.clip(off_axis / fine.period_s, -limit, limit))
            track = self._step(track, np.array([0.0, turn]), "refine")[0]
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
        track = fine.filter.predict(track, twist, period_s=fine.period_s)
        return fine.filter.correct(track, self._look()), contact

    def dock(self, track: LandmarkTrack) -> Failure | None:
        """Return why the robot is not in the dock, or None once it is.

        Parameters
        ----------
        track : LandmarkTrack
            Belief from `search`.

        Returns
        -------
        (str, str) or None
            Outcome and reason.
        """
        track = self._refine(track)
        fine = self._task.fine
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
            if _spread_m(track) > _UNSURE_SD_M:
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
        goal_in_body = np.array([*(track.place_m - stand_off), psi])
        return pose_in_goal_frame(np.zeros(3), goal_in_body)

    def _contact_of_the_station(self) -> Failure | None:
        x, y, heading = pose_in_goal_frame(self._drive.pose, self._task.goal)
        away = float(np.hypot(x, y))
        if away <= self._task.tolerance_m and abs(heading) <= self._task.tolerance_rad:
            return None
        return "missed", (
            f"the robot stopped {away:.2f} m and {np.degrees(abs(heading)):.0f} degrees off, where "
            "the station makes no contact"
        )


def _spread_m(track: LandmarkTrack) -> float:
    """Return the standard deviation of the landmark's estimated place [m]."""
    return float(np.sqrt(np.trace(track.belief.covariance[PLACE, PLACE])))
