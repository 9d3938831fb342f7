"""Random build errors: one reader from the table ``[tolerance]``, seed and number alone.

Samples are independent of each other: intervals of shares and quantiles hold as they stand, more
samples keep the first ones, and neither order nor number of workers matters. (Latin hypercubes and
antithetic pairs would have neither the first nor the second.)
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.build_errors import BuildErrors, common_errors, tilt_of_lean
from octant.reader_design.study_file.tolerance import Tolerance

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Deviation:
    """How a built reader and its room differ from the drawing; factors are over the study's values.

    Parameters
    ----------
    build : Errors of the reader ([m], [rad]).
    frequency_factor, conductivity_factor : Of the frequency; of the room's materials [-].
    permittivity_factor : Of the materials' relative permittivity less one [-].
    """

    build: BuildErrors
    frequency_factor: float = 1.0
    permittivity_factor: float = 1.0
    conductivity_factor: float = 1.0


def as_drawn(antennas: int) -> Deviation:
    """Return the deviation of a reader and a room that are as drawn: none.

    Parameters
    ----------
    antennas : Number of antennas.
    """
    return Deviation(build=common_errors(antennas))


def drawn_deviation(
    tolerance: Tolerance, *, antennas: int, antenna_radius_m: float, seed: int, index: int
) -> Deviation:
    """Return the deviation of one sample ([m], [rad]), the same for designs of as many antennas.

    Every error is drawn, zero sizes too, so that changing one size leaves the others' draws alone.

    Parameters
    ----------
    tolerance : Sizes of the errors ([m], [deg], [%]) and their distribution.
    antennas : Number of antennas.
    antenna_radius_m : r_a [m]; an error sideways turns the antenna's azimuth by its share of it.
    seed, index : Seed of the study; number of the sample, from 0.
    """
    random = np.random.default_rng([seed, index])
    if tolerance.distribution == "uniform":
        units = random.uniform(-1.0, 1.0, (8, antennas))
        shared = random.uniform(-1.0, 1.0, 8)
    else:
        units = random.standard_normal((8, antennas))
        shared = random.standard_normal(8)
    angle = math.radians(tolerance.angle_deg)
    tilt, towards = tilt_of_lean(np.tan(np.clip(angle * units[4:6].T, -1.5, 1.5)))
    own = BuildErrors(
        radial_m=tolerance.position_m * units[0],
        azimuth_rad=tolerance.position_m / antenna_radius_m * units[1],
        gap_m=tolerance.gap_m * units[2],
        length_m=tolerance.antenna_length_m * units[3],
        tilt_rad=tilt,
        tilt_azimuth_rad=towards,
        plate_azimuth_rad=angle * units[6],
        plate_height_m=tolerance.plate_height_m * units[7],
        ground_plane_m=tolerance.ground_plane_m * float(shared[0]),
    )
    common = common_errors(
        antennas,
        radial_m=tolerance.common.antenna_radius_m * float(shared[1]),
        gap_m=tolerance.common.gap_m * float(shared[2]),
        length_m=tolerance.common.antenna_length_m * float(shared[3]),
        plate_height_m=tolerance.common.plate_height_m * float(shared[4]),
    )
    return Deviation(
        build=own.plus(common),
        frequency_factor=_factor(tolerance.frequency_percent, shared[5]),
        permittivity_factor=_factor(tolerance.permittivity_percent, shared[6]),
        conductivity_factor=_factor(tolerance.conductivity_percent, shared[7]),
    )


def _factor(percent: float, unit: float) -> float:
    """Return one plus an error, kept above zero whatever a normal draw brings."""
    return max(1.0 + 0.01 * percent * float(unit), 0.01)


def regressors(
    deviations: list[Deviation], antenna_radius_m: float
) -> tuple[tuple[str, ...], FloatArray]:
    """Return names and (s, p) values ([mm], [deg], [-]) of what scores can depend on by symmetry.

    Antennas are interchangeable but for the ground plane's corners, so that to first order a
    smooth score follows the mean of each kind of error, and to second order its scatter over
    antennas. Columns that never change are left out.

    Parameters
    ----------
    deviations : Samples.
    antenna_radius_m : r_a [m], by which azimuth errors become lengths.
    """
    table: dict[str, list[float]] = {}

    def add(name: str, value: float) -> None:
        table.setdefault(name, []).append(value)

    for deviation in deviations:
        build = deviation.build
        lean = np.degrees(np.arctan(build.lean))
        for name, values in (
            ("antenna away from the axis", 1e3 * build.radial_m),
            ("antenna sideways", 1e3 * antenna_radius_m * build.azimuth_rad),
            ("gap", 1e3 * build.gap_m),
            ("antenna length", 1e3 * build.length_m),
            ("lean away from the axis", lean[:, 0]),
            ("lean sideways", lean[:, 1]),
            ("plate azimuth", np.degrees(build.plate_azimuth_rad)),
            ("plate height", 1e3 * build.plate_height_m),
        ):
            add(f"{name}: mean", float(values.mean()))
            add(f"{name}: scatter", float(values.std()))
        add("ground plane: mean", 1e3 * build.ground_plane_m)
        add("frequency: mean", deviation.frequency_factor)
        add("permittivity: mean", deviation.permittivity_factor)
        add("conductivity: mean", deviation.conductivity_factor)
    kept = {
        n: v for n, v in table.items() if np.ptp(v) > 1e-12 * max(1.0, float(np.max(np.abs(v))))
    }
    return tuple(kept), np.column_stack([np.zeros((len(deviations), 0)), *kept.values()])
