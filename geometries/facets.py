"""Facets: maximal coplanar connected polygons of one material, whatever mesh they came from.

Rays see facets, so that remeshing a wall, a T-junction between unevenly meshed panels or a doubled
triangle never changes a path. Vertices are welded by position, triangles gathered into planes,
planes split by material and connection, and pieces reduced to directed outlines. A point belongs to
a facet when the outline winds around it or passes within the tolerance.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries import _outline_kernels
from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import (
    FloatArray,
    IntArray,
    row_numbers,
    triangle_area_vectors,
)
from octant.geometries.overlaps import outer_outlines
from octant.geometries.planes import group_planes


@dataclass(frozen=True, slots=True, kw_only=True)
class Facets:
    """Planes and the flat polygons that lie in them, as arrays ready for the kernels.

    Parameters
    ----------
    plane_normal : (p, 3) float64 — Unit normal of each plane [-].
    plane_offset_m : (p,) float64 — Plane equation: normal . x = offset [m].
    plane_u, plane_v : (p, 3) float64 — Axes [-] in each plane; u along its longest outline edge.
    plane_facet_start : (p + 1,) int64 — Where the facets of each plane start.
    facet_plane : (f,) int64 — Plane of each facet, ascending.
    facet_material : (f,) int64 — Index of the material label.
    facet_bounds_m : (f, 4) float64 — Least u, least v, greatest u, greatest v [m].
    facet_is_rectangle : (f,) bool — Whether the facet fills its bounds, which then suffice [-].
    outline_start : (f + 1,) int64 — Where the outline edges of each facet start.
    outline_m : (e, 4) float64 — Directed edges u0, v0, u1, v1 [m]; the facet lies to their left.
    triangle_facet : (t,) int64 — Facet of each input triangle; -1 for a triangle without area.
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

    def outline_room_m(self, facet: int | None = None) -> FloatArray:
        """Return the (k, 2, 3) start and end [m] of a facet's directed edges, in the room's frame.

        Parameters
        ----------
        facet : Index of the facet; None: all of them, one after the other.
        """
        first, last = (0, len(self.facet_plane)) if facet is None else (facet, facet + 1)
        start = self.outline_start[first : last + 1]
        plane = np.repeat(self.facet_plane[first:last], np.diff(start))
        ends = self.outline_m[start[0] : start[-1]].reshape(-1, 2, 2)
        origin = self.plane_normal[plane] * self.plane_offset_m[plane][:, None]
        along_u = ends[..., :1] * self.plane_u[plane][:, None]
        room: FloatArray = origin[:, None] + along_u + ends[..., 1:] * self.plane_v[plane][:, None]
        return room

    def area_m2(self, facet: int) -> float:
        """Return the area [m^2] that a facet's outline encloses.

        Parameters
        ----------
        facet : Index of the facet.
        """
        uv = self.outline_m[self.outline_start[facet] : self.outline_start[facet + 1]]
        return float(0.5 * np.sum(uv[:, 0] * uv[:, 3] - uv[:, 2] * uv[:, 1]))


