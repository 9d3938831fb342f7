"""Wedges: the sectors of air between the facets that meet along an edge, which diffract.

The rim of a sheet has one of 360 degrees, a cabinet's edge one of 270, a fold of a sheet two, a
junction of k sheets k. Facets that an edge rests on (the floor under a cabinet) bound sectors too.
"""

import math
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from octant.geometries import _bvh_kernels, _wedge_kernels
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.edges import Edges, find_edges, row_products
from octant.geometries.facets import Facets
from octant.geometries.occlusion import segments_blocked
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS

BoolArray = npt.NDArray[np.bool_]

ANGLE_TOLERANCE_RAD = 1e-6
"""Angle [rad] within which facets count as coplanar, or a sector as a whole part of 180 degrees."""

PLACES_ON_EDGE = (0.537, 0.463, 0.789, 0.211, 0.943, 0.057)
"""Places [-] along an edge, one of which must be outside solids: where other bodies seldom end."""


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
    tips : (w, 2) int64 — 1 where the rim of a sheet ends in the open at its start or at its end
        [-]; 0 for other wedges, where a facet carries it on as its mirror image, or the next rim;
        -1 where a wedge of a lower number goes on between the same planes, as where the material
        changes: to that one belongs what falls on the end itself.
    """

    edge: IntArray
    origin_m: FloatArray
    length_m: FloatArray
    axis: FloatArray
    tangent: FloatArray
    normal: FloatArray
    exterior_rad: FloatArray
    facets: IntArray
    tips: IntArray

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
            ("tips", (w, 2), np.int64),
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
    tolerance_m = LENGTHS.plane_per_extent * scene.extent_m
    edges = find_edges(scene.facets, tolerance_m=tolerance_m)
    wedges = _sectors(scene.facets, edges, *facets_rested_on(scene.facets, edges, tolerance_m).T)
    half = 0.5 * wedges.exterior_rad[:, None]
    into = np.cos(half) * wedges.tangent + np.sin(half) * wedges.normal
    beside = wedges.origin_m + 100.0 * tolerance_m * into
    outside = np.zeros(len(wedges), dtype=np.bool_)
    for share in PLACES_ON_EDGE:
        left = np.flatnonzero(~outside)
        along = (share * wedges.length_m[left])[:, None] * wedges.axis[left]
        outside[left] = ~scene.inside_solid(beside[left] + along)
    kept = Wedges(**{f.name: getattr(wedges, f.name)[outside] for f in fields(Wedges)})
    tips = _tips(scene, kept, tolerance_m)
    return replace(kept, tips=np.where(tips == 0, -_yields(kept, tolerance_m), tips))


def _tips(scene: Scene, wedges: Wedges, tolerance_m: float) -> IntArray:
    """Return which ends of each wedge's edge are in the open, see :class:`Wedges`."""
    from scipy.spatial import cKDTree

    tips = np.zeros((len(wedges), 2), dtype=np.int64)
    rim = np.flatnonzero(wedges.exterior_rad > 2.0 * math.pi - ANGLE_TOLERANCE_RAD)
    if len(rim) == 0:
        return tips
    origin, axis = wedges.origin_m[rim], wedges.axis[rim]
    places = np.stack((origin, origin + wedges.length_m[rim, None] * axis), axis=1).reshape(-1, 3)
    outward = np.stack((-axis, axis), axis=1).reshape(-1, 3)
    into = np.repeat(-wedges.tangent[rim], 2, axis=0)
    step_m = 100.0 * tolerance_m
    beside = places + step_m * into
    ends = ~segments_blocked(scene.bvh, beside - step_m * outward, beside + step_m * outward)
    one, other = cKDTree(places).query_pairs(tolerance_m, output_type="ndarray").T
    made_of = np.repeat(scene.facets.facet_material[wedges.facets[rim, 0]], 2)
    goes_on = row_products(outward[one], outward[other]) < -1.0 + ANGLE_TOLERANCE_RAD
    goes_on &= row_products(into[one], into[other]) > 1.0 - ANGLE_TOLERANCE_RAD
    goes_on &= made_of[one] == made_of[other]
    ends[one[goes_on]] = ends[other[goes_on]] = False
    tips[rim] = ends.reshape(-1, 2)
    return tips


def _yields(wedges: Wedges, tolerance_m: float) -> IntArray:
    """Return 1 at ends of edges where one of a lower number goes on, see `Wedges.tips`."""
    from scipy.spatial import cKDTree

    yields = np.zeros(2 * len(wedges), dtype=np.int64)
    if len(wedges):
        far = wedges.origin_m + wedges.length_m[:, None] * wedges.axis
        places = np.stack((wedges.origin_m, far), axis=1).reshape(-1, 3)
        outward = np.stack((-wedges.axis, wedges.axis), axis=1).reshape(-1, 3)
        half = 0.5 * np.repeat(wedges.exterior_rad, 2)[:, None]
        tangent, normal = np.repeat(wedges.tangent, 2, axis=0), np.repeat(wedges.normal, 2, axis=0)
        into = np.cos(half) * tangent + np.sin(half) * normal
        one, other = cKDTree(places).query_pairs(tolerance_m, output_type="ndarray").T
        goes_on = row_products(outward[one], outward[other]) < -1.0 + ANGLE_TOLERANCE_RAD
        goes_on &= row_products(into[one], into[other]) > 1.0 - ANGLE_TOLERANCE_RAD
        goes_on &= np.abs(half[one, 0] - half[other, 0]) < ANGLE_TOLERANCE_RAD
        yields[np.maximum(one, other)[goes_on]] = 1
    return yields.reshape(-1, 2)


