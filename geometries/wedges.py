"""Wedges: the sectors of air between the facets that meet along an edge, which diffract.

The rim of a sheet has one of 360 degrees, a cabinet's edge one of 270, a fold of a sheet two, a
junction of k sheets k. Facets that an edge rests on (the floor under a cabinet) bound sectors too.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.edges import Edges, find_edges
from octant.geometries.facets import Facets
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS

ANGLE_TOLERANCE_RAD = 1e-6
"""Angle [rad] within which facets count as coplanar, or a sector as a whole part of 180 degrees."""

PLACES_ON_EDGE = (0.537, 0.463, 0.789, 0.211, 0.943, 0.057)
"""Places [-] along an edge, one of which must be outside solids: where other bodies seldom end."""

PAIRS_PER_CALL = 2_000_000
"""Pairs of edge and plane [-] whose distances are held in memory at a time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wedges:
    """Sectors of air along straight edges, each between a face 0 and a face n.

    Parameters
    ----------
    edge : (w,) int64 — Edge that each wedge lies along; wedges of one edge share its place.
    origin_m : (w, 3) float64 — Start of the edge [m].
    length_m : (w,) float64 — Length of the edge [m].
    axis, tangent, normal : (w, 3) float64 — Unit vectors [-]: along the edge; into face 0, across
        it; face 0's normal into the air.
    exterior_rad : (w,) float64 — Angle [rad] of the air, face 0 to face n, n pi: 2 pi at a rim.
    facets : (w, 2) int64 — Facets that are face 0 and face n; twice the same one for a rim.
    """

    edge: IntArray
    origin_m: FloatArray
    length_m: FloatArray
    axis: FloatArray
    tangent: FloatArray
    normal: FloatArray
    exterior_rad: FloatArray
    facets: IntArray

    def __post_init__(self) -> None:
        w = len(self.edge)
        for name, shape, dtype in (
            ("edge", (w,), np.int64),
            ("origin_m", (w, 3), np.float64),
            ("length_m", (w,), np.float64),
            ("axis", (w, 3), np.float64),
            ("tangent", (w, 3), np.float64),
            ("normal", (w, 3), np.float64),
            ("exterior_rad", (w,), np.float64),
            ("facets", (w, 2), np.int64),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.edge)

    @property
    def face_normals(self) -> FloatArray:
        """Unit normals [-] of face 0 and face n into the air, (w, 2, 3)."""
        turn = self.exterior_rad[:, None]
        last = np.sin(turn) * self.tangent - np.cos(turn) * self.normal
        normals: FloatArray = np.stack((self.normal, last), axis=1)
        return normals


def find_wedges(scene: Scene) -> Wedges:
    """Return the wedges of a scene that diffract.

    Left out are edges inside solids, seams of one material in one plane, and corners of pi / m, m =
    2, 3 ... (a room's own): there reflections alone are exact for perfect conductors; with two
    materials the small difference between the orders of reflection remains. Where two bodies cut
    through one another the mesh has no edge to diffract: `octant audit` finds such places.

    Parameters
    ----------
    scene : Geometry.
    """
    tolerance_m = _edge_tolerance_m(scene)
    edges = find_edges(scene.facets, tolerance_m=tolerance_m)
    resting = _facets_rested_on(scene.facets, edges, tolerance_m)
    rows = [
        (edge, *sector)
        for edge in range(len(edges.opening_rad))
        for sector in _sectors(scene.facets, edges, edge, resting.get(edge, []))
    ]
    wedges = _as_wedges(edges, rows)
    half = 0.5 * wedges.exterior_rad[:, None]
    into = np.cos(half) * wedges.tangent + np.sin(half) * wedges.normal
    beside = wedges.origin_m + 100.0 * tolerance_m * into
    outside = np.zeros(len(wedges), dtype=np.bool_)
    for share in PLACES_ON_EDGE:
        left = np.flatnonzero(~outside)
        along = (share * wedges.length_m[left])[:, None] * wedges.axis[left]
        outside[left] = ~scene.inside_solid(beside[left] + along)
    return _as_wedges(edges, [row for row, keep in zip(rows, outside, strict=True) if keep])


def _edge_tolerance_m(scene: Scene) -> float:
    return LENGTHS.plane_per_extent * scene.extent_m


_Row = tuple[int, FloatArray, FloatArray, float, int, int]


def _as_wedges(edges: Edges, rows: list[_Row]) -> Wedges:
    edge = np.array([row[0] for row in rows], dtype=np.int64)
    ends = edges.ends_m[edge]
    length = edges.length_m[edge]
    return Wedges(
        edge=edge,
        origin_m=ends[:, 0],
        length_m=length,
        axis=(ends[:, 1] - ends[:, 0]) / length[:, None],
        tangent=np.array([row[1] for row in rows]).reshape(-1, 3),
        normal=np.array([row[2] for row in rows]).reshape(-1, 3),
        exterior_rad=np.array([row[3] for row in rows]),
        facets=np.array([row[4:] for row in rows], dtype=np.int64).reshape(-1, 2),
    )


