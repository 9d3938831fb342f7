"""Even triangle meshes of metal bodies beside the reader, and how many functions they carry.

Triangles that lie in one plane are first joined to convex polygons, so that the mesh depends on the
body's shape and not on how it was drawn.
"""

import functools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave._element_size import ElementSize
from octant.em.reader.fullwave._orientation import oriented
from octant.em.reader.fullwave._reader_pieces import Piece, PieceMesher, joined_pieces
from octant.em.reader.fullwave._symmetry import turned, turns_of
from octant.em.reader.fullwave.basis import best_sectors
from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number
from octant.geometries._plane_geometry import FloatArray, IntArray, weld
from octant.geometries.bodies import Body
from octant.geometries.tolerances import LENGTHS

Ring = tuple[int, ...]
"""Corners of a polygon in order [-]; some may stand on a straight edge."""

CONVEX = 1e-6
"""Sine of the angle by which a corner may turn inwards and still count as straight [-]."""


def even_mesh(
    vertices_m: npt.ArrayLike, faces: npt.ArrayLike, *, edge_m: float, turns: int = 1
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Return vertices (v, 3) [m] and triangles (f, 3) of a body, laid evenly on its flat parts.

    Parameters
    ----------
    vertices_m : (v, 3) array_like — Vertices [m]; those at one place count as one.
    faces : (f, 3) array_like — Vertex indices [-].
    edge_m : Edge length wanted [m]; triangles that bend and have shorter edges stay as they are.
    turns : Number whose divisors are rotations about z that the mesh keeps where the body has them.
    """
    points = frozen_array(vertices_m, name="vertices_m", shape=(None, 3))
    given = frozen_array(faces, name="faces", shape=(None, 3), dtype=np.int64)
    edge = positive_number(edge_m, name="edge_m")
    mesher = PieceMesher(
        ElementSize(
            coarse_m=edge,
            finest_m=edge,
            strips_m=np.zeros((0, 2, 3)),
            planes_m=np.zeros((0, 3)),
        )
    )
    pieces: list[Piece] = []
    for ring in _convex_rings(points, oriented(points, _proper(points, given))):
        corners = points[list(ring)]
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
        if len(ring) == 3 and sides.max() <= edge * (1.0 + LENGTHS.same_share):
            pieces.append((corners, np.arange(3)[None]))
        else:
            pieces += [mesher.mesh(part) for part in _parts(corners, turns)]
    laid, triangles = joined_pieces(pieces, LENGTHS.weld_m)
    return laid, _proper(laid, triangles)


def surroundings_size(bodies: Sequence[Body], *, edge_m: float, antennas: int) -> tuple[int, int]:
    """Return how many functions bodies add to the reader's, and how many sectors they leave it.

    Parameters
    ----------
    bodies : Metal beside the reader, in its frame.
    edge_m : Edge length of its mesh [m].
    antennas : Number of antennas, which the number of sectors divides.
    """
    content = tuple((b.vertices_m.tobytes(), b.faces.tobytes()) for b in bodies)
    return _size_of(content, float(edge_m), antennas)


@functools.lru_cache(maxsize=64)
def _size_of(
    content: tuple[tuple[bytes, bytes], ...], edge_m: float, antennas: int
) -> tuple[int, int]:
    if not content:
        return 0, antennas
    meshes = [
        even_mesh(
            np.frombuffer(points).reshape(-1, 3),
            np.frombuffer(faces, dtype=np.int64).reshape(-1, 3),
            edge_m=edge_m,
            turns=antennas,
        )
        for points, faces in content
    ]
    vertices, faces = joined_pieces(meshes)
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    sheets = np.unique(sides, axis=0, return_counts=True)[1]
    return int((sheets - 1).sum()), best_sectors(vertices, faces, turns_of(antennas))


def _proper(points_m: FloatArray, faces: IntArray) -> IntArray:
    """Return the triangles with vertices at one place made one, without those that have no area."""
    joined: IntArray = weld(points_m, LENGTHS.weld_m)[faces]
    a, b, c = (points_m[joined[:, k]] for k in range(3))
    longest = np.maximum.reduce([((u - v) ** 2).sum(axis=1) for u, v in ((a, b), (b, c), (c, a))])
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    proper: IntArray = joined[area > LENGTHS.same_share * longest]
    return proper


def _convex_rings(points_m: FloatArray, faces: IntArray) -> list[Ring]:
    """Return convex polygons that cover a mesh, joined over the longest edges first.

    An edge on which three or more triangles meet stays one, as does every corner of an outline:
    polygons that touch share all corners there.
    """
    rings: dict[int, Ring] = dict(enumerate(map(tuple, faces.tolist())))
    owner = list(range(len(faces)))
    sides = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges, of_side, sheets = np.unique(
        np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    order = np.argsort(of_side.reshape(-1), kind="stable")
    first = np.concatenate(([0], np.cumsum(sheets)))[:-1]
    two = np.flatnonzero(sheets == 2)
    pairs = np.column_stack((order[first[two]], order[first[two] + 1])) // 3
    a, b, c = (points_m[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    flat = np.linalg.norm(np.cross(normal[pairs[:, 0]], normal[pairs[:, 1]]), axis=1) < 1e-3
    length = np.linalg.norm(points_m[edges[two, 0]] - points_m[edges[two, 1]], axis=1)
    open_edges = [i for i in np.argsort(-np.round(length, 9), kind="stable").tolist() if flat[i]]
    joined = True
    while joined:
        joined, left = False, []
        for i in open_edges:
            one, other = (_root(owner, t) for t in pairs[i].tolist())
            if one == other:
                continue
            u, v = edges[two[i]].tolist()
            ring = _joined_rings(rings[one], rings[other], u, v)
            if ring is None or not _is_convex(points_m[list(ring)]):
                left.append(i)
                continue
            rings[one] = ring
            del rings[other]
            owner[other] = one
            joined = True
        open_edges = left
    return list(rings.values())


def _root(owner: list[int], number: int) -> int:
    """Return the polygon that a triangle is part of by now."""
    while owner[number] != number:
        owner[number] = owner[owner[number]]
        number = owner[number]
    return number


def _joined_rings(one: Ring, other: Ring, u: int, v: int) -> Ring | None:
    """Return the outline of two polygons that share the edge u v, or None where it is not one."""
    count = len(one)
    if one[(one.index(u) + 1) % count] != v:
        u, v = v, u
    if other[(other.index(v) + 1) % len(other)] != u:
        other = other[::-1]
    start, back = one.index(v), other.index(u)
    ring = [*one[start:], *one[:start], *other[back:], *other[:back]]
    # Corners u and v stand twice in a row now; further shared edges stand there and back.
    k = 0
    while len(ring) >= 3 and k < len(ring):
        if ring[k] == ring[(k + 1) % len(ring)]:
            del ring[k]
        elif ring[k - 1] == ring[(k + 1) % len(ring)]:
            for gone in sorted((k, (k + 1) % len(ring)), reverse=True):
                del ring[gone]
        else:
            k += 1
            continue
        k = 0
    return tuple(ring) if len(ring) >= 3 and len(set(ring)) == len(ring) else None


def _is_convex(corners_m: FloatArray) -> bool:
    """Return whether a polygon (k, 3) is flat and convex; corners on straight edges are allowed."""
    along = np.roll(corners_m, -1, axis=0) - corners_m
    along /= np.linalg.norm(along, axis=1)[:, None]
    centred = corners_m - corners_m.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    normal /= np.linalg.norm(normal)
    if np.abs(centred @ normal).max() > LENGTHS.place_m:
        return False
    following = np.roll(along, -1, axis=0)
    sine, cosine = np.cross(along, following) @ normal, (along * following).sum(axis=1)
    whole = abs(float(np.arctan2(sine, cosine).sum()) - 2.0 * math.pi) < 1.0
    return bool(sine.min() > -CONVEX) and whole


def _parts(corners_m: FloatArray, turns: int) -> list[FloatArray]:
    """Return a convex polygon (k, 3) so that turned polygons get turned meshes.

    One that the axis pierces is cut into sectors where a turn leaves it the same; another begins at
    the corner from which the heights and distances from the axis are least.
    """
    count = len(corners_m)
    normal = np.cross(corners_m, np.roll(corners_m, -1, axis=0)).sum(axis=0)
    upward = corners_m if normal[2] >= 0.0 else corners_m[::-1]
    for sectors in turns_of(turns):
        if count % sectors or np.abs(np.ptp(corners_m[:, 2])) > LENGTHS.place_m:
            continue
        step = count // sectors
        there = turned(upward, 2.0 * math.pi / sectors)
        if np.abs(there - np.roll(upward, -step, axis=0)).max() > LENGTHS.place_m:
            continue
        axis = np.array((0.0, 0.0, upward[0, 2]))
        closed = np.concatenate((upward, upward[:1]))
        return [
            np.concatenate((axis[None], closed[s * step : (s + 1) * step + 1]))
            for s in range(sectors)
        ]
    place = np.column_stack((corners_m[:, 2], np.hypot(corners_m[:, 0], corners_m[:, 1])))
    place = np.round(place, 7) + 0.0
    begin = min(range(count), key=lambda k: np.roll(place, -k, axis=0).ravel().tolist())
    return [np.roll(corners_m, -begin, axis=0)]
