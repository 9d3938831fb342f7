"""How a fixed landmark moves in the frame of a robot that slips, step by exact step.

State: the landmark's place e_x, e_y [m] in the body frame, the linear slip b [m/s], the landmark's
attitude ψ [rad] in the body frame and the angular slip s [rad/s]; the robot moves with v + b and
ω + s where v and ω were commanded. Every function takes leading axes.
"""

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]

_SMALL_RAD = 1e-4


def attitude_transition(period_s: npt.ArrayLike) -> FloatArray:
    """Return exp(A T) = [[1, -T], [0, 1]] of ψ and s over one period, (..., 2, 2) [rad per rad, s].

    Parameters
    ----------
    period_s : (...) array_like
        Period T [s].

    Notes
    -----
    Docking paper (6). The commanded turn enters by [-T, 0]ᵀ ω; as printed, the input matrix already
    holds ω and is multiplied by it once more.
    """
    period = np.asarray(period_s, dtype=np.float64)
    one, zero = np.ones_like(period), np.zeros_like(period)
    return _matrix([[one, -period], [zero, one]])


def position_transition(turn_rate_rad_per_s: npt.ArrayLike, period_s: npt.ArrayLike) -> FloatArray:
    """Return the transition matrix of e_x, e_y and b over one period.

    Parameters
    ----------
    turn_rate_rad_per_s : (...) array_like
        Turn rate ω, slip included [rad/s].
    period_s : (...) array_like
        Period T [s].

    Returns
    -------
    (..., 3, 3) float64
        Docking paper (25) [m per m, s]; its third column, less the last entry, is also the effect
        of the commanded speed, (26).
    """
    rate, period = np.broadcast_arrays(
        np.asarray(turn_rate_rad_per_s, dtype=np.float64), np.asarray(period_s, dtype=np.float64)
    )
    turn = rate * period
    cos, sin = np.cos(turn), np.sin(turn)
    ahead, aside = _arc(turn)
    one, zero = np.ones_like(turn), np.zeros_like(turn)
    return _matrix([[cos, sin, -period * ahead], [-sin, cos, period * aside], [zero, zero, one]])


def turn_sensitivity(
    place_m: npt.ArrayLike,
    *,
    speed_m_per_s: npt.ArrayLike,
    turn_rate_rad_per_s: npt.ArrayLike,
    period_s: npt.ArrayLike,
) -> FloatArray:
    """Return the derivative of the landmark's next place with respect to the turn rate [m s/rad].

    Parameters
    ----------
    place_m : (..., 2) array_like
        e_x, e_y before the step [m].
    speed_m_per_s : (...) array_like
        Speed, slip included [m/s].
    turn_rate_rad_per_s : (...) array_like
        Turn rate, slip included [rad/s].
    period_s : (...) array_like
        Period T [s].

    Returns
    -------
    (..., 2) float64
        ∂(e_x, e_y)/∂ω [m s/rad]: what couples the place to the angular slip.
    """
    place = np.asarray(place_m, dtype=np.float64)
    period = np.asarray(period_s, dtype=np.float64)
    turn = np.asarray(turn_rate_rad_per_s, dtype=np.float64) * period
    cos, sin = np.cos(turn), np.sin(turn)
    small = np.abs(turn) < _SMALL_RAD
    safe = np.where(small, 1.0, turn)
    ahead, aside = _arc(turn)
    # Derivatives of sin x / x and (1 - cos x)/x.
    d_ahead = np.where(small, -turn / 3.0, (cos - ahead) / safe)
    d_aside = np.where(small, 0.5 - turn**2 / 8.0, (sin - aside) / safe)
    x, y = place[..., 0], place[..., 1]
    distance = np.asarray(speed_m_per_s, dtype=np.float64) * period
    return np.stack(
        [
            period * (cos * y - sin * x - distance * d_ahead),
            period * (distance * d_aside - cos * x - sin * y),
        ],
        axis=-1,
    )


def checked_period(period_s: npt.ArrayLike) -> FloatArray:
    """Return a sample time, or many, once they are known to be positive [s].

    Parameters
    ----------
    period_s : (...) array_like
        Sample times [s].
    """
    period = np.asarray(period_s, dtype=np.float64)
    if not (np.isfinite(period).all() and (period > 0.0).all()):
        worst = period[~(np.isfinite(period) & (period > 0.0))].flat[0]
        msg = (
            f"the sample time is {worst:g} s, but it must be positive and finite: give the time "
            "that passed since the last step."
        )
        raise NavigationError(msg)
    return period


def _arc(turn_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sin x / x and (1 - cos x)/x, exact also without turning [-]."""
    half = np.sinc(turn_rad / (2.0 * np.pi))
    return np.sinc(turn_rad / np.pi), 0.5 * turn_rad * half**2


def _matrix(rows: list[list[FloatArray]]) -> FloatArray:
    filled = np.empty((*rows[0][0].shape, len(rows), len(rows[0])))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            filled[..., i, j] = entry
    return filled
