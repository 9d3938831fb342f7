# mypy: allow-untyped-defs
"""Compiled exact path finding over edges: from an unfolded edge and a receiver to its paths.

An edge image is an edge mirrored by every plane between it and the receiver; a source image stands
for every reflection before it. The diffraction point then follows from two distances and two
heights, and the rest is the image method towards either end.
"""

import numpy as np

from octant.em.medium._transition_kernels import END_REACH
from octant.em.paths._edge_point_kernels import (
    SECTOR_TOLERANCE,
    in_sector,
    kept_on_edges,
    two_points,
    yields,
)
from octant.em.paths._neighbour_kernels import at_tip, beside_edge, comes_first, counts
from octant.em.paths._path_kernels import (
    RECEIVER,
    SOURCE,
    find_paths,
    inside_supporting_planes,
)
from octant.geometries._bvh_kernels import segment_blocked, two_planes
from octant.geometries.kernels import kernel

PARALLEL = 1e-9
"""Squared sine of an angle [-] below which two edges count as parallel."""


@kernel
def met_before(
    wedge_frame, points, facets, row, order, met_points, met_facets, met_orders, met, tolerance
):
    """Return whether a path that touches something was met already; remember it.

    A ray at the end of an edge, where another edge goes on or a plane shows the edge's image, may
    be read as diffracted by either, and as reflected before or behind: it is one path.
    """
    for k in range(min(met[0], len(met_orders))):
        if met_orders[k] != order:
            continue
        distance = 0.0
        for v in range(order + 2):
            for a in range(3):
                distance = max(distance, abs(points[row, v, a] - met_points[k, v, a]))
        if distance > tolerance:
            continue
        i, j = 0, 0
        same = True
        while same:
            while i < order and facets[row, i] >= 0:
                i += 1
            while j < order and met_facets[k, j] >= 0:
                j += 1
            if order in (i, j):
                same = i == j
                break
            w, u = -1 - facets[row, i], -1 - met_facets[k, j]
            cosine = 0.0
            for a in range(3):
                cosine += wedge_frame[w, 3 + a] * wedge_frame[u, 3 + a]
            same = 1.0 - cosine * cosine <= PARALLEL
            for v in range(min(i, j) + 1, max(i, j) + 1):  # bent in the same place
                for a in range(3):
                    same = same and abs(points[row, v + 1, a] - points[row, v, a]) <= tolerance
            # Where two edges of one line end, each has half of the ray.
            here = at_tip(wedge_frame, w, points, row, i + 1, tolerance)
            there = at_tip(wedge_frame, u, met_points, k, j + 1, tolerance)
            if here >= 0 and there >= 0:
                same = same and (here == there) == (cosine > 0.0)
            i += 1
            j += 1
        if same:
            return True
    k = met[0] % len(met_orders)
    met[0] += 1
    met_orders[k] = order
    for v in range(order + 2):
        for a in range(3):
            met_points[k, v, a] = points[row, v, a]
        if v < order:
            met_facets[k, v] = facets[row, v]
    return False


@kernel
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


