"""Closed parts of a scene: the room's shell, the solids, and which side of a facet is outside."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries import _outline_kernels, _scene_kernels
from octant.geometries._plane_geometry import (
    ODD_DIRECTION,
    FloatArray,
    IntArray,
    connected_labels,
    row_numbers,
    triangle_area_vectors,
)
from octant.geometries.facets import Facets
from octant.geometries.occlusion import build_bvh, winding_numbers

RAY_DIRECTIONS = np.array([ODD_DIRECTION, np.roll(-ODD_DIRECTION, 1), np.roll(ODD_DIRECTION, 2)])
"""Directions [-] of rays that find whether they start outside; the first clear answer counts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedParts:
    """Parts of a mesh in which each edge belongs to exactly two triangles.

    Parameters
    ----------
    solids : Triangles [m] of each part but the shell, neighbours wound alike; the shell, when there
        is one, is numbered after them.
    shell_corners_m : (s, 3, 3) float64 — Triangles [m] around the whole room; none: it is open.
    part_of_triangle : (t,) int64 — Number of the part of each triangle, -1 for open ones.
    """

    solids: tuple[FloatArray, ...]
    shell_corners_m: FloatArray
    part_of_triangle: IntArray


def find_closed_parts(
    vertices_m: FloatArray,
    faces: IntArray,
    *,
    has_area: npt.NDArray[np.bool_],
    room_faces: int,
    tolerance_m: float,
) -> ClosedParts:
    """Return the closed parts of a welded mesh, joined over edges, by first triangle.

    Parameters
    ----------
    vertices_m : (n, 3) float64 — Vertices [m].
    faces : (t, 3) int64 — Triangles as indices of welded vertices; the room's come first.
    has_area : (t,) bool — Whether each triangle has one [-]; the others are of no part.
    room_faces : Number of the room's triangles; objects share no edge with it.
    tolerance_m : Distance [m] within which a corner stands on another triangle's edge.
    """
    triangle, start, end = _cut_edges(vertices_m, faces, has_area, room_faces, tolerance_m)
    in_room = triangle < room_faces
    rows = np.column_stack((np.minimum(start, end), np.maximum(start, end), in_room))
    edge_of, begin, member = row_numbers(rows)
    same = edge_of[member][1:] == edge_of[member][:-1]
    one, other = member[:-1][same], member[1:][same]
    pairs = np.column_stack((triangle[one], triangle[other]))
    against = start[one] == start[other]
    label = connected_labels(len(faces), pairs)
    _, first, label = np.unique(label, return_index=True, return_inverse=True)
    label = np.argsort(np.argsort(first))[label.reshape(-1)]
    closed = np.ones(len(first), dtype=np.bool_)
    closed[label[triangle[np.diff(begin)[edge_of] != 2]]] = False
    closed[label[~has_area]] = False
    by_label = np.argsort(label, kind="stable")
    begin = np.searchsorted(label[by_label], np.arange(len(first) + 1))
    turned = _wound_alike(faces, pairs, against & closed[label[pairs[:, 0]]])
    corners = vertices_m[turned[by_label]]
    room = vertices_m[np.unique(faces[:room_faces])]
    shell = _shell(corners, begin, closed & (np.sort(first) < room_faces), room)
    part = np.full(len(first), -1, dtype=np.int64)
    solid = np.flatnonzero(closed & (np.arange(len(first)) != shell))
    part[solid] = np.arange(len(solid))
    if shell >= 0:
        part[shell] = len(solid)
    return ClosedParts(
        solids=tuple(corners[begin[i] : begin[i + 1]] for i in solid),
        shell_corners_m=corners[begin[shell] : begin[shell + 1]] if shell >= 0 else corners[:0],
        part_of_triangle=part[label] if len(faces) else label,
    )


def _cut_edges(
    vertices_m: FloatArray,
    faces: IntArray,
    has_area: npt.NDArray[np.bool_],
    room_faces: int,
    tolerance_m: float,
) -> tuple[IntArray, IntArray, IntArray]:
    """Return triangle, start, end of edges, cut at T-junctions, which so do not open a part."""
    triangle = np.repeat(np.flatnonzero(has_area), 3)
    start, end = faces[has_area].reshape(-1), np.roll(faces[has_area], -1, axis=1).reshape(-1)
    in_room = triangle < room_faces
    rows = np.column_stack((np.minimum(start, end), np.maximum(start, end), in_room))
    edge_of, begin, _ = row_numbers(rows)
    whole = np.diff(begin)[edge_of] == 2
    parts = [np.column_stack((triangle, start, end))[whole]]
    for room in (True, False):
        open_ = np.flatnonzero(~whole & (in_room == room))
        cut = _outline_kernels.split_edges(
            np.array([0, len(open_)]), start[open_], end[open_], vertices_m, tolerance_m
        )
        parts.append(np.column_stack((triangle[open_][cut[:, 0]], cut[:, 1:])))
    triangle, start, end = np.concatenate(parts).T
    return triangle, start, end