def _sectors(facets: Facets, edges: Edges, rests: IntArray, rested_on: IntArray) -> Wedges:
    """Return the wedges about all edges; edge ``rests[i]`` lies within facet ``rested_on[i]``."""
    count = len(edges.opening_rad)
    side = np.cross(edges.axis[rests], facets.plane_normal[facets.facet_plane[rested_on]])
    edge = np.concatenate((edges.edge_of, np.repeat(rests, 2)))
    face = np.concatenate((edges.facet, np.repeat(rested_on, 2)))
    inward = np.concatenate((edges.inward, np.stack((side, -side), axis=1).reshape(-1, 3)))
    first = edges.inward[edges.facet_start[:-1]]
    across = row_products(inward, np.cross(edges.axis, first)[edge])
    turns = zip(across, row_products(inward, first[edge]), strict=True)
    angle = np.array([math.atan2(y, x) for y, x in turns])
    angle = np.where(angle < -ANGLE_TOLERANCE_RAD, angle + 2.0 * math.pi, angle)
    # Of facets that cover one another in one plane the first is the one that paths meet.
    around = np.lexsort((face, np.round(angle / ANGLE_TOLERANCE_RAD), edge))
    edge, face, inward, angle = edge[around], face[around], inward[around], angle[around]
    start = np.searchsorted(edge, np.arange(count + 1))
    kept = np.zeros(len(edge), dtype=np.bool_)
    last = np.full(count, -np.inf)
    for rank in range(int(np.diff(start).max(initial=0))):
        row = start[:-1][np.diff(start) > rank] + rank
        row = row[angle[row] - last[edge[row]] > ANGLE_TOLERANCE_RAD]
        kept[row], last[edge[row]] = True, angle[row]
    edge, face, inward, angle = edge[kept], face[kept], inward[kept], angle[kept]
    start = np.searchsorted(edge, np.arange(count + 1))
    following = np.arange(1, len(edge) + 1)
    following[start[1:] - 1] = start[:-1]
    width = angle[following] - angle + np.where(following == start[edge], 2.0 * math.pi, 0.0)
    material = facets.facet_material[face]
    bends = np.flatnonzero(_diffracts(width, material == material[following]))
    edge = edge[bends]
    ends, length = edges.ends_m[edge], edges.length_m[edge]
    return Wedges(
        edge=edge,
        origin_m=ends[:, 0],
        length_m=length,
        axis=(ends[:, 1] - ends[:, 0]) / length[:, None],
        tangent=inward[bends],
        normal=np.cross(edges.axis[edge], inward[bends]),
        exterior_rad=width[bends],
        facets=np.column_stack((face, face[following]))[bends],
        tips=np.zeros((len(bends), 2), dtype=np.int64),
    )


def _diffracts(width_rad: FloatArray, same_material: BoolArray) -> BoolArray:
    """Return whether sectors of these angles, each between two faces, diffract."""
    parts = math.pi / np.maximum(width_rad, ANGLE_TOLERANCE_RAD)
    nearest = np.round(parts)
    whole = np.abs(parts - nearest) * width_rad < ANGLE_TOLERANCE_RAD
    exact = whole & ((nearest >= 2) | ((nearest == 1) & same_material))
    diffracts: BoolArray = (width_rad >= ANGLE_TOLERANCE_RAD) & ~exact
    return diffracts


def facets_rested_on(facets: Facets, edges: Edges, tolerance_m: float) -> IntArray:
    """Return (k, 2) edges that lie within a facet of another body, and the facet, ascending.

    Parameters
    ----------
    facets, edges : Facets of a scene and their edges.
    tolerance_m : Distance [m] within which an edge lies in a plane, or on a facet's rim.
    """
    corners, at = facets.outline_room_m().reshape(-1, 3), 2 * facets.outline_start[:-1]
    low = np.minimum.reduceat(corners, at, axis=0) if len(at) else corners
    high = np.maximum.reduceat(corners, at, axis=0) if len(at) else corners
    order, boxes, links = _bvh_kernels.build(low - 2.0 * tolerance_m, high + 2.0 * tolerance_m)
    known = (
        edges.ends_m,
        boxes,
        links,
        order,
        facets.facet_plane,
        facets.plane_normal,
        facets.plane_offset_m,
        facets.plane_u,
        facets.plane_v,
        facets.outline_start,
        facets.outline_m,
    )
    pairs: IntArray = _wedge_kernels.facets_rested_on(*read_only(known), tolerance_m)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


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
        tips=np.zeros((0, 2), dtype=np.int64),
    )