def build_facets(
    vertices_m: FloatArray,
    faces: IntArray,
    material: IntArray,
    *,
    tolerance_m: float,
    rounding_m: FloatArray | float | None = None,
) -> Facets:
    """Return the facets of a welded mesh, ordered by plane, material and first triangle.

    Parameters
    ----------
    vertices_m : (n, 3) float64 — Vertices [m].
    faces : (t, 3) int64 — Triangles as indices of welded vertices.
    material : (t,) int64 — Material index of each triangle.
    tolerance_m : T-junction tolerance [m]: how near a corner stands to an edge that it lies on.
    rounding_m : (n,) — How far [m] rounding may have moved vertices; None: the tolerance.
    """
    rounding = tolerance_m if rounding_m is None else rounding_m
    label = group_planes(vertices_m, faces, rounding)
    used = np.flatnonzero(label >= 0)
    normal, offset, turned = _fitted_planes(vertices_m, faces[used], label[used])
    group_of, _, _ = row_numbers(np.column_stack((label, material))[used])
    edge_piece, ends, piece = _outlines(
        vertices_m, turned, group_of, normal[label[used]], tolerance_m
    )
    # Pieces by plane, material and first triangle; those whose edges all cancelled are not facets.
    has_edges = np.zeros(len(used), dtype=np.bool_)
    has_edges[edge_piece] = True
    heads = np.flatnonzero(has_edges)
    heads = heads[np.lexsort((heads, group_of[heads]))]
    facet_of_head = np.full(len(used), -1, dtype=np.int64)
    facet_of_head[heads] = np.arange(len(heads))
    triangle_facet = np.full(len(faces), -1, dtype=np.int64)
    triangle_facet[used] = facet_of_head[piece]
    kept, facet_plane = np.unique(label[used[heads]], return_inverse=True)
    outline_facet = facet_of_head[edge_piece]
    order = np.argsort(outline_facet, kind="stable")
    return _assembled(
        ends_m=ends[order],
        outline_facet=outline_facet[order],
        facet_plane=facet_plane.reshape(-1).astype(np.int64),
        facet_material=material[used[heads]],
        normal=normal[kept],
        offset=offset[kept],
        triangle_facet=triangle_facet,
    )


