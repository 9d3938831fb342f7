# mypy: allow-untyped-defs
"""Compiled waves side by side: many paths' fields meet their walls and travel on at once."""

from typing import Any

import numpy as np
from numba.extending import overload

from octant.em.antennas._antenna_kernels import (
    DIPOLE,
    ISOTROPIC_THETA,
    MONOPOLE,
    far_field,
    wire_field,
)
from octant.em.antennas._phase_kernels import sine_cosine
from octant.em.medium._reflection_kernels import displaced_air, half_space, wall
from octant.em.records import TRANSMISSION, PatternArrays
from octant.geometries._array_kernels import at
from octant.geometries.kernels import kernel

WIDTH = 64
"""Paths whose fields are worked out side by side: what they need fits the first-level cache."""

# Rows of WIDTH numbers in the state of the paths that are worked out side by side. One array with
# rows at fixed distances, since only then the compiler sees that they do not overlap, and computes
# several paths at once.
DX, DY, DZ = 0 * WIDTH, 1 * WIDTH, 2 * WIDTH  # direction of travel
XR, YR, ZR = 3 * WIDTH, 4 * WIDTH, 5 * WIDTH  # field, real part
XI, YI, ZI = 6 * WIDTH, 7 * WIDTH, 8 * WIDTH  # field, imaginary part
NX, NY, NZ = 9 * WIDTH, 10 * WIDTH, 11 * WIDTH  # normal of the wall that is met
LX, LY, LZ = 12 * WIDTH, 13 * WIDTH, 14 * WIDTH  # the leg behind it [m]
ER, EI = 15 * WIDTH, 16 * WIDTH  # its permittivity, where it is a half-space
TR, TI, UR, UI = 17 * WIDTH, 18 * WIDTH, 19 * WIDTH, 20 * WIDTH  # its coefficients, TE and TM
THROUGH = 21 * WIDTH  # 1 where the wave passes, 0 where it is reflected
ALONG = 22 * WIDTH  # direction times normal
LENGTH, SPREAD = 23 * WIDTH, 24 * WIDTH  # [m]
KNOWN = 25 * WIDTH  # what is kept of walls met before, KEPT rows each
KEPT, WALLS = 7, 3
SIZE = KNOWN + WALLS * KEPT * WIDTH


def far_fields(antenna: Any, state: Any, count: Any) -> None:
    """Fill the far fields of an antenna towards the state's directions."""
    if isinstance(antenna, PatternArrays):
        _pattern_fields(antenna, state, count)
    else:
        _closed_form_fields(antenna, state, count)


@overload(far_fields, inline="never")
def _far_fields_of(antenna, state, count):  # noqa: ARG001  numba asks for the same signature
    if antenna.instance_class is PatternArrays:
        return lambda antenna, state, count: _pattern_fields(antenna, state, count)  # noqa: PLW0108
    return lambda antenna, state, count: _closed_form_fields(antenna, state, count)  # noqa: PLW0108


@kernel
def _closed_form_fields(antenna, state, count):
    wire, even = antenna.kind in (DIPOLE, MONOPOLE), antenna.kind == ISOTROPIC_THETA
    for i in range(count if wire else 0):
        x, y, z = wire_field(antenna, False, state[DX + i], state[DY + i], state[DZ + i])
        state[XR + i], state[YR + i], state[ZR + i] = x, y, z
        state[XI + i], state[YI + i], state[ZI + i] = 0.0, 0.0, 0.0
    for i in range(count if even else 0):
        x, y, z = wire_field(antenna, True, state[DX + i], state[DY + i], state[DZ + i])
        state[XR + i], state[YR + i], state[ZR + i] = x, y, z
        state[XI + i], state[YI + i], state[ZI + i] = 0.0, 0.0, 0.0
    for i in range(0 if wire or even else count):
        x, y, z = far_field(antenna, state[DX + i], state[DY + i], state[DZ + i])
        state[XR + i], state[YR + i], state[ZR + i] = x, y, z
        state[XI + i], state[YI + i], state[ZI + i] = 0.0, 0.0, 0.0


@kernel
def _pattern_fields(antenna, state, count):
    for i in range(count):
        x, y, z = far_field(antenna, state[DX + i], state[DY + i], state[DZ + i])
        state[XR + i], state[YR + i], state[ZR + i] = x.real, y.real, z.real
        state[XI + i], state[YI + i], state[ZI + i] = x.imag, y.imag, z.imag


