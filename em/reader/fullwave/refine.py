"""Refinement of any triangle mesh down to a longest edge; what shares edges goes on to do so."""

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number
from octant.geometries.tolerances import LENGTHS

MOST_ROUNDS = 40
"""Rounds of halving edges after which a mesh counts as fine enough [-]."""


def refined_mesh(
    vertices_m: npt.ArrayLike, faces: npt.ArrayLike, *, longest_m: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Return vertices (v, 3) [m] and triangles (f, 3) with no edge longer than asked.

    Parameters
    ----------
    vertices_m : (v, 3) array_like — Vertices [m]; triangles that touch must share them.
    faces : (f, 3) array_like — Vertex indices [-].
    longest_m : Greatest edge length wanted [m].

    Returns
    -------
    tuple of ndarray
        Vertices, the given ones first, and triangles of the same orientation.

    Notes
    -----
    Every round halves the edges that are longer than asked and not much shorter than the longest
    edge of a triangle beside them; a halved edge is halved for all its triangles.
    """
    points = np.array(frozen_array(vertices_m, name="vertices_m", shape=(None, 3)))
    triangles = np.array(frozen_array(faces, name="faces", shape=(None, 3), dtype=np.int64))
    limit = positive_number(longest_m, name="longest_m")
    for _ in range(MOST_ROUNDS):
        sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
        edges, of_side = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
        of_side = of_side.reshape(-1, 3)
        length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        longest = np.zeros(len(edges))
        for k in range(3):
            np.maximum.at(longest, of_side[:, k], length[of_side].max(axis=1))
        split = (length > limit * (1.0 + LENGTHS.same_share)) & (length >= 0.75 * longest)
        split |= (length > limit * (1.0 + LENGTHS.same_share)) & (length >= length[of_side].max())
        if not split.any():
            if not (length > limit * (1.0 + LENGTHS.same_share)).any():
                break
            split = length > limit * (1.0 + LENGTHS.same_share)
        middle = np.full(len(edges), -1)
        middle[split] = len(points) + np.arange(int(split.sum()))
        points = np.concatenate((points, points[edges[split]].mean(axis=1)))
        triangles = _divided(triangles, middle[of_side])
    return points, triangles


def _divided(
    triangles: npt.NDArray[np.int64], middle: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Return the triangles cut at their edges' new middle vertices (-1 where there is none)."""
    cut = (middle >= 0).sum(axis=1)
    parts = [triangles[cut == 0]]
    for number in (1, 2):
        some = cut == number
        # Turn each triangle so that the cut edge (or, of two, the whole edge) is its first.
        odd = (middle[some] >= 0) if number == 1 else (middle[some] < 0)
        turn = (np.argmax(odd, axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(triangles[some], turn, axis=1).T
        m = np.take_along_axis(middle[some], turn, axis=1).T
        if number == 1:
            parts += [np.column_stack((a, m[0], c)), np.column_stack((m[0], b, c))]
        else:
            parts += [
                np.column_stack((c, m[2], m[1])),
                np.column_stack((a, b, m[1])),
                np.column_stack((a, m[1], m[2])),
            ]
    some = cut == 3
    (a, b, c), (ab, bc, ca) = triangles[some].T, middle[some].T
    parts += [
        np.column_stack((a, ab, ca)),
        np.column_stack((ab, b, bc)),
        np.column_stack((ca, bc, c)),
        np.column_stack((ab, bc, ca)),
    ]
    return np.concatenate(parts)
