"""The differential-drive robot: kinematics, one sample period, and the wheels' limits."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.robot.motion import pose_on_arc


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferentialDrive:
    """A two-wheeled robot; the defaults are the Scout of thesis 3.3.3.

    Poses are x [m], y [m], heading θ [rad]; wheel rates are angular speeds in the order right,
    left, as in (3.6). The sentence before (3.5) has ν_R and ν_L the other way round than its
    equations, followed here. The maker's list has 7 inch wheels (r = 8.9 cm).

    Parameters
    ----------
    wheel_radius_m, axle_length_m : Radius r of the wheels and distance l between them [m].
    max_wheel_speed_m_per_s : Highest speed of a wheel's rim [m/s].
    """

    wheel_radius_m: float = 0.0825
    axle_length_m: float = 0.30
    max_wheel_speed_m_per_s: float = 0.75

    def __post_init__(self) -> None:
        for name, unit in (
            ("wheel_radius_m", "m"),
            ("axle_length_m", "m"),
            ("max_wheel_speed_m_per_s", "m/s"),
        ):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                msg = (
                    f"{name} is {value} {unit}, but it must be positive and finite: "
                    "give the robot's real value."
                )
                raise NavigationError(msg)

    @property
    def max_wheel_rate_rad_per_s(self) -> float:
        """Return the highest angular speed of a wheel, u_max of (3.8) [rad/s]."""
        return self.max_wheel_speed_m_per_s / self.wheel_radius_m

    @property
    def max_turn_rate_rad_per_s(self) -> float:
        """Return the fastest turn on the spot [rad/s]."""
        return 2.0 * self.max_wheel_speed_m_per_s / self.axle_length_m

    @property
    def least_radius_m(self) -> float:
        """Return the radius of the tightest circle that the robot's centre can drive [m]."""
        return 0.0

    def turning(self, turn_rate_rad_per_s: float, *, reverse: bool = False) -> tuple[float, float]:  # noqa: ARG002
        """Return speed [m/s] and turn rate [rad/s] of a turn with as little way as there can be.

        Parameters
        ----------
        turn_rate_rad_per_s : Wanted, counter-clockwise positive [rad/s].
        reverse : Whether a robot that cannot turn on the spot drives backwards.
        """
        return 0.0, turn_rate_rad_per_s

    def turning_limit_rad_per_s(self, speed_m_per_s: float) -> float:  # noqa: ARG002
        """Return how fast a `turning` may be [rad/s].

        Parameters
        ----------
        speed_m_per_s : Greatest speed on the way of it [m/s], for a robot that needs one.
        """
        return self.max_turn_rate_rad_per_s

    def encircles(self, ahead_m: float, left_m: float) -> bool:
        """Return whether a place lies inside the tightest circle to its side: out of reach ahead.

        Parameters
        ----------
        ahead_m, left_m : The place from the robot's centre [m].
        """
        radius = self.least_radius_m
        return bool(np.hypot(ahead_m, abs(left_m) - radius) < radius)

    def shafts(self, wheel_rates_rad_per_s: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return how fast the shafts turn that motors drive and encoders count: the wheels [rad/s].

        Parameters
        ----------
        wheel_rates_rad_per_s : (..., 2) float64 — Right and left [rad/s], or rotations [rad].
        """
        return np.asarray(wheel_rates_rad_per_s, dtype=np.float64)

    def of_shafts(self, shafts: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the wheel rates [rad/s] of `shafts`, whose inverse this is.

        Parameters
        ----------
        shafts : (..., 2) float64 — Rates of the shafts [rad/s], or rotations [rad].
        """
        return np.asarray(shafts, dtype=np.float64)

    def follow(
        self,
        before_rad_per_s: npt.ArrayLike,
        wanted_rad_per_s: npt.ArrayLike,
        *,
        period_s: float,
        acceleration_rad_per_s2: float | None = None,
        dead_band_rad_per_s: float = 0.0,
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return the wheels' mean rates in a period, and their rates at its end [rad/s].

        Each wheel's motor stands still on commands below its dead band, and changes its rate at
        most so fast: it ramps, then holds. The rotations in the period are exact, and so is the
        circle of a ramp from rest; where one of speed and turn rate ramps and the other stays, the
        mean rates lead aside by about a sixth of the period's way times its turn.

        Parameters
        ----------
        before_rad_per_s, wanted_rad_per_s : (..., 2) float64 — Rates now, and the command [rad/s].
        period_s : Sample period T [s].
        acceleration_rad_per_s2 : Greatest acceleration [rad/s²]; None: at once.
        dead_band_rad_per_s : Slower commands do not turn a wheel [rad/s].
        """
        wanted = without_dead_band(wanted_rad_per_s, dead_band_rad_per_s)
        return ramp(
            before_rad_per_s, wanted, period_s=period_s, acceleration=acceleration_rad_per_s2
        )

    def saturate(self, wheel_rates_rad_per_s: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return wheel rates, each cut by itself to ±u_max, thesis (3.8) [rad/s].

        Parameters
        ----------
        wheel_rates_rad_per_s : (..., 2) float64 — Wanted rates, right and left [rad/s].
        """
        limit = self.max_wheel_rate_rad_per_s
        return np.clip(np.asarray(wheel_rates_rad_per_s, dtype=np.float64), -limit, limit)

    def twist(self, wheel_rates_rad_per_s: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the forward speed [m/s] and the turn rate [rad/s] that wheel rates produce."""
        rates = np.asarray(wheel_rates_rad_per_s, dtype=np.float64)
        right, left = rates[..., 0], rates[..., 1]
        speed = 0.5 * self.wheel_radius_m * (right + left)
        turn_rate = self.wheel_radius_m * (right - left) / self.axle_length_m
        return np.stack([speed, turn_rate], axis=-1)

    def wheel_rates(
        self, *, speed_m_per_s: npt.ArrayLike, turn_rate_rad_per_s: npt.ArrayLike
    ) -> npt.NDArray[np.float64]:
        """Return the wheel rates for a forward speed and a turn rate [rad/s]."""
        speed = np.asarray(speed_m_per_s, dtype=np.float64)
        half = 0.5 * self.axle_length_m * np.asarray(turn_rate_rad_per_s, dtype=np.float64)
        return np.stack([speed + half, speed - half], axis=-1) / self.wheel_radius_m

    def pose_rate(
        self, pose: npt.ArrayLike, wheel_rates_rad_per_s: npt.ArrayLike
    ) -> npt.NDArray[np.float64]:
        """Return dx/dt [m/s], dy/dt [m/s], dθ/dt [rad/s], thesis (3.7).

        Parameters
        ----------
        pose, wheel_rates_rad_per_s : As for `step_euler` [m, rad], [rad/s].
        """
        heading = np.asarray(pose, dtype=np.float64)[..., 2]
        twist = self.twist(wheel_rates_rad_per_s)
        speed, turn_rate = twist[..., 0], twist[..., 1]
        rates = np.broadcast_arrays(speed * np.cos(heading), speed * np.sin(heading), turn_rate)
        return np.stack(rates, axis=-1)

    def step_euler(
        self, pose: npt.ArrayLike, wheel_rates_rad_per_s: npt.ArrayLike, *, period_s: float
    ) -> npt.NDArray[np.float64]:
        """Return the pose one Euler step later, thesis (5.1) [m, rad], the heading not wrapped.

        A period that turns by Δθ on v T bends the path by about v T Δθ / 2 too little.

        Parameters
        ----------
        pose : (..., 3) float64 — x [m], y [m], heading [rad].
        wheel_rates_rad_per_s : (..., 2) float64 — Right and left in the period [rad/s].
        period_s : Sample period T [s].
        """
        return np.asarray(pose) + period_s * self.pose_rate(pose, wheel_rates_rad_per_s)

    def step_arc(
        self, pose: npt.ArrayLike, wheel_rates_rad_per_s: npt.ArrayLike, *, period_s: float
    ) -> npt.NDArray[np.float64]:
        """Return the pose a period later on the exact arc of (3.7) [m, rad], not wrapped.

        Parameters
        ----------
        pose, wheel_rates_rad_per_s, period_s : As for `step_euler` [m, rad], [rad/s], [s].
        """
        twist = self.twist(wheel_rates_rad_per_s)
        return pose_on_arc(
            pose, period_s, speed_m_per_s=twist[..., 0], turn_rate_rad_per_s=twist[..., 1]
        )


def without_dead_band(wanted: npt.ArrayLike, dead_band: float) -> npt.NDArray[np.float64]:
    """Return commands, zero where they are smaller than the dead band [rad/s].

    Parameters
    ----------
    wanted, dead_band : (...) float64, float — Commands and the band [rad/s].
    """
    given = np.asarray(wanted, dtype=np.float64)
    return given if dead_band == 0.0 else np.where(np.abs(given) < dead_band, 0.0, given)


def ramp(
    before: npt.ArrayLike,
    wanted: npt.ArrayLike,
    *,
    period_s: float,
    acceleration: npt.ArrayLike | None,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return mean and last rate of a period that begins with a ramp to the wanted one [rad/s].

    Parameters
    ----------
    before, wanted : (...) float64 — Rates at the period's begin, and the command [rad/s].
    period_s : Its length T [s].
    acceleration : (...) float64 or None — Slope of the ramp [rad/s²]; None: a step.
    """
    end = np.asarray(wanted, dtype=np.float64)
    if acceleration is None:
        return end, end
    start, slope = np.asarray(before, dtype=np.float64), np.asarray(acceleration)
    change = np.clip(end - start, -slope * period_s, slope * period_s)
    end = start + change
    ramp_share = np.abs(change) / (slope * period_s)
    return end - 0.5 * ramp_share * change, end


def linear_model(
    poses: npt.ArrayLike, wheel_rates: npt.ArrayLike, robot: DifferentialDrive
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return F = ∂q̇/∂q (k, 3, 3) [1/s, m/s per rad], G = ∂q̇/∂u (k, 3, 2) [m/rad, -], (7.28).

    Parameters
    ----------
    poses : (k, 3) float64 — x [m], y [m], heading [rad].
    wheel_rates : (k, 2) float64 — Right and left [rad/s].
    robot : Wheels and axle.
    """
    heading = np.asarray(poses, dtype=np.float64)[:, 2]
    speed = robot.twist(wheel_rates)[:, 0]
    cos, sin = np.cos(heading), np.sin(heading)
    f = np.zeros((len(heading), 3, 3))
    f[:, 0, 2], f[:, 1, 2] = -speed * sin, speed * cos
    half, spin = 0.5 * robot.wheel_radius_m, robot.wheel_radius_m / robot.axle_length_m
    g = np.empty((len(heading), 3, 2))
    g[:, 0], g[:, 1] = half * cos[:, None], half * sin[:, None]
    g[:, 2] = (spin, -spin)
    return f, g
