# mypy: allow-untyped-defs
"""Compiled interpolation of the reader's embedded patterns."""

from typing import NamedTuple

import numpy as np
from numba import njit

PAD = 2
"""Rows and columns that the table repeats beyond its ends, for the cubic stencil."""


class ResponseArrays(NamedTuple):
    """Embedded patterns of n antennas on a uniform grid, padded over the poles and around."""

    table: np.ndarray  # (T + 2 PAD, P + 2 PAD, n, 2) complex128, phase at each antenna's own centre
    step_theta: float  # [rad]
    step_phi: float  # [rad]
    centre_rad: np.ndarray  # (n, 3): wavenumber times phase centre, reader frame


@njit(cache=True, error_model="numpy")
def cubic_weights(t):
    """Return the four Lagrange weights at -1, 0, 1, 2 for a place t between 0 and 1."""
    return (
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    )


@njit(cache=True, error_model="numpy")
def _cubic(t, weight, row):
    """Fill the four Lagrange weights of a place t between 0 and 1."""
    weight[row, 0], weight[row, 1], weight[row, 2], weight[row, 3] = cubic_weights(t)


@njit(cache=True, error_model="numpy")
def far_fields(table, step_theta, step_phi, centre, theta, phi, weight, out):
    """Fill (n, 2) F_theta, F_phi of every antenna in one direction of the reader frame."""
    a = theta / step_theta
    b = phi / step_phi
    i = min(int(a), table.shape[0] - 2 * PAD - 2)
    j = int(np.floor(b))
    _cubic(a - i, weight, 0)
    _cubic(b - j, weight, 1)
    around = table.shape[1] - 2 * PAD
    i += PAD - 1
    j = j % around + PAD - 1
    n = table.shape[2]
    for k in range(n):
        out[k, 0] = 0.0
        out[k, 1] = 0.0
    for p in range(4):
        for q in range(4):
            w = weight[0, p] * weight[1, q]
            for k in range(n):
                out[k, 0] += w * table[i + p, j + q, k, 0]
                out[k, 1] += w * table[i + p, j + q, k, 1]
    st, ct = np.sin(theta), np.cos(theta)
    x, y, z = st * np.cos(phi), st * np.sin(phi), ct
    for k in range(n):
        angle = x * centre[k, 0] + y * centre[k, 1] + z * centre[k, 2]
        turn = complex(np.cos(angle), np.sin(angle))
        out[k, 0] *= turn
        out[k, 1] *= turn


@njit(cache=True, error_model="numpy")
def fill_far_fields(response, theta, phi, out):
    """Fill (m, n, 2) F_theta, F_phi for m directions."""
    weight = np.empty((2, 4))
    for i in range(len(theta)):
        far_fields(
            response.table,
            response.step_theta,
            response.step_phi,
            response.centre_rad,
            theta[i],
            phi[i],
            weight,
            out[i],
        )
