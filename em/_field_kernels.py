# mypy: allow-untyped-defs
"""Compiled vector fields along paths: pattern, spreading, phase and every interaction."""

import numpy as np
from numba import njit

from octant.em._antenna_kernels import far_field
from octant.em._diffraction_kernels import diffract, diffract_twice
from octant.em._reflection_kernels import displaced_air, wall
from octant.em._transmission_kernels import TRANSMISSION


@njit(cache=True, error_model="numpy")
def wall_frame(nx, ny, nz, ix, iy, iz):
    """Return the unit vector across the plane of incidence of a wave that travels along i."""
    sx, sy, sz = iy * nz - iz * ny, iz * nx - ix * nz, ix * ny - iy * nx
    sine = np.sqrt(sx * sx + sy * sy + sz * sz)
    if sine >= 1e-9:
        return sx / sine, sy / sine, sz / sine
    # Along the normal TE and TM are one (r_te = -r_tm), so any transverse direction will do.
    if abs(nx) < 0.7:
        sx, sy, sz = 0.0, -nz, ny
    else:
        sx, sy, sz = nz, 0.0, -nx
    sine = np.sqrt(sx * sx + sy * sy + sz * sz)
    return sx / sine, sy / sine, sz / sine


@njit(cache=True, error_model="numpy", inline="always")
def _reflect(permittivity, thickness, begin, end, front, nx, ny, nz, ix, iy, iz, ex, ey, ez):
    """Return the field after a reflection, from the wall's normal and the direction before.

    Returns the field and the direction after it. Either side of a sheet may be hit.
    """
    cosine = -(ix * nx + iy * ny + iz * nz)
    from_front = front == (cosine >= 0.0)
    if cosine < 0.0:
        nx, ny, nz, cosine = -nx, -ny, -nz, -cosine
    rx, ry, rz = ix + 2.0 * cosine * nx, iy + 2.0 * cosine * ny, iz + 2.0 * cosine * nz
    te, tm, _, _ = wall(permittivity, thickness, begin, end, cosine, from_front)
    sx, sy, sz = wall_frame(nx, ny, nz, ix, iy, iz)
    # Parallel directions s x d, in and out.
    px, py, pz = sy * iz - sz * iy, sz * ix - sx * iz, sx * iy - sy * ix
    qx, qy, qz = sy * rz - sz * ry, sz * rx - sx * rz, sx * ry - sy * rx
    across = te * (ex * sx + ey * sy + ez * sz)
    along = tm * (ex * px + ey * py + ez * pz)
    ex, ey, ez = across * sx + along * qx, across * sy + along * qy, across * sz + along * qz
    return ex, ey, ez, rx, ry, rz


@njit(cache=True, error_model="numpy")
def _transmit(permittivity, thickness, begin, end, front, nx, ny, nz, ix, iy, iz, ex, ey, ez):
    """Return the field behind a sheet, which stands in place of the air along its normal."""
    cosine = -(ix * nx + iy * ny + iz * nz)
    from_front = front == (cosine >= 0.0)
    if cosine < 0.0:
        nx, ny, nz, cosine = -nx, -ny, -nz, -cosine
    _, _, te, tm = wall(permittivity, thickness, begin, end, cosine, from_front)
    air = displaced_air(thickness, begin, end, cosine)
    sx, sy, sz = wall_frame(nx, ny, nz, ix, iy, iz)
    px, py, pz = sy * iz - sz * iy, sz * ix - sx * iz, sx * iy - sy * ix
    across = air * te * (ex * sx + ey * sy + ez * sz)
    along = air * tm * (ex * px + ey * py + ez * pz)
    return across * sx + along * px, across * sy + along * py, across * sz + along * pz


