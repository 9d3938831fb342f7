# mypy: allow-untyped-defs
"""Compiled places of diffraction on edges: where the shortest way meets one edge, or two."""

import numpy as np

from octant.geometries.kernels import kernel

SECTOR_TOLERANCE = 1e-7
"""Angle [rad] by which a ray may leave a wedge's sector of air: rays along a face have rounding."""

STATIONARY = 1e-6
"""Slope [-] of a path's length over two edges, up to which its two points count as the shortest."""

ROUNDING = 1e-14
"""Share of a path's length [-] to which its points are found."""

MEETING = 1e-9
"""Share of a path's length [-] below which edges meet, or an end stands on the line of an edge."""

BESIDE = 100.0
"""Distance from where edges meet [shares `MEETING`] at which the way's slope is looked at."""

STEPS = 80
"""Steps [-] after which the two points of a double diffraction count as not found."""

NEWTON_STEPS = 12
"""Steps [-] from which on every other one halves the bracket."""


@kernel
def in_sector(wedge_frame, wedge, dx, dy, dz, tolerance):
    """Return whether a direction away from the edge points into the wedge's air, faces included."""
    across = dx * wedge_frame[wedge, 6] + dy * wedge_frame[wedge, 7] + dz * wedge_frame[wedge, 8]
    up = dx * wedge_frame[wedge, 9] + dy * wedge_frame[wedge, 10] + dz * wedge_frame[wedge, 11]
    angle = np.arctan2(up, across)
    if angle < 0.0:
        angle += 2.0 * np.pi
    return angle <= wedge_frame[wedge, 12] + tolerance or angle >= 2.0 * np.pi - tolerance


@kernel
def yields(wedge_frame, wedge, t, tolerance):
    """Return whether a place of an edge is an end of it that belongs to the next edge."""
    at_start = wedge_frame[wedge, 14] < 0.0 and t <= tolerance
    return at_start or (wedge_frame[wedge, 15] < 0.0 and t >= wedge_frame[wedge, 13] - tolerance)


@kernel
def best_place(wedge_frame, first, last, s, distance, along):
    """Return where the shortest way from the point s of one edge meets another, and if it does.

    It leads to a point at ``distance`` from the other edge's line and ``along`` it.
    """
    bx, by, bz = wedge_frame[last, 3], wedge_frame[last, 4], wedge_frame[last, 5]
    px = wedge_frame[first, 0] + s * wedge_frame[first, 3] - wedge_frame[last, 0]
    py = wedge_frame[first, 1] + s * wedge_frame[first, 4] - wedge_frame[last, 1]
    pz = wedge_frame[first, 2] + s * wedge_frame[first, 5] - wedge_frame[last, 2]
    place = px * bx + py * by + pz * bz
    px, py, pz = px - place * bx, py - place * by, pz - place * bz
    beside = np.sqrt(px * px + py * py + pz * pz)
    if beside + distance == 0.0:
        return place, False
    return place + (along - place) * beside / (beside + distance), True


@kernel
def _length(wedge_frame, first, last, distance_s, along_s, distance_r, along_r, s, t):
    """Return the length of a way over the point s of one edge and t of another."""
    between = 0.0
    for a in range(3):
        here = wedge_frame[first, a] + s * wedge_frame[first, 3 + a]
        between += (wedge_frame[last, a] + t * wedge_frame[last, 3 + a] - here) ** 2
    length = np.sqrt(between) + np.sqrt(distance_s * distance_s + (s - along_s) ** 2)
    return length + np.sqrt(distance_r * distance_r + (t - along_r) ** 2)


@kernel
def kept_on_edges(
    wedge_frame, first, last, distance_s, along_s, distance_r, along_r, s, t, tolerance
):
    """Return the places of the shortest way over two edges that end, and its detour.

    ``s`` and ``t`` are the places on the edges' lines, which lie off at least one of them; the
    detour is infinite where an end is none in the open, or one of the other edge too.
    """
    shortest = _length(wedge_frame, first, last, distance_s, along_s, distance_r, along_r, s, t)
    length_1, length_2 = wedge_frame[first, 13], wedge_frame[last, 13]
    end_1 = 0 if s < -tolerance else (1 if s > length_1 + tolerance else -1)
    end_2 = 0 if t < -tolerance else (1 if t > length_2 + tolerance else -1)
    if end_1 >= 0 and wedge_frame[first, 14 + end_1] <= 0.0:
        return s, t, np.inf
    if end_2 >= 0 and wedge_frame[last, 14 + end_2] <= 0.0:
        return s, t, np.inf
    for i in range(2):
        for j in range(2):
            gap = 0.0
            for a in range(3):
                here = wedge_frame[first, a] + i * length_1 * wedge_frame[first, 3 + a]
                there = wedge_frame[last, a] + j * length_2 * wedge_frame[last, 3 + a]
                gap = max(gap, abs(here - there))
            if gap <= 10.0 * tolerance and (i == end_1 or j == end_2):
                return s, t, np.inf
    # The length is convex: the shortest way meets one of the ends that the lines' own way lies off.
    kept, s_kept, t_kept = np.inf, s, t
    for i in range(2):
        if i == 0 and end_1 >= 0:
            s = end_1 * length_1
            t, _ = best_place(wedge_frame, first, last, s, distance_r, along_r)
        elif i == 1 and end_2 >= 0:
            t = end_2 * length_2
            s, _ = best_place(wedge_frame, last, first, t, distance_s, along_s)
        else:
            continue
        s, t = min(max(s, 0.0), length_1), min(max(t, 0.0), length_2)
        length = _length(wedge_frame, first, last, distance_s, along_s, distance_r, along_r, s, t)
        if length < kept:
            kept, s_kept, t_kept = length, s, t
    return s_kept, t_kept, kept - shortest


