# mypy: allow-untyped-defs
"""Compiled search of the path that all receivers of a box have to one image, by its corners.

Where lines from a box to an image pierce a plane on their way, they do so within the hull of where
those of its corners do: a projection with one sign of its denominator keeps hulls, and so does one
after the other. Where the corners' points are clear of everything that the search for one receiver
decides by, by far more than rounding, all receivers of the box are decided alike.
"""

import numpy as np

from octant.em.paths._facet_kernels import INSIDE, ON_RIM, OUTSIDE, winds_around
from octant.em.paths._neighbour_kernels import TOUCHING
from octant.geometries.kernels import kernel

CORNERS = 8

SLACK = 100.0
"""Allowance [tolerances of the scene] of every test, far above rounding."""

FLAT = 1e6
"""Height of an image over a plane [tolerances] below which nothing is concluded."""

WAY_NODE, WAY_PLANE, WAY_FACET, CURSOR = 0, 1, 2, 3
"""Columns of a way: one row per reflection counted from the receivers."""

NO_PATH, CLEAR, NEAR, UNSURE = 0, 1, 2, 3
"""What a box has: no path; one, the same for all; one that something may stand in or touch; or what
is left to each receiver."""


@kernel
def box_scratch(max_order):
    """Return the corners' points by depth, the way being tried, and the one found."""
    return (
        np.empty((max_order + 2, CORNERS, 3)),
        np.zeros((max_order + 2, 4), dtype=np.int64),
        np.zeros((max_order + 2, 4), dtype=np.int64),
    )


@kernel(forceinline=True)
def _fill_corners(boxes, box, points):
    """Fill the corners of a box, of which a flat one has fewer; return how many it has."""
    count = 1
    for a in range(3):
        points[0, 0, a] = boxes[box, a]
    for a in range(3):
        if boxes[box, 3 + a] > boxes[box, a]:
            for c in range(count):
                for b in range(3):
                    points[0, count + c, b] = points[0, c, b]
                points[0, count + c, a] = boxes[box, 3 + a]
            count *= 2
    return count


@kernel(forceinline=True)
def _place_on_facet(facet_box, facet_outline, outline, facet, u0, v0, u1, v1, slack):
    """Return where a rectangle of its plane lies with respect to a facet; across is on the rim."""
    u_low, v_low = facet_box[facet, 0], facet_box[facet, 1]
    u_high, v_high = facet_box[facet, 2], facet_box[facet, 3]
    if u0 > u_high + slack or v0 > v_high + slack or u1 < u_low - slack or v1 < v_low - slack:
        return OUTSIDE
    begin, end = facet_outline[facet, 0], facet_outline[facet, 1]
    if begin == end:
        within = (
            u0 >= u_low + slack
            and v0 >= v_low + slack
            and u1 <= u_high - slack
            and v1 <= v_high - slack
        )
        return INSIDE if within else ON_RIM
    u, v = 0.5 * (u0 + u1), 0.5 * (v0 + v1)
    for i in range(begin, end):
        a0, b0, a1, b1 = (
            outline[i, 0],
            outline[i, 1],
            outline[i, 2],
            outline[i, 3],
        )
        if (
            max(a0, a1) < u0 - slack
            or max(b0, b1) < v0 - slack
            or min(a0, a1) > u1 + slack
            or min(b0, b1) > v1 + slack
        ):
            continue
        du, dv = a1 - a0, b1 - b0
        reach = 0.5 * (abs(du) * (v1 - v0) + abs(dv) * (u1 - u0))
        reach += slack * np.sqrt(du * du + dv * dv)
        if abs(du * (v - b0) - (u - a0) * dv) <= reach:
            return ON_RIM
    return winds_around(outline, begin, end, u, v, 0.0)


