# mypy: allow-untyped-defs
"""Compiled vector fields along paths: pattern, spreading, phase and every interaction."""

import numpy as np

from octant.em.antennas._antenna_kernels import far_field
from octant.em.fields._diffraction_kernels import along_edge, diffract, diffract_twice
from octant.em.fields._wave_kernels import (
    DX,
    DY,
    DZ,
    LENGTH,
    SIZE,
    SPREAD,
    TI,
    TR,
    WIDTH,
    XI,
    XR,
    YI,
    YR,
    ZI,
    ZR,
    far_fields,
    gather_walls,
    meet_walls,
    reflect_any_walls,
    reflect_half_spaces,
    travel,
)
from octant.em.paths._path_kernels import path_rows
from octant.em.records import TRANSMISSION
from octant.geometries._array_kernels import at
from octant.geometries._wedge_kernels import one_facet
from octant.geometries.kernels import kernel

_FACETS = 7  # first of the two columns of an edge's frame that hold its facets

SHORT = 1e3
"""Length [tolerances of the scene] up to which a leg is too short to have a direction."""


@kernel(forceinline=True)
def field_rows(rows):
    """Return fields and directions (rows, 3) of paths, of which components stand together."""
    return np.empty((3, rows), dtype=np.complex128).T, np.empty((3, rows)).T


@kernel(returns="none")
def path_fields(
    antenna,
    planes,
    facet_plane,
    facet_layers,
    facet_front,
    permittivity,
    thickness,
    wedge_utd,
    wedge_faces,
    tolerance,
    wavelength,
    count,
    points,
    facets,
    orders,
    field,
    direction,
):
    """Fill the field that each of ``count`` paths brings to its receiver, and how it travels there.

    Row by row, ``points`` run from the receiver over the interactions to the source, and ``facets``
    name the facet or wedge of each interaction in the same sense. The field is times lambda / 4 pi,
    so that its product with a receiving pattern is the complex gain; the direction is the last
    leg's.

    Neighbouring paths of one order are worked out side by side, one over an edge by itself.
    """
    wavenumber = 2.0 * np.pi / wavelength
    state = np.empty(SIZE)
    begin = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
    while begin < count:
        order = orders[begin]
        last = begin + 1
        if not _has_edge(wedge_utd, facets, begin, order):
            while (
                last < count
                and last < begin + WIDTH
                and orders[last] == order
                and not _has_edge(wedge_utd, facets, last, order)
            ):
                last += 1
        width = last - begin
        for i in range(width):
            p = at(begin, i)
            lx = points[p, order, 0] - points[p, order + 1, 0]
            ly = points[p, order, 1] - points[p, order + 1, 1]
            lz = points[p, order, 2] - points[p, order + 1, 2]
            length = np.sqrt(lx * lx + ly * ly + lz * lz)
            scale = 1.0 / length
            # From here on the direction is turned by each wall's normal, not taken from vertices,
            # which nearly coincide where a path runs through a corner. Between edges a leg's length
            # is its projection on that direction.
            state[DX + i], state[DY + i], state[DZ + i] = scale * lx, scale * ly, scale * lz
            state[LENGTH + i] = length
        far_fields(antenna, state, width)
        before, between, after, edges = _edge_lengths(wedge_utd, points, facets, begin, order)
        leg, known = order, np.int64(0)
        while leg > 0:
            leg -= 1
            if facets[begin, leg] < 0:
                leg = _bend(
                    planes,
                    facet_plane,
                    wedge_utd,
                    wedge_faces,
                    permittivity,
                    thickness,
                    wavenumber,
                    tolerance,
                    before,
                    between,
                    after,
                    edges,
                    points,
                    facets,
                    begin,
                    leg,
                    state,
                )
                continue
            simple = gather_walls(
                planes,
                facet_plane,
                facet_layers,
                permittivity,
                thickness,
                points,
                facets,
                begin,
                leg,
                width,
                state,
            )
            known = reflect_half_spaces(state, width, known)
            if not simple:
                reflect_any_walls(
                    facet_layers,
                    facet_front,
                    permittivity,
                    thickness,
                    facets,
                    begin,
                    leg,
                    width,
                    state,
                )
            meet_walls(state, width)
        for i in range(width):
            state[SPREAD + i] = state[LENGTH + i]
        if edges == 1:
            state[SPREAD] = np.sqrt(before * after * (before + after))
            state[LENGTH] = before + after
        elif edges == 2:
            length = before + between + after
            state[SPREAD] = np.sqrt(before * between * after * length)
            state[LENGTH] = length
        travel(state, width, wavenumber, wavelength / (4.0 * np.pi))
        for a in range(3):
            for i in range(width):
                p = at(begin, i)
                field[p, a] = complex(state[XR + a * WIDTH + i], state[XI + a * WIDTH + i])
                direction[p, a] = state[DX + a * WIDTH + i]
        begin = last


