# mypy: allow-untyped-defs
"""Compiled places of diffraction on edges: where the shortest way meets one edge, or two."""

import numpy as np
from numba import njit

SECTOR_TOLERANCE = 1e-7
"""Angle [rad] by which a ray may leave a wedge's sector of air: rays along a face have rounding."""

STATIONARY = 1e-6
"""Slope [-] of a path's length over two edges, up to which its two points count as the shortest."""

NEWTON_STEPS = 40
"""Steps [-] after which the two points of a double diffraction count as not found."""


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
    off the last. The length is a convex function of the two places: Newton's method with halved
    steps.
    """
    ax, ay, az = wedge_frame[first, 3], wedge_frame[first, 4], wedge_frame[first, 5]
    bx, by, bz = wedge_frame[last, 3], wedge_frame[last, 4], wedge_frame[last, 5]
    ox = wedge_frame[last, 0] - wedge_frame[first, 0]
    oy = wedge_frame[last, 1] - wedge_frame[first, 1]
    oz = wedge_frame[last, 2] - wedge_frame[first, 2]
    ab = ax * bx + ay * by + az * bz
    s, t = along_s, along_r
    best = np.inf
    ds, dt = 0.0, 0.0
    smooth = False
    for _ in range(NEWTON_STEPS):
        for _ in range(NEWTON_STEPS):
            vx, vy, vz = ox + t * bx - s * ax, oy + t * by - s * ay, oz + t * bz - s * az
            r = np.sqrt(vx * vx + vy * vy + vz * vz)
            r1 = np.sqrt(distance_s * distance_s + (s - along_s) ** 2)
            r3 = np.sqrt(distance_r * distance_r + (t - along_r) ** 2)
            length = r1 + r + r3
            if length <= best:
                break
            ds, dt = 0.5 * ds, 0.5 * dt
            s, t = s - ds, t - dt
        best = length
        if r == 0.0 or r1 == 0.0 or r3 == 0.0:
            return s, t, False
        va, vb = (vx * ax + vy * ay + vz * az) / r, (vx * bx + vy * by + vz * bz) / r
        gs, gt = (s - along_s) / r1 - va, (t - along_r) / r3 + vb
        hss = distance_s * distance_s / r1**3 + (1.0 - va * va) / r
        htt = distance_r * distance_r / r3**3 + (1.0 - vb * vb) / r
        hst = (va * vb - ab) / r
        det = hss * htt - hst * hst
        if det <= 0.0:
            return s, t, False
        ds, dt = -(htt * gs - hst * gt) / det, -(hss * gt - hst * gs) / det
        # Where the edges meet, the length has a kink, at which no ray is diffracted by either.
        smooth = abs(gs) + abs(gt) <= STATIONARY
        if abs(ds) + abs(dt) <= 1e-14 * length:
            return s, t, smooth
        s, t = s + ds, t + dt
    return s, t, smooth and abs(ds) + abs(dt) <= 1e-9 * best
