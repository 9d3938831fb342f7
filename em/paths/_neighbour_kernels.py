# mypy: allow-untyped-defs
"""Compiled decision on paths that touch something: those that a path close by has as well count.

Where a reflection falls on a rim, on the foot of a partition or into a corner, where an edge is met
at its very end or a leg has no length, each test of the search for itself passes within its
tolerance, though together they may belong to no path: the double reflection at a convex edge, the
reflection under a partition. So such a path is searched again between ends that are moved by about
a micrometre to many sides, where nothing touches.
"""

import numpy as np

from octant.em.paths._edge_point_kernels import (
    SECTOR_TOLERANCE,
    best_place,
    in_sector,
    two_points,
)
from octant.em.paths._facet_kernels import ON_RIM, OUTSIDE, place_on_facet
from octant.geometries._bvh_kernels import segment_blocked, two_planes
from octant.geometries._wedge_kernels import one_facet
from octant.geometries.kernels import kernel

TOUCHING = 8.0
"""Distance [margins of the hierarchy] up to which something touches a path."""

MOVE = 200.0
"""Distance [margins of the hierarchy] by which the ends are moved, about 1e-6 m in a room."""

STRICT = 0.01
"""Share of the margins [-] within which hits at the ends of a neighbour's legs are ignored."""

NUDGE = 0.002
"""Share of a move [-] by which a neighbour that has a path is moved once more, and must have it
still: else one slips by chance, within `STRICT`, through the foot of a partition."""

# Six fractions evenly spread in six dimensions: multiples of the powers of 1 / g, g^7 = g + 1.
_STEPS = 1.0 / 1.1127756842787053 ** np.arange(1.0, 7.0)
_APART = 2.0 * ((0.5 + np.arange(1.0, 49.0)[:, None] * _STEPS) % 1.0) - 1.0
_TOGETHER = np.hstack((_APART[:24, :3], _APART[:24, :3] + 0.05 * _APART[:24, 3:]))
MOVES = np.vstack((_TOGETHER, _APART))
"""(n, 6) moves [-1 to 1] of the end that is first in space, and of the other.

First both go the same way almost: what runs along a face then stays on one side of it.
"""


@kernel
def comes_first(x, y, z, ox, oy, oz):
    """Return whether a point comes before another in space: what does not depend on who sends."""
    return x < ox or (x == ox and (y < oy or (y == oy and z < oz)))


@kernel(forceinline=True)
def _ends(points, row, order):
    """Return the places of receiver and source of a path."""
    return (
        points[row, 0, 0],
        points[row, 0, 1],
        points[row, 0, 2],
        points[row, order + 1, 0],
        points[row, order + 1, 1],
        points[row, order + 1, 2],
    )


@kernel
def touched(
    boxes, links, triangles, owner, by_facet, facet_plane, plane_a, plane_b, x, y, z, reach
):
    """Return whether a triangle may touch a point [m], those of two planes left out.

    ``owner`` is the facet of each triangle, or its plane.
    """
    node = 0
    while node < len(links):
        if (
            x < boxes[node, 0] - reach
            or y < boxes[node, 1] - reach
            or z < boxes[node, 2] - reach
            or x > boxes[node, 3] + reach
            or y > boxes[node, 4] + reach
            or z > boxes[node, 5] + reach
        ):
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            plane = facet_plane[owner[i]] if by_facet else owner[i]
            if plane in (plane_a, plane_b):
                continue
            px, py, pz = x - triangles[i, 0], y - triangles[i, 1], z - triangles[i, 2]
            ax, ay, az = triangles[i, 3], triangles[i, 4], triangles[i, 5]
            bx, by, bz = triangles[i, 6], triangles[i, 7], triangles[i, 8]
            if (
                px < min(0.0, ax, bx) - reach
                or py < min(0.0, ay, by) - reach
                or pz < min(0.0, az, bz) - reach
                or px > max(0.0, ax, bx) + reach
                or py > max(0.0, ay, by) + reach
                or pz > max(0.0, az, bz) + reach
            ):
                continue
            nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            size = np.sqrt(nx * nx + ny * ny + nz * nz)
            if abs(nx * px + ny * py + nz * pz) <= reach * size:
                return True
        node += 1
    return False


