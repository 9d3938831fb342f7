# mypy: allow-untyped-defs
"""Compiled interactions of near triangles, the singular part of the potential in closed form."""

import numpy as np

from octant.em.reader.fullwave._phase_kernels import cosine_sine, logarithms
from octant.geometries.kernels import kernel

LANES = 48
"""Points integrated side by side: those of the rule for triangles that touch [-]."""

# Where rows of lanes begin: points of the outer triangle from its centroid, their weights, places
# and heights over the inner one, its potential and that times places, and scratch.
A = 0
W = 3 * LANES
P = W + LANES
FLAT = P + 3 * LANES
POTENTIAL = FLAT + LANES
M = POTENTIAL + LANES
X = M + 3 * LANES
Y = X + LANES
T0 = Y + LANES
LM = T0 + LANES
LP = LM + LANES
R0 = LP + LANES
RM = R0 + LANES
RP = RM + LANES
ALL_ROWS = RP // LANES + 1


@kernel(nogil=True, forceinline=True)
def _is_near(tri, p, q, near):
    """Return whether q is near to p, unless both move alike."""
    if tri.motion[p] >= 0 and tri.motion[p] == tri.motion[q]:
        return False
    dx = tri.place[p, 0] - tri.place[q, 0]
    dy = tri.place[p, 1] - tri.place[q, 1]
    dz = tri.place[p, 2] - tri.place[q, 2]
    reach = near * (tri.radius[p] + tri.radius[q])
    return dx * dx + dy * dy + dz * dz < reach * reach


@kernel(nogil=True)
def near_counts(tri, near, counts):
    """Count, for each triangle p of the first sector, its near triangles q with q0 >= p."""
    for p in range(tri.per_sector):
        total = 0
        for s in range(tri.sectors):
            for q0 in range(p, tri.per_sector):
                if _is_near(tri, p, s * tri.per_sector + q0, near):
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
                if _is_near(tri, p, q, near):
                    found[at] = q
                    at += 1


@kernel(nogil=True)
def _fill_points(tri, p, touching, s):
    """Put points (from the centroid) and weights of a triangle's rule in lanes; return how many.

    Seven points are eight lanes, the last of no weight.
    """
    if not touching:
        for a in range(8):
            b = min(a, 6)
            s[A + a], s[A + LANES + a], s[A + 2 * LANES + a] = (
                tri.points[p, b, 0],
                tri.points[p, b, 1],
                tri.points[p, b, 2],
            )
            s[W + a] = tri.weight[a] if a < 7 else 0.0
        return 8
    for a in range(LANES):
        s[W + a] = tri.close_weight[a]
        for c in range(3):
            s[A + c * LANES + a] = (
                tri.close[a, 0] * tri.offset[p, 0, c]
                + tri.close[a, 1] * tri.offset[p, 1, c]
                + tri.close[a, 2] * tri.offset[p, 2, c]
            )
    return LANES


@kernel(nogil=True)
def _fill_smooth(tri, p, q, wavenumber, number, s, moments):
    """Fill the moments of the smooth rest (exp(-jkR) - 1) / R, of seven points of q.

    It has a kink at R = 0.
    """
    dx = tri.centre[p, 0] - tri.centre[q, 0]
    dy = tri.centre[p, 1] - tri.centre[q, 1]
    dz = tri.centre[p, 2] - tri.centre[q, 2]
    moments[:] = 0.0
    for b in range(7):
        bx, by, bz = tri.points[q, b, 0], tri.points[q, b, 1], tri.points[q, b, 2]
        for a in range(number):
            ox = dx + s[A + a] - bx
            oy = dy + s[A + LANES + a] - by
            oz = dz + s[A + 2 * LANES + a] - bz
            r = np.sqrt(ox * ox + oy * oy + oz * oz)
            w = s[W + a] * tri.weight[b]
            cosine, sine = cosine_sine(0.5 * wavenumber * r)
            apart = wavenumber * r >= 1e-9
            over = (-2.0 * w) * sine / (r if apart else 1.0)
            s[X + a] = over * sine if apart else 0.0
            s[Y + a] = over * cosine if apart else -wavenumber * w
        gr = gi = ur = ui = vr = vi = wr = wi = 0.0
        for a in range(number):
            er, ei = s[X + a], s[Y + a]
            gr += er
            gi += ei
            ur += er * s[A + a]
            ui += ei * s[A + a]
            vr += er * s[A + LANES + a]
            vi += ei * s[A + LANES + a]
            wr += er * s[A + 2 * LANES + a]
            wi += ei * s[A + 2 * LANES + a]
        _add_moments(moments, 0, gr, ur, vr, wr, gr * bx, gr * by, gr * bz)
        _add_moments(moments, 8, gi, ui, vi, wi, gi * bx, gi * by, gi * bz)
        moments[7] += bx * ur + by * vr + bz * wr
        moments[15] += bx * ui + by * vi + bz * wi


