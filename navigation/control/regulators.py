"""The textbook's regulators and the graceful law of Park and Kuipers, in polar coordinates."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.checks import check_positive
from octant.navigation.control.docking_law import DockingLaw

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class CartesianRegulator:
    """The textbook's Cartesian regulator: to the goal point, with any heading.

    Textbook (11.78), (11.79): v = -k₁ (x cos θ + y sin θ), ω = k₂ (atan2(y, x) - θ + π), the angle
    wrapped; in polar coordinates v = k₁ e cos α, ω = k₂ α.

    Parameters
    ----------
    k1_per_s, k2_per_s : Gains of speed and turn [1/s].
    """

    k1_per_s: float = 1.0
    k2_per_s: float = 3.0

    def __post_init__(self) -> None:
        check_positive(self.k1_per_s, name="k1_per_s", unit="1/s")
        check_positive(self.k2_per_s, name="k2_per_s", unit="1/s")

    def twist(self, polar: npt.ArrayLike) -> FloatArray:
        """Return the wanted speed [m/s] and turn rate [rad/s]."""
        state = np.asarray(polar, dtype=np.float64)
        e, alpha = state[..., 0], state[..., 1]
        return np.stack([self.k1_per_s * e * np.cos(alpha), self.k2_per_s * alpha], axis=-1)


def posture_regulator(
    *, k1_per_s: float = 1.0, k2_per_s: float = 2.5, k3: float = 3.0
) -> DockingLaw:
    """Return the textbook's posture regulator: to the goal point with the goal's heading.

    Textbook (11.81), (11.82): v = k₁ ρ cos γ, ω = k₂ γ + k₁ (sin γ cos γ / γ)(γ + k₃ δ). With ρ, γ,
    δ for e, α, φ it is the docking law of γ = k₁, k = k₂, h = k₃, both after Aicardi et al. (1995).

    Parameters
    ----------
    k1_per_s, k2_per_s : Gains of speed and turn [1/s].
    k3 : Weight of the direction of arrival [-].
    """
    return DockingLaw(gamma_per_s=k1_per_s, k_per_s=k2_per_s, h=k3)


@dataclass(frozen=True, slots=True, kw_only=True)
class GracefulLaw:
    """The graceful docking law of Park and Kuipers: a path first, then a comfortable speed.

    Parameters
    ----------
    k1 : How much the heading leads the direction of arrival [-].
    k2 : How much faster the heading settles than the position [-].
    beta : How much curvature slows the robot, β of v = v_max/(1 + β |κ|^λ) [m^λ].
    exponent : Exponent λ of the curvature [-].
    max_speed_m_per_s : Speed on the straight [m/s].
    slowing_radius_m : Distance within which the speed falls in proportion to it [m].

    Notes
    -----
    Park and Kuipers (2011), "A smooth control law for graceful motion of differential wheeled
    mobile robots in 2D environment", equations (11), (14), (15); their δ and θ are -α and -φ here:

        κ = [k₂ (α + atan(k₁ φ)) + (1 + k₁/(1 + (k₁ φ)²)) sin α] / e,   ω = κ v.

    Its path does not depend on its speed, so any speed limit keeps the path. It only drives
    forward.
    """

    k1: float = 1.0
    k2: float = 3.0
    beta: float = 0.4
    exponent: float = 2.0
    max_speed_m_per_s: float = 0.2
    slowing_radius_m: float = 0.5

    def __post_init__(self) -> None:
        for name, unit in (
            ("k1", "(no unit)"),
            ("k2", "(no unit)"),
            ("beta", "m^lambda"),
            ("exponent", "(no unit)"),
            ("max_speed_m_per_s", "m/s"),
            ("slowing_radius_m", "m"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)

    def curvature_per_m(self, polar: npt.ArrayLike) -> FloatArray:
        """Return the curvature κ of the wanted path, counter-clockwise positive [1/m].

        Parameters
        ----------
        polar : (..., 3) array_like — e [m], α [rad], φ [rad].
        """
        state = np.asarray(polar, dtype=np.float64)
        e, alpha, phi = state[..., 0], state[..., 1], state[..., 2]
        lead = self.k1 * phi
        settle = self.k2 * (alpha + np.arctan(lead))
        return np.asarray((settle + (1.0 + self.k1 / (1.0 + lead**2)) * np.sin(alpha)) / e)

    def twist(self, polar: npt.ArrayLike) -> FloatArray:
        """Return the wanted speed [m/s] and turn rate [rad/s]."""
        curvature = self.curvature_per_m(polar)
        e = np.asarray(polar, dtype=np.float64)[..., 0]
        comfort = 1.0 / (1.0 + self.beta * np.abs(curvature) ** self.exponent)
        speed = self.max_speed_m_per_s * comfort * np.minimum(1.0, e / self.slowing_radius_m)
        return np.stack([speed, curvature * speed], axis=-1)
