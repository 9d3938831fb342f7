# mypy: allow-untyped-defs
"""Compiled exact path finding over edges: from an unfolded edge and a receiver to its paths.

An edge image is an edge mirrored by every plane between it and the receiver; a source image stands
for every reflection before it. The diffraction point then follows from two distances and two
heights, and the rest is the image method towards either end.
"""

import numpy as np
from numba import njit

from octant.em.paths._path_kernels import (
    ON_RIM,
    RECEIVER,
    RIM,
    SOURCE,
    find_paths,
    inside_supporting_planes,
    known_already,
)
from octant.geometries._bvh_kernels import segment_blocked, two_planes

SECTOR_TOLERANCE = 1e-7
"""Angle [rad] by which a ray may leave a wedge's sector of air: rays along a face have rounding."""

STATIONARY = 1e-6
"""Slope [-] of a path's length over two edges, up to which its two points count as the shortest."""

NEWTON_STEPS = 40
"""Steps [-] after which the two points of a double diffraction count as not found."""


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
def unfold(planes, sequence, begin, end, x, y, z, chain_image):
    """Fill the images of a point over the planes of a sequence, one after the other."""
    chain_image[0, 0], chain_image[0, 1], chain_image[0, 2] = x, y, z
    for k in range(begin, end):
        plane = sequence[k]
        nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
        height = nx * x + ny * y + nz * z - planes[plane, 3]
        x, y, z = x - 2.0 * height * nx, y - 2.0 * height * ny, z - 2.0 * height * nz
        i = k - begin + 1
        chain_image[i, 0], chain_image[i, 1], chain_image[i, 2] = x, y, z


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
    chain_image,
    chain_order,
    chain_branches,
    before_points,
    before_facets,
    before_orders,
    points,
    facets,
    orders,
):
    """Return the number of paths over the edge images ``first`` to ``last``, and the image reached.

    Stops before an image whose paths might not fit into ``points``. Rows are filled as in
    :func:`find_paths`; in ``facets`` a diffraction at wedge w is -1 - w.
    """
    found = 0
    ends = len(state) - 1
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
            own_planes = two_planes(
                facet_plane[wedge_facets[wedge, 0]], facet_plane[wedge_facets[wedge, 1]]
            )
            # Behind the edge, the point on it is the source of a single sequence of images.
            unfold(
                planes,
                edge_planes,
                edge_plane_start[k],
                edge_plane_start[k + 1],
                wedge_frame[wedge, 0] + t * wedge_frame[wedge, 3],
                wedge_frame[wedge, 1] + t * wedge_frame[wedge, 4],
                wedge_frame[wedge, 2] + t * wedge_frame[wedge, 5],
                chain_image,
            )
            for i in range(reflections):
                chain_branches[i + 1, 0] = edge_planes[edge_plane_start[k] + i]
            state[ends, RECEIVER], state[ends, SOURCE] = -1, own_planes
            seen = find_paths(
                chain_image,
                chain_order,
                chain_order,
                chain_branches,
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
                False,
                reflections,
                reflections + 1,
                state,
                before_points,
                before_facets,
                before_orders,
            )
            if seen == 0:
                continue
            on_rim = several
            for i in range(reflections):
                on_rim = on_rim or state[i, RIM] == ON_RIM
            depth = reflections + 1
            for i in range(depth + 1):
                for a in range(3):
                    points[found, i, a] = before_points[0, i, a]
                if i < reflections:
                    facets[found, i] = before_facets[0, i]
            facets[found, reflections] = -1 - wedge
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
                first_planes = two_planes(
                    facet_plane[wedge_facets[one, 0]], facet_plane[wedge_facets[one, 1]]
                )
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
                    own_planes,
                    first_planes,
                ):
                    continue
                own_planes = first_planes
                facets[found, depth] = -1 - one
                depth += 1
                points[found, depth, 0] = qx
                points[found, depth, 1] = qy
                points[found, depth, 2] = qz
            leaf = node_leaf[node]
            state[ends, RECEIVER], state[ends, SOURCE] = own_planes, -1
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
    state, chain_image, chain_order, chain_branches = before[:4]
    before_points, before_facets, before_orders = before[4:]
    bvh = scene.bvh
    if inside_supporting_planes(scene.supporting, x, y, z) and inside_supporting_planes(
        scene.supporting, tree.image[0, 0], tree.image[0, 1], tree.image[0, 2]
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
        chain_image,
        chain_order,
        chain_branches,
        before_points,
        before_facets,
        before_orders,
        points,
        facets,
        orders,
    )
