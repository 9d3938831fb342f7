"""A reader by itself: its ports, embedded patterns and surface currents, solved and written."""

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.from_files import pattern_tables
from octant.em.antennas.pattern_files.ffe import write_ffe
from octant.em.antennas.pattern_files.touchstone import write_touchstone
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.convergence import convergence_study
from octant.em.reader.fullwave.port_files import loads_of_file, network_of_file
from octant.em.reader.fullwave.response import response_of, solved_reader
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.single import dipole_mesh, monopole_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.em.reader.hybrids import axial_ratio_db, result_with_hybrids
from octant.em.reader.reader_netcdf import reader_dataset
from octant.geometries.errors import ConfigError, PhysicsWarning
from octant.reader_design.face.reader_figures import (
    current_figure,
    cuts_figure,
    element_figure,
    gain_dbi,
    gain_figure,
    s_matrix_figure,
)
from octant.reader_design.face.shown import figure_html, progress_of, text_html
from octant.reader_design.face.tables import StudyTable, study_from, with_keys_of
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.versions import versions
from octant.reader_design.setting.cost import reader_cost
from octant.reader_design.setting.design import METAL, response_at
from octant.reader_design.setting.scale import reader_preset, scale_note
from octant.reader_design.setting.solving import SOLVING
from octant.reader_design.showing.dxf_files import write_dxf
from octant.reader_design.showing.mat_files import write_mat
from octant.reader_design.showing.matching_lines import Behind, matching_lines
from octant.reader_design.showing.netcdf import variable, write_dataset
from octant.reader_design.showing.workshop import drawing, drawing_scale, save_drawing
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.reader import Reader as ReaderTable
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

ELEVATIONS_DEG = (0.0, 30.0, 45.0, 60.0)
DENSITIES = (8.0, 10.0, 14.0)
"""Elements per wavelength that a convergence study solves with [-]."""
FIGURE_STEP_DEG = 3.0


@with_keys_of(ReaderTable)
class Reader(StudyTable):
    """A bearing-sensitive reader: its antennas around an axis, ground plane and plates.

    The keys are those of the table ``[reader]`` of a study file.

    Examples
    --------
    >>> import octant
    >>> reader = octant.Reader(antenna_radius_m=0.10, plate_height_m=0.08, response="isolated")
    >>> reader.antennas
    8
    >>> reader.solve(2.4e9, step_deg=30).pattern.dims
    ('frequency', 'antenna', 'component', 'theta', 'phi')
    """

    __slots__ = ()
    _kind = ReaderTable

    def __init__(self, **keys: Any) -> None:  # noqa: ANN401  keys of the table
        self.table = study_from("Reader", {"reader": keys}).reader

    @classmethod
    def preset(cls, band: str | float) -> Self:
        """Return a reader for a band: Octant's best for 2.4 GHz, scaled with the wavelength.

        Parameters
        ----------
        band : ``868 MHz``, ``915 MHz``, ``2.4 GHz``, ``5.8 GHz``, or a frequency [Hz].
        """
        return cls.of(reader_preset(band))

    def solve(
        self,
        frequencies_hz: float | Sequence[float] = 2.4e9,
        *,
        step_deg: float = 2.0,
        progress: bool | Progress = True,
    ) -> "SolvedReader":
        """Return the reader's ports and patterns; a PhysicsWarning tells the limits of its model.

        Parameters
        ----------
        frequencies_hz : Frequencies [Hz]; antennas without a length are resonant at the first.
        step_deg : Step of the patterns over theta and phi [deg]; it must divide 180.
        progress : False silences it.
        """
        given = np.atleast_1d(np.asarray(frequencies_hz, dtype=np.float64)).tolist()
        if not given:
            msg = "no frequency is given; give one or several in Hz."
            raise ConfigError(msg)
        study = study_from("solve", {"reader": self, "radio": {"frequency_hz": given[0]}})
        return solve_reader_of(study, given, step_deg=step_deg, progress=progress_of(progress))

    def drawing(self, path: str | Path, *, frequency_hz: float = 2.4e9, title: str = "") -> None:
        """Write the workshop's drawing to scale, all lengths in [mm], as SVG, PDF, PNG or DXF.

        DXF needs ``octant[cad]``; its dimensions can be measured in CAD programs.

        Parameters
        ----------
        path, title : File ending in .svg, .pdf, .png or .dxf, replaced where it exists; its title.
        frequency_hz : Where antennas without a length are resonant [Hz].
        """
        file, kinds = Path(path), (".svg", ".pdf", ".png", ".dxf")
        if file.suffix.lower() not in kinds:
            msg = f"{file} ends in {file.suffix!r}; a drawing ends in {', '.join(kinds)}."
            raise ConfigError(msg)
        sheet = drawing(self.table, frequency_hz=frequency_hz, title=title or self.table.label())
        if file.suffix.lower() == ".dxf":
            write_dxf(sheet, file, scale=drawing_scale(self.table))
        else:
            save_drawing(sheet, file)

    def plot(self) -> "Figure":
        """Return a picture of the reader's metal and antennas."""
        from octant.geometries.scene import build_scene
        from octant.reader_design.showing.scene_picture import scene_figure

        design = self.table
        body = design.body()
        return scene_figure(
            build_scene([], objects=[body.body]),
            title=design.label(),
            tags={str(i + 1): foot for i, foot in enumerate(body.element_feet_m)},
        )

    def __repr__(self) -> str:
        return f"<Reader: {self.antennas} {self.table.label()}, {self.response}>"


