"""Small vectorised pieces of plane geometry that several modules of this layer share."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def triangle_area_vectors(vertices_m: FloatArray, faces: IntArray) -> FloatArray:
    """Return (m, 3) area vectors [m^2]: normal by the right-hand rule times the triangle's area."""
    a, b, c = (vertices_m[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def plane_basis(normal: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors u [-] along ``direction`` within the plane and v = normal x u [-]."""
    u = direction - normal * float(normal @ direction)
    u = u / np.linalg.norm(u)
    return u, np.cross(normal, u)


def connected_labels(count: int, pairs: IntArray) -> IntArray:
    """Return (count,) component labels [-] of a graph given by (k, 2) index pairs."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(pairs), dtype=np.int8)
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    labels: IntArray = connected_components(graph, directed=False)[1].astype(np.int64)
    return labels


def weld(vertices_m: FloatArray, tolerance_m: float) -> IntArray:
    """Return (n,) index of the representative of each vertex.

    Vertices nearer than ``tolerance_m`` [m] to one another share one representative; no vertex
    moves, so exact coordinates stay exact.
    """
    from scipy.spatial import cKDTree

    _, first, inverse = np.unique(vertices_m, axis=0, return_index=True, return_inverse=True)
    unique = vertices_m[first]
    pairs = cKDTree(unique).query_pairs(tolerance_m, output_type="ndarray")
    labels = connected_labels(len(unique), pairs.astype(np.int64))
    representative = np.full(labels.max() + 1, len(vertices_m), dtype=np.int64)
    np.minimum.at(representative, labels, first.astype(np.int64))
    welded: IntArray = representative[labels][inverse.reshape(-1)]
    return welded
