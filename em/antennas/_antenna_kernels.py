# mypy: allow-untyped-defs
"""Compiled far fields of the antennas, as vectors in the room's frame."""

from typing import Any

import numpy as np
from numba.extending import overload

from octant.em.antennas._phase_kernels import sine_cosine
from octant.em.antennas._response_kernels import PAD, cell_weights
from octant.em.records import AntennaArrays, PatternArrays, PatternChannels
from octant.geometries.kernels import kernel

ISOTROPIC_THETA = 0
DIPOLE = 1
MONOPOLE = 2
PATCH = 3
CONICAL_PATCH = 4
# Cosine to the axis down to which a direction lies in the plane under an antenna, which counts as
# above it: between ends of one height rounding would choose.
_HORIZON = -1e-9


def antenna_at(antennas: Any, channel: int) -> Any:
    """Return an antenna at one of its frequencies."""
    if isinstance(antennas, PatternChannels):
        return _pattern_at(antennas, channel)
    return _closed_form_at(antennas, channel)


@overload(antenna_at, inline="never")
def _antenna_at_of(antennas, channel):  # noqa: ARG001  numba asks for the same signature
    if antennas.instance_class is PatternChannels:
        return lambda antennas, channel: _pattern_at(antennas, channel)  # noqa: PLW0108
    return lambda antennas, channel: _closed_form_at(antennas, channel)  # noqa: PLW0108


@kernel
def _closed_form_at(antennas, channel):
    n = antennas.numbers[channel]
    return AntennaArrays(
        antennas.kind[channel], n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8]
    )


@kernel
def _pattern_at(antennas, channel):
    n = antennas.numbers[channel]
    table, linear = antennas.tables[channel], antennas.linear[channel]
    return PatternArrays(table, linear, n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7])


def far_field(antenna: Any, dx: float, dy: float, dz: float) -> Any:
    """Return the far-field vector (x, y, z) [-] towards the unit direction d; |F|^2 is the gain.

    Kernels get the code for the antenna's own type, so that the real far fields of closed form
    cost nothing extra beside the complex ones of tables.
    """
    if isinstance(antenna, PatternArrays):
        return _pattern_field(antenna, dx, dy, dz)
    return _closed_form_field(antenna, dx, dy, dz)


@overload(far_field, inline="never")
def _far_field_of(antenna, dx, dy, dz):  # noqa: ARG001  numba asks for the same signature
    if antenna.instance_class is PatternArrays:
        return lambda antenna, dx, dy, dz: _pattern_field(antenna, dx, dy, dz)  # noqa: PLW0108
    return lambda antenna, dx, dy, dz: _closed_form_field(antenna, dx, dy, dz)  # noqa: PLW0108


@kernel
def _closed_form_field(antenna, dx, dy, dz):
    c = dx * antenna.axis_x + dy * antenna.axis_y + dz * antenna.axis_z
    if antenna.kind == PATCH:
        return _patch_field(antenna, dx, dy, dz, c)
    if antenna.kind == CONICAL_PATCH:
        return _disc_field(antenna, dx, dy, dz, c)
    return wire_field(antenna, antenna.kind == ISOTROPIC_THETA, dx, dy, dz)


@kernel(forceinline=True)
def wire_field(antenna, even, dx, dy, dz):
    """Return the far field of a dipole, a monopole or, if ``even``, `ISOTROPIC_THETA`.

    Without a branch, and without what the other kind takes where ``even`` is a literal.
    """
    ax, ay, az = antenna.axis_x, antenna.axis_y, antenna.axis_z
    c = dx * ax + dy * ay + dz * az
    # The sine from the cross product keeps its digits near the axis, where 1 - c^2 loses them.
    sx, sy, sz = dy * az - dz * ay, dz * ax - dx * az, dx * ay - dy * ax
    sine = np.sqrt(sx * sx + sy * sy + sz * sz)
    on_axis = sine < 1e-12
    sine = 1.0 if on_axis else sine
    # cos(h c) - cos(h), without cancellation
    h = 0.5 * antenna.half_length_rad
    plus, _ = sine_cosine(h * (1.0 + c))
    minus, _ = sine_cosine(h * (1.0 - c))
    strength = 1.0 if even else antenna.amplitude * 2.0 * plus * minus / sine
    dark = on_axis | ((c < _HORIZON) & (antenna.kind == MONOPOLE))
    scale = 0.0 if dark else strength / sine
    # On the axis theta-hat depends on azimuth; azimuth 0 (or the y axis for a horizontal antenna
    # along x) is as good as any other.
    hx, hy = (1.0, 0.0) if abs(ax) < 0.5 else (0.0, 1.0)
    p = hx * ax + hy * ay
    hx, hy, hz = hx - p * ax, hy - p * ay, -p * az
    unit = 1.0 / np.sqrt(hx * hx + hy * hy + hz * hz)  # of all directions, so divided once
    there = (unit if on_axis & even else 0.0) * (1.0 if c > 0.0 else -1.0)
    return (
        scale * (c * dx - ax) + there * hx,
        scale * (c * dy - ay) + there * hy,
        scale * (c * dz - az) + there * hz,
    )


