# mypy: allow-untyped-defs
"""Compiled exact path finding: from images and a receiver to reflection points, or nothing."""

import numpy as np

from octant.em.paths._facet_kernels import OUTSIDE, place_on_facet
from octant.em.paths._neighbour_kernels import comes_first, counts
from octant.em.paths._transmission_kernels import MAX_CROSSINGS
from octant.em.records import CHUNK
from octant.geometries._bvh_kernels import segment_blocked
from octant.geometries.kernels import kernel

FACET, PLANE, NODE, CURSOR = 0, 1, 2, 3
"""Columns of the search state, one row per reflection counted from the receiver."""

RECEIVER, SOURCE = 0, 1
"""Columns of its last row: where an end is a point of an edge, its two planes, packed; else -1."""


@kernel(forceinline=True)
def inside_supporting_planes(supporting, x, y, z):
    """Return whether a point is on the inner side of every plane that bounds the whole scene."""
    for i in range(len(supporting)):
        height = supporting[i, 0] * x + supporting[i, 1] * y + supporting[i, 2] * z
        if height < supporting[i, 3]:
            return False
    return True


@kernel(forceinline=True)
def path_is_free(boxes, links, triangles, triangle_planes, margin, points, state, row, order):
    """Return whether every segment of a path is free; each ignores the planes that it ends on."""
    ends = len(state) - 1
    for i in range(order + 1):
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
            state[i - 1, PLANE] if i > 0 else state[ends, RECEIVER],
            state[i, PLANE] if i < order else state[ends, SOURCE],
        ):
            return False
    return True


@kernel
def known_already(points, first, last, order, tolerance):
    """Return whether row ``last`` repeats one of the rows from ``first`` on, vertex by vertex."""
    for row in range(first, last):
        distance = 0.0
        for k in range(order + 2):
            for a in range(3):
                distance = max(distance, abs(points[row, k, a] - points[last, k, a]))
        if distance <= tolerance:
            return True
    return False


@kernel
def find_paths(
    leaves,
    image,
    order_of,
    branch_start,
    branches,
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
    x,
    y,
    z,
    falling,
    whole,
    several,
    first,
    last,
    row,
    state,
    points,
    facets,
    orders,
    near,
    touching,
):
    """Return the row after those of the paths that images first to last of ``leaves`` give.

    The reflection points are found backwards, from the receiver towards the source: each is where
    the line from the last point to the image pierces the branch's plane, within one of its facets.
    From ``row`` on, ``points`` receives receiver, reflections and source, ``facets`` the facet of
    each reflection in the same sense, ``orders`` the number of reflections. Where receiver or
    source is a point of an edge, the last row of the state names its planes, which do not block or
    reflect there. ``several`` asks for every path of an image; else the first is the only one.
    ``whole`` says that the ends are antennas, so that :func:`counts` decides on paths that touch
    something.

    A path exactly through the edge of two walls may be read as a reflection by either first. Which
    reading is taken must not depend on which end sends, or reciprocity would fail there: branches
    are sorted by plane, and tried in falling order where the receiver comes first in space, else in
    rising order.
    """
    found = row
    ends = len(state) - 1
    for place in range(first, last):
        leaf = leaves[place]
        order = order_of[leaf]
        depth = 0
        found_before = found
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
                for k in range(order):
                    facets[found, k] = state[k, FACET]
                if path_is_free(
                    boxes, links, triangles, triangle_planes, margin, points, state, found, order
                ) and (
                    not whole
                    or counts(
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
                        found,
                        order,
                        near,
                        touching,
                    )
                ):
                    orders[found] = order
                    # Of an image that touches something, two ways may meet in one rim.
                    room = len(orders) - found > last - place + 1
                    if not (several or (whole and touching[found] > 0 and room)):
                        found += 1
                        break
                    if not known_already(points, found_before, found, order, 10.0 * tolerance):
                        found += 1
                        for k in range(order + 1):
                            for a in range(3):
                                points[found, k, a] = points[found - 1, k, a]
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
            # Merged images join branches of which some repeat the plane just used, and an edge
            # cannot be seen in the planes that it lies in.
            if depth > 0:
                if plane == state[depth - 1, PLANE]:
                    continue
            elif plane in (state[ends, RECEIVER] & 0xFFFFFFFF, (state[ends, RECEIVER] >> 32) - 1):
                continue
            nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
            ix, iy, iz = image[here, 0], image[here, 1], image[here, 2]
            px, py, pz = points[found, depth, 0], points[found, depth, 1], points[found, depth, 2]
            image_height = nx * ix + ny * iy + nz * iz - planes[plane, 3]
            point_height = nx * px + ny * py + nz * pz - planes[plane, 3]
            # Behind an edge that ends on the plane, its point is its own image. A way that runs
            # within the plane meets it nowhere.
            if abs(image_height) <= tolerance:
                t = 1.0
                apart = max(abs(ix - px), abs(iy - py), abs(iz - pz))
                if abs(point_height) <= tolerance < apart:
                    continue
            elif image_height > 0.0:
                if point_height > tolerance:
                    continue
                t = max(point_height / (point_height - image_height), 0.0)
            else:
                if point_height < -tolerance:
                    continue
                t = max(point_height / (point_height - image_height), 0.0)
            hx, hy, hz = px + t * (ix - px), py + t * (iy - py), pz + t * (iz - pz)
            u = hx * planes[plane, 4] + hy * planes[plane, 5] + hz * planes[plane, 6]
            v = hx * planes[plane, 7] + hy * planes[plane, 8] + hz * planes[plane, 9]
            hit = -1
            for facet in range(plane_facet_start[plane], plane_facet_start[plane + 1]):
                where = place_on_facet(facet_box, facet_outline, outline, facet, u, v, tolerance)
                if where != OUTSIDE:
                    hit = facet
                    break
            if hit < 0:
                continue
            state[depth, FACET] = hit
            state[depth, PLANE] = plane
            depth += 1
            points[found, depth, 0] = hx
            points[found, depth, 1] = hy
            points[found, depth, 2] = hz
            state[depth, NODE] = branches[branch, 1]
            state[depth, CURSOR] = 0
    return found