@kernel(forceinline=True)
def _planes_of(code, facet_plane, wedge_facets):
    """Return the one or two planes that a path touches at an interaction."""
    if code >= 0:
        return facet_plane[code], facet_plane[code]
    return facet_plane[wedge_facets[-1 - code, 0]], facet_plane[wedge_facets[-1 - code, 1]]


@kernel
def _over_a_face(wedge_facets, code, other):
    """Return whether two interactions are at edges of one facet, over which the ray may run."""
    return code < 0 and other < 0 and one_facet(wedge_facets, -1 - code, -1 - other)


@kernel
def _along(planes, plane, wedge_facets, points, facets, row, order, reach):
    """Return whether a leg runs within a plane, the one between two edges of a facet left out."""
    near = False
    for v in range(order + 2):
        height = -planes[plane, 3]
        for a in range(3):
            height += planes[plane, a] * points[row, v, a]
        here = abs(height) <= reach
        between = 1 < v <= order and _over_a_face(
            wedge_facets, facets[row, v - 2], facets[row, v - 1]
        )
        if near and here and not between:
            return True
        near = here
    return False


@kernel
def touches(
    planes,
    facet_box,
    facet_outline,
    facet_plane,
    outline,
    tolerance,
    boxes,
    links,
    triangles,
    triangle_planes,
    sheet_boxes,
    sheet_links,
    sheets,
    sheet_facets,
    margin,
    wedge_frame,
    wedge_facets,
    points,
    facets,
    row,
    order,
):
    """Return whether a path has a leg of no length or touches more than it interacts with.

    So does one that runs along a face of its edge, where it meets the rims of others.
    """
    reach = TOUCHING * margin
    for i in range(order + 1):
        leg = 0.0
        for a in range(3):
            leg = max(leg, abs(points[row, i + 1, a] - points[row, i, a]))
        if leg <= reach:
            return True
    for i in range(order):
        code = facets[row, i]
        x, y, z = points[row, i + 1, 0], points[row, i + 1, 1], points[row, i + 1, 2]
        plane_a, plane_b = _planes_of(code, facet_plane, wedge_facets)
        if code >= 0:
            u = x * planes[plane_a, 4] + y * planes[plane_a, 5] + z * planes[plane_a, 6]
            v = x * planes[plane_a, 7] + y * planes[plane_a, 8] + z * planes[plane_a, 9]
            where = place_on_facet(facet_box, facet_outline, outline, code, u, v, tolerance)
            if where == ON_RIM:
                return True
        else:
            w = -1 - code
            along = 0.0
            for a in range(3):
                along += (points[row, i + 1, a] - wedge_frame[w, a]) * wedge_frame[w, 3 + a]
            if along <= reach or along >= wedge_frame[w, 13] - reach:
                return True
            for plane in (plane_a, plane_b):
                if _along(planes, plane, wedge_facets, points, facets, row, order, reach):
                    return True
        if touched(
            boxes,
            links,
            triangles,
            triangle_planes,
            False,
            facet_plane,
            plane_a,
            plane_b,
            x,
            y,
            z,
            reach,
        ) or touched(
            sheet_boxes,
            sheet_links,
            sheets,
            sheet_facets,
            True,
            facet_plane,
            plane_a,
            plane_b,
            x,
            y,
            z,
            reach,
        ):
            return True
    return False


@kernel
def _mirror(planes, plane, point, image):
    """Fill the image of a point over a plane; return the point's height over it [m]."""
    height = -planes[plane, 3]
    for a in range(3):
        height += planes[plane, a] * point[a]
    for a in range(3):
        image[a] = point[a] - 2.0 * height * planes[plane, a]
    return height


