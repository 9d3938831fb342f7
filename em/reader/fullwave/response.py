"""The reader's response by the method of moments, as the rest of Octant takes it."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import GRID_SHAPE, ReaderResponse
from octant.em.antennas.kinds import Antenna
from octant.em.directions import angle_grid
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.loads import LoadedReader
from octant.em.reader.fullwave.mesh import (
    CELLS_PER_WAVELENGTH,
    FEED_GAP_M,
    WIRE_RADIUS_M,
    reader_mesh,
)
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.bodies import Body
from octant.geometries.errors import AntennaError
from octant.geometries.reader_body import ReaderBody

MODEL = "fullwave"
"""Name of the model [-]."""


def solved_reader(
    body: ReaderBody,
    antenna: Antenna,
    *,
    gap_m: float = 0.005,
    load_ohm: npt.ArrayLike = 50.0,
    cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    wire_radius_m: float = WIRE_RADIUS_M,
    feed_gap_m: float = FEED_GAP_M,
    graded_tips: bool = True,
    surroundings: Sequence[Body] = (),
    conductor: Conductor | None = None,
    symmetry: bool = True,
) -> FullwaveResult:
    """Return the full-wave solution of a reader.

    Parameters
    ----------
    body : Ground plane, plates and the places of the antennas.
    antenna : One element, an upright dipole or monopole; its frequency and length are used.
    gap_m : Height of a dipole's lower end, or of a monopole's own plane, above the ground plane
        [m].
    load_ohm : Impedance of source and load of every port [ohm].
    cells_per_wavelength : Elements per wavelength [-]; 10 for design, 14 for final figures.
    wire_radius_m : Radius of the antennas' wire [m].
    feed_gap_m : Length of the feed [m]; 0 is a delta gap.
    graded_tips : Cut the strips' last cells finer; see `reader_mesh`.
    surroundings : Further perfectly conducting meshes in the reader frame.
    conductor : What the reader is made of; None: perfect metal.
    symmetry : Use the rotational symmetry that the mesh has.

    Notes
    -----
    Mutual coupling, mismatch to the loads, diffraction at all edges and currents on the plates are
    in the patterns. Tag and room are not included.
    """
    if antenna.kind not in {"dipole", "monopole"} or abs(antenna.axis[2]) < 1.0 - 1e-12:
        msg = (
            f"antenna {antenna.kind!r} of axis {antenna.axis.tolist()} has no full-wave mesh; give "
            "an upright dipole or monopole."
        )
        raise AntennaError(msg)
    mesh = reader_mesh(
        body,
        frequency_hz=antenna.frequency_hz,
        antenna="monopole" if antenna.kind == "monopole" else "dipole",
        length_m=antenna.length_m,
        gap_m=gap_m,
        cells_per_wavelength=cells_per_wavelength,
        wire_radius_m=wire_radius_m,
        feed_gap_m=feed_gap_m,
        graded_tips=graded_tips,
        surroundings=surroundings,
        conductor=conductor,
    )
    return solve_reader(mesh, load_ohm=load_ohm, symmetry=symmetry)


def response_of(result: LoadedReader, body: ReaderBody) -> ReaderResponse:
    """Return the patterns of a solution on the grid that radio maps read.

    Parameters
    ----------
    result : Solution.
    body : Gives the antennas' azimuths.
    """
    theta, phi = angle_grid(*GRID_SHAPE)
    pattern = np.moveaxis(result.pattern_grid(theta, len(phi)), -1, 1)
    return ReaderResponse.from_centre(
        pattern,
        model=MODEL,
        frequency_hz=result.frequency_hz,
        azimuths_rad=body.element_azimuths_rad,
        phase_centres_m=result.unloaded.phase_centres_m,
        warnings=result.warnings,
    )
