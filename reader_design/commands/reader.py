"""``octant reader``: the reader of a study by itself, its ports, patterns and currents."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click
from msgspec import Meta

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import (
    BAND_GHZ,
    FREQUENCIES,
    approve,
    common_options,
    dry_run_option,
    json_option,
    number,
    out_option,
    print_plan,
    study_argument,
    written_line,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import numpy as np
    import numpy.typing as npt
    import xarray as xr

    from octant.reader_design.face.reader import SolvedReader
    from octant.reader_design.face.reader_measured import MeasuredReader
    from octant.reader_design.study_file.schema import Study


EFFICIENCIES = ("radiated_share", "radiation_efficiency")
_EXPORTS = {"svg": "drawing.svg", "dxf": "drawing.dxf", "mat": "reader.mat"}


@click.command()
@study_argument
@out_option("octant-reader")
@click.option(
    "--step-deg",
    type=number(Annotated[float, Meta(ge=0.5, le=45.0)]),
    metavar="DEG",
    default=2.0,
    show_default=True,
    help="Step of the patterns over theta and phi [deg], 0.5 to 45; it must divide 180.",
)
@click.option(
    "--model",
    type=click.Choice(["fullwave", "rays", "isolated"]),
    help="How the reader's body enters; default: the study's reader.response.",
)
@click.option(
    "--frequencies",
    type=FREQUENCIES,
    help="Band over which the ports are solved [Hz], or frequencies with commas; default: the "
    "study's radio.channels_hz.",
)
@click.option("--band", "band_ghz", type=BAND_GHZ, help="The same in GHz, such as 2.3:2.5:41.")
@click.option(
    "--convergence", is_flag=True, help="Solve with 8, 10 and 14 cells per wavelength too."
)
@click.option(
    "--export",
    type=click.Choice(["svg", "dxf", "mat"]),
    multiple=True,
    help="Also write the workshop's drawing (SVG, DXF) or everything for MATLAB; may be repeated.",
)
@click.option(
    "--measured",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    multiple=True,
    metavar="FILE",
    help="Compare with a measured reader: its Touchstone file, or a pattern file for each antenna; "
    "may be repeated.",
)
@click.option(
    "--tilts",
    type=number(Annotated[float, Meta(ge=1.0, le=90.0)]),
    metavar="DEG",
    help="Table over tags of every tilt, in steps of so many degrees, 1 to 90, that divide 180.",
)
@click.option(
    "--tilts-elevation",
    type=number(Annotated[float, Meta(ge=0.0, le=89.0)]),
    metavar="DEG",
    default=17.0,
    show_default=True,
    help="Elevation of those tags over the horizon [deg], 0 to 89.",
)
@dry_run_option
@json_option
@common_options
def reader(
    *,
    study: Path | None,
    out: Path,
    step_deg: float,
    model: str | None,
    frequencies: tuple[float, ...] | None,
    band_ghz: tuple[float, ...] | None,
    convergence: bool,
    export: tuple[str, ...],
    measured: tuple[Path, ...],
    tilts: float | None,
    tilts_elevation: float,
    dry_run: bool,
    as_json: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Solve the reader of STUDY's table [reader] at the carrier frequency.

    Prints impedances, S-matrix and power balance. Writes reader.nc (patterns, impedances, S-matrix
    in the reader's frame), one .ffe file for each antenna, reader.sNp (Touchstone), study.toml, and
    figures of gains, S-matrix and surface currents. Over a band, reader.sNp has a point for each
    frequency, and band.csv, reader.nc and figures (Smith chart, return loss, isolation, efficiency
    and gain) show ports and patterns over it. It says whether the antennas are matched to their
    loads, and which load or network would match them. With --export, drawing.svg and
    drawing.dxf are the reader to scale with all its lengths, and reader.mat is for MATLAB. With
    --measured, the report has what was measured beside what was computed. With --tilts, tilts.csv
    and a table say what tags of unknown tilt lose, and where the strongest antenna is next to them.
    """
    from msgspec.structs import replace

    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.reader import check_step, solve_reader_of
    from octant.reader_design.face.reader_band import solutions_of
    from octant.reader_design.face.reader_measured import measured_reader
    from octant.reader_design.keeping.keys import digest
    from octant.reader_design.keeping.results import complete_line
    from octant.reader_design.keeping.versions import versions
    from octant.reader_design.setting.cost import reader_cost
    from octant.reader_design.showing.netcdf import inputs_of, read_dataset, write_dataset
    from octant.reader_design.study_file.loading import load_study

    loaded = _with_model(load_study(study), model)
    chosen = loaded.reader.response
    check_step(step_deg, name="--step-deg")
    check_step(tilts or step_deg, name="--tilts")
    if convergence and chosen != "fullwave":
        msg = (
            f"--convergence is given, but the model is {chosen!r}, which has no mesh; leave it "
            "out, or give --model fullwave."
        )
        raise ConfigError(msg)
    band_hz = _band_hz(loaded, frequencies, band_ghz)
    names = _file_names(loaded, chosen, export, over_band=bool(band_hz), tilts=tilts)
    files = [out / name for name in names]
    seen = [file.resolve() for file in measured]
    inputs = digest(
        [loaded, step_deg, band_hz, convergence, seen, tilts, tilts_elevation, versions()]
    )
    known = inputs_of(files[0]) == inputs
    progress = Progress(quiet=quiet)
    written = [*files, out / "figures", out / "report.html"]
    if known and not force and all(place.exists() for place in written):
        data = read_dataset(files[0])
        if "summary" in data.attrs:  # else the run ended before its figures did
            progress.say(complete_line(out))
            _print_result(data, written, study=study, as_json=as_json)
            return
    refuse_overwrite(*files, force=force or known)
    highest = replace(loaded.radio, channels_hz=band_hz[-1:])
    solutions = 1 + (solutions_of(band_hz) if band_hz else 0)
    cost = reader_cost(replace(loaded, radio=highest)).times(
        solutions, "solutions", "--frequencies"
    )
    if dry_run:
        print_plan(f"{cost.text()}.", as_json=as_json)
        return
    approve(cost, progress)
    solved = solve_reader_of(
        loaded, [loaded.radio.frequency_hz], step_deg=step_deg, progress=progress
    )
    beside = measured_reader(solved, measured) if measured else None
    write_dataset(data := solved.dataset().assign_attrs(inputs=inputs), files[0], force=True)
    lines, over_band = _write_rest(solved, out, band_hz, beside=beside, progress=progress)
    if tilts is not None:
        lines += _tilt_lines(solved, out, tilts, tilts_elevation)
    lines += solved.convergence_lines(progress=progress) if convergence else ()
    data = data.assign(over_band).assign_attrs(summary="\n".join(lines))
    write_dataset(data, files[0], force=True)
    _write_exports(solved, out, export)
    _print_result(data, written, study=study, as_json=as_json)


