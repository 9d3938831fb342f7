"""A reader's ports over a band of frequencies: impedance, reflection, S-matrix."""

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files.touchstone import write_touchstone
from octant.em.decibels import decibels
from octant.em.reader.fullwave.band import NODES, solve_band
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.result import FullwaveResult
from octant.geometries.errors import ConfigError
from octant.geometries.files import write_text
from octant.reader_design.face.reader_figures import return_loss_figure
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

NODES_PER_WIDTH = 25.0
"""Solutions beyond `NODES` for each unit of relative bandwidth [-]; S is within 2e-5 up to 0.3."""
BAND_COLUMNS = (
    "frequency_hz",
    "antenna",
    "resistance_ohm",
    "reactance_ohm",
    "reflection_db",
    "radiated_share",
    "other_loads_share",
)
"""Columns of ``band.csv``: a row a frequency and antenna."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReaderBand:
    """What a reader's ports are over a band.

    Parameters
    ----------
    reader : The reader; its loads are the reference of the S-matrices.
    results : Solutions of one mesh, of rising frequency.
    """

    reader: Reader
    results: tuple[FullwaveResult, ...]

    @property
    def frequencies_hz(self) -> FloatArray:
        """Frequencies, (f,) [Hz]."""
        return np.array([result.frequency_hz for result in self.results])

    @property
    def s_matrices(self) -> npt.NDArray[np.complex128]:
        """S-matrices (f, n, n) [-], ports referred to their loads."""
        return np.stack([result.s_matrix for result in self.results])

    @property
    def impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Input impedance (f, n) of each antenna, the others loaded [ohm]."""
        return np.stack([result.input_impedance_ohm for result in self.results])

    @property
    def reflection_db(self) -> FloatArray:
        """Reflection (f, n) at each antenna's port [dB]; the return loss with a minus sign."""
        shares = np.stack([result.reflected_share for result in self.results])
        return decibels(np.maximum(shares, 1e-10))

    def to_touchstone(self, path: str | Path) -> None:
        """Write the S-matrices as Touchstone, a point a frequency.

        Parameters
        ----------
        path : The file, ending in ``.sNp``; replaced where it exists.
        """
        write_touchstone(
            path, self.frequencies_hz, self.s_matrices, reference_ohm=self.reader.load_ohm
        )

    def to_csv(self, path: str | Path) -> None:
        """Write a table of `BAND_COLUMNS` [Hz], [ohm], [dB].

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(BAND_COLUMNS)
        for result, reflection_db in zip(self.results, self.reflection_db, strict=True):
            columns = (
                result.input_impedance_ohm.real,
                result.input_impedance_ohm.imag,
                reflection_db,
                result.radiated_share,
                result.coupled_share,
            )
            for antenna, row in enumerate(zip(*columns, strict=True), start=1):
                writer.writerow([result.frequency_hz, antenna, *(float(value) for value in row)])
        write_text(Path(path), out.getvalue())

    def figure(self) -> "Figure":
        """Return the return loss and the impedance of every antenna over frequency."""
        return return_loss_figure(
            self.frequencies_hz,
            self.impedance_ohm,
            -self.reflection_db,
            title=f"Return loss at {self.reader.load_ohm:g} ohm: {self.reader.label()}",
        )

    def lines(self) -> Iterator[str]:
        """Yield a heading and one line a frequency: antenna 1, and the ports' range."""
        yield (
            "frequency [GHz]  impedance of antenna 1 [ohm]  reflection of all [dB]  "
            "radiated by antenna 1 [%]"
        )
        for result, level_db in zip(self.results, self.reflection_db, strict=True):
            z = result.input_impedance_ohm[0]
            over = f"{level_db.min():.2f} to {level_db.max():.2f}"
            yield (
                f"{result.frequency_hz / 1e9:>15.6g}{f'{z.real:.1f}{z.imag:+.1f}j':>30}"
                f"{over:>24}{100.0 * result.radiated_share[0]:>27.1f}"
            )


def band_of(study: Study, frequencies_hz: Sequence[float], *, progress: Progress) -> ReaderBand:
    """Return the ports of a study's reader at frequencies, interpolated between few solutions.

    Antennas without a length are resonant at the carrier. One mesh, of the highest frequency or the
    carrier, serves the whole band, so that curves are smooth.

    Parameters
    ----------
    study : Its table ``[reader]`` is solved by full wave; others are refused.
    frequencies_hz : Where the ports are wanted [Hz].
    progress : Shows the frequencies.
    """
    design, carrier_hz = study.reader, study.radio.frequency_hz
    wanted = sorted(set(frequencies_hz))
    if design.response != "fullwave" or len(wanted) < 2:
        msg = (
            f"a band of {len(wanted)} frequencies was asked for of a reader with response = "
            f'"{design.response}", but two frequencies or more and "fullwave" are needed; other '
            "models give patterns only."
        )
        raise ConfigError(msg)
    feed = design.feed()
    load_ohm = feed["load_ohm"]
    mesh = reader_mesh(
        design.body(),
        frequency_hz=max(wanted[-1], carrier_hz),
        antenna=design.antenna,
        length_m=design.element(carrier_hz).length_m,
        gap_m=feed["gap_m"],
        wire_radius_m=feed["wire_radius_m"],
        feed_gap_m=feed["feed_gap_m"],
        surroundings=feed["surroundings"],
        cells_per_wavelength=design.cells_per_wavelength,
    )
    nodes = solutions_of(wanted)
    progress.say(f"band: {len(wanted)} frequencies from {nodes} solutions")
    band = solve_band(mesh, wanted, nodes=nodes, load_ohm=load_ohm)
    with progress.track(wanted, label="band") as tracked:
        return ReaderBand(reader=design, results=tuple(band.at(f) for f in tracked))


def solutions_of(frequencies_hz: Sequence[float]) -> int:
    """Return how many solutions a band is interpolated from [-].

    Parameters
    ----------
    frequencies_hz : Where the ports are wanted, two or more different ones [Hz].
    """
    low, high = min(frequencies_hz), max(frequencies_hz)
    width = 2.0 * (high - low) / (high + low)
    return min(len(set(frequencies_hz)), NODES + int(NODES_PER_WIDTH * width))