@kernel(forceinline=True)
def path_rows(rows, width):
    """Return points, and codes of interactions, of paths of up to ``width`` interactions.

    Of one vertex the rows stand together, so that several paths are worked out at once.
    """
    return (
        np.empty((3, width + 2, rows)).T,
        np.empty((width + 1, rows), dtype=np.int64).T,
    )


@kernel
def make_scratch(max_order, ways, transmits, rows):
    """Return state, points, facets and orders for chunks of paths of up to ``max_order`` bends.

    Behind them come the points of neighbours, and the number of that of a path that touches
    something. Each row has room for the sheets that a path may pass through besides.
    """
    width = max_order + (MAX_CROSSINGS if transmits else 0)
    rows = max(rows, 2 * CHUNK, ways) + 1
    points, facets = path_rows(rows, width)
    return (
        np.empty((max_order + 3, 4), dtype=np.int64),
        points,
        facets,
        np.empty(rows, dtype=np.int64),
        np.empty((3, width + 2, rows)).T,
        np.zeros(rows, dtype=np.int64),
    )


@kernel(forceinline=True)
def search_chunk(scene, tree, x, y, z, first, last, row, whole):
    """Return the row after those of the paths to x, y, z over the images from first to last."""
    bvh, sheets = scene.bvh, scene.sheet_bvh
    state, points, facets, orders, near, touching = whole
    image = tree.image
    state[len(state) - 1, :] = -1
    if inside_supporting_planes(scene.supporting, x, y, z) and inside_supporting_planes(
        scene.supporting, image[0, 0], image[0, 1], image[0, 2]
    ):
        bvh = scene.inner_bvh
    return find_paths(
        tree.leaves,
        image,
        tree.order,
        tree.branch_start,
        tree.branches,
        scene.planes,
        scene.plane_facet_start,
        scene.facet_box,
        scene.facet_outline,
        scene.facet_plane,
        scene.outline,
        scene.tolerance,
        bvh.boxes,
        bvh.links,
        bvh.triangles,
        bvh.planes,
        sheets.boxes,
        sheets.links,
        sheets.triangles,
        sheets.planes,
        bvh.margin,
        scene.wedge_frame,
        scene.wedge_facets,
        x,
        y,
        z,
        comes_first(x, y, z, image[0, 0], image[0, 1], image[0, 2]),
        True,
        scene.transmits,
        first,
        last,
        row,
        state,
        points,
        facets,
        orders,
        near,
        touching,
    )