@kernel
def _reflections(
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    facet_plane,
    outline,
    facets,
    row,
    begin,
    end,
    images,
    near,
):
    """Fill the reflections between vertices begin and end; return whether they are on facets."""
    for a in range(3):
        images[end, a] = near[end, a]
    for v in range(end - 1, begin, -1):
        _mirror(planes, facet_plane[facets[row, v - 1]], images[v + 1], images[v])
    for v in range(begin + 1, end):
        plane = facet_plane[facets[row, v - 1]]
        here, there = -planes[plane, 3], -planes[plane, 3]
        for a in range(3):
            here += planes[plane, a] * near[v - 1, a]
            there += planes[plane, a] * images[v, a]
        if not here * there < 0.0:
            return False
        t = here / (here - there)
        hu, hv = 0.0, 0.0
        for a in range(3):
            near[v, a] = near[v - 1, a] + t * (images[v, a] - near[v - 1, a])
            hu += near[v, a] * planes[plane, 4 + a]
            hv += near[v, a] * planes[plane, 7 + a]
        hit = False
        for facet in range(plane_facet_start[plane], plane_facet_start[plane + 1]):
            place = place_on_facet(facet_box, facet_outline, outline, facet, hu, hv, 0.0)
            hit = hit or place != OUTSIDE
        if not hit:
            return False
    return True


@kernel
def beside_edge(wedge_frame, w, point):
    """Return the distance of a point from the line of a wedge's edge, and its place along it."""
    along, across, up = 0.0, 0.0, 0.0
    for a in range(3):
        offset = point[a] - wedge_frame[w, a]
        along += offset * wedge_frame[w, 3 + a]
        across += offset * wedge_frame[w, 6 + a]
        up += offset * wedge_frame[w, 9 + a]
    return np.sqrt(across * across + up * up), along


@kernel
def at_tip(wedge_frame, w, points, row, v, reach):
    """Return 0 or 1 where a vertex of a path is the tip at its edge's start or end, else -1."""
    along = 0.0
    for a in range(3):
        along += (points[row, v, a] - wedge_frame[w, a]) * wedge_frame[w, 3 + a]
    for end in range(2):
        if wedge_frame[w, 14 + end] > 0.0 and abs(along - end * wedge_frame[w, 13]) <= reach:
            return end
    return -1


@kernel(returns="boolean")
def _edge_points(
    planes, facet_plane, wedge_frame, points, facets, row, order, last, first, reach, images, near
):
    """Fill the points on a path's edges, vertices last and first; return whether it has them.

    A path over the tip of an edge meets it there, whether or not its point of diffraction is off.
    """
    for a in range(3):
        images[0, a], images[1, a] = near[0, a], near[order + 1, a]
    for v in range(1, last):
        _mirror(planes, facet_plane[facets[row, v - 1]], images[0], images[0])
    for v in range(order, first, -1):
        _mirror(planes, facet_plane[facets[row, v - 1]], images[1], images[1])
    w, one = -1 - facets[row, last - 1], -1 - facets[row, first - 1]
    distance_r, along_r = beside_edge(wedge_frame, w, images[0])
    distance_s, along_s = beside_edge(wedge_frame, one, images[1])
    if last == first:
        end = at_tip(wedge_frame, w, points, row, last, reach)
        if end >= 0:
            t = end * wedge_frame[w, 13]
        elif distance_s + distance_r == 0.0:
            return False
        else:
            t = along_s + (along_r - along_s) * distance_s / (distance_s + distance_r)
        s = t
    else:
        start = at_tip(wedge_frame, one, points, row, first, reach)
        end = at_tip(wedge_frame, w, points, row, last, reach)
        s, t, found = start * wedge_frame[one, 13], end * wedge_frame[w, 13], True
        if start < 0 and end < 0:
            s, t, found = two_points(wedge_frame, one, w, distance_s, along_s, distance_r, along_r)
        elif end < 0:
            t, found = best_place(wedge_frame, one, w, s, distance_r, along_r)
        elif start < 0:
            s, found = best_place(wedge_frame, w, one, t, distance_s, along_s)
        if not found:
            return False
    if not (0.0 <= t <= wedge_frame[w, 13] and 0.0 <= s <= wedge_frame[one, 13]):
        return False
    for a in range(3):
        near[last, a] = wedge_frame[w, a] + t * wedge_frame[w, 3 + a]
        near[first, a] = wedge_frame[one, a] + s * wedge_frame[one, 3 + a]
    return True


