"""The immutable scene: bodies reduced to planes, facets and a hierarchy for occlusion."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries._bvh_kernels import BvhArrays
from octant.geometries._plane_geometry import FloatArray, IntArray, connected_labels, weld
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.facets import Facets, build_facets
from octant.geometries.occlusion import build_bvh, segments_blocked, winding_numbers

PLANE_TOLERANCE_PER_EXTENT = 1e-6
"""Coplanarity tolerance [-] per extent of the scene: ten times what float32 mesh files round off,
a thousandth of a degree of phase per metre at 2.4 GHz."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A room and its objects as the rays see them.

    Both sides of every facet reflect. Facets are sheets unless they belong to a closed solid.

    Parameters
    ----------
    bodies : tuple of Body
        Everything that the scene was built from, in order.
    material_names : tuple of str
        Labels that ``facets.facet_material`` counts [-].
    facets : Facets
        Planes and polygons.
    triangle_corners_m : (t, 3, 3) float64
        Corners [m] of the triangles that have an area.
    triangle_facet : (t,) int64
        Facet of each of them [-].
    facet_front : (f,) bool
        Whether the outward side of each facet's triangles, by the order of their corners, is the
        one that its plane's normal points to [-].
    supporting_side : (p,) int64
        +1 or -1 [-] when the whole scene lies on that side of the plane (the side that the normal
        points to, or the other), 0 when the plane cuts through the scene.
    bvh : BvhArrays
        Hierarchy over all triangles.
    inner_bvh : BvhArrays
        Hierarchy without the triangles of supporting planes: between two points on the inner side
        of those planes they can block nothing.
    shell_corners_m : (s, 3, 3) float64
        Triangles [m] of the closed room, none when the room is open or absent.
    solids : tuple of (t, 3, 3) float64
        Triangles [m] of each closed object.
    bounds_m : (2, 3) float64
        Least and greatest corner [m]; zeros without any body.
    has_room : bool
        Whether there is a room to be inside of [-].
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

    def __post_init__(self) -> None:
        bounds = frozen_array(self.bounds_m, name="bounds_m", shape=(2, 3))
        object.__setattr__(self, "bounds_m", bounds)

    @property
    def extent_m(self) -> float:
        """Diagonal of the bounds [m]; 1 m for an empty scene."""
        return _extent_m(self.bounds_m)

    @property
    def tolerance_m(self) -> float:
        """Distance [m] within which a point counts as lying on a facet."""
        return 1e-9 * self.extent_m

    @property
    def floor_height_m(self) -> float:
        """Height of the lowest point [m]; 0 for an empty scene."""
        return float(self.bounds_m[0, 2])

    def inside_solid(self, points_m: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return (n,) bool, whether each point lies inside a closed object [-].

        Parameters
        ----------
        points_m : (n, 3) float64
            Points [m].
        """
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 3)
        inside = np.zeros(len(points), dtype=np.bool_)
        for corners in self.solids:
            low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
            near = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
            inside[near] |= np.abs(winding_numbers(points[near], corners)) > 0.5
        return inside

    def inside_room(self, points_m: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return (n,) bool, whether each point lies in the room [-], objects or not.

        A closed room is asked exactly. An open one (a doorway, a missing ceiling) has no inside in
        the strict sense: there a point within the bounds that has floor below it or ceiling above
        it counts. Without a room every point is inside.

        Parameters
        ----------
        points_m : (n, 3) float64
            Points [m].
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

    def distance_to_facets_m(self, points_m: npt.ArrayLike) -> tuple[FloatArray, IntArray]:
        """Return (n,) distances [m] of points to the nearest facet below them, and its plane [-].

        Only facets onto which a point projects perpendicularly count.

        Parameters
        ----------
        points_m : (n, 3) float64
            Points [m].

        Returns
        -------
        (n,) float64
            Distance [m]; infinity when no facet lies perpendicularly below the point.
        (n,) int64
            Plane [-]; -1 when there is none.
        """
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 3)
        nearest = np.full(len(points), np.inf)
        plane_of = np.full(len(points), -1, dtype=np.int64)
        f = self.facets
        for facet, plane in enumerate(f.facet_plane):
            distance = np.abs(points @ f.plane_normal[plane] - f.plane_offset_m[plane])
            close = np.flatnonzero(distance < nearest)
            uv = np.stack((points[close] @ f.plane_u[plane], points[close] @ f.plane_v[plane]), -1)
            hit = close[_winds_around(f, facet, uv, self.tolerance_m)]
            nearest[hit], plane_of[hit] = distance[hit], plane
        return nearest, plane_of

    def stand_off(
        self, points_m: npt.ArrayLike, standoff_m: float
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Return points moved off the walls they are mounted on, and which of them moved.

        A point on a facet is moved along its normal by the stand-off, into the room (or away from
        the solid); in a corner it leaves every facet that it lies on.

        Parameters
        ----------
        points_m : (n, 3) float64
            Points [m].
        standoff_m : float
            Distance [m] to keep, > 0.

        Returns
        -------
        (n, 3) float64
            Points [m].
        (n,) bool
            Whether each point was moved [-].
        """
        points = np.array(points_m, dtype=np.float64).reshape(-1, 3)
        slack = PLANE_TOLERANCE_PER_EXTENT * self.extent_m
        moved: npt.NDArray[np.bool_] = self.distance_to_facets_m(points)[0] <= slack
        for i in np.flatnonzero(moved):
            normals = self.facets.plane_normal[self._planes_at(points[i], slack)]
            signs = np.array(list(itertools.product((1.0, -1.0), repeat=len(normals))))
            places = points[i] + standoff_m * signs @ normals
            free = self.inside_room(places) & ~self.inside_solid(places)
            free &= self.distance_to_facets_m(places)[0] > slack
            points[i] = places[int(np.argmax(free))]
        return points, moved

    def _planes_at(self, point_m: FloatArray, slack_m: float) -> list[int]:
        """Return the planes of all facets that a point lies on [-]."""
        f = self.facets
        planes = []
        for facet, plane in enumerate(f.facet_plane):
            if abs(float(point_m @ f.plane_normal[plane]) - f.plane_offset_m[plane]) <= slack_m:
                uv = np.array([[point_m @ f.plane_u[plane], point_m @ f.plane_v[plane]]])
                if _winds_around(f, facet, uv, slack_m)[0] and int(plane) not in planes:
                    planes.append(int(plane))
        return planes


def _extent_m(bounds_m: FloatArray) -> float:
    extent = float(np.linalg.norm(bounds_m[1] - bounds_m[0]))
    return extent if extent > 0.0 else 1.0


def _winds_around(
    facets: Facets, facet: int, uv_m: FloatArray, tolerance_m: float
) -> npt.NDArray[np.bool_]:
    """Return (n,) bool, whether points (n, 2) [m] of a facet's plane lie in it, rim included."""
    edges = facets.outline_m[facets.outline_start[facet] : facets.outline_start[facet + 1]]
    u, v = uv_m[:, None, 0], uv_m[:, None, 1]
    u0, v0, u1, v1 = edges.T
    side = (u1 - u0) * (v - v0) - (u - u0) * (v1 - v0)
    up, down = (v0 <= v) & (v1 > v), (v0 > v) & (v1 <= v)
    winding = (up & (side > 0)).sum(axis=1) - (down & (side < 0)).sum(axis=1)
    length = np.hypot(u1 - u0, v1 - v0)
    along = ((u - u0) * (u1 - u0) + (v - v0) * (v1 - v0)) / length
    clipped = np.clip(along, 0.0, length)
    aside = np.hypot(u - u0 - clipped * (u1 - u0) / length, v - v0 - clipped * (v1 - v0) / length)
    inside: npt.NDArray[np.bool_] = (aside <= tolerance_m).any(axis=1) | (winding != 0)
    return inside


def free_space_scene() -> Scene:
    """Return the scene without anything in it: every path is the line of sight."""
    return build_scene(())


def build_scene(bodies: Sequence[Body], *, objects: Sequence[Body] = ()) -> Scene:
    """Return the scene made of a room and the objects in it.

    Parameters
    ----------
    bodies : sequence of Body
        The room. Its closed parts inside the outermost one are solids; the outermost, when closed,
        is the shell that antennas must be inside of.
    objects : sequence of Body
        Furniture; the closed ones are solids.

    Returns
    -------
    Scene
        Immutable; no body at all gives free space.

    Raises
    ------
    GeometryError
        If there are bodies but no triangle with an area.
    """
    everything = (*bodies, *objects)
    names = tuple(dict.fromkeys(body.material for body in everything))
    if not everything:
        vertices, faces = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        bounds = np.zeros((2, 3))
    else:
        vertices, faces = _concatenated(everything)
        bounds = np.stack((vertices.min(axis=0), vertices.max(axis=0)))
    extent = _extent_m(bounds)
    sizes = [len(body.faces) for body in everything]
    material = np.repeat([names.index(b.material) for b in everything], sizes).astype(np.int64)
    room_faces = sum(sizes[: len(bodies)])
    if everything:
        faces = weld(vertices, 1e-7 * extent)[faces]
        # A triangle given twice is one; whose room or object it is stays apart.
        of_room = np.arange(len(faces)) < room_faces
        keys = np.column_stack((np.sort(faces, axis=1), material, of_room))
        kept = np.sort(np.unique(keys, axis=0, return_index=True)[1])
        faces, material = faces[kept], material[kept]
        room_faces = int(np.searchsorted(kept, room_faces))
    tolerance = PLANE_TOLERANCE_PER_EXTENT * extent
    facets = build_facets(vertices, faces, material, tolerance_m=tolerance)
    if everything and len(facets.facet_plane) == 0:
        msg = (
            f"none of the {len(faces)} triangles has an area; check the mesh and its unit with "
            "octant audit."
        )
        raise GeometryError(msg)
    shell, solids = _closed_parts(vertices, faces, room_faces=room_faces)
    side = _supporting_sides(vertices[np.unique(faces)], facets, tolerance)
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
        shell_corners_m=shell,
        solids=solids,
        bounds_m=bounds,
        has_room=len(bodies) > 0,
    )