def _wound_alike(faces: IntArray, pairs: IntArray, against: npt.NDArray[np.bool_]) -> IntArray:
    """Return (t, 3) faces, turned if possible so that no neighbours (k, 2) disagree."""
    count = len(faces)
    if not against.any():
        return faces
    # Each triangle stands for two nodes, as stored and turned; a pair joins those that agree.
    other = pairs[:, 1] + count * against
    opposite = pairs[:, 1] + count * ~against
    nodes = np.column_stack((pairs[:, 0], other, pairs[:, 0] + count, opposite)).reshape(-1, 2)
    label = connected_labels(2 * count, nodes)
    turn = label[:count] > label[count:]
    return np.where(turn[:, None], faces[:, ::-1], faces)


def _shell(
    corners_m: FloatArray,
    begin: IntArray,
    candidates: npt.NDArray[np.bool_],
    room_m: FloatArray,
) -> int:
    """Return the candidate with the largest box, -1 without one, or if it is no room's.

    A room's holds at least half of the bounds of its vertices (n, 3): something may stick out.
    """
    chosen = np.flatnonzero(candidates)
    if len(chosen) == 0:
        return -1
    spans = [np.ptp(corners_m[begin[i] : begin[i + 1]].reshape(-1, 3), axis=0) for i in chosen]
    volume = np.prod(spans, axis=1)
    largest = int(np.argmax(volume))
    is_room = volume[largest] >= 0.5 * float(np.prod(np.ptp(room_m, axis=0)))
    return int(chosen[largest]) if is_room else -1


def facet_sides(
    vertices_m: FloatArray, faces: IntArray, facets: Facets, parts: ClosedParts, *, extent_m: float
) -> tuple[IntArray, IntArray]:
    """Return each facet's closed part, -1 for sheets and mixed ones, and its outer side.

    The side is +1 where the plane's normal points out of the part, -1 into it, 0 without one.

    Parameters
    ----------
    vertices_m : (n, 3) float64 — Vertices [m].
    faces : (t, 3) int64 — Triangles that the facets were built from, as indices of vertices.
    facets, parts : Facets and closed parts of these triangles.
    extent_m : Size of the scene [m].
    """
    count = len(facets.facet_plane)
    facet, part = facets.triangle_facet, parts.part_of_triangle
    chosen = np.flatnonzero((facet >= 0) & (part >= 0))
    out = np.zeros(len(faces), dtype=np.int64)
    if len(chosen):
        tagged = build_bvh(vertices_m[faces[chosen]], chosen, extent_m=extent_m)
        sides = np.zeros(len(chosen), dtype=np.int64)
        _scene_kernels.outer_sides(
            tagged.boxes, tagged.links, tagged.triangles, part[tagged.planes], RAY_DIRECTIONS, sides
        )
        out[tagged.planes] = sides
    area = triangle_area_vectors(vertices_m, faces)
    normal = facets.plane_normal[facets.facet_plane[facet]] if count else np.zeros_like(area)
    out *= np.where(np.sum(area * normal, axis=1) < 0.0, -1, 1)
    used = np.flatnonzero(facet >= 0)
    least = np.full((count, 2), np.iinfo(np.int64).max)
    greatest = np.full((count, 2), np.iinfo(np.int64).min)
    pair = np.column_stack((part, out))[used]
    np.minimum.at(least, facet[used], pair)
    np.maximum.at(greatest, facet[used], pair)
    agree = (least == greatest).all(axis=1) & (least[:, 0] >= 0) & (least[:, 1] != 0)
    return np.where(agree, least[:, 0], -1), np.where(agree, least[:, 1], 0)


def inside_parts(point_m: FloatArray, parts: tuple[FloatArray, ...]) -> npt.NDArray[np.bool_]:
    """Return (k,) bool, whether a point is inside each closed part (its winding number odd) [-].

    Parameters
    ----------
    point_m : (3,) float64 — Point [m], not on a part.
    parts : Triangles [m] of each part.
    """
    inside = np.zeros(len(parts), dtype=np.bool_)
    for i, corners in enumerate(parts):
        if len(corners) == 0:
            continue
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        if (low < point_m).all() and (high > point_m).all():
            winding = float(winding_numbers(point_m[None, :], corners)[0])
            inside[i] = round(winding) % 2 == 1
    return inside
