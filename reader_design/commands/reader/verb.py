"""``octant reader``: the reader of a study by itself, its ports, patterns and currents."""

import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, PhysicsWarning
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from octant.em.antennas.embedded import ReaderResponse
    from octant.em.reader.fullwave.result import FullwaveResult
    from octant.reader_design.study_file.reader import Reader
    from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

ELEVATIONS_DEG = (0.0, 30.0, 45.0, 60.0)
"""Elevations of the polar cuts [deg]."""
DENSITIES = (8.0, 10.0, 14.0)
"""Elements per wavelength that a convergence study solves with [-]."""
FIGURE_STEP_DEG = 3.0
"""Step of the grid for solids of gain [deg]."""


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder for results.")
@click.option(
    "--step-deg",
    type=click.FloatRange(min=0.5, max=45.0),
    default=2.0,
    show_default=True,
    help="Step of the patterns over theta and phi [deg]; it must divide 180.",
)
@click.option(
    "--model",
    type=click.Choice(["fullwave", "rays", "isolated"]),
    help="How the reader's body enters; default: the study's reader.response.",
)
@click.option(
    "--convergence", is_flag=True, help="Solve with 8, 10 and 14 cells per wavelength too."
)
@common_options
def reader(
    *,
    study: Path,
    out: Path,
    step_deg: float,
    model: str | None,
    convergence: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Solve the reader of STUDY's table [reader] at the carrier frequency.

    Prints impedances, S-matrix and power balance. Writes reader.nc (patterns, impedances, S-matrix
    in the reader's frame), one .ffe file for each antenna, reader.sNp (Touchstone), study.toml, and
    figures of gains, S-matrix and surface currents.
    """
    from msgspec.structs import replace

    from octant.geometries.files import refuse_overwrite, write_text
    from octant.reader_design.study_file.loading import load_study, to_toml

    loaded = load_study(study)
    chosen = model or loaded.reader.response
    loaded = replace(loaded, reader=replace(loaded.reader, response=chosen))
    _check(step_deg, convergence=convergence, model=chosen)
    design = loaded.reader
    ports = design.antennas
    names = ["reader.nc", "study.toml", *(f"antenna_{i + 1}.ffe" for i in range(ports))]
    if chosen == "fullwave":
        names.append(f"reader.s{ports}p")
    files = {name: out / name for name in names}
    refuse_overwrite(*files.values(), force=force)
    progress = Progress(quiet=quiet)
    response, result = _solved(loaded, design, chosen)
    for note in (*design.notes(), *response.warnings):
        warnings.warn(note, PhysicsWarning, stacklevel=1)
    theta, phi, pattern = _sampled(response, result, step_deg)
    write_text(files["study.toml"], to_toml(loaded, relative_to=out))
    _write_patterns(loaded, files, theta, phi, pattern, response=response, result=result)
    alone = _alone(loaded, design)
    drawn = _figures(design, response, result, alone)
    _write_figures(out / "figures", drawn, progress)
    click.echo(_alone_line(design, alone, _alone_gain(alone, theta, phi)))
    for line in _lines(loaded, design, pattern, response=response, result=result):
        click.echo(line)
    if convergence:
        for line in _convergence_lines(loaded, design, progress):
            click.echo(line)
    click.echo(f"written: {', '.join(str(p) for p in files.values())} and {out / 'figures'}")


def _check(step_deg: float, *, convergence: bool, model: str) -> None:
    steps = 180.0 / step_deg
    if abs(steps - round(steps)) > 1e-9:
        msg = f"--step-deg is {step_deg:g} degrees, but it must divide 180 degrees; give 1, 2 or 5."
        raise ConfigError(msg)
    if convergence and model != "fullwave":
        msg = (
            f"--convergence is given, but the model is {model!r}, which has no mesh; leave it out, "
            "or give --model fullwave."
        )
        raise ConfigError(msg)


def _solved(
    study: "Study", design: "Reader", model: str
) -> tuple["ReaderResponse", "FullwaveResult | None"]:
    """Return the reader's response, and the solution behind it where the model has one."""
    frequency_hz = study.radio.frequency_hz
    if model != "fullwave":
        from octant.reader_design.setting.design import response_at

        return response_at(design, frequency_hz, model), None
    from octant.em.reader.fullwave.response import fullwave_response

    return fullwave_response(
        design.body(),
        design.element(frequency_hz),
        cells_per_wavelength=study.reader.cells_per_wavelength,
        **design.feed(),
    )


def _sampled(
    response: "ReaderResponse", result: "FullwaveResult | None", step_deg: float
) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Return angles [rad] and the (n, t, p, 2) patterns, phi from 0 to 2 pi with both ends."""
    rows, columns = round(180.0 / step_deg) + 1, round(360.0 / step_deg)
    theta = np.linspace(0.0, math.pi, rows)
    phi = np.linspace(0.0, 2.0 * math.pi, columns + 1)
    if result is None:
        return theta, phi, response.far_field(theta[:, None], phi)
    pattern = result.pattern_grid(theta, columns)
    return theta, phi, np.concatenate((pattern, pattern[:, :, :1]), axis=2)


def _write_patterns(
    study: "Study",
    files: dict[str, Path],
    theta: FloatArray,
    phi: FloatArray,
    pattern: ComplexArray,
    *,
    response: "ReaderResponse",
    result: "FullwaveResult | None",
) -> None:
    from octant.em.antennas.from_files import pattern_tables
    from octant.em.antennas.pattern_files.ffe import write_ffe
    from octant.em.antennas.pattern_files.touchstone import write_touchstone
    from octant.em.reader.reader_netcdf import write_reader_netcdf

    exact = _on_grid(response, theta, phi[:-1], pattern[:, :, :-1])
    write_reader_netcdf(
        files["reader.nc"],
        exact,
        impedance_ohm=None if result is None else result.input_impedance_ohm,
        s_matrix=None if result is None else result.s_matrix,
    )
    _tell_origin(study, files["reader.nc"], result)
    for i, table in enumerate(pattern_tables(exact)):
        write_ffe(files[f"antenna_{i + 1}.ffe"], [table])
    if result is not None:
        write_touchstone(
            files[f"reader.s{result.ports}p"],
            [result.frequency_hz],
            result.s_matrix[None],
            reference_ohm=study.reader.load_ohm,
        )


def _on_grid(
    response: "ReaderResponse", theta: FloatArray, phi: FloatArray, pattern: ComplexArray
) -> "ReaderResponse":
    """Return the response with patterns on another grid, which are exact on it."""
    from dataclasses import replace

    from octant.em.constants import SPEED_OF_LIGHT_M_PER_S

    st, ct = np.sin(theta)[:, None], np.cos(theta)[:, None]
    flat = np.broadcast_to(ct, (len(theta), len(phi)))
    direction = np.stack((st * np.cos(phi), st * np.sin(phi), flat), axis=-1)
    wavenumber = 2.0 * math.pi * response.frequency_hz / SPEED_OF_LIGHT_M_PER_S
    ahead = wavenumber * np.einsum("tpc,nc->ntp", direction, response.phase_centres_m)
    return replace(response, pattern=np.moveaxis(pattern, -1, 1) * np.exp(-1j * ahead)[:, None])


def _tell_origin(study: "Study", path: Path, result: "FullwaveResult | None") -> None:
    """Add the study, the versions and the quality of the solution to a file of patterns."""
    from octant.reader_design.keeping.versions import versions
    from octant.reader_design.showing.netcdf import read_dataset, variable, write_dataset
    from octant.reader_design.study_file.loading import to_toml

    data = read_dataset(path)
    data.attrs |= {"study": to_toml(study), "seed": study.seed, **versions()}
    if result is not None:
        data["radiated_share"] = variable(
            ["antenna"],
            result.radiated_share,
            units="1",
            long_name="radiated over available power",
        )
        data.attrs |= {
            "load_ohm": study.reader.load_ohm,
            "unknowns": result.unknowns,
            "balance_error": result.balance_error,
        }
    write_dataset(data, path, force=True)


def _alone_gain(alone: "FullwaveResult", theta: FloatArray, phi: FloatArray) -> FloatArray:
    """Return the (t, p) gain of one antenna alone [dBi], mismatch taken out."""
    from octant.reader_design.commands.reader.figures import gain_dbi

    pattern = alone.far_field(theta[:, None], phi)[0]
    return gain_dbi(pattern / math.sqrt(float(alone.accepted_share[0])))


def _figures(
    design: "Reader",
    response: "ReaderResponse",
    result: "FullwaveResult | None",
    alone: "FullwaveResult",
) -> Iterator[tuple[str, "Figure"]]:
    """Yield the name and each figure of the reader."""
    from octant.reader_design.commands.reader.figures import (
        current_figure,
        cuts_figure,
        element_figure,
        gain_dbi,
        gain_figure,
        s_matrix_figure,
    )

    label = design.label()
    theta, phi, pattern = _sampled(response, result, FIGURE_STEP_DEG)
    single = _alone_gain(alone, theta, phi)
    yield (
        "element",
        element_figure(theta, phi, single, title=f"A single {design.antenna}, alone"),
    )
    cuts = [
        (float(e), gain_dbi(response.far_field(math.radians(90.0 - e), phi)))
        for e in ELEVATIONS_DEG
    ]
    yield (
        "cuts",
        cuts_figure(phi, cuts, response.azimuths_rad, title=f"All antennas: {label}"),
    )
    gain = gain_dbi(pattern[0])
    yield "gain_antenna_1", gain_figure(theta, phi, gain, title=f"Antenna 1: {label}")
    if result is None:
        return
    from octant.em.reader.surface_currents import current_density_a_per_m

    yield "s_matrix", s_matrix_figure(result.s_matrix, title=f"S-matrix: {label}")
    yield (
        "currents_antenna_1",
        current_figure(
            result.basis.corners_m,
            current_density_a_per_m(result, 0),
            title=f"Surface current, antenna 1 driven: {label}",
        ),
    )


def _alone(study: "Study", design: "Reader") -> "FullwaveResult":
    """Return the solution of one antenna alone: a dipole, or a monopole on its own plane."""
    from octant.em.reader.fullwave.single import dipole_mesh, monopole_mesh
    from octant.em.reader.fullwave.solve import solve_reader

    element = design.element(study.radio.frequency_hz)
    if design.antenna == "dipole":
        mesh = dipole_mesh(
            frequency_hz=element.frequency_hz,
            length_m=element.length_m,
            wire_radius_m=design.wire_radius_m,
            feed_gap_m=design.feed_gap_m,
        )
    else:
        mesh = monopole_mesh(
            frequency_hz=element.frequency_hz,
            plane_m=design.monopole_plane_m or design.ground_plane_m,
            length_m=element.length_m,
            wire_radius_m=design.wire_radius_m,
            feed_gap_m=design.feed_gap_m,
        )
    return solve_reader(mesh, load_ohm=design.load_ohm)


def _alone_line(design: "Reader", alone: "FullwaveResult", gain: FloatArray) -> str:
    """Return impedance and gain of one antenna alone, in one sentence."""
    z, top = alone.input_impedance_ohm[0], float(gain.max())
    accepted = 10.0 * math.log10(float(alone.accepted_share[0]))
    return (
        f"A single {design.antenna} alone: {z.real:.1f}{z.imag:+.1f}j ohm, gain {top:.2f} dBi, "
        f"realised at {design.load_ohm:g} ohm {top + accepted:.2f} dBi."
    )


def _write_figures(folder: Path, drawn: Iterator[tuple[str, "Figure"]], progress: Progress) -> None:
    from octant.reader_design.showing.style import save_figure

    for name, figure in progress.track(drawn, label="figures"):
        save_figure(figure, folder / f"{name}.png")


def _lines(
    study: "Study",
    design: "Reader",
    pattern: ComplexArray,
    *,
    response: "ReaderResponse",
    result: "FullwaveResult | None",
) -> Iterator[str]:
    """Yield what a person wants to read about the reader."""
    from octant.reader_design.commands.reader.figures import gain_dbi
    from octant.reader_design.commands.reader.lines import balance_line, port_lines, s_matrix_lines

    peak = gain_dbi(pattern).max(axis=(1, 2))
    head = f"{design.label()} at {response.frequency_hz / 1e9:g} GHz, model {response.model}"
    if result is None:
        yield f"{head}: patterns only, the antennas count as matched."
        yield "greatest gain [dBi]: " + ", ".join(f"{g:.2f}" for g in peak)
        return
    yield (
        f"{head}: {result.unknowns} unknowns at {study.reader.cells_per_wavelength:g} cells per "
        f"wavelength, loads of {study.reader.load_ohm:g} ohm."
    )
    yield from port_lines(result, response.azimuths_rad, peak)
    yield from s_matrix_lines(result.s_matrix)
    yield balance_line(result)


def _convergence_lines(study: "Study", design: "Reader", progress: Progress) -> Iterator[str]:
    """Yield how impedances and gains move with the mesh."""
    from octant.em.reader.fullwave.convergence import convergence_study
    from octant.em.reader.fullwave.response import fullwave_response

    def solve(cells: float) -> "FullwaveResult":
        progress.say(f"convergence: {cells:g} cells per wavelength")
        return fullwave_response(
            design.body(),
            design.element(study.radio.frequency_hz),
            cells_per_wavelength=cells,
            **design.feed(),
        )[1]

    yield "Convergence, against the finest mesh:"
    yield from convergence_study(solve, DENSITIES).lines()
