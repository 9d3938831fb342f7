"""A band of frequencies from a handful of solutions, interpolated."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave._circuit import admittance_of, embedded_voltages
from octant.em.reader.fullwave.mesh import ReaderMesh
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.solve import result_of, solve_reader
from octant.geometries._checks import positive_number
from octant.geometries.errors import AntennaError

NODES = 4
"""Default number of solutions across a band [-]; enough for a few per cent of bandwidth."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FullwaveBand:
    """Solutions of one mesh at several frequencies, and everything in between.

    Parameters
    ----------
    results : Solutions in order of frequency, same mesh and loads; at least two.
    """

    results: tuple[FullwaveResult, ...]

    def __post_init__(self) -> None:
        frequencies = self.frequencies_hz
        if len(frequencies) < 2 or not (np.diff(frequencies) > 0.0).all():
            msg = (
                f"a band has solutions at {frequencies.tolist()} Hz, but at least two of rising "
                "frequency are needed."
            )
            raise AntennaError(msg)

    @property
    def frequencies_hz(self) -> npt.NDArray[np.float64]:
        """Return (k,) the frequencies that were solved [Hz]."""
        return np.array([result.frequency_hz for result in self.results])

    def at(self, frequency_hz: float) -> FullwaveResult:
        """Return the interpolated solution at a frequency of the band.

        Parameters
        ----------
        frequency_hz : Frequency [Hz], from the first to the last one solved.

        Returns
        -------
        FullwaveResult
            Matrices and currents by interpolation, patterns from the currents at that frequency;
            ``balance_error`` shows what the interpolation is worth.

        Notes
        -----
        Polynomials through all solutions, of the scattering matrix and of the currents with all
        ports loaded: loads damp the resonances that the bare admittances have.
        """
        nodes = self.frequencies_hz
        if not nodes[0] * (1 - 1e-12) <= frequency_hz <= nodes[-1] * (1 + 1e-12):
            msg = (
                f"frequency_hz is {frequency_hz:g} Hz, but the band was solved from "
                f"{nodes[0]:g} to {nodes[-1]:g} Hz; solve a wider band."
            )
            raise AntennaError(msg)
        weights = [math.prod((frequency_hz - o) / (n - o) for o in nodes if o != n) for n in nodes]
        first = self.results[0]
        load = first.load_ohm
        s_matrix = sum(w * r.s_matrix for w, r in zip(weights, self.results, strict=True))
        loaded = sum(
            w * np.tensordot(r.embedded_voltages_v, r.halves_a_per_m, axes=(1, 0))
            for w, r in zip(weights, self.results, strict=True)
        )
        admittance = admittance_of(np.asarray(s_matrix), load)
        back = np.linalg.inv(embedded_voltages(admittance, load))
        halves = np.tensordot(back, loaded, axes=(1, 0))
        return result_of(
            first.basis,
            halves,
            admittance,
            frequency_hz=frequency_hz,
            load_ohm=load,
            sheet_ohm=first.sheet_ohm,
            port_step=first.port_step,
            phase_centres_m=first.unloaded.phase_centres_m,
            doubts=first.unloaded.doubts,
        )


def solve_band(
    mesh: ReaderMesh,
    frequencies_hz: Sequence[float],
    *,
    nodes: int = NODES,
    load_ohm: npt.ArrayLike = 50.0,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
    symmetry: bool = True,
) -> FullwaveBand:
    """Return solutions from which those at all given frequencies follow by interpolation.

    Parameters
    ----------
    mesh : Triangles and feeds, one mesh for the whole band.
    frequencies_hz : Frequencies wanted [Hz]; their least and greatest bound the band.
    nodes : Number of solutions, at least 2; no more are made than there are frequencies.
    load_ohm : Impedance of source and load of every port [ohm].
    surface_impedance_ohm : Surface impedance of each triangle [ohm].
    symmetry : Use the rotational symmetry that the mesh has.

    Returns
    -------
    FullwaveBand
        Solutions at the extrema of a Chebyshev polynomial, the band's ends included.
    """
    wanted = sorted({positive_number(f, name="frequencies_hz", unit="Hz") for f in frequencies_hz})
    if nodes < 2 or len(wanted) < 2:
        msg = (
            f"a band of {len(wanted)} frequencies by {nodes} solutions was asked for, but at least "
            "two of each are needed; solve a single frequency directly."
        )
        raise AntennaError(msg)
    places = np.array(wanted)
    if len(wanted) > nodes:
        turn = np.cos(math.pi * np.arange(nodes) / (nodes - 1))
        places = 0.5 * (wanted[0] + wanted[-1]) - 0.5 * (wanted[-1] - wanted[0]) * turn
    return FullwaveBand(
        results=tuple(
            solve_reader(
                mesh,
                frequency_hz=float(place),
                load_ohm=load_ohm,
                surface_impedance_ohm=surface_impedance_ohm,
                symmetry=symmetry,
            )
            for place in places
        )
    )
