"""The facets of a scene as the search for images sees them: hulls, sides, and who hides whom."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em.search import _beam_kernels
from octant.em.search.once import once
from octant.geometries import _bvh_kernels
from octant.geometries._arrays import read_only
from octant.geometries.closed_parts import inside_parts
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

NEVER = 2
"""Side [-] of a facet that a path can use on neither side."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchFacets:
    """Facets as beams meet them.

    Parameters
    ----------
    side : (f,) int64 — +1 or -1: the only side on which a facet reflects; 0: both.
    occluder_area_m2 : (f,) float64 — Area [m^2] of opaque facets that fill their hull; others 0.
    hull_start : (f + 1,) int64 — Where the corners of each facet's convex hull start.
    hulls_m : (v, 3) float64 — Corners [m], counter-clockwise about the plane's normal.
    boxes : (n, 6) float64 — Boxes [m] of the hierarchy over the hulls of usable facets.
    links : (n, 3) int64 — Links of the hierarchy, as in `octant.geometries.occlusion`.
    order : (k,) int64 — Facets in the order of the hierarchy.
    margin_m : Distance [m] by which a target must lie behind a facet, and within its outline, to be
        hidden: more than facets deviate from their triangles.
    unevenness_m : Greatest distance [m] of a triangle's corner from its facet's plane.
    """

    side: IntArray
    occluder_area_m2: FloatArray
    hull_start: IntArray
    hulls_m: FloatArray
    boxes: FloatArray
    links: IntArray
    order: IntArray
    margin_m: float
    unevenness_m: float


def search_facets(
    scene: Scene, source_m: FloatArray, region_m: FloatArray, opaque_facets: BoolArray
) -> SearchFacets:
    """Return the facets of a scene as the beams of one source meet them.

    Sources for which facets reflect on the same sides share them: the same object.

    Parameters
    ----------
    scene : Geometry.
    source_m : (3,) float64 — The source [m].
    region_m : (2, 3) float64 — Box [m] that all receivers lie in.
    opaque_facets : (f,) bool — Facets that let nothing through.
    """
    side = _sides(scene, source_m, region_m, opaque_facets)
    key = ("facets", side.tobytes(), opaque_facets.tobytes())
    return once(scene, key, lambda: _facets(scene, side, opaque_facets))


class _Outlines(NamedTuple):
    """Outlines of facets, whatever the source."""

    hull_start: IntArray  # (f + 1,)
    hulls: FloatArray  # (v, 3) [m]
    low: FloatArray  # (f, 3) [m]: least corner of the box around a hull
    high: FloatArray  # (f, 3) [m]: its greatest corner
    filling_area: FloatArray  # (f,) [m^2] of facets that fill their hull; others 0
    unevenness: float  # [m]


def _outlines(scene: Scene) -> _Outlines:
    f = scene.facets
    fills = np.zeros(len(f.facet_plane), dtype=np.bool_)
    hull_start, uv = _beam_kernels.facet_hulls(*read_only((f.outline_start, f.outline_m)), fills)
    owner = np.repeat(np.arange(len(f.facet_plane)), np.diff(hull_start))
    plane = f.facet_plane[owner]
    origin = f.plane_normal[plane] * f.plane_offset_m[plane][:, None]
    hulls = origin + uv[:, :1] * f.plane_u[plane] + uv[:, 1:] * f.plane_v[plane]
    area = np.zeros(len(f.facet_plane))
    low, high = np.zeros((len(area), 3)), np.zeros((len(area), 3))
    if len(area):
        edges = f.outline_m
        twice = edges[:, 0] * edges[:, 3] - edges[:, 2] * edges[:, 1]
        area = 0.5 * np.add.reduceat(twice, f.outline_start[:-1])
        low = np.minimum.reduceat(hulls, hull_start[:-1], axis=0) - scene.tolerance_m
        high = np.maximum.reduceat(hulls, hull_start[:-1], axis=0) + scene.tolerance_m
    return _Outlines(
        hull_start=hull_start,
        hulls=np.ascontiguousarray(hulls),
        low=low,
        high=high,
        filling_area=np.where(fills, area, 0.0),
        unevenness=_unevenness_m(scene),
    )


def _facets(scene: Scene, side: IntArray, opaque_facets: BoolArray) -> SearchFacets:
    shape = once(scene, "outlines", lambda: _outlines(scene))
    used = np.flatnonzero(side != NEVER)
    order, boxes, links = _bvh_kernels.build(shape.low[used], shape.high[used])
    return SearchFacets(
        side=side,
        occluder_area_m2=np.where(opaque_facets, shape.filling_area, 0.0),
        hull_start=shape.hull_start,
        hulls_m=shape.hulls,
        boxes=boxes,
        links=links,
        order=used[order],
        margin_m=LENGTHS.hiding_per_extent * scene.extent_m + 2.0 * shape.unevenness,
        unevenness_m=shape.unevenness,
    )


def _sides(
    scene: Scene, source: FloatArray, region: FloatArray, opaque_facets: BoolArray
) -> IntArray:
    """Return the side on which each facet can reflect: +1, -1, 0 for both, or ``NEVER``."""
    f = scene.facets
    inner = inner_sides(scene, source, region)[f.facet_plane]
    parts = (*scene.solids, scene.shell_corners_m)
    # A part is sealed when all of its triangles are in facets that let nothing through.
    sealed = np.zeros(len(parts) + 1, dtype=np.bool_)
    sealed[np.unique(scene.triangle_part)] = True
    opaque = np.append(opaque_facets, False)[f.triangle_facet]
    sealed[scene.triangle_part[~opaque]] = False
    sealed[-1] = False
    inside = np.append(inside_parts(source, parts), False)
    own = np.where(inside[scene.facet_part], -1, 1) * scene.facet_outer_side
    own = np.where(sealed[scene.facet_part], own, 0)
    return np.where(inner * own < 0, NEVER, np.where(inner != 0, inner, own)).astype(np.int64)


def inner_sides(scene: Scene, source_m: FloatArray, region_m: FloatArray) -> IntArray:
    """Return +1, -1 or 0 per plane: the one side on which everything lies, receivers included.

    Parameters
    ----------
    scene : Geometry.
    source_m : (3,) float64 — The source [m].
    region_m : (2, 3) float64 — Box [m] that all receivers lie in.
    """
    sides = scene.supporting_side.copy()
    outer = np.flatnonzero(sides)
    normal = sides[outer, None] * scene.facets.plane_normal[outer]
    offset = sides[outer] * scene.facets.plane_offset_m[outer]
    # The corner of the region that lies farthest out; 0 * inf must not become NaN.
    corner = np.where(normal > 0.0, region_m[0], region_m[1])
    lowest = np.sum(np.where(normal == 0.0, 0.0, normal * np.where(normal == 0.0, 0.0, corner)), 1)
    beyond = np.minimum(lowest, normal @ source_m) - offset < -scene.tolerance_m
    sides[outer[beyond]] = 0
    return sides


def _unevenness_m(scene: Scene) -> float:
    """Return the greatest distance [m] of a triangle's corner from its facet's plane."""
    f, bvh = scene.facets, scene.bvh
    normal, offset = f.plane_normal[bvh.planes], f.plane_offset_m[bvh.planes]
    height = np.sum(bvh.triangles[:, :3] * normal, axis=1) - offset
    first = np.sum(bvh.triangles[:, 3:6] * normal, axis=1)
    second = np.sum(bvh.triangles[:, 6:] * normal, axis=1)
    farthest = np.abs(np.stack((height, height + first, height + second)))
    return float(farthest.max(initial=0.0))