def check_step(step_deg: float, *, name: str) -> None:
    """Refuse a step that does not divide half a turn.

    Parameters
    ----------
    step_deg, name : The step [deg] and the name of the argument.
    """
    steps = 180.0 / step_deg if step_deg > 0.0 else math.nan
    if not abs(steps - round(steps) if math.isfinite(steps) else math.nan) <= 1e-9:
        msg = f"{name} is {step_deg:g} degrees, but it must divide 180 degrees; give 1, 2 or 5."
        raise ConfigError(msg)


def solve_reader_of(
    study: Study,
    frequencies_hz: Sequence[float],
    *,
    step_deg: float,
    progress: Progress,
) -> "SolvedReader":
    """Return the solved reader of a study's table ``[reader]``.

    Parameters
    ----------
    study : The study.
    frequencies_hz, step_deg, progress : As in `Reader.solve` [Hz], [deg].
    """
    check_step(step_deg, name="step_deg")
    design = study.reader
    first = frequencies_hz[0]
    cut = msgspec.structs.replace(design, antenna_length_m=design.element(first).length_m)
    count = len(frequencies_hz)
    alone = msgspec.structs.replace(study.radio, channels_hz=())
    expected_s = count * reader_cost(msgspec.structs.replace(study, radio=alone)).seconds
    label = SOLVING if count == 1 else f"{SOLVING} at {count} frequencies"
    with progress.during(label, expected_s=expected_s):
        at = [_solved(study, design if f == first else cut, f) for f in frequencies_hz]
    notes = dict.fromkeys((*design.notes(), *(w for r, _ in at for w in r.warnings)))
    if (outside := scale_note(design, first)) is not None:
        notes[outside] = None
    for note in notes:
        warnings.warn(note, PhysicsWarning, stacklevel=2)
    return SolvedReader(
        study=study,
        design=design,
        responses=tuple(response for response, _ in at),
        results=tuple(result for _, result in at if result is not None),
        step_deg=step_deg,
    )


def _solved(
    study: Study, design: ReaderTable, frequency_hz: float
) -> tuple[ReaderResponse, FullwaveResult | None]:
    if not study.reader.has_ports:
        return response_at(design, frequency_hz), None
    body = design.body()
    if design.response == METAL:
        result = solve_reader(design.metal_mesh(frequency_hz), load_ohm=design.load_ohm)
        hybrids = design.hybrids()
        result = result if hybrids is None else result_with_hybrids(result, hybrids)
    else:
        result = solved_reader(
            body,
            design.element(frequency_hz),
            cells_per_wavelength=study.reader.cells_per_wavelength,
            **design.feed(),
        )
    feeding = design.feeding()
    result = result if feeding is None else feeding.on(result)
    return response_of(result, body), result