def _fitted_planes(
    vertices_m: FloatArray, faces: IntArray, label: IntArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the normal and offset [m] of each plane, and the faces wound about its normal."""
    planes = int(label.max(initial=-1)) + 1
    area = triangle_area_vectors(vertices_m, faces)
    by_size = np.lexsort((np.arange(len(faces)), -np.linalg.norm(area, axis=1), label))
    largest = by_size[np.searchsorted(label[by_size], np.arange(planes))]
    same_side = np.sign(np.sum(area * area[largest][label], axis=1))
    total = np.zeros((planes, 3))
    np.add.at(total, label, area * same_side[:, None])
    normal = total / np.linalg.norm(total, axis=1)[:, None]
    # -0.0 would print as such and compare oddly; + 0.0 turns it into 0.0.
    normal = np.where(np.abs(normal) < 1e-15, 0.0, normal) + 0.0
    height = np.einsum("tka,ta->tk", vertices_m[faces], normal[label]).reshape(-1)
    corner_label = np.repeat(label, 3)
    ordered = height[np.lexsort((height, corner_label))]
    size = np.bincount(label, minlength=planes) * 3
    start = np.cumsum(size) - size
    offset = 0.5 * (ordered[start + (size - 1) // 2] + ordered[start + size // 2])
    turned = np.where((same_side < 0)[:, None], faces[:, ::-1], faces)
    return normal, offset, turned


def _outlines(
    vertices_m: FloatArray,
    faces: IntArray,
    group_of: IntArray,
    normals: FloatArray,
    tolerance_m: float,
) -> tuple[IntArray, FloatArray, IntArray]:
    """Return piece and ends (k, 2, 3) [m] of outline edges, and the (t,) piece of each triangle.

    Pieces are the connected parts of a group, by first triangle. Sides are split where other
    corners stand on them (T-junctions); opposite edges cancel. Layers count once.
    """
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    group, start, end = _net_edges(np.repeat(group_of, 3), start, end)
    groups = int(group_of.max(initial=-1)) + 1
    group_start = np.searchsorted(group, np.arange(groups + 1))
    cut = _outline_kernels.split_edges(group_start, start, end, vertices_m, tolerance_m)
    # A vertex counts apart in every group that uses it.
    rows = np.concatenate(
        (
            np.column_stack((np.repeat(group_of, 3), faces.reshape(-1))),
            np.column_stack((np.repeat(group[cut[:, 0]], 2), cut[:, 1:].reshape(-1))),
        )
    )
    number, _, member = row_numbers(rows)
    local_faces = number[: faces.size].reshape(-1, 3)
    local_cut = number[faces.size :].reshape(-1, 2)
    corners = int(number.max(initial=-1)) + 1
    root = _outline_kernels.connected(corners, local_faces, local_cut)
    first_triangle = np.full(corners, len(faces), dtype=np.int64)
    np.minimum.at(first_triangle, root[local_faces[:, 0]], np.arange(len(faces)))
    vertex_of = np.empty(corners, dtype=np.int64)
    vertex_of[number[member]] = rows[member, 1]
    piece, start, end = _net_edges(
        first_triangle[root[local_cut[:, 0]]], local_cut[:, 0], local_cut[:, 1]
    )
    piece, start, end, places = outer_outlines(
        piece, start, end, vertices_m[vertex_of], normal_of_piece=normals, tolerance_m=tolerance_m
    )
    stays = _outline_kernels.merge_straight(start, end, places, tolerance_m)
    ends = np.stack((places[start], places[end]), axis=1)[stays]
    return piece[stays], ends, first_triangle[root[local_faces[:, 0]]]


def _net_edges(
    group: IntArray, start: IntArray, end: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the directed edges (group, start, end) that opposite ones do not cancel, by group."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, first, member = row_numbers(np.column_stack((group, low, high)))
    sign = np.where(start < end, 1, -1)[member]
    net = np.add.reduceat(sign, first[:-1]) if len(member) else np.zeros(0, dtype=np.int64)
    row = np.repeat(member[first[:-1]], np.abs(net))
    forward = np.repeat(net > 0, np.abs(net))
    return (
        group[row],
        np.where(forward, low[row], high[row]),
        np.where(forward, high[row], low[row]),
    )


def _assembled(
    *,
    ends_m: FloatArray,
    outline_facet: IntArray,
    facet_plane: IntArray,
    facet_material: IntArray,
    normal: FloatArray,
    offset: FloatArray,
    triangle_facet: IntArray,
) -> Facets:
    """Return the facets, given the ends (e, 2, 3) [m] of their outline edges by facet."""
    planes, facets = len(normal), len(facet_plane)
    span = ends_m[:, 1] - ends_m[:, 0]
    edge_plane = facet_plane[outline_facet]
    longest = np.lexsort((-np.linalg.norm(span, axis=1), edge_plane))
    longest = longest[np.searchsorted(edge_plane[longest], np.arange(planes))]
    u = span[longest] - normal * np.sum(span[longest] * normal, axis=1)[:, None]
    u = u / np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(normal, u)
    axes = np.stack((u, v), axis=1)[edge_plane]
    uv = np.einsum("eka,eca->ekc", ends_m, axes).reshape(-1, 4)
    outline_start = np.searchsorted(outline_facet, np.arange(facets + 1)).astype(np.int64)
    corners = uv.reshape(-1, 2)
    bounds, area = np.zeros((facets, 4)), np.zeros(facets)
    if facets:
        bounds[:, :2] = np.minimum.reduceat(corners, 2 * outline_start[:-1], axis=0)
        bounds[:, 2:] = np.maximum.reduceat(corners, 2 * outline_start[:-1], axis=0)
        area = 0.5 * np.add.reduceat(uv[:, 0] * uv[:, 3] - uv[:, 2] * uv[:, 1], outline_start[:-1])
    box = (bounds[:, 2] - bounds[:, 0]) * (bounds[:, 3] - bounds[:, 1])
    fills = np.abs(area - box) <= 1e-12 * (1.0 + np.abs(area))
    return Facets(
        plane_normal=normal,
        plane_offset_m=offset,
        plane_u=u,
        plane_v=v,
        plane_facet_start=np.searchsorted(facet_plane, np.arange(planes + 1)).astype(np.int64),
        facet_plane=facet_plane,
        facet_material=facet_material,
        facet_bounds_m=bounds,
        facet_is_rectangle=fills & (np.diff(outline_start) == 4),
        outline_start=outline_start,
        outline_m=uv,
        triangle_facet=triangle_facet,
    )
