# mypy: allow-untyped-defs
"""Compiled kernels of the bounding volume hierarchy: build, and "is this segment free?".

The tree is stored in depth-first order with skip links, so that a traversal needs no stack: a node
whose box is hit is followed by its first child, any other by the node its skip link names.
"""

from typing import NamedTuple

import numpy as np

from octant.geometries.kernels import kernel

RIM = 1e-10
"""Inclusive margin [-] in barycentric coordinates."""

PARALLEL = 1e-11
"""Angle [rad] below which a line counts as parallel to a plane: far above what rounding leaves."""

LEAF_SIZE = 4
BINS = 16
MAX_DEPTH = 64


class BvhArrays(NamedTuple):
    """Arrays of a hierarchy: n nodes over t triangles."""

    boxes: np.ndarray  # (n, 6) float64: least corner, greatest corner [m]
    links: np.ndarray  # (n, 3) int64: next node when this one is missed, first triangle, triangles
    triangles: np.ndarray  # (t, 9) float64: corner, first side, second side [m]
    planes: np.ndarray  # (t,) int64: plane of each triangle
    margin: float  # [m] by which hits at the ends of a segment are ignored


@kernel
def _split_place(lo, hi, order, begin, end, axis, low, width):
    """Return the number of bins left of the cheapest surface-area split, 0 if there is none."""
    counts = np.zeros(BINS, dtype=np.int64)
    box = np.empty((BINS, 6))
    for b in range(BINS):
        for a in range(3):
            box[b, a], box[b, 3 + a] = np.inf, -np.inf
    x = np.empty(6)
    for i in range(begin, end):
        tri = order[i]
        b = min(BINS - 1, int(BINS * (0.5 * (lo[tri, axis] + hi[tri, axis]) - low) / width))
        counts[b] += 1
        for a in range(3):
            box[b, a] = min(box[b, a], lo[tri, a])
            box[b, 3 + a] = max(box[b, 3 + a], hi[tri, a])
    best = np.inf
    place = 0
    for cut in range(1, BINS):
        cost = 0.0
        for part in range(2):
            n = 0
            for a in range(3):
                x[a], x[3 + a] = np.inf, -np.inf
            for b in range(0 if part == 0 else cut, cut if part == 0 else BINS):
                n += counts[b]
                for a in range(3):
                    x[a] = min(x[a], box[b, a])
                    x[3 + a] = max(x[3 + a], box[b, 3 + a])
            if n == 0:
                cost = np.inf
                break
            dx, dy, dz = x[3] - x[0], x[4] - x[1], x[5] - x[2]
            cost += n * (dx * dy + dy * dz + dz * dx)
        if cost < best:
            best = cost
            place = cut
    return place


