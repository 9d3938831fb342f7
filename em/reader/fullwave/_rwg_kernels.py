# mypy: allow-untyped-defs
"""Compiled interactions of triangles: moments of the Green function, scattered to functions.

A pair of triangles (p, q) has eight moments of g = exp(-jkR)/R, means over both triangles with
places u, v counted from the centroids: <g>, <u g>, <v g>, <u.v g>. They give all nine interactions
of the pair's half-functions l/(2A) (r - corner).

Rows are owned: the caller hands out triangles of one colour, which share no row, so that threads
never meet and the sum in every entry runs in one order.
"""

from typing import NamedTuple

import numpy as np

from octant.em.reader.fullwave._phase_kernels import (
    C4,
    C6,
    C8,
    C10,
    C12,
    S3,
    S5,
    S7,
    S9,
    S11,
    S13,
    cosine_sine,
)
from octant.geometries.kernels import kernel

NINTH = 1 / 9

MOST_BY_SERIES = 1.3
"""Phase over two triangles' radii [rad] up to which the series above are taken: off by 5e-10 there,
by 1e-12 at 0.85."""

LANES = 32
"""Triangles integrated side by side [-]."""

# Where rows of lanes begin: difference of centroids, its length, points, edges and corners of q,
# scratch, moments <g>, <u g>, <v g>, <u.v g> and their imaginary
# parts, interactions.
D = 0
FAR = 3 * LANES
POINTS = FAR + LANES
LENGTHS = POINTS + 21 * LANES
CORNERS = LENGTHS + 3 * LANES
T = CORNERS + 9 * LANES
G = T + 8 * LANES
U = G + LANES
V = U + 3 * LANES
UV = V + 3 * LANES
PART = 8 * LANES
K = G + 2 * PART
ALL_ROWS = K // LANES + 18


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
    place: np.ndarray  # (f, 3) centroids whose distances decide how a pair is integrated [m]
    motion: np.ndarray  # (f,) two of one number, 0 or more, are left out; -1 never


class FunctionArrays(NamedTuple):
    """Half-functions of the first sector's triangles: which function, turned how far, sign."""

    start: np.ndarray  # (per_sector + 1,)
    function: np.ndarray  # (e,)
    turn: np.ndarray  # (e,)
    local: np.ndarray  # (e,) corner opposite the edge
    sign: np.ndarray  # (e,)


@kernel(nogil=True)
def _sort_pairs(tri, p, wavenumber, near, mid, chosen, number):
    """Sort the triangles q with q0 >= p that are not near to p by the way that they are integrated.

    Rows of ``chosen``: three points or seven, each with phases by a series or by sine and cosine.
    """
    number[:] = 0
    for s in range(tri.sectors):
        for q0 in range(p, tri.per_sector):
            q = s * tri.per_sector + q0
            if tri.motion[p] >= 0 and tri.motion[p] == tri.motion[q]:
                continue
            dx = tri.place[p, 0] - tri.place[q, 0]
            dy = tri.place[p, 1] - tri.place[q, 1]
            dz = tri.place[p, 2] - tri.place[q, 2]
            square = dx * dx + dy * dy + dz * dz
            reach = tri.radius[p] + tri.radius[q]
            if square < near * near * reach * reach:
                continue
            way = 0
            if square < mid * mid * reach * reach:
                way = 2
            if wavenumber * reach > MOST_BY_SERIES:
                way += 1
            chosen[way, number[way]] = q
            number[way] += 1


@kernel(nogil=True)
def _gather(tri, p, chosen, lanes, first, last, s):
    """Put places and points of the triangles chosen[:lanes] in lanes, the last one in the rest."""
    for i in range(LANES):
        q = chosen[min(i, lanes - 1)]
        dx = tri.centre[p, 0] - tri.centre[q, 0]
        dy = tri.centre[p, 1] - tri.centre[q, 1]
        dz = tri.centre[p, 2] - tri.centre[q, 2]
        s[D + i], s[D + LANES + i], s[D + 2 * LANES + i] = dx, dy, dz
        s[FAR + i] = np.sqrt(dx * dx + dy * dy + dz * dz)
        at = POINTS + i
        for b in range(first, last):
            for c in range(3):
                s[at] = tri.points[q, b, c]
                at += LANES
        at = LENGTHS + i
        for b in range(3):
            s[at] = tri.length[q, b]
            at += LANES
        at = CORNERS + i
        for b in range(3):
            for c in range(3):
                s[at] = tri.offset[q, b, c]
                at += LANES


@kernel(nogil=True, forceinline=True)
def _one_point(s, at, i, weight, wavenumber, dx, dy, dz, far, sums):
    """Return the sums over points of q with one more: real and imaginary parts of g and v g."""
    tr, ti, fx, fy, fz, hx, hy, hz = sums
    bx, by, bz = s[at + i], s[at + LANES + i], s[at + 2 * LANES + i]
    ox, oy, oz = dx - bx, dy - by, dz - bz
    r = np.sqrt(ox * ox + oy * oy + oz * oz)
    w = weight / r
    x = wavenumber * (r - far)
    t = x * x
    re = w * (1.0 + t * (-0.5 + t * (C4 + t * (C6 + t * (C8 + t * (C10 + t * C12))))))
    im = -w * (x * (1.0 + t * (S3 + t * (S5 + t * (S7 + t * (S9 + t * (S11 + t * S13)))))))
    return (
        tr + re, ti + im, fx + re * bx, fy + re * by, fz + re * bz,
        hx + im * bx, hy + im * by, hz + im * bz,
    )  # fmt: skip


