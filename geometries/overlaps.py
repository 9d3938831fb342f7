"""The outline of what overlaps itself: triangles given twice in two meshings, boxes squashed flat.

Such a piece is one polygon for rays. Where two layers of it end in one there is no edge, though
there is one in the sum of the triangles' outlines.
"""

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from octant.geometries import _outline_kernels, _overlap_kernels
from octant.geometries._plane_geometry import (
    FloatArray,
    IntArray,
    connected_labels,
    row_numbers,
    weld,
)

LARGEST_OUTLINE = 20_000
"""Edges [-] of a piece above which overlaps are not resolved: the time grows with the square."""

_ROUNDS = 12


def outer_outlines(
    piece: IntArray,
    start: IntArray,
    end: IntArray,
    places_m: FloatArray,
    *,
    normal_of_piece: FloatArray,
    tolerance_m: float,
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Return outlines (m,) without edges at which a piece's layers end on one another; corners [m].

    Corners are (n + c, 3): those where edges cross are added.

    Parameters
    ----------
    piece : (k,) int64 — Piece of each directed edge, in any order.
    start, end : (k,) int64 — Corners of the edges, apart for every piece, which lies to their left.
    places_m : (n, 3) float64 — Corners [m].
    normal_of_piece : (p, 3) float64 — Normal [-] about which each piece is wound.
    tolerance_m : Distance [m] within which corners and edges coincide.
    """
    chosen = _may_overlap(piece, start, end, places_m, normal_of_piece)
    if not chosen.any():
        return piece, start, end, places_m
    kept = ~chosen[piece]
    parts, places, count = [np.column_stack((piece, start, end))[kept]], [places_m], len(places_m)
    by_piece = np.argsort(piece, kind="stable")
    begin = np.searchsorted(piece[by_piece], np.arange(len(chosen) + 1))
    for number in np.flatnonzero(chosen):
        rows = by_piece[begin[number] : begin[number + 1]]
        own, edges = np.unique(np.column_stack((start[rows], end[rows])), return_inverse=True)
        edges, crossed = _outer_edges(
            edges.reshape(-1, 2), places_m[own], normal_of_piece[number], tolerance_m
        )
        own = np.concatenate((own, count + np.arange(len(crossed))))
        parts.append(np.column_stack((np.full(len(edges), number), own[edges])))
        places.append(crossed)
        count += len(crossed)
    piece, start, end = np.concatenate(parts).T
    return piece, start, end, np.concatenate(places)


def _may_overlap(
    piece: IntArray, start: IntArray, end: IntArray, places_m: FloatArray, normal: FloatArray
) -> npt.NDArray[np.bool_]:
    """Return (p,) bool: pieces whose outline touches itself, or has not exactly one outer loop."""
    corners, pieces = len(places_m), len(normal)
    times = np.bincount(start, minlength=corners)
    loop = connected_labels(corners, np.column_stack((start, end)))
    twice = np.cross(places_m[start], places_m[end])
    area = np.bincount(loop[start], np.sum(twice * normal[piece], axis=1), minlength=corners)
    outer = np.zeros(corners, dtype=np.bool_)
    outer[loop[start]] = area[loop[start]] > 0.0
    piece_of_loop = np.zeros(corners, dtype=np.int64)
    piece_of_loop[loop[start]] = piece
    loops = np.bincount(piece_of_loop[outer], minlength=pieces)
    sizes = np.bincount(piece, minlength=pieces)
    chosen = (sizes > 0) & (loops != 1)
    chosen[piece[times[start] > 1]] = True
    few_enough: npt.NDArray[np.bool_] = chosen & (sizes <= LARGEST_OUTLINE)
    return few_enough


def _outer_edges(
    ends: IntArray, places_m: FloatArray, normal: FloatArray, tolerance_m: float
) -> tuple[IntArray, FloatArray]:
    """Return (m, 2) edges between covered and bare ground, and corners (c, 3) [m] where some cross.

    The edges cut the plane into cells, each covered by whole layers. What bounds the covered cells
    is closed whatever the corners' noise, since the way around each cell is.
    """
    span = places_m[ends[:, 1]] - places_m[ends[:, 0]]
    axes = np.stack((span[0], np.cross(normal, span[0]))) / np.linalg.norm(span[0])
    corners = places_m
    # A cut bends an edge by up to the tolerance, by which it may come to lie on others, or cross.
    for _ in range(_ROUNDS):
        # Corners and edges that noise keeps apart come together before anything is cut.
        near = weld(corners, 2.0 * tolerance_m)[ends]
        near = near[near[:, 0] != near[:, 1]]
        ends = _outline_kernels.split_edges(
            np.array([0, len(near)]), near[:, 0], near[:, 1], corners, tolerance_m
        )[:, 1:]
        uv = (corners - places_m[0]) @ axes.T
        pairs, along = _overlap_kernels.crossings(uv[ends].reshape(-1, 4), tolerance_m)
        if len(pairs) == 0:
            break
        ends, corners = _cut(ends, corners, pairs, along)
    return _bounds_of_covered(ends, (corners - places_m[0]) @ axes.T), corners[len(places_m) :]


def _cut(
    ends: IntArray, corners_m: FloatArray, pairs: IntArray, along_m: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return edges (m, 2) cut where pairs (c, 2) of them cross, and all corners [m]."""
    first = ends[pairs[:, 0]]
    span = corners_m[first[:, 1]] - corners_m[first[:, 0]]
    crossed = corners_m[first[:, 0]] + along_m[:, :1] / np.linalg.norm(span, axis=1)[:, None] * span
    cuts: list[list[tuple[float, int]]] = [[] for _ in ends]
    for edge, place, corner in zip(
        pairs.flat, along_m.flat, len(corners_m) + np.repeat(np.arange(len(pairs)), 2), strict=True
    ):
        cuts[edge].append((float(place), int(corner)))
    rows = np.array(
        [
            pair
            for k, (begin, end) in enumerate(ends.tolist())
            for pair in pairwise([begin, *(corner for _, corner in sorted(cuts[k])), end])
        ],
        dtype=np.int64,
    ).reshape(-1, 2)
    return rows, np.concatenate((corners_m, crossed))


def _bounds_of_covered(rows: IntArray, uv_m: FloatArray) -> IntArray:
    """Return (m, 2) the edges, of (k, 2) that meet at corners (n, 2) [m] only, around their left.

    A cell is a way along the left of edges; the layers on it differ from those of the next cell by
    the edge between them, and are counted from the cell around all.
    """
    low, high = rows.min(axis=1), rows.max(axis=1)
    _, first, member = row_numbers(np.column_stack((low, high)))
    net = np.add.reduceat(np.sign(rows[:, 1] - rows[:, 0])[member], first[:-1])
    one = member[first[:-1]][net != 0]
    a, b, layers, count = low[one], high[one], net[net != 0], int((net != 0).sum())
    if count == 0:
        return np.zeros((0, 2), dtype=np.int64)
    # Each edge is walked both ways: way k from a to b, way k + count back.
    start, end = np.concatenate((a, b)), np.concatenate((b, a))
    direction = uv_m[end] - uv_m[start]
    order = np.lexsort((np.arctan2(direction[:, 1], direction[:, 0]), start))
    begin = np.searchsorted(start[order], start[order], side="left")
    last = np.searchsorted(start[order], start[order], side="right") - 1
    number = np.arange(2 * count)
    clockwise = np.empty(2 * count, dtype=np.int64)
    clockwise[order] = order[np.where(number > begin, number - 1, last)]
    cell = connected_labels(2 * count, np.column_stack((number, np.roll(clockwise, count))))
    left, right = cell[:count], cell[count:]
    twice = uv_m[start, 0] * uv_m[end, 1] - uv_m[end, 0] * uv_m[start, 1]
    area = np.bincount(cell, weights=twice)
    part = connected_labels(len(area), np.column_stack((left, right)))
    around = np.lexsort((area, part))
    around = around[np.searchsorted(part[around], np.arange(int(part.max()) + 1))]
    steps: list[list[tuple[int, int]]] = [[] for _ in area]
    for i, j, step in zip(left.tolist(), right.tolist(), layers.tolist(), strict=True):
        steps[i].append((j, -step))
        steps[j].append((i, step))
    layer = np.full(len(area), np.iinfo(np.int64).min)
    for outermost in around.tolist():
        others = part[left] != part[outermost]
        place = uv_m[start[np.flatnonzero(cell == outermost)[0]]]
        layer[outermost] = _windings(uv_m[a[others]], uv_m[b[others]], layers[others], place)
        waiting = [outermost]
        for here in waiting:
            for there, step in steps[here]:
                if layer[there] == np.iinfo(np.int64).min:
                    layer[there] = layer[here] + step
                    waiting.append(there)
    covered = layer > 0
    forward, back = covered[left] & ~covered[right], covered[right] & ~covered[left]
    bounds = (np.column_stack((a, b))[forward], np.column_stack((b, a))[back])
    return np.unique(np.concatenate(bounds), axis=0)


def _windings(start_m: FloatArray, end_m: FloatArray, times: IntArray, place_m: FloatArray) -> int:
    """Return how often edges (k, 2), each counted ``times``, wind around a place (2,) [m]."""
    (u0, v0), (u1, v1) = (start_m - place_m).T, (end_m - place_m).T
    side = u0 * v1 - u1 * v0
    up, down = (v0 <= 0.0) & (v1 > 0.0) & (side > 0.0), (v0 > 0.0) & (v1 <= 0.0) & (side < 0.0)
    return int(times[up].sum() - times[down].sum())
