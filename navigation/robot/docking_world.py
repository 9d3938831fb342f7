"""The simulated floor: a robot that slips, and stops where it touches something."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.robot.drive import DifferentialDrive

FloatArray = npt.NDArray[np.float64]

_CONTACT_SPACING_M = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelSlip:
    """Return how a robot's motion differs from its command, while it moves.

    Parameters
    ----------
    linear_m_per_s : float
        Constant part b of the speed [m/s].
    angular_rad_per_s : float
        Constant part s of the turn rate [rad/s].
    position_m2_per_s : float
        Growth of the place's variance [m²/s].
    heading_rad2_per_s : float
        Growth of the heading's variance [rad²/s].

    Raises
    ------
    NavigationError
        When a value is not finite or a variance is negative.
    """

    linear_m_per_s: float = -0.01
    angular_rad_per_s: float = 0.008
    position_m2_per_s: float = 4.1e-6
    heading_rad2_per_s: float = 2e-5

    def __post_init__(self) -> None:
        if not (np.isfinite(self.linear_m_per_s) and np.isfinite(self.angular_rad_per_s)):
            msg = (
                f"the slips are {self.linear_m_per_s} m/s and {self.angular_rad_per_s} rad/s, but "
                "both must be finite: give numbers."
            )
            raise NavigationError(msg)
        for name, unit in (("position_m2_per_s", "m²/s"), ("heading_rad2_per_s", "rad²/s")):
            check_positive(getattr(self, name), name=name, unit=unit, allow_zero=True)


class SlippingRobot:
    """A robot on the simulated floor; its true pose is for the world only.

    Parameters
    ----------
    robot : DifferentialDrive
        Wheels and their limits.
    slip : WheelSlip
        How it slips.
    pose : (3,) array_like
        True x [m], y [m], heading [rad] at the start.
    rng : numpy.random.Generator
        Source of the random part of its motion.
    blocked : callable or None
        (m, 2) points [m] -> (m,) bool: where it touches something.
    """

    def __init__(
        self,
        *,
        robot: DifferentialDrive,
        slip: WheelSlip,
        pose: npt.ArrayLike,
        rng: np.random.Generator,
        blocked: Callable[[FloatArray], npt.NDArray[np.bool_]] | None,
    ) -> None:
        self._robot, self._slip, self._rng, self._blocked = robot, slip, rng, blocked
        self.pose = np.array(pose, dtype=np.float64)

    def move(self, twist: npt.ArrayLike, *, period_s: float) -> bool:
        """Return whether the robot touches something; move it for one period.

        Parameters
        ----------
        twist : (2,) array_like
            Commanded v [m/s], ω [rad/s].
        period_s : float
            Length of the period [s].

        Returns
        -------
        bool
            True on contact: it then stands at the last free place of its way.
        """
        speed, turn_rate = (float(c) for c in np.asarray(twist))
        noise = self._rng.standard_normal(3)
        if speed == 0.0 and turn_rate == 0.0:
            return False
        robot, slip = self._robot, self._slip
        rates = robot.saturate(
            robot.wheel_rates(
                speed_m_per_s=speed + slip.linear_m_per_s,
                turn_rate_rad_per_s=turn_rate + slip.angular_rad_per_s,
            )
        )
        reached = robot.step_arc(self.pose, rates, period_s=period_s)
        reached[:2] += np.sqrt(slip.position_m2_per_s * period_s) * noise[:2]
        reached[2] = wrap_angle(reached[2] + np.sqrt(slip.heading_rad2_per_s * period_s) * noise[2])
        free, contact = self._last_free(reached)
        self.pose = free
        return contact

    def _last_free(self, reached: FloatArray) -> tuple[FloatArray, bool]:
        if self._blocked is None:
            return reached, False
        move = reached - self.pose
        move[2] = wrap_angle(move[2])
        parts = max(1, int(np.ceil(np.hypot(move[0], move[1]) / _CONTACT_SPACING_M)))
        shares = np.arange(1, parts + 1) / parts
        hits = np.flatnonzero(self._blocked(self.pose[:2] + shares[:, None] * move[:2]))
        if not hits.size:
            return reached, False
        stopped = self.pose + (hits[0] / parts) * move
        stopped[2] = reached[2]
        return stopped, True
