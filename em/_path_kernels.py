"""Compiled exact path finding: from an image and a receiver to the reflection points, or nothing."""

from typing import NamedTuple

import numpy as np
from numba import njit

from octant.geometries._bvh_kernels import BvhArrays, segment_blocked


class TreeArrays(NamedTuple):
    """The images of one source."""

    image: np.ndarray  # (n, 3) [m]
    order: np.ndarray  # (n,) int64
    branch_start: np.ndarray  # (n + 1,) int64
    branch_plane: np.ndarray  # (b,) int64
    branch_parent: np.ndarray  # (b,) int64
    max_order: int


class SceneArrays(NamedTuple):
    """Planes, facets and hierarchies of a scene, and the facets' electrical properties."""

    plane_normal: np.ndarray  # (p, 3)
    plane_offset: np.ndarray  # (p,) [m]
    plane_u: np.ndarray  # (p, 3)
    plane_v: np.ndarray  # (p, 3)
    plane_facet_start: np.ndarray  # (p + 1,) int64
    supporting_side: np.ndarray  # (p,) int64
    facet_bounds: np.ndarray  # (f, 4) [m]
    facet_is_rectangle: np.ndarray  # (f,) bool
    outline_start: np.ndarray  # (f + 1,) int64
    outline: np.ndarray  # (e, 4) [m]
    bvh: BvhArrays
    inner_bvh: BvhArrays
    tolerance: float  # [m]
    facet_permittivity: np.ndarray  # (f,) complex128
    facet_thickness_wavelengths: np.ndarray  # (f,), infinite for a half-space
    wavelength: float  # [m]


class PathScratch(NamedTuple):
    """Working memory of one thread, for paths of up to so many reflections."""

    points: np.ndarray  # (order + 2, 3): receiver, reflections backwards, source [m]
    facets: np.ndarray  # (order + 1,) int64: facet of each reflection
    planes: np.ndarray  # (order + 2,) int64: its plane
    node: np.ndarray  # (order + 2,) int64
    cursor: np.ndarray  # (order + 2,) int64


@njit(cache=True, error_model="numpy")
def make_scratch(max_order):
    """Return working memory for paths of up to ``max_order`` reflections."""
    return PathScratch(
        np.empty((max_order + 2, 3)),
        np.empty(max_order + 1, dtype=np.int64),
        np.empty(max_order + 2, dtype=np.int64),
        np.empty(max_order + 2, dtype=np.int64),
        np.empty(max_order + 2, dtype=np.int64),
    )


@njit(cache=True, error_model="numpy")
def winds_around(outline, begin, end, u, v, tolerance):
    """Return whether directed edges wind around a point or pass within the tolerance of it."""
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
                return True
        if v0 <= v:
            if v1 > v and side > 0.0:
                winding += 1
        elif v1 <= v and side < 0.0:
            winding -= 1
    return winding != 0


@njit(cache=True, error_model="numpy")
def facet_at(scene, plane, x, y, z):
    """Return the facet of a plane that holds a point of it, -1 for none."""
    first, last = scene.plane_facet_start[plane], scene.plane_facet_start[plane + 1]
    pu, pv = scene.plane_u[plane], scene.plane_v[plane]
    u = x * pu[0] + y * pu[1] + z * pu[2]
    v = x * pv[0] + y * pv[1] + z * pv[2]
    tolerance = scene.tolerance
    for facet in range(first, last):
        box = scene.facet_bounds[facet]
        if (
            u < box[0] - tolerance
            or v < box[1] - tolerance
            or u > box[2] + tolerance
            or v > box[3] + tolerance
        ):
            continue
        if scene.facet_is_rectangle[facet] or winds_around(
            scene.outline,
            scene.outline_start[facet],
            scene.outline_start[facet + 1],
            u,
            v,
            tolerance,
        ):
            return facet
    return -1


@njit(cache=True, error_model="numpy")
def inside_supporting_planes(scene, x, y, z):
    """Return whether a point is on the inner side of every plane that bounds the whole scene."""
    for plane in range(len(scene.plane_offset)):
        side = scene.supporting_side[plane]
        if side != 0:
            n = scene.plane_normal[plane]
            if side * (n[0] * x + n[1] * y + n[2] * z - scene.plane_offset[plane]) < 0.0:
                return False
    return True


