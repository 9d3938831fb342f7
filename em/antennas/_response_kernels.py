# mypy: allow-untyped-defs
"""Compiled interpolation of the reader's embedded patterns."""

import numpy as np

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
def far_fields(table, linear, step_theta, step_phi, centre, theta, phi, parts, out):
    """Fill (c, n, 2) F_theta, F_phi of every antenna in one direction of the reader frame.

    ``parts`` (c n 4,) is worked in.
    """
    a = theta / step_theta
    b = phi / step_phi
    i = min(int(a), table.shape[0] - 2 * PAD - 2)
    j = int(np.floor(b))
    fraction = b - j
    j = j % (table.shape[1] - 2 * PAD)
    row = cell_weights(a - i, linear[i, j])
    v0, v1, v2, v3 = cell_weights(fraction, linear[i, j])
    i += PAD - 1
    j += PAD - 1
    for m in range(len(parts)):
        parts[m] = 0.0
    for p in range(4):
        w0, w1, w2, w3 = row[p] * v0, row[p] * v1, row[p] * v2, row[p] * v3
        first, second, third, fourth = (
            table[i + p, j],
            table[i + p, j + 1],
            table[i + p, j + 2],
            table[i + p, j + 3],
        )
        for m in range(len(parts)):
            part = parts[m]
            part += w0 * first[m]
            part += w1 * second[m]
            part += w2 * third[m]
            part += w3 * fourth[m]
            parts[m] = part
    st, ct = np.sin(theta), np.cos(theta)
    x, y, z = st * np.cos(phi), st * np.sin(phi), ct
    m = 0
    for c in range(centre.shape[0]):
        for k in range(centre.shape[1]):
            angle = x * centre[c, k, 0] + y * centre[c, k, 1] + z * centre[c, k, 2]
            turn = complex(np.cos(angle), np.sin(angle))
            out[c, k, 0] = complex(parts[m], parts[m + 1]) * turn
            out[c, k, 1] = complex(parts[m + 2], parts[m + 3]) * turn
            m += 4


@kernel
def fill_far_fields(response, theta, phi, out):
    """Fill (m, c, n, 2) F_theta, F_phi for m directions."""
    parts = np.empty(response.table.shape[2])
    for i in range(len(theta)):
        far_fields(
            response.table,
            response.linear,
            response.step_theta,
            response.step_phi,
            response.centre_rad,
            theta[i],
            phi[i],
            parts,
            out[i],
        )
