"""Grids of directions, and how far a place is ahead of the reader's centre in each."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

POLE_MISMATCH = 0.02
"""Difference [-], over the greatest amplitude, up to which a pattern agrees over a pole."""


def angle_grid(rows: int, columns: int) -> tuple[FloatArray, FloatArray]:
    """Return theta (rows,) from 0 to pi and phi (columns,) from 0 up to, not including, 2 pi [rad].

    Parameters
    ----------
    rows, columns : Numbers of angles, evenly spaced.
    """
    phi: FloatArray = np.arange(columns, dtype=np.float64) * (2.0 * np.pi / columns)
    return np.linspace(0.0, np.pi, rows, dtype=np.float64), phi


def phase_ahead_rad(
    theta_rad: FloatArray, phi_rad: FloatArray, places_m: FloatArray, *, wavelength_m: float
) -> FloatArray:
    """Return how far waves from places are ahead of those from the origin, (n, T, P) [rad].

    Parameters
    ----------
    theta_rad, phi_rad : (T,), (P,) float64 — Directions of a grid [rad].
    places_m : (n, 3) float64 — Places [m].
    wavelength_m : Wavelength [m].
    """
    st, ct = np.sin(theta_rad)[:, None], np.cos(theta_rad)[:, None]
    parts = np.broadcast_arrays(st * np.cos(phi_rad), st * np.sin(phi_rad), ct)
    along_m = np.einsum("tpc,nc->ntp", np.stack(parts, axis=-1), places_m)
    ahead: FloatArray = 2.0 * np.pi / wavelength_m * along_m
    return ahead