@kernel
def _leg_has(
    boxes,
    links,
    triangles,
    triangle_planes,
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    outline,
    points,
    depth,
    count,
    plane_p,
    plane_q,
    slack,
):
    """Return CLEAR where nothing is near the hull of a leg but the planes that it ends on.

    NO_PATH where one facet stands between all of its ends, else NEAR.
    """
    x0, y0, z0 = np.inf, np.inf, np.inf
    x1, y1, z1 = -np.inf, -np.inf, -np.inf
    for k in range(depth, depth + 2 if len(links) > 0 else depth):
        for c in range(count):
            x, y, z = points[k, c, 0], points[k, c, 1], points[k, c, 2]
            x0, y0, z0 = min(x0, x - slack), min(y0, y - slack), min(z0, z - slack)
            x1, y1, z1 = max(x1, x + slack), max(y1, y + slack), max(z1, z + slack)
    dx = points[depth + 1, 0, 0] - points[depth, 0, 0]
    dy = points[depth + 1, 0, 1] - points[depth, 0, 1]
    dz = points[depth + 1, 0, 2] - points[depth, 0, 2]
    node, found, tried = 0, CLEAR, -1
    while node < len(links):
        if (
            (boxes[node, 0] > x1)
            | (boxes[node, 1] > y1)
            | (boxes[node, 2] > z1)
            | (boxes[node, 3] < x0)
            | (boxes[node, 4] < y0)
            | (boxes[node, 5] < z0)
        ):
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            plane = triangle_planes[i]
            if plane in (plane_p, plane_q):
                continue
            ax, ay, az = triangles[i, 3], triangles[i, 4], triangles[i, 5]
            bx, by, bz = triangles[i, 6], triangles[i, 7], triangles[i, 8]
            cx, cy, cz = bx - ax, by - ay, bz - az
            # Two convex bodies are apart along a normal of the one or across an edge of each.
            if (
                _apart(triangles, i, points, depth, count, 1.0, 0.0, 0.0, slack)
                or _apart(triangles, i, points, depth, count, 0.0, 1.0, 0.0, slack)
                or _apart(triangles, i, points, depth, count, 0.0, 0.0, 1.0, slack)
                or _apart(
                    triangles,
                    i,
                    points,
                    depth,
                    count,
                    ay * bz - az * by,
                    az * bx - ax * bz,
                    ax * by - ay * bx,
                    slack,
                )
                or _apart(
                    triangles,
                    i,
                    points,
                    depth,
                    count,
                    ay * dz - az * dy,
                    az * dx - ax * dz,
                    ax * dy - ay * dx,
                    slack,
                )
                or _apart(
                    triangles,
                    i,
                    points,
                    depth,
                    count,
                    by * dz - bz * dy,
                    bz * dx - bx * dz,
                    bx * dy - by * dx,
                    slack,
                )
                or _apart(
                    triangles,
                    i,
                    points,
                    depth,
                    count,
                    cy * dz - cz * dy,
                    cz * dx - cx * dz,
                    cx * dy - cy * dx,
                    slack,
                )
            ):
                continue
            found = NEAR
            if plane != tried and _hides(
                planes,
                plane_facet_start,
                facet_box,
                facet_outline,
                outline,
                plane,
                points,
                depth,
                count,
                slack,
            ):
                return NO_PATH
            tried = plane
        node += 1
    return found


@kernel
def _apart(triangles, i, points, depth, count, nx, ny, nz, slack):
    """Return whether a triangle and the hull of a leg are apart along a direction."""
    first = nx * triangles[i, 0] + ny * triangles[i, 1] + nz * triangles[i, 2]
    a = nx * triangles[i, 3] + ny * triangles[i, 4] + nz * triangles[i, 5]
    b = nx * triangles[i, 6] + ny * triangles[i, 7] + nz * triangles[i, 8]
    least, most = np.inf, -np.inf
    for k in range(depth, depth + 2):
        for c in range(count):
            place = nx * points[k, c, 0] + ny * points[k, c, 1] + nz * points[k, c, 2]
            least, most = min(least, place), max(most, place)
    reach = slack * np.sqrt(nx * nx + ny * ny + nz * nz)
    return least > first + max(0.0, a, b) + reach or most < first + min(0.0, a, b) - reach