@kernel
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
    sheet_boxes,
    sheet_links,
    sheets,
    sheet_facets,
    margin,
    end_reach,
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
    near,
    touching,
    met_points,
    met_facets,
    met_orders,
    met,
):
    """Return the number of paths over the edge images ``first`` to ``last``, and the image reached.

    Stops before an image whose paths might not fit into ``points``. Rows are filled as in
    :func:`find_paths`; in ``facets`` a diffraction at wedge w is -1 - w.
    """
    found = 0
    ends = len(state) - 1
    slack = SECTOR_TOLERANCE
    falling = comes_first(x, y, z, image[0, 0], image[0, 1], image[0, 2])
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
        if wedge_frame[wedge, 12] + slack < angle < 2.0 * np.pi - slack:
            continue
        reflections = edge_plane_start[k + 1] - edge_plane_start[k]
        for node in range(node_start[k], node_start[k + 1]):
            beside, place = node_source[node, 0], node_source[node, 1]
            lit_from, lit_to = node_reach[node, 0], node_reach[node, 1]
            one = node_first[node]
            if one < 0:
                t = 0.5 * (place + along)  # of both ends on the line, seen from anywhere near it
                if beside + distance > tolerance:
                    t = place + (along - place) * beside / (beside + distance)
                elif -tolerance <= t <= wedge_frame[wedge, 13] + tolerance:
                    continue  # a ray along the edge is bent by it nowhere in particular
                one = wedge
                length = wedge_frame[wedge, 13]
                if t < -tolerance or t > length + tolerance:
                    end = 0 if t < 0.0 else 1
                    if wedge_frame[wedge, 14 + end] <= 0.0:
                        continue
                    t = end * length
                    detour = np.sqrt(beside * beside + (t - place) ** 2)
                    detour += np.sqrt(distance * distance + (t - along) ** 2)
                    detour -= np.sqrt((beside + distance) ** 2 + (along - place) ** 2)
                    if detour > end_reach:
                        continue
                s = t
            else:
                s, t, ok = two_points(wedge_frame, one, wedge, beside, place, distance, along)
                if not ok:
                    continue
                if max(-s, s - wedge_frame[one, 13], -t, t - wedge_frame[wedge, 13]) > tolerance:
                    s, t, detour = kept_on_edges(
                        wedge_frame,
                        one,
                        wedge,
                        beside,
                        place,
                        distance,
                        along,
                        s,
                        t,
                        tolerance,
                    )
                    if detour > end_reach:
                        continue
            if t < lit_from - tolerance or t > lit_to + tolerance:
                continue
            # Half the tolerance: the edge that goes on takes what is within all of it.
            if yields(wedge_frame, wedge, t, 0.5 * tolerance) or (
                one != wedge and yields(wedge_frame, one, s, 0.5 * tolerance)
            ):
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
                chain_order,
                chain_image,
                chain_order,
                chain_order,
                chain_branches,
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
                False,
                False,
                reflections,
                reflections + 1,
                np.int64(0),
                state,
                before_points,
                before_facets,
                before_orders,
                near,
                touching,
            )
            if seen == 0:
                continue
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
                points[found, depth + 1, 0] = qx
                points[found, depth + 1, 1] = qy
                points[found, depth + 1, 2] = qz
                # A leg along an edge is bent by it nowhere in particular, and carries nothing.
                if (
                    gap <= tolerance
                    or beside_edge(wedge_frame, wedge, points[found, depth + 1])[0] <= tolerance
                    or beside_edge(wedge_frame, one, points[found, depth])[0] <= tolerance
                    or not in_sector(wedge_frame, wedge, qx - px, qy - py, qz - pz, slack)
                    or not in_sector(wedge_frame, one, px - qx, py - qy, pz - qz, slack)
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
            state[ends, RECEIVER], state[ends, SOURCE] = own_planes, -1
            ways = find_paths(
                node_leaf,
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
                points[found, depth, 0],
                points[found, depth, 1],
                points[found, depth, 2],
                falling,
                False,
                several,
                node,
                node + 1,
                np.int64(0),
                state,
                before_points,
                before_facets,
                before_orders,
                near,
                touching,
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
                    slack,
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
                if counts(
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
                    orders[found],
                    near,
                    touching,
                ) and not (
                    touching[found] > 0
                    and met_before(
                        wedge_frame,
                        points,
                        facets,
                        found,
                        orders[found],
                        met_points,
                        met_facets,
                        met_orders,
                        met,
                        10.0 * tolerance,
                    )
                ):
                    found += 1
    return found, last


@kernel(returns="UniTuple(int64, 2)")
def search_edges(scene, tree, edges, x, y, z, first, before, met, whole):
    """Return the number of paths over some edge images from ``first`` on, and where to go on."""
    points, facets, orders, near, touching = whole[1:]
    met_points, met_facets, met_orders, met_count = met
    if first == 0:
        met_count[0] = 0
    state, chain_image, chain_order, chain_branches = before[:4]
    before_points, before_facets, before_orders = before[4:]
    bvh, sheets = scene.bvh, scene.sheet_bvh
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
        sheets.boxes,
        sheets.links,
        sheets.triangles,
        sheets.planes,
        bvh.margin,
        END_REACH * scene.wavelength / (2.0 * np.pi),
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
        near,
        touching,
        met_points,
        met_facets,
        met_orders,
        met_count,
    )
