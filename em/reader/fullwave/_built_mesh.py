"""A drawn reader's mesh moved to where things are as built: the same triangles, other corners.

Meshing the built reader afresh would change the number and the shape of its triangles with every
error, and the solution with them by up to a tenth of a decibel. Moved corners keep the geometry as
exact, and make the solution a smooth function of the errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave._strips import Strip
from octant.em.reader.fullwave._symmetry import turned
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries._reader_mesh import reach_to_rim_m
from octant.geometries.build_errors import BuildErrors
from octant.geometries.errors import GeometryError
from octant.geometries.reader_body import ReaderBody
from octant.geometries.tolerances import LENGTHS

BoolArray = npt.NDArray[np.bool_]

GROUND, PLATE, PLANE, AROUND, STRIP = range(5)
"""Kinds of sheet: ground plane, plates, monopoles' own planes, surroundings, antennas."""

DRAGGED_M = 0.02
"""Greatest distance [m] from an antenna's foot at which the ground plane's mesh follows it."""

LEAST_DRAGGED_M = 0.008
"""Distance [m] from a foot to the rim or a plate below which no mesh follows it: a millimetre's
shift would press its triangles flat."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parts:
    """A joined mesh and what each triangle belongs to: kind, and number among its kind."""

    vertices_m: FloatArray
    faces: IntArray
    kind: IntArray
    number: IntArray

    def vertices_of(self, kind: int, number: int | None = None) -> IntArray:
        """Return the vertices of a sheet, or of all sheets of a kind."""
        chosen = self.kind == kind
        if number is not None:
            chosen &= self.number == number
        return np.unique(self.faces[chosen])


def built_lines_m(body: ReaderBody, strips: Sequence[Strip], *, joined: bool) -> FloatArray:
    """Return (n, 2, 3) lower and upper end of each antenna as built [m]."""
    lines = np.array([strip.middle_line_m for strip in strips])
    errors = body.errors
    if errors is None:
        return lines
    azimuth, radius = body.built.element_azimuths_rad, body.built.element_radii_m
    length = np.array([strip.length_m for strip in strips]) + errors.length_m
    bottom = lines[:, 0, 2] + (0.0 if joined else errors.gap_m)
    for name, value in (("length_m", length), ("gap_m", np.where(joined, 1.0, bottom))):
        wrong = np.flatnonzero(value <= 0.0)
        if wrong.size:
            msg = (
                f"{name} of antenna {wrong[0] + 1} would be {value[wrong[0]]:.3g} m with its build "
                "error, but it must be more than 0; give smaller errors, or change the design."
            )
            raise GeometryError(msg)
    flat = np.zeros(len(azimuth))
    radial = np.column_stack((np.cos(azimuth), np.sin(azimuth), flat))
    across = np.column_stack((-radial[:, 1], radial[:, 0], flat))
    lean = errors.lean
    axis = lean[:, :1] * radial + lean[:, 1:] * across + np.array((0.0, 0.0, 1.0))
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    low = radius[:, None] * radial + bottom[:, None] * np.array((0.0, 0.0, 1.0))
    return np.stack((low, low + length[:, None] * axis), axis=1)


def built_vertices_m(
    parts: Parts,
    body: ReaderBody,
    strips: Sequence[Strip],
    lines_m: FloatArray,
    *,
    rim_m: FloatArray,
    joined: bool,
) -> FloatArray:
    """Return where the corners are as built [m].

    Strips keep level lower ends, as wide as drawn, and lean as parallelograms; monopoles' own
    planes stay level. The ground plane's corners follow plates and feet, its rim keeps its shape.
    """
    errors = body.errors
    if errors is None:
        return parts.vertices_m
    there = parts.vertices_m.copy()
    _move_plates(there, parts, body)
    for i, strip in enumerate(strips):
        turn = float(errors.azimuth_rad[i])
        foot, low = strip.foot_m[1], lines_m[i, 0]
        on_strip = parts.vertices_of(STRIP, i)
        from_foot = parts.vertices_m[on_strip] - foot
        along = from_foot[:, 2] / strip.length_m
        from_foot[:, 2] = 0.0
        there[on_strip] = low + turned(from_foot, turn) + along[:, None] * (lines_m[i, 1] - low)
        sheets = np.union1d(parts.vertices_of(PLANE, 2 * i), parts.vertices_of(PLANE, 2 * i + 1))
        sheets = np.setdiff1d(sheets, on_strip)
        there[sheets] = low + turned(parts.vertices_m[sheets] - foot, turn)
    _move_ground(there, parts, body, rim_m=rim_m, joined=joined)
    return there


def _move_plates(there: FloatArray, parts: Parts, body: ReaderBody) -> None:
    """Turn, stretch and raise the plates' corners in place."""
    built, reach = body.built, body.plate_outer_radius_m
    outline, between = body.plate_outline_m, len(body.plate_profile_m) + 1
    for k, azimuth in enumerate(body.plate_azimuths_rad):
        corners = np.unique(
            np.concatenate([parts.vertices_of(PLATE, between * k + j) for j in range(between)])
        )
        old = parts.vertices_m[corners]
        out = old @ np.array((np.cos(azimuth), np.sin(azimuth), 0.0))
        height = np.interp(out, outline[:, 0], outline[:, 1])
        new_height = np.interp(out, outline[:, 0], built.plate_heights_m(k))
        ratio = np.ones(len(old))
        np.divide(new_height, height, out=ratio, where=old[:, 2] > 0.0)
        stretch = built.plate_reaches_m[k] / reach
        moved = turned(old, float(built.plate_azimuths_rad[k] - azimuth))
        there[corners] = moved * np.column_stack((np.full((len(old), 2), stretch), ratio))


