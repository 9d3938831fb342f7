"""True edges of a scene: where facets meet at an angle, or where a sheet ends.

Seams between coplanar triangles are not edges, whatever the mesh. Outline edges are cut where the
outline of another facet begins or ends on them, so that unevenly meshed walls share their corners.
"""

from dataclasses import dataclass

import numpy as np

from octant.geometries import _bvh_kernels, _wedge_kernels
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries._plane_geometry import FloatArray, IntArray, row_numbers, weld
from octant.geometries.facets import Facets


@dataclass(frozen=True, slots=True, kw_only=True)
class Edges:
    """Straight edges and the facets that meet along them.

    Parameters
    ----------
    ends_m : (e, 2, 3) float64 — End points [m].
    facet_start : (e + 1,) int64 — Where the facets of each edge start in ``facet``.
    facet : (k,) int64 — Facets that end along each edge: one for a free edge, two for a wedge or a
        bent sheet, three and more for a junction of sheets.
    inward : (k, 3) float64 — Unit vectors [-] from the edge into each of these facets.
    opening_rad : (e,) float64 — Smallest angle [rad] between two facets, seen along the edge: 0 for
        a free edge, pi for the seam of two materials in one plane.
    """

    ends_m: FloatArray
    facet_start: IntArray
    facet: IntArray
    inward: FloatArray
    opening_rad: FloatArray

    def __post_init__(self) -> None:
        e = len(self.opening_rad)
        for name, shape, dtype in (
            ("ends_m", (e, 2, 3), np.float64),
            ("facet_start", (e + 1,), np.int64),
            ("facet", (None,), np.int64),
            ("inward", (len(self.facet), 3), np.float64),
            ("opening_rad", (e,), np.float64),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    @property
    def length_m(self) -> FloatArray:
        """Length of each edge [m], (e,)."""
        length: FloatArray = np.linalg.norm(self.ends_m[:, 1] - self.ends_m[:, 0], axis=1)
        return length

    @property
    def edge_of(self) -> IntArray:
        """Edge that each of ``facet`` ends along, (k,)."""
        return np.repeat(np.arange(len(self.opening_rad)), np.diff(self.facet_start))

    @property
    def axis(self) -> FloatArray:
        """Unit vector [-] along each edge, (e, 3)."""
        return unit_vectors(self.ends_m[:, 1] - self.ends_m[:, 0])


def find_edges(facets: Facets, *, tolerance_m: float) -> Edges:
    """Return the true edges of a set of facets, ordered by the facets that own them.

    An edge that rests in the middle of another body's facet counts with its own facets only.

    Parameters
    ----------
    facets : Facets of a scene.
    tolerance_m : Distance [m] within which corners and edges coincide.
    """
    owner = np.repeat(np.arange(len(facets.facet_plane)), np.diff(facets.outline_start))
    outline = facets.outline_room_m()
    places = outline.reshape(-1, 3)
    corner = weld(places, tolerance_m).reshape(-1, 2)
    piece, first, second = _cut_at_corners(places, corner, tolerance_m).T
    low, high = np.minimum(first, second), np.maximum(first, second)
    _, start, member = row_numbers(np.column_stack((low, high)))
    by_owner = np.argsort(member[start[:-1]])
    size = np.diff(start)[by_owner]
    edge = np.repeat(np.arange(len(size)), size)
    begin = np.cumsum(size) - size
    row = member[np.repeat(start[:-1][by_owner] - begin, size) + np.arange(len(member))]
    lowest = row[begin]
    ends = np.stack((places[low[lowest]], places[high[lowest]]), axis=1)
    # Where a facet's outline runs along an edge twice, the nearer one counts.
    span = outline[piece[row], 1] - outline[piece[row], 0]
    to_middle = 0.5 * (ends[edge, 0] + ends[edge, 1]) - outline[piece[row], 0]
    share = np.sum(to_middle * span, axis=1) / np.sum(span * span, axis=1)
    aside = np.linalg.norm(to_middle - share[:, None] * span, axis=1)
    facet = owner[piece[row]]
    nearest = np.lexsort((np.arange(len(row)), aside, facet, edge))
    once = np.ones(len(row), dtype=np.bool_)
    once[1:] = (np.diff(edge[nearest]) > 0) | (np.diff(facet[nearest]) > 0)
    kept = nearest[once]
    edge, facet = edge[kept], facet[kept]
    axis = unit_vectors(ends[:, 1] - ends[:, 0])[edge]
    # The facet lies to the left of its directed outline, seen from its normal's side.
    along = np.where((row_products(span[kept], axis) > 0.0)[:, None], axis, -axis)
    inward = unit_vectors(np.cross(facets.plane_normal[facets.facet_plane[facet]], along))
    return Edges(
        ends_m=ends,
        facet_start=np.searchsorted(edge, np.arange(len(ends) + 1)),
        facet=facet,
        inward=inward,
        opening_rad=_opening_rad(inward, edge, len(ends)),
    )


def row_products(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return (n,) products of rows (n, 3), rounded as those of two single vectors are.

    Parameters
    ----------
    first, second : (n, 3) float64 — Vectors, in any unit [-].
    """
    products: FloatArray = (first[:, None, :] @ second[:, :, None])[:, 0, 0]
    return products


def unit_vectors(vectors: FloatArray) -> FloatArray:
    """Return vectors (n, 3), in any unit, over their lengths [-].

    Parameters
    ----------
    vectors : (n, 3) float64 — None of length zero [-].
    """
    unit: FloatArray = vectors / np.sqrt(row_products(vectors, vectors))[:, None]
    return unit


def _cut_at_corners(places_m: FloatArray, corner: IntArray, tolerance_m: float) -> IntArray:
    """Return (k, 3) outline edge, start and end of its parts between corners that lie on it."""
    used = np.unique(corner)
    order, boxes, links = _bvh_kernels.build(places_m[used], places_m[used])
    known = read_only((places_m, corner, used, boxes, links, order))
    pieces: IntArray = _wedge_kernels.cut_at_corners(*known, tolerance_m)
    return pieces


def _opening_rad(inward: FloatArray, edge: IntArray, edges: int) -> FloatArray:
    """Return the smallest angle [rad] between the facets of each edge, 0 for a single one."""
    opening = np.full(edges, np.inf)
    for step in range(1, int(np.bincount(edge, minlength=1).max())):
        row = np.flatnonzero(edge[step:] == edge[:-step])
        p, q = inward[row], inward[row + step]
        angle = np.arctan2(np.linalg.norm(np.cross(p, q), axis=1), np.sum(p * q, axis=1))
        np.minimum.at(opening, edge[row], angle)
    return np.where(np.isinf(opening), 0.0, opening)
