"""Facets: maximal coplanar connected polygons of one material, whatever mesh they came from.

Triangles are only the way a surface was written down. Rays see facets, so that remeshing a wall,
a T-junction between unevenly meshed panels or a doubled triangle never changes a path.

The stages are: weld vertices by position, gather triangles into planes, split each plane by
material and connection, and reduce every piece to its directed outline. A point belongs to a facet
when the outline winds around it or passes within the tolerance.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import (
    FloatArray,
    IntArray,
    connected_labels,
    plane_basis,
    triangle_area_vectors,
)

SLIVER_ASPECT = 1e-4
"""Height over longest side [-] below which a triangle's own normal is not trusted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Facets:
    """Planes and the flat polygons that lie in them, as arrays ready for the kernels.

    Parameters
    ----------
    plane_normal : (p, 3) float64
        Unit normal of each plane [-].
    plane_offset_m : (p,) float64
        Plane equation: normal . x = offset [m].
    plane_u, plane_v : (p, 3) float64
        Orthonormal axes [-] within each plane; u runs along the plane's longest outline edge.
    plane_facet_start : (p + 1,) int64
        Facets of plane k are ``plane_facet_start[k]`` up to ``plane_facet_start[k + 1]`` [-].
    facet_plane : (f,) int64
        Plane of each facet [-], ascending.
    facet_material : (f,) int64
        Index of the material label [-].
    facet_bounds_m : (f, 4) float64
        Least u, least v, greatest u, greatest v [m] in the plane's axes.
    facet_is_rectangle : (f,) bool
        Whether the facet fills its bounds [-], so that the bounds alone decide containment.
    outline_start : (f + 1,) int64
        Outline edges of facet i are ``outline_start[i]`` up to ``outline_start[i + 1]`` [-].
    outline_m : (e, 4) float64
        Directed edges u0, v0, u1, v1 [m]; the facet lies to their left.
    triangle_facet : (t,) int64
        Facet of each input triangle [-]; -1 for a triangle without area.
    """

    plane_normal: FloatArray
    plane_offset_m: FloatArray
    plane_u: FloatArray
    plane_v: FloatArray
    plane_facet_start: IntArray
    facet_plane: IntArray
    facet_material: IntArray
    facet_bounds_m: FloatArray
    facet_is_rectangle: npt.NDArray[np.bool_]
    outline_start: IntArray
    outline_m: FloatArray
    triangle_facet: IntArray

    def __post_init__(self) -> None:
        p, f, e = len(self.plane_normal), len(self.facet_plane), len(self.outline_m)
        shapes: dict[str, tuple[tuple[int | None, ...], type]] = {
            "plane_normal": ((p, 3), np.float64),
            "plane_offset_m": ((p,), np.float64),
            "plane_u": ((p, 3), np.float64),
            "plane_v": ((p, 3), np.float64),
            "plane_facet_start": ((p + 1,), np.int64),
            "facet_plane": ((f,), np.int64),
            "facet_material": ((f,), np.int64),
            "facet_bounds_m": ((f, 4), np.float64),
            "facet_is_rectangle": ((f,), np.bool_),
            "outline_start": ((f + 1,), np.int64),
            "outline_m": ((e, 4), np.float64),
            "triangle_facet": ((None,), np.int64),
        }
        for name, (shape, dtype) in shapes.items():
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    def outline_room_m(self, facet: int) -> FloatArray:
        """Return the (k, 2, 3) end points [m] of a facet's outline edges, in the room's frame.

        Parameters
        ----------
        facet : int
            Index of the facet [-].

        Returns
        -------
        (k, 2, 3) float64
            Start and end of each directed edge [m].
        """
        plane = self.facet_plane[facet]
        uv = self.outline_m[self.outline_start[facet] : self.outline_start[facet + 1]]
        origin = self.plane_normal[plane] * self.plane_offset_m[plane]
        ends = uv.reshape(-1, 2, 2)
        room: FloatArray = (
            origin + ends[..., :1] * self.plane_u[plane] + ends[..., 1:] * self.plane_v[plane]
        )
        return room

    def area_m2(self, facet: int) -> float:
        """Return the area [m^2] that a facet's outline encloses.

        Parameters
        ----------
        facet : int
            Index of the facet [-].
        """
        uv = self.outline_m[self.outline_start[facet] : self.outline_start[facet + 1]]
        return float(0.5 * np.sum(uv[:, 0] * uv[:, 3] - uv[:, 2] * uv[:, 1]))


