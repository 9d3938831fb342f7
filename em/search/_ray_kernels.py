# mypy: allow-untyped-defs
"""Compiled ray launching: which sequences of planes rays from a source meet, and their power."""

import numpy as np

from octant.geometries._array_kernels import grown
from octant.geometries._bvh_kernels import crossing
from octant.geometries.kernels import kernel

MAX_STACK = 130
"""Nodes waiting in a nearest-first walk: two per level of the deepest hierarchy, and some."""

MAX_BRANCHES = 256
"""Rays [-] that one launched ray may have waiting where facets let part of it through."""

MAX_SEGMENTS = 4096
"""Segments [-] after which a launched ray is given up."""


@kernel
def _enters(boxes, node, px, py, pz, ix, iy, iz):
    """Return where a ray enters a box, infinity when it misses."""
    t0, t1 = (boxes[node, 0] - px) * ix, (boxes[node, 3] - px) * ix
    enter, leave = min(t0, t1), max(t0, t1)
    t0, t1 = (boxes[node, 1] - py) * iy, (boxes[node, 4] - py) * iy
    enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
    t0, t1 = (boxes[node, 2] - pz) * iz, (boxes[node, 5] - pz) * iz
    enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
    return enter if enter <= leave and leave >= 0.0 else np.inf


@kernel
def _nearest(bvh, facet_plane, px, py, pz, dx, dy, dz, plane_left, stack, enter):
    """Return the first triangle on a ray and its distance [m]; -1 when there is none."""
    boxes, links, triangles = bvh.boxes, bvh.links, bvh.triangles
    best, found = np.inf, -1
    ix, iy, iz = 1.0 / dx, 1.0 / dy, 1.0 / dz
    top = 0
    if len(links) > 0:
        stack[0], enter[0] = 0, _enters(boxes, 0, px, py, pz, ix, iy, iz)
        top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if enter[top] >= best:
            continue
        if links[node, 2] == 0:
            near, far = node + 1, links[node + 1, 0]
            to_near = _enters(boxes, near, px, py, pz, ix, iy, iz)
            to_far = _enters(boxes, far, px, py, pz, ix, iy, iz)
            if to_near > to_far:
                near, far, to_near, to_far = far, near, to_far, to_near
            stack[top], enter[top] = far, to_far
            stack[top + 1], enter[top + 1] = near, to_near
            top += 2
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            if facet_plane[bvh.planes[i]] == plane_left:
                continue
            t = crossing(triangles, i, px, py, pz, dx, dy, dz)
            if 0.0 < t < best:
                best, found = t, i
    return found, best


@kernel
def _length_within(box, px, py, pz, dx, dy, dz, far):
    """Return how much [m] of a ray's first ``far`` metres lies in a box, (2, 3) [m]."""
    start, direction = (px, py, pz), (dx, dy, dz)
    enter, leave = 0.0, far
    for axis in range(3):
        at, along = start[axis], direction[axis]
        low, high = box[0, axis], box[1, axis]
        if along > 0.0:
            enter, leave = max(enter, (low - at) / along), min(leave, (high - at) / along)
        elif along < 0.0:
            enter, leave = max(enter, (high - at) / along), min(leave, (low - at) / along)
        elif at < low or at > high:
            leave = 0.0
    return max(0.0, leave - enter)


@kernel
def _slot(table, nodes, parent, plane):
    """Return the table's place for a sequence: where it is, or where it would go."""
    mask = np.uint64(len(table) - 1)
    h = np.uint64(parent) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(plane)
    h *= np.uint64(0xBF58476D1CE4E5B9)
    h ^= h >> np.uint64(31)
    place = h & mask
    while True:
        node = table[place]
        if node < 0 or (nodes[node, 0] == parent and nodes[node, 1] == plane):
            return np.int64(place)
        place = (place + np.uint64(1)) & mask


