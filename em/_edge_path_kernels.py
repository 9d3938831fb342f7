# mypy: allow-untyped-defs
"""Compiled exact path finding over edges: from an unfolded edge and a receiver to its paths.

An edge image is an edge mirrored by every plane between it and the receiver; a source image stands
for every reflection before it. The diffraction point then follows from two distances and two
heights, and the rest is the image method towards either end.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from octant.em._path_kernels import (
    INSIDE,
    corner_blocked,
    facet_at,
    find_paths,
    inside_supporting_planes,
    known_already,
)
from octant.geometries._bvh_kernels import segment_blocked

SECTOR_TOLERANCE = 1e-7
"""Angle [rad] by which a ray may leave a wedge's sector of air: rays along a face have rounding."""

STATIONARY = 1e-6
"""Slope [-] of a path's length over two edges, up to which its two points count as the shortest."""

NEWTON_STEPS = 40
"""Steps [-] after which the two points of a double diffraction count as not found."""


class EdgeTreeArrays(NamedTuple):
    """Edge images of one source: k images, n nodes (a source image each)."""

    wedge: np.ndarray  # (k,) int64: the wedge that diffracts last
    frame: np.ndarray  # (k, 12): mirrored origin [m], axis, tangent, normal
    plane_start: np.ndarray  # (k + 1,) int64
    planes: np.ndarray  # (s,) int64: planes from the edge to the receiver, in that order
    node_start: np.ndarray  # (k + 1,) int64
    leaf: np.ndarray  # (n,) int64: image of the source
    first: np.ndarray  # (n,) int64: the wedge that diffracts first, -1 for a single diffraction
    source: np.ndarray  # (n, 2): the image's distance from the first edge's line, its place along
    reach: np.ndarray  # (n, 2): part of the last edge that can be lit, from and to [m]
    ways: int  # greatest number of paths that one image of the source can give
    rows: int  # room for paths that the largest edge image may need
    max_order: int


@njit(cache=True, error_model="numpy")
def in_sector(wedge_frame, wedge, dx, dy, dz):
    """Return whether a direction away from the edge points into the wedge's air, faces included."""
    across = dx * wedge_frame[wedge, 6] + dy * wedge_frame[wedge, 7] + dz * wedge_frame[wedge, 8]
    up = dx * wedge_frame[wedge, 9] + dy * wedge_frame[wedge, 10] + dz * wedge_frame[wedge, 11]
    angle = np.arctan2(up, across)
    if angle < 0.0:
        angle += 2.0 * np.pi
    return (
        angle <= wedge_frame[wedge, 12] + SECTOR_TOLERANCE
        or angle >= 2.0 * np.pi - SECTOR_TOLERANCE
    )