@kernel(nogil=True, forceinline=True)
def _add_point(s, i, ax, ay, az, sums):
    """Add the sums over the points of q at one point of p to the moments of a lane."""
    tr, ti, fx, fy, fz, hx, hy, hz = sums
    s[G + i] += tr
    s[U + i] += tr * ax
    s[U + LANES + i] += tr * ay
    s[U + 2 * LANES + i] += tr * az
    s[V + i] += fx
    s[V + LANES + i] += fy
    s[V + 2 * LANES + i] += fz
    s[UV + i] += ax * fx + ay * fy + az * fz
    s[G + PART + i] += ti
    s[U + PART + i] += ti * ax
    s[U + PART + LANES + i] += ti * ay
    s[U + PART + 2 * LANES + i] += ti * az
    s[V + PART + i] += hx
    s[V + PART + LANES + i] += hy
    s[V + PART + 2 * LANES + i] += hz
    s[UV + PART + i] += ax * hx + ay * hy + az * hz


@kernel(nogil=True)
def _seven_points(tri, p, k, s):
    """Add the seven points of p and of each triangle in the lanes to the moments.

    Points of q are written out: what they add stays in registers.
    """
    w0, w1, w4 = tri.weight[0], tri.weight[1], tri.weight[4]
    for a in range(7):
        ax, ay, az = tri.points[p, a, 0], tri.points[p, a, 1], tri.points[p, a, 2]
        wa = tri.weight[a]
        first, inner, outer = wa * w0, wa * w1, wa * w4
        for i in range(LANES):
            x, y, z = s[D + i] + ax, s[D + LANES + i] + ay, s[D + 2 * LANES + i] + az
            far = s[FAR + i]
            sums = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            sums = _one_point(s, POINTS, i, first, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 3 * LANES, i, inner, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 6 * LANES, i, inner, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 9 * LANES, i, inner, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 12 * LANES, i, outer, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 15 * LANES, i, outer, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 18 * LANES, i, outer, k, x, y, z, far, sums)
            _add_point(s, i, ax, ay, az, sums)


@kernel(nogil=True)
def _three_points(tri, p, k, s):
    """Add the three points of p and of each triangle in the lanes to the moments."""
    for a in range(7, 10):
        ax, ay, az = tri.points[p, a, 0], tri.points[p, a, 1], tri.points[p, a, 2]
        for i in range(LANES):
            x, y, z = s[D + i] + ax, s[D + LANES + i] + ay, s[D + 2 * LANES + i] + az
            far = s[FAR + i]
            sums = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            sums = _one_point(s, POINTS, i, NINTH, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 3 * LANES, i, NINTH, k, x, y, z, far, sums)
            sums = _one_point(s, POINTS + 6 * LANES, i, NINTH, k, x, y, z, far, sums)
            _add_point(s, i, ax, ay, az, sums)


@kernel(nogil=True)
def _add_by_sine(tri, p, wavenumber, first, last, share, s):
    """Add the points of p and of the triangles in the lanes, phases of any size."""
    for a in range(first, last):
        ax, ay, az = tri.points[p, a, 0], tri.points[p, a, 1], tri.points[p, a, 2]
        for i in range(LANES):
            tr = ti = fx = fy = fz = hx = hy = hz = 0.0
            at = POINTS + i
            for b in range(first, last):
                bx, by, bz = s[at], s[at + LANES], s[at + 2 * LANES]
                ox = s[D + i] + ax - bx
                oy = s[D + LANES + i] + ay - by
                oz = s[D + 2 * LANES + i] + az - bz
                r = np.sqrt(ox * ox + oy * oy + oz * oz)
                w = tri.weight[a] * tri.weight[b] * share / r
                x = wavenumber * (r - s[FAR + i])
                cosine, sine = cosine_sine(x)
                re, im = w * cosine, -w * sine
                tr, fx, fy, fz = tr + re, fx + re * bx, fy + re * by, fz + re * bz
                ti, hx, hy, hz = ti + im, hx + im * bx, hy + im * by, hz + im * bz
                at += 3 * LANES
            _add_point(s, i, ax, ay, az, (tr, ti, fx, fy, fz, hx, hy, hz))


