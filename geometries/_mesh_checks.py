"""Vectorised checks of a triangle mesh whose vertices are joined by position.

Throughout, ``vertices_m`` is (n, 3) [m] and ``faces`` is (m, 3): welded vertex numbers.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._plane_geometry import (
    FloatArray,
    IntArray,
    connected_labels,
    triangle_area_vectors,
    weld,
)

# Two triangles fold over each other when their planes differ by less than this angle [rad].
_FOLD_RAD = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EdgeTable:
    """The edges of a welded mesh, one row for each side of a triangle.

    Parameters
    ----------
    face : (s,) int64 — Triangle of each side.
    edge : (s,) int64 — Edge that the side lies on.
    start, end : (s,) int64 — Vertices that the side runs between, in the triangle's winding.
    edge_vertices : (e, 2) int64 — Vertices of each edge, the lower number first.
    sides : (e,) int64 — Number of triangle sides on each edge.
    """

    face: IntArray
    start: IntArray
    end: IntArray
    edge: IntArray
    edge_vertices: IntArray
    sides: IntArray


def edge_table(faces: IntArray) -> EdgeTable:
    """Return the edges of a mesh without degenerate triangles, in the order of their vertices."""
    start = faces.reshape(-1)
    end = np.roll(faces, -1, axis=1).reshape(-1)
    count = int(faces.max()) + 1 if len(faces) else 1
    key = np.minimum(start, end) * count + np.maximum(start, end)
    keys, edge, sides = np.unique(key, return_inverse=True, return_counts=True)
    return EdgeTable(
        face=np.repeat(np.arange(len(faces)), 3),
        start=start,
        end=end,
        edge=edge.astype(np.int64),
        edge_vertices=np.column_stack((keys // count, keys % count)),
        sides=sides.astype(np.int64),
    )


def welded_faces(vertices_m: FloatArray, faces: IntArray, tolerance_m: float) -> IntArray:
    """Return the (m, 3) faces in the numbers of the vertices that stand for all at their place."""
    joined: IntArray = weld(vertices_m, tolerance_m)[faces]
    return joined


def degenerate_faces(vertices_m: FloatArray, faces: IntArray, tolerance_m: float) -> IntArray:
    """Return the (d,) triangles that are no higher above their longest side than the tolerance."""
    corners = vertices_m[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    area = np.linalg.norm(triangle_area_vectors(vertices_m, faces), axis=1)
    return np.flatnonzero(2.0 * area <= tolerance_m * longest)


def duplicate_faces(faces: IntArray) -> IntArray:
    """Return the (d,) triangles that repeat an earlier one, whichever way they wind."""
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return np.setdiff1d(np.arange(len(faces)), first)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OpenBorder:
    """Edges that only one triangle has, cut at the vertices that lie on them.

    Parameters
    ----------
    t_junctions : Pairs of an open edge and a vertex in its interior.
    piece_face : (p,) int64 — Triangle of each piece of an open edge.
    piece_vertices : (p, 2) int64 — Vertices of each piece, the lower number first.
    free : (p,) bool — Whether no other piece lies there, so that the surface really ends [-].
    """

    t_junctions: int
    piece_face: IntArray
    piece_vertices: IntArray
    free: npt.NDArray[np.bool_]


def open_border(vertices_m: FloatArray, table: EdgeTable, tolerance_m: float) -> OpenBorder:
    """Return open edges, cut where another's vertex lies on them; T-junctions are not free."""
    side = np.flatnonzero(table.sides[table.edge] == 1)
    ends = table.edge_vertices[table.edge[side]]
    edge, vertex, along = _vertices_on_edges(vertices_m, ends, tolerance_m)
    rows = np.arange(len(side))
    edge_of = np.concatenate((rows, edge, rows))
    place = np.concatenate((np.zeros(len(rows)), along, np.ones(len(rows))))
    vertex_of = np.concatenate((ends[:, 0], vertex, ends[:, 1]))
    order = np.lexsort((place, edge_of))
    edge_of, vertex_of = edge_of[order], vertex_of[order]
    same = edge_of[1:] == edge_of[:-1]
    pieces = np.sort(np.column_stack((vertex_of[:-1][same], vertex_of[1:][same])), axis=1)
    _, which, times = np.unique(pieces, axis=0, return_inverse=True, return_counts=True)
    return OpenBorder(
        t_junctions=len(edge),
        piece_face=table.face[side[edge_of[:-1][same]]],
        piece_vertices=pieces,
        free=times[which.reshape(-1)] % 2 == 1,
    )


