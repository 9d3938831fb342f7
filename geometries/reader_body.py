"""The reader's body: ground plane, plates and element places, as one mesh of sheets.

Reader frame: origin at the centre of the ground plane's upper side, z up, antenna i = 1 ... n at
azimuth (i - 1) 2 pi / n from +x towards +y; plates half-way between. Sheets have no thickness.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number
from octant.geometries._plane_geometry import FloatArray
from octant.geometries._polygons import mesh_of_triangles
from octant.geometries._reader_mesh import (
    ground_triangles,
    plate_triangles,
    reach_to_rim_m,
)
from octant.geometries.bodies import Body
from octant.geometries.build_errors import BuildErrors
from octant.geometries.built_places import BuiltPlaces, built_places
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS

GroundPlaneShape = Literal["square", "round", "octagon"]
GROUND_PLANE_SHAPES: tuple[GroundPlaneShape, ...] = ("square", "round", "octagon")
"""Shapes that a ground plane may have [-]."""

MIN_ROUND_SIDES = 32
"""Least number of sides of the polygon that stands for a round ground plane [-]."""

MONOPOLE_PLANE_MARGIN_M = 0.001
"""Clearance that a monopole's own plane keeps from the plates [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReaderBody:
    """A reader's metal body, as `reader_body` builds it.

    Parameters
    ----------
    antennas : Number of antennas n, at least 3.
    antenna_radius_m : Distance of the antennas from the axis, r_a [m].
    plate_height_m, plate_height_axis_m : Height of the plates at outer end, h_p, and axis [m].
    plate_profile_m : Heights of the plates at even distances between axis and outer end [m].
    plate_outer_radius_m : Distance of the plates' outer end from the axis [m].
    ground_plane_m : Side of a square, diameter of a round, width across flats of an octagon [m].
    ground_plane_shape : "square", "round" or "octagon".
    monopole_plane_m : Wanted side of the square plane under each monopole [m]; 0: none of its own.
    element_azimuths_rad, plate_azimuths_rad : (n,) float64 — Azimuths as drawn [rad]; (0,): none.
    body : The sheets as one mesh [m], in the reader frame. Plates share vertices with the ground
        plane and with each other; the antennas' feet are vertices too.
    built : Azimuths [rad], distances and heights [m] of antennas and plates as built.
    errors : Built less drawn, in ``built``, ``body`` and ``element_feet_m`` only. None: as drawn.
    """

    antennas: int
    antenna_radius_m: float
    plate_height_m: float
    plate_height_axis_m: float
    plate_profile_m: tuple[float, ...]
    plate_outer_radius_m: float
    ground_plane_m: float
    ground_plane_shape: GroundPlaneShape
    monopole_plane_m: float
    element_azimuths_rad: npt.NDArray[np.float64]
    plate_azimuths_rad: npt.NDArray[np.float64]
    body: Body
    built: BuiltPlaces
    errors: BuildErrors | None = None

    def __post_init__(self) -> None:
        for name in ("element_azimuths_rad", "plate_azimuths_rad"):
            value = frozen_array(getattr(self, name), name=name, shape=(None,))
            object.__setattr__(self, name, value)
        if len(self.element_azimuths_rad) != self.antennas:
            msg = (
                f"element_azimuths_rad has {len(self.element_azimuths_rad)} values, but the reader "
                f"has {self.antennas} antennas."
            )
            raise GeometryError(msg)

    @property
    def has_plates(self) -> bool:
        """Whether any plate stands on the ground plane."""
        return len(self.plate_azimuths_rad) > 0

    @property
    def plate_outline_m(self) -> npt.NDArray[np.float64]:
        """(k + 2, 2) the plates' upper edge: distance from the axis, height as drawn [m]."""
        heights = (self.plate_height_axis_m, *self.plate_profile_m, self.plate_height_m)
        away = np.linspace(0.0, self.plate_outer_radius_m, len(heights))
        outline: npt.NDArray[np.float64] = np.column_stack((away, heights))
        return outline

    @property
    def element_feet_m(self) -> npt.NDArray[np.float64]:
        """(n, 3) points of the ground plane's upper side below the antennas, reader frame [m]."""
        delta = self.built.element_azimuths_rad
        flat = np.zeros(self.antennas)
        feet: npt.NDArray[np.float64] = self.built.element_radii_m[:, None] * np.column_stack(
            (np.cos(delta), np.sin(delta), flat)
        )
        return feet

    @property
    def fitted_monopole_plane_m(self) -> float:
        """Side of the square plane that fits under each monopole, see the function [m]."""
        return fitted_monopole_plane_m(
            self.monopole_plane_m,
            antenna_radius_m=self.antenna_radius_m,
            antennas=self.antennas,
        )