@kernel
def _shortest_from(wedge_frame, first, last, s, distance_s, along_s, distance_r, along_r):
    """Return what the shortest way over the point s of the first edge is like.

    Its place on the last edge, its length, how far the edges are apart there, and how that length
    rises along s, once and twice [m, -, 1/m].
    """
    a0, a1, a2 = wedge_frame[first, 3], wedge_frame[first, 4], wedge_frame[first, 5]
    b0, b1, b2 = wedge_frame[last, 3], wedge_frame[last, 4], wedge_frame[last, 5]
    t, _ = best_place(wedge_frame, first, last, s, distance_r, along_r)
    vx = wedge_frame[last, 0] - wedge_frame[first, 0] + t * b0 - s * a0
    vy = wedge_frame[last, 1] - wedge_frame[first, 1] + t * b1 - s * a1
    vz = wedge_frame[last, 2] - wedge_frame[first, 2] + t * b2 - s * a2
    r = np.sqrt(vx * vx + vy * vy + vz * vz)
    r1 = np.sqrt(distance_s * distance_s + (s - along_s) ** 2)
    r3 = np.sqrt(distance_r * distance_r + (t - along_r) ** 2)
    if r == 0.0:
        return t, r1 + r3, r, 0.0, 0.0
    va, vb = (vx * a0 + vy * a1 + vz * a2) / r, (vx * b0 + vy * b1 + vz * b2) / r
    hst = (va * vb - (a0 * b0 + a1 * b1 + a2 * b2)) / r
    htt = distance_r * distance_r / r3**3 + (1.0 - vb * vb) / r
    curve = distance_s * distance_s / r1**3 + (1.0 - va * va) / r
    if htt > 0.0:
        curve -= hst * hst / htt
    return t, r1 + r + r3, r, (s - along_s) / r1 - va, curve


@kernel
def two_points(wedge_frame, first, last, distance_s, along_s, distance_r, along_r):
    """Return where the shortest path meets two edges, as lengths along them, and if it was found.

    The source stands ``distance_s`` off the first edge's line at ``along_s``, the receiver likewise
    off the last. For each place on the first the best one on the last is that of a single edge;
    what is left is a convex function of one place: Newton's method, kept in a bracket. An end on
    the line of an edge is its own place there. Where both edges meet, the length has a kink; if
    the shortest way is there, no ray is diffracted by either: not found.
    """
    size = distance_s + abs(along_s) + distance_r + abs(along_r)
    for a in range(3):
        size += abs(wedge_frame[last, a] - wedge_frame[first, a])
    s, t = along_s, along_r
    if distance_r <= MEETING * size:
        if distance_s > MEETING * size:
            s, _ = best_place(wedge_frame, last, first, t, distance_s, along_s)
        return s, t, True
    if distance_s <= MEETING * size:
        t, _ = best_place(wedge_frame, first, last, s, distance_r, along_r)
        return s, t, True
    given = wedge_frame, first, last
    ends = distance_s, along_s, distance_r, along_r
    low, high, slope = -np.inf, np.inf, np.inf
    for i in range(STEPS):
        t, length, r, slope, curve = _shortest_from(*given, s, *ends)
        if r <= MEETING * length:
            aside = BESIDE * MEETING * length
            if _shortest_from(*given, s + aside, *ends)[3] < 0.0:
                low, s = s, s + aside
            elif _shortest_from(*given, s - aside, *ends)[3] > 0.0:
                high, s = s, s - aside
            else:
                return s, t, False
            continue
        if slope > 0.0:
            high = s
        else:
            low = s
        to = s - slope / curve if curve > 0.0 else np.inf
        halve = i >= NEWTON_STEPS and i % 2 == 0 and high - low < np.inf
        if abs(to - s) > ROUNDING * length and (halve or not low < to < high):
            to = 0.5 * (low + high)
            if low == -np.inf:
                to = high - 2.0 * length
            elif high == np.inf:
                to = low + 2.0 * length
        if abs(to - s) <= ROUNDING * length:
            return s, t, abs(slope) <= STATIONARY
        s = to
    return s, t, abs(slope) <= STATIONARY