@kernel(nogil=True)
def _moments(tri, p, wavenumber, way, s):
    """Fill the moments of exp(-jkR)/R of p with the triangles in the lanes, each a mean.

    The phase is that over the distance of the centroids, turned by the latter's at the end.
    """
    for at in range(G, G + 2 * PART):
        s[at] = 0.0
    if way == 0:
        _three_points(tri, p, wavenumber, s)
    elif way == 1:
        _add_by_sine(tri, p, wavenumber, 7, 10, NINTH, s)
    elif way == 2:
        _seven_points(tri, p, wavenumber, s)
    else:
        _add_by_sine(tri, p, wavenumber, 0, 7, 1.0, s)
    for i in range(LANES):
        cosine, sine = cosine_sine(wavenumber * s[FAR + i])
        s[T + i], s[T + LANES + i] = cosine, -sine
    for row in range(8):
        for i in range(LANES):
            re, im = s[G + row * LANES + i], s[G + PART + row * LANES + i]
            s[G + row * LANES + i] = re * s[T + i] - im * s[T + LANES + i]
            s[G + PART + row * LANES + i] = re * s[T + LANES + i] + im * s[T + i]


@kernel(nogil=True)
def _interactions(tri, p, vector, scalar, s):
    """Fill the nine interactions of p's half-functions with those of the triangles in the lanes.

    <(u - a).(v - b) g> is the part without b, less b . (<u g> - a <g>).
    """
    vr, vi, sr, si = vector.real, vector.imag, scalar.real, scalar.imag
    for i in range(3):
        ax, ay, az = tri.offset[p, i, 0], tri.offset[p, i, 1], tri.offset[p, i, 2]
        for part in range(2):
            at, to = G + part * PART, T + part * 4 * LANES
            for n in range(LANES):
                g = s[at + n]
                s[to + n] = s[at + 7 * LANES + n] - (
                    ax * s[at + 4 * LANES + n]
                    + ay * s[at + 5 * LANES + n]
                    + az * s[at + 6 * LANES + n]
                )
                s[to + LANES + n] = s[at + LANES + n] - ax * g
                s[to + 2 * LANES + n] = s[at + 2 * LANES + n] - ay * g
                s[to + 3 * LANES + n] = s[at + 3 * LANES + n] - az * g
        own = tri.length[p, i]
        for j in range(3):
            at, length, to = (
                CORNERS + 3 * j * LANES,
                LENGTHS + j * LANES,
                K + 2 * (3 * i + j) * LANES,
            )
            for n in range(LANES):
                bx, by, bz = s[at + n], s[at + LANES + n], s[at + 2 * LANES + n]
                re = s[T + n] - (
                    bx * s[T + LANES + n] + by * s[T + 2 * LANES + n] + bz * s[T + 3 * LANES + n]
                )
                im = s[T + 4 * LANES + n] - (
                    bx * s[T + 5 * LANES + n]
                    + by * s[T + 6 * LANES + n]
                    + bz * s[T + 7 * LANES + n]
                )
                gr, gi = s[G + n], s[G + PART + n]
                w = own * s[length + n]
                s[to + n] = w * (vr * re - vi * im + sr * gr - si * gi)
                s[to + LANES + n] = w * (vr * im + vi * re + sr * gi + si * gr)


@kernel(nogil=True)
def add_far(tri, fun, rows, begin, end, wavenumber, near, mid, vector, scalar, z):
    """Add pairs of the triangles rows[begin:end] with all that are not near to z (m, sector, n).

    ``vector`` and ``scalar`` are j w mu / (16 pi) and 1 / (4 pi j w eps). Triangles q stand side by
    side in lanes, so that the processor integrates several at a time.
    """
    count, sectors = tri.per_sector, tri.sectors
    start, function, turn, local, sign = fun
    chosen = np.empty((4, count * sectors), dtype=np.int64)
    number = np.empty(4, dtype=np.int64)
    s = np.empty(ALL_ROWS * LANES)
    row = np.zeros((3, sectors, 3 * count), dtype=np.complex128)
    column = np.empty(len(local), dtype=np.int64)
    for q0 in range(count):
        for f in range(start[q0], start[q0 + 1]):
            column[f] = 3 * q0 + local[f]
    for index in range(begin, end):
        p = rows[index]
        row[:, :, 3 * p :] = 0.0
        _sort_pairs(tri, p, wavenumber, near, mid, chosen, number)
        for way in range(4):
            first, last = (7, 10) if way < 2 else (0, 7)
            for at in range(0, number[way], LANES):
                lanes = min(LANES, number[way] - at)
                _gather(tri, p, chosen[way, at:], lanes, first, last, s)
                _moments(tri, p, wavenumber, way, s)
                _interactions(tri, p, vector, scalar, s)
                for lane in range(lanes):
                    q = chosen[way, at + lane]
                    q0 = q % count
                    half = 0.5 if q0 == p else 1.0
                    to = K + lane
                    for i in range(3):
                        for j in range(3 * q0, 3 * q0 + 3):
                            row[i, q // count, j] = complex(half * s[to], half * s[to + LANES])
                            to += 2 * LANES
        for e in range(start[p], start[p + 1]):
            m, own, i = function[e], sign[e], local[e]
            for part in range(sectors):
                shift = part - turn[e]
                for f in range(start[p], len(column)):
                    d = shift + turn[f]
                    if d < 0:
                        d += sectors
                    elif d >= sectors:
                        d -= sectors
                    z[m, d, function[f]] += (own * sign[f]) * row[i, part, column[f]]


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
