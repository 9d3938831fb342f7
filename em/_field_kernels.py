"""Compiled vector fields along a path: pattern, spreading, phase and every reflection."""

import numpy as np
from numba import njit

from octant.em._antenna_kernels import far_field
from octant.em._reflection_kernels import half_space, slab


@njit(cache=True, error_model="numpy")
def path_field(scene, antenna, points, facets, order):
    """Return the field that a path brings to a receiver, and how it gets there.

    ``points`` run from the receiver (row 0) over the reflections to the source (row order + 1),
    ``facets`` name the facet of each reflection in the same sense.

    Returns Ex, Ey, Ez (times lambda / 4 pi, so that the product with a receiving pattern is the
    complex gain), the unit vector of the last leg's direction of travel, and the length [m].
    """
    length = 0.0
    dx, dy, dz = 0.0, 0.0, 0.0
    ex, ey, ez = complex(0.0), complex(0.0), complex(0.0)
    started = False
    for leg in range(order, -1, -1):
        lx = points[leg, 0] - points[leg + 1, 0]
        ly = points[leg, 1] - points[leg + 1, 1]
        lz = points[leg, 2] - points[leg + 1, 2]
        size = np.sqrt(lx * lx + ly * ly + lz * lz)
        length += size
        # A leg without length (a path through a corner) has the direction of the mirrored line.
        if size > 0.0:
            gx, gy, gz = lx / size, ly / size, lz / size
        elif started:
            n = _normal(scene, facets[leg])
            c = 2.0 * (dx * n[0] + dy * n[1] + dz * n[2])
            gx, gy, gz = dx - c * n[0], dy - c * n[1], dz - c * n[2]
        else:
            gx, gy, gz = 0.0, 0.0, 1.0
        if not started:
            fx, fy, fz = far_field(antenna, gx, gy, gz)
            ex, ey, ez = complex(fx), complex(fy), complex(fz)
            started = True
        else:
            ex, ey, ez = _reflect(scene, facets[leg], dx, dy, dz, gx, gy, gz, ex, ey, ez)
        dx, dy, dz = gx, gy, gz
    k = 2.0 * np.pi / scene.wavelength
    factor = scene.wavelength / (4.0 * np.pi * length) * np.exp(-1j * k * length)
    return ex * factor, ey * factor, ez * factor, dx, dy, dz, length


@njit(cache=True, error_model="numpy")
def _normal(scene, facet):
    """Return the normal of a facet's plane, by bisection of the ascending facet starts."""
    lo, hi = 0, len(scene.plane_offset)
    while hi - lo > 1:
        middle = (lo + hi) // 2
        if scene.plane_facet_start[middle] <= facet:
            lo = middle
        else:
            hi = middle
    return scene.plane_normal[lo]


@njit(cache=True, error_model="numpy")
def _reflect(scene, facet, ix, iy, iz, rx, ry, rz, ex, ey, ez):
    """Return the field after a reflection, from directions in and out and the field before."""
    # The normal that the two directions imply: exact, and right for either side of a sheet.
    nx, ny, nz = rx - ix, ry - iy, rz - iz
    norm = np.sqrt(nx * nx + ny * ny + nz * nz)
    if norm < 1e-12:  # grazing: in and out agree, and the wall reflects -1
        return -ex, -ey, -ez
    cosine = 0.5 * norm
    nx, ny, nz = nx / norm, ny / norm, nz / norm
    thickness = scene.facet_thickness_wavelengths[facet]
    if np.isinf(thickness):
        te, tm = half_space(scene.facet_permittivity[facet], cosine)
    else:
        te, tm, _, _ = slab(scene.facet_permittivity[facet], cosine, thickness)
    sx, sy, sz = iy * nz - iz * ny, iz * nx - ix * nz, ix * ny - iy * nx
    norm = np.sqrt(sx * sx + sy * sy + sz * sz)
    if norm < 1e-9:  # along the normal: te = -tm, and any transverse direction is perpendicular
        return te * ex, te * ey, te * ez
    sx, sy, sz = sx / norm, sy / norm, sz / norm
    # Parallel directions s x d, in and out.
    px, py, pz = sy * iz - sz * iy, sz * ix - sx * iz, sx * iy - sy * ix
    qx, qy, qz = sy * rz - sz * ry, sz * rx - sx * rz, sx * ry - sy * rx
    across = te * (ex * sx + ey * sy + ez * sz)
    along = tm * (ex * px + ey * py + ez * pz)
    return across * sx + along * qx, across * sy + along * qy, across * sz + along * qz


@njit(cache=True, error_model="numpy", nogil=True)
def path_gains(scene, transmitter, receiver, order, vertices, facets, gain, length, directions):
    """Fill complex gain, length and the (departure, arrival) directions of recorded paths.

    Vertices run from the source to the receiver. The arrival direction points from the receiver
    to where the wave comes from.
    """
    width = vertices.shape[1]
    points = np.empty((width, 3))
    backwards = np.empty(max(width, 1), dtype=np.int64)
    for i in range(len(order)):
        n = order[i]
        for k in range(n + 2):
            points[k] = vertices[i, n + 1 - k]
        for k in range(n):
            backwards[k] = facets[i, n - 1 - k]
        ex, ey, ez, dx, dy, dz, total = path_field(scene, transmitter, points, backwards, n)
        fx, fy, fz = far_field(receiver, -dx, -dy, -dz)
        gain[i] = ex * fx + ey * fy + ez * fz
        length[i] = total
        size = 0.0
        for a in range(3):
            directions[i, 0, a] = vertices[i, 1, a] - vertices[i, 0, a]
            size += directions[i, 0, a] ** 2
        for a in range(3):
            directions[i, 0, a] /= np.sqrt(size)
        directions[i, 1, 0] = -dx
        directions[i, 1, 1] = -dy
        directions[i, 1, 2] = -dz