@kernel(returns="int64")
def neighbour_has(
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    facet_plane,
    outline,
    boxes,
    links,
    triangles,
    triangle_planes,
    margin,
    wedge_frame,
    wedge_facets,
    points,
    facets,
    row,
    order,
    near,
    begin,
):
    """Return the number of the first move, from 1, whose ends have the path of a row too; 0: none.

    ``near`` (n, 3) is filled by that path; ``begin`` moves are left out. Which end is moved how
    depends on which is first in space, not on which sends.
    """
    images = np.empty((order + 2, 3))
    own = np.empty(2, dtype=np.int64)
    ends = order + 1
    reach = TOUCHING * margin
    last, first = 0, 0
    for v in range(1, ends):
        if facets[row, v - 1] < 0:
            last, first = v if last == 0 else last, v
    for v in (last, first):
        if v > 0 and at_tip(wedge_frame, -1 - facets[row, v - 1], points, row, v, reach) >= 0:
            for other in (v - 1, v + 1):
                leg = 0.0
                for a in range(3):
                    leg = max(leg, abs(points[row, v, a] - points[row, other, a]))
                if leg <= reach:
                    return 0  # nothing reflects in a tip
    # Between edges of one face, or from a tip in its plane, the leg stays in it for all moves.
    along_face = False
    if first > last > 0:
        along_face = (
            _over_a_face(wedge_facets, facets[row, last - 1], facets[row, first - 1])
            or at_tip(wedge_frame, -1 - facets[row, last - 1], points, row, last, reach) >= 0
            or at_tip(wedge_frame, -1 - facets[row, first - 1], points, row, first, reach) >= 0
        )
    at_receiver = 0 if comes_first(*_ends(points, row, order)) else 3
    good = False
    for k in range(2 * begin, 2 * len(MOVES)):
        # Each move first by itself, then, if the path is there, nudged towards the next.
        move, again = k // 2, k % 2
        if again and not good:
            continue
        after, nudge = (move + 1) % len(MOVES), NUDGE * again
        for a in range(3):
            here = MOVES[move, at_receiver + a] + nudge * MOVES[after, at_receiver + a]
            there = MOVES[move, 3 - at_receiver + a] + nudge * MOVES[after, 3 - at_receiver + a]
            near[0, a] = points[row, 0, a] + MOVE * margin * here
            near[ends, a] = points[row, ends, a] + MOVE * margin * there
        good = last == 0 or _edge_points(
            planes,
            facet_plane,
            wedge_frame,
            points,
            facets,
            row,
            order,
            last,
            first,
            reach,
            images,
            near,
        )
        start = 0
        for end in (last, first, ends):
            if good and end > start:
                good = _reflections(
                    planes,
                    plane_facet_start,
                    facet_box,
                    facet_outline,
                    facet_plane,
                    outline,
                    facets,
                    row,
                    start,
                    end,
                    images,
                    near,
                )
                start = end
        for v in range(1, ends):
            if good and facets[row, v - 1] < 0:
                for other in (v - 1, v + 1):
                    on_face = last <= other <= first and along_face
                    good = good and in_sector(
                        wedge_frame,
                        -1 - facets[row, v - 1],
                        near[other, 0] - near[v, 0],
                        near[other, 1] - near[v, 1],
                        near[other, 2] - near[v, 2],
                        SECTOR_TOLERANCE if on_face else 0.0,
                    )
        for v in range(ends):
            if not good:
                break
            for side in range(2):
                code = v - 1 + side
                own[side] = -1
                if 0 <= code < order:
                    plane_a, plane_b = _planes_of(facets[row, code], facet_plane, wedge_facets)
                    own[side] = plane_a if plane_a == plane_b else two_planes(plane_a, plane_b)
            good = not segment_blocked(
                boxes,
                links,
                triangles,
                triangle_planes,
                STRICT * margin,
                near[v, 0],
                near[v, 1],
                near[v, 2],
                near[v + 1, 0],
                near[v + 1, 1],
                near[v + 1, 2],
                own[0],
                own[1],
            )
        if good and again:
            return move + 1
    return 0


