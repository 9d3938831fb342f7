# mypy: allow-untyped-defs
"""Compiled search for the sheets that a path passes straight through."""

import numpy as np
from numba import njit

from octant.em.paths._neighbour_kernels import MOVE, MOVES, comes_first
from octant.em.records import TRANSMISSION
from octant.geometries._bvh_kernels import crossing

MAX_CROSSINGS = 128
"""Sheets that one path may pass through; a path through more counts as blocked."""


@njit(cache=True, error_model="numpy")
def crossings(
    boxes,
    links,
    triangles,
    triangle_facets,
    margin,
    facet_plane,
    px,
    py,
    pz,
    qx,
    qy,
    qz,
    plane_a,
    plane_b,
    plane_c,
    plane_d,
    rising,
    places,
    facets,
):
    """Return how many sheets stand strictly between p and q; fill places 0..1 and facets in order.

    Those met in one place stand by their planes, ``rising`` or falling. One plane counts once,
    whatever its meshing; planes ``plane_a`` to ``plane_d`` do not count. A number above the length
    of the arrays says that they were too short.
    """
    count = 0
    dx, dy, dz = qx - px, qy - py, qz - pz
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    if length == 0.0:
        return 0
    near = margin / length
    far = 1.0 - near
    ix, iy, iz = 1.0 / dx, 1.0 / dy, 1.0 / dz
    node = 0
    while node < len(links):
        t0, t1 = (boxes[node, 0] - px) * ix, (boxes[node, 3] - px) * ix
        enter, leave = min(t0, t1), max(t0, t1)
        t0, t1 = (boxes[node, 1] - py) * iy, (boxes[node, 4] - py) * iy
        enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        t0, t1 = (boxes[node, 2] - pz) * iz, (boxes[node, 5] - pz) * iz
        enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        if enter > leave or leave < near or enter > far:
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            facet = triangle_facets[i]
            plane = facet_plane[facet]
            if plane in (plane_a, plane_b, plane_c, plane_d):
                continue
            t = crossing(triangles, i, px, py, pz, dx, dy, dz)
            if not near < t < far:
                continue
            known = False
            for k in range(count):
                if facet_plane[facets[k]] == plane:
                    # Two facets of one plane share a rim there: the lower number stands for both.
                    facets[k] = min(facets[k], facet)
                    known = True
            if known:
                continue
            if count == len(places):
                return count + 1
            k = count
            while k > 0 and places[k - 1] > t - near:
                before = facet_plane[facets[k - 1]] < plane
                if places[k - 1] <= t + near and before == rising:
                    break
                places[k], facets[k] = places[k - 1], facets[k - 1]
                k -= 1
            places[k], facets[k] = t, facet
            count += 1
        node += 1
    return count


@njit(cache=True, error_model="numpy")
def sheets_between(
    boxes,
    links,
    triangles,
    triangle_facets,
    margin,
    facet_plane,
    px,
    py,
    pz,
    qx,
    qy,
    qz,
    plane_a,
    plane_b,
    plane_c,
    plane_d,
    rising,
    places,
    facets,
):
    """Return what :func:`crossings` does, of a leg close by where sheets are met on their rims.

    A leg through the edge in which two sheets meet crosses one of them or both, as its neighbours
    do. Of these one that crosses most is taken, as a rim that is touched counts as met.
    """
    count = crossings(
        boxes,
        links,
        triangles,
        triangle_facets,
        margin,
        facet_plane,
        px,
        py,
        pz,
        qx,
        qy,
        qz,
        plane_a,
        plane_b,
        plane_c,
        plane_d,
        rising,
        places,
        facets,
    )
    length = np.sqrt((qx - px) ** 2 + (qy - py) ** 2 + (qz - pz) ** 2)
    tied = False
    for k in range(1, min(count, len(places))):
        tied = tied or (places[k] - places[k - 1]) * length <= 2.0 * margin
    if not tied:
        return count
    most, best = -1, 0
    for k in range(len(MOVES) + 1):
        move = MOVES[k if k < len(MOVES) else best]
        x, y, z = MOVE * margin * move[0], MOVE * margin * move[1], MOVE * margin * move[2]
        count = crossings(
            boxes,
            links,
            triangles,
            triangle_facets,
            margin,
            facet_plane,
            px + x,
            py + y,
            pz + z,
            qx + x,
            qy + y,
            qz + z,
            plane_a,
            plane_b,
            plane_c,
            plane_d,
            rising,
            places,
            facets,
        )
        if count > most:
            most, best = count, k
    return count


