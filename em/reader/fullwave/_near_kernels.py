# mypy: allow-untyped-defs
"""Compiled interactions of near triangles, the singular part of the potential in closed form."""

import numpy as np

from octant.geometries.kernels import kernel


@kernel(nogil=True)
def near_counts(tri, near, counts):
    """Count, for each triangle p of the first sector, its near triangles q with q0 >= p."""
    for p in range(tri.per_sector):
        total = 0
        for s in range(tri.sectors):
            for q0 in range(p, tri.per_sector):
                q = s * tri.per_sector + q0
                dx = tri.centre[p, 0] - tri.centre[q, 0]
                dy = tri.centre[p, 1] - tri.centre[q, 1]
                dz = tri.centre[p, 2] - tri.centre[q, 2]
                reach = near * (tri.radius[p] + tri.radius[q])
                if dx * dx + dy * dy + dz * dz < reach * reach:
                    total += 1
        counts[p] = total


@kernel(nogil=True)
def near_lists(tri, near, start, found):
    """Fill the near triangles that ``near_counts`` counted."""
    for p in range(tri.per_sector):
        at = start[p]
        for s in range(tri.sectors):
            for q0 in range(p, tri.per_sector):
                q = s * tri.per_sector + q0
                dx = tri.centre[p, 0] - tri.centre[q, 0]
                dy = tri.centre[p, 1] - tri.centre[q, 1]
                dz = tri.centre[p, 2] - tri.centre[q, 2]
                reach = near * (tri.radius[p] + tri.radius[q])
                if dx * dx + dy * dy + dz * dz < reach * reach:
                    found[at] = q
                    at += 1


@kernel(nogil=True)
def _fill_points(tri, p, touching, place, share):
    """Fill the points (from the centroid) and weights of a triangle's rule; return their number."""
    if not touching:
        for a in range(7):
            share[a] = tri.weight[a]
            for c in range(3):
                place[a, c] = tri.points[p, a, c]
        return 7
    for a in range(len(tri.close)):
        share[a] = tri.close_weight[a]
        for c in range(3):
            place[a, c] = (
                tri.close[a, 0] * tri.offset[p, 0, c]
                + tri.close[a, 1] * tri.offset[p, 1, c]
                + tri.close[a, 2] * tri.offset[p, 2, c]
            )
    return len(tri.close)