@kernel
def _hides(
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    outline,
    plane,
    points,
    depth,
    count,
    slack,
):
    """Return whether a facet of a plane stands between all ends of a leg."""
    nx, ny, nz, offset = planes[plane, 0], planes[plane, 1], planes[plane, 2], planes[plane, 3]
    u0, v0, u1, v1 = np.inf, np.inf, -np.inf, -np.inf
    sides = 0
    for c in range(count):
        px, py, pz = points[depth, c, 0], points[depth, c, 1], points[depth, c, 2]
        qx, qy, qz = points[depth + 1, c, 0], points[depth + 1, c, 1], points[depth + 1, c, 2]
        here = nx * px + ny * py + nz * pz - offset
        there = nx * qx + ny * qy + nz * qz - offset
        if here > slack and there < -slack:
            sides |= 1
        elif here < -slack and there > slack:
            sides |= 2
        else:
            return False
        t = here / (here - there)
        hx, hy, hz = px + t * (qx - px), py + t * (qy - py), pz + t * (qz - pz)
        u = hx * planes[plane, 4] + hy * planes[plane, 5] + hz * planes[plane, 6]
        v = hx * planes[plane, 7] + hy * planes[plane, 8] + hz * planes[plane, 9]
        u0, v0, u1, v1 = min(u0, u), min(v0, v), max(u1, u), max(v1, v)
    for facet in range(plane_facet_start[plane], plane_facet_start[plane + 1]):
        if sides != 3 and (
            _place_on_facet(facet_box, facet_outline, outline, facet, u0, v0, u1, v1, slack)
            == INSIDE
        ):
            return True
    return False


@kernel(forceinline=True)
def _meet(scene, plane, before, image, node, points, depth, count, slack):
    """Fill where lines to an image pierce a plane; return the facet, -1: none, -2: unsure."""
    nx, ny, nz = scene.planes[plane, 0], scene.planes[plane, 1], scene.planes[plane, 2]
    offset = scene.planes[plane, 3]
    ux, uy, uz = scene.planes[plane, 4], scene.planes[plane, 5], scene.planes[plane, 6]
    vx, vy, vz = scene.planes[plane, 7], scene.planes[plane, 8], scene.planes[plane, 9]
    ix, iy, iz = image[node, 0], image[node, 1], image[node, 2]
    image_height = nx * ix + ny * iy + nz * iz - offset
    if abs(image_height) <= FLAT * scene.tolerance:
        return -2
    side = 1.0 if image_height > 0.0 else -1.0
    nearest, farthest = np.inf, -np.inf
    u0, v0, u1, v1 = np.inf, np.inf, -np.inf, -np.inf
    for c in range(count):
        px, py, pz = points[depth, c, 0], points[depth, c, 1], points[depth, c, 2]
        height = nx * px + ny * py + nz * pz - offset
        nearest, farthest = min(nearest, side * height), max(farthest, side * height)
        t = height / (height - image_height)
        hx, hy, hz = px + t * (ix - px), py + t * (iy - py), pz + t * (iz - pz)
        points[depth + 1, c, 0], points[depth + 1, c, 1], points[depth + 1, c, 2] = hx, hy, hz
        u = hx * ux + hy * uy + hz * uz
        v = hx * vx + hy * vy + hz * vz
        u0, v0, u1, v1 = min(u0, u), min(v0, v), max(u1, u), max(v1, v)
    if nearest > slack:
        return -1
    if farthest >= -slack:
        return -2
    for facet in range(scene.plane_facet_start[plane], scene.plane_facet_start[plane + 1]):
        where = _place_on_facet(
            scene.facet_box, scene.facet_outline, scene.outline, facet, u0, v0, u1, v1, slack
        )
        if where == ON_RIM:
            return -2
        if where == INSIDE:
            # Nor may a point lie on the plane that the leg comes from.
            for c in range(count if before >= 0 else 0):
                height = -scene.planes[before, 3]
                for a in range(3):
                    height += scene.planes[before, a] * points[depth + 1, c, a]
                if abs(height) <= slack:
                    return -2
            return facet
    return -1


