"""The docking law: feedback to a goal pose by Lyapunov's method, its gains and limits."""

import warnings
from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import PhysicsWarning
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_choice, check_positive

FloatArray = npt.NDArray[np.float64]

Approach = Literal["forward", "reverse"]
"""Which end of the robot comes first: the front, or the back as into a charging dock."""

Saturation = Literal["clip", "curvature"]
"""How commands beyond the limits are cut: each on its own, or both by one factor."""


class GoalLaw(Protocol):
    """A feedback law that drives a robot to the origin of the goal frame."""

    def twist(self, polar: npt.ArrayLike) -> FloatArray:
        """Return the wanted speed v [m/s] and turn rate ω [rad/s], (..., 2).

        Parameters
        ----------
        polar : (..., 3) array_like — e [m], α [rad], φ [rad] of `polar.polar_state`.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class DockingLaw:
    """The docking law; the defaults are the gains of the paper's experiment.

    Warns (`PhysicsWarning`) when k is outside [2γ, γ(h + 1)]: the path's curvature is then
    unbounded at the goal.

    Parameters
    ----------
    gamma_per_s, k_per_s : Gains γ of the speed and k of the turn [1/s].
    h : Weight h of the direction of arrival [-].
    approach : {"forward", "reverse"} — "reverse": the same pose backwards, the paper's [0, ±π, ±π].

    Notes
    -----
    Docking paper (33), (35):

        v = γ e cos α,   ω = k α + γ (cos α sin α / α)(α + h φ).

    With V = (λ e² + α² + h φ²)/2 this gives V̇ = -λ γ e² cos²α - k α² (the paper's (32) lacks the
    minus sign of ė, its (36) the λ, its (37) the minus sign of ė). Near the goal e falls as
    exp(-γ t), while α and φ follow s² + k s + γ² h = 0: stable for all positive gains. The
    curvature ω/v stays bounded only if they fall at least as fast as e, which with s = p - γ is
    p² + (k - 2γ) p + γ² (h + 1) - γ k = 0 with roots on the left: 2γ < k < γ (h + 1). The gains of
    the paper's figure 4, γ = 3, h = 1, k = 6, lie on the corner k = 2γ = γ(h + 1), where the
    curvature grows as the logarithm of 1/e.
    """

    gamma_per_s: float = 0.125
    h: float = 20.0
    k_per_s: float = 1.0
    approach: Approach = "forward"

    def __post_init__(self) -> None:
        for name, unit in (("gamma_per_s", "1/s"), ("h", "(no unit)"), ("k_per_s", "1/s")):
            check_positive(getattr(self, name), name=name, unit=unit)
        check_choice(self.approach, get_args(Approach), name="approach")
        low, high = self.bounded_curvature_per_s
        if not low <= self.k_per_s <= high:
            msg = (
                f"k_per_s is {self.k_per_s:g} 1/s, outside the region of bounded curvature "
                f"2 gamma <= k <= gamma (h + 1), here {low:g} to {high:g} 1/s: the robot arrives, "
                "but turns ever more sharply at the goal."
            )
            warnings.warn(msg, PhysicsWarning, stacklevel=3)

    @property
    def bounded_curvature_per_s(self) -> tuple[float, float]:
        """Return the ends 2γ and γ(h + 1) of the region for k [1/s]; empty for h below 1."""
        return 2.0 * self.gamma_per_s, self.gamma_per_s * (self.h + 1.0)

    def twist(self, polar: npt.ArrayLike) -> FloatArray:
        """Return the wanted speed [m/s] and turn rate [rad/s]."""
        e, alpha, phi = _errors(polar, self.approach)
        speed = self.gamma_per_s * e * np.cos(alpha)
        # sinc keeps sin α / α defined on the straight line to the goal.
        pull = self.gamma_per_s * np.cos(alpha) * np.sinc(alpha / np.pi)
        turn_rate = self.k_per_s * alpha + pull * (alpha + self.h * phi)
        return np.stack([-speed if self.approach == "reverse" else speed, turn_rate], axis=-1)

    def lyapunov(self, polar: npt.ArrayLike, *, weight_per_m2: float = 1.0) -> FloatArray:
        """Return V = (λ e² + α² + h φ²)/2 of (31) [-], which never rises along an ideal run.

        Parameters
        ----------
        polar : (..., 3) array_like — e [m], α [rad], φ [rad].
        weight_per_m2 : Weight λ of the distance [1/m²].
        """
        e, alpha, phi = _errors(polar, self.approach)
        return np.asarray(0.5 * (weight_per_m2 * e**2 + alpha**2 + self.h * phi**2))


@dataclass(frozen=True, slots=True, kw_only=True)
class TwistLimits:
    """The limits of a command and the manner of keeping them.

    Parameters
    ----------
    max_speed_m_per_s : Highest speed, forward or backward [m/s].
    max_turn_rate_rad_per_s : Highest turn rate [rad/s].
    saturation : {"clip", "curvature"} — Cut each on its own, as in the paper's experiment, or scale
        both by one factor, so that the path keeps its shape and only takes longer.
    """

    max_speed_m_per_s: float = 0.2
    max_turn_rate_rad_per_s: float = 0.2
    saturation: Saturation = "curvature"

    def __post_init__(self) -> None:
        check_positive(self.max_speed_m_per_s, name="max_speed_m_per_s", unit="m/s")
        check_positive(self.max_turn_rate_rad_per_s, name="max_turn_rate_rad_per_s", unit="rad/s")
        check_choice(self.saturation, get_args(Saturation), name="saturation")

    def apply(self, twist: npt.ArrayLike) -> FloatArray:
        """Return a command v [m/s], ω [rad/s] within the limits.

        Parameters
        ----------
        twist : (..., 2) array_like — Wanted v [m/s] and ω [rad/s].
        """
        wanted = np.asarray(twist, dtype=np.float64)
        limits = np.array([self.max_speed_m_per_s, self.max_turn_rate_rad_per_s])
        if self.saturation == "clip":
            return np.clip(wanted, -limits, limits)
        excess = np.max(np.abs(wanted) / limits, axis=-1, keepdims=True)
        return np.asarray(wanted / np.maximum(excess, 1.0))


def slip_compensated(twist: npt.ArrayLike, slips: npt.ArrayLike) -> FloatArray:
    """Return the command v - b̂ [m/s], ω - ŝ [rad/s] that makes a slipping robot move as wanted.

    Uncompensated, a slip b < 0 stops the law where γ e = |b|: 8 cm before the goal for the paper's
    γ = 0.125 /s and b = -0.01 m/s.

    Parameters
    ----------
    twist : (..., 2) array_like — Wanted v [m/s] and ω [rad/s].
    slips : (..., 2) array_like — Estimated slips b̂ [m/s] and ŝ [rad/s], added to v and ω.
    """
    return np.asarray(twist, dtype=np.float64) - np.asarray(slips, dtype=np.float64)


def stall_distance_m(law: DockingLaw, linear_slip_m_per_s: float) -> float:
    """Return the distance from the goal at which an uncompensated slip stops the robot, |b|/γ [m].

    Parameters
    ----------
    law : Gains.
    linear_slip_m_per_s : Slip b against the motion [m/s].
    """
    return abs(linear_slip_m_per_s) / law.gamma_per_s


def faded(polar: npt.ArrayLike, *, radius_m: float, approach: Approach = "forward") -> FloatArray:
    """Return a polar state in which the direction of the goal fades out near the goal, (..., 3).

    e, α - (1 - w) φ and w φ with w = min(1, e²/radius²); in reverse φ is counted from π. The
    direction of a goal nearer than the estimate is certain is noise: at w = 0 only the heading's
    error is left, α - φ = -θ. An ideal run is hardly changed: there φ has gone before.

    Parameters
    ----------
    polar : (..., 3) array_like — e [m], α [rad], φ [rad], estimated.
    radius_m : Distance within which it fades [m]: several deviations of the estimated place.
    approach : {"forward", "reverse"} — Which end comes first.
    """
    state = np.asarray(polar, dtype=np.float64)
    e, alpha, phi = state[..., 0], state[..., 1], state[..., 2]
    astray = _errors(state, approach)[2]
    lost = (1.0 - np.minimum(1.0, (e / radius_m) ** 2)) * astray
    return np.stack([e, alpha - lost, phi - lost], axis=-1)


def latched(polar: npt.ArrayLike, *, radius_m: float, approach: Approach = "forward") -> bool:
    """Return whether the robot has arrived and should stop for good.

    So within the radius, and within three radii once the goal lies behind the end that comes first:
    α at the goal is noise, and a law that follows it turns on the spot.

    Parameters
    ----------
    polar, approach : As for `faded` [m], [rad].
    radius_m : Distance that counts as arrived [m].
    """
    e, alpha, _ = _errors(polar, approach)
    passed = bool(np.cos(alpha) <= 0.0) and bool(e <= 3.0 * radius_m)
    return bool(e <= radius_m) or passed


def _errors(polar: npt.ArrayLike, approach: Approach) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return e [m] and the angles [rad] that the law drives to zero."""
    state = np.asarray(polar, dtype=np.float64)
    e, alpha, phi = state[..., 0], state[..., 1], state[..., 2]
    if approach == "reverse":
        return e, wrap_angle(alpha - np.pi), wrap_angle(phi - np.pi)
    return e, alpha, phi
