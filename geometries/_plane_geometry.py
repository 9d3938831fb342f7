"""Small vectorised pieces of plane geometry that several modules of this layer share."""

import numpy as np
import numpy.typing as npt

from octant.geometries import _plane_kernels

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

ODD_DIRECTION = np.array([0.7548776662466927, 0.5698402909980532, 0.3247179572447461])
"""A direction whose components no whole numbers relate: powers of the inverse plastic number."""


def triangle_area_vectors(vertices_m: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m, 3) area vectors [m^2]: normal by the right-hand rule times the triangle's area."""
    a, b, c = (vertices_m[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def connected_labels(count: int, pairs: IntArray) -> IntArray:
    """Return (count,) component labels of a graph given by (k, 2) index pairs."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(pairs), dtype=np.int8)
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    labels: IntArray = connected_components(graph, directed=False)[1].astype(np.int64)
    return labels


def row_numbers(rows: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return (n,) the number of each row of whole numbers >= 0, by value, and which rows have it.

    Equal rows share number i; they are ``member[start[i] : start[i + 1]]``, ascending.
    """
    key, span = np.zeros(len(rows), dtype=np.int64), 1
    for column in rows.T:  # whole numbers sort far quicker than rows
        width = int(column.max(initial=0)) + 1
        if span * width >= 2**62:
            key = np.unique(key, return_inverse=True)[1].reshape(-1)
            span = len(rows)
        key, span = key * width + column, span * width
    member = np.argsort(key, kind="stable")
    first = np.ones(len(rows), dtype=np.bool_)
    first[1:] = key[member][1:] != key[member][:-1]
    number = np.empty(len(rows), dtype=np.int64)
    number[member] = np.cumsum(first) - 1
    return number, np.append(np.flatnonzero(first), len(rows)), member


def weld(vertices_m: FloatArray, tolerance_m: float) -> IntArray:
    """Return (n,) index of the first of the vertices that are nearer than ``tolerance_m`` [m].

    No vertex moves: exact coordinates stay exact. Only vertices of nearly the same height along an
    odd direction are compared, in which no two corners of a regular mesh agree.
    """
    points = np.ascontiguousarray(vertices_m, dtype=np.float64)
    representative: IntArray = np.arange(len(points), dtype=np.int64)
    if len(points):
        height = points @ ODD_DIRECTION
        slack = 4e-15 * float(np.abs(points).max())
        order = np.argsort(height, kind="stable")
        _plane_kernels.weld(points, order, height, tolerance_m, slack, representative)
    return representative


def triangle_bounds_m(vertices_m: FloatArray, faces: IntArray) -> FloatArray:
    """Return (2, 3) bounds [m] of the triangles that have an area; stray vertices do not count."""
    has_area = triangle_area_vectors(vertices_m, faces).any(axis=1)
    used = vertices_m[(faces[has_area] if has_area.any() else faces).reshape(-1)]
    return np.stack((used.min(axis=0), used.max(axis=0)))


def distinct_triangles(faces: IntArray, material: IntArray, room_faces: int) -> IntArray:
    """Return distinct triangles of three welded corners, the room's apart from the objects'."""
    corners = np.sort(faces, axis=1)
    real = np.flatnonzero((corners[:, :2] < corners[:, 1:]).all(axis=1))
    keys = np.column_stack((corners, material, np.arange(len(faces)) < room_faces))
    _, start, member = row_numbers(keys[real].astype(np.int64))
    return np.sort(real[member[start[:-1]]])