@kernel(forceinline=True)
def _legs_have(scene, blocks, links, triangles, planes, points, trail, order, count, slack):
    """Return what `_leg_has`, of all legs of a way."""
    found = CLEAR
    for k in range(order + 1 if len(links) > 0 else 0):
        leg = _leg_has(
            blocks,
            links,
            triangles,
            planes,
            scene.planes,
            scene.plane_facet_start,
            scene.facet_box,
            scene.facet_outline,
            scene.outline,
            points,
            k,
            count,
            trail[k - 1, WAY_PLANE] if k > 0 else -1,
            trail[k, WAY_PLANE] if k < order else -1,
            slack,
        )
        if leg == NO_PATH:
            return NO_PATH
        found = max(found, leg)
    return found


@kernel(forceinline=True)
def search_box(
    scene, blocks, links, triangles, planes, margin, tree, leaf, falling, boxes, box, scratch
):
    """Return what all receivers of a box have of an image; a path's way is in the last of scratch.

    ``blocks`` to ``margin`` are of what blocks them, ``falling`` says in which order they read
    branches.
    """
    points, trail, way = scratch
    slack = max(SLACK * scene.tolerance, 2.0 * TOUCHING * margin)
    count = _fill_corners(boxes, box, points)
    order = tree.order[leaf]
    found = NO_PATH
    depth = 0
    trail[0, WAY_NODE], trail[0, CURSOR] = leaf, 0
    while depth >= 0:
        here = trail[depth, WAY_NODE]
        if depth == order:
            if found != NO_PATH or not _ends_apart(tree.image, points, depth, count, slack):
                return UNSURE
            legs = _legs_have(
                scene, blocks, links, triangles, planes, points, trail, order, count, slack
            )
            depth -= 1
            if legs == NO_PATH:
                continue
            for k in range(order):
                way[k, WAY_NODE], way[k, WAY_PLANE] = trail[k, WAY_NODE], trail[k, WAY_PLANE]
                way[k, WAY_FACET] = trail[k, WAY_FACET]
            # Who is blocked may read the image by another way.
            found = legs
            if found == CLEAR:
                return CLEAR
            continue
        tried = trail[depth, CURSOR]
        begin, end = tree.branch_start[here], tree.branch_start[here + 1]
        if tried == end - begin:
            depth -= 1
            continue
        trail[depth, CURSOR] = tried + 1
        branch = end - 1 - tried if falling else begin + tried
        plane = tree.branches[branch, 0]
        before = trail[depth - 1, WAY_PLANE] if depth > 0 else -1
        # Merged images join branches of which some repeat the plane just used.
        if plane == before:
            continue
        facet = _meet(scene, plane, before, tree.image, here, points, depth, count, slack)
        if facet == -2:
            return UNSURE
        if facet >= 0:
            trail[depth, WAY_PLANE], trail[depth, WAY_FACET] = plane, facet
            depth += 1
            trail[depth, WAY_NODE], trail[depth, CURSOR] = tree.branches[branch, 1], 0
    return found


@kernel(forceinline=True)
def _ends_apart(image, points, depth, count, slack):
    """Return whether the source is outside the box of the last points; make it the next ones."""
    apart = False
    for a in range(3):
        low, high = np.inf, -np.inf
        for c in range(count):
            low, high = min(low, points[depth, c, a]), max(high, points[depth, c, a])
        apart = apart or image[0, a] < low - slack or image[0, a] > high + slack
        for c in range(count):
            points[depth + 1, c, a] = image[0, a]
    return apart