@kernel
def reflect_half_spaces(state, count, known):
    """Fill the coefficients of half-spaces: see :mod:`octant.em.medium._reflection_kernels`.

    Parallel walls of one material, as floor and ceiling, have the same: those of the first
    ``known`` walls are kept. Returned is how many are now.
    """
    for i in range(count):
        along = (
            state[DX + i] * state[NX + i]
            + state[DY + i] * state[NY + i]
            + state[DZ + i] * state[NZ + i]
        )
        state[ALONG + i] = along
    for wall_before in range(known):
        row = KNOWN + wall_before * KEPT * WIDTH
        if state[row] != abs(state[ALONG]):
            continue
        different = 0
        for i in range(count):
            other = (
                (abs(state[ALONG + i]) != state[at(row, i)])
                | (state[ER + i] != state[at(row + WIDTH, i)])
                | (state[EI + i] != state[at(row + 2 * WIDTH, i)])
            )
            different += 1 if other else 0
        if different == 0:
            for i in range(count):
                state[TR + i] = state[at(row + 3 * WIDTH, i)]
                state[TI + i] = state[at(row + 4 * WIDTH, i)]
                state[UR + i] = state[at(row + 5 * WIDTH, i)]
                state[UI + i] = state[at(row + 6 * WIDTH, i)]
            return known
    for i in range(count):
        te, tm = half_space(complex(state[ER + i], state[EI + i]), abs(state[ALONG + i]))
        state[TR + i], state[TI + i] = te.real, te.imag
        state[UR + i], state[UI + i] = tm.real, tm.imag
    if known == WALLS:
        return known
    row = KNOWN + known * KEPT * WIDTH
    for i in range(count):
        state[at(row, i)] = abs(state[ALONG + i])
        state[at(row + WIDTH, i)] = state[ER + i]
        state[at(row + 2 * WIDTH, i)] = state[EI + i]
        state[at(row + 3 * WIDTH, i)] = state[TR + i]
        state[at(row + 4 * WIDTH, i)] = state[TI + i]
        state[at(row + 5 * WIDTH, i)] = state[UR + i]
        state[at(row + 6 * WIDTH, i)] = state[UI + i]
    return known + 1


@kernel
def meet_walls(state, count):
    """Turn directions and fields by the walls' coefficients, and walk the legs behind them.

    A reflected field is that of a perfect conductor, m = 2 n (n . e) - e, times TM; its TE part,
    s (s . m) / sin^2 with s = d x n, is times -TE instead. A field that passes is e times TM, its
    TE part times TE. Towards normal incidence TE parts have no direction, but TE + TM (or TE - TM
    of what passes) vanishes as sin^2 there, so that no case is needed.
    """
    for i in range(count):
        dx, dy, dz = state[DX + i], state[DY + i], state[DZ + i]
        nx, ny, nz = state[NX + i], state[NY + i], state[NZ + i]
        xr, yr, zr = state[XR + i], state[YR + i], state[ZR + i]
        xi, yi, zi = state[XI + i], state[YI + i], state[ZI + i]
        tr, ti, ur, ui = state[TR + i], state[TI + i], state[UR + i], state[UI + i]
        sx, sy, sz = dy * nz - dz * ny, dz * nx - dx * nz, dx * ny - dy * nx
        through = state[THROUGH + i] > 0.0
        twice = 0.0 if through else 2.0
        sign = 1.0 if through else -1.0
        re = twice * (nx * xr + ny * yr + nz * zr)
        im = twice * (nx * xi + ny * yi + nz * zi)
        xr, yr, zr = nx * re + sign * xr, ny * re + sign * yr, nz * re + sign * zr
        xi, yi, zi = nx * im + sign * xi, ny * im + sign * yi, nz * im + sign * zi
        bend = twice * state[ALONG + i]
        dx, dy, dz = dx - bend * nx, dy - bend * ny, dz - bend * nz
        # TE x sign - TM, times the field along s over sin^2.
        scale = 1.0 / max(sx * sx + sy * sy + sz * sz, 1e-300)
        re, im = scale * (sx * xr + sy * yr + sz * zr), scale * (sx * xi + sy * yi + sz * zi)
        lr, li = sign * tr - ur, sign * ti - ui
        lr, li = lr * re - li * im, lr * im + li * re
        state[XR + i], state[XI + i] = ur * xr - ui * xi + lr * sx, ur * xi + ui * xr + li * sx
        state[YR + i], state[YI + i] = ur * yr - ui * yi + lr * sy, ur * yi + ui * yr + li * sy
        state[ZR + i], state[ZI + i] = ur * zr - ui * zi + lr * sz, ur * zi + ui * zr + li * sz
        state[DX + i], state[DY + i], state[DZ + i] = dx, dy, dz
        state[LENGTH + i] += dx * state[LX + i] + dy * state[LY + i] + dz * state[LZ + i]