@dataclass(frozen=True, kw_only=True, eq=False)
class SolvedReader:
    """What a reader's ports and patterns are, at one or several frequencies.

    Parameters
    ----------
    study, design : What was solved, and its reader.
    responses, results : Patterns, one a frequency, and the solutions behind them, if any.
    step_deg : Step of the patterns over theta and phi [deg].
    loads, network : Files that say what the ports are loaded with, and how they are coupled; empty:
        the reader's ``load_ohm``, and the solution.
    """

    study: Study
    design: ReaderTable
    responses: tuple[ReaderResponse, ...]
    results: tuple[FullwaveResult, ...]
    step_deg: float
    loads: str = ""
    network: str = ""

    @property
    def frequencies_hz(self) -> tuple[float, ...]:
        """Frequencies [Hz]."""
        return tuple(response.frequency_hz for response in self.responses)

    def result(self, number: int = 0) -> FullwaveResult:
        """Return the full-wave solution at one frequency; refuse a model that gives patterns only.

        Parameters
        ----------
        number : Of the frequency.
        """
        if not self.results:
            msg = (
                f"the model {self.responses[0].model!r} gives patterns only, so there are no "
                "impedances, S-matrix or currents; solve a Reader with response='fullwave'."
            )
            raise ConfigError(msg)
        return self.results[number]

    def loaded(self, path: str | Path) -> "SolvedReader":
        """Return the same reader with the loads of a Touchstone file, version 1 or 2, on its ports.

        They stand at the antennas, in place of ``reader.feed``.

        Parameters
        ----------
        path : File of one port, which loads all antennas, or of as many as there are, not coupled.
        """
        self.result()
        results = [
            replace(
                result,
                load_ohm=loads_of_file(path, result.frequency_hz, ports=result.ports),
                feeds=None,
            )
            for result in self.results
        ]
        return self._with_results(results, loads=str(path))

    def with_network(self, path: str | Path) -> "SolvedReader":
        """Return the same reader with the coupling of a Touchstone file, as of a measured one.

        Its patterns are those of the solution for each antenna's voltage; the voltages are the
        file's. A PhysicsWarning says where its powers do not fit to the solution's patterns.

        Parameters
        ----------
        path : File with a port for each antenna, in their order.
        """
        self.result()
        results = [
            replace(
                result,
                unloaded=replace(
                    result.unloaded,
                    admittance_s=network_of_file(path, result.frequency_hz, ports=result.ports),
                ),
            )
            for result in self.results
        ]
        for text in dict.fromkeys(text for result in results for text in result.warnings):
            warnings.warn(f"{path}: {text}", PhysicsWarning, stacklevel=2)
        return self._with_results(results, network=str(path))

    def _with_results(self, results: Sequence[FullwaveResult], **said: str) -> "SolvedReader":
        body = self.design.body()
        responses = tuple(response_of(result, body) for result in results)
        return replace(self, results=tuple(results), responses=responses, **said)  # type: ignore[arg-type]

    def sampled(self, number: int, step_deg: float) -> tuple[FloatArray, FloatArray, ComplexArray]:
        """Return angles [rad] and the (n, t, p, 2) patterns, phi from 0 to 2 pi with both ends.

        Parameters
        ----------
        number, step_deg : Number of the frequency; step over theta and phi [deg].
        """
        rows, columns = round(180.0 / step_deg) + 1, round(360.0 / step_deg)
        theta = np.linspace(0.0, math.pi, rows)
        phi = np.linspace(0.0, 2.0 * math.pi, columns + 1)
        if not self.results:
            return theta, phi, self.responses[number].far_field(theta[:, None], phi)
        pattern = self.results[number].pattern_grid(theta, columns)
        return theta, phi, np.concatenate((pattern, pattern[:, :, :1]), axis=2)

    @cached_property
    def _samples(self) -> tuple[tuple[FloatArray, FloatArray, ComplexArray], ...]:
        return tuple(self.sampled(i, self.step_deg) for i in range(len(self.responses)))

    @property
    def pattern(self) -> "xr.DataArray":
        """Embedded realised patterns: complex F_theta and F_phi, |F|^2 = gain."""
        theta, phi, _ = self._samples[0]
        values = np.stack([np.moveaxis(p, -1, 1) for _, _, p in self._samples])
        return self._array(
            values,
            ["antenna", "component", "theta", "phi"],
            units="1",
            long_name="embedded far field, |F|^2 = gain, phase at the reader's centre, e^{+j w t}",
            theta=("degree", np.degrees(theta), "angle from +z"),
            phi=("degree", np.degrees(phi), "azimuth from antenna 1"),
            component=("1", np.array(["theta", "phi"]), "component of the far field"),
        )

    @property
    def s(self) -> "xr.DataArray":
        """S-matrix: the wave out of ``antenna`` for a unit wave into ``antenna_2``."""
        self.result()
        return self._array(
            np.stack([result.s_matrix for result in self.results]),
            ["antenna", "antenna_2"],
            units="1",
            long_name="wave out of antenna for a unit wave into antenna_2",
        )

    @property
    def z(self) -> "xr.DataArray":
        """Input impedance of each antenna, the others loaded [ohm]."""
        self.result()
        return self._array(
            np.stack([result.input_impedance_ohm for result in self.results]),
            ["antenna"],
            units="ohm",
            long_name="input impedance, the others loaded",
        )

    def _array(
        self,
        values: npt.NDArray[Any],
        dims: list[str],
        *,
        units: str,
        long_name: str,
        **axes: tuple[str, npt.NDArray[Any], str],
    ) -> "xr.DataArray":
        import xarray as xr

        numbers = np.arange(1, self.responses[0].antennas + 1)
        known = {
            "frequency": ("Hz", np.array(self.frequencies_hz), "frequency"),
            "antenna": ("1", numbers, "number of the antenna"),
            "antenna_2": ("1", numbers, "number of the antenna that is fed"),
            **axes,
        }
        dims = ["frequency", *dims]
        return xr.DataArray(
            values,
            dims=dims,
            coords={
                name: variable(
                    [name], known[name][1], units=known[name][0], long_name=known[name][2]
                )
                for name in dims
            },
            attrs={"units": units, "long_name": long_name},
        )

    def dataset(self, number: int = 0) -> "xr.Dataset":
        """Return what ``reader.nc`` holds at one frequency: patterns, impedances [ohm], S-matrix.

        Parameters
        ----------
        number : Of the frequency.
        """
        result = self.results[number] if self.results else None
        data = reader_dataset(
            self._exact(number),
            impedance_ohm=None if result is None else result.input_impedance_ohm,
            s_matrix=None if result is None else result.s_matrix,
        )
        data.attrs |= {"study": to_toml(self.study), "seed": self.study.seed, **versions()}
        if result is not None:
            data["radiated_share"] = variable(
                ["antenna"],
                result.radiated_share,
                units="1",
                long_name="radiated over available power",
            )
            data["radiation_efficiency"] = variable(
                ["antenna"],
                result.radiation_efficiency,
                units="1",
                long_name="radiated over radiated and lost power",
            )
            data.attrs |= {
                "load_ohm": self.study.reader.load_ohm,
                "unknowns": result.unknowns,
                "balance_error": result.balance_error,
            }
        return data

    def _exact(self, number: int) -> ReaderResponse:
        """Return the response with patterns that are exact on the grid of the files."""
        response = self.responses[number]
        pattern = self._samples[number][2][:, :, :-1]
        return ReaderResponse.from_centre(
            np.moveaxis(pattern, -1, 1),
            model=response.model,
            frequency_hz=response.frequency_hz,
            azimuths_rad=response.azimuths_rad,
            phase_centres_m=response.phase_centres_m,
            warnings=response.warnings,
        )

    def to_netcdf(self, path: str | Path, *, number: int = 0, force: bool = False) -> None:
        """Write ``reader.nc``, which ``[reader] pattern_files`` and other programs can read.

        Parameters
        ----------
        path, number : The file and the number of the frequency.
        force : Replace a file that exists.
        """
        write_dataset(self.dataset(number), Path(path), force=force)

    def to_mat(self, path: str | Path, *, number: int = 0) -> None:
        """Write the same as a MAT file for MATLAB: complex ``pattern``, ``s_matrix`` and so on.

        Parameters
        ----------
        path, number : The file, replaced where it exists; the number of the frequency.
        """
        write_mat(self.dataset(number), Path(path))

    def to_ffe(self, folder: str | Path) -> tuple[Path, ...]:
        """Return the FEKO far-field files that are written, one for each antenna.

        Parameters
        ----------
        folder : Where ``antenna_1.ffe`` and so on are written; replaced where they exist.
        """
        tables_at = [pattern_tables(self._exact(i)) for i in range(len(self.responses))]
        files = []
        Path(folder).mkdir(parents=True, exist_ok=True)
        for i, tables in enumerate(zip(*tables_at, strict=True)):
            files.append(Path(folder) / f"antenna_{i + 1}.ffe")
            write_ffe(files[-1], list(tables))
        return tuple(files)

    def to_touchstone(self, path: str | Path) -> Path:
        """Return the Touchstone file of the S-matrix that is written, at the reader's ``load_ohm``.

        It is that of the antennas' own ports, without ``reader.feed``.

        Parameters
        ----------
        path : The file; its suffix becomes ``.sNp``, and it is replaced where it exists.
        """
        result = self.result()
        real_ohm = np.array(self.study.reader.load_ohm, dtype=np.complex128)
        file = Path(path).with_suffix(f".s{result.ports}p")
        file.parent.mkdir(parents=True, exist_ok=True)
        write_touchstone(
            file,
            list(self.frequencies_hz),
            np.stack([replace(r, load_ohm=real_ohm, feeds=None).s_matrix for r in self.results]),
            reference_ohm=self.study.reader.load_ohm,
        )
        return file

    @cached_property
    def alone(self) -> FullwaveResult:
        """One antenna alone at the first frequency: a dipole, or a monopole on its own plane."""
        design = self.design
        element = design.element(self.frequencies_hz[0])
        if design.antenna == "dipole":
            mesh = dipole_mesh(
                frequency_hz=element.frequency_hz,
                length_m=element.length_m,
                wire_radius_m=design.wire_radius_m,
                feed_gap_m=design.feed_gap_m,
                conductor=design.conductor,
            )
        else:
            mesh = monopole_mesh(
                frequency_hz=element.frequency_hz,
                plane_m=design.monopole_plane_m or design.ground_plane_m,
                length_m=element.length_m,
                wire_radius_m=design.wire_radius_m,
                feed_gap_m=design.feed_gap_m,
                conductor=design.conductor,
            )
        return solve_reader(mesh, load_ohm=design.load_ohm)

    def _alone_gain(self, theta: FloatArray, phi: FloatArray) -> FloatArray:
        """Return the (t, p) gain of one antenna alone [dBi], mismatch taken out."""
        pattern = self.alone.far_field(theta[:, None], phi)[0]
        return gain_dbi(pattern / math.sqrt(float(self.alone.accepted_share[0])))

    def figures(self, number: int = 0) -> "Iterator[tuple[str, Figure]]":
        """Yield the name and each figure of the reader at one frequency.

        Parameters
        ----------
        number : Of the frequency.
        """
        design = self.design
        label = design.label()
        theta, phi, pattern = self.sampled(number, FIGURE_STEP_DEG)
        if design.drawn:
            single = self._alone_gain(theta, phi)
            title = f"A single {design.antenna}, alone"
            yield "element", element_figure(theta, phi, single, title=title)
        yield "cuts", self.plot(number)
        gain = gain_dbi(pattern[0])
        yield "gain_antenna_1", gain_figure(theta, phi, gain, title=f"Antenna 1: {label}")
        if not self.results:
            return
        result = self.results[number]
        yield "s_matrix", s_matrix_figure(result.s_matrix, title=f"S-matrix: {label}")
        yield (
            "currents_antenna_1",
            current_figure(
                result.basis.corners_m,
                np.linalg.norm(result.surface_currents(0), axis=1),
                title=f"Surface current, antenna 1 driven: {label}",
            ),
        )

    def plot(self, number: int = 0) -> "Figure":
        """Return polar cuts of the gain of all antennas at four elevations.

        Parameters
        ----------
        number : Of the frequency.
        """
        response = self.responses[number]
        phi = np.linspace(0.0, 2.0 * math.pi, round(360.0 / FIGURE_STEP_DEG) + 1)
        cuts = [
            (float(e), gain_dbi(response.far_field(math.radians(90.0 - e), phi)))
            for e in ELEVATIONS_DEG
        ]
        title = f"All antennas: {self.design.label()}"
        return cuts_figure(phi, cuts, response.azimuths_rad, title=title)

    def alone_lines(self) -> Iterator[str]:
        """Yield impedance and gain of one antenna alone, in one sentence; nothing of files."""
        if not self.design.drawn:
            return
        theta, phi, _ = self._samples[0]
        alone, design = self.alone, self.design
        z, top = alone.input_impedance_ohm[0], float(self._alone_gain(theta, phi).max())
        accepted = 10.0 * math.log10(float(alone.accepted_share[0]))
        yield (
            f"A single {design.antenna} alone: {z.real:.1f}{z.imag:+.1f}j ohm, gain {top:.2f} dBi, "
            f"realised at {design.load_ohm:g} ohm {top + accepted:.2f} dBi."
        )

    def lines(self, number: int = 0, *, matching: bool = True) -> Iterator[str]:
        """Yield what a person wants to read about the reader at one frequency.

        Parameters
        ----------
        number, matching : Of the frequency; whether to say what would match it.
        """
        response = self.responses[number]
        peak = gain_dbi(self._samples[number][2]).max(axis=(1, 2))
        frequency = f"{response.frequency_hz / 1e9:g} GHz"
        head = f"{self.design.label()} at {frequency}, model {response.model}"
        if not self.results:
            yield f"{head}: patterns only, the antennas count as matched."
            yield "greatest gain [dBi]: " + ", ".join(f"{g:.2f}" for g in peak)
            return
        result, reader = self.results[number], self.study.reader
        yield (
            f"{head}: {result.unknowns} unknowns at {reader.cells_per_wavelength:g} cells per "
            f"wavelength, loads of {self.loads or self.study.reader.loads_text()}"
            f"{f', coupling of {self.network}' if self.network else ''}."
        )
        yield from port_lines(result, response.azimuths_rad, peak)
        yield from s_matrix_lines(result.s_matrix)
        yield balance_line(result)
        if (conductor := self.design.conductor) is not None:
            yield metal_line(conductor, result)
        if self.design.hybrids() is not None:
            ahead = result.far_field(np.full(result.ports, 0.5 * math.pi), response.azimuths_rad)
            ratio = axial_ratio_db(ahead[np.arange(result.ports), np.arange(result.ports)])
            yield (
                "Axial ratio of each antenna towards its azimuth, along the horizon [dB]: "
                f"{', '.join(f'{value:.1f}' for value in ratio)}."
            )
        if not matching or self.loads:
            return
        yield from matching_lines(
            result.admittance_s[None],
            result.frequency_hz,
            at_hz=result.frequency_hz,
            load_ohm=reader.load_ohm,
            behind=Behind.of(reader, (result,)),
        )

    def convergence_lines(self, *, progress: bool | Progress = True) -> Iterator[str]:
        """Yield how impedances and gains move with the mesh, at the first frequency.

        Parameters
        ----------
        progress : False silences it.
        """
        self.result()
        shown = progress_of(progress)

        def solve(cells: float) -> FullwaveResult:
            shown.say(f"convergence: {cells:g} cells per wavelength")
            return solved_reader(
                self.design.body(),
                self.design.element(self.frequencies_hz[0]),
                cells_per_wavelength=cells,
                **self.design.feed(),
            )

        yield "Convergence, against the finest mesh:"
        yield from convergence_study(solve, DENSITIES).lines()

    def __repr__(self) -> str:
        frequencies = ", ".join(f"{f / 1e9:g}" for f in self.frequencies_hz)
        peak = float(gain_dbi(self._samples[0][2]).max())
        text = f"<SolvedReader: {self.responses[0].antennas} {self.design.label()}, "
        text += f"{self.responses[0].model}, {frequencies} GHz, greatest gain {peak:.2f} dBi"
        if self.results:
            returned = float(self.results[0].reflected_share.max())
            text += f", |S11| up to {10.0 * math.log10(max(returned, 1e-20)):.1f} dB"
        return text + ">"

    def _repr_html_(self) -> str:
        return text_html("\n".join(self.lines())) + figure_html(self.plot())