@kernel(forceinline=True)
def _has_edge(wedge_utd, facets, p, order):
    """Return whether a path bends at an edge."""
    if len(wedge_utd) > 0:
        for leg in range(order):
            if facets[p, leg] < 0:
                return True
    return False


@kernel(forceinline=True)
def _edge_lengths(wedge_utd, points, facets, p, order):
    """Return the lengths of a path before, between and behind its edges [m], and their number."""
    before, between, length, edges = 0.0, 0.0, 0.0, 0
    if len(wedge_utd) == 0:
        return before, between, length, edges
    for leg in range(order, -1, -1):
        lx = points[p, leg, 0] - points[p, leg + 1, 0]
        ly = points[p, leg, 1] - points[p, leg + 1, 1]
        lz = points[p, leg, 2] - points[p, leg + 1, 2]
        length += np.sqrt(lx * lx + ly * ly + lz * lz)
        if leg > 0 and facets[p, leg - 1] < 0:
            if edges == 0:
                before = length
            else:
                between = length - before
            edges += 1
    return before, between, length - before - between, edges


@kernel(returns="int64")
def _bend(
    planes,
    facet_plane,
    wedge_utd,
    wedge_faces,
    permittivity,
    thickness,
    wavenumber,
    tolerance,
    before,
    between,
    after,
    edges,
    points,
    facets,
    p,
    leg,
    state,
):
    """Turn the one path in the state at its edge, or at both; return the leg that it leaves by."""
    ex = complex(state[XR], state[XI])
    ey = complex(state[YR], state[YI])
    ez = complex(state[ZR], state[ZI])
    dx, dy, dz = state[DX], state[DY], state[DZ]
    ox, oy, oz = leaving(planes, facet_plane, tolerance, points, facets, p, leg)
    if edges == 1:
        ex, ey, ez = diffract(
            wedge_utd,
            wedge_faces,
            permittivity,
            thickness,
            -1 - facets[p, leg],
            wavenumber,
            tolerance,
            along_edge(wedge_utd, -1 - facets[p, leg], points[p, leg + 1]),
            before,
            after,
            dx,
            dy,
            dz,
            ox,
            oy,
            oz,
            ex,
            ey,
            ez,
        )
    else:
        qx, qy, qz = leaving(planes, facet_plane, tolerance, points, facets, p, leg - 1)
        ex, ey, ez = diffract_twice(
            wedge_utd,
            wedge_faces,
            permittivity,
            thickness,
            -1 - facets[p, leg],
            -1 - facets[p, leg - 1],
            one_facet(wedge_utd[:, _FACETS:], -1 - facets[p, leg], -1 - facets[p, leg - 1]),
            wavenumber,
            tolerance,
            along_edge(wedge_utd, -1 - facets[p, leg], points[p, leg + 1]),
            along_edge(wedge_utd, -1 - facets[p, leg - 1], points[p, leg]),
            before,
            between,
            after,
            dx,
            dy,
            dz,
            ox,
            oy,
            oz,
            qx,
            qy,
            qz,
            ex,
            ey,
            ez,
        )
        ox, oy, oz = qx, qy, qz
        leg -= 1
    state[XR], state[YR], state[ZR] = ex.real, ey.real, ez.real
    state[XI], state[YI], state[ZI] = ex.imag, ey.imag, ez.imag
    state[DX], state[DY], state[DZ] = ox, oy, oz
    return leg


