# mypy: allow-untyped-defs
"""Compiled interactions of triangles: moments of the Green function, scattered to functions.

A pair of triangles (p, q) has eight moments of g = exp(-jkR)/R, means over both triangles with
places u, v counted from the centroids: <g>, <u g>, <v g>, <u.v g>. They give all nine interactions
of the pair's half-functions l/(2A) (r - corner).

Rows are owned: the caller hands out triangles of one colour, which share no row, so that threads
never meet and the sum in every entry runs in one order. Hot loops stay in one function on purpose:
a call with array arguments costs more than a quadrature point.
"""

from typing import NamedTuple

import numpy as np

from octant.geometries.kernels import kernel

C4, C6, C8, C10 = 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800  # Taylor's, of the cosine
S3, S5, S7, S9, S11 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800  # and the sine


class TriangleArrays(NamedTuple):
    """All triangles of a mesh for the kernels; sector by sector."""

    per_sector: int
    sectors: int
    corner: np.ndarray  # (f, 3, 3) [m]
    centre: np.ndarray  # (f, 3) [m]
    radius: np.ndarray  # (f,) greatest distance of a corner from the centroid [m]
    area: np.ndarray  # (f,) [m^2]
    offset: np.ndarray  # (f, 3, 3) corners less centroid [m]
    length: np.ndarray  # (f, 3) length of the edge opposite each corner [m]
    points: np.ndarray  # (f, 10, 3) of the 7-point and the 3-point rule, less centroid [m]
    weight: np.ndarray  # (10,) of sum 1 in the 7-point rule, of 1 each in the 3-point rule
    close: np.ndarray  # (c, 3) barycentric points of the rule for triangles that touch
    close_weight: np.ndarray  # (c,) of sum 1


class FunctionArrays(NamedTuple):
    """Half-functions of the first sector's triangles: which function, turned how far, sign."""

    start: np.ndarray  # (per_sector + 1,)
    function: np.ndarray  # (e,)
    turn: np.ndarray  # (e,)
    local: np.ndarray  # (e,) corner opposite the edge
    sign: np.ndarray  # (e,)