@kernel
def travel(state, count, wavenumber, scale):
    """Multiply the fields by the phase of their length and by ``scale`` over their spreading."""
    for i in range(count):
        sine, cosine = sine_cosine(wavenumber * state[LENGTH + i])
        size = scale / state[SPREAD + i]
        re, im = size * cosine, -size * sine
        xr, yr, zr = state[XR + i], state[YR + i], state[ZR + i]
        xi, yi, zi = state[XI + i], state[YI + i], state[ZI + i]
        state[XR + i], state[XI + i] = xr * re - xi * im, xr * im + xi * re
        state[YR + i], state[YI + i] = yr * re - yi * im, yr * im + yi * re
        state[ZR + i], state[ZI + i] = zr * re - zi * im, zr * im + zi * re


@kernel
def _gather_wall(planes, facet_plane, facet_layers, permittivity, code, count, state):
    """Fill the wall that all paths meet."""
    facet = code % TRANSMISSION
    plane, through = facet_plane[facet], 1.0 if code >= TRANSMISSION else 0.0
    nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
    eps_r = permittivity[facet_layers[facet, 0]]
    for i in range(count):
        state[NX + i], state[NY + i], state[NZ + i] = nx, ny, nz
        state[THROUGH + i] = through
        state[ER + i], state[EI + i] = eps_r.real, eps_r.imag


@kernel
def gather_walls(
    planes,
    facet_plane,
    facet_layers,
    permittivity,
    thickness,
    points,
    facets,
    first,
    leg,
    count,
    state,
):
    """Fill the walls that ``count`` paths meet at a leg; return whether all are half-spaces."""
    code, different = facets[first, leg], 0
    for i in range(count):
        p = at(first, i)
        state[LX + i] = points[p, leg, 0] - points[p, leg + 1, 0]
        state[LY + i] = points[p, leg, 1] - points[p, leg + 1, 1]
        state[LZ + i] = points[p, leg, 2] - points[p, leg + 1, 2]
    for i in range(count):
        different |= facets[at(first, i), leg] ^ code
    if different == 0:
        _gather_wall(planes, facet_plane, facet_layers, permittivity, code, count, state)
        begin, end = facet_layers[code % TRANSMISSION, 0], facet_layers[code % TRANSMISSION, 1]
        return end - begin == 1 and thickness[begin] == np.inf
    simple = True
    for i in range(count):
        code = facets[at(first, i), leg]
        passes = code >= TRANSMISSION
        facet = code - TRANSMISSION if passes else code
        plane = facet_plane[facet]
        state[NX + i] = planes[plane, 0]
        state[NY + i] = planes[plane, 1]
        state[NZ + i] = planes[plane, 2]
        state[THROUGH + i] = 1.0 if passes else 0.0
        begin, end = facet_layers[facet, 0], facet_layers[facet, 1]
        simple &= end - begin == 1 and thickness[begin] == np.inf
        state[ER + i] = permittivity[begin].real
        state[EI + i] = permittivity[begin].imag
    return simple


@kernel(returns="none")
def reflect_any_walls(
    facet_layers, facet_front, permittivity, thickness, facets, first, leg, count, state
):
    """Fill the coefficients of walls of any layers, for reflection or for what passes."""
    for i in range(count):
        along = state[ALONG + i]
        code = facets[first + i, leg]
        facet = code - TRANSMISSION if code >= TRANSMISSION else code
        begin, end = facet_layers[facet, 0], facet_layers[facet, 1]
        # Either side of a sheet may be hit; TE and TM do not care which way the normal points.
        from_front = facet_front[facet] == (along <= 0.0)
        te, tm, te_out, tm_out = wall(permittivity, thickness, begin, end, abs(along), from_front)
        if code >= TRANSMISSION:
            # The sheet stands in place of the air along its normal.
            air = displaced_air(thickness, begin, end, abs(along))
            te, tm = air * te_out, air * tm_out
        state[TR + i], state[TI + i] = te.real, te.imag
        state[UR + i], state[UI + i] = tm.real, tm.imag