def _vertices_on_edges(
    vertices_m: FloatArray, ends: IntArray, tolerance_m: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return edge, vertex and place between 0 and 1 of each end that lies inside another edge.

    Long edges go piece by piece: near vertices grow with the edges' length, not its cube.
    """
    from scipy.spatial import cKDTree

    none = np.zeros(0, dtype=np.int64)
    if len(ends) == 0:
        return none, none, np.zeros(0)
    candidates = np.unique(ends)
    tree = cKDTree(vertices_m[candidates])
    start, step = vertices_m[ends[:, 0]], vertices_m[ends[:, 1]] - vertices_m[ends[:, 0]]
    length = np.linalg.norm(step, axis=1)
    stride = max(float(np.median(length)), float(length.sum()) / (4 * len(length)))
    parts = np.maximum(np.ceil(length / stride), 1.0).astype(np.int64)
    owner = np.repeat(np.arange(len(ends)), parts)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
    middle = start[owner] + ((number + 0.5) / parts[owner])[:, None] * step[owner]
    radius = 0.5 * length[owner] / parts[owner] + tolerance_m
    found = tree.query_ball_point(middle, radius)
    edge = np.repeat(owner, [len(f) for f in found])
    vertex = candidates[np.concatenate([np.asarray(f, dtype=np.int64) for f in found])]
    offset = vertices_m[vertex] - start[edge]
    along = (offset * step[edge]).sum(axis=1) / length[edge] ** 2
    aside = np.linalg.norm(offset - along[:, None] * step[edge], axis=1)
    end_on = tolerance_m / length[edge]
    inside = (aside <= tolerance_m) & (along > end_on) & (along < 1.0 - end_on)
    hits = np.unique(np.column_stack((edge[inside], vertex[inside])), axis=0, return_index=True)[1]
    chosen = np.flatnonzero(inside)[hits]
    return edge[chosen].astype(np.int64), vertex[chosen], along[chosen]


def winding_conflicts(table: EdgeTable, body_of_face: IntArray) -> int:
    """Return the number of edges whose two triangles, of one body, run along it the same way."""
    first, second = _pairs_of_sides(table)
    same_body = body_of_face[table.face[first]] == body_of_face[table.face[second]]
    return int((same_body & (table.start[first] == table.start[second])).sum())


def folded_edges(vertices_m: FloatArray, faces: IntArray, table: EdgeTable) -> int:
    """Return the number of edges at which two triangles, no duplicates, lie on each other."""
    first, second = _pairs_of_sides(table)
    origin = vertices_m[table.start[first]]
    along = vertices_m[table.end[first]] - origin
    along /= np.linalg.norm(along, axis=1)[:, None]
    away = []
    for side in (first, second):
        corners = faces[table.face[side]]
        apex = corners.sum(axis=1) - table.start[side] - table.end[side]
        offset = vertices_m[apex] - origin
        offset -= (offset * along).sum(axis=1)[:, None] * along
        away.append(offset / np.linalg.norm(offset, axis=1)[:, None])
    return int((np.linalg.norm(away[0] - away[1], axis=1) < _FOLD_RAD).sum())


def _pairs_of_sides(table: EdgeTable) -> tuple[IntArray, IntArray]:
    """Return the two sides on each edge that has exactly two."""
    order = np.argsort(table.edge, kind="stable")
    last = np.cumsum(table.sides) - 1
    double = last[table.sides == 2]
    return order[double - 1], order[double]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Components:
    """Parts of a mesh that hang together along edges.

    Parameters
    ----------
    label : (m,) int64 — Component of each triangle.
    closed : (c,) bool — Whether each component has no free edge [-].
    volume_m3 : (c,) float64 — Volume of closed ones [m³], negative when the normals point inwards.
    bounds_m : (c, 2, 3) float64 — Lowest and highest corner of each [m].
    """

    label: IntArray
    closed: npt.NDArray[np.bool_]
    volume_m3: FloatArray
    bounds_m: FloatArray


def components(
    vertices_m: FloatArray, faces: IntArray, table: EdgeTable, border: OpenBorder
) -> Components:
    """Return the parts of a mesh that hang together along edges or T-junctions."""
    order = np.argsort(table.edge, kind="stable")
    same = table.edge[order][1:] == table.edge[order][:-1]
    pairs = np.column_stack((table.face[order][:-1][same], table.face[order][1:][same]))
    rank = np.lexsort(border.piece_vertices.T)
    meets = (border.piece_vertices[rank][1:] == border.piece_vertices[rank][:-1]).all(axis=1)
    over = border.piece_face[rank]
    pairs = np.concatenate((pairs, np.column_stack((over[:-1][meets], over[1:][meets]))))
    label = connected_labels(len(faces), pairs)
    count = int(label.max()) + 1
    closed = np.ones(count, dtype=np.bool_)
    closed[label[border.piece_face[border.free]]] = False
    corners = vertices_m[faces]
    low = np.full((count, 3), np.inf)
    high = np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    a, b, c = np.moveaxis(corners - low[label][:, None, :], 1, 0)
    volume = np.zeros(count)
    np.add.at(volume, label, (a * np.cross(b, c)).sum(axis=1) / 6.0)
    return Components(
        label=label, closed=closed, volume_m3=volume, bounds_m=np.stack((low, high), axis=1)
    )
