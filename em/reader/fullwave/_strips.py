"""Antennas as upright strips, two triangles a cell; a grounded strip's foot is part of a sheet."""

import math
from dataclasses import dataclass

import numpy as np

from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries._reader_mesh import reach_to_rim_m
from octant.geometries.tolerances import LENGTHS

CELLS_OF_HALF_WAVE = 24
"""Even cells along a strip of half a wavelength at up to 14 elements per wavelength [-]."""

TIP_CUTS = (0.25, 0.6)
"""Where the cell at a free tip is cut [-] when tips are graded."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Strip:
    """An upright strip across the radius; ``foot_m`` (3, 3) is right, middle and left at its foot.

    Right is towards smaller azimuth. The foot's middle is a vertex of the strip when grounded.
    ``graded`` cuts the cells at free tips finer.
    """

    foot_m: FloatArray
    length_m: float
    cells: int
    grounded: bool
    graded: bool = False

    @classmethod
    def upright(
        cls,
        azimuth_rad: float,
        *,
        antenna_radius_m: float,
        bottom_m: float,
        length_m: float,
        width_m: float,
        cells: int,
        grounded: bool,
        graded: bool,
        rim_m: FloatArray | None,
    ) -> "Strip":
        """Return an antenna's strip; with ``rim_m`` its foot follows the rim if it is on it."""
        radial = np.array((math.cos(azimuth_rad), math.sin(azimuth_rad)))
        across = np.array((-radial[1], radial[0]))
        middle = antenna_radius_m * radial
        foot = np.array([middle - 0.5 * width_m * across, middle, middle + 0.5 * width_m * across])
        if rim_m is not None:
            reach = float(reach_to_rim_m(np.array([azimuth_rad]), rim_m)[0])
            if antenna_radius_m >= reach * (1.0 - LENGTHS.same_share):
                foot = np.array(
                    [
                        along_rim(rim_m, azimuth_rad, -0.5 * width_m),
                        middle,
                        along_rim(rim_m, azimuth_rad, 0.5 * width_m),
                    ]
                )
        return cls(
            foot_m=np.column_stack((foot, np.full(3, bottom_m))),
            length_m=length_m,
            cells=cells,
            grounded=grounded,
            graded=graded,
        )

    @property
    def middle_line_m(self) -> FloatArray:
        """Return (2, 3) lower and upper end of the middle line [m]."""
        return np.array((self.foot_m[1], self.foot_m[1] + np.array((0.0, 0.0, self.length_m))))


def along_rim(rim_m: FloatArray, azimuth_rad: float, distance_m: float) -> FloatArray:
    """Return the point of a convex rim at a short signed distance from where a spoke meets it."""
    reach = float(reach_to_rim_m(np.array([azimuth_rad]), rim_m)[0])
    start = reach * np.array((math.cos(azimuth_rad), math.sin(azimuth_rad)))
    angles = np.mod(np.arctan2(rim_m[:, 1], rim_m[:, 0]) - azimuth_rad, 2.0 * math.pi)
    small = LENGTHS.same_share
    if distance_m > 0.0:
        ahead = np.where(angles < small, angles + 2.0 * math.pi, angles)
        corner = rim_m[np.argmin(ahead)]
    else:
        behind = np.where(angles > 2.0 * math.pi - small, angles - 2.0 * math.pi, angles)
        corner = rim_m[np.argmax(np.where(behind < small, -1.0, behind))]
    direction = (corner - start) / np.linalg.norm(corner - start)
    point: FloatArray = start + abs(distance_m) * direction
    return point


def strip_cells(length_m: float, wavelength_m: float, cells_per_wavelength: float) -> int:
    """Return the number of cells along a strip, without the cuts at its tips; it is even."""
    half_wave = CELLS_OF_HALF_WAVE * max(1.0, cells_per_wavelength / 14.0)
    return 2 * max(2, round(half_wave * length_m / wavelength_m))


def strip_triangles(strip: Strip) -> tuple[FloatArray, IntArray]:
    """Return vertices (v, 3) [m] and triangles (f, 3) [-] of a strip.

    Diagonals change direction half-way up, so that a dipole is the same above and below.
    """
    even = np.linspace(0.0, strip.length_m, strip.cells + 1)
    cuts = even[1] * np.array(TIP_CUTS if strip.graded else ())
    tips = (strip.length_m - cuts,) if strip.grounded else (cuts, strip.length_m - cuts)
    height = np.sort(np.concatenate((even, *tips)))
    cells = len(height) - 1
    rise = np.column_stack((np.zeros((cells + 1, 2)), height))
    right, left = strip.foot_m[0] + rise, strip.foot_m[2] + rise
    vertices = np.stack((right, left), axis=1).reshape(-1, 3)
    faces = []
    for c in range(cells):
        r0, l0, r1, l1 = 2 * c, 2 * c + 1, 2 * c + 2, 2 * c + 3
        if c == 0 and strip.grounded:
            middle = len(vertices)
            faces += [(r0, middle, r1), (middle, l1, r1), (middle, l0, l1)]
        elif c < cells // 2:
            faces += [(r0, l0, l1), (r0, l1, r1)]
        else:
            faces += [(r0, l0, r1), (l0, l1, r1)]
    if strip.grounded:
        vertices = np.concatenate((vertices, strip.foot_m[1:2]))
    return vertices, np.array(faces, dtype=np.int64)
