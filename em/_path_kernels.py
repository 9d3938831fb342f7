# mypy: allow-untyped-defs
"""Compiled exact path finding: from images and a receiver to reflection points, or nothing.

A call costs an atomic count for every array it is handed, which would outweigh the search of one
path. So each function here works through many images at a time and takes its arrays one by one.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from octant.geometries._bvh_kernels import BvhArrays, segment_blocked

CHUNK = 256
"""Images that are worked through before their paths are used: bounds the memory per receiver."""

FACET, PLANE, NODE, CURSOR, RIM = 0, 1, 2, 3, 4
"""Columns of the search state, one row per reflection counted from the receiver."""

OUTSIDE, INSIDE, ON_RIM = 0, 1, 2
"""Where a point of its plane lies with respect to a facet."""

CORNER_REACH = 1e3
"""Half the span, in margins of the hierarchy, over which hits on a rim look for obstacles."""


class TreeArrays(NamedTuple):
    """The images of one source."""

    image: np.ndarray  # (n, 3) [m]; image 0 is the source
    order: np.ndarray  # (n,) int64
    branch_start: np.ndarray  # (n + 1,) int64
    branches: np.ndarray  # (b, 2) int64: plane, parent image
    max_order: int


class SceneArrays(NamedTuple):
    """Planes, facets and hierarchies of a scene, and the facets' electrical properties."""

    planes: np.ndarray  # (p, 10): normal, offset [m], axis u, axis v
    plane_facet_start: np.ndarray  # (p + 1,) int64
    supporting_side: np.ndarray  # (p,) int64
    facet_box: np.ndarray  # (f, 4) [m]
    facet_outline: np.ndarray  # (f, 2) int64: begin, end of its outline; equal: fills its box
    facet_plane: np.ndarray  # (f,) int64
    outline: np.ndarray  # (e, 4) [m]
    bvh: BvhArrays
    inner_bvh: BvhArrays
    tolerance: float  # [m]
    facet_permittivity: np.ndarray  # (f,) complex128
    facet_thickness: np.ndarray  # (f,) in wavelengths, infinite for a half-space
    wavelength: float  # [m]


@njit(cache=True, error_model="numpy")
def winds_around(outline, begin, end, u, v, tolerance):
    """Return where a point lies with respect to the polygon of directed edges."""
    winding = 0
    for i in range(begin, end):
        u0, v0, u1, v1 = outline[i, 0], outline[i, 1], outline[i, 2], outline[i, 3]
        du, dv = u1 - u0, v1 - v0
        side = du * (v - v0) - (u - u0) * dv
        length2 = du * du + dv * dv
        if side * side <= tolerance * tolerance * length2:
            along = (u - u0) * du + (v - v0) * dv
            slack = tolerance * np.sqrt(length2)
            if -slack <= along <= length2 + slack:
                return ON_RIM
        if v0 <= v:
            if v1 > v and side > 0.0:
                winding += 1
        elif v1 <= v and side < 0.0:
            winding -= 1
    return INSIDE if winding != 0 else OUTSIDE


@njit(cache=True, error_model="numpy")
def inside_supporting_planes(planes, supporting_side, x, y, z):
    """Return whether a point is on the inner side of every plane that bounds the whole scene."""
    for plane in range(len(planes)):
        height = planes[plane, 0] * x + planes[plane, 1] * y + planes[plane, 2] * z
        if supporting_side[plane] * (height - planes[plane, 3]) < 0.0:
            return False
    return True


@njit(cache=True, error_model="numpy")
def path_is_free(boxes, links, triangles, triangle_planes, margin, points, state, row, order):
    """Return whether every segment of a path is free; each ignores the planes that it ends on."""
    for i in range(order + 1):
        plane_a = state[i - 1, PLANE] if i > 0 else -1
        plane_b = state[i, PLANE] if i < order else -1
        if segment_blocked(
            boxes,
            links,
            triangles,
            triangle_planes,
            margin,
            points[row, i, 0],
            points[row, i, 1],
            points[row, i, 2],
            points[row, i + 1, 0],
            points[row, i + 1, 1],
            points[row, i + 1, 2],
            plane_a,
            plane_b,
        ):
            return False
        on_rim = i < order and state[i, RIM] == ON_RIM
        if on_rim and corner_blocked(
            boxes, links, triangles, triangle_planes, margin, points, row, i, plane_b
        ):
            return False
    return True