@njit(cache=True, error_model="numpy")
def two_points(wedge_frame, first, last, distance_s, along_s, distance_r, along_r):
    """Return where the shortest path meets two edges, as lengths along them, and if it was found.

    The source stands ``distance_s`` off the first edge's line at ``along_s``, the receiver likewise
    off the last. The length is a convex function of the two places: Newton's method with halved
    steps.
    """
    ax, ay, az = wedge_frame[first, 3], wedge_frame[first, 4], wedge_frame[first, 5]
    bx, by, bz = wedge_frame[last, 3], wedge_frame[last, 4], wedge_frame[last, 5]
    ox = wedge_frame[last, 0] - wedge_frame[first, 0]
    oy = wedge_frame[last, 1] - wedge_frame[first, 1]
    oz = wedge_frame[last, 2] - wedge_frame[first, 2]
    ab = ax * bx + ay * by + az * bz
    s, t = along_s, along_r
    best = np.inf
    ds, dt = 0.0, 0.0
    smooth = False
    for _ in range(NEWTON_STEPS):
        for _ in range(NEWTON_STEPS):
            vx, vy, vz = ox + t * bx - s * ax, oy + t * by - s * ay, oz + t * bz - s * az
            r = np.sqrt(vx * vx + vy * vy + vz * vz)
            r1 = np.sqrt(distance_s * distance_s + (s - along_s) ** 2)
            r3 = np.sqrt(distance_r * distance_r + (t - along_r) ** 2)
            length = r1 + r + r3
            if length <= best:
                break
            ds, dt = 0.5 * ds, 0.5 * dt
            s, t = s - ds, t - dt
        best = length
        if r == 0.0 or r1 == 0.0 or r3 == 0.0:
            return s, t, False
        va, vb = (vx * ax + vy * ay + vz * az) / r, (vx * bx + vy * by + vz * bz) / r
        gs, gt = (s - along_s) / r1 - va, (t - along_r) / r3 + vb
        hss = distance_s * distance_s / r1**3 + (1.0 - va * va) / r
        htt = distance_r * distance_r / r3**3 + (1.0 - vb * vb) / r
        hst = (va * vb - ab) / r
        det = hss * htt - hst * hst
        if det <= 0.0:
            return s, t, False
        ds, dt = -(htt * gs - hst * gt) / det, -(hss * gt - hst * gs) / det
        # Where the edges meet, the length has a kink, at which no ray is diffracted by either.
        smooth = abs(gs) + abs(gt) <= STATIONARY
        if abs(ds) + abs(dt) <= 1e-14 * length:
            return s, t, smooth
        s, t = s + ds, t + dt
    return s, t, smooth and abs(ds) + abs(dt) <= 1e-9 * best


@njit(cache=True, error_model="numpy")
def after_edge(
    planes,
    plane_facet_start,
    facet_box,
    facet_outline,
    outline,
    tolerance,
    sequence,
    begin,
    end,
    ex,
    ey,
    ez,
    points,
    facets,
    row,
):
    """Return whether the receiver sees the edge point over the planes between them, and a rim hit.

    ``points[row, 0]`` is the receiver; ex, ey, ez is the mirrored edge point. Fills the reflections
    into ``points[row, 1:]`` and ``facets[row]``. The second value tells if one lies on a rim.
    """
    on_rim = False
    for depth in range(end - begin):
        plane = sequence[end - 1 - depth]
        nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
        px, py, pz = points[row, depth, 0], points[row, depth, 1], points[row, depth, 2]
        edge_height = nx * ex + ny * ey + nz * ez - planes[plane, 3]
        point_height = nx * px + ny * py + nz * pz - planes[plane, 3]
        if abs(edge_height) <= tolerance or edge_height * point_height > 0.0:
            return False, False
        t = point_height / (point_height - edge_height)
        hx, hy, hz = px + t * (ex - px), py + t * (ey - py), pz + t * (ez - pz)
        facet, where = facet_at(
            planes,
            plane_facet_start,
            facet_box,
            facet_outline,
            outline,
            tolerance,
            plane,
            hx,
            hy,
            hz,
        )
        if facet < 0:
            return False, False
        on_rim = on_rim or where != INSIDE
        facets[row, depth] = facet
        points[row, depth + 1, 0] = hx
        points[row, depth + 1, 1] = hy
        points[row, depth + 1, 2] = hz
        ex, ey, ez = (
            ex - 2.0 * edge_height * nx,
            ey - 2.0 * edge_height * ny,
            ez - 2.0 * edge_height * nz,
        )
    return True, on_rim


@njit(cache=True, error_model="numpy")
def after_edge_is_free(
    boxes,
    links,
    triangles,
    triangle_planes,
    margin,
    facet_plane,
    edge_plane_a,
    edge_plane_b,
    on_rim,
    points,
    facets,
    row,
    reflections,
):
    """Return whether the segments from the receiver to the edge point are free."""
    for i in range(reflections + 1):
        last = i == reflections
        plane_b = edge_plane_a if last else facet_plane[facets[row, i]]
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
            facet_plane[facets[row, i - 1]] if i > 0 else -1,
            plane_b,
            edge_plane_b if last else -1,
            -1,
        ):
            return False
        if (
            on_rim
            and not last
            and corner_blocked(
                boxes, links, triangles, triangle_planes, margin, points, row, i, plane_b
            )
        ):
            return False
    return True