@kernel
def leaving(planes, facet_plane, tolerance, points, facets, p, leg):
    """Return the unit direction in which a path leaves an interaction towards the receiver.

    A leg too short for its direction takes the next one's, mirrored back by what reflects between.
    """
    ox, oy, oz, size = 0.0, 0.0, 0.0, 0.0
    behind = leg + 1
    while behind > 0 and size <= SHORT * tolerance:
        behind -= 1
        ox = points[p, behind, 0] - points[p, behind + 1, 0]
        oy = points[p, behind, 1] - points[p, behind + 1, 1]
        oz = points[p, behind, 2] - points[p, behind + 1, 2]
        size = np.sqrt(ox * ox + oy * oy + oz * oz)
    if size == 0.0:
        return 0.0, 0.0, 0.0
    ox, oy, oz = ox / size, oy / size, oz / size
    for v in range(behind + 1, leg + 1):
        code = facets[p, v - 1]
        if 0 <= code < TRANSMISSION:
            plane = facet_plane[code]
            nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
            twice = 2.0 * (nx * ox + ny * oy + nz * oz)
            ox, oy, oz = ox - twice * nx, oy - twice * ny, oz - twice * nz
    return ox, oy, oz


@kernel(forceinline=True)
def fields_in_scene(scene, antenna, count, points, facets, orders, field, direction):
    """Fill the fields of ``count`` paths in a scene, see :func:`path_fields`."""
    path_fields(
        antenna,
        scene.planes,
        scene.facet_plane,
        scene.facet_layers,
        scene.facet_front,
        scene.layer_permittivity,
        scene.layer_thickness,
        scene.wedge_utd,
        scene.wedge_faces,
        scene.tolerance,
        scene.wavelength,
        count,
        points,
        facets,
        orders,
        field,
        direction,
    )


@kernel
def receive(antenna, begin, count, field, direction, state):
    """Fill real and imaginary parts of the gains of up to `WIDTH` paths, in the rows `TR`, `TI`.

    ``field`` and ``direction`` are what `path_fields` filled, from the row ``begin`` on.
    """
    for i in range(count):
        p = at(begin, i)
        state[DX + i], state[DY + i] = -direction[p, 0], -direction[p, 1]
        state[DZ + i] = -direction[p, 2]
    far_fields(antenna, state, count)
    for i in range(count):
        p = at(begin, i)
        gain = (
            field[p, 0] * complex(state[XR + i], state[XI + i])
            + field[p, 1] * complex(state[YR + i], state[YI + i])
            + field[p, 2] * complex(state[ZR + i], state[ZI + i])
        )
        state[TR + i], state[TI + i] = gain.real, gain.imag


@kernel(nogil=True)
def path_gains(scene, transmitter, receiver, order, vertices, codes, gain, directions):
    """Fill complex gains and the (departure, arrival) directions of recorded paths.

    Vertices run from the source to the receiver. The arrival direction points from the receiver
    to where the wave comes from.
    """
    width = vertices.shape[1]
    points, backwards = path_rows(np.int64(1), width - 2)
    field, direction = field_rows(np.int64(1))
    one = np.empty(1, dtype=np.int64)
    for i in range(len(order)):
        n = order[i]
        one[0] = n
        for k in range(n + 2):
            for a in range(3):
                points[0, k, a] = vertices[i, n + 1 - k, a]
        for k in range(n):
            backwards[0, k] = codes[i, n - 1 - k]
        fields_in_scene(scene, transmitter, np.int64(1), points, backwards, one, field, direction)
        fx, fy, fz = far_field(receiver, -direction[0, 0], -direction[0, 1], -direction[0, 2])
        gain[i] = field[0, 0] * fx + field[0, 1] * fy + field[0, 2] * fz
        size = 0.0
        for a in range(3):
            directions[i, 0, a] = vertices[i, 1, a] - vertices[i, 0, a]
            size += directions[i, 0, a] ** 2
        for a in range(3):
            directions[i, 0, a] /= np.sqrt(size)
            directions[i, 1, a] = -direction[0, a]
