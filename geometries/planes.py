"""Which triangles lie in one plane, as far as the rounding of their stored corners lets one tell.

Files hold float32: a flat wall that is meshed, turned and stored comes back flat to some ten
nanometres only, and rays would find edges where there are none. What counts is the rounding of the
corners in question, not the scene's size: a small curved thing in a large hall keeps its facets.
"""

import numpy as np

from octant.geometries import _plane_kernels
from octant.geometries._arrays import read_only
from octant.geometries._plane_geometry import (
    FloatArray,
    IntArray,
    row_numbers,
    triangle_area_vectors,
)
from octant.geometries.tolerances import LENGTHS

FLOAT32_BITS = 24
"""Significant bits [-] of the coordinates in most mesh files."""

FLOAT64_BITS = 53
"""Significant bits [-] of arithmetic, and of what text files can hold."""

TYPED_DIGITS = 8
"""Decimal digits [-] that coordinates are drawn with at most; float32 numbers have more."""

PRINTED_SHARE = 0.02
"""Share [-] of a float32 number's last bit that is lost when a text file prints it."""

SLIVER_ASPECT = 1e-4
"""Height over longest side [-] below which a triangle's own normal is not trusted."""


def rounding_m(
    vertices_m: FloatArray,
    *,
    coordinate_bits: int,
    extent_m: float,
    stored_m: FloatArray | float = 0.0,
) -> FloatArray:
    """Return (n,) how far [m] rounding may have moved each vertex off the plane it was drawn in.

    Rounding moves a coordinate c by at most 2^-bits |c|, and a corner at x off its plane by at most
    2^-bits |x| (Cauchy's inequality). Corner and plane are both rounded, and files turned, moved
    and scaled afterwards: four times that is allowed. Near the origin it is 2^-(bits - 1) of the
    extent, but never more than ``LENGTHS.place_m``, and always what arithmetic in float64 adds.
    A scene that stands further from the origin than it is large was drawn about an origin of its
    own: only rounding that was seen in its file (`observed_rounding`) counts from the file's.

    Parameters
    ----------
    vertices_m : (n, 3) float64 — Vertices [m].
    coordinate_bits : Significant bits of the stored coordinates: 24 for float32, 53 for float64.
    extent_m : Size of the scene [m].
    stored_m : (n,) or one — Rounding seen in the vertices' files [m].
    """
    unit = 0.5**coordinate_bits
    floor = min(LENGTHS.place_m, 2.0 * unit * extent_m) + 0.5**50 * extent_m
    size = np.linalg.norm(vertices_m, axis=1)
    rounded = np.maximum(unit * np.minimum(size, extent_m), 0.5**FLOAT64_BITS * size)
    tolerance: FloatArray = 4.0 * np.maximum(rounded, stored_m) + floor
    return tolerance


def observed_rounding(coordinates: FloatArray) -> float:
    """Return how far [unit of the file] float32 has moved all corners (n, 3) at least; 0: not seen.

    Along one axis they are float32 numbers when all agree with one to some per cent of its last
    bit (what a text prints of it), and some have more digits than anyone types.

    Parameters
    ----------
    coordinates : (n, 3) float64 — Corners as the file holds them [unit of the file].
    """
    size = np.abs(coordinates)
    with np.errstate(over="ignore"):
        stored = coordinates.astype(np.float32)
    if len(coordinates) == 0 or not np.isfinite(stored).all():
        return 0.0
    last_bit = np.spacing(np.abs(stored).max(axis=0)).astype(np.float64)
    alike = (np.abs(coordinates - stored) <= PRINTED_SHARE * last_bit).all(axis=0)
    digits = size * 10.0 ** (TYPED_DIGITS - 1 - np.floor(np.log10(np.maximum(size, 1e-30))))
    typed = np.abs(digits - np.rint(digits)) < 1e-4
    seen = coordinates[:, alike & ~typed.all(axis=0)]
    return float(0.5**FLOAT32_BITS * np.linalg.norm(seen, axis=1).min())


def group_planes(
    vertices_m: FloatArray, faces: IntArray, tolerance_m: FloatArray | float
) -> IntArray:
    """Return the (t,) plane label of each triangle, by size of its largest one; -1 without area.

    From the largest triangle on, a plane grows over shared edges, fitted by least squares. A corner
    belongs when it is off the plane by at most its tolerance, times 1 at the plane's centre and 1
    more for every half width further out (a rounded triangle fixes a plane that much worse there),
    eight times at most; afterwards the same holds for every triangle against the final plane. So
    facets deviate from their triangles, and tilt, by what rounding explains only: a gently curved
    surface is not followed, however small its triangles. Separate pieces share a plane when the
    wider one's holds the other, three times the tolerance at most, and the other's own plane
    differs by no more than rounding; of dozens of nearly equal planes some may stay apart, which
    costs time but loses no path.

    Parameters
    ----------
    vertices_m : (n, 3) float64 — Vertices [m].
    faces : (t, 3) int64 — Triangles as indices of welded vertices.
    tolerance_m : (n,) or one — How far [m] rounding may have moved vertices off their planes.
    """
    tolerance = np.broadcast_to(np.asarray(tolerance_m, dtype=np.float64), (len(vertices_m),))
    tolerance = np.ascontiguousarray(tolerance)
    label = np.full(len(faces), -1, dtype=np.int64)
    area = triangle_area_vectors(vertices_m, faces)
    size = np.linalg.norm(area, axis=1)
    corners = vertices_m[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    flat = np.flatnonzero(size > 0.5 * tolerance[faces].max(axis=1, initial=0.0) * longest)
    if len(flat) == 0:
        return label
    normal = np.divide(area, size[:, None], out=np.zeros_like(area), where=size[:, None] > 0)
    edges = np.sort(np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2), axis=1)
    edge_of, edge_start, sides = row_numbers(edges)
    seeds = flat[np.argsort(-size[flat], kind="stable")]
    region, planes = _plane_kernels.grow_regions(
        seeds,
        *read_only((vertices_m, faces)),
        normal,
        2.0 * size >= SLIVER_ASPECT * longest**2,
        tolerance,
        edge_of.reshape(-1, 3),
        edge_start,
        sides // 3,
    )
    member = region[flat]
    region_tolerance = np.zeros(len(planes))
    np.maximum.at(region_tolerance, member, tolerance[faces[flat]].max(axis=1))
    low, high = vertices_m.min(axis=0), vertices_m.max(axis=0)
    radius = max(float(np.linalg.norm(high - low)), 1e-300)
    leader = _plane_kernels.merge_regions(planes, region_tolerance, 0.5 * (low + high), radius)
    label[flat] = leader[member]
    # Regions are numbered by their first seed; numbers that a larger one has taken over fall out.
    label[flat] = np.unique(label[flat], return_inverse=True)[1].reshape(-1)
    return label
