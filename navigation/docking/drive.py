"""The robot of one docking mission: it moves, reckons its pose, and keeps the record."""

import numpy as np
import numpy.typing as npt

from octant.navigation.docking.setting import DockingSetting
from octant.navigation.docking.task import DockingResult, DockingTask, Outcome, Phase
from octant.navigation.robot.docking_world import SlippingRobot

FloatArray = npt.NDArray[np.float64]

MANOEUVRE_SPEED_M_PER_S = 0.15
"""Speed of short straight manoeuvres [m/s]."""

_MANOEUVRE_PERIOD_S = 0.4


class DockingDrive:
    """The robot of one run, with its odometry and its record.

    Parameters
    ----------
    task : DockingTask
        What is driven.
    setting : DockingSetting
        Robot and obstacles.
    pose : (3,) float64
        True x [m], y [m], heading [rad] at the start.
    rng : numpy.random.Generator
        Source of the random part of the motion.
    """

    def __init__(
        self,
        task: DockingTask,
        setting: DockingSetting,
        *,
        pose: FloatArray,
        rng: np.random.Generator,
    ) -> None:
        self._task, self._robot = task, setting.robot
        self._body = SlippingRobot(
            robot=setting.robot, slip=task.slip, pose=pose, rng=rng, blocked=setting.blocked
        )
        self._times_s: list[float] = []
        self._phases: list[str] = []
        self._rows: list[FloatArray] = []
        self._seen: list[bool] = []
        self.odometry = np.zeros(3)
        self.time_s = 0.0
        self.contacts = 0
        self.staged_m = np.nan

    @property
    def pose(self) -> FloatArray:
        """Return the (3,) true x [m], y [m], heading [rad]: for sensors and for the record."""
        return self._body.pose

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
        """Return whether the robot touches something; log, move and reckon one period.

        Parameters
        ----------
        phase : Phase
            What the robot is doing.
        twist : (2,) float64
            Command v [m/s], ω [rad/s].
        period_s : float
            Length of the period [s].
        seen : bool
            Whether the camera reported a landmark just now.
        polar : (3,) float64 or None
            Estimated e [m], α [rad], φ [rad], for the record.
        slips : (2,) float64 or None
            Estimated b [m/s], s [rad/s], for the record.

        Returns
        -------
        bool
            True on contact.
        """
        self._row(phase, twist, seen=seen, polar=polar, slips=slips)
        contact = self._body.move(twist, period_s=period_s)
        rates = self._robot.wheel_rates(speed_m_per_s=twist[0], turn_rate_rad_per_s=twist[1])
        self.odometry = self._robot.step_arc(self.odometry, rates, period_s=period_s)
        self.time_s += period_s
        self.contacts += contact
        return contact

    def straight(self, distance_m: float, phase: Phase) -> None:
        """Drive straight, backwards where negative, until something is touched.

        Parameters
        ----------
        distance_m : float
            How far [m].
        phase : Phase
            What the robot is doing.
        """
        speed = float(np.copysign(MANOEUVRE_SPEED_M_PER_S, distance_m))
        twist = np.array([speed, 0.0])
        for _ in range(int(np.ceil(distance_m / speed / _MANOEUVRE_PERIOD_S))):
            if self.step(phase, twist, period_s=_MANOEUVRE_PERIOD_S):
                return

    def result(self, outcome: Outcome, reason: str, *, tries: int) -> DockingResult:
        """Return the record of the run.

        Parameters
        ----------
        outcome : Outcome
            How it ended.
        reason : str
            The same in a sentence.
        tries : int
            Tries begun.

        Returns
        -------
        DockingResult
            With one more row: where the robot stands now.
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