@kernel(nogil=True)
def add_near(
    tri, fun, rows, begin, end, near_start, near_list, wavenumber, close, vector, scalar, sheet, z
):
    """Add the near pairs of the triangles rows[begin:end] to z, with 1/R integrated in closed form.

    The closed form runs once over either triangle, a rule of points over the other: that of
    triangles that touch when their centroids are nearer than ``close`` times the sum of radii, else
    seven points. The mean of both keeps the matrix symmetric. ``sheet`` (f,) is the surface
    impedance.
    """
    count, sectors = tri.per_sector, tri.sectors
    corner, centre, offset, length, area = tri.corner, tri.centre, tri.offset, tri.length, tri.area
    seven, w7 = tri.points, tri.weight
    start, function, turn, local, sign = fun
    k = np.empty((3, 3), dtype=np.complex128)
    place = np.empty((len(tri.close), 3))
    share_at = np.empty(len(tri.close))
    for index in range(begin, end):
        p = rows[index]
        for at in range(near_start[p], near_start[p + 1]):
            q = near_list[at]
            q0 = q % count
            s = q // count
            gr = gi = 0.0
            ur = vr = wr = 0.0
            ui = vi = wi = 0.0
            xr = yr = zr = 0.0
            xi = yi = zi = 0.0
            dr = di = 0.0
            dx = centre[p, 0] - centre[q, 0]
            dy = centre[p, 1] - centre[q, 1]
            dz = centre[p, 2] - centre[q, 2]
            reach = close * (tri.radius[p] + tri.radius[q])
            touching = dx * dx + dy * dy + dz * dz < reach * reach
            number = _fill_points(tri, p, p == q, place, share_at)
            for a in range(number):  # the smooth rest (exp(-jkR) - 1) / R; it has a kink at R = 0
                ax, ay, az = place[a, 0], place[a, 1], place[a, 2]
                for b in range(7):
                    bx, by, bz = seven[q, b, 0], seven[q, b, 1], seven[q, b, 2]
                    ox, oy, oz = dx + ax - bx, dy + ay - by, dz + az - bz
                    r = np.sqrt(ox * ox + oy * oy + oz * oz)
                    w = share_at[a] * w7[b]
                    if wavenumber * r < 1e-9:
                        er, ei = 0.0, -wavenumber * w
                    else:
                        sine = np.sin(0.5 * wavenumber * r)
                        er = -2.0 * w * sine * sine / r
                        ei = -w * np.sin(wavenumber * r) / r
                    gr += er
                    gi += ei
                    ur += er * ax
                    vr += er * ay
                    wr += er * az
                    ui += ei * ax
                    vi += ei * ay
                    wi += ei * az
                    xr += er * bx
                    yr += er * by
                    zr += er * bz
                    xi += ei * bx
                    yi += ei * by
                    zi += ei * bz
                    dot = ax * bx + ay * by + az * bz
                    dr += er * dot
                    di += ei * dot
            for side in range(2):
                if side == 0:
                    outer, inner = p, q
                else:
                    outer, inner = q, p
                # unit normal of the inner triangle
                e1x = corner[inner, 1, 0] - corner[inner, 0, 0]
                e1y = corner[inner, 1, 1] - corner[inner, 0, 1]
                e1z = corner[inner, 1, 2] - corner[inner, 0, 2]
                e2x = corner[inner, 2, 0] - corner[inner, 0, 0]
                e2y = corner[inner, 2, 1] - corner[inner, 0, 1]
                e2z = corner[inner, 2, 2] - corner[inner, 0, 2]
                nx = e1y * e2z - e1z * e2y
                ny = e1z * e2x - e1x * e2z
                nz = e1x * e2y - e1y * e2x
                norm = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
                nx *= norm
                ny *= norm
                nz *= norm
                share = 0.5 / area[inner]
                number = _fill_points(tri, outer, touching, place, share_at)
                for a in range(number):
                    ax, ay, az = place[a, 0], place[a, 1], place[a, 2]
                    px = centre[outer, 0] + ax
                    py = centre[outer, 1] + ay
                    pz = centre[outer, 2] + az
                    height = (
                        (px - corner[inner, 0, 0]) * nx
                        + (py - corner[inner, 0, 1]) * ny
                        + (pz - corner[inner, 0, 2]) * nz
                    )
                    flat = abs(height)
                    # the point's projection onto the inner plane
                    px -= height * nx
                    py -= height * ny
                    pz -= height * nz
                    potential = 0.0
                    mx = my = mz = 0.0
                    for edge in range(3):
                        g, h = edge, (edge + 1) % 3
                        gx = corner[inner, g, 0] - px
                        gy = corner[inner, g, 1] - py
                        gz = corner[inner, g, 2] - pz
                        hx = corner[inner, h, 0] - px
                        hy = corner[inner, h, 1] - py
                        hz = corner[inner, h, 2] - pz
                        tx, ty, tz = hx - gx, hy - gy, hz - gz
                        norm = 1.0 / np.sqrt(tx * tx + ty * ty + tz * tz)
                        tx *= norm
                        ty *= norm
                        tz *= norm
                        # outward in the plane: along x normal
                        ox = ty * nz - tz * ny
                        oy = tz * nx - tx * nz
                        oz = tx * ny - ty * nx
                        t0 = gx * ox + gy * oy + gz * oz
                        lm = gx * tx + gy * ty + gz * tz
                        lp = hx * tx + hy * ty + hz * tz
                        r0 = t0 * t0 + flat * flat
                        rm = np.sqrt(lm * lm + r0)
                        rp = np.sqrt(lp * lp + r0)
                        if lm + lp >= 0.0:
                            top, bottom = rp + lp, rm + lm
                        else:
                            top, bottom = rm - lm, rp - lp
                        logarithm = 0.0
                        if bottom > 1e-14 * top:
                            logarithm = np.log(top / bottom)
                        potential += t0 * logarithm
                        if flat > 1e-12 * rp:
                            potential -= flat * (
                                np.arctan(t0 * lp / (r0 + flat * rp))
                                - np.arctan(t0 * lm / (r0 + flat * rm))
                            )
                        w = 0.5 * (r0 * logarithm + lp * rp - lm * rm)
                        mx += w * ox
                        my += w * oy
                        mz += w * oz
                    mx += (px - centre[inner, 0]) * potential
                    my += (py - centre[inner, 1]) * potential
                    mz += (pz - centre[inner, 2]) * potential
                    w = share_at[a] * share
                    gr += w * potential
                    dr += w * (ax * mx + ay * my + az * mz)
                    if side == 0:
                        ur += w * potential * ax
                        vr += w * potential * ay
                        wr += w * potential * az
                        xr += w * mx
                        yr += w * my
                        zr += w * mz
                    else:
                        xr += w * potential * ax
                        yr += w * potential * ay
                        zr += w * potential * az
                        ur += w * mx
                        vr += w * my
                        wr += w * mz
            half = 0.5 if q0 == p else 1.0
            spread = 0.0
            if p == q:
                for i in range(3):
                    for c in range(3):
                        spread += offset[p, i, c] * offset[p, i, c] / 12.0
            for i in range(3):
                ax, ay, az = offset[p, i, 0], offset[p, i, 1], offset[p, i, 2]
                pr = dr - (ax * xr + ay * yr + az * zr)
                pi = di - (ax * xi + ay * yi + az * zi)
                lr, mr, nr = ur - ax * gr, vr - ay * gr, wr - az * gr
                li, mi, ni = ui - ax * gi, vi - ay * gi, wi - az * gi
                for j in range(3):
                    bx, by, bz = offset[q, j, 0], offset[q, j, 1], offset[q, j, 2]
                    re = pr - (bx * lr + by * mr + bz * nr)
                    im = pi - (bx * li + by * mi + bz * ni)
                    value = vector * complex(re, im) + scalar * complex(gr, gi)
                    if p == q:
                        dot = ax * bx + ay * by + az * bz
                        value += sheet[p] * ((spread + dot) / (4.0 * area[p]))
                    k[i, j] = (half * length[p, i] * length[q, j]) * value
            for e in range(start[p], start[p + 1]):
                m, shift, i, se = function[e], s - turn[e], local[e], sign[e]
                for f in range(start[q0], start[q0 + 1]):
                    d = shift + turn[f]
                    if d < 0:
                        d += sectors
                    elif d >= sectors:
                        d -= sectors
                    z[m, d, function[f]] += (se * sign[f]) * k[i, local[f]]