def _facet_fronts(
    facets: Facets, corners_m: FloatArray, facet: IntArray
) -> npt.NDArray[np.bool_]:
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
    sides = np.zeros(len(facets.plane_normal), dtype=np.int64)
    for i, (normal, offset) in enumerate(
        zip(facets.plane_normal, facets.plane_offset_m, strict=True)
    ):
        height = vertices_m @ normal - offset
        if height.min() >= -tolerance_m:
            sides[i] = 1
        elif height.max() <= tolerance_m:
            sides[i] = -1
    sides.setflags(write=False)
    return sides


def _closed_parts(
    vertices_m: FloatArray, faces: IntArray, *, room_faces: int
) -> tuple[FloatArray, tuple[FloatArray, ...]]:
    """Return the triangles of the closed room, and of each closed solid.

    Parts are joined over shared edges; a part is closed when each of its edges belongs to exactly
    two triangles.
    """
    none = np.zeros((0, 3, 3))
    if len(faces) == 0:
        return none, ()
    edges = np.sort(np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])), axis=1)
    in_room = np.tile(np.arange(len(faces)) < room_faces, 3)
    keyed = np.column_stack((edges, in_room))
    _, edge_of, times = np.unique(keyed, axis=0, return_inverse=True, return_counts=True)
    edge_of = edge_of.reshape(-1)
    triangle_of = np.tile(np.arange(len(faces)), 3)
    order = np.argsort(edge_of, kind="stable")
    same = edge_of[order][1:] == edge_of[order][:-1]
    pairs = np.column_stack((triangle_of[order][:-1][same], triangle_of[order][1:][same]))
    part = connected_labels(len(faces), pairs)
    open_parts = np.unique(part[triangle_of[times[edge_of] != 2]])
    parts = [
        (vertices_m[faces[part == label]], bool(np.flatnonzero(part == label)[0] < room_faces))
        for label in np.setdiff1d(np.unique(part), open_parts)
    ]
    room_vertices = vertices_m[np.unique(faces[:room_faces])] if room_faces else None
    shell, solids = none, []
    for corners, of_room in parts:
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        outermost = (
            of_room
            and room_vertices is not None
            and bool((room_vertices >= low).all() and (room_vertices <= high).all())
        )
        if outermost and len(shell) == 0:
            shell = corners
        else:
            solids.append(corners)
    return shell, tuple(solids)
