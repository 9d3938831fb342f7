"""The outline of what overlaps itself: triangles given twice in two meshings, boxes squashed flat.

Such a piece is one polygon for rays. Where two layers of it end in one there is no edge, though
there is one in the sum of the triangles' outlines.
"""

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from octant.geometries import _overlap_kernels
from octant.geometries._plane_geometry import (
    FloatArray,
    IntArray,
    connected_labels,
    row_numbers,
    weld,
)

LARGEST_OUTLINE = 20_000
"""Edges [-] of a piece above which overlaps are not resolved: the time grows with the square."""


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
    corners: IntArray, places_m: FloatArray, normal: FloatArray, tolerance_m: float
) -> tuple[IntArray, FloatArray]:
    """Return (m, 2) edges with nothing on their right, and corners (c, 3) [m] where some cross."""
    number, first, member = row_numbers(corners)
    corners, weights = corners[member[first[:-1]]], np.bincount(number)
    span = places_m[corners[:, 1]] - places_m[corners[:, 0]]
    length = np.linalg.norm(span, axis=1)
    axes = np.stack((span[0], np.cross(normal, span[0]))) / length[0]
    uv = (places_m - places_m[0]) @ axes.T
    pairs, along = _overlap_kernels.crossings(uv[corners].reshape(-1, 4), tolerance_m)
    share = along / length[pairs]
    crossed = places_m[corners[pairs[:, 0], 0]] + share[:, :1] * span[pairs[:, 0]]
    joined = len(places_m) + np.repeat(weld(crossed, 2.0 * tolerance_m), 2)
    cuts: list[list[tuple[float, int]]] = [[] for _ in corners]
    for edge, place, corner in zip(pairs.flat, along.flat, joined, strict=True):
        cuts[edge].append((float(place), int(corner)))
    rows = np.array(
        [
            (a, b, k)
            for k, (begin, end) in enumerate(corners.tolist())
            for a, b in pairwise([begin, *(corner for _, corner in sorted(cuts[k])), end])
            if a != b
        ]
    )
    uv = np.concatenate((uv, (crossed - places_m[0]) @ axes.T))
    winding = _overlap_kernels.right_windings(
        uv[rows[:, :2]].reshape(-1, 4), weights[rows[:, 2]], 2.0 * tolerance_m
    )
    outer: IntArray = np.unique(rows[winding == 0, :2], axis=0)
    return outer, crossed