@kernel(nogil=True)
def add_far(tri, fun, rows, begin, end, wavenumber, near, mid, vector, scalar, z):
    """Add pairs of the triangles rows[begin:end] with all that are not near to z (m, sector, n).

    ``vector`` and ``scalar`` are j w mu / (16 pi) and 1 / (4 pi j w eps).
    """
    count, sectors = tri.per_sector, tri.sectors
    centre, radius, offset, length = tri.centre, tri.radius, tri.offset, tri.length
    points, weight = tri.points, tri.weight
    start, function, turn, local, sign = fun
    third = 1.0 / 3.0
    k = np.empty((3, 3), dtype=np.complex128)
    for index in range(begin, end):
        p = rows[index]
        cx, cy, cz, rp = centre[p, 0], centre[p, 1], centre[p, 2], radius[p]
        for s in range(sectors):
            for q0 in range(p, count):
                q = s * count + q0
                dx, dy, dz = cx - centre[q, 0], cy - centre[q, 1], cz - centre[q, 2]
                square = dx * dx + dy * dy + dz * dz
                reach = rp + radius[q]
                if square < near * near * reach * reach:
                    continue
                gr = gi = 0.0
                ur = vr = wr = 0.0  # <u g>
                ui = vi = wi = 0.0
                xr = yr = zr = 0.0  # <v g>
                xi = yi = zi = 0.0
                dr = di = 0.0
                # exp(-jkR) about the distance of the centroids: the rest is below k (rp + rq).
                far = np.sqrt(square)
                c0, s0 = np.cos(wavenumber * far), np.sin(wavenumber * far)
                direct = wavenumber * reach > 0.9
                # Points 0 to 6 are the 7-point rule, the others the 3-point rule.
                first, last, share = 7, 10, third * third
                if square < mid * mid * reach * reach:
                    first, last, share = 0, 7, 1.0
                for a in range(first, last):
                    ax, ay, az = points[p, a, 0], points[p, a, 1], points[p, a, 2]
                    ex, ey, ez = dx + ax, dy + ay, dz + az
                    tr = ti = 0.0
                    fx = fy = fz = 0.0
                    hx = hy = hz = 0.0
                    for b in range(first, last):
                        bx, by, bz = points[q, b, 0], points[q, b, 1], points[q, b, 2]
                        ox, oy, oz = ex - bx, ey - by, ez - bz
                        r = np.sqrt(ox * ox + oy * oy + oz * oz)
                        w = weight[b] / r
                        if direct:
                            er = np.cos(wavenumber * r) * w
                            ei = -np.sin(wavenumber * r) * w
                        else:
                            x = wavenumber * (r - far)
                            t = x * x
                            co = 1.0 + t * (-0.5 + t * (C4 + t * (C6 + t * (C8 + t * C10))))
                            si = 1.0 + t * (S3 + t * (S5 + t * (S7 + t * (S9 + t * S11))))
                            si *= x
                            er = (c0 * co - s0 * si) * w
                            ei = -(s0 * co + c0 * si) * w
                        tr += er
                        ti += ei
                        fx += er * bx
                        fy += er * by
                        fz += er * bz
                        hx += ei * bx
                        hy += ei * by
                        hz += ei * bz
                    w = weight[a]
                    gr += w * tr
                    gi += w * ti
                    ur += w * tr * ax
                    vr += w * tr * ay
                    wr += w * tr * az
                    ui += w * ti * ax
                    vi += w * ti * ay
                    wi += w * ti * az
                    xr += w * fx
                    yr += w * fy
                    zr += w * fz
                    xi += w * hx
                    yi += w * hy
                    zi += w * hz
                    dr += w * (ax * fx + ay * fy + az * fz)
                    di += w * (ax * hx + ay * hy + az * hz)
                gr, gi = gr * share, gi * share
                ur, vr, wr = ur * share, vr * share, wr * share
                ui, vi, wi = ui * share, vi * share, wi * share
                xr, yr, zr = xr * share, yr * share, zr * share
                xi, yi, zi = xi * share, yi * share, zi * share
                dr, di = dr * share, di * share
                half = 0.5 if q0 == p else 1.0
                for i in range(3):
                    ax, ay, az = offset[p, i, 0], offset[p, i, 1], offset[p, i, 2]
                    # <(u - a).(v - b) g> = part without b, less b . (<u g> - a <g>)
                    pr = dr - (ax * xr + ay * yr + az * zr)
                    pi = di - (ax * xi + ay * yi + az * zi)
                    lr, mr, nr = ur - ax * gr, vr - ay * gr, wr - az * gr
                    li, mi, ni = ui - ax * gi, vi - ay * gi, wi - az * gi
                    for j in range(3):
                        bx, by, bz = offset[q, j, 0], offset[q, j, 1], offset[q, j, 2]
                        re = pr - (bx * lr + by * mr + bz * nr)
                        im = pi - (bx * li + by * mi + bz * ni)
                        k[i, j] = (half * length[p, i] * length[q, j]) * (
                            vector * complex(re, im) + scalar * complex(gr, gi)
                        )
                for e in range(start[p], start[p + 1]):
                    m, shift, i, se = function[e], s - turn[e], local[e], sign[e]
                    for f in range(start[q0], start[q0 + 1]):
                        d = shift + turn[f]
                        if d < 0:
                            d += sectors
                        elif d >= sectors:
                            d -= sectors
                        z[m, d, function[f]] += (se * sign[f]) * k[i, local[f]]


@kernel(nogil=True)
def add_mirror(z, tile, begin, end):
    """Add to z[m, d, n] its partner z[n, -d, m], for the tiles of rows begin to end.

    A pair of tiles is done by the one of the lower number, so no two calls touch one entry.
    """
    size, sectors = z.shape[0], z.shape[1]
    tiles = (size + tile - 1) // tile
    for upper in range(begin, end):
        for lower in range(upper, tiles):
            for d in range(sectors):
                other = (sectors - d) % sectors
                for m in range(upper * tile, min(size, upper * tile + tile)):
                    for n in range(lower * tile, min(size, lower * tile + tile)):
                        if upper == lower and (n < m or (n == m and other < d)):
                            continue
                        value = z[m, d, n] + z[n, other, m]
                        z[m, d, n] = value
                        z[n, other, m] = value
