# mypy: allow-untyped-defs
"""Compiled interpolation of the reader's embedded patterns."""

import numpy as np

from octant.em.antennas._phase_kernels import sine_cosine
from octant.geometries.kernels import kernel

PAD = 2
"""Rows and columns that the table repeats beyond its ends, for the cubic stencil."""


@kernel
def cubic_weights(t):
    """Return the four Lagrange weights at -1, 0, 1, 2 for a place t between 0 and 1."""
    return (
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    )


@kernel
def cell_weights(t, linear):
    """Return the four weights of `cubic_weights`, or those of a straight line at a step."""
    if linear:
        return 0.0, 1.0 - t, t, 0.0
    return cubic_weights(t)


@kernel
def interpolate(response, theta, phi, parts):
    """Fill (4 c n,) parts of the patterns of a table's antennas in one direction of its frame."""
    table = response.table
    a, b = theta / response.step_theta, phi / response.step_phi
    i = min(int(a), table.shape[0] - 2 * PAD - 2)
    j = int(np.floor(b))
    fraction = b - j
    j = j % (table.shape[1] - 2 * PAD)
    row = cell_weights(a - i, response.linear[i, j])
    v0, v1, v2, v3 = cell_weights(fraction, response.linear[i, j])
    i += PAD - 1
    j += PAD - 1
    for m in range(len(parts)):
        parts[m] = 0.0
    for p in range(4):
        w0, w1, w2, w3 = row[p] * v0, row[p] * v1, row[p] * v2, row[p] * v3
        for m in range(len(parts)):
            part = parts[m]
            part += w0 * table[i + p, j, m]
            part += w1 * table[i + p, j + 1, m]
            part += w2 * table[i + p, j + 2, m]
            part += w3 * table[i + p, j + 3, m]
            parts[m] = part


@kernel
def turn_phases(centre, x, y, z, turns):
    """Fill (2, k) real and imaginary parts of what refers k antennas' phases to one centre.

    ``centre`` (3, k) is the wavenumber times each antenna's own, x, y, z the unit direction.
    """
    for m in range(centre.shape[1]):
        sine, cosine = sine_cosine(x * centre[0, m] + y * centre[1, m] + z * centre[2, m])
        turns[0, m], turns[1, m] = cosine, sine


@kernel
def fill_far_fields(response, theta, phi, out):
    """Fill (m, c, n, 2) F_theta, F_phi for m directions."""
    count = response.centre_rad.shape[1]
    parts, turns = np.empty(4 * count), np.empty((2, count))
    antennas = out.shape[2]
    for i in range(len(theta)):
        across, z = np.sin(theta[i]), np.cos(theta[i])
        interpolate(response, theta[i], phi[i], parts)
        turn_phases(response.centre_rad, across * np.cos(phi[i]), across * np.sin(phi[i]), z, turns)
        for m in range(count):
            turn = complex(turns[0, m], turns[1, m])
            one = out[i, m // antennas, m % antennas]
            one[0] = complex(parts[m], parts[count + m]) * turn
            one[1] = complex(parts[2 * count + m], parts[3 * count + m]) * turn
