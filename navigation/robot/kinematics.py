"""Robots with other wheels: a car with steered front wheels, and a synchro drive.

Their wheel rates, right and left, are those of the car's rear wheels, and for the synchro drive
those of two wheels beside its centre that would move it alike. So what commands wheels commands
them too, and `saturate` says what they make of it.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.robot.drive import DifferentialDrive, ramp, without_dead_band

FloatArray = npt.NDArray[np.float64]

_STEEPEST_RAD = 0.5 * np.pi


@dataclass(frozen=True, slots=True, kw_only=True)
class CarDrive(DifferentialDrive):
    """A car: two driven rear wheels behind a differential gear, and steered front wheels.

    The bicycle model about the middle of the rear axle: v forward, ω = v tan(δ) / L. The steering
    limit means a least radius L / tan(δ_max), and no turn on the spot. The steering acts at once.
    The pose is that of the rear axle's middle, where the round body and the reader have theirs.

    Parameters
    ----------
    wheelbase_m : Distance L from the rear axle to the front one [m].
    steering_limit_rad : Greatest steering angle δ_max of the bicycle's front wheel [rad].
    """

    wheelbase_m: float
    steering_limit_rad: float

    def __post_init__(self) -> None:
        DifferentialDrive.__post_init__(self)
        check_positive(self.wheelbase_m, name="wheelbase_m", unit="m")
        if not 0.0 < self.steering_limit_rad < _STEEPEST_RAD:
            msg = (
                f"steering_limit_rad is {self.steering_limit_rad} rad, but wheels steer by more "
                "than 0 and less than a right angle: give the real limit."
            )
            raise NavigationError(msg)

    @property
    def least_radius_m(self) -> float:
        """Return the radius of the tightest circle that the robot's centre can drive [m]."""
        return self.wheelbase_m / float(np.tan(self.steering_limit_rad))

    @property
    def max_turn_rate_rad_per_s(self) -> float:
        """Return the fastest turn, on the tightest circle with the outer wheel at u_max [rad/s]."""
        return self.max_wheel_speed_m_per_s / (self.least_radius_m + 0.5 * self.axle_length_m)

    def turning(self, turn_rate_rad_per_s: float, *, reverse: bool = False) -> tuple[float, float]:
        """Return speed [m/s] and turn rate [rad/s] on the tightest circle."""
        speed = abs(turn_rate_rad_per_s) * self.least_radius_m
        return -speed if reverse else speed, turn_rate_rad_per_s

    def turning_limit_rad_per_s(self, speed_m_per_s: float) -> float:
        """Return how fast a `turning` may be: within the wheels' limits and a speed [rad/s]."""
        return min(self.max_turn_rate_rad_per_s, speed_m_per_s / self.least_radius_m)

    def saturate(self, wheel_rates_rad_per_s: npt.ArrayLike) -> FloatArray:
        """Return rates of a steering within its limit, both scaled to u_max if need be [rad/s]."""
        rates = np.asarray(wheel_rates_rad_per_s, dtype=np.float64)
        mean, half = rates.mean(axis=-1), 0.5 * (rates[..., 0] - rates[..., 1])
        # ω r l/2 = half and v r = mean: |half| <= |mean| l / (2 R) is |ω| <= |v| / R.
        most = np.abs(mean) * 0.5 * self.axle_length_m / self.least_radius_m
        half = np.clip(half, -most, most)
        kept = np.stack([mean + half, mean - half], axis=-1)
        over = np.abs(kept).max(axis=-1, keepdims=True) / self.max_wheel_rate_rad_per_s
        return np.asarray(kept / np.maximum(over, 1.0))

    def follow(
        self,
        before_rad_per_s: npt.ArrayLike,
        wanted_rad_per_s: npt.ArrayLike,
        *,
        period_s: float,
        acceleration_rad_per_s2: float | None = None,
        dead_band_rad_per_s: float = 0.0,
    ) -> tuple[FloatArray, FloatArray]:
        """Return mean and last rates of a period: one motor before the differential gear [rad/s].

        It ramps, and has the dead band; the steering keeps the commanded curvature.
        """
        before, wanted = np.asarray(before_rad_per_s), np.asarray(wanted_rad_per_s)
        start, goal = before.mean(axis=-1), wanted.mean(axis=-1)
        # A command to stop says nothing of the steering: it stays.
        steered = np.where((goal == 0.0)[..., None], before, wanted)
        middle = steered.mean(axis=-1)
        lean = 0.5 * (steered[..., 0] - steered[..., 1]) / np.where(middle == 0.0, 1.0, middle)
        goal = without_dead_band(goal, dead_band_rad_per_s)
        rolled = ramp(start, goal, period_s=period_s, acceleration=acceleration_rad_per_s2)
        mean, end = (
            np.stack([rate * (1.0 + lean), rate * (1.0 - lean)], axis=-1) for rate in rolled
        )
        return mean, end