@njit(cache=True, error_model="numpy")
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
    """
    wavenumber = 2.0 * np.pi / wavelength
    for p in range(count):
        order = orders[p]
        # Lengths before, between and after the edges.
        length, first, second = 0.0, 0.0, 0.0
        edges = 0
        for leg in range(order, -1, -1):
            lx = points[p, leg, 0] - points[p, leg + 1, 0]
            ly = points[p, leg, 1] - points[p, leg + 1, 1]
            lz = points[p, leg, 2] - points[p, leg + 1, 2]
            size = np.sqrt(lx * lx + ly * ly + lz * lz)
            if leg == order:
                dx, dy, dz = lx / size, ly / size, lz / size
            length += size
            if leg > 0 and facets[p, leg - 1] < 0:
                if edges == 0:
                    first = length
                else:
                    second = length - first
                edges += 1
        # From here on the direction is turned by each wall's normal, not taken from vertices, which
        # nearly coincide where a path runs through a corner.
        fx, fy, fz = far_field(antenna, dx, dy, dz)
        ex, ey, ez = complex(fx), complex(fy), complex(fz)
        leg = order
        while leg > 0:
            leg -= 1
            code = facets[p, leg]
            if code < 0:
                ox, oy, oz = _towards(points, p, leg)
                if edges == 1:
                    after = length - first
                    ex, ey, ez = diffract(
                        wedge_utd,
                        wedge_faces,
                        permittivity,
                        thickness,
                        -1 - code,
                        wavenumber,
                        tolerance,
                        first,
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
                    dx, dy, dz = ox, oy, oz
                    continue
                last = leg - 1
                after = length - first - second
                qx, qy, qz = _towards(points, p, last)
                ex, ey, ez = diffract_twice(
                    wedge_utd,
                    wedge_faces,
                    permittivity,
                    thickness,
                    -1 - code,
                    -1 - facets[p, last],
                    True,
                    wavenumber,
                    tolerance,
                    first,
                    second,
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
                dx, dy, dz = qx, qy, qz
                leg = last
                continue
            facet = code - TRANSMISSION if code >= TRANSMISSION else code
            plane = facet_plane[facet]
            nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
            begin, end, front = facet_layers[facet, 0], facet_layers[facet, 1], facet_front[facet]
            if code >= TRANSMISSION:
                ex, ey, ez = _transmit(
                    permittivity,
                    thickness,
                    begin,
                    end,
                    front,
                    nx,
                    ny,
                    nz,
                    dx,
                    dy,
                    dz,
                    ex,
                    ey,
                    ez,
                )
            else:
                ex, ey, ez, dx, dy, dz = _reflect(
                    permittivity,
                    thickness,
                    begin,
                    end,
                    front,
                    nx,
                    ny,
                    nz,
                    dx,
                    dy,
                    dz,
                    ex,
                    ey,
                    ez,
                )
        if edges == 0:
            spread = length
        elif edges == 1:
            spread = np.sqrt(first * (length - first) * length)
        else:
            spread = np.sqrt(first * second * (length - first - second) * length)
        phase = wavenumber * length
        scale = wavelength / (4.0 * np.pi * spread)
        factor = complex(scale * np.cos(phase), -scale * np.sin(phase))
        field[p, 0] = ex * factor
        field[p, 1] = ey * factor
        field[p, 2] = ez * factor
        direction[p, 0] = dx
        direction[p, 1] = dy
        direction[p, 2] = dz


@njit(cache=True, error_model="numpy")
def _towards(points, p, leg):
    """Return the unit direction from an interaction to the next one towards the receiver."""
    ox = points[p, leg, 0] - points[p, leg + 1, 0]
    oy = points[p, leg, 1] - points[p, leg + 1, 1]
    oz = points[p, leg, 2] - points[p, leg + 1, 2]
    size = np.sqrt(ox * ox + oy * oy + oz * oz)
    return ox / size, oy / size, oz / size


@njit(cache=True, error_model="numpy", forceinline=True)
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


@njit(cache=True, error_model="numpy", nogil=True)
def path_gains(scene, transmitter, receiver, order, vertices, codes, gain, directions):
    """Fill complex gains and the (departure, arrival) directions of recorded paths.

    Vertices run from the source to the receiver. The arrival direction points from the receiver
    to where the wave comes from.
    """
    width = vertices.shape[1]
    points = np.empty((1, width, 3))
    backwards = np.empty((1, width), dtype=np.int64)
    field = np.empty((1, 3), dtype=np.complex128)
    direction = np.empty((1, 3))
    one = np.empty(1, dtype=np.int64)
    for i in range(len(order)):
        n = order[i]
        one[0] = n
        for k in range(n + 2):
            for a in range(3):
                points[0, k, a] = vertices[i, n + 1 - k, a]
        for k in range(n):
            backwards[0, k] = codes[i, n - 1 - k]
        fields_in_scene(scene, transmitter, 1, points, backwards, one, field, direction)
        fx, fy, fz = far_field(receiver, -direction[0, 0], -direction[0, 1], -direction[0, 2])
        gain[i] = field[0, 0] * fx + field[0, 1] * fy + field[0, 2] * fz
        size = 0.0
        for a in range(3):
            directions[i, 0, a] = vertices[i, 1, a] - vertices[i, 0, a]
            size += directions[i, 0, a] ** 2
        for a in range(3):
            directions[i, 0, a] /= np.sqrt(size)
            directions[i, 1, a] = -direction[0, a]