@kernel(returns="boolean")
def read_otherwise(
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    facet_plane,
    outline,
    boxes,
    links,
    triangles,
    triangle_planes,
    margin,
    wedge_frame,
    wedge_facets,
    points,
    facets,
    row,
    order,
    near,
):
    """Return whether a path over an edge is one that is read better with two interactions swapped.

    At the foot of an edge a ray may be reflected before or behind it, in a corner by either wall
    first. Seen from the end that is first in space, edges come before walls, and walls in falling
    order of their planes, as in the search for paths without edges.
    """
    receiver_first = comes_first(*_ends(points, row, order))
    for i in range(order - 1):
        leg = 0.0
        for a in range(3):
            leg = max(leg, abs(points[row, i + 1, a] - points[row, i + 2, a]))
        if leg > TOUCHING * margin:
            continue
        here, there = facets[row, i], facets[row, i + 1]
        ahead, behind = (here, there) if receiver_first else (there, here)
        if ahead < 0 or (behind >= 0 and facet_plane[ahead] >= facet_plane[behind]):
            continue
        facets[row, i], facets[row, i + 1] = there, here
        found = neighbour_has(
            planes,
            plane_facet_start,
            facet_box,
            facet_outline,
            facet_plane,
            outline,
            boxes,
            links,
            triangles,
            triangle_planes,
            margin,
            wedge_frame,
            wedge_facets,
            points,
            facets,
            row,
            order,
            near,
            0,
        )
        facets[row, i], facets[row, i + 1] = here, there
        if found > 0:
            return True
    return False


@kernel
def counts(
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    facet_plane,
    outline,
    tolerance,
    boxes,
    links,
    triangles,
    triangle_planes,
    sheet_boxes,
    sheet_links,
    sheets,
    sheet_facets,
    margin,
    wedge_frame,
    wedge_facets,
    points,
    facets,
    row,
    order,
    near,
    touching,
):
    """Return whether a path of a row counts: it touches nothing, or a neighbour has it as well.

    ``touching[row]`` is 0, or the number of the neighbour, whose vertices are in ``near[row]``.
    """
    touching[row] = 0
    if not touches(
        planes,
        facet_box,
        facet_outline,
        facet_plane,
        outline,
        tolerance,
        boxes,
        links,
        triangles,
        triangle_planes,
        sheet_boxes,
        sheet_links,
        sheets,
        sheet_facets,
        margin,
        wedge_frame,
        wedge_facets,
        points,
        facets,
        row,
        order,
    ):
        return True
    over_edge = False
    for i in range(order):
        over_edge = over_edge or facets[row, i] < 0
    if over_edge and read_otherwise(
        planes,
        plane_facet_start,
        facet_box,
        facet_outline,
        facet_plane,
        outline,
        boxes,
        links,
        triangles,
        triangle_planes,
        margin,
        wedge_frame,
        wedge_facets,
        points,
        facets,
        row,
        order,
        near[row],
    ):
        return False
    touching[row] = neighbour_has(
        planes,
        plane_facet_start,
        facet_box,
        facet_outline,
        facet_plane,
        outline,
        boxes,
        links,
        triangles,
        triangle_planes,
        margin,
        wedge_frame,
        wedge_facets,
        points,
        facets,
        row,
        order,
        near[row],
        0,
    )
    return touching[row] > 0