@kernel
def build(lo, hi):
    """Return order, boxes and links of a hierarchy over the boxes (t, 3) lo to hi [m]."""
    t = len(lo)
    order = np.empty(t, dtype=np.int64)
    for i in range(t):
        order[i] = i
    bounds = np.empty((2 * t + 1, 6))
    links = np.zeros((2 * t + 1, 3), dtype=np.int64)
    # Depth-first work list: begin, end, depth. A node's skip link is where the list continues once
    # its subtree is done, which is known when the next entry of the same list level is taken.
    work = np.empty((2 * MAX_DEPTH + 4, 3), dtype=np.int64)
    open_node = np.empty(MAX_DEPTH + 2, dtype=np.int64)
    open_node[:] = -1
    centre_lo, centre_hi, width = np.empty(3), np.empty(3), np.empty(3)
    top = 0
    nodes = 0
    if t > 0:
        work[0, 0], work[0, 1], work[0, 2] = 0, t, 0
        top = 1
    while top > 0:
        top -= 1
        begin, end, depth = work[top, 0], work[top, 1], work[top, 2]
        for d in range(depth, MAX_DEPTH + 2):
            if open_node[d] >= 0:
                links[open_node[d], 0] = nodes
                open_node[d] = -1
        node = nodes
        nodes += 1
        open_node[depth] = node
        for a in range(3):
            bounds[node, a] = np.inf
            bounds[node, 3 + a] = -np.inf
        centre_lo[:], centre_hi[:] = np.inf, -np.inf
        for i in range(begin, end):
            for a in range(3):
                bounds[node, a] = min(bounds[node, a], lo[order[i], a])
                bounds[node, 3 + a] = max(bounds[node, 3 + a], hi[order[i], a])
                c = 0.5 * (lo[order[i], a] + hi[order[i], a])
                centre_lo[a] = min(centre_lo[a], c)
                centre_hi[a] = max(centre_hi[a], c)
        axis = 0
        for a in range(3):
            width[a] = centre_hi[a] - centre_lo[a]
            if width[a] > width[axis]:
                axis = a
        middle = begin
        if end - begin > LEAF_SIZE and depth < MAX_DEPTH and width[axis] > 0.0:
            cut = _split_place(lo, hi, order, begin, end, axis, centre_lo[axis], width[axis])
            for i in range(begin, end):
                tri = order[i]
                c = 0.5 * (lo[tri, axis] + hi[tri, axis])
                if min(BINS - 1, int(BINS * (c - centre_lo[axis]) / width[axis])) < cut:
                    order[i] = order[middle]
                    order[middle] = tri
                    middle += 1
        if middle in (begin, end):
            links[node, 1] = begin
            links[node, 2] = end - begin
        else:
            work[top, 0], work[top, 1], work[top, 2] = middle, end, depth + 1
            work[top + 1, 0], work[top + 1, 1], work[top + 1, 2] = begin, middle, depth + 1
            top += 2
    for d in range(MAX_DEPTH + 2):
        if open_node[d] >= 0:
            links[open_node[d], 0] = nodes
    return order, bounds[:nodes].copy(), links[:nodes].copy()


@kernel
def two_planes(first, second):
    """Return one number for the two planes that meet at a segment's end, for segment_blocked."""
    return first | (second + 1) << 32


@kernel(forceinline=True)
def crossing(triangles, i, px, py, pz, dx, dy, dz):
    """Return the t at which the line p + t d crosses a triangle, rim included, or -1.

    A line within its plane crosses it nowhere; there det is 0, or what rounding makes of it.
    """
    ax, ay, az = triangles[i, 3], triangles[i, 4], triangles[i, 5]
    bx, by, bz = triangles[i, 6], triangles[i, 7], triangles[i, 8]
    hx, hy, hz = dy * bz - dz * by, dz * bx - dx * bz, dx * by - dy * bx
    det = ax * hx + ay * hy + az * hz
    if abs(det) <= PARALLEL * (abs(ax) + abs(ay) + abs(az)) * (abs(bx) + abs(by) + abs(bz)) * (
        abs(dx) + abs(dy) + abs(dz)
    ):
        return -1.0
    sx, sy, sz = px - triangles[i, 0], py - triangles[i, 1], pz - triangles[i, 2]
    u = (sx * hx + sy * hy + sz * hz) / det
    if u < -RIM or u > 1.0 + RIM:
        return -1.0
    cx, cy, cz = sy * az - sz * ay, sz * ax - sx * az, sx * ay - sy * ax
    v = (dx * cx + dy * cy + dz * cz) / det
    if v < -RIM or u + v > 1.0 + RIM:
        return -1.0
    return (bx * cx + by * cy + bz * cz) / det


