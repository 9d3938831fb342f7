"""The reader's sheets in convex pieces, each meshed once for all pieces congruent with it."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from octant.em.reader.fullwave._element_size import ElementSize
from octant.em.reader.fullwave._polygon_mesh import mesh_polygon
from octant.em.reader.fullwave._strips import Strip
from octant.geometries._plane_geometry import FloatArray, IntArray, weld
from octant.geometries._reader_mesh import reach_to_rim_m
from octant.geometries.reader_body import ReaderBody
from octant.geometries.tolerances import LENGTHS

Piece = tuple[FloatArray, IntArray]
"""Vertices (v, 3) [m] and triangles (f, 3) [-]."""

UP = np.array((0.0, 0.0, 1.0))


class PieceMesher:
    """Meshes convex planar pieces; congruent ones among congruent strips get the same mesh."""

    def __init__(self, size: ElementSize) -> None:
        self._size = size
        self._known: dict[object, Piece] = {}

    def mesh(self, corners_m: FloatArray, fixed_m: FloatArray | None = None) -> Piece:
        """Return the mesh of a convex polygon (k, 3), with (f, 3) further vertices inside it.

        The first edge, taken from the first corner, sets the frame; the piece is also compared
        with its mirror image, whose first edge is the last one backwards.
        """
        fixed = np.zeros((0, 3)) if fixed_m is None else fixed_m
        origin = corners_m[0]
        normal = np.zeros(3)
        for a, b in itertools.pairwise(corners_m[1:]):
            normal += np.cross(a - origin, b - origin)
        normal /= np.linalg.norm(normal)
        views = []
        mirrored = np.concatenate((corners_m[:1], corners_m[:0:-1]))
        for ring, up in ((corners_m, normal), (mirrored, -normal)):
            u = (ring[1] - ring[0]) / np.linalg.norm(ring[1] - ring[0])
            axes = np.array((u, np.cross(up, u), up))
            flat = np.round((ring - origin) @ axes.T, 10)[:, :2] + 0.0
            inside = np.round((fixed - origin) @ axes.T, 10)[:, :2] + 0.0
            inside = inside[np.lexsort(inside.T)]
            # Seen from either side the strips are the same: drop the sign of the height.
            seen = self._size.key(origin, axes)
            below = self._size.key(origin, axes * np.array((1.0, 1.0, -1.0))[:, None])
            key = (tuple(flat.ravel()), tuple(inside.ravel()), min(seen, below))
            views.append((key, ring, axes, inside))
        key, ring, axes, inside = min(views, key=lambda view: view[0])
        if key not in self._known:
            flat = (ring - origin) @ axes[:2].T

            def size(points_m: FloatArray) -> FloatArray:
                return self._size.at(origin + points_m @ axes[:2])

            self._known[key] = mesh_polygon(flat, size, inside)
        points, faces = self._known[key]
        return origin + points @ axes[:2], faces


def _spokes(body: ReaderBody, rim_m: FloatArray) -> list[tuple[float, list[FloatArray], bool]]:
    """Return azimuth, places from the axis outwards, and whether an antenna is on each spoke."""
    inner = tuple(body.plate_outline_m[1:-1, 0].tolist())
    marks = [(float(a), body.antenna_radius_m, True) for a in body.element_azimuths_rad]
    marks += [(float(a), body.plate_outer_radius_m, False) for a in body.plate_azimuths_rad]
    marks.sort()
    spokes = []
    for azimuth, radius, is_antenna in marks:
        within = () if is_antenna else inner
        end = float(reach_to_rim_m(np.array([azimuth]), rim_m)[0])
        direction = np.array((math.cos(azimuth), math.sin(azimuth)))
        outer = end * direction
        near = np.flatnonzero(np.abs(rim_m - outer).max(axis=1) <= LENGTHS.same_share * end)
        outer = rim_m[near[0]] if near.size else outer
        on_rim = radius >= end * (1.0 - LENGTHS.same_share)
        places = [*(r * direction for r in within), outer if on_rim else radius * direction]
        spokes.append((azimuth, places if on_rim else [*places, outer], is_antenna))
    return spokes


def ground_pieces(
    body: ReaderBody,
    rim_m: FloatArray,
    strips: Sequence[Strip],
    mesher: PieceMesher,
    *,
    joined: bool,
) -> list[Piece]:
    """Return the ground plane's pieces, one between any two neighbouring spokes."""
    spokes = _spokes(body, rim_m)
    rim_angles = np.mod(np.arctan2(rim_m[:, 1], rim_m[:, 0]), 2.0 * math.pi)
    feet = np.concatenate([strip.foot_m[[0, 2], :2] for strip in strips])
    foot_angles = np.mod(np.arctan2(feet[:, 1], feet[:, 0]), 2.0 * math.pi)
    pieces = []
    for i, (azimuth, places, _) in enumerate(spokes):
        following, far_places, _ = spokes[(i + 1) % len(spokes)]
        width = (following - azimuth) % (2.0 * math.pi)

        def within(
            angles: FloatArray, start: float = azimuth, width: float = width
        ) -> tuple[IntArray, FloatArray]:
            ahead = np.mod(angles - start, 2.0 * math.pi)
            return np.flatnonzero(
                (ahead > LENGTHS.same_share) & (ahead < width - LENGTHS.same_share)
            ), ahead

        found, ahead = within(rim_angles)
        outline = [(ahead[k], rim_m[k]) for k in found]
        fixed = []
        if joined:
            found, ahead = within(foot_angles)
            for k in found:
                reach = float(reach_to_rim_m(foot_angles[k : k + 1], rim_m)[0])
                if np.hypot(*feet[k]) >= reach * (1.0 - LENGTHS.turned_share):
                    outline.append((ahead[k], feet[k]))
                else:
                    fixed.append(feet[k])
        between = [point for _, point in sorted(outline, key=lambda entry: float(entry[0]))]
        sector = np.array([np.zeros(2), *places, *between, *far_places[::-1]])
        inside = np.array(fixed).reshape(-1, 2)
        pieces.append(mesher.mesh(_flat(sector), _flat(inside)))
    return pieces


