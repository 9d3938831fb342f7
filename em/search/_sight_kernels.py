# mypy: allow-untyped-defs
"""Compiled search for edges that see each other, past the facets that hide them."""

import numpy as np

from octant.geometries._array_kernels import grown
from octant.geometries._bvh_kernels import crossing
from octant.geometries._wedge_kernels import one_facet
from octant.geometries.kernels import kernel

_MEETING = 10.0  # distance [slacks] below which two edges meet
_FACES = 2


@kernel
def _fill_box(box, points):
    """Fill the eight corners of a box."""
    for i in range(8):
        for a in range(3):
            points[i, a] = box[3 + a] if (i >> a) & 1 else box[a]


@kernel
def _fill_ends(frame, points):
    """Fill both ends of an edge."""
    for a in range(3):
        points[0, a] = frame[a]
        points[1, a] = frame[a] + frame[13] * frame[3 + a]


@kernel
def _height(normal, point, origin):
    return (
        normal[0] * (point[0] - origin[0])
        + normal[1] * (point[1] - origin[1])
        + normal[2] * (point[2] - origin[2])
    )


@kernel
def _within_solid(frame, normals, points, count, slack):
    """Return whether all points lie behind both faces of a wedge, whose solid is convex."""
    along, up = np.cos(0.5 * frame[12]), np.sin(0.5 * frame[12])
    for i in range(count):
        for face in range(_FACES):
            if _height(normals[face], points[i], frame) > slack:
                return False
        x = _height(frame[6:9], points[i], frame)
        y = _height(frame[9:12], points[i], frame)
        if along * x + up * y > slack:  # in the plane of a sheet, before its rim
            return False
    return True


@kernel
def _along_face(frame, normals, ends, slack):
    """Return whether an edge lies in the plane of a face of a wedge, and on the face's side."""
    turn = frame[12]
    for face in range(_FACES):
        along, up = (1.0, 0.0) if face == 0 else (np.cos(turn), np.sin(turn))
        flat, before = True, False
        for i in range(2):
            flat = flat and abs(_height(normals[face], ends[i], frame)) <= slack
            x = _height(frame[6:9], ends[i], frame)
            y = _height(frame[9:12], ends[i], frame)
            before = before or along * x + up * y > slack
        if flat and before:
            return True
    return False


@kernel
def _gap(frame, points):
    """Return the least distance [m] of two points from an edge."""
    least = np.inf
    for i in range(2):
        along = min(max(_height(frame[3:6], points[i], frame), 0.0), frame[13])
        square = 0.0
        for a in range(3):
            square += (points[i, a] - frame[a] - along * frame[3 + a]) ** 2
        least = min(least, np.sqrt(square))
    return least


@kernel
def _hides(plane, hull, begin, end, ends, points, count, slack):
    """Return whether a convex facet crosses all lines from both ends of an edge to some points."""
    for e in range(2):
        here = plane[0] * ends[e, 0] + plane[1] * ends[e, 1] + plane[2] * ends[e, 2] - plane[3]
        for i in range(count):
            q = points[i]
            there = plane[0] * q[0] + plane[1] * q[1] + plane[2] * q[2] - plane[3]
            if min(abs(here), abs(there)) <= slack or (here > 0.0) == (there > 0.0):
                return False
            t = here / (here - there)
            x = ends[e, 0] + t * (q[0] - ends[e, 0])
            y = ends[e, 1] + t * (q[1] - ends[e, 1])
            z = ends[e, 2] + t * (q[2] - ends[e, 2])
            for c in range(begin, end):
                d = c + 1 if c + 1 < end else begin
                ux, uy, uz = (
                    hull[d, 0] - hull[c, 0],
                    hull[d, 1] - hull[c, 1],
                    hull[d, 2] - hull[c, 2],
                )
                vx, vy, vz = x - hull[c, 0], y - hull[c, 1], z - hull[c, 2]
                left = (
                    plane[0] * (uy * vz - uz * vy)
                    + plane[1] * (uz * vx - ux * vz)
                    + plane[2] * (ux * vy - uy * vx)
                )
                # A line through the very rim is blocked, as for paths.
                if left < -slack * np.sqrt(ux * ux + uy * uy + uz * uz):
                    return False
    return True