def reader_body(
    *,
    antenna_radius_m: float = 0.10,
    plate_height_m: float = 0.08,
    plate_height_axis_m: float | None = None,
    plate_profile_m: Sequence[float] = (),
    plate_outer_radius_m: float | None = None,
    ground_plane_m: float = 0.20,
    ground_plane_shape: GroundPlaneShape = "square",
    antennas: int = 8,
    monopole_plane_m: float = 0.0,
    material: str = "pec",
    name: str = "reader",
    errors: BuildErrors | None = None,
) -> ReaderBody:
    """Return the body of a reader; the defaults are the thesis' choice (section 5.3, figure 5.1).

    Parameters
    ----------
    antenna_radius_m : Distance of antennas from the axis, r_a [m], on the plane or its edge.
    plate_height_m : Height of the plates at their outer end, h_p [m].
    plate_height_axis_m : Height at the axis [m]; None: `plate_height_m`. Both 0: no plates.
    plate_profile_m : Heights at even distances between axis and outer end [m]; none: straight.
    plate_outer_radius_m : Their outer end's distance from the axis [m]; None: `ground_plane_m` / 2.
    ground_plane_m : Side of a square, diameter of a round, width across flats of an octagon [m].
    ground_plane_shape : "square": sides along x' and y'. "octagon": flats face antennas 1, 3, 5, 7
        of 8 and half-way. "round": regular polygon inscribed in the circle, of at least 32 sides
        (99.4 % of its area), a multiple of 2 n: a turn by an antenna maps it onto itself.
    antennas : Number of antennas, at least 3.
    monopole_plane_m : Side of the square plane under each monopole [m], not in the mesh; 0: none.
    material : Label of the sheets' material.
    name : Name of the body.
    errors : Built less drawn; None: as drawn. With errors a dipole may stand beyond the rim.
    """
    if not isinstance(antennas, int) or antennas < 3:
        msg = f"antennas is {antennas!r}, but a reader needs a whole number of at least 3."
        raise GeometryError(msg)
    if ground_plane_shape not in GROUND_PLANE_SHAPES:
        listed = ", ".join(repr(s) for s in GROUND_PLANE_SHAPES)
        msg = f"ground_plane_shape is {ground_plane_shape!r}, but it must be one of {listed}."
        raise GeometryError(msg)
    side = positive_number(ground_plane_m, name="ground_plane_m")
    radius = positive_number(antenna_radius_m, name="antenna_radius_m")
    rim_height = positive_number(plate_height_m, name="plate_height_m", allow_zero=True)
    axis_height = rim_height
    if plate_height_axis_m is not None:
        axis_height = positive_number(
            plate_height_axis_m, name="plate_height_axis_m", allow_zero=True
        )
    reach = 0.5 * side
    if plate_outer_radius_m is not None:
        reach = positive_number(plate_outer_radius_m, name="plate_outer_radius_m")
    plane = positive_number(monopole_plane_m, name="monopole_plane_m", allow_zero=True)
    rim = ground_plane_outline_m(side, shape=ground_plane_shape, antennas=antennas)
    elements = 2.0 * math.pi * np.arange(antennas) / antennas
    profile = tuple(positive_number(h, name="plate_profile_m") for h in plate_profile_m)
    _refuse_profile((axis_height, *profile, rim_height))
    has_plates = max(rim_height, axis_height) > 0.0
    plates = elements + math.pi / antennas if has_plates else np.zeros(0)
    _refuse_overhang(radius, elements, rim, of="antenna_radius_m")
    _refuse_overhang(reach, plates, rim, of="plate_outer_radius_m")
    built = built_places(
        BuiltPlaces(
            element_azimuths_rad=elements,
            element_radii_m=np.full(antennas, radius),
            plate_azimuths_rad=plates,
            plate_reaches_m=np.full(len(plates), reach),
            plate_rim_heights_m=np.full(len(plates), rim_height),
            plate_axis_height_m=axis_height,
            plate_profiles_m=np.tile(profile, (len(plates), 1)),
        ),
        errors,
        rim_m=rim,
        ground_plane_m=side,
        is_round=ground_plane_shape == "round",
    )
    result = ReaderBody(
        antennas=antennas,
        antenna_radius_m=radius,
        plate_height_m=rim_height,
        plate_height_axis_m=axis_height,
        plate_profile_m=profile,
        plate_outer_radius_m=reach,
        ground_plane_m=side,
        ground_plane_shape=ground_plane_shape,
        monopole_plane_m=plane,
        element_azimuths_rad=elements,
        plate_azimuths_rad=plates,
        body=_sheets(built, rim, name=name, material=material),
        built=built,
        errors=None if errors is None or errors.is_zero else errors,
    )
    _ = result.fitted_monopole_plane_m  # raises when no plane fits at all
    return result


