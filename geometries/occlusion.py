"""Answers "is this segment free?" for triangle meshes, in float64.

Kay and Kajiya (1986) slabs, Moller and Trumbore (1997) triangles, a binned surface-area tree: built
in O(n log n), answers in O(log n). Single-precision tracers cannot be used here: paths end *on*
surfaces, and only the exclusion of the end planes by number separates an end from an obstacle.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries import _bvh_kernels
from octant.geometries._arrays import read_only
from octant.geometries._bvh_kernels import BvhArrays
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.tolerances import LENGTHS


def build_bvh(corners_m: FloatArray, planes: IntArray, *, extent_m: float) -> BvhArrays:
    """Return the hierarchy over triangles, as the arrays that the kernels take.

    Parameters
    ----------
    corners_m : (t, 3, 3) float64 — Corners of the triangles [m].
    planes : (t,) int64 — Number of the plane that each triangle lies in, for exclusion.
    extent_m : Size of the whole scene [m], the scale of the margins.
    """
    margin = LENGTHS.facet_per_extent * extent_m
    corners = np.ascontiguousarray(corners_m, dtype=np.float64).reshape(-1, 3, 3)
    low, high = corners.min(axis=1) - margin, corners.max(axis=1) + margin
    order, boxes, links = _bvh_kernels.build(low, high)
    base = corners[order, 0]
    sides = (base, corners[order, 1] - base, corners[order, 2] - base)
    return BvhArrays(
        boxes=boxes,
        links=links,
        triangles=np.ascontiguousarray(np.concatenate(sides, axis=1)),
        planes=np.ascontiguousarray(planes[order].astype(np.int64)),
        margin=margin,
    )


def segments_blocked(
    bvh: BvhArrays,
    starts_m: npt.ArrayLike,
    ends_m: npt.ArrayLike,
    *,
    start_planes: npt.ArrayLike = -1,
    end_planes: npt.ArrayLike = -1,
) -> npt.NDArray[np.bool_]:
    """Return (n,) bool, whether something stands strictly between the ends of each segment [-].

    Parameters
    ----------
    bvh : Hierarchy of `build_bvh`.
    starts_m, ends_m : (n, 3) float64 — Ends of the segments [m].
    start_planes, end_planes : (n,) int or int — Planes to ignore [-]; -1: none.
    """
    starts: npt.NDArray[Any] = np.ascontiguousarray(starts_m, dtype=np.float64).reshape(-1, 3)
    ends = np.ascontiguousarray(ends_m, dtype=np.float64).reshape(-1, 3)
    shape = (len(starts),)
    blocked = np.zeros(shape, dtype=np.bool_)
    _bvh_kernels.segments_blocked(
        *read_only((bvh, starts, ends)),
        np.ascontiguousarray(np.broadcast_to(start_planes, shape), dtype=np.int64),
        np.ascontiguousarray(np.broadcast_to(end_planes, shape), dtype=np.int64),
        blocked,
    )
    return blocked


def winding_numbers(points_m: npt.ArrayLike, corners_m: FloatArray) -> FloatArray:
    """Return (n,) winding numbers [-] of points: closed meshes give +1 or -1 inside, 0 outside.

    The sign is the orientation; open ones give the share of the full solid angle that they cover
    (Jacobson, Kavan and Sorkine, 2013, equation 5).

    Parameters
    ----------
    points_m : (n, 3) float64 — Points [m], not on the mesh.
    corners_m : (t, 3, 3) float64 — Corners of the triangles [m].
    """
    points = np.ascontiguousarray(points_m, dtype=np.float64).reshape(-1, 3)
    winding = np.zeros(len(points))
    _bvh_kernels.winding_numbers(points, np.ascontiguousarray(corners_m), winding)
    return winding
