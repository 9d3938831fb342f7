# mypy: allow-untyped-defs
"""Compiled places of diffraction on edges: where the shortest way meets one edge, or two."""

import numpy as np
from numba import njit

SECTOR_TOLERANCE = 1e-7
"""Angle [rad] by which a ray may leave a wedge's sector of air: rays along a face have rounding."""

STATIONARY = 1e-6
"""Slope [-] of a path's length over two edges, up to which its two points count as the shortest."""

ROUNDING = 1e-14
"""Share of a path's length [-] to which its points are found."""

MEETING = 1e-9
"""Share of a path's length [-] below which edges meet, or an end stands on the line of an edge."""

STEPS = 80
"""Steps [-] after which the two points of a double diffraction count as not found."""

NEWTON_STEPS = 12
"""Steps [-] from which on every other one halves the bracket."""


@njit(cache=True, error_model="numpy")
def in_sector(wedge_frame, wedge, dx, dy, dz, tolerance):
    """Return whether a direction away from the edge points into the wedge's air, faces included."""
    across = dx * wedge_frame[wedge, 6] + dy * wedge_frame[wedge, 7] + dz * wedge_frame[wedge, 8]
    up = dx * wedge_frame[wedge, 9] + dy * wedge_frame[wedge, 10] + dz * wedge_frame[wedge, 11]
    angle = np.arctan2(up, across)
    if angle < 0.0:
        angle += 2.0 * np.pi
    return angle <= wedge_frame[wedge, 12] + tolerance or angle >= 2.0 * np.pi - tolerance


@njit(cache=True, error_model="numpy")
def two_points(wedge_frame, first, last, distance_s, along_s, distance_r, along_r):
    """Return where the shortest path meets two edges, as lengths along them, and if it was found.

    The source stands ``distance_s`` off the first edge's line at ``along_s``, the receiver likewise
    off the last. For each place on the first the best one on the last is that of a single edge;
    what is left is a convex function of one place: Newton's method, kept in a bracket. Where both
    edges meet, the length has a kink, at which no ray is diffracted by either, nor is one that runs
    along an edge: not found.
    """
    ax, ay, az = wedge_frame[first, 3], wedge_frame[first, 4], wedge_frame[first, 5]
    bx, by, bz = wedge_frame[last, 3], wedge_frame[last, 4], wedge_frame[last, 5]
    ox = wedge_frame[last, 0] - wedge_frame[first, 0]
    oy = wedge_frame[last, 1] - wedge_frame[first, 1]
    oz = wedge_frame[last, 2] - wedge_frame[first, 2]
    ab = ax * bx + ay * by + az * bz
    s, t = along_s, along_r
    low, high, slope = -np.inf, np.inf, np.inf
    if distance_s == 0.0 or distance_r == 0.0:
        return s, t, False
    for i in range(STEPS):
        px, py, pz = s * ax - ox, s * ay - oy, s * az - oz
        place = px * bx + py * by + pz * bz
        px, py, pz = px - place * bx, py - place * by, pz - place * bz
        beside = np.sqrt(px * px + py * py + pz * pz)
        t = place + (along_r - place) * beside / (beside + distance_r)
        vx, vy, vz = ox + t * bx - s * ax, oy + t * by - s * ay, oz + t * bz - s * az
        r = np.sqrt(vx * vx + vy * vy + vz * vz)
        r1 = np.sqrt(distance_s * distance_s + (s - along_s) ** 2)
        r3 = np.sqrt(distance_r * distance_r + (t - along_r) ** 2)
        length = r1 + r + r3
        if min(r, distance_s, distance_r) <= MEETING * length:
            return s, t, False
        va, vb = (vx * ax + vy * ay + vz * az) / r, (vx * bx + vy * by + vz * bz) / r
        slope = (s - along_s) / r1 - va
        if slope > 0.0:
            high = s
        else:
            low = s
        hst = (va * vb - ab) / r
        htt = distance_r * distance_r / r3**3 + (1.0 - vb * vb) / r
        curve = distance_s * distance_s / r1**3 + (1.0 - va * va) / r
        if htt > 0.0:
            curve -= hst * hst / htt
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