def _sheets(built: BuiltPlaces, rim_m: FloatArray, *, name: str, material: str) -> Body:
    """Return ground plane and plates as built, as one mesh."""
    rim = built.rim_scale * rim_m
    ends = reach_to_rim_m(built.plate_azimuths_rad, rim) if len(built.plate_azimuths_rad) else 0.0
    # A plate beyond the rim by more than rounding is one on the polygon of a round plane.
    over = built.plate_reaches_m > ends * (1.0 + LENGTHS.same_share)
    reaches = np.where(over, ends, built.plate_reaches_m)
    triangles = ground_triangles(
        rim, built.element_radii_m, built.element_azimuths_rad, reaches, built.plate_azimuths_rad
    )
    triangles += plate_triangles(
        reaches,
        built.plate_azimuths_rad,
        heights_m=[built.plate_heights_m(i) for i in range(len(reaches))],
    )
    vertices, faces = mesh_of_triangles(np.array(triangles))
    return Body(name=name, vertices_m=vertices, faces=faces, material=material)


def _refuse_profile(heights_m: tuple[float, ...]) -> None:
    """Raise for heights from axis to outer end that no plate of several heights can have."""
    inner = len(heights_m) - 2
    if not inner:
        return
    if min(heights_m) <= 0.0:
        msg = (
            "plate_profile_m is given, but the plates have no height at the axis or at their outer "
            "end; give plate_height_m and plate_height_axis_m above 0."
        )
        raise GeometryError(msg)
    for j in range(1, inner + 1):
        if heights_m[j + 1] * j >= heights_m[j] * (j + 1):
            msg = (
                f"plate_profile_m rises from {heights_m[j]:g} to {heights_m[j + 1]:g} m more "
                "steeply than a line from the foot of the axis; make it rise less."
            )
            raise GeometryError(msg)


def ground_plane_outline_m(
    ground_plane_m: float, *, shape: GroundPlaneShape, antennas: int
) -> npt.NDArray[np.float64]:
    """Return the (k, 2) corners of a ground plane's rim, counter-clockwise [m].

    Parameters
    ----------
    ground_plane_m : Side of a square, diameter of a round, width across flats of an octagon [m].
    shape : "square", "round" or "octagon".
    antennas : Number of antennas, which sets the number of sides of a round plane.
    """
    half = 0.5 * ground_plane_m
    if shape == "square":
        return half * np.array([(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)])
    if shape == "octagon":
        angle = 0.25 * math.pi * (np.arange(8) + 0.5)
        half /= math.cos(math.pi / 8)
    else:
        step = 2 * antennas
        sides = step * math.ceil(MIN_ROUND_SIDES / step)
        angle = 2.0 * math.pi * np.arange(sides) / sides
    return half * np.column_stack((np.cos(angle), np.sin(angle)))


def fitted_monopole_plane_m(
    monopole_plane_m: float,
    *,
    antenna_radius_m: float,
    antennas: int = 8,
    margin_m: float = MONOPOLE_PLANE_MARGIN_M,
) -> float:
    """Return the side of the square plane under each monopole [m]: as wanted, or what fits.

    Centred there, two sides along the radius, and larger by the margin on all sides, it must not
    cross the half-planes half-way between neighbours, where the plates stand (or the neighbour's
    plane). With alpha = pi / n, a growing square first touches one at its inner corner, when half
    its side is r_a sin(alpha) / (sin(alpha) + cos(alpha)): 14.6 mm for r_a = 50 mm and n = 8, so
    that the thesis' planes of 40 mm cannot stand there.

    Parameters
    ----------
    monopole_plane_m : Wanted side [m]; 0 stays 0.
    antenna_radius_m : Distance of the antennas from the axis, r_a [m].
    antennas : Number of antennas n, at least 3.
    margin_m : Clearance to keep on all sides [m].
    """
    asked = positive_number(monopole_plane_m, name="monopole_plane_m", allow_zero=True)
    radius = positive_number(antenna_radius_m, name="antenna_radius_m")
    margin = positive_number(margin_m, name="margin_m", allow_zero=True)
    if asked == 0.0:
        return 0.0
    alpha = math.pi / antennas
    largest = 2.0 * (radius * math.sin(alpha) / (math.sin(alpha) + math.cos(alpha)) - margin)
    if largest <= 0.0:
        msg = (
            f"monopole_plane_m is {asked:g} m, but between the plates no plane fits at "
            f"antenna_radius_m = {radius:g} m with {margin:g} m to spare; move the antennas out, "
            "or give 0."
        )
        raise GeometryError(msg)
    return min(asked, largest)


def _refuse_overhang(
    radius_m: float, azimuths_rad: FloatArray, rim_m: FloatArray, *, of: str
) -> None:
    """Raise when a place at a radius and one of the azimuths lies beyond the rim."""
    if len(azimuths_rad) == 0:
        return
    distance = reach_to_rim_m(azimuths_rad, rim_m)
    worst = int(np.flatnonzero(distance <= distance.min() * (1.0 + LENGTHS.same_share))[0])
    if radius_m > distance[worst] * (1.0 + LENGTHS.same_share):
        msg = (
            f"{of} is {radius_m:g} m, but the ground plane ends {distance[worst]:.4g} m from its "
            f"centre at azimuth {math.degrees(azimuths_rad[worst]):g} deg; make it smaller, or "
            "ground_plane_m larger."
        )
        raise GeometryError(msg)
