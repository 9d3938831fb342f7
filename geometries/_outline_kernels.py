# mypy: allow-untyped-defs
"""Compiled kernels that turn the triangles of a plane into outlines."""

import numpy as np

from octant.geometries._array_kernels import fill_order, first_not_below, grown
from octant.geometries._plane_kernels import join, roots
from octant.geometries.kernels import kernel


@kernel
def _corners_between(vertices, corners, places, axis, a, b, tolerance, hits, along):
    """Fill ``hits`` with the corners that stand on the edge from a to b, in order; return how many.

    ``corners`` are sorted by ``places``, their coordinate along ``axis``.
    """
    ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
    dx, dy, dz = vertices[b, 0] - ax, vertices[b, 1] - ay, vertices[b, 2] - az
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    least = min(vertices[a, axis], vertices[b, axis]) - tolerance
    most = max(vertices[a, axis], vertices[b, axis]) + tolerance
    count = 0
    for i in range(first_not_below(places, least), len(corners)):
        if places[i] > most:
            break
        c = corners[i]
        if c in (a, b):
            continue
        x, y, z = vertices[c, 0] - ax, vertices[c, 1] - ay, vertices[c, 2] - az
        t = (x * dx + y * dy + z * dz) / length
        if t <= tolerance or t >= length - tolerance:
            continue
        x, y, z = x - t * dx / length, y - t * dy / length, z - t * dz / length
        if x * x + y * y + z * z > tolerance * tolerance:
            continue
        place = count
        while place > 0 and along[place - 1] > t:
            along[place] = along[place - 1]
            hits[place] = hits[place - 1]
            place -= 1
        along[place] = t
        hits[place] = c
        count += 1
    return count


@kernel
def split_edges(group_start, starts, ends, vertices, tolerance):
    """Return (k, 3) edge, start and end of the edges cut where corners of their group lie on them.

    Edges of group g are ``group_start[g]`` up to ``group_start[g + 1]``.
    """
    pieces = np.empty((2 * len(starts) + 16, 3), dtype=np.int64)
    count = 0
    longest = 0
    for g in range(len(group_start) - 1):
        longest = max(longest, 2 * (group_start[g + 1] - group_start[g]))
    keys, order = np.empty(longest), np.empty(longest, dtype=np.int64)
    all_corners, all_places = np.empty(longest, dtype=np.int64), np.empty(longest)
    hits, along = np.empty(longest, dtype=np.int64), np.empty(longest)
    for g in range(len(group_start) - 1):
        begin, end = group_start[g], group_start[g + 1]
        alone = end - begin <= 3  # a triangle: nothing can stand on its sides
        axis = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
        n = 0
        if not alone:
            both = 2 * (end - begin)
            for i in range(begin, end):
                keys[2 * (i - begin)], keys[2 * (i - begin) + 1] = starts[i], ends[i]
            fill_order(keys[:both], order[:both])
            for i in range(both):
                c = np.int64(keys[order[i]])
                if n == 0 or c != all_corners[n - 1]:
                    all_corners[n] = c
                    n += 1
            widest = -1.0
            for a in range(3):
                low, high = np.inf, -np.inf
                for i in range(n):
                    low = min(low, vertices[all_corners[i], a])
                    high = max(high, vertices[all_corners[i], a])
                if high - low > widest:
                    widest, axis = high - low, np.int64(a)
            for i in range(n):
                keys[i] = vertices[all_corners[i], axis]
            fill_order(keys[:n], order[:n])
            for i in range(n):
                all_places[i] = keys[order[i]]
                order[i] = all_corners[order[i]]
        corners, places = order[:n], all_places[:n]
        for i in range(begin, end):
            found = 0
            if not alone:
                found = _corners_between(
                    vertices, corners, places, axis, starts[i], ends[i], tolerance, hits, along
                )
            pieces = grown(pieces, count + found + 1)
            here = starts[i]
            for k in range(found + 1):
                following = hits[k] if k < found else ends[i]
                pieces[count, 0] = i
                pieces[count, 1] = here
                pieces[count, 2] = following
                here = following
                count += 1
    return pieces[:count].copy()


@kernel
def connected(count, triangles, edges):
    """Return (count,) the least corner that each corner hangs together with."""
    parent = np.arange(count)
    for i in range(len(triangles)):
        join(parent, triangles[i, 0], triangles[i, 1])
        join(parent, triangles[i, 1], triangles[i, 2])
    for i in range(len(edges)):
        join(parent, edges[i, 0], edges[i, 1])
    roots(parent)
    return parent


@kernel
def merge_straight(starts, ends, places, tolerance):
    """Join straight runs of directed edges between corners at ``places``; return which edges stay.

    ``ends`` is changed: an edge that stays runs to the end of its run.
    """
    corners = len(places)
    into, out = np.zeros(corners, dtype=np.int64), np.zeros(corners, dtype=np.int64)
    edge_into, edge_out = np.empty(corners, dtype=np.int64), np.empty(corners, dtype=np.int64)
    for i in range(len(starts)):
        out[starts[i]] += 1
        edge_out[starts[i]] = i
        into[ends[i]] += 1
        edge_into[ends[i]] = i
    stays = np.ones(len(starts), dtype=np.bool_)
    for v in range(corners):
        if into[v] != 1 or out[v] != 1:
            continue
        before, after = starts[edge_into[v]], ends[edge_out[v]]
        if v in (before, after):
            continue
        length2, along, offset2 = 0.0, 0.0, 0.0
        for a in range(3):
            span = places[after, a] - places[before, a]
            offset = places[v, a] - places[before, a]
            length2 += span * span
            along += offset * span
            offset2 += offset * offset
        if length2 == 0.0 or along <= 0.0 or along >= length2:
            continue
        aside2 = 0.0
        for a in range(3):
            offset = places[v, a] - places[before, a]
            aside2 += (offset - along / length2 * (places[after, a] - places[before, a])) ** 2
        if aside2 > tolerance * tolerance:
            continue
        stays[edge_out[v]] = False
        ends[edge_into[v]] = after
        if into[after] == 1:
            edge_into[after] = edge_into[v]
    return stays