@kernel
def _hidden(
    boxes,
    links,
    triangles,
    triangle_planes,
    planes,
    plane_facet_start,
    opaque_area,
    hull_start,
    hulls,
    ends,
    points,
    count,
    slack,
):
    """Return whether one facet hides some points, and all between them, from a whole edge.

    Of the facets that stand between both middles each is asked; what two of them hide together
    is left to the paths.
    """
    middle, way = np.empty(3), np.empty(3)
    for a in range(3):
        middle[a] = 0.5 * (ends[0, a] + ends[1, a])
        way[a] = -middle[a]
        for i in range(count):
            way[a] += points[i, a] / count
    node = 0
    while node < len(links):
        enter, leave = 0.0, 1.0
        for a in range(3):
            t0 = (boxes[node, a] - middle[a]) / way[a]
            t1 = (boxes[node, 3 + a] - middle[a]) / way[a]
            enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        if enter > leave:
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            t = crossing(triangles, i, middle[0], middle[1], middle[2], way[0], way[1], way[2])
            if not 0.0 < t < 1.0:
                continue
            p = triangle_planes[i]
            for f in range(plane_facet_start[p], plane_facet_start[p + 1]):
                if opaque_area[f] > 0.0 and _hides(
                    planes[p], hulls, hull_start[f], hull_start[f + 1], ends, points, count, slack
                ):
                    return True
        node += 1
    return False


@kernel(nogil=True)
def edges_in_sight(
    wedge_frame,
    face_normals,
    facets,
    wedge_boxes,
    wedge_links,
    wedge_order,
    boxes,
    links,
    triangles,
    triangle_planes,
    planes,
    plane_facet_start,
    opaque_area,
    hull_start,
    hulls,
    begin,
    end,
    slack,
):
    """Return (k, 2) wedges, the first of ``begin`` to ``end``, the other behind it, in sight.

    The air of each must be wider than half a turn. Pairs of one facet, of edges that meet, and
    those along a face of either are left out. None that sees the other is lost; of those that do
    not, some are left. The first hierarchy is over the edges, the second over what blocks.
    """
    pairs = np.empty((256, 2), dtype=np.int64)
    count = 0
    ends, there, corners = np.empty((2, 3)), np.empty((2, 3)), np.empty((8, 3))
    for i in range(begin, end):
        _fill_ends(wedge_frame[i], ends)
        node = np.int64(0)
        while node < len(wedge_links):
            _fill_box(wedge_boxes[node], corners)
            if _within_solid(wedge_frame[i], face_normals[i], corners, 8, slack) or _hidden(
                boxes,
                links,
                triangles,
                triangle_planes,
                planes,
                plane_facet_start,
                opaque_area,
                hull_start,
                hulls,
                ends,
                corners,
                8,
                slack,
            ):
                node = wedge_links[node, 0]
                continue
            for k in range(wedge_links[node, 1], wedge_links[node, 1] + wedge_links[node, 2]):
                j = wedge_order[k]
                if j <= i:
                    continue
                _fill_ends(wedge_frame[j], there)
                if (
                    one_facet(facets, i, j)
                    or min(_gap(wedge_frame[i], there), _gap(wedge_frame[j], ends))
                    <= _MEETING * slack
                    or _along_face(wedge_frame[i], face_normals[i], there, _MEETING * slack)
                    or _along_face(wedge_frame[j], face_normals[j], ends, _MEETING * slack)
                    or _within_solid(wedge_frame[i], face_normals[i], there, 2, slack)
                    or _within_solid(wedge_frame[j], face_normals[j], ends, 2, slack)
                    or _hidden(
                        boxes,
                        links,
                        triangles,
                        triangle_planes,
                        planes,
                        plane_facet_start,
                        opaque_area,
                        hull_start,
                        hulls,
                        ends,
                        there,
                        2,
                        slack,
                    )
                ):
                    continue
                pairs = grown(pairs, count + 1)
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
            node += 1
    return pairs[:count].copy()