@njit(cache=True, error_model="numpy")
def corner_blocked(boxes, links, triangles, triangle_planes, margin, points, row, i, plane):
    """Return whether a path that touches a facet's rim passes through a neighbour's there.

    Hits at the very ends of a segment do not count as obstacles, so a path could slip into a solid
    through its edge. The chord from just before the rim to just after it settles that.
    """
    reach = CORNER_REACH * margin
    ends = np.empty(6)
    for side in range(2):
        other = i if side == 0 else i + 2
        size = 0.0
        for a in range(3):
            size += (points[row, other, a] - points[row, i + 1, a]) ** 2
        size = np.sqrt(size)
        if size <= reach:  # the next reflection is in the same corner
            return False
        for a in range(3):
            ends[3 * side + a] = points[row, i + 1, a] + reach / size * (
                points[row, other, a] - points[row, i + 1, a]
            )
    return segment_blocked(
        boxes,
        links,
        triangles,
        triangle_planes,
        margin,
        ends[0],
        ends[1],
        ends[2],
        ends[3],
        ends[4],
        ends[5],
        plane,
        -1,
    )


@njit(cache=True, error_model="numpy")
def find_paths(
    image,
    order_of,
    branch_start,
    branches,
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    outline,
    tolerance,
    boxes,
    links,
    triangles,
    triangle_planes,
    margin,
    x,
    y,
    z,
    first,
    last,
    state,
    points,
    facets,
    orders,
):
    """Return how many of the images ``first`` to ``last`` give a path to the receiver x, y, z.

    The reflection points are found backwards, from the receiver towards the source: each is where
    the line from the last point to the image pierces the branch's plane, within one of its facets.
    Row by row, ``points`` receives receiver, reflections and source, ``facets`` the facet of each
    reflection in the same sense, ``orders`` the number of reflections.

    A path exactly through the edge of two walls may be read as a reflection by either first. Which
    reading is taken must not depend on which end sends, or reciprocity would fail there: branches
    are sorted by plane, and tried in rising or falling order by which end comes first in space.
    """
    found = 0
    falling = x < image[0, 0] or (
        x == image[0, 0] and (y < image[0, 1] or (y == image[0, 1] and z < image[0, 2]))
    )
    for leaf in range(first, last):
        order = order_of[leaf]
        depth = 0
        points[found, 0, 0] = x
        points[found, 0, 1] = y
        points[found, 0, 2] = z
        state[0, NODE] = leaf
        state[0, CURSOR] = 0
        while depth >= 0:
            here = state[depth, NODE]
            if depth == order:
                for a in range(3):
                    points[found, depth + 1, a] = image[0, a]
                if len(links) == 0 or path_is_free(
                    boxes, links, triangles, triangle_planes, margin, points, state, found, order
                ):
                    for k in range(order):
                        facets[found, k] = state[k, FACET]
                    orders[found] = order
                    found += 1
                    break
                depth -= 1
                continue
            tried = state[depth, CURSOR]
            begin, end = branch_start[here], branch_start[here + 1]
            if tried == end - begin:
                depth -= 1
                continue
            state[depth, CURSOR] = tried + 1
            branch = end - 1 - tried if falling else begin + tried
            plane = branches[branch, 0]
            # Merged images join branches of which some repeat the plane just used.
            if depth > 0 and plane == state[depth - 1, PLANE]:
                continue
            nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
            ix, iy, iz = image[here, 0], image[here, 1], image[here, 2]
            px, py, pz = points[found, depth, 0], points[found, depth, 1], points[found, depth, 2]
            image_height = nx * ix + ny * iy + nz * iz - planes[plane, 3]
            point_height = nx * px + ny * py + nz * pz - planes[plane, 3]
            if image_height > 0.0:
                if point_height > tolerance:
                    continue
            elif point_height < -tolerance:
                continue
            t = max(point_height / (point_height - image_height), 0.0)
            hx, hy, hz = px + t * (ix - px), py + t * (iy - py), pz + t * (iz - pz)
            u = hx * planes[plane, 4] + hy * planes[plane, 5] + hz * planes[plane, 6]
            v = hx * planes[plane, 7] + hy * planes[plane, 8] + hz * planes[plane, 9]
            hit = -1
            where = OUTSIDE
            for facet in range(plane_facet_start[plane], plane_facet_start[plane + 1]):
                if (
                    u < facet_box[facet, 0] - tolerance
                    or v < facet_box[facet, 1] - tolerance
                    or u > facet_box[facet, 2] + tolerance
                    or v > facet_box[facet, 3] + tolerance
                ):
                    continue
                begin, end = facet_outline[facet, 0], facet_outline[facet, 1]
                if begin < end:
                    where = winds_around(outline, begin, end, u, v, tolerance)
                elif (
                    u < facet_box[facet, 0] + tolerance
                    or v < facet_box[facet, 1] + tolerance
                    or u > facet_box[facet, 2] - tolerance
                    or v > facet_box[facet, 3] - tolerance
                ):
                    where = ON_RIM
                else:
                    where = INSIDE
                if where != OUTSIDE:
                    hit = facet
                    break
            if hit < 0:
                continue
            state[depth, RIM] = where
            state[depth, FACET] = hit
            state[depth, PLANE] = plane
            depth += 1
            points[found, depth, 0] = hx
            points[found, depth, 1] = hy
            points[found, depth, 2] = hz
            state[depth, NODE] = branches[branch, 1]
            state[depth, CURSOR] = 0
    return found


