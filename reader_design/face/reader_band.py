"""A reader's ports over a band of frequencies: impedance, reflection, S-matrix."""

import csv
import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files.touchstone import write_touchstone
from octant.em.decibels import decibels
from octant.em.reader.fullwave.band import NODES, solve_band_adaptively
from octant.em.reader.fullwave.band_ports import ports_over
from octant.em.reader.fullwave.loads import LoadedReader
from octant.em.reader.fullwave.mesh import ReaderMesh, reader_mesh
from octant.em.reader.fullwave.ported import PortedMesh
from octant.em.reader.hybrids import with_hybrids
from octant.em.reader.matching import vswr
from octant.geometries.errors import ConfigError
from octant.geometries.files import write_text
from octant.reader_design.face.reader_figures import return_loss_figure
from octant.reader_design.face.smith_figures import band_gain_figure, isolation_figure, smith_figure
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.feed_choice import FeedChoice, chosen_feed
from octant.reader_design.showing.matching_lines import Behind, matching_lines
from octant.reader_design.showing.netcdf import variable
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

GAIN_STEP_DEG = 5.0
"""Step of the directions among which the greatest gain is looked for [deg]."""
NODES_PER_WIDTH = 25.0
"""Solutions beyond `NODES` that are expected for each unit of relative bandwidth [-]."""
BAND_COLUMNS = (
    "frequency_hz",
    "antenna",
    "resistance_ohm",
    "reactance_ohm",
    "reflection_db",
    "radiated_share",
    "other_loads_share",
    "vswr",
    "embedded_efficiency",
    "greatest_gain_dbi",
    "own_gain_dbi",
    "margin_db",
    "radiation_efficiency",
)
"""Columns of ``band.csv``: a row a frequency and antenna. ``radiated_share`` is the total
efficiency, of what the source offers; ``embedded_efficiency`` of what the antenna's port takes;
``radiation_efficiency`` of what is radiated or lost in metal.
Gains are realised: the greatest, that towards the antenna's own azimuth along the horizon, and how
far the latter is above the next antenna's there."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReaderBand:
    """What a reader's ports are over a band.

    Parameters
    ----------
    study : Its reader's loads are the reference of the S-matrices; at its carrier the reader is to
        be matched.
    results : Solutions of one mesh, of rising frequency.
    error : What `solve_band_adaptively` says of the interpolation between few solutions [-].
    """

    study: Study
    results: tuple[LoadedReader, ...]
    error: float | None = None

    @property
    def reader(self) -> Reader:
        """The reader."""
        return self.study.reader

    @cached_property
    def frequencies_hz(self) -> FloatArray:
        """Frequencies, (f,) [Hz]."""
        return np.array([result.frequency_hz for result in self.results])

    @cached_property
    def s_matrices(self) -> npt.NDArray[np.complex128]:
        """S-matrices (f, n, n) [-], ports referred to their loads."""
        return np.stack([result.s_matrix for result in self.results])

    @cached_property
    def impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Input impedance (f, n) of each antenna, the others loaded [ohm]."""
        return np.stack([result.input_impedance_ohm for result in self.results])

    @cached_property
    def reflection_db(self) -> FloatArray:
        """Reflection (f, n) at each antenna's port [dB]; the return loss with a minus sign."""
        return decibels(np.maximum(self.reflected_share, 1e-10))

    @cached_property
    def reflected_share(self) -> FloatArray:
        """Reflected over available power (f, n) of each antenna [-]."""
        return np.stack([result.reflected_share for result in self.results])

    @cached_property
    def admittance_s(self) -> npt.NDArray[np.complex128]:
        """Admittances (f, n, n) of the ports without loads [S]."""
        return np.stack([result.admittance_s for result in self.results])

    @cached_property
    def radiated_share(self) -> FloatArray:
        """Total efficiency (f, n): radiated over available power [-]."""
        return np.stack([result.radiated_share for result in self.results])

    @cached_property
    def embedded_efficiency(self) -> FloatArray:
        """Efficiency (f, n): radiated power over what each antenna's port takes [-]."""
        taken = 1.0 - np.stack([result.reflected_share for result in self.results])
        return self.radiated_share / taken

    @cached_property
    def radiation_efficiency(self) -> FloatArray:
        """Efficiency (f, n) of the metal: radiated over radiated and lost power [-]."""
        return np.stack([result.radiation_efficiency for result in self.results])

    @cached_property
    def gains_dbi(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Greatest realised gain, that towards the own azimuth [dBi], and margin [dB], (f, n)."""
        azimuths = self.reader.body().element_azimuths_rad
        theta = np.radians(np.arange(0.0, 180.1, GAIN_STEP_DEG))
        greatest, own, margin = [], [], []
        for result in self.results:
            pattern = result.pattern_grid(theta, round(360.0 / GAIN_STEP_DEG))
            greatest.append((np.abs(pattern) ** 2).sum(axis=-1).max(axis=(1, 2)))
            ahead = result.pattern_towards(np.full(len(azimuths), 0.5 * math.pi), azimuths)
            towards = (np.abs(ahead) ** 2).sum(axis=-1)  # antenna, direction
            mine = np.diagonal(towards).copy()
            np.fill_diagonal(towards, 0.0)
            own.append(mine)
            margin.append(mine / np.maximum(towards.max(axis=0), 1e-30))
        return decibels(np.array(greatest)), decibels(np.array(own)), decibels(np.array(margin))

    def variables(self) -> "dict[str, xr.Variable]":
        """Return what ``reader.nc`` holds over the band, with its coordinate ``band_frequency``."""
        greatest, own, margin = self.gains_dbi
        dims = ["band_frequency", "antenna"]
        rows = (
            ("band_impedance_ohm", self.impedance_ohm, "ohm", "input impedance, the others loaded"),
            ("band_reflection_db", self.reflection_db, "dB", "reflection at the port"),
            ("band_vswr", vswr(self.reflected_share), "1", "voltage standing wave ratio"),
            ("band_radiated_share", self.radiated_share, "1", "radiated over available power"),
            (
                "band_embedded_efficiency",
                self.embedded_efficiency,
                "1",
                "radiated power over what the port takes",
            ),
            (
                "band_radiation_efficiency",
                self.radiation_efficiency,
                "1",
                "radiated over radiated and lost power",
            ),
            ("band_greatest_gain_dbi", greatest, "dBi", "greatest realised gain"),
            ("band_own_gain_dbi", own, "dBi", "realised gain towards the own azimuth"),
            ("band_margin_db", margin, "dB", "own gain above the next antenna's there"),
        )
        return {
            "band_frequency": variable(
                ["band_frequency"], self.frequencies_hz, units="Hz", long_name="frequency"
            ),
            "band_s_matrix": variable(
                ["band_frequency", "antenna", "antenna_2"],
                self.s_matrices,
                units="1",
                long_name="wave out of antenna for a unit wave into antenna_2",
            ),
            **{
                name: variable(dims, values, units=units, long_name=text)
                for name, values, units, text in rows
            },
        }

    def to_touchstone(self, path: str | Path) -> None:
        """Write the S-matrices of the antennas' own ports as Touchstone, a point a frequency.

        Parameters
        ----------
        path : The file, ending in ``.sNp``; replaced where it exists.
        """
        load_ohm = self.reader.load_ohm
        loads = np.full(self.results[0].ports, load_ohm, dtype=np.complex128)
        bare = [replace(result, load_ohm=loads, feeds=None).s_matrix for result in self.results]
        write_touchstone(path, self.frequencies_hz, np.stack(bare), reference_ohm=load_ohm)

    def to_csv(self, path: str | Path) -> None:
        """Write a table of `BAND_COLUMNS` [Hz], [ohm], [dB], [dBi].

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(BAND_COLUMNS)
        columns = (
            self.impedance_ohm.real,
            self.impedance_ohm.imag,
            self.reflection_db,
            self.radiated_share,
            np.stack([result.coupled_share for result in self.results]),
            vswr(self.reflected_share),
            self.embedded_efficiency,
            *self.gains_dbi,
            self.radiation_efficiency,
        )
        for i, frequency_hz in enumerate(self.frequencies_hz):
            for antenna, row in enumerate(zip(*(c[i] for c in columns), strict=True), start=1):
                writer.writerow([float(frequency_hz), antenna, *(float(value) for value in row)])
        write_text(Path(path), out.getvalue())

    @property
    def _loads(self) -> str:
        """What the ports are loaded with, as short as titles have it."""
        behind = "" if self.reader.line is None else " behind reader.feed"
        return f"{self.reader.load_ohm:g} ohm{behind}"

    def figure(self) -> "Figure":
        """Return the return loss and the impedance of every antenna over frequency."""
        return return_loss_figure(
            self.frequencies_hz,
            self.impedance_ohm,
            -self.reflection_db,
            title=f"Return loss at {self._loads}: {self.reader.label()}",
        )

    def figures(self) -> "Iterator[tuple[str, Figure]]":
        """Yield name and figure of everything that is shown over the band."""
        at, label = f" at {self._loads}", self.reader.label()
        yield "return_loss", self.figure()
        yield (
            "smith",
            smith_figure(self.s_matrices, self.frequencies_hz, title=f"Reflection{at}: {label}"),
        )
        yield (
            "isolation",
            isolation_figure(self.s_matrices, self.frequencies_hz, title=f"Isolation{at}: {label}"),
        )
        yield (
            "efficiency_and_gain",
            band_gain_figure(
                self.frequencies_hz,
                (self.radiated_share, self.embedded_efficiency),
                self.gains_dbi,
                title=f"Efficiency, gain and margin{at}: {label}",
            ),
        )

    def lines(self) -> Iterator[str]:
        """Yield a heading and one line a frequency: antenna 1, and the ports' range."""
        yield (
            "frequency [GHz]  impedance of antenna 1 [ohm]  reflection of all [dB]  "
            "radiated by antenna 1 [%]"
        )
        rows = zip(
            self.frequencies_hz,
            self.impedance_ohm[:, 0],
            self.reflection_db,
            self.radiated_share[:, 0],
            strict=True,
        )
        for frequency_hz, z, level_db, radiated in rows:
            over = f"{level_db.min():.2f} to {level_db.max():.2f}"
            yield (
                f"{frequency_hz / 1e9:>15.6g}{f'{z.real:.1f}{z.imag:+.1f}j':>30}"
                f"{over:>24}{100.0 * radiated:>27.1f}"
            )
        yield from matching_lines(
            self.admittance_s,
            self.frequencies_hz,
            at_hz=self.study.radio.frequency_hz,
            load_ohm=self.reader.load_ohm,
            behind=Behind.of(self.reader, self.results),
            choice=self._choice,
        )

    def _choice(self) -> FeedChoice | None:
        """Return the feed that would match it and keep its bearing best."""
        return chosen_feed(self.study, self.results, at_hz=self.study.radio.frequency_hz)


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
    if not design.has_ports or len(wanted) < 2:
        msg = (
            f"a band of {len(wanted)} frequencies was asked for of a reader with response = "
            f'"{design.response}", but two frequencies or more and "fullwave" are needed; other '
            "models give patterns only."
        )
        raise ConfigError(msg)
    load_ohm = design.load_ohm
    highest_hz = max(wanted[-1], carrier_hz)
    mesh = _mesh(design, highest_hz, carrier_hz)
    with progress.count(solutions_of(wanted), label="solutions of the band") as done:
        band = solve_band_adaptively(mesh, wanted, load_ohm=load_ohm, progress=done)
    if band.error is not None:
        progress.say(
            f"band: {len(wanted)} frequencies from {len(band.results)} solutions; the last one was "
            f"predicted within {float(decibels(max(band.error**2, 1e-20))):.0f} dB in S."
        )
    found = ports_over(band, wanted)
    with progress.track(wanted, label="band") as tracked:
        results = tuple(next(found) for _ in tracked)
    hybrids = design.hybrids()
    if hybrids is not None:
        results = tuple(_behind(hybrids, result) for result in results)
    feeding = design.feeding()
    if feeding is not None:
        results = tuple(feeding.on(result) for result in results)
    return ReaderBand(study=study, results=results, error=band.error)


def _behind(hybrids: npt.NDArray[np.complex128], result: LoadedReader) -> LoadedReader:
    """Return a solution behind hybrids, with the same loads."""
    unloaded = with_hybrids(result.unloaded, hybrids)
    return LoadedReader(unloaded=unloaded, load_ohm=result.load_ohm[: len(hybrids)])


def _mesh(design: Reader, highest_hz: float, carrier_hz: float) -> ReaderMesh | PortedMesh:
    """Return one mesh for a whole band."""
    if not design.drawn:
        return design.metal_mesh(highest_hz)
    feed = design.feed()
    return reader_mesh(
        design.body(),
        frequency_hz=highest_hz,
        antenna=design.antenna,
        length_m=design.element(carrier_hz).length_m,
        gap_m=feed["gap_m"],
        wire_radius_m=feed["wire_radius_m"],
        feed_gap_m=feed["feed_gap_m"],
        surroundings=feed["surroundings"],
        conductor=feed["conductor"],
        cells_per_wavelength=design.cells_per_wavelength,
    )


def solutions_of(frequencies_hz: Sequence[float]) -> int:
    """Return how many solutions a band is expected to be interpolated from [-].

    Parameters
    ----------
    frequencies_hz : Where the ports are wanted, two or more different ones [Hz].
    """
    low, high = min(frequencies_hz), max(frequencies_hz)
    width = 2.0 * (high - low) / (high + low)
    return min(len(set(frequencies_hz)), NODES + int(NODES_PER_WIDTH * width))