@kernel(forceinline=True)
def segment_blocked(
    boxes, links, triangles, planes, margin, px, py, pz, qx, qy, qz, plane_p, plane_q
):
    """Return whether a triangle stands strictly between p and q [m].

    Triangles of the planes ``plane_p`` and ``plane_q`` do not count: a segment that ends on a plane
    cannot cross it again. Where it ends on an edge, both of its planes come as one number, packed
    by :func:`two_planes`. A hit on a triangle's very rim counts, so that no ray slips between two
    triangles. Arrays come one by one, and few of anything: a tuple of arrays passed in an inner
    loop, or one argument too many to be inlined, costs more than the search itself.
    """
    nodes = len(links)
    if nodes == 0:
        return False
    # Most segments pass the outermost box by on one side, which needs no division to see; in one
    # condition, since six would be guessed wrong too often.
    if (
        (max(px, qx) < boxes[0, 0])
        | (max(py, qy) < boxes[0, 1])
        | (max(pz, qz) < boxes[0, 2])
        | (min(px, qx) > boxes[0, 3])
        | (min(py, qy) > boxes[0, 4])
        | (min(pz, qz) > boxes[0, 5])
    ):
        return False
    # A single plane has nothing in the upper half, which stands for no second one.
    at_p, also_p = plane_p & 0xFFFFFFFF, (plane_p >> 32) - 1
    at_q, also_q = plane_q & 0xFFFFFFFF, (plane_q >> 32) - 1
    dx, dy, dz = qx - px, qy - py, qz - pz
    if dx == 0.0 and dy == 0.0 and dz == 0.0:
        return False
    ix, iy, iz = 1.0 / dx, 1.0 / dy, 1.0 / dz
    node = 0
    while node < nodes:
        t0, t1 = (boxes[node, 0] - px) * ix, (boxes[node, 3] - px) * ix
        enter, leave = min(t0, t1), max(t0, t1)
        t0, t1 = (boxes[node, 1] - py) * iy, (boxes[node, 4] - py) * iy
        enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        t0, t1 = (boxes[node, 2] - pz) * iz, (boxes[node, 5] - pz) * iz
        enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        if enter > leave or leave < 0.0 or enter > 1.0:
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            plane = planes[i]
            if plane in (at_p, at_q):
                continue
            t = crossing(triangles, i, px, py, pz, dx, dy, dz)
            near = margin / np.sqrt(dx * dx + dy * dy + dz * dz)
            if near < t < 1.0 - near and plane not in (also_p, also_q):
                return True
        node += 1
    return False


@kernel
def segments_blocked(bvh, starts, ends, plane_a, plane_b, blocked):
    """Fill (n,) ``blocked`` for n segments between (n, 3) points [m]."""
    for i in range(len(starts)):
        blocked[i] = segment_blocked(
            bvh.boxes,
            bvh.links,
            bvh.triangles,
            bvh.planes,
            bvh.margin,
            starts[i, 0],
            starts[i, 1],
            starts[i, 2],
            ends[i, 0],
            ends[i, 1],
            ends[i, 2],
            plane_a[i],
            plane_b[i],
        )


@kernel
def winding_numbers(points, corners, winding):
    """Fill (n,) ``winding`` [-] of n points about (t, 3, 3) triangles [m].

    The solid angle of each triangle is that of Van Oosterom and Strackee (1983), equation 8.
    """
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        total = 0.0
        for t in range(len(corners)):
            ax, ay, az = corners[t, 0, 0] - x, corners[t, 0, 1] - y, corners[t, 0, 2] - z
            bx, by, bz = corners[t, 1, 0] - x, corners[t, 1, 1] - y, corners[t, 1, 2] - z
            cx, cy, cz = corners[t, 2, 0] - x, corners[t, 2, 1] - y, corners[t, 2, 2] - z
            la = np.sqrt(ax * ax + ay * ay + az * az)
            lb = np.sqrt(bx * bx + by * by + bz * bz)
            lc = np.sqrt(cx * cx + cy * cy + cz * cz)
            volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
            scale = (
                la * lb * lc
                + (ax * bx + ay * by + az * bz) * lc
                + (bx * cx + by * cy + bz * cz) * la
                + (cx * ax + cy * ay + cz * az) * lb
            )
            total += 2.0 * np.arctan2(volume, scale)
        winding[i] = total / (4.0 * np.pi)