def _move_ground(
    there: FloatArray, parts: Parts, body: ReaderBody, *, rim_m: FloatArray, joined: bool
) -> None:
    """Move the ground plane's corners in place: rim and feet as given, the others smoothly."""
    ground = parts.vertices_of(GROUND)
    faces = parts.faces[parts.kind == GROUND]
    held = np.zeros(len(there), dtype=bool)
    rim = _border(faces)
    errors = body.errors
    if errors is None:
        return
    if joined:
        _refuse_moved_rim_feet(body, errors, rim_m)
    held[rim] = True
    on_plates, on_strips = parts.vertices_of(PLATE), parts.vertices_of(STRIP)
    free_rim = np.setdiff1d(rim, np.concatenate((on_plates, on_strips)))
    there[free_rim] = _built_rim_m(parts.vertices_m[free_rim], body, rim_m)
    held[np.intersect1d(ground, np.concatenate((on_plates, on_strips)))] = True
    shift = there[:, :2] - parts.vertices_m[:, :2]
    there[ground, :2] += _smooth(parts.vertices_m, faces, shift, held)[ground]
    if not joined:
        _drag_feet(there, parts.vertices_m, ground[held[ground]], ground[~held[ground]], body)
    a, b, c = (there[faces[:, k], :2] for k in range(3))
    u, v, w = (parts.vertices_m[faces[:, k], :2] for k in range(3))
    if (_cross(b - a, c - a) * _cross(v - u, w - u) <= 0.0).any():
        msg = (
            "the build errors move antennas or plates farther than the mesh of the ground plane "
            "can follow; give smaller errors, or draw the reader so."
        )
        raise GeometryError(msg)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def _border(faces: IntArray) -> IntArray:
    """Return the vertices on edges of one triangle only."""
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    return np.unique(edges[count == 1])


def _built_rim_m(points_m: FloatArray, body: ReaderBody, rim_m: FloatArray) -> FloatArray:
    """Return where points of the rim are as built: they follow the plates along it.

    Corners of a polygon stay corners; those of a round plane are free.
    """
    built = body.built
    knots, turns = body.plate_azimuths_rad, built.plate_azimuths_rad - body.plate_azimuths_rad
    if body.ground_plane_shape == "round":
        if not len(knots):
            knots = body.element_azimuths_rad
            turns = built.element_azimuths_rad - knots
    else:
        corners = np.mod(np.arctan2(rim_m[:, 1], rim_m[:, 0]), 2.0 * np.pi)
        apart = np.abs(np.mod(knots[:, None] - corners + np.pi, 2.0 * np.pi) - np.pi)
        at_corner = apart.min(axis=1, initial=np.inf) < LENGTHS.same_share
        if at_corner.any():
            end = reach_to_rim_m(knots[at_corner], rim_m).min()
            if body.plate_outer_radius_m >= end * (1.0 - LENGTHS.same_share):
                _refuse_moved_corner(turns[at_corner])
        knots = np.concatenate((knots[~at_corner], corners))
        turns = np.concatenate((turns[~at_corner], np.zeros(len(corners))))
    azimuth = np.arctan2(points_m[:, 1], points_m[:, 0])
    turn = np.interp(azimuth, knots, turns, period=2.0 * np.pi)
    radius = built.rim_scale * np.hypot(points_m[:, 0], points_m[:, 1])
    if body.ground_plane_shape != "round":
        radius = np.where(
            turn == 0.0, radius, reach_to_rim_m(azimuth + turn, built.rim_scale * rim_m)
        )
    moved: FloatArray = radius[:, None] * np.column_stack(
        (np.cos(azimuth + turn), np.sin(azimuth + turn), np.zeros(len(points_m)))
    )
    return moved