@njit(cache=True, error_model="numpy")
def find_edge_paths(
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
    margin,
    wedge_frame,
    wedge_facets,
    edge_wedge,
    edge_frame,
    edge_plane_start,
    edge_planes,
    node_start,
    node_leaf,
    node_first,
    node_source,
    node_reach,
    x,
    y,
    z,
    several,
    ways_per_node,
    first,
    last,
    state,
    before_points,
    before_facets,
    before_orders,
    points,
    facets,
    orders,
):
    """Return the number of paths over the edge images ``first`` to ``last``, and the image reached.

    Stops before an image whose paths might not fit into ``points``. Rows are filled as in
    :func:`octant.em._path_kernels.find_paths`; in ``facets`` a diffraction at wedge w is -1 - w.
    """
    found = 0
    for k in range(first, last):
        if found + (node_start[k + 1] - node_start[k]) * ways_per_node > len(orders):
            return found, k
        wedge = edge_wedge[k]
        rx, ry, rz = x - edge_frame[k, 0], y - edge_frame[k, 1], z - edge_frame[k, 2]
        along = rx * edge_frame[k, 3] + ry * edge_frame[k, 4] + rz * edge_frame[k, 5]
        across = rx * edge_frame[k, 6] + ry * edge_frame[k, 7] + rz * edge_frame[k, 8]
        up = rx * edge_frame[k, 9] + ry * edge_frame[k, 10] + rz * edge_frame[k, 11]
        distance = np.sqrt(across * across + up * up)
        angle = np.arctan2(up, across)
        if angle < 0.0:
            angle += 2.0 * np.pi
        if wedge_frame[wedge, 12] + SECTOR_TOLERANCE < angle < 2.0 * np.pi - SECTOR_TOLERANCE:
            continue
        reflections = edge_plane_start[k + 1] - edge_plane_start[k]
        for node in range(node_start[k], node_start[k + 1]):
            beside, place = node_source[node, 0], node_source[node, 1]
            lit_from, lit_to = node_reach[node, 0], node_reach[node, 1]
            one = node_first[node]
            if one < 0:
                if beside + distance <= tolerance:
                    continue
                t = place + (along - place) * beside / (beside + distance)
                s = t
                one = wedge
            else:
                s, t, ok = two_points(wedge_frame, one, wedge, beside, place, distance, along)
                if not ok or s < -tolerance or s > wedge_frame[one, 13] + tolerance:
                    continue
            if t < lit_from - tolerance or t > lit_to + tolerance:
                continue
            if (along - t) ** 2 + distance * distance <= tolerance * tolerance:
                continue  # the receiver stands on the edge itself
            points[found, 0, 0] = x
            points[found, 0, 1] = y
            points[found, 0, 2] = z
            seen, on_rim = after_edge(
                planes,
                plane_facet_start,
                facet_box,
                facet_outline,
                outline,
                tolerance,
                edge_planes,
                edge_plane_start[k],
                edge_plane_start[k + 1],
                edge_frame[k, 0] + t * edge_frame[k, 3],
                edge_frame[k, 1] + t * edge_frame[k, 4],
                edge_frame[k, 2] + t * edge_frame[k, 5],
                points,
                facets,
                found,
            )
            if not seen:
                continue
            depth = reflections + 1
            for a in range(3):
                points[found, depth, a] = wedge_frame[wedge, a] + t * wedge_frame[wedge, 3 + a]
            facets[found, reflections] = -1 - wedge
            plane_a = facet_plane[wedge_facets[wedge, 0]]
            plane_b = facet_plane[wedge_facets[wedge, 1]]
            if not after_edge_is_free(
                boxes,
                links,
                triangles,
                triangle_planes,
                margin,
                facet_plane,
                plane_a,
                plane_b,
                on_rim,
                points,
                facets,
                found,
                reflections,
            ):
                continue
            if one != wedge:
                px, py, pz = (
                    points[found, depth, 0],
                    points[found, depth, 1],
                    points[found, depth, 2],
                )
                qx = wedge_frame[one, 0] + s * wedge_frame[one, 3]
                qy = wedge_frame[one, 1] + s * wedge_frame[one, 4]
                qz = wedge_frame[one, 2] + s * wedge_frame[one, 5]
                gap = abs(qx - px) + abs(qy - py) + abs(qz - pz)
                if (
                    gap <= tolerance
                    or not in_sector(wedge_frame, wedge, qx - px, qy - py, qz - pz)
                    or not in_sector(wedge_frame, one, px - qx, py - qy, pz - qz)
                ):
                    continue
                plane_c = facet_plane[wedge_facets[one, 0]]
                plane_d = facet_plane[wedge_facets[one, 1]]
                if segment_blocked(
                    boxes,
                    links,
                    triangles,
                    triangle_planes,
                    margin,
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
                ):
                    continue
                plane_a, plane_b = plane_c, plane_d
                facets[found, depth] = -1 - one
                depth += 1
                points[found, depth, 0] = qx
                points[found, depth, 1] = qy
                points[found, depth, 2] = qz
            leaf = node_leaf[node]
            ways = find_paths(
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
                points[found, depth, 0],
                points[found, depth, 1],
                points[found, depth, 2],
                plane_a,
                plane_b,
                several,
                leaf,
                leaf + 1,
                state,
                before_points,
                before_facets,
                before_orders,
            )
            here = found
            for way in range(ways):
                before = before_orders[way]
                if not in_sector(
                    wedge_frame,
                    one,
                    before_points[way, 1, 0] - before_points[way, 0, 0],
                    before_points[way, 1, 1] - before_points[way, 0, 1],
                    before_points[way, 1, 2] - before_points[way, 0, 2],
                ):
                    continue
                if found > here:
                    for i in range(depth + 1):
                        for a in range(3):
                            points[found, i, a] = points[here, i, a]
                        if i < depth:
                            facets[found, i] = facets[here, i]
                for i in range(before + 1):
                    for a in range(3):
                        points[found, depth + 1 + i, a] = before_points[way, 1 + i, a]
                    if i < before:
                        facets[found, depth + i] = before_facets[way, i]
                orders[found] = depth + before
                if not on_rim or not known_already(
                    points, 0, found, orders[found], 10.0 * tolerance
                ):
                    found += 1
    return found, last


@njit(cache=True, error_model="numpy")
def search_edges(scene, tree, edges, x, y, z, first, before, points, facets, orders):
    """Return the number of paths over some edge images from ``first`` on, and where to go on."""
    state, before_points, before_facets, before_orders = before
    bvh = scene.bvh
    if inside_supporting_planes(
        scene.planes, scene.supporting_side, x, y, z
    ) and inside_supporting_planes(
        scene.planes, scene.supporting_side, tree.image[0, 0], tree.image[0, 1], tree.image[0, 2]
    ):
        bvh = scene.inner_bvh
    return find_edge_paths(
        tree.image,
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
        bvh.margin,
        scene.wedge_frame,
        scene.wedge_facets,
        edges.wedge,
        edges.frame,
        edges.plane_start,
        edges.planes,
        edges.node_start,
        edges.leaf,
        edges.first,
        edges.source,
        edges.reach,
        x,
        y,
        z,
        scene.transmits,
        edges.ways,
        first,
        len(edges.wedge),
        state,
        before_points,
        before_facets,
        before_orders,
        points,
        facets,
        orders,
    )