@kernel
def _disc_field(antenna, dx, dy, dz, c):
    """Return the field of a disc of which the rim radiates all around."""
    ax, ay, az = antenna.axis_x, antenna.axis_y, antenna.axis_z
    sx, sy, sz = dy * az - dz * ay, dz * ax - dx * az, dx * ay - dy * ax
    sine = np.sqrt(sx * sx + sy * sy + sz * sz)
    if c < _HORIZON or sine < 1e-12:
        return 0.0, 0.0, 0.0
    scale = antenna.amplitude * _bessel_1(antenna.half_length_rad * sine) / sine
    return scale * (c * dx - ax), scale * (c * dy - ay), scale * (c * dz - az)


@kernel
def _bessel_1(x):
    """Return the Bessel function J1 by its power series, which holds to 1e-14 up to x = 8."""
    quarter = 0.25 * x * x
    term = 0.5 * x
    total = term
    for k in range(1, 30):
        term *= -quarter / (k * (k + 1))
        total += term
    return total


@kernel
def _patch_field(antenna, dx, dy, dz, c):
    """Return the field of two in-phase magnetic slots across the resonant length."""
    if c < _HORIZON:
        return 0.0, 0.0, 0.0
    ax, ay, az = antenna.axis_x, antenna.axis_y, antenna.axis_z
    lx, ly, lz = antenna.side_x, antenna.side_y, antenna.side_z
    wx, wy, wz = ay * lz - az * ly, az * lx - ax * lz, ax * ly - ay * lx  # along the slots
    z = antenna.half_width_rad * (dx * wx + dy * wy + dz * wz)
    slot = np.sin(z) / z if abs(z) > 1e-8 else 1.0
    pair = np.cos(antenna.half_length_rad * (dx * lx + dy * ly + dz * lz))
    scale = antenna.amplitude * slot * pair
    return scale * (wy * dz - wz * dy), scale * (wz * dx - wx * dz), scale * (wx * dy - wy * dx)


@kernel
def _pattern_field(antenna, dx, dy, dz):
    """Return the field of a table, between its points cubic, or linear at steps."""
    ax, ay, az = antenna.axis_x, antenna.axis_y, antenna.axis_z
    ux, uy, uz = antenna.side_x, antenna.side_y, antenna.side_z
    vx, vy, vz = ay * uz - az * uy, az * ux - ax * uz, ax * uy - ay * ux
    x, y = dx * ux + dy * uy + dz * uz, dx * vx + dy * vy + dz * vz
    z = dx * ax + dy * ay + dz * az
    across = np.sqrt(x * x + y * y)
    cp, sp = (x / across, y / across) if across > 0.0 else (1.0, 0.0)
    table = antenna.table
    a = np.arctan2(across, z) / antenna.step_theta
    b = np.arctan2(sp, cp) / antenna.step_phi
    i, j = min(int(a), table.shape[0] - 2 * PAD - 2), int(np.floor(b))
    fraction = b - j
    j = j % (table.shape[1] - 2 * PAD)
    linear = antenna.linear[i, j]
    row, column = cell_weights(a - i, linear), cell_weights(fraction, linear)
    i += PAD - 1
    j += PAD - 1
    f_theta, f_phi = complex(0.0), complex(0.0)
    for p in range(4):
        for q in range(4):
            w = row[p] * column[q]
            f_theta += w * table[i + p, j + q, 0, 0]
            f_phi += w * table[i + p, j + q, 0, 1]
    # theta-hat = z (cp u + sp v) - across a, phi-hat = cp v - sp u
    on_u, on_v, on_a = (
        z * cp * f_theta - sp * f_phi,
        z * sp * f_theta + cp * f_phi,
        -across * f_theta,
    )
    return (
        on_u * ux + on_v * vx + on_a * ax,
        on_u * uy + on_v * vy + on_a * ay,
        on_u * uz + on_v * vz + on_a * az,
    )


@kernel
def fill_far_field(antenna, direction, out):
    """Fill (n, 3) far-field vectors for (n, 3) unit directions."""
    for i in range(len(direction)):
        x, y, z = far_field(antenna, direction[i, 0], direction[i, 1], direction[i, 2])
        out[i, 0] = x
        out[i, 1] = y
        out[i, 2] = z