def port_lines(
    result: FullwaveResult,
    azimuths_rad: npt.NDArray[np.float64],
    peak_gain_dbi: npt.NDArray[np.float64],
) -> Iterator[str]:
    """Yield a heading and one line an antenna: impedance, reflection, power, gain.

    Parameters
    ----------
    result : Solution.
    azimuths_rad, peak_gain_dbi : (n,) float64 — Azimuths [rad], greatest realised gains [dBi].
    """
    yield (
        "antenna  azimuth [°]  input impedance [ohm]  reflection [dB]  radiated [%]  "
        "to other loads [%]  greatest gain [dBi]"
    )
    returned, coupled = result.reflected_share, result.coupled_share
    for i, z in enumerate(result.input_impedance_ohm):
        seen = f"{z.real:.1f}{z.imag:+.1f}j"
        yield (
            f"{i + 1:>7}{np.degrees(azimuths_rad[i]):>13.1f}{seen:>23}"
            f"{10.0 * np.log10(max(returned[i], 1e-10)):>17.2f}"
            f"{100.0 * result.radiated_share[i]:>14.1f}{100.0 * coupled[i]:>20.1f}"
            f"{peak_gain_dbi[i]:>21.2f}"
        )


def s_matrix_lines(s_matrix: npt.NDArray[np.complex128]) -> Iterator[str]:
    """Yield a scattering matrix's magnitudes [dB]: driven antennas above, a row a receiving one.

    Parameters
    ----------
    s_matrix : (n, n) complex128 — Scattering matrix [-].
    """
    level = 20.0 * np.log10(np.maximum(np.abs(s_matrix), 1e-10))
    numbers = "".join(f"{i + 1:>8}" for i in range(len(level)))
    yield f"|S| [dB]{numbers}"
    for i, row in enumerate(level):
        yield f"{i + 1:>8}" + "".join(f"{value:>8.2f}" for value in row)


