# mypy: allow-untyped-defs
"""Compiled vector fields along paths: pattern, spreading, phase and every reflection."""

import numpy as np
from numba import njit

from octant.em._antenna_kernels import far_field
from octant.em._reflection_kernels import half_space, slab


@njit(cache=True, error_model="numpy")
def _reflect(permittivity, thickness, nx, ny, nz, ix, iy, iz, ex, ey, ez):
    """Return the field after a reflection, from the wall's normal and the direction before.

    Returns the field and the direction after it. Either side of a sheet may be hit.
    """
    cosine = -(ix * nx + iy * ny + iz * nz)
    if cosine < 0.0:
        nx, ny, nz, cosine = -nx, -ny, -nz, -cosine
    rx, ry, rz = ix + 2.0 * cosine * nx, iy + 2.0 * cosine * ny, iz + 2.0 * cosine * nz
    if np.isinf(thickness):
        te, tm = half_space(permittivity, cosine)
    else:
        te, tm, _, _ = slab(permittivity, cosine, thickness)
    sx, sy, sz = iy * nz - iz * ny, iz * nx - ix * nz, ix * ny - iy * nx
    sine = np.sqrt(sx * sx + sy * sy + sz * sz)
    if sine < 1e-9:  # along the normal: te = -tm, and any transverse direction is perpendicular
        return te * ex, te * ey, te * ez, rx, ry, rz
    sx, sy, sz = sx / sine, sy / sine, sz / sine
    # Parallel directions s x d, in and out.
    px, py, pz = sy * iz - sz * iy, sz * ix - sx * iz, sx * iy - sy * ix
    qx, qy, qz = sy * rz - sz * ry, sz * rx - sx * rz, sx * ry - sy * rx
    across = te * (ex * sx + ey * sy + ez * sz)
    along = tm * (ex * px + ey * py + ez * pz)
    ex, ey, ez = across * sx + along * qx, across * sy + along * qy, across * sz + along * qz
    return ex, ey, ez, rx, ry, rz


@njit(cache=True, error_model="numpy")
def path_fields(
    antenna,
    planes,
    facet_plane,
    permittivity,
    thickness,
    wavelength,
    count,
    points,
    facets,
    orders,
    field,
    direction,
):
    """Fill the field that each of ``count`` paths brings to its receiver, and how it travels there.

    Row by row, ``points`` run from the receiver over the reflections to the source, and ``facets``
    name the facet of each reflection in the same sense. The field is times lambda / 4 pi, so that
    its product with a receiving pattern is the complex gain; the direction is the last leg's.
    """
    for p in range(count):
        order = orders[p]
        length = 0.0
        for leg in range(order + 1):
            lx = points[p, leg, 0] - points[p, leg + 1, 0]
            ly = points[p, leg, 1] - points[p, leg + 1, 1]
            lz = points[p, leg, 2] - points[p, leg + 1, 2]
            size = np.sqrt(lx * lx + ly * ly + lz * lz)
            length += size
        # From here on the direction is turned by each wall's normal, not taken from vertices, which
        # nearly coincide where a path runs through a corner.
        dx, dy, dz = lx / size, ly / size, lz / size
        fx, fy, fz = far_field(antenna, dx, dy, dz)
        ex, ey, ez = complex(fx), complex(fy), complex(fz)
        for leg in range(order - 1, -1, -1):
            facet = facets[p, leg]
            plane = facet_plane[facet]
            ex, ey, ez, dx, dy, dz = _reflect(
                permittivity[facet],
                thickness[facet],
                planes[plane, 0],
                planes[plane, 1],
                planes[plane, 2],
                dx,
                dy,
                dz,
                ex,
                ey,
                ez,
            )
        phase = 2.0 * np.pi / wavelength * length
        scale = wavelength / (4.0 * np.pi * length)
        factor = complex(scale * np.cos(phase), -scale * np.sin(phase))
        field[p, 0] = ex * factor
        field[p, 1] = ey * factor
        field[p, 2] = ez * factor
        direction[p, 0] = dx
        direction[p, 1] = dy
        direction[p, 2] = dz


@njit(cache=True, error_model="numpy", nogil=True)
def path_gains(scene, transmitter, receiver, order, vertices, facets, gain, directions):
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
            backwards[0, k] = facets[i, n - 1 - k]
        path_fields(
            transmitter,
            scene.planes,
            scene.facet_plane,
            scene.facet_permittivity,
            scene.facet_thickness,
            scene.wavelength,
            1,
            points,
            backwards,
            one,
            field,
            direction,
        )
        fx, fy, fz = far_field(receiver, -direction[0, 0], -direction[0, 1], -direction[0, 2])
        gain[i] = field[0, 0] * fx + field[0, 1] * fy + field[0, 2] * fz
        size = 0.0
        for a in range(3):
            directions[i, 0, a] = vertices[i, 1, a] - vertices[i, 0, a]
            size += directions[i, 0, a] ** 2
        for a in range(3):
            directions[i, 0, a] /= np.sqrt(size)
            directions[i, 1, a] = -direction[0, a]