def _flat(points_m: FloatArray) -> FloatArray:
    """Return (n, 3) points of the plane z = 0 [m]."""
    return np.column_stack((points_m, np.zeros(len(points_m))))


def plate_pieces(body: ReaderBody, mesher: PieceMesher) -> list[Piece]:
    """Return the plates, each from the axis out, one piece between any two heights given."""
    pieces = []
    for azimuth in body.plate_azimuths_rad:
        out = np.array((math.cos(azimuth), math.sin(azimuth), 0.0))
        for (near, near_height), (far, height) in itertools.pairwise(body.plate_outline_m):
            corners = [near * out, far * out]
            if height > 0.0:
                corners.append(far * out + height * UP)
            if near_height > 0.0:
                corners.append(near * out + near_height * UP)
            pieces.append(mesher.mesh(np.array(corners)))
    return pieces


def plane_pieces(strips: Sequence[Strip], side_m: float, mesher: PieceMesher) -> list[Piece]:
    """Return the monopoles' own square planes, two halves each, two sides along the radius."""
    pieces = []
    for strip in strips:
        right, middle, left = strip.foot_m
        radial = np.array((middle[0], middle[1], 0.0)) / np.hypot(middle[0], middle[1])
        across = np.cross(UP, radial)
        inner, outer = middle - 0.5 * side_m * radial, middle + 0.5 * side_m * radial
        far = 0.5 * side_m * across
        pieces.append(
            mesher.mesh(np.array((inner, middle, outer, outer + far, inner + far)), left[None])
        )
        pieces.append(
            mesher.mesh(np.array((inner, inner - far, outer - far, outer, middle)), right[None])
        )
    return pieces


def joined_pieces(pieces: Sequence[Piece], tolerance_m: float = LENGTHS.joined_m) -> Piece:
    """Return all pieces as one, vertices nearer to each other than the tolerance [m] made one."""
    starts = np.cumsum([0, *(len(points) for points, _ in pieces)])
    points = np.concatenate([points for points, _ in pieces])
    faces = np.concatenate([f + start for (_, f), start in zip(pieces, starts, strict=False)])
    faces = weld(points, tolerance_m)[faces]
    used, faces = np.unique(faces, return_inverse=True)
    return points[used], faces.reshape(-1, 3).astype(np.int64)
