"""The immutable scene: bodies reduced to planes, facets and a hierarchy for occlusion."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from octant.geometries import _scene_kernels
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries._bvh_kernels import BvhArrays
from octant.geometries._plane_geometry import (
    FloatArray,
    IntArray,
    distinct_triangles,
    triangle_bounds_m,
    weld,
)
from octant.geometries.bodies import Body
from octant.geometries.closed_parts import facet_sides, find_closed_parts
from octant.geometries.errors import GeometryError
from octant.geometries.facets import Facets, build_facets
from octant.geometries.occlusion import build_bvh, segments_blocked, winding_numbers
from octant.geometries.planes import FLOAT32_BITS, rounding_m
from octant.geometries.tolerances import LENGTHS

MOST_PLANES = 6
"""Planes [-] through one point from which `Scene.stand_off` moves it; a room's corner has three."""


@dataclass(frozen=True, slots=True, kw_only=True, weakref_slot=True)
class Scene:
    """A room and its objects as the rays see them; both sides of every facet reflect.

    Parameters
    ----------
    bodies : Everything that the scene was built from, in order.
    material_names : Labels that ``facets.facet_material`` counts.
    facets : Planes and polygons.
    triangle_corners_m : (t, 3, 3) float64 — Corners [m] of the triangles that have an area.
    triangle_facet : (t,) int64 — Facet of each of them.
    facet_front : (f,) bool — Whether its triangles' outward side is the plane normal's [-].
    supporting_side : (p,) int64 — +1 or -1: the whole scene lies on the plane's side that the
        normal points to, or the other; 0: on both.
    bvh : Hierarchy over all triangles.
    inner_bvh : Hierarchy without supporting planes, which block nothing between points inside them.
    shell_corners_m : (s, 3, 3) float64 — Triangles [m] of the closed room; none: open or absent.
    solids : Triangles [m] of each closed object.
    bounds_m : (2, 3) float64 — Least and greatest corner [m]; zeros without any body.
    has_room : Whether there is a room to be inside of.
    facet_part : (f,) int64 — Closed part of each facet: a solid's number, ``len(solids)`` for the
        closed room, -1 for a sheet.
    triangle_part : (t,) int64 — The same by triangle, as ``facets.triangle_facet`` counts them.
    facet_outer_side : (f,) int64 — +1: the plane's normal points out of that part, -1: into it, 0:
        a sheet.
    floor_m : Height of the floor [m]; None: that of the lowest point.
    """

    bodies: tuple[Body, ...]
    material_names: tuple[str, ...]
    facets: Facets
    triangle_corners_m: FloatArray
    triangle_facet: IntArray
    facet_front: npt.NDArray[np.bool_]
    supporting_side: IntArray
    bvh: BvhArrays
    inner_bvh: BvhArrays
    shell_corners_m: FloatArray
    solids: tuple[FloatArray, ...]
    bounds_m: FloatArray
    has_room: bool
    triangle_part: IntArray
    facet_part: IntArray
    facet_outer_side: IntArray
    floor_m: float | None = None
    _solid_bounds_m: tuple[tuple[FloatArray, FloatArray], ...] = field(
        init=False, repr=False, compare=False
    )

    def __post_init__(self) -> None:
        bounds = frozen_array(self.bounds_m, name="bounds_m", shape=(2, 3))
        object.__setattr__(self, "bounds_m", bounds)
        boxes = tuple((s.min(axis=(0, 1)), s.max(axis=(0, 1))) for s in self.solids)
        object.__setattr__(self, "_solid_bounds_m", boxes)
        f, t = len(self.facets.facet_plane), len(self.facets.triangle_facet)
        for name, size in (("triangle_part", t), ("facet_part", f), ("facet_outer_side", f)):
            value = frozen_array(getattr(self, name), name=name, shape=(size,), dtype=np.int64)
            object.__setattr__(self, name, value)

    @property
    def extent_m(self) -> float:
        """Diagonal of the bounds [m]; 1 m for an empty scene."""
        return _extent_m(self.bounds_m)

    @property
    def tolerance_m(self) -> float:
        """Distance [m] within which a point counts as lying on a facet."""
        return LENGTHS.facet_per_extent * self.extent_m

    @property
    def floor_height_m(self) -> float:
        """Height of the floor [m]: as given, or of the lowest point; 0 for an empty scene."""
        return float(self.bounds_m[0, 2]) if self.floor_m is None else self.floor_m

    def inside_solid(self, points_m: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return (n,) bool, whether each point lies inside a closed object [-].

        Parameters
        ----------
        points_m : (n, 3) float64 — Points [m].
        """
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 3)
        inside = np.zeros(len(points), dtype=np.bool_)
        axis = int(np.argmax(np.ptp(points, axis=0))) if len(points) else 0
        order = np.argsort(points[:, axis], kind="stable")
        places = points[order, axis]
        for corners, (low, high) in zip(self.solids, self._solid_bounds_m, strict=True):
            near = order[slice(*np.searchsorted(places, (low[axis], high[axis])))]
            near = near[((points[near] > low) & (points[near] < high)).all(axis=1)]
            inside[near] |= np.abs(winding_numbers(points[near], corners)) > 0.5
        return inside

    def inside_room(self, points_m: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return (n,) bool, whether each point lies in the room [-], objects or not.

        Exact for a closed room. In an open one (a doorway, no ceiling) a point within the bounds
        counts if it has floor below or ceiling above; without a room every point does.

        Parameters
        ----------
        points_m : (n, 3) float64 — Points [m].
        """
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 3)
        if not self.has_room:
            return np.ones(len(points), dtype=np.bool_)
        slack = self.tolerance_m
        within = (points >= self.bounds_m[0] - slack) & (points <= self.bounds_m[1] + slack)
        inside: npt.NDArray[np.bool_] = within.all(axis=1)
        if len(self.shell_corners_m):
            chosen = np.flatnonzero(inside)
            winding = winding_numbers(points[chosen], self.shell_corners_m)
            inside[chosen] = np.abs(winding) > 0.25  # one half on a wall itself
        else:
            chosen = np.flatnonzero(inside)
            below, above = points[chosen].copy(), points[chosen].copy()
            below[:, 2], above[:, 2] = self.bounds_m[0, 2] - 1.0, self.bounds_m[1, 2] + 1.0
            covered = segments_blocked(self.bvh, points[chosen], below)
            inside[chosen] = covered | segments_blocked(self.bvh, points[chosen], above)
        return inside

    def distance_to_facets_m(
        self, points_m: npt.ArrayLike, *, within_m: float = math.inf
    ) -> tuple[FloatArray, IntArray]:
        """Return (n,) distances [m] to the nearest facet, infinity without one, and planes, -1 [-].

        Only facets onto which a point projects perpendicularly count.

        Parameters
        ----------
        points_m : (n, 3) float64 — Points [m].
        within_m : Distance [m] beyond which no facet is looked for; small is quick in dense meshes.
        """
        points = np.ascontiguousarray(points_m, dtype=np.float64).reshape(-1, 3)
        nearest = np.full(len(points), float(within_m))
        plane_of = np.full(len(points), -1, dtype=np.int64)
        _scene_kernels.nearest_facets(
            read_only(points),
            *self._walls(),
            self.tolerance_m,
            nearest,
            plane_of,
        )
        return nearest, plane_of

    def stand_off(
        self, points_m: npt.ArrayLike, standoff_m: float
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Return points [m] moved off the walls they are mounted on, and which of them moved.

        Along a facet's normal, into the room or off the solid; in a corner off every facet.

        Parameters
        ----------
        points_m : (n, 3) float64 — Points [m].
        standoff_m : Distance [m] to keep, > 0.
        """
        points = np.array(points_m, dtype=np.float64).reshape(-1, 3)
        slack = LENGTHS.plane_per_extent * self.extent_m
        moved: npt.NDArray[np.bool_] = np.isfinite(
            self.distance_to_facets_m(points, within_m=slack)[0]
        )
        for i in np.flatnonzero(moved):
            normals = self.facets.plane_normal[self._planes_at(points[i], slack)]
            signs = np.array(list(itertools.product((1.0, -1.0), repeat=len(normals))))
            places = points[i] + standoff_m * signs @ normals
            free = self.inside_room(places) & ~self.inside_solid(places)
            free &= np.isinf(self.distance_to_facets_m(places, within_m=slack)[0])
            points[i] = places[int(np.argmax(free))]
        return points, moved

    def _planes_at(self, point_m: FloatArray, slack_m: float) -> IntArray:
        """Return the planes of all facets that a point lies on, a few of them at an apex."""
        found = np.zeros(len(self.facets.plane_normal), dtype=np.bool_)
        _scene_kernels.planes_at(
            read_only(np.ascontiguousarray(point_m)),
            *self._walls(),
            slack_m,
            found,
        )
        planes = np.flatnonzero(found)
        return planes[:: -(-len(planes) // MOST_PLANES)] if len(planes) else planes

    def _walls(self) -> tuple[FloatArray, IntArray, FloatArray, IntArray, FloatArray, FloatArray]:
        """Return boxes, links, triangles and planes of the hierarchy; normals and offsets [m]."""
        boxes, links, triangles, planes, _ = self.bvh
        facets = self.facets
        return read_only(
            (boxes, links, triangles, planes, facets.plane_normal, facets.plane_offset_m)
        )


def _extent_m(bounds_m: FloatArray) -> float:
    extent = float(np.linalg.norm(bounds_m[1] - bounds_m[0]))
    return extent if extent > 0.0 else 1.0


def free_space_scene() -> Scene:
    """Return the scene without anything in it: every path is the line of sight."""
    return build_scene(())


def build_scene(
    bodies: Sequence[Body],
    *,
    objects: Sequence[Body] = (),
    coordinate_bits: int = FLOAT32_BITS,
    floor_m: float | None = None,
) -> Scene:
    """Return the scene made of a room and the objects in it; no body at all gives free space.

    Parameters
    ----------
    bodies : The room. Closed parts inside the outermost are solids; the outermost, when closed, is
        the shell that antennas must be inside of.
    objects : Furniture; the closed ones are solids.
    coordinate_bits : Significant bits of coordinates, 1 to 53, whose rounding does not keep
        triangles out of one plane: 24 (float32) suits files; with 53 a wall made uneven by float32
        becomes many planes.
    floor_m : Height of the floor [m]; None: that of the lowest point.
    """
    if not 1 <= coordinate_bits <= 53:
        msg = f"coordinate_bits = {coordinate_bits} is not a number of bits from 1 to 53."
        raise GeometryError(msg)
    everything = (*bodies, *objects)
    names = tuple(dict.fromkeys(body.material for body in everything))
    if not everything:
        vertices, faces, stored = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), np.zeros(0)
        bounds = np.zeros((2, 3))
    else:
        vertices, faces = _concatenated(everything)
        stored = np.repeat(
            [b.rounding_m for b in everything], [len(b.vertices_m) for b in everything]
        )
        bounds = triangle_bounds_m(vertices, faces)
    extent = _extent_m(bounds)
    sizes = [len(body.faces) for body in everything]
    material = np.repeat([names.index(b.material) for b in everything], sizes).astype(np.int64)
    room_faces = sum(sizes[: len(bodies)])
    if everything:
        faces = weld(vertices, LENGTHS.weld_per_extent * extent)[faces]
        kept = distinct_triangles(faces, material, room_faces)
        faces, material = faces[kept], material[kept]
        room_faces = int(np.searchsorted(kept, room_faces))
        places, faces = np.unique(faces, return_inverse=True)
        vertices, faces, stored = vertices[places], faces.reshape(-1, 3), stored[places]
    tolerance = LENGTHS.plane_per_extent * extent
    rounding = rounding_m(
        vertices,
        coordinate_bits=coordinate_bits,
        extent_m=extent,
        stored_m=stored if coordinate_bits <= FLOAT32_BITS else 0.0,
    )
    facets = build_facets(vertices, faces, material, tolerance_m=tolerance, rounding_m=rounding)
    if everything and len(facets.facet_plane) == 0:
        msg = (
            f"none of the {sum(sizes)} triangles has an area; check the mesh and its unit with "
            "octant audit."
        )
        raise GeometryError(msg)
    parts = find_closed_parts(
        vertices,
        faces,
        has_area=facets.triangle_facet >= 0,
        room_faces=room_faces,
        tolerance_m=tolerance,
    )
    part, outer = facet_sides(vertices, faces, facets, parts, extent_m=extent)
    side = _supporting_sides(vertices, facets, tolerance)
    used = facets.triangle_facet >= 0
    plane_of = facets.facet_plane[facets.triangle_facet[used]]
    corners = vertices[faces[used]]
    inner = side[plane_of] == 0
    return Scene(
        bodies=everything,
        material_names=names,
        facets=facets,
        triangle_corners_m=corners,
        triangle_facet=facets.triangle_facet[used],
        facet_front=_facet_fronts(facets, corners, facets.triangle_facet[used]),
        supporting_side=side,
        bvh=build_bvh(corners, plane_of, extent_m=extent),
        inner_bvh=build_bvh(corners[inner], plane_of[inner], extent_m=extent),
        shell_corners_m=parts.shell_corners_m,
        solids=parts.solids,
        bounds_m=bounds,
        has_room=len(bodies) > 0,
        triangle_part=parts.part_of_triangle,
        facet_part=part,
        facet_outer_side=outer,
        floor_m=floor_m,
    )


def _facet_fronts(facets: Facets, corners_m: FloatArray, facet: IntArray) -> npt.NDArray[np.bool_]:
    """Return (f,) bool, whether the triangles of each facet mostly turn as its plane's normal."""
    area = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
    along = np.sum(area * facets.plane_normal[facets.facet_plane[facet]], axis=1)
    total = np.bincount(facet, weights=along, minlength=len(facets.facet_plane))
    front: npt.NDArray[np.bool_] = total >= 0.0
    return front


def _concatenated(bodies: Sequence[Body]) -> tuple[FloatArray, IntArray]:
    offsets = np.cumsum([0] + [len(body.vertices_m) for body in bodies])
    vertices = np.concatenate([body.vertices_m for body in bodies])
    faces = np.concatenate([b.faces + n for b, n in zip(bodies, offsets, strict=False)])
    return vertices, faces.astype(np.int64)


def _supporting_sides(vertices_m: FloatArray, facets: Facets, tolerance_m: float) -> IntArray:
    """Return the side of each plane that the whole scene lies on, 0 when it is on both."""
    sides = np.zeros(len(facets.plane_normal), dtype=np.int64)
    # Corners that lie far out in some direction settle most planes at once.
    extremes = np.argmax(vertices_m @ _DIRECTIONS.T, axis=0) if len(vertices_m) else []
    points = np.concatenate((vertices_m[extremes], vertices_m))
    _scene_kernels.supporting_sides(
        *read_only((points, facets.plane_normal, facets.plane_offset_m)), tolerance_m, sides
    )
    sides.setflags(write=False)
    return sides


_DIRECTIONS = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
"""Directions [-] in which the outermost corners of a scene are looked for."""
