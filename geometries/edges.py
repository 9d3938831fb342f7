"""True edges of a scene: where facets meet at an angle, or where a sheet ends.

Seams between coplanar triangles are not edges, whatever the mesh. Outline edges are cut where the
outline of another facet begins or ends on them, so that unevenly meshed walls share their corners.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import FloatArray, IntArray, weld
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
    opening_rad : (e,) float64 — Smallest angle [rad] between two facets, seen along the edge: 0 for
        a free edge, pi for the seam of two materials in one plane.
    """

    ends_m: FloatArray
    facet_start: IntArray
    facet: IntArray
    opening_rad: FloatArray

    def __post_init__(self) -> None:
        e = len(self.opening_rad)
        for name, shape, dtype in (
            ("ends_m", (e, 2, 3), np.float64),
            ("facet_start", (e + 1,), np.int64),
            ("facet", (None,), np.int64),
            ("opening_rad", (e,), np.float64),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    @property
    def length_m(self) -> FloatArray:
        """Length of each edge [m], (e,)."""
        length: FloatArray = np.linalg.norm(self.ends_m[:, 1] - self.ends_m[:, 0], axis=1)
        return length


def find_edges(facets: Facets, *, tolerance_m: float) -> Edges:
    """Return the true edges of a set of facets, ordered by the facets that own them.

    An edge that rests in the middle of another body's facet counts with its own facets only.

    Parameters
    ----------
    facets : Facets of a scene.
    tolerance_m : Distance [m] within which corners and edges coincide.
    """
    owner = np.repeat(np.arange(len(facets.facet_plane)), np.diff(facets.outline_start))
    outlines = [facets.outline_room_m(f) for f in range(len(facets.facet_plane))]
    ends = np.concatenate(outlines) if outlines else np.zeros((0, 2, 3))
    places = ends.reshape(-1, 3)
    corner = np.zeros((0, 2), dtype=np.int64)
    if len(places):
        corner = weld(places, tolerance_m).reshape(-1, 2)
    shared: dict[tuple[int, int], list[int]] = {}
    for facet, chain in zip(owner, _cut_at_corners(places, corner, tolerance_m), strict=True):
        for a, b in pairwise(chain):
            members = shared.setdefault((min(a, b), max(a, b)), [])
            if facet not in members:
                members.append(int(facet))
    sets = list(shared.values())
    segments = np.array([[places[a], places[b]] for a, b in shared]).reshape(-1, 2, 3)
    start = np.concatenate(([0], np.cumsum([len(s) for s in sets], dtype=np.int64)))
    return Edges(
        ends_m=segments,
        facet_start=start.astype(np.int64),
        facet=np.array([f for s in sets for f in s], dtype=np.int64),
        opening_rad=np.array(
            [_opening_rad(facets, ends_m, s) for ends_m, s in zip(segments, sets, strict=True)]
        ),
    )


def _cut_at_corners(places_m: FloatArray, corner: IntArray, tolerance_m: float) -> list[list[int]]:
    """Return, per outline edge, its welded corners and those of other outlines that lie on it."""
    from scipy.spatial import cKDTree

    used = np.unique(corner)
    if len(used) == 0:
        return []
    tree = cKDTree(places_m[used])
    chains: list[list[int]] = []
    for a, b in corner:
        if a == b:  # an edge no longer than what counts as one place: there is none
            chains.append([])
            continue
        span = places_m[b] - places_m[a]
        length = float(np.linalg.norm(span))
        near = used[tree.query_ball_point(places_m[a] + 0.5 * span, 0.5 * length + tolerance_m)]
        along = (places_m[near] - places_m[a]) @ span / length
        aside = np.linalg.norm(
            places_m[near] - places_m[a] - along[:, None] * span / length, axis=1
        )
        on = (aside <= tolerance_m) & (along > tolerance_m) & (along < length - tolerance_m)
        chains.append([int(a), *(int(v) for v in near[on][np.argsort(along[on])]), int(b)])
    return chains


def _opening_rad(facets: Facets, ends_m: FloatArray, members: list[int]) -> float:
    """Return the smallest angle [rad] between the facets of an edge, 0 for a single one."""
    axis = (ends_m[1] - ends_m[0]) / np.linalg.norm(ends_m[1] - ends_m[0])
    middle = 0.5 * (ends_m[0] + ends_m[1])
    inward = []
    for facet in members:
        # The facet lies to the left of its directed outline, seen from its normal's side.
        edges = facets.outline_room_m(facet)
        span = edges[:, 1] - edges[:, 0]
        length = np.linalg.norm(span, axis=1)
        along = np.sum((middle - edges[:, 0]) * span, axis=1) / length
        aside = np.linalg.norm(
            middle - edges[:, 0] - (along / length)[:, None] * span, axis=1
        ) + np.where((along >= 0.0) & (along <= length), 0.0, np.inf)
        directed = span[int(np.argmin(aside))]
        normal = facets.plane_normal[facets.facet_plane[facet]]
        inward.append(np.cross(normal, directed / np.linalg.norm(directed)))
    if len(inward) < 2:
        return 0.0
    angles = [
        float(np.arctan2(abs(float(axis @ np.cross(p, q))), float(p @ q)))
        for i, p in enumerate(inward)
        for q in inward[i + 1 :]
    ]
    return min(angles)
