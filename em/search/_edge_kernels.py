# mypy: allow-untyped-defs
"""Compiled test of which part of which edge an image of the source can light."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _keep_above(lo, hi, value, slope, slack):
    """Return the part of lo..hi where value + slope t >= -slack."""
    if slope == 0.0:
        return (lo, hi) if value >= -slack else (1.0, 0.0)
    edge = (-slack - value) / slope
    if slope > 0.0:
        return max(lo, edge), hi
    return lo, min(hi, edge)


@njit(cache=True, error_model="numpy")
def lit_through(image, plane, hull, begin, end, ox, oy, oz, ax, ay, az, length, slack):
    """Return the part of an edge that an image sees through the convex polygon of a facet.

    ``plane`` is its normal and offset, the polygon ``hull[begin:end]``; an empty part has its end
    before its start. The part may be too large by the slack, never too small.
    """
    lo, hi = 0.0, length
    height = plane[0] * image[0] + plane[1] * image[1] + plane[2] * image[2] - plane[3]
    side = 1.0 if height < 0.0 else -1.0
    value = side * (plane[0] * ox + plane[1] * oy + plane[2] * oz - plane[3])
    slope = side * (plane[0] * ax + plane[1] * ay + plane[2] * az)
    lo, hi = _keep_above(lo, hi, value, slope, slack)
    mx, my, mz = 0.0, 0.0, 0.0
    for i in range(begin, end):
        mx, my, mz = mx + hull[i, 0], my + hull[i, 1], mz + hull[i, 2]
    n = end - begin
    mx, my, mz = mx / n - image[0], my / n - image[1], mz / n - image[2]
    reach = max(
        abs(ox - image[0]) + abs(oy - image[1]) + abs(oz - image[2]),
        abs(ox + length * ax - image[0])
        + abs(oy + length * ay - image[1])
        + abs(oz + length * az - image[2]),
    )
    for i in range(begin, end):
        j = i + 1 if i + 1 < end else begin
        px, py, pz = hull[i, 0] - image[0], hull[i, 1] - image[1], hull[i, 2] - image[2]
        qx, qy, qz = hull[j, 0] - image[0], hull[j, 1] - image[1], hull[j, 2] - image[2]
        sx, sy, sz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        norm = np.sqrt(sx * sx + sy * sy + sz * sz)
        near = np.sqrt(min(px * px + py * py + pz * pz, qx * qx + qy * qy + qz * qz))
        if norm <= slack * near or near <= slack:
            continue
        sx, sy, sz = sx / norm, sy / norm, sz / norm
        if sx * mx + sy * my + sz * mz < 0.0:
            sx, sy, sz = -sx, -sy, -sz
        value = sx * (ox - image[0]) + sy * (oy - image[1]) + sz * (oz - image[2])
        slope = sx * ax + sy * ay + sz * az
        # A corner that is off by the slack moves the side of the beam further out behind it.
        lo, hi = _keep_above(lo, hi, value, slope, slack * (1.0 + reach / near))
        if lo > hi:
            break
    return lo, hi


@njit(cache=True, error_model="numpy")
def _lies_in(plane, ox, oy, oz, ax, ay, az, length, slack):
    """Return whether an edge lies in a plane, which then cannot show its image."""
    start = plane[0] * ox + plane[1] * oy + plane[2] * oz - plane[3]
    rise = (plane[0] * ax + plane[1] * ay + plane[2] * az) * length
    return abs(start) <= slack and abs(start + rise) <= slack


@njit(cache=True, error_model="numpy")
def light_edges(
    image,
    order,
    branch_start,
    branches,
    planes,
    plane_facet_start,
    hull_start,
    hulls,
    wedge_frame,
    slack,
    reach,
    source,
):
    """Fill which part of each wedge's edge each image can light, and where the image stands.

    (i, w, 2) ``reach``: from and to [m], empty where to < from; (i, w, 2) ``source``: distance from
    the edge's line and place along it [m].
    """
    for i in range(len(image)):
        for w in range(len(wedge_frame)):
            ox, oy, oz = wedge_frame[w, 0], wedge_frame[w, 1], wedge_frame[w, 2]
            ax, ay, az = wedge_frame[w, 3], wedge_frame[w, 4], wedge_frame[w, 5]
            length = wedge_frame[w, 13]
            sx, sy, sz = image[i, 0] - ox, image[i, 1] - oy, image[i, 2] - oz
            across = sx * wedge_frame[w, 6] + sy * wedge_frame[w, 7] + sz * wedge_frame[w, 8]
            up = sx * wedge_frame[w, 9] + sy * wedge_frame[w, 10] + sz * wedge_frame[w, 11]
            beside = np.sqrt(across * across + up * up)
            source[i, w, 0] = beside
            source[i, w, 1] = sx * ax + sy * ay + sz * az
            reach[i, w, 0], reach[i, w, 1] = 1.0, 0.0
            if beside <= slack:
                continue
            # An image stands in one direction of an edge, wherever along it the ray arrives.
            angle = np.arctan2(up, across)
            if angle < 0.0:
                angle += 2.0 * np.pi
            tolerance = 1e-7 + slack / beside
            if wedge_frame[w, 12] + tolerance < angle < 2.0 * np.pi - tolerance:
                continue
            if order[i] == 0:
                reach[i, w, 0], reach[i, w, 1] = 0.0, length
                continue
            low, high = np.inf, -np.inf
            for b in range(branch_start[i], branch_start[i + 1]):
                plane = branches[b, 0]
                if _lies_in(planes[plane], ox, oy, oz, ax, ay, az, length, slack):
                    continue
                for facet in range(plane_facet_start[plane], plane_facet_start[plane + 1]):
                    lo, hi = lit_through(
                        image[i],
                        planes[plane],
                        hulls,
                        hull_start[facet],
                        hull_start[facet + 1],
                        ox,
                        oy,
                        oz,
                        ax,
                        ay,
                        az,
                        length,
                        slack,
                    )
                    if lo <= hi:
                        low, high = min(low, lo), max(high, hi)
            if low <= high:
                reach[i, w, 0], reach[i, w, 1] = low, high
