"""The coarse stage of docking: by bearings and odometry to the place under the station's tag."""

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.docking.drive import DockingDrive
from octant.navigation.docking.task import DockingTask, Failure
from octant.navigation.robot.motion import AT_REST, Motion
from octant.navigation.sensing.bearing import turn_towards, vector_sum_bearing
from octant.navigation.sensing.sensor import Sensor

FloatArray = npt.NDArray[np.float64]

_TURN_ON_SPOT_RAD = 0.6
_TURN_RATE_RAD_PER_S = 1.0
_SILENT_READINGS = 20
_OFFSET_M = 0.8
_EVADE_BACK_M = 0.3
_EVADE_ALONG_M = 0.6


class CoarseDrive:
    """The coarse stage of one run; it remembers what it learned of the tag's place.

    Parameters
    ----------
    task : DockingTask
        Tag and manner.
    reader : Sensor
        The bearing-sensitive reader.
    drive : DockingDrive
        The robot.
    rng : numpy.random.Generator
        Source of the reader's noise and of the ways around obstacles.
    """

    def __init__(
        self, task: DockingTask, reader: Sensor, drive: DockingDrive, rng: np.random.Generator
    ) -> None:
        self._task, self._reader, self._drive, self._rng = task, reader, drive, rng
        self._place = task.coarse.place_filter.start()
        self._driven = AT_REST

    def approach(self, attempt: int) -> Failure | None:
        """Return why the robot did not get to the tag, or None once it is there.

        Parameters
        ----------
        attempt : int
            Number of the try, from 1; later ones aim beside the tag, where there may be more to
            see.

        Returns
        -------
        (str, str) or None
            Outcome and reason.
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
            if silent > _SILENT_READINGS:
                return "tag not found", f"the reader heard nothing in {silent} readings in a row"
            self._place = coarse.place_filter.observe(
                self._place, self._drive.odometry, bearing_rad=bearing
            )
            place, spread = self._place.place()
            ahead = place + offset - self._drive.odometry[:2]
            trusted = spread <= coarse.arrival_spread_m
            if np.hypot(*ahead) <= coarse.arrival_radius_m and trusted:
                return None
            twist = self._twist_towards(ahead)
            contact = self._drive.step("approach", twist, period_s=coarse.period_s)
            self._driven = AT_REST if contact else self._motion(twist)
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
        return float(turn_towards(vector_sum_bearing(rss_w, self._reader.azimuths_rad)))

    def _motion(self, twist: FloatArray) -> Motion:
        """Return how the robot really drove on a command: a slow reader reads on that way."""
        slip = self._task.slip
        return Motion(
            speed_m_per_s=float(twist[0]) + slip.linear_m_per_s,
            turn_rate_rad_per_s=float(twist[1]) + slip.angular_rad_per_s,
        )

    def _twist_towards(self, ahead: FloatArray) -> FloatArray:
        """Return the command towards a point given from the robot's place, in odometry's axes."""
        coarse = self._task.coarse
        distance = float(np.hypot(*ahead))
        if distance <= coarse.arrival_radius_m:
            # There, but not sure of it: drive across, bearings from new places decide.
            return np.array([coarse.speed_m_per_s, 0.3])
        error = float(wrap_angle(np.arctan2(ahead[1], ahead[0]) - self._drive.odometry[2]))
        rate = np.clip(error / coarse.period_s, -_TURN_RATE_RAD_PER_S, _TURN_RATE_RAD_PER_S)
        if abs(error) > _TURN_ON_SPOT_RAD:
            return np.array([0.0, rate])
        return np.array([min(coarse.speed_m_per_s, distance / coarse.period_s), 0.7 * rate])

    def _evade(self) -> bool:
        """Return whether the robot got away from what it touches, back and to one side."""
        if self._drive.worn_out:
            return False
        self._drive.straight(-_EVADE_BACK_M, "back off")
        turn = float(self._rng.choice([-1.0, 1.0]) * self._rng.uniform(np.pi / 3, 2 * np.pi / 3))
        self._drive.step(
            "back off",
            np.array([0.0, np.copysign(_TURN_RATE_RAD_PER_S, turn)]),
            period_s=abs(turn) / _TURN_RATE_RAD_PER_S,
        )
        self._drive.straight(_EVADE_ALONG_M, "approach")
        return not self._drive.worn_out