@kernel(nogil=True)
def _add_moments(moments, at, g, ux, uy, uz, vx, vy, vz):
    """Add <g>, <u g>, <v g> to the moments from ``at`` on."""
    moments[at] += g
    moments[at + 1] += ux
    moments[at + 2] += uy
    moments[at + 3] += uz
    moments[at + 4] += vx
    moments[at + 5] += vy
    moments[at + 6] += vz


@kernel(nogil=True)
def _project(tri, outer, inner, number, s):
    """Put the points' projections onto the inner plane, from its centroid, and heights in lanes.

    Return the unit normal.
    """
    ax, ay, az = tri.corner[inner, 0, 0], tri.corner[inner, 0, 1], tri.corner[inner, 0, 2]
    ux = tri.corner[inner, 1, 0] - ax
    uy = tri.corner[inner, 1, 1] - ay
    uz = tri.corner[inner, 1, 2] - az
    vx = tri.corner[inner, 2, 0] - ax
    vy = tri.corner[inner, 2, 1] - ay
    vz = tri.corner[inner, 2, 2] - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    norm = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx * norm, ny * norm, nz * norm
    cx = tri.centre[outer, 0] - tri.centre[inner, 0]
    cy = tri.centre[outer, 1] - tri.centre[inner, 1]
    cz = tri.centre[outer, 2] - tri.centre[inner, 2]
    fx, fy, fz = tri.offset[inner, 0, 0], tri.offset[inner, 0, 1], tri.offset[inner, 0, 2]
    for a in range(number):
        px, py, pz = cx + s[A + a], cy + s[A + LANES + a], cz + s[A + 2 * LANES + a]
        height = (px - fx) * nx + (py - fy) * ny + (pz - fz) * nz
        s[P + a] = px - height * nx
        s[P + LANES + a] = py - height * ny
        s[P + 2 * LANES + a] = pz - height * nz
        s[FLAT + a] = abs(height)
        s[POTENTIAL + a] = 0.0
        s[M + a] = s[M + LANES + a] = s[M + 2 * LANES + a] = 0.0
    return nx, ny, nz


@kernel(nogil=True)
def _add_edge(tri, inner, edge, normal, number, s, bits):
    """Add what one edge gives to the potentials of the inner triangle at the points in lanes."""
    nx, ny, nz = normal
    g, h = edge, (edge + 1) % 3
    ex, ey, ez = tri.offset[inner, g, 0], tri.offset[inner, g, 1], tri.offset[inner, g, 2]
    tx = tri.offset[inner, h, 0] - ex
    ty = tri.offset[inner, h, 1] - ey
    tz = tri.offset[inner, h, 2] - ez
    length = np.sqrt(tx * tx + ty * ty + tz * tz)
    tx, ty, tz = tx / length, ty / length, tz / length
    # outward in the plane: along x normal
    ox, oy, oz = ty * nz - tz * ny, tz * nx - tx * nz, tx * ny - ty * nx
    for a in range(number):
        gx, gy, gz = ex - s[P + a], ey - s[P + LANES + a], ez - s[P + 2 * LANES + a]
        t0 = gx * ox + gy * oy + gz * oz
        lm = gx * tx + gy * ty + gz * tz
        lp = lm + length
        r0 = t0 * t0 + s[FLAT + a] * s[FLAT + a]
        rm = np.sqrt(lm * lm + r0)
        rp = np.sqrt(lp * lp + r0)
        ahead = lm + lp >= 0.0
        top = rp + lp if ahead else rm - lm
        bottom = rm + lm if ahead else rp - lp
        some = bottom > 1e-14 * top
        s[X + a] = top / bottom if some else 1.0
        s[T0 + a], s[LM + a], s[LP + a] = t0, lm, lp
        s[R0 + a], s[RM + a], s[RP + a] = r0, rm, rp
    logarithms(s[X:], bits[X:], s[Y:], number)
    for a in range(number):
        t0, r0 = s[T0 + a], s[R0 + a]
        s[POTENTIAL + a] += t0 * s[X + a]
        w = 0.5 * (r0 * s[X + a] + s[LP + a] * s[RP + a] - s[LM + a] * s[RM + a])
        s[M + a] += w * ox
        s[M + LANES + a] += w * oy
        s[M + 2 * LANES + a] += w * oz
    for a in range(number):
        flat = s[FLAT + a]
        if flat > 1e-12 * s[RP + a]:
            s[POTENTIAL + a] -= flat * (
                np.arctan(s[T0 + a] * s[LP + a] / (s[R0 + a] + flat * s[RP + a]))
                - np.arctan(s[T0 + a] * s[LM + a] / (s[R0 + a] + flat * s[RM + a]))
            )