def metal_line(conductor: Conductor, result: FullwaveResult) -> str:
    """Return what the metal costs [%], and what is radiated in all, in one sentence.

    Parameters
    ----------
    conductor, result : What the reader is made of; the solution.
    """
    depth_um = 1e6 * conductor.skin_depth_m(result.frequency_hz)
    own, total = 100.0 * result.radiation_efficiency, 100.0 * result.radiated_share
    return (
        f"Metal of {conductor.conductivity_s_per_m:g} S/m (skin depth {depth_um:.2g} um, roughness "
        f"factor {conductor.roughness_factor:g}): radiation efficiency {own.min():.2f} to "
        f"{own.max():.2f} %, total efficiency {total.min():.1f} to {total.max():.1f} %; sheets "
        "that carry current on one side only lose up to twice as much."
    )


def balance_line(result: FullwaveResult) -> str:
    """Return the power balance [%] and how symmetric the scattering matrix is, in one sentence.

    Parameters
    ----------
    result : Solution.
    """
    s_matrix = result.s_matrix
    skew = float(np.abs(s_matrix - s_matrix.T).max())
    return (
        f"Power balance: radiated and accepted power differ by {100.0 * result.balance_error:.2g} "
        f"% at most; the S-matrix is symmetric within {skew:.1e}."
    )
