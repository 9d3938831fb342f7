# mypy: allow-untyped-defs
"""Compiled far fields of the antennas, as vectors in the room's frame."""

from typing import NamedTuple

import numpy as np
from numba import njit

ISOTROPIC_THETA = 0
DIPOLE = 1
MONOPOLE = 2


class AntennaArrays(NamedTuple):
    """One antenna for the kernels."""

    kind: int
    half_length_rad: float  # k l / 2 of the dipole (or of the monopole with its image)
    amplitude: float  # square root of twice the reciprocal of the radiation integral
    axis_x: float
    axis_y: float
    axis_z: float


@njit(cache=True, error_model="numpy")
def far_field(antenna, dx, dy, dz):
    """Return the far-field vector (x, y, z) [-] towards the unit direction d; |F|^2 is the gain."""
    ax, ay, az = antenna.axis_x, antenna.axis_y, antenna.axis_z
    c = dx * ax + dy * ay + dz * az
    # The sine from the cross product keeps its digits near the axis, where 1 - c^2 loses them.
    sx, sy, sz = dy * az - dz * ay, dz * ax - dx * az, dx * ay - dy * ax
    sine = np.sqrt(sx * sx + sy * sy + sz * sz)
    if sine < 1e-12:
        if antenna.kind != ISOTROPIC_THETA:
            return 0.0, 0.0, 0.0
        # On the axis theta-hat depends on azimuth; azimuth 0 (or the y axis for a horizontal
        # antenna along x) is as good as any other.
        hx, hy, hz = (1.0, 0.0, 0.0) if abs(ax) < 0.5 else (0.0, 1.0, 0.0)
        p = hx * ax + hy * ay + hz * az
        hx, hy, hz = hx - p * ax, hy - p * ay, hz - p * az
        norm = np.sqrt(hx * hx + hy * hy + hz * hz) * (1.0 if c > 0.0 else -1.0)
        return hx / norm, hy / norm, hz / norm
    if antenna.kind == ISOTROPIC_THETA:
        strength = 1.0
    elif antenna.kind == MONOPOLE and c < 0.0:
        return 0.0, 0.0, 0.0
    else:
        h = antenna.half_length_rad
        # cos(h c) - cos(h), without cancellation
        strength = (
            antenna.amplitude
            * 2.0
            * np.sin(0.5 * h * (1.0 + c))
            * np.sin(0.5 * h * (1.0 - c))
            / sine
        )
    scale = strength / sine
    return scale * (c * dx - ax), scale * (c * dy - ay), scale * (c * dz - az)


@njit(cache=True, error_model="numpy")
def fill_far_field(antenna, direction, out):
    """Fill (n, 3) far-field vectors for (n, 3) unit directions."""
    for i in range(len(direction)):
        x, y, z = far_field(antenna, direction[i, 0], direction[i, 1], direction[i, 2])
        out[i, 0] = x
        out[i, 1] = y
        out[i, 2] = z