@kernel(nogil=True)
def _add_singular(tri, outer, inner, swapped, number, s, bits, moments):
    """Add the moments of 1/R in closed form over the inner triangle, by points over the outer.

    Half of them, as this is the mean of both orders; ``swapped`` when the inner one is p.
    """
    normal = _project(tri, outer, inner, number, s)
    for edge in range(3):
        _add_edge(tri, inner, edge, normal, number, s, bits)
    share = 0.5 / tri.area[inner]
    g = ux = uy = uz = vx = vy = vz = dot = 0.0
    for a in range(number):
        w = s[W + a] * share
        ax, ay, az = s[A + a], s[A + LANES + a], s[A + 2 * LANES + a]
        potential = s[POTENTIAL + a]
        mx = s[M + a] + s[P + a] * potential
        my = s[M + LANES + a] + s[P + LANES + a] * potential
        mz = s[M + 2 * LANES + a] + s[P + 2 * LANES + a] * potential
        g += w * potential
        ux += w * potential * ax
        uy += w * potential * ay
        uz += w * potential * az
        vx += w * mx
        vy += w * my
        vz += w * mz
        dot += w * (ax * mx + ay * my + az * mz)
    if swapped:
        _add_moments(moments, 0, g, vx, vy, vz, ux, uy, uz)
    else:
        _add_moments(moments, 0, g, ux, uy, uz, vx, vy, vz)
    moments[7] += dot


@kernel(nogil=True)
def _near_moments(tri, p, q, wavenumber, close, s, bits, moments):
    """Fill the 16 moments of a near pair: <g>, <u g>, <v g>, <u.v g>, and imaginary parts."""
    dx = tri.place[p, 0] - tri.place[q, 0]
    dy = tri.place[p, 1] - tri.place[q, 1]
    dz = tri.place[p, 2] - tri.place[q, 2]
    reach = close * (tri.radius[p] + tri.radius[q])
    touching = dx * dx + dy * dy + dz * dz < reach * reach
    number = _fill_points(tri, p, p == q, s)
    _fill_smooth(tri, p, q, wavenumber, number, s, moments)
    number = _fill_points(tri, p, touching, s)
    _add_singular(tri, p, q, False, number, s, bits, moments)
    number = _fill_points(tri, q, touching, s)
    _add_singular(tri, q, p, True, number, s, bits, moments)


@kernel(nogil=True)
def add_near(
    tri, fun, rows, begin, end, near_start, near_list, wavenumber, close, vector, scalar, sheet, z
):
    """Add the near pairs of the triangles rows[begin:end] to z, with 1/R integrated in closed form.

    The closed form runs once over either triangle, a rule of points over the other: that of
    triangles that touch when their centroids are nearer than ``close`` times the sum of radii, else
    seven points. The mean of both keeps the matrix symmetric. Points stand side by side in lanes.
    ``sheet`` (f,) is the surface impedance.
    """
    count, sectors, offset, length = tri.per_sector, tri.sectors, tri.offset, tri.length
    start, function, turn, local, sign = fun
    k = np.empty((3, 3), dtype=np.complex128)
    s = np.zeros(ALL_ROWS * LANES)
    bits = s.view(np.int64)
    moments = np.empty(16)
    for index in range(begin, end):
        p = rows[index]
        for at in range(near_start[p], near_start[p + 1]):
            q = near_list[at]
            q0 = q % count
            part = q // count
            _near_moments(tri, p, q, wavenumber, close, s, bits, moments)
            gr, ur, vr, wr = moments[0], moments[1], moments[2], moments[3]
            xr, yr, zr, dr = moments[4], moments[5], moments[6], moments[7]
            gi, ui, vi, wi = moments[8], moments[9], moments[10], moments[11]
            xi, yi, zi, di = moments[12], moments[13], moments[14], moments[15]
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
                        value += sheet[p] * ((spread + dot) / (4.0 * tri.area[p]))
                    k[i, j] = (half * length[p, i] * length[q, j]) * value
            for e in range(start[p], start[p + 1]):
                m, shift, i, se = function[e], part - turn[e], local[e], sign[e]
                for f in range(start[q0], start[q0 + 1]):
                    d = shift + turn[f]
                    if d < 0:
                        d += sectors
                    elif d >= sectors:
                        d -= sectors
                    z[m, d, function[f]] += (se * sign[f]) * k[i, local[f]]
