"""Where the antennas and plates of a reader stand as built."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import FloatArray
from octant.geometries._reader_mesh import reach_to_rim_m
from octant.geometries.build_errors import BuildErrors
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BuiltPlaces:
    """Places in the reader frame as built; the drawing's own where there are no errors.

    Parameters
    ----------
    element_azimuths_rad : (n,) float64 — Azimuth of each antenna's foot [rad].
    element_radii_m : (n,) float64 — Its distance from the axis [m].
    plate_azimuths_rad : (n,) or (0,) float64 — Azimuth of each plate [rad].
    plate_reaches_m, plate_rim_heights_m : (n,) or (0,) float64 — Each plate's outer end: distance
        from the axis, height [m].
    plate_axis_height_m : Height of all plates at the axis [m].
    plate_profiles_m : (n, k) float64 — Each plate's heights at even distances between axis and
        outer end [m].
    rim_scale : Size of the ground plane over the drawn one [-].
    """

    element_azimuths_rad: FloatArray
    element_radii_m: FloatArray
    plate_azimuths_rad: FloatArray
    plate_reaches_m: FloatArray
    plate_rim_heights_m: FloatArray
    plate_axis_height_m: float
    plate_profiles_m: FloatArray
    rim_scale: float = 1.0

    def __post_init__(self) -> None:
        elements, plates = len(self.element_azimuths_rad), len(self.plate_azimuths_rad)
        for name, count in (
            ("element_azimuths_rad", elements),
            ("element_radii_m", elements),
            ("plate_azimuths_rad", plates),
            ("plate_reaches_m", plates),
            ("plate_rim_heights_m", plates),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=(count,))
            object.__setattr__(self, name, value)
        profiles = frozen_array(
            self.plate_profiles_m, name="plate_profiles_m", shape=(plates, None)
        )
        object.__setattr__(self, "plate_profiles_m", profiles)

    def plate_heights_m(self, plate: int) -> FloatArray:
        """Return (k + 2,) a plate's heights at even distances from the axis to its outer end [m].

        Parameters
        ----------
        plate : Which one, from 0.
        """
        ends = [self.plate_axis_height_m], [self.plate_rim_heights_m[plate]]
        return np.concatenate((ends[0], self.plate_profiles_m[plate], ends[1]))


def built_places(
    drawn: BuiltPlaces,
    errors: BuildErrors | None,
    *,
    rim_m: FloatArray,
    ground_plane_m: float,
    is_round: bool,
) -> BuiltPlaces:
    """Return where things stand with errors added ([m], [rad]).

    Parameters
    ----------
    drawn : The drawing.
    errors : What is built less what is drawn; None, or zeros: as drawn.
    rim_m : (k, 2) float64 — Corners of the drawn ground plane's rim, counter-clockwise [m].
    ground_plane_m : Drawn side or diameter of the ground plane [m].
    is_round : Whether the rim stands for a circle: plates on it keep their distance from the axis.
    """
    if errors is None:
        return drawn
    antennas = len(drawn.element_azimuths_rad)
    if errors.antennas != antennas:
        msg = (
            f"errors are those of {errors.antennas} antennas, but the reader has {antennas}; give "
            "one value for each antenna."
        )
        raise GeometryError(msg)
    if errors.is_zero:
        return drawn
    scale = 1.0 + errors.ground_plane_m / ground_plane_m
    if scale <= 0.0:
        msg = (
            f"the ground plane of {ground_plane_m:g} m cannot be {-errors.ground_plane_m:g} m "
            "smaller; give a smaller error."
        )
        raise GeometryError(msg)
    elements = drawn.element_azimuths_rad + errors.azimuth_rad
    radii = drawn.element_radii_m + errors.radial_m
    _refuse_any(radii <= 0.0, "antenna", "would stand on the axis or beyond it")
    if not len(drawn.plate_azimuths_rad):
        return replace(drawn, element_azimuths_rad=elements, element_radii_m=radii, rim_scale=scale)
    plates = drawn.plate_azimuths_rad + errors.plate_azimuth_rad
    drawn_rim = reach_to_rim_m(drawn.plate_azimuths_rad, rim_m)
    rim = scale * (drawn_rim if is_round else reach_to_rim_m(plates, rim_m))
    at_rim = drawn.plate_reaches_m >= drawn_rim * (1.0 - LENGTHS.same_share)
    reaches = np.where(at_rim, rim, drawn.plate_reaches_m)
    _refuse_any(reaches > rim, "plate", "would end beyond the ground plane")
    rim_heights = _heights(drawn.plate_rim_heights_m, errors.plate_height_m)
    mean = np.array([errors.plate_height_m.mean()])
    axis_height = float(_heights(np.array([drawn.plate_axis_height_m]), mean)[0])
    inner = drawn.plate_profiles_m.shape[1]
    share = np.arange(1, inner + 1) / (inner + 1)
    between = mean * (1.0 - share) + errors.plate_height_m[:, None] * share
    _refuse_disorder(elements, plates)
    return BuiltPlaces(
        element_azimuths_rad=elements,
        element_radii_m=radii,
        plate_azimuths_rad=plates,
        plate_reaches_m=reaches,
        plate_rim_heights_m=rim_heights,
        plate_axis_height_m=axis_height,
        plate_profiles_m=_heights(drawn.plate_profiles_m, between),
        rim_scale=scale,
    )


def _heights(drawn_m: FloatArray, error_m: FloatArray) -> FloatArray:
    """Return heights as built; those of zero stay, others must not become zero."""
    built: FloatArray = np.where(drawn_m > 0.0, drawn_m + error_m, 0.0)
    _refuse_any((drawn_m > 0.0) & (built <= 0.0), "plate", "would have no height")
    return built


def _refuse_any(wrong: npt.NDArray[np.bool_], what: str, why: str) -> None:
    if wrong.any():
        msg = (
            f"{what} {int(np.flatnonzero(wrong)[0]) + 1} {why} with its build error; give smaller "
            "errors, or change the design."
        )
        raise GeometryError(msg)


def _refuse_disorder(elements_rad: FloatArray, plates_rad: FloatArray) -> None:
    """Raise unless plate i stands between antennas i and i + 1."""
    order = np.column_stack((elements_rad, plates_rad)).ravel()
    steps = np.diff(np.append(order, order[0] + 2.0 * math.pi))
    wrong = np.flatnonzero(steps <= 0.0)
    if wrong.size:
        at = int(wrong[0])
        antenna = (at // 2 + at % 2) % len(elements_rad) + 1
        msg = (
            f"antenna {antenna} would stand on or beyond plate {at // 2 + 1} with its build "
            "error; give smaller errors, or change the design."
        )
        raise GeometryError(msg)