def _refuse_moved_corner(turns_rad: FloatArray) -> None:
    if turns_rad.any():
        msg = (
            "a plate ends on a corner of the ground plane and cannot be turned away from it by a "
            "build error; draw the plates a little shorter."
        )
        raise GeometryError(msg)


def _refuse_moved_rim_feet(body: ReaderBody, errors: BuildErrors, rim_m: FloatArray) -> None:
    """Raise when a monopole whose foot is part of the rim would leave it."""
    reach = reach_to_rim_m(body.element_azimuths_rad, rim_m)
    on_rim = body.antenna_radius_m >= reach * (1.0 - LENGTHS.same_share)
    leaves = errors.radial_m != 0.0
    if body.ground_plane_shape != "round":
        leaves |= errors.azimuth_rad != 0.0
    outside = body.built.element_radii_m >= body.built.rim_scale * reach
    wrong = np.flatnonzero((on_rim & leaves) | (~on_rim & outside))
    if wrong.size:
        msg = (
            f"antenna {wrong[0] + 1} is joined to the ground plane at or near its rim, where its "
            "foot cannot be moved by a build error; move the antennas in, or give them a plane of "
            "their own."
        )
        raise GeometryError(msg)


def _drag_feet(
    there: FloatArray, drawn_m: FloatArray, held: IntArray, free: IntArray, body: ReaderBody
) -> None:
    """Let the ground plane's fine mesh follow each antenna that stands well inside the sheets.

    Nearer to the rim or a plate it stays: there the mesh is fine all around.
    """
    from scipy.spatial import cKDTree

    drawn = body.antenna_radius_m * _directions(body.element_azimuths_rad)
    built = body.built.element_radii_m[:, None] * _directions(body.built.element_azimuths_rad)
    width = np.minimum(cKDTree(drawn_m[held, :2]).query(drawn)[0], DRAGGED_M)
    apart, index = cKDTree(drawn_m[free, :2]).query(drawn)
    chosen = np.flatnonzero((width >= LEAST_DRAGGED_M) & (apart < LENGTHS.joined_m))
    left = built - there[free[index], :2]
    for i in chosen:
        away = np.linalg.norm(drawn_m[free, :2] - drawn[i], axis=1)
        there[free, :2] += np.maximum(1.0 - away / width[i], 0.0)[:, None] * left[i]


def _directions(azimuths_rad: FloatArray) -> FloatArray:
    return np.column_stack((np.cos(azimuths_rad), np.sin(azimuths_rad)))


def _smooth(
    vertices_m: FloatArray,
    faces: IntArray,
    shift_m: FloatArray,
    held: BoolArray,
) -> FloatArray:
    """Return the shifts of the other vertices [m] that vary least: harmonic, linear elements.

    A shift that is linear in the place, such as a turn or a stretch, is continued exactly.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    used = np.unique(faces)
    free = used[~held[used]]
    out = np.zeros_like(shift_m)
    if not shift_m[held].any() or not len(free):
        return out
    count = len(vertices_m)
    rows, columns, weights = [], [], []
    for k in range(3):
        apex, a, b = faces[:, k], faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        to_a = vertices_m[a, :2] - vertices_m[apex, :2]
        to_b = vertices_m[b, :2] - vertices_m[apex, :2]
        cotangent = (to_a * to_b).sum(axis=1) / np.abs(_cross(to_a, to_b))
        rows += [a, b, a, b]
        columns += [b, a, a, b]
        weights += [-cotangent, -cotangent, cotangent, cotangent]
    entries = (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns)))
    stiffness = coo_matrix(entries, shape=(count, count)).tocsr()
    known = np.flatnonzero(held)
    right = -(stiffness[free][:, known] @ shift_m[known])
    out[free] = splu(stiffness[free][:, free].tocsc()).solve(right)
    return out
