"""Whether a landmark's pose tells the slips: the docking paper's matrices (7) and (27)."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_SMALL_RAD = 1e-2


def attitude_observability() -> FloatArray:
    """Return [C; C A] of attitude ψ and angular slip s, docking paper (7): rank 2 [-].

    Its (7) for A = [[0, -1], [0, 0]] and C = [1, 0] of (4), (5).
    """
    output = np.array([[1.0, 0.0]])
    return np.vstack([output, output @ np.array([[0.0, -1.0], [0.0, 0.0]])])


def attitude_gramian(duration_s: float) -> FloatArray:
    """Return the observability Gramian of ψ and s over a time, (2, 2) [s], [s²], [s³].

    The same integral as (27), of (6): ∫ [[1, -τ], [-τ, τ²]] dτ.

    Parameters
    ----------
    duration_s : Time for which the landmark is in sight [s].
    """
    t = duration_s
    return np.array([[t, -(t**2) / 2.0], [-(t**2) / 2.0, t**3 / 3.0]])


def position_gramian(duration_s: float, *, turn_rate_rad_per_s: float = 0.0) -> FloatArray:
    """Return the observability Gramian of e_x, e_y and the linear slip b, (3, 3) [s], [s²], [s³].

    Parameters
    ----------
    duration_s : Time t for which the landmark is in sight [s].
    turn_rate_rad_per_s : Turn rate ω, constant as (27) takes it: a, b and c there hold for it only
        [rad/s].

    Notes
    -----
    Docking paper (27), integrated: ∫a = (cos ωt - 1)/ω², ∫b = (sin ωt - ωt)/ω², ∫c = 2 (ωt - sin
    ωt)/ω³. Its limit for ω = 0 is [[t, 0, -t²/2], [0, t, 0], [-t²/2, 0, t³/3]], of determinant
    t⁵/12; the paper prints -t and -t² for the last column, which no Gramian can have: it would be
    negative for b alone.
    """
    t = duration_s
    x = turn_rate_rad_per_s * t
    if abs(x) < _SMALL_RAD:
        # Series to x⁴: 1 - cos x, x - sin x cancel.
        ahead = -0.5 + x**2 / 24.0
        aside = -x / 6.0 + x**3 / 120.0
        slip = 1.0 / 3.0 - x**2 / 60.0
    else:
        ahead = (np.cos(x) - 1.0) / x**2
        aside = (np.sin(x) - x) / x**2
        slip = 2.0 * (x - np.sin(x)) / x**3
    a, b, c = t**2 * ahead, t**2 * aside, t**3 * slip
    return np.array([[t, 0.0, a], [0.0, t, b], [a, b, c]])


def slip_deviation(gramian: FloatArray, *, measured_variance: float, period_s: float) -> float:
    """Return the least standard deviation of the slip that measurements alone allow [m/s], [rad/s].

    The Gramian over R T is the information of measurements of variance R every T, with neither
    plant noise nor an estimate before; the slip is the last state. On a straight way it is
    √(12 R T / t³).

    Parameters
    ----------
    gramian : (n, n) float64 — From `position_gramian` or `attitude_gramian` [s], [s²], [s³].
    measured_variance : Variance R of each measured coordinate [m²], or of the attitude [rad²].
    period_s : Time T from one image to the next [s].
    """
    return float(np.sqrt(measured_variance * period_s * np.linalg.inv(gramian)[-1, -1]))