@njit(cache=True, error_model="numpy")
def search_chunk(scene, tree, x, y, z, first, state, points, facets, orders):
    """Return the number of paths to x, y, z among one chunk of images, filled in row by row."""
    bvh = scene.bvh
    image = tree.image
    if inside_supporting_planes(
        scene.planes, scene.supporting_side, x, y, z
    ) and inside_supporting_planes(
        scene.planes, scene.supporting_side, image[0, 0], image[0, 1], image[0, 2]
    ):
        bvh = scene.inner_bvh
    return find_paths(
        image,
        tree.order,
        tree.branch_start,
        tree.branches,
        scene.planes,
        scene.plane_facet_start,
        scene.facet_box,
        scene.facet_outline,
        scene.outline,
        scene.tolerance,
        bvh.boxes,
        bvh.links,
        bvh.triangles,
        bvh.planes,
        bvh.margin,
        x,
        y,
        z,
        first,
        min(first + CHUNK, len(tree.order)),
        state,
        points,
        facets,
        orders,
    )


@njit(cache=True, error_model="numpy")
def make_scratch(max_order):
    """Return state, points, facets and orders for chunks of paths of up to ``max_order``."""
    return (
        np.empty((max_order + 2, 5), dtype=np.int64),
        np.empty((CHUNK + 1, max_order + 2, 3)),
        np.empty((CHUNK + 1, max_order + 1), dtype=np.int64),
        np.empty(CHUNK + 1, dtype=np.int64),
    )


@njit(cache=True, error_model="numpy", nogil=True)
def record_paths(scene, tree, receivers, start, order, vertices, facets, counts):
    """Count the paths of each receiver, and record those that fit between start[i] and start[i+1].

    Vertices run from source to receiver. Those that a short path does not need repeat the receiver,
    facets that it does not need are -1.
    """
    state, points, hit, orders = make_scratch(tree.max_order)
    for i in range(len(receivers)):
        x, y, z = receivers[i, 0], receivers[i, 1], receivers[i, 2]
        counts[i] = 0
        for first in range(0, len(tree.order), CHUNK):
            found = search_chunk(scene, tree, x, y, z, first, state, points, hit, orders)
            for p in range(found):
                row = start[i] + counts[i]
                counts[i] += 1
                if row >= start[i + 1]:
                    continue
                n = orders[p]
                order[row] = n
                for k in range(vertices.shape[1]):
                    for a in range(3):
                        vertices[row, k, a] = points[p, max(n + 1 - k, 0), a]
                for k in range(facets.shape[1]):
                    facets[row, k] = hit[p, n - 1 - k] if k < n else -1