def group_planes(vertices_m: FloatArray, faces: IntArray, tolerance_m: float) -> IntArray:
    """Return the (t,) plane label [-] of each triangle, -1 for triangles without area.

    The largest triangle not yet placed opens a plane; every triangle of like direction whose three
    corners lie within the tolerance joins it.

    Parameters
    ----------
    vertices_m : (n, 3) float64
        Vertices [m].
    faces : (t, 3) int64
        Triangles as vertex indices [-].
    tolerance_m : float
        Greatest distance [m] of a corner from the plane.
    """
    from scipy.spatial import cKDTree

    area = triangle_area_vectors(vertices_m, faces)
    size = np.linalg.norm(area, axis=1)
    corners = vertices_m[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    flat = size > 0.5 * tolerance_m * longest
    label = np.full(len(faces), -1, dtype=np.int64)
    if not flat.any():
        return label
    normal = np.divide(area, size[:, None], out=np.zeros_like(area), where=size[:, None] > 0)
    sliver = 2 * size < SLIVER_ASPECT * longest**2
    trusted = np.flatnonzero(flat & ~sliver)
    untrusted = np.flatnonzero(flat & sliver)
    tree = cKDTree(np.vstack((normal[trusted], -normal[trusted]))) if len(trusted) else None
    count = 0
    for seed in sorted(np.flatnonzero(flat), key=lambda i: (-size[i], i)):
        if label[seed] >= 0:
            continue
        near = untrusted
        if tree is not None:
            found = np.asarray(tree.query_ball_point(normal[seed], 0.02), dtype=np.int64)
            near = np.concatenate((trusted[found % len(trusted)], untrusted))
        near = near[label[near] < 0]
        distance = np.abs((corners[near] - corners[seed, 0]) @ normal[seed]).max(axis=1)
        label[near[distance <= tolerance_m]] = count
        label[seed] = count
        count += 1
    return label


def build_facets(
    vertices_m: FloatArray,
    faces: IntArray,
    material: IntArray,
    *,
    tolerance_m: float,
) -> Facets:
    """Return the facets of a welded triangle mesh.

    Parameters
    ----------
    vertices_m : (n, 3) float64
        Vertices [m].
    faces : (t, 3) int64
        Triangles as indices of welded vertices [-].
    material : (t,) int64
        Material index of each triangle [-].
    tolerance_m : float
        Coplanarity and T-junction tolerance [m].

    Returns
    -------
    Facets
        Ordered by plane, material and first triangle, so that the order of the mesh decides ties.
    """
    plane_of = group_planes(vertices_m, faces, tolerance_m)
    builder = _FacetBuilder(vertices_m, faces, material, tolerance_m)
    for plane in range(int(plane_of.max(initial=-1)) + 1):
        builder.add_plane(np.flatnonzero(plane_of == plane))
    return builder.finish()


class _FacetBuilder:
    """Collects planes and their facets one after the other."""

    def __init__(
        self, vertices_m: FloatArray, faces: IntArray, material: IntArray, tolerance_m: float
    ) -> None:
        self.vertices_m, self.faces, self.material = vertices_m, faces, material
        self.tolerance_m = tolerance_m
        self.planes: list[tuple[FloatArray, float, FloatArray, FloatArray]] = []
        self.plane_facet_start = [0]
        self.facet_plane: list[int] = []
        self.facet_material: list[int] = []
        self.outlines: list[FloatArray] = []
        self.triangle_facet = np.full(len(faces), -1, dtype=np.int64)

    def add_plane(self, triangles: IntArray) -> None:
        """Add one plane with all the facets that its triangles make."""
        area = triangle_area_vectors(self.vertices_m, self.faces[triangles])
        largest = area[np.argmax(np.linalg.norm(area, axis=1))]
        same_side = np.sign(area @ largest)
        total = (area * same_side[:, None]).sum(axis=0)
        normal = total / np.linalg.norm(total)
        # -0.0 would print as such and compare oddly; + 0.0 turns it into 0.0.
        normal = np.where(np.abs(normal) < 1e-15, 0.0, normal) + 0.0
        offset = float(np.median(self.vertices_m[self.faces[triangles]] @ normal))
        pieces: list[tuple[int, list[tuple[int, int]], IntArray]] = []
        for material in np.unique(self.material[triangles]):
            chosen = self.material[triangles] == material
            turned = np.where(
                (same_side[chosen] < 0)[:, None],
                self.faces[triangles[chosen]][:, ::-1],
                self.faces[triangles[chosen]],
            )
            pieces += [
                (int(material), edges, triangles[chosen][members])
                for edges, members in _outlines(self.vertices_m, turned, self.tolerance_m)
            ]
        ends = np.array([edge for _, edges, _ in pieces for edge in edges], dtype=np.int64)
        if len(ends) == 0:  # two triangles back to back cancel out: nothing is left to hit
            return
        span = self.vertices_m[ends[:, 1]] - self.vertices_m[ends[:, 0]]
        u, v = plane_basis(normal, span[np.argmax(np.linalg.norm(span, axis=1))])
        plane = len(self.planes)
        self.planes.append((normal, offset, u, v))
        for kind, edges, members in pieces:
            if not edges:
                continue
            corners = self.vertices_m[np.array(edges)]
            self.triangle_facet[members] = len(self.facet_plane)
            self.facet_plane.append(plane)
            self.facet_material.append(kind)
            uv = np.stack((corners @ u, corners @ v), axis=-1)
            self.outlines.append(uv.reshape(-1, 4))
        self.plane_facet_start.append(len(self.facet_plane))

    def finish(self) -> Facets:
        """Return what was collected."""
        starts = np.concatenate(([0], np.cumsum([len(o) for o in self.outlines], dtype=np.int64)))
        corners = [outline.reshape(-1, 2) for outline in self.outlines]
        bounds = [np.concatenate((c.min(axis=0), c.max(axis=0))) for c in corners]
        area = [0.5 * np.sum(o[:, 0] * o[:, 3] - o[:, 2] * o[:, 1]) for o in self.outlines]
        rectangle = [
            len(o) == 4 and abs(a - (b[2] - b[0]) * (b[3] - b[1])) <= 1e-12 * (1.0 + abs(a))
            for o, a, b in zip(self.outlines, area, bounds, strict=True)
        ]
        return Facets(
            plane_normal=np.array([p[0] for p in self.planes]).reshape(-1, 3),
            plane_offset_m=np.array([p[1] for p in self.planes], dtype=np.float64),
            plane_u=np.array([p[2] for p in self.planes]).reshape(-1, 3),
            plane_v=np.array([p[3] for p in self.planes]).reshape(-1, 3),
            plane_facet_start=np.array(self.plane_facet_start, dtype=np.int64),
            facet_plane=np.array(self.facet_plane, dtype=np.int64),
            facet_material=np.array(self.facet_material, dtype=np.int64),
            facet_bounds_m=np.array(bounds).reshape(-1, 4),
            facet_is_rectangle=np.array(rectangle, dtype=np.bool_),
            outline_start=starts.astype(np.int64),
            outline_m=np.concatenate(self.outlines) if self.outlines else np.zeros((0, 4)),
            triangle_facet=self.triangle_facet,
        )


def _outlines(
    vertices_m: FloatArray, faces: IntArray, tolerance_m: float
) -> list[tuple[list[tuple[int, int]], IntArray]]:
    """Return, per connected piece, its directed outline edges and the triangles it is made of.

    Directed edges that run in opposite senses cancel. Where a corner of one triangle stands on the
    side of another (a T-junction) the side is split there first, so that seams cancel as well.
    """
    if len(faces) == 1:  # every triangle of a curved surface: nothing to cancel or to join
        a, b, c = faces[0].tolist()
        return [([(a, b), (b, c), (c, a)], np.zeros(1, dtype=np.int64))]
    net: dict[tuple[int, int], int] = {}
    for a, b in np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])).tolist():
        _count_edge(net, a, b, 1)
    links = [(a, b) for a, b in faces[:, [0, 1]].tolist()] + faces[:, [1, 2]].tolist()
    split: dict[tuple[int, int], int] = {}
    corners = np.array(sorted({vertex for edge in net for vertex in edge}), dtype=np.int64)
    for (a, b), times in net.items():
        chain = [a, *_corners_on_edge(vertices_m, corners, a, b, tolerance_m), b]
        links += list(pairwise(chain))
        for p, q in pairwise(chain):
            _count_edge(split, p, q, times)
    used, index = np.unique(np.concatenate((faces.ravel(), np.ravel(links))), return_inverse=True)
    label = connected_labels(len(used), index[faces.size :].reshape(-1, 2))
    piece_of_triangle = label[index[: faces.size].reshape(-1, 3)[:, 0]]
    place = {int(vertex): int(label[i]) for i, vertex in enumerate(used)}
    by_piece: dict[int, list[tuple[int, int]]] = {}
    for (a, b), times in split.items():
        by_piece.setdefault(place[a], []).extend([(a, b)] * times)
    order = dict.fromkeys(piece_of_triangle.tolist())
    return [
        (
            _merge_straight(vertices_m, by_piece.get(piece, []), tolerance_m),
            np.flatnonzero(piece_of_triangle == piece),
        )
        for piece in order
    ]


