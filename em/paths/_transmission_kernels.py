# mypy: allow-untyped-defs
"""Compiled search for the sheets that a path passes straight through."""

import numpy as np

from octant.em.paths._facet_kernels import ON_RIM, place_on_facet
from octant.em.paths._neighbour_kernels import STRICT, comes_first, neighbour_has, touched
from octant.em.records import TRANSMISSION
from octant.geometries._bvh_kernels import crossing
from octant.geometries.kernels import kernel

MAX_CROSSINGS = 128
"""Sheets that one path may pass through; a path through more counts as blocked."""


@kernel
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


@kernel
def _meets_others(scene, points, p, leg, places, sheets, count, k):
    """Return whether a leg meets sheet k in an edge of it where other sheets are met too."""
    bvh, facet = scene.sheet_bvh, sheets[k]
    plane = scene.facet_plane[facet]
    at = np.empty(3)
    u, v = 0.0, 0.0
    length = 0.0
    for a in range(3):
        way = points[p, leg + 1, a] - points[p, leg, a]
        at[a] = points[p, leg, a] + places[k] * way
        u += at[a] * scene.planes[plane, 4 + a]
        v += at[a] * scene.planes[plane, 7 + a]
        length += way * way
    on_rim = place_on_facet(
        scene.facet_box, scene.facet_outline, scene.outline, facet, u, v, scene.tolerance
    )
    if on_rim != ON_RIM:
        return False
    near = 2.0 * bvh.margin / np.sqrt(length)
    for other in (k - 1, k + 1):
        if 0 <= other < count and abs(places[other] - places[k]) <= near:
            return True
    return touched(
        bvh.boxes,
        bvh.links,
        bvh.triangles,
        bvh.planes,
        True,
        scene.facet_plane,
        plane,
        plane,
        at[0],
        at[1],
        at[2],
        2.0 * bvh.margin,
    )


@kernel
def _planes_of(code, facet_plane, wedge_facets):
    """Return the one or two planes that a path touches at an interaction."""
    if code >= 0:
        return facet_plane[code], -1
    return facet_plane[wedge_facets[-1 - code, 0]], facet_plane[wedge_facets[-1 - code, 1]]


@kernel(returns="int64")
def insert_crossings(scene, found, points, facets, orders, near, touching):
    """Return how many of ``found`` paths are left, with the sheets they pass through among theirs.

    Rows hold receiver, interactions and source; those that pass through too many sheets are
    dropped, the others move up. A path that touches something passes the sheets of its neighbour,
    and so does one through an edge in which sheets meet: of these it passes those that places
    beside the edge do. A free rim that is touched hides.
    """
    bvh, sheet_bvh = scene.bvh, scene.sheet_bvh
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
        tried = touching[p] > 0
        leg = 0
        while leg <= order:
            a, b = (-1, -1)
            if leg > 0:
                a, b = _planes_of(facets[p, leg - 1], scene.facet_plane, scene.wedge_facets)
            c, d = (-1, -1)
            if leg < order:
                c, d = _planes_of(facets[p, leg], scene.facet_plane, scene.wedge_facets)
            ways, margin = points, sheet_bvh.margin
            if touching[p] > 0:
                ways, margin = near, STRICT * margin
            count = crossings(
                sheet_bvh.boxes,
                sheet_bvh.links,
                sheet_bvh.triangles,
                sheet_bvh.planes,
                margin,
                scene.facet_plane,
                ways[p, leg, 0],
                ways[p, leg, 1],
                ways[p, leg, 2],
                ways[p, leg + 1, 0],
                ways[p, leg + 1, 1],
                ways[p, leg + 1, 2],
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
            if count > room or count > MAX_CROSSINGS:
                fits = False
                break
            in_sheet = middle and count > 0
            rim = False
            for k in range(0 if tried else count):
                rim = rim or _meets_others(scene, points, p, leg, places, sheets, count, k)
            if rim or (in_sheet and touching[p] > 0):  # the next neighbour may pass beside
                tried = True
                touching[p] = neighbour_has(
                    scene.planes,
                    scene.plane_facet_start,
                    scene.facet_box,
                    scene.facet_outline,
                    scene.facet_plane,
                    scene.outline,
                    bvh.boxes,
                    bvh.links,
                    bvh.triangles,
                    bvh.planes,
                    bvh.margin,
                    scene.wedge_frame,
                    scene.wedge_facets,
                    points,
                    facets,
                    p,
                    order,
                    near[p],
                    touching[p],
                )
                if touching[p] > 0:
                    leg, size = 0, 0
                    continue
            if in_sheet:
                fits = False
                break
            for k in range(count):
                new_facets[size] = TRANSMISSION + sheets[k]
                for axis in range(3):
                    here = points[p, leg, axis]
                    new_points[size, axis] = here + places[k] * (points[p, leg + 1, axis] - here)
                size += 1
            if leg < order:
                new_facets[size] = facets[p, leg]
                for axis in range(3):
                    new_points[size, axis] = points[p, leg + 1, axis]
                size += 1
            leg += 1
        if not fits:
            continue
        for axis in range(3):
            source = points[p, order + 1, axis]
            points[left, 0, axis] = points[p, 0, axis]
            for k in range(size):
                points[left, k + 1, axis] = new_points[k, axis]
            points[left, size + 1, axis] = source
        for k in range(size):
            facets[left, k] = new_facets[k]
        orders[left] = size
        left += 1
    return left