@njit(cache=True, error_model="numpy")
def _free(scene, inner, scratch, order):
    """Return whether every segment of the path in the scratch memory is free."""
    bvh = scene.inner_bvh if inner else scene.bvh
    points, planes = scratch.points, scratch.planes
    for i in range(order + 1):
        plane_a = planes[i - 1] if i > 0 else -1
        plane_b = planes[i] if i < order else -1
        if segment_blocked(
            bvh,
            points[i, 0],
            points[i, 1],
            points[i, 2],
            points[i + 1, 0],
            points[i + 1, 1],
            points[i + 1, 2],
            plane_a,
            plane_b,
        ):
            return False
    return True


@njit(cache=True, error_model="numpy")
def find_path(scene, tree, image, inner, scratch):
    """Return whether the image gives a path to the receiver at ``scratch.points[0]``.

    The reflection points are found backwards, from the receiver towards the source: each is where
    the line from the last point to the image pierces the branch's plane, within one of its facets.
    The path is left in the scratch memory. The bool ``inner`` says that receiver and source lie
    inside every supporting plane, so that those cannot block.
    """
    points, node, cursor = scratch.points, scratch.node, scratch.cursor
    order = tree.order[image]
    depth = 0
    node[0] = image
    cursor[0] = tree.branch_start[image]
    while depth >= 0:
        here = node[depth]
        if depth == order:
            points[depth + 1] = tree.image[0]
            if _free(scene, inner, scratch, order):
                return True
            depth -= 1
            continue
        if cursor[depth] == tree.branch_start[here + 1]:
            depth -= 1
            continue
        branch = cursor[depth]
        cursor[depth] += 1
        plane = tree.branch_plane[branch]
        # Merged images join branches of which some repeat the plane just used.
        if depth > 0 and plane == scratch.planes[depth - 1]:
            continue
        nx, ny, nz = (
            scene.plane_normal[plane, 0],
            scene.plane_normal[plane, 1],
            scene.plane_normal[plane, 2],
        )
        ix, iy, iz = tree.image[here, 0], tree.image[here, 1], tree.image[here, 2]
        px, py, pz = points[depth, 0], points[depth, 1], points[depth, 2]
        image_height = nx * ix + ny * iy + nz * iz - scene.plane_offset[plane]
        point_height = nx * px + ny * py + nz * pz - scene.plane_offset[plane]
        if image_height > 0.0:
            if point_height > scene.tolerance:
                continue
        elif point_height < -scene.tolerance:
            continue
        t = point_height / (point_height - image_height)
        t = max(t, 0.0)
        x, y, z = px + t * (ix - px), py + t * (iy - py), pz + t * (iz - pz)
        facet = facet_at(scene, plane, x, y, z)
        if facet < 0:
            continue
        scratch.facets[depth] = facet
        scratch.planes[depth] = plane
        depth += 1
        points[depth, 0] = x
        points[depth, 1] = y
        points[depth, 2] = z
        parent = tree.branch_parent[branch]
        node[depth] = parent
        cursor[depth] = tree.branch_start[parent]
    return False


@njit(cache=True, error_model="numpy", nogil=True)
def count_paths(scene, tree, receivers, counts):
    """Fill (m,) number of paths to each receiver."""
    scratch = make_scratch(tree.max_order)
    source = tree.image[0]
    source_inside = inside_supporting_planes(scene, source[0], source[1], source[2])
    for i in range(len(receivers)):
        scratch.points[0] = receivers[i]
        inner = source_inside and inside_supporting_planes(
            scene, receivers[i, 0], receivers[i, 1], receivers[i, 2]
        )
        total = 0
        for image in range(len(tree.order)):
            if find_path(scene, tree, image, inner, scratch):
                total += 1
        counts[i] = total


@njit(cache=True, error_model="numpy", nogil=True)
def record_paths(scene, tree, receivers, start, order, vertices, facets):
    """Fill the paths of receiver i from row ``start[i]``: order, vertices from source to receiver.

    Unused vertices of short paths repeat the receiver, unused facets are -1.
    """
    scratch = make_scratch(tree.max_order)
    source = tree.image[0]
    source_inside = inside_supporting_planes(scene, source[0], source[1], source[2])
    for i in range(len(receivers)):
        scratch.points[0] = receivers[i]
        inner = source_inside and inside_supporting_planes(
            scene, receivers[i, 0], receivers[i, 1], receivers[i, 2]
        )
        row = start[i]
        for image in range(len(tree.order)):
            if not find_path(scene, tree, image, inner, scratch):
                continue
            n = tree.order[image]
            order[row] = n
            for k in range(vertices.shape[1]):
                vertices[row, k] = scratch.points[max(n + 1 - k, 0)]
            for k in range(facets.shape[1]):
                facets[row, k] = scratch.facets[n - 1 - k] if k < n else -1
            row += 1