@kernel
def _larger_table(nodes, count, size):
    table = np.full(size, -1, dtype=np.int64)
    for node in range(1, count):
        table[_slot(table, nodes, nodes[node, 0], nodes[node, 1])] = node
    return table


@kernel(nogil=True)
def launch(source, directions, bvh, facet_plane, clear, normals, front, wall, walls, box, most):
    """Return (k, 3) sequences that a block of rays meets: parent, plane and order.

    Rows are sequences of planes, as a tree: row 0 is the source, each other row adds a plane to its
    parent's. A second array (k,) holds the length [m] that rays run in ``box`` after it, weighed by
    what is left of their power.

    ``bvh`` counts its triangles by facet; ``clear`` marks the planes that also let rays through;
    ``walls`` are shares of power as `octant.em.search.ray_share.wall_powers` returns them, ``wall``
    is the row of each facet and ``front`` whether its first layer is where its normal points.
    """
    nodes = np.zeros((256, 3), dtype=np.int64)
    nodes[0, 0], nodes[0, 1] = -1, -1
    power = np.zeros(256)
    count = 1
    table = np.full(1024, -1, dtype=np.int64)
    stack, enter = np.empty(MAX_STACK, dtype=np.int64), np.empty(MAX_STACK)
    waiting = np.empty((MAX_BRANCHES, 7))  # place, direction, power
    state = np.empty((MAX_BRANCHES, 2), dtype=np.int64)  # sequence, plane left
    bins = walls.shape[3]
    for r in range(len(directions)):
        for a in range(3):
            waiting[0, a], waiting[0, 3 + a] = source[a], directions[r, a]
        waiting[0, 6] = 1.0
        state[0] = 0, -1
        top, segments = 1, 0
        while top > 0 and segments < MAX_SEGMENTS:
            segments += 1
            top -= 1
            px, py, pz = waiting[top, 0], waiting[top, 1], waiting[top, 2]
            dx, dy, dz = waiting[top, 3], waiting[top, 4], waiting[top, 5]
            left_power = waiting[top, 6]
            parent, left = state[top]
            hit, far = _nearest(bvh, facet_plane, px, py, pz, dx, dy, dz, left, stack, enter)
            power[parent] += left_power * _length_within(box, px, py, pz, dx, dy, dz, far)
            if hit < 0:
                continue
            facet = bvh.planes[hit]
            plane = facet_plane[facet]
            nx, ny, nz = normals[plane, 0], normals[plane, 1], normals[plane, 2]
            along = nx * dx + ny * dy + nz * dz
            cell = min(int(abs(along) * bins), bins - 1)
            side = 0 if (along < 0.0) == front[facet] else 1
            px, py, pz = px + far * dx, py + far * dy, pz + far * dz
            if clear[plane] and top < MAX_BRANCHES - 1:
                through = left_power * walls[wall[facet], side, 1, cell]
                waiting[top] = px, py, pz, dx, dy, dz, through
                state[top] = parent, plane
                top += 1
            order = nodes[parent, 2] + 1
            if order > most:
                continue
            slot = _slot(table, nodes, parent, plane)
            node = table[slot]
            if node < 0:
                if count == len(nodes):
                    nodes, more = grown(nodes, 2 * count), np.zeros(2 * count)
                    for k in range(count):
                        more[k] = power[k]
                    power = more
                node = count
                nodes[node, 0], nodes[node, 1], nodes[node, 2] = parent, plane, order
                table[slot] = node
                count += 1
                if 2 * count > len(table):
                    table = _larger_table(nodes, count, 2 * len(table))
            if top < MAX_BRANCHES:
                back = left_power * walls[wall[facet], side, 0, cell]
                dx, dy, dz = dx - 2.0 * along * nx, dy - 2.0 * along * ny, dz - 2.0 * along * nz
                waiting[top] = px, py, pz, dx, dy, dz, back
                state[top] = node, plane
                top += 1
    return nodes[:count].copy(), power[:count].copy()