def _sectors(
    facets: Facets, edges: Edges, edge: int, rested_on: list[int]
) -> list[tuple[FloatArray, FloatArray, float, int, int]]:
    """Return tangent, normal, angle and the two faces of each sector about an edge."""
    span = edges.ends_m[edge, 1] - edges.ends_m[edge, 0]
    axis = span / np.linalg.norm(span)
    members = edges.facet[edges.facet_start[edge] : edges.facet_start[edge + 1]]
    inward = [_inward(facets, edges.ends_m[edge], axis, int(f)) for f in members]
    faces = [int(f) for f in members]
    for facet in rested_on:
        side = np.cross(axis, facets.plane_normal[facets.facet_plane[facet]])
        inward += [side, -side]
        faces += [facet, facet]
    first, across = inward[0], np.cross(axis, inward[0])
    angle = np.array([math.atan2(float(d @ across), float(d @ first)) for d in inward])
    angle = np.where(angle < -ANGLE_TOLERANCE_RAD, angle + 2.0 * math.pi, angle)
    # Of facets that cover one another in one plane the first is the one that paths meet.
    order: list[int] = []
    for k in np.lexsort((np.array(faces), np.round(angle / ANGLE_TOLERANCE_RAD))):
        if not order or angle[k] - angle[order[-1]] > ANGLE_TOLERANCE_RAD:
            order.append(int(k))
    found = []
    for here, there in zip(order, np.roll(order, -1), strict=True):
        width = float(angle[there] - angle[here])
        if there == order[0]:
            width += 2.0 * math.pi
        same = facets.facet_material[faces[here]] == facets.facet_material[faces[there]]
        if _diffracts(width, same_material=bool(same)):
            found.append(
                (
                    inward[here],
                    np.cross(axis, inward[here]),
                    width,
                    faces[here],
                    faces[there],
                )
            )
    return found


def _diffracts(width_rad: float, *, same_material: bool) -> bool:
    """Return whether a sector of this angle between two faces diffracts."""
    if width_rad < ANGLE_TOLERANCE_RAD:
        return False
    parts = math.pi / width_rad
    whole = abs(parts - round(parts)) * width_rad < ANGLE_TOLERANCE_RAD
    return not (whole and (round(parts) >= 2 or (round(parts) == 1 and same_material)))


def _inward(facets: Facets, ends_m: FloatArray, axis: FloatArray, facet: int) -> FloatArray:
    """Return the unit vector from an edge of a facet's outline into the facet."""
    middle = 0.5 * (ends_m[0] + ends_m[1])
    # The facet lies to the left of its directed outline, seen from its normal's side.
    outline = facets.outline_room_m(facet)
    span = outline[:, 1] - outline[:, 0]
    length = np.linalg.norm(span, axis=1)
    along = np.sum((middle - outline[:, 0]) * span, axis=1) / length
    nearest = outline[:, 0] + (np.clip(along, 0.0, length) / length)[:, None] * span
    aside = np.linalg.norm(middle - nearest, axis=1)
    directed = span[int(np.argmin(aside))]
    normal = facets.plane_normal[facets.facet_plane[facet]]
    inward = np.cross(normal, axis if float(directed @ axis) > 0.0 else -axis)
    unit: FloatArray = inward / np.linalg.norm(inward)
    return unit


def _facets_rested_on(facets: Facets, edges: Edges, tolerance_m: float) -> dict[int, list[int]]:
    """Return, for edges that lie within a facet of another body, those facets."""
    found: dict[int, list[int]] = {}
    planes = max(1, len(facets.plane_normal))
    step = max(1, PAIRS_PER_CALL // planes)
    for begin in range(0, len(edges.opening_rad), step):
        ends = edges.ends_m[begin : begin + step]
        height = np.abs(ends @ facets.plane_normal.T - facets.plane_offset_m).max(axis=1)
        for row, plane in np.argwhere(height <= tolerance_m):
            middle = ends[row].mean(axis=0)
            uv = np.array([middle @ facets.plane_u[plane], middle @ facets.plane_v[plane]])
            for facet in range(
                facets.plane_facet_start[plane], facets.plane_facet_start[plane + 1]
            ):
                if _within(facets, facet, uv, tolerance_m):
                    found.setdefault(begin + int(row), []).append(facet)
    return found


def _within(facets: Facets, facet: int, uv_m: npt.NDArray[np.float64], tolerance_m: float) -> bool:
    """Return whether a point (2,) [m] of a facet's plane lies in it, and not on its rim."""
    u0, v0, u1, v1 = facets.outline_m[
        facets.outline_start[facet] : facets.outline_start[facet + 1]
    ].T
    u, v = uv_m
    length = np.hypot(u1 - u0, v1 - v0)
    along = np.clip(((u - u0) * (u1 - u0) + (v - v0) * (v1 - v0)) / length, 0.0, length) / length
    aside = np.hypot(u - u0 - along * (u1 - u0), v - v0 - along * (v1 - v0))
    if float(aside.min()) <= tolerance_m:
        return False
    side = (u1 - u0) * (v - v0) - (u - u0) * (v1 - v0)
    up, down = (v0 <= v) & (v1 > v), (v0 > v) & (v1 <= v)
    return int((up & (side > 0)).sum()) != int((down & (side < 0)).sum())


def no_wedges() -> Wedges:
    """Return an empty set of wedges: nothing diffracts."""
    whole, vector = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    return Wedges(
        edge=whole,
        origin_m=vector,
        length_m=np.zeros(0),
        axis=vector,
        tangent=vector,
        normal=vector,
        exterior_rad=np.zeros(0),
        facets=np.zeros((0, 2), dtype=np.int64),
    )
