# mypy: allow-untyped-defs
"""Compiled searches for edges: which corners stand on one, and which facets one rests on."""

import numpy as np

from octant.geometries._array_kernels import grown
from octant.geometries.kernels import kernel


@kernel
def _passes_box(boxes, node, start, step, tolerance):
    """Return whether a segment comes as near to a box as the tolerance."""
    least, most = 0.0, 1.0
    for a in range(3):
        low = boxes[node, a] - tolerance - start[a]
        high = boxes[node, 3 + a] + tolerance - start[a]
        if step[a] == 0.0:
            if low > 0.0 or high < 0.0:
                return False
            continue
        t, u = low / step[a], high / step[a]
        least, most = max(least, min(t, u)), min(most, max(t, u))
    return least <= most


@kernel
def cut_at_corners(places, ends, corners, boxes, links, order, tolerance):
    """Return (k, 3) edge, start and end of edges (e, 2), cut where other corners stand on them.

    The hierarchy is over ``corners``, rows of ``places``. Edges from a corner to itself are none.
    """
    pieces = np.empty((2 * len(ends) + 16, 3), dtype=np.int64)
    hits, along = np.empty(16, dtype=np.int64), np.empty(16)
    step = np.empty(3)
    count = 0
    for i in range(len(ends)):
        a, b = ends[i, 0], ends[i, 1]
        if a == b:
            continue
        start = places[a]
        length = 0.0
        for k in range(3):
            step[k] = places[b, k] - start[k]
            length += step[k] * step[k]
        length = np.sqrt(length)
        found = 0
        node = 0
        while node < len(links):
            if not _passes_box(boxes, node, start, step, 2.0 * tolerance):
                node = links[node, 0]
                continue
            for j in range(links[node, 1], links[node, 1] + links[node, 2]):
                corner = corners[order[j]]
                x, y, z = (
                    places[corner, 0] - start[0],
                    places[corner, 1] - start[1],
                    places[corner, 2] - start[2],
                )
                t = (x * step[0] + y * step[1] + z * step[2]) / length
                if t <= tolerance or t >= length - tolerance:
                    continue
                s = t / length
                x, y, z = x - s * step[0], y - s * step[1], z - s * step[2]
                if np.sqrt(x * x + y * y + z * z) > tolerance:
                    continue
                if found == len(hits):
                    more, further = np.empty(2 * found, dtype=np.int64), np.empty(2 * found)
                    for k in range(found):
                        more[k], further[k] = hits[k], along[k]
                    hits, along = more, further
                place = found
                while place > 0 and along[place - 1] > t:
                    along[place], hits[place] = along[place - 1], hits[place - 1]
                    place -= 1
                along[place], hits[place] = t, corner
                found += 1
            node += 1
        pieces = grown(pieces, count + found + 1)
        for k in range(found + 1):
            pieces[count, 0] = i
            pieces[count, 1] = a if k == 0 else hits[k - 1]
            pieces[count, 2] = hits[k] if k < found else b
            count += 1
    return pieces[:count].copy()


@kernel
def _within(outline, begin, end, u, v, tolerance):
    """Return whether a point of a facet's plane lies in it, and not on its rim."""
    winding = 0
    for i in range(begin, end):
        du, dv = outline[i, 2] - outline[i, 0], outline[i, 3] - outline[i, 1]
        pu, pv = u - outline[i, 0], v - outline[i, 1]
        t = min(max((pu * du + pv * dv) / (du * du + dv * dv), 0.0), 1.0)
        if np.hypot(pu - t * du, pv - t * dv) <= tolerance:
            return False
        side = du * pv - pu * dv
        if outline[i, 1] <= v:
            winding += outline[i, 3] > v and side > 0.0
        else:
            winding -= outline[i, 3] <= v and side < 0.0
    return winding != 0


@kernel
def facets_rested_on(
    ends,
    boxes,
    links,
    order,
    facet_plane,
    normal,
    offset,
    plane_u,
    plane_v,
    outline_start,
    outline,
    tolerance,
):
    """Return (k, 2) edge, by number, and facet where an edge (e, 2, 3) lies within a facet.

    The hierarchy is over the facets, whose boxes are larger than they by the tolerance.
    """
    pairs = np.empty((64, 2), dtype=np.int64)
    count = 0
    middle = np.empty(3)
    for e in range(len(ends)):
        for a in range(3):
            middle[a] = 0.5 * (ends[e, 0, a] + ends[e, 1, a])
        node = 0
        while node < len(links):
            outside = False
            for a in range(3):
                outside |= middle[a] < boxes[node, a] or middle[a] > boxes[node, 3 + a]
            if outside:
                node = links[node, 0]
                continue
            for j in range(links[node, 1], links[node, 1] + links[node, 2]):
                facet = order[j]
                plane = facet_plane[facet]
                u, v, height = 0.0, 0.0, 0.0
                for end in range(2):
                    own = -offset[plane]
                    for a in range(3):
                        own += normal[plane, a] * ends[e, end, a]
                    height = max(height, abs(own))
                if height > tolerance:
                    continue
                for a in range(3):
                    u += middle[a] * plane_u[plane, a]
                    v += middle[a] * plane_v[plane, a]
                if _within(
                    outline, outline_start[facet], outline_start[facet + 1], u, v, tolerance
                ):
                    pairs = grown(pairs, count + 1)
                    pairs[count, 0], pairs[count, 1] = e, facet
                    count += 1
            node += 1
    return pairs[:count].copy()


@kernel
def one_facet(facets, first, second):
    """Return whether two wedges bound one facet; ``facets`` (w, 2) are their faces."""
    for i in range(2):
        for j in range(2):
            if facets[first, i] == facets[second, j]:
                return True
    return False