def _count_edge(net: dict[tuple[int, int], int], a: int, b: int, times: int) -> None:
    """Add a directed edge, cancelling it against its reverse; counts stay positive."""
    for _ in range(times):
        if net.get((b, a), 0) > 0:
            net[b, a] -= 1
            if net[b, a] == 0:
                del net[b, a]
        else:
            net[a, b] = net.get((a, b), 0) + 1


def _corners_on_edge(
    vertices_m: FloatArray, corners: IntArray, a: int, b: int, tolerance_m: float
) -> list[int]:
    """Return those of the outline's corners that stand on the edge between a and b, in order."""
    start, span = vertices_m[a], vertices_m[b] - vertices_m[a]
    length = float(np.linalg.norm(span))
    along = (vertices_m[corners] - start) @ span / length
    aside = np.linalg.norm(vertices_m[corners] - start - along[:, None] * span / length, axis=1)
    on = (aside <= tolerance_m) & (along > tolerance_m) & (along < length - tolerance_m)
    hits = corners[on][np.argsort(along[on])]
    return [int(v) for v in hits]


def _merge_straight(
    vertices_m: FloatArray, edges: list[tuple[int, int]], tolerance_m: float
) -> list[tuple[int, int]]:
    """Return the outline with straight runs of edges joined into single edges."""
    following: dict[int, list[int]] = {}
    leading: dict[int, list[int]] = {}
    for a, b in edges:
        following.setdefault(a, []).append(b)
        leading.setdefault(b, []).append(a)
    for vertex in list(following):
        if len(following[vertex]) != 1 or len(leading.get(vertex, [])) != 1:
            continue
        before, after = leading[vertex][0], following[vertex][0]
        span = vertices_m[after] - vertices_m[before]
        length = float(np.linalg.norm(span))
        if length == 0.0 or before == vertex:
            continue
        offset = vertices_m[vertex] - vertices_m[before]
        along = float(offset @ span) / length
        aside = float(np.linalg.norm(offset - along * span / length))
        if aside <= tolerance_m and 0.0 < along < length:
            following[before][following[before].index(vertex)] = after
            leading[after][leading[after].index(vertex)] = before
            del following[vertex], leading[vertex]
    return [(a, b) for a, ends in following.items() for b in ends]