@njit(cache=True, error_model="numpy")
def _planes_of(code, facet_plane, wedge_facets):
    """Return the one or two planes that a path touches at an interaction."""
    if code >= 0:
        return facet_plane[code], -1
    return facet_plane[wedge_facets[-1 - code, 0]], facet_plane[wedge_facets[-1 - code, 1]]


@njit(cache=True, error_model="numpy")
def insert_crossings(
    boxes,
    links,
    triangles,
    triangle_facets,
    margin,
    facet_plane,
    wedge_facets,
    found,
    points,
    facets,
    orders,
    near,
    touching,
):
    """Return how many of ``found`` paths are left, with the sheets they pass through among theirs.

    Rows hold receiver, interactions and source; those that pass through too many sheets are
    dropped, the others move up. A path that touches something passes the sheets of its neighbour.
    """
    places = np.empty(MAX_CROSSINGS)
    sheets = np.empty(MAX_CROSSINGS, dtype=np.int64)
    new_points = np.empty((points.shape[1], 3))
    new_facets = np.empty(facets.shape[1], dtype=np.int64)
    left = 0
    for p in range(found):
        order = orders[p]
        last = order + 1
        rising = comes_first(
            points[p, 0, 0],
            points[p, 0, 1],
            points[p, 0, 2],
            points[p, last, 0],
            points[p, last, 1],
            points[p, last, 2],
        )
        size = 0
        fits = True
        for leg in range(order + 1):
            a, b = (
                (-1, -1) if leg == 0 else _planes_of(facets[p, leg - 1], facet_plane, wedge_facets)
            )
            c, d = (-1, -1)
            if leg < order:
                c, d = _planes_of(facets[p, leg], facet_plane, wedge_facets)
            ways = near if touching[p] else points
            px, py, pz = ways[p, leg, 0], ways[p, leg, 1], ways[p, leg, 2]
            qx, qy, qz = ways[p, leg + 1, 0], ways[p, leg + 1, 1], ways[p, leg + 1, 2]
            count = sheets_between(
                boxes,
                links,
                triangles,
                triangle_facets,
                margin,
                facet_plane,
                px,
                py,
                pz,
                qx,
                qy,
                qz,
                a,
                b,
                c,
                d,
                rising,
                places,
                sheets,
            )
            # The middle leg of a double diffraction runs along a facet: there a sheet stands on it.
            middle = 0 < leg < order and facets[p, leg - 1] < 0 and facets[p, leg] < 0
            room = len(new_facets) - size - (order - leg)
            if count > room or count > MAX_CROSSINGS or (middle and count > 0):
                fits = False
                break
            px, py, pz = points[p, leg, 0], points[p, leg, 1], points[p, leg, 2]
            qx, qy, qz = points[p, leg + 1, 0], points[p, leg + 1, 1], points[p, leg + 1, 2]
            for k in range(count):
                t = places[k]
                new_facets[size] = TRANSMISSION + sheets[k]
                new_points[size, 0] = px + t * (qx - px)
                new_points[size, 1] = py + t * (qy - py)
                new_points[size, 2] = pz + t * (qz - pz)
                size += 1
            if leg < order:
                new_facets[size] = facets[p, leg]
                new_points[size, 0], new_points[size, 1], new_points[size, 2] = qx, qy, qz
                size += 1
        if not fits:
            continue
        for a in range(3):
            source = points[p, order + 1, a]
            points[left, 0, a] = points[p, 0, a]
            for k in range(size):
                points[left, k + 1, a] = new_points[k, a]
            points[left, size + 1, a] = source
        for k in range(size):
            facets[left, k] = new_facets[k]
        orders[left] = size
        left += 1
    return left
