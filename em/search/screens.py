"""What hides facets in scenes of very many: convex opaque polygons, and what goes on beyond them.

A facet that fills its hull is one screen; of any other, each triangle is. Where an opaque triangle
goes on across a screen's edge, both together leave nothing between them.
"""

import numpy as np
import numpy.typing as npt

from octant.em.search._cell_kernels import SightFacets
from octant.em.search._screen_kernels import MOST_EDGES, Screens
from octant.em.search.facets import SearchFacets
from octant.em.search.once import once
from octant.geometries._arrays import read_only
from octant.geometries._plane_geometry import row_numbers, weld
from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

LARGE_LEAST, LARGE_SHARE = 512, 64
"""Facets [-] whose screens are looked at first: so many at least, one in so many of all."""


def sight_facets(scene: Scene, facets: SearchFacets) -> SightFacets:
    """Return the facets as kernels look for them, lengths in [m].

    Parameters
    ----------
    scene : Geometry.
    facets : The same as the beams of one source meet them.
    """
    f = scene.facets
    arrays = SightFacets(
        plane_normal=f.plane_normal,
        plane_offset=f.plane_offset_m,
        plane=f.facet_plane,
        side=facets.side,
        hull_start=facets.hull_start,
        hulls=facets.hulls_m,
        boxes=facets.boxes,
        links=facets.links,
        order=facets.order,
        slack=scene.tolerance_m,
    )
    return read_only(arrays)


def find_screens(scene: Scene, facets: SearchFacets, opaque_facets: BoolArray) -> Screens:
    """Return the screens of a scene, lengths in [m]; they are the same for all sources.

    Parameters
    ----------
    scene : Geometry.
    facets : Its facets as beams meet them.
    opaque_facets : (f,) bool — Facets that let nothing through.
    """
    key = ("screens", opaque_facets.tobytes())
    return once(scene, key, lambda: _screens(scene, facets, opaque_facets))


def _screens(scene: Scene, facets: SearchFacets, opaque_facets: BoolArray) -> Screens:
    count = len(scene.facets.facet_plane)
    size = np.diff(facets.hull_start)
    whole = (facets.occluder_area_m2 > 0.0) & (size <= MOST_EDGES)
    opaque = opaque_facets[scene.triangle_facet]
    corners, owner = scene.triangle_corners_m[opaque], scene.triangle_facet[opaque]
    apart = ~whole[owner]
    hull_rows = np.repeat(whole, size)
    places = np.concatenate((corners.reshape(-1, 3), facets.hulls_m[hull_rows]))
    # Hulls lie in the facet's plane, off which triangles may be by half of this.
    number = weld(places, scene.tolerance_m + 2.0 * facets.unevenness_m)
    triangle = number[: 3 * len(corners)].reshape(-1, 3)
    hull_end = np.arange(len(facets.hulls_m)) + 1
    hull_end[facets.hull_start[1:] - 1] = facets.hull_start[:-1]
    row_of = np.cumsum(hull_rows) - 1
    hull = number[3 * len(corners) :]
    follows = hull[row_of[hull_end[hull_rows]]]
    # Screens: hulls and triangles, by facet.
    sizes = np.concatenate((size[whole], np.full(int(apart.sum()), 3)))
    facet = np.concatenate((np.flatnonzero(whole), owner[apart]))
    start = np.concatenate((np.column_stack((hull, follows)), _edges(triangle[apart])))
    at = np.concatenate((facets.hulls_m[hull_rows], corners[apart].reshape(-1, 3)))
    own = np.concatenate((-1 - np.flatnonzero(whole), np.flatnonzero(apart)))
    beyond = _beyond(triangle, corners, owner, start, np.repeat(own, sizes))
    order = np.argsort(facet, kind="stable")
    first = np.cumsum(sizes) - sizes
    corner_start = np.concatenate(([0], np.cumsum(sizes[order])))
    moved = np.repeat(first[order] - corner_start[:-1], sizes[order]) + np.arange(len(at))
    area = np.zeros(count)
    np.maximum.at(area, owner, _areas(corners))
    area = np.maximum(area, facets.occluder_area_m2)
    large = np.argsort(-area, kind="stable")[: max(LARGE_LEAST, count // LARGE_SHARE)]
    large = np.sort(large[area[large] > 0.0])
    is_large = np.zeros(count, dtype=np.bool_)
    is_large[large] = True
    arrays = Screens(
        facet_start=np.searchsorted(facet[order], np.arange(count + 1)).astype(np.int64),
        corner_start=corner_start.astype(np.int64),
        corners=np.ascontiguousarray(at[moved]),
        beyond=np.ascontiguousarray(beyond[moved]),
        large=large,
        is_large=is_large,
        margin=facets.margin_m,
        give=scene.tolerance_m + 2.0 * facets.unevenness_m,
    )
    return read_only(arrays)


def _areas(corners: FloatArray) -> FloatArray:
    """Return the areas [m^2] of triangles."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area: FloatArray = 0.5 * np.linalg.norm(np.cross(first, second), axis=1)
    return area


def _edges(triangle: IntArray) -> IntArray:
    """Return (3 t, 2) the edges of triangles, by triangle."""
    edges: IntArray = np.stack((triangle, np.roll(triangle, -1, axis=1)), axis=2).reshape(-1, 2)
    return edges


def _beyond(
    triangle: IntArray, corners: FloatArray, owner: IntArray, edge: IntArray, own: IntArray
) -> FloatArray:
    """Return (e, 3) the third corner of the triangle across each edge of a screen; NaN: none.

    An edge counts that exactly two triangles have, whose three corners are not the same. ``own``
    names the screen's triangle, or, as -1 - f, the facet that it fills; the other one is across.
    """
    sides = _edges(triangle)
    rows = np.concatenate((np.sort(sides, axis=1), np.sort(edge, axis=1)))
    name, start, member = row_numbers(rows)
    number = np.bincount(name[: len(sides)], minlength=len(start) - 1)
    group = name[len(sides) :]
    two = np.flatnonzero(number[group] == 2)
    # Of each name's rows those of triangles come first.
    pair = np.stack((member[start[group[two]]], member[start[group[two]] + 1]))
    is_own = np.where(own[two] >= 0, pair // 3 == own[two], owner[pair // 3] == -1 - own[two])
    third = np.roll(triangle, -2, axis=1).reshape(-1)[pair]
    used = (is_own[0] != is_own[1]) & (third[0] != third[1])
    across = np.where(is_own[0], pair[1], pair[0])[used]
    found = np.full((len(edge), 3), np.nan)
    found[two[used]] = np.roll(corners, -2, axis=1).reshape(-1, 3)[across]
    return found
