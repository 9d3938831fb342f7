"""Desired trajectories with their feed-forward: curves in time, sampled as poses and speeds."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive

FloatArray = npt.NDArray[np.float64]

_STILL_M_PER_S = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A way in the plane as a function of time.

    Parameters
    ----------
    name : What it is called.
    duration_s : How long it takes [s].
    motion : Times (k,) [s] to (3, k, 2): place [m], velocity [m/s] and acceleration [m/s²].
    resting_heading_rad : Heading of a curve that never moves [rad].
    """

    name: str
    duration_s: float
    motion: Callable[[FloatArray], FloatArray]
    resting_heading_rad: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.duration_s) and self.duration_s > 0.0):
            msg = (
                f"the trajectory {self.name!r} takes {self.duration_s} s, but its duration must "
                "be positive and finite: give seconds."
            )
            raise NavigationError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class DesiredTrajectory:
    """A desired trajectory at sample times, thesis 6.5.2.

    Parameters
    ----------
    name : What it is called.
    time_s : (k,) float64 — Times, evenly spaced [s].
    poses : (k, 3) float64 — x [m], y [m], heading, unwrapped [rad].
    speed_m_per_s, turn_rate_rad_per_s : (k,) float64 — Forward speed ν [m/s], turn rate ω [rad/s].
    """

    name: str
    time_s: FloatArray
    poses: FloatArray
    speed_m_per_s: FloatArray
    turn_rate_rad_per_s: FloatArray

    def __post_init__(self) -> None:
        count = len(self.time_s)
        for name, shape in (
            ("time_s", (count,)),
            ("poses", (count, 3)),
            ("speed_m_per_s", (count,)),
            ("turn_rate_rad_per_s", (count,)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)

    @property
    def period_s(self) -> float:
        """Return the distance of two samples [s]."""
        return float(self.time_s[1] - self.time_s[0])

    @property
    def steps(self) -> int:
        """Return the number of intervals."""
        return len(self.time_s) - 1

    @property
    def length_m(self) -> float:
        """Return the length of the way, by its chords [m]."""
        return float(np.linalg.norm(np.diff(self.poses[:, :2], axis=0), axis=1).sum())

    def wheel_rates(self, robot: DifferentialDrive) -> FloatArray:
        """Return the feed-forward of the wheels, (k, 2), right and left [rad/s]."""
        return robot.wheel_rates(
            speed_m_per_s=self.speed_m_per_s, turn_rate_rad_per_s=self.turn_rate_rad_per_s
        )


def desired_trajectory(curve: Curve, *, period_s: float) -> DesiredTrajectory:
    """Return a curve in duration / period + 1 samples, with heading, speed and turn rate.

    Thesis (6.31) and below, signs put right: ω = (ÿẋ - ẍẏ)/ν², heading the unwrapped atan2(ẏ, ẋ);
    the printed tan⁻¹ loses the quadrant, and for the ellipse tan⁻¹(y/x) is the direction of the
    place. Where the curve stands still its heading is the last one.

    Parameters
    ----------
    curve : The way.
    period_s : Sample period T [s]; the duration is a multiple of it.
    """
    steps = round(curve.duration_s / period_s) if period_s > 0.0 else 0
    if steps < 1 or abs(steps * period_s - curve.duration_s) > 1e-9 * curve.duration_s:
        msg = (
            f"the sample period is {period_s} s, but the {curve.duration_s} s of {curve.name!r} "
            "must be a multiple of it: choose another period."
        )
        raise NavigationError(msg)
    time: FloatArray = period_s * np.arange(steps + 1, dtype=np.float64)
    place, velocity, acceleration = curve.motion(time)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    moving = speed > _STILL_M_PER_S
    cross = velocity[:, 0] * acceleration[:, 1] - velocity[:, 1] * acceleration[:, 0]
    turn = np.where(moving, cross / np.where(moving, speed, 1.0) ** 2, 0.0)
    heading = np.full(steps + 1, curve.resting_heading_rad)
    if moving.any():
        known = np.flatnonzero(moving)
        last = known[np.maximum(np.searchsorted(known, np.arange(steps + 1), side="right") - 1, 0)]
        heading = np.unwrap(np.arctan2(velocity[last, 1], velocity[last, 0]))
    return DesiredTrajectory(
        name=curve.name,
        time_s=time,
        poses=np.column_stack([place, heading]),
        speed_m_per_s=np.where(moving, speed, 0.0),
        turn_rate_rad_per_s=turn,
    )


def check_feasible(trajectory: DesiredTrajectory, robot: DifferentialDrive) -> None:
    """Refuse a trajectory that the wheels cannot follow.

    Parameters
    ----------
    trajectory : The trajectory.
    robot : The robot and its limits.
    """
    wanted = trajectory.wheel_rates(robot)
    rates = np.abs(wanted).max(axis=1)
    worst = int(np.argmax(rates))
    limit = robot.max_wheel_rate_rad_per_s
    if robot.least_radius_m > 0.0:
        short = np.abs(robot.saturate(wanted) - wanted).max(axis=1)
        worst = int(np.argmax(short))
        if short[worst] > limit * 1e-9:
            msg = (
                f"the trajectory {trajectory.name!r} is infeasible: at "
                f"{trajectory.time_s[worst]:g} s it needs {trajectory.speed_m_per_s[worst]:.3g} "
                f"m/s and {trajectory.turn_rate_rad_per_s[worst]:.3g} rad/s of a car whose least "
                f"radius is {robot.least_radius_m:.3g} m and whose wheels turn at most "
                f"{limit:.3g} rad/s; give it more time or wider bends."
            )
            raise NavigationError(msg)
    if rates[worst] > limit * (1.0 + 1e-9):
        speed = trajectory.speed_m_per_s[worst]
        turn = trajectory.turn_rate_rad_per_s[worst]
        msg = (
            f"the trajectory {trajectory.name!r} is infeasible: at {trajectory.time_s[worst]:g} s "
            f"its speed of {speed:.3g} m/s and curvature of {turn / max(speed, 1e-12):.3g} 1/m "
            f"need {rates[worst]:.3g} rad/s of a wheel that turns at most {limit:.3g} rad/s; give "
            "it more time or wider bends."
        )
        raise NavigationError(msg)
