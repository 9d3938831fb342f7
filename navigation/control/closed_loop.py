"""Closed loops of a goal law and an ideal robot, integrated to a tight tolerance."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.control.docking_law import GoalLaw, TwistLimits
from octant.navigation.control.polar import polar_rate, polar_state, pose_of_polar

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedLoop:
    """One run of a law in the goal frame, one row a time.

    Parameters
    ----------
    time_s : (t,) float64 — Times [s].
    polar : (t, 3) float64 — e [m], α [rad], φ [rad], continuous.
    twist : (t, 2) float64 — Command v [m/s], ω [rad/s].
    """

    time_s: FloatArray
    polar: FloatArray
    twist: FloatArray

    def __post_init__(self) -> None:
        for name, shape in (("time_s", (None,)), ("polar", (None, 3)), ("twist", (None, 2))):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)

    @property
    def pose(self) -> FloatArray:
        """Return the (t, 3) poses in the goal frame: x [m], y [m], heading in (-π, π] [rad]."""
        return pose_of_polar(self.polar)


def integrate(
    law: GoalLaw,
    start: npt.ArrayLike,
    time_s: npt.ArrayLike,
    *,
    limits: TwistLimits | None = None,
    slips: tuple[float, float] = (0.0, 0.0),
    tolerance: float = 1e-12,
) -> ClosedLoop:
    """Return state and command at the wanted times, under continuous feedback of the true state.

    Parameters
    ----------
    law : Feedback; integrated in polar state, where it is smooth and φ stays continuous.
    start : (3,) array_like — x [m], y [m], heading [rad] in the goal frame, not at the goal itself.
    time_s : (t,) array_like — Ascending times that are wanted [s], counted from the start.
    limits : Limits of the command; None: none.
    slips : What the robot adds to every command: b [m/s], s [rad/s].
    tolerance : Relative tolerance of the integrator (eighth order, Dormand and Prince) [-].
    """
    from scipy.integrate import solve_ivp

    times = frozen_array(time_s, name="time_s", shape=(None,), error=NavigationError)
    given = frozen_array(start, name="start", shape=(3,), error=NavigationError)
    if times.size == 0 or times[0] < 0.0 or np.any(np.diff(times) <= 0.0):
        msg = "time_s must ascend from zero or later without repetition: sort it."
        raise NavigationError(msg)
    first = polar_state(given)
    if first[0] == 0.0:
        msg = "the start is the goal, where α and φ are undefined: start elsewhere."
        raise NavigationError(msg)

    def command(polar: FloatArray) -> FloatArray:
        wanted = law.twist(polar)
        return wanted if limits is None else limits.apply(wanted)

    def rate(_: float, polar: FloatArray) -> FloatArray:
        return polar_rate(polar, command(polar) + np.array(slips))

    solution = solve_ivp(
        rate,
        (0.0, float(times[-1])),
        first,
        method="DOP853",
        t_eval=times,
        rtol=tolerance,
        atol=tolerance * float(first[0]),
    )
    if not solution.success:
        msg = (
            f"the run from {given.tolist()} reaches the goal before {times[-1]:g} s, where the "
            "law ends: ask for earlier times."
        )
        raise NavigationError(msg)
    polar = np.ascontiguousarray(solution.y.T)
    return ClosedLoop(time_s=times, polar=polar, twist=command(polar))