def _file_names(
    study: "Study", model: str, export: tuple[str, ...], *, over_band: bool, tilts: float | None
) -> list[str]:
    """Return the names of all files but report and figures; refuse those that cannot be written."""
    from octant.reader_design.showing.dxf_files import check_dxf

    ports = study.reader.antennas
    names = ["reader.nc", "study.toml", *(f"antenna_{i + 1}.ffe" for i in range(ports))]
    if model in {"fullwave", "metal"}:
        names.append(f"reader.s{ports}p")
    names += ["band.csv"] if over_band else []
    names += [] if tilts is None else ["tilts.csv"]
    if "dxf" in export:
        check_dxf()
    if set(export) & {"svg", "dxf"} and not study.reader.drawn:
        msg = (
            f"--export asks for a drawing, but reader.response is {study.reader.response!r}, whose "
            "metal Octant does not draw; leave svg and dxf out."
        )
        raise ConfigError(msg)
    return names + [_EXPORTS[kind] for kind in dict.fromkeys(export)]


def _tilt_lines(
    solved: "SolvedReader", out: Path, step_deg: float, elevation_deg: float
) -> "Iterator[str]":
    """Yield the table over tags of every tilt, which is written too."""
    from octant.reader_design.face.reader_tilts import tilt_table

    table = tilt_table(solved.responses[0], step_deg=step_deg, elevation_deg=elevation_deg)
    table.to_csv(out / "tilts.csv")
    yield from table.lines()


def _write_exports(solved: "SolvedReader", out: Path, export: tuple[str, ...]) -> None:
    """Write the drawings, and the file for MATLAB."""
    from octant.reader_design.showing.dxf_files import write_dxf
    from octant.reader_design.showing.workshop import drawing, drawing_scale, save_drawing

    study = solved.study
    if set(export) & {"svg", "dxf"}:
        sheet = drawing(study.reader, frequency_hz=study.radio.frequency_hz, title=study.name)
        if "svg" in export:
            save_drawing(sheet, out / _EXPORTS["svg"])
        if "dxf" in export:
            write_dxf(sheet, out / _EXPORTS["dxf"], scale=drawing_scale(study.reader))
    if "mat" in export:
        solved.to_mat(out / _EXPORTS["mat"])