@dataclass(frozen=True, slots=True, kw_only=True)
class SynchroDrive(DifferentialDrive):
    """A synchro drive: all wheels roll together and steer together, by a motor each.

    Heading and speed are independent: the inputs are v and ω of the unicycle themselves, each with
    its own limit. The body does not turn with the wheels. The reader stands on the turret that such
    robots have for directional sensors, coupled to the steering: its front is where the wheels
    roll, so the heading is the wheels', and the round body collides alike at any heading.

    Parameters
    ----------
    turn_rate_limit_rad_per_s : Fastest turn of the steering [rad/s].
    turn_acceleration_rad_per_s2 : Its greatest acceleration [rad/s²]; None: at once.

    Notes
    -----
    The distance of the equivalent wheels, `axle_length_m`, is 2 v_max / ω_max, whatever is given:
    what two such wheels can do within (3.8) is then within both limits, so that a controller that
    plans with wheel rates plans what the robot can do.
    """

    turn_rate_limit_rad_per_s: float
    turn_acceleration_rad_per_s2: float | None = None

    def __post_init__(self) -> None:
        check_positive(
            self.turn_rate_limit_rad_per_s, name="turn_rate_limit_rad_per_s", unit="rad/s"
        )
        if self.turn_acceleration_rad_per_s2 is not None:
            check_positive(
                self.turn_acceleration_rad_per_s2,
                name="turn_acceleration_rad_per_s2",
                unit="rad/s²",
            )
        axle_m = 2.0 * self.max_wheel_speed_m_per_s / self.turn_rate_limit_rad_per_s
        object.__setattr__(self, "axle_length_m", axle_m)
        DifferentialDrive.__post_init__(self)

    def saturate(self, wheel_rates_rad_per_s: npt.ArrayLike) -> FloatArray:
        """Return rates whose speed and turn rate are each cut by itself to its limit [rad/s]."""
        limits = np.array([self.max_wheel_rate_rad_per_s, self.turn_rate_limit_rad_per_s])
        return self.of_shafts(np.clip(self.shafts(wheel_rates_rad_per_s), -limits, limits))

    def shafts(self, wheel_rates_rad_per_s: npt.ArrayLike) -> FloatArray:
        """Return the rates of the rolling and of the steering, v/r and ω [rad/s]."""
        twist = self.twist(wheel_rates_rad_per_s)
        return np.stack([twist[..., 0] / self.wheel_radius_m, twist[..., 1]], axis=-1)

    def of_shafts(self, shafts: npt.ArrayLike) -> FloatArray:
        """Return the equivalent wheel rates of rolling and steering [rad/s]."""
        given = np.asarray(shafts, dtype=np.float64)
        return self.wheel_rates(
            speed_m_per_s=self.wheel_radius_m * given[..., 0], turn_rate_rad_per_s=given[..., 1]
        )

    def follow(
        self,
        before_rad_per_s: npt.ArrayLike,
        wanted_rad_per_s: npt.ArrayLike,
        *,
        period_s: float,
        acceleration_rad_per_s2: float | None = None,
        dead_band_rad_per_s: float = 0.0,
    ) -> tuple[FloatArray, FloatArray]:
        """Return mean and last rates of a period: rolling and steering ramp apart [rad/s].

        The dead band is that of the rolling.
        """
        before, wanted = self.shafts(before_rad_per_s), self.shafts(wanted_rad_per_s)
        rolling = ramp(
            before[..., 0],
            without_dead_band(wanted[..., 0], dead_band_rad_per_s),
            period_s=period_s,
            acceleration=acceleration_rad_per_s2,
        )
        steering = ramp(
            before[..., 1],
            wanted[..., 1],
            period_s=period_s,
            acceleration=self.turn_acceleration_rad_per_s2,
        )
        mean, end = (
            self.of_shafts(np.stack(pair, axis=-1)) for pair in zip(rolling, steering, strict=True)
        )
        return mean, end