def _write_rest(
    solved: "SolvedReader",
    out: Path,
    band_hz: tuple[float, ...],
    *,
    beside: "MeasuredReader | None",
    progress: Progress,
) -> "tuple[list[str], dict[str, xr.Variable]]":
    """Return what is worth saying, and what reader.nc has of the band; write all the rest."""
    from octant.geometries.files import write_text
    from octant.reader_design.face.reader_band import band_of
    from octant.reader_design.face.reader_page import reader_report
    from octant.reader_design.showing.pages import render_report
    from octant.reader_design.showing.style import save_figure
    from octant.reader_design.study_file.loading import to_toml

    study = solved.study
    write_text(out / "study.toml", to_toml(study, relative_to=out))
    solved.to_ffe(out)
    band = band_of(study, band_hz, progress=progress) if band_hz else None
    if band:
        band.to_touchstone(out / f"reader.s{study.reader.antennas}p")
        band.to_csv(out / "band.csv")
        for name, figure in band.figures():
            save_figure(figure, out / "figures" / f"{name}.png")
    elif solved.results:
        solved.to_touchstone(out / "reader")
    with progress.track(solved.figures(), label="figures") as figures:
        for name, figure in figures:
            save_figure(figure, out / "figures" / f"{name}.png")
    # Over a band the sentences on matching tell more than those at one frequency.
    own = solved.lines(matching=band is None)
    lines = [*solved.alone_lines(), *own, *(band.lines() if band else ())]
    if beside is not None:
        lines += beside.lines()
        cuts = beside.figure()
        if cuts is not None:
            save_figure(cuts, out / "figures" / "measured.png")
    page = reader_report(solved, out, lines, beside=beside)
    write_text(out / "report.html", render_report(page))
    return lines, band.variables() if band else {}


def _print_result(
    data: "xr.Dataset", written: "Sequence[Path]", *, study: Path | None, as_json: bool
) -> None:
    """Print what was found about the reader: sentences, or a document."""
    from octant.reader_design.terminal.documents import csv_rows, json_text

    if not as_json:
        for line in data.attrs["summary"].splitlines():
            click.echo(line)
        click.echo(written_line(written))
        return
    named = ("impedance_ohm", "s_matrix")
    document = {
        "verb": "reader",
        "study": study,
        "model": data.attrs["model"],
        "frequency_hz": float(data["frequency_hz"]),
        **{name: _complex(data[name]) if name in data else None for name in named},
        **{name: data[name].to_numpy() if name in data else None for name in EFFICIENCIES},
        "band": [row for file in written if file.name == "band.csv" for row in csv_rows(file)],
        "tilts": [row for file in written if file.name == "tilts.csv" for row in csv_rows(file)],
        "summary": data.attrs["summary"].splitlines(),
        "written": written,
    }
    click.echo(json_text(document))


def _complex(values: "xr.DataArray") -> "npt.NDArray[np.complex128]":
    """Return complex numbers of an array whose last dimension is ``part``."""
    pairs = values.transpose(..., "part").to_numpy()
    return pairs[..., 0] + 1j * pairs[..., 1]


def _with_model(study: "Study", model: str | None) -> "Study":
    """Return a study whose reader's response is of a model, if one is given."""
    from msgspec.structs import replace

    from octant.reader_design.study_file.reader import check_conductor
    from octant.reader_design.study_file.reader_feed import check_feed
    from octant.reader_design.study_file.reader_metal import check_metal

    design = replace(study.reader, response=model or study.reader.response)
    if design.response != "files":
        design = replace(design, pattern_files=(), pattern_turn="none")
    check_metal(
        design.bodies,
        design.ports,
        antennas=design.antennas,
        response=design.response,
        ground=design.ground,
    )
    check_conductor(design)
    if design.line is not None:
        check_feed(design.line, antennas=design.antennas, response=design.response)
    return replace(study, reader=design)


def _band_hz(
    study: "Study", frequencies: tuple[float, ...] | None, band: tuple[float, ...] | None
) -> tuple[float, ...]:
    """Return the band over which the ports are solved [Hz]; nothing where there is none."""
    response = study.reader.response
    if frequencies and band:
        msg = "--frequencies and --band are both given, but there is one band; give one."
        raise ConfigError(msg)
    asked = frequencies or band
    if asked and not study.reader.has_ports:
        msg = (
            f"{'--frequencies' if frequencies else '--band'} is given, but the model is "
            f"{response!r}, which gives patterns only; leave it out, or give --model fullwave."
        )
        raise ConfigError(msg)
    found = asked or tuple(sorted(set(study.radio.channels_hz)))
    return found if study.reader.has_ports and len(found) > 1 else ()
