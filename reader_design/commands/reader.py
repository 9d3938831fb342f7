"""``octant reader``: the reader of a study by itself, its ports, patterns and currents."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click
from msgspec import Meta

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import FREQUENCIES, approve, common_options, number

if TYPE_CHECKING:
    from octant.reader_design.study_file.schema import Study


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder for results.")
@click.option(
    "--step-deg",
    type=number(Annotated[float, Meta(ge=0.5, le=45.0)]),
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
    "--frequencies",
    type=FREQUENCIES,
    help="Band over which the ports are solved [Hz], or frequencies with commas; default: the "
    "study's radio.channels_hz.",
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
    frequencies: tuple[float, ...] | None,
    convergence: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Solve the reader of STUDY's table [reader] at the carrier frequency.

    Prints impedances, S-matrix and power balance. Writes reader.nc (patterns, impedances, S-matrix
    in the reader's frame), one .ffe file for each antenna, reader.sNp (Touchstone), study.toml, and
    figures of gains, S-matrix and surface currents. Over a band, reader.sNp has a point for each
    frequency, and band.csv and a figure show impedance and return loss.
    """
    from msgspec.structs import replace

    from octant.geometries.files import refuse_overwrite, write_text
    from octant.reader_design.face.reader import check_step, solve_reader_of
    from octant.reader_design.face.reader_band import band_of, solutions_of
    from octant.reader_design.keeping.keys import digest
    from octant.reader_design.keeping.versions import versions
    from octant.reader_design.setting.cost import reader_cost
    from octant.reader_design.showing.netcdf import inputs_of, write_dataset
    from octant.reader_design.showing.style import save_figure
    from octant.reader_design.study_file.loading import load_study, to_toml

    loaded = _with_model(load_study(study), model)
    chosen = loaded.reader.response
    check_step(step_deg, name="--step-deg")
    if convergence and chosen != "fullwave":
        msg = (
            f"--convergence is given, but the model is {chosen!r}, which has no mesh; leave it "
            "out, or give --model fullwave."
        )
        raise ConfigError(msg)
    band_hz = _band_hz(loaded, frequencies)
    ports = loaded.reader.antennas
    names = ["reader.nc", "study.toml", *(f"antenna_{i + 1}.ffe" for i in range(ports))]
    if chosen == "fullwave":
        names.append(f"reader.s{ports}p")
    names += ["band.csv"] if band_hz else []
    files = [out / name for name in names]
    inputs = digest([loaded, step_deg, band_hz, versions()])
    refuse_overwrite(*files, force=force or inputs_of(files[0]) == inputs)
    progress = Progress(quiet=quiet)
    highest = replace(loaded.radio, channels_hz=band_hz[-1:])
    solutions = 1 + (solutions_of(band_hz) if band_hz else 0)
    cost = reader_cost(replace(loaded, radio=highest))
    approve(cost.times(solutions, "solutions", "--frequencies"), progress)
    solved = solve_reader_of(
        loaded, [loaded.radio.frequency_hz], step_deg=step_deg, progress=progress
    )
    write_dataset(solved.dataset().assign_attrs(inputs=inputs), files[0], force=True)
    write_text(out / "study.toml", to_toml(loaded, relative_to=out))
    solved.to_ffe(out)
    band = band_of(loaded, band_hz, progress=progress) if band_hz else None
    if band:
        band.to_touchstone(out / f"reader.s{ports}p")
        band.to_csv(out / "band.csv")
        save_figure(band.figure(), out / "figures" / "return_loss.png")
    elif solved.results:
        solved.to_touchstone(out / "reader")
    with progress.track(solved.figures(), label="figures") as figures:
        for name, figure in figures:
            save_figure(figure, out / "figures" / f"{name}.png")
    for line in (*solved.alone_lines(), *solved.lines(), *(band.lines() if band else ())):
        click.echo(line)
    if convergence:
        for line in solved.convergence_lines(progress=progress):
            click.echo(line)
    click.echo(f"written: {', '.join(str(p) for p in files)} and {out / 'figures'}")


def _with_model(study: "Study", model: str | None) -> "Study":
    """Return a study whose reader's response is of a model, if one is given."""
    from msgspec.structs import replace

    design = replace(study.reader, response=model or study.reader.response)
    if design.response != "files":
        design = replace(design, pattern_files=(), pattern_turn="none")
    return replace(study, reader=design)


def _band_hz(study: "Study", frequencies: tuple[float, ...] | None) -> tuple[float, ...]:
    """Return the band over which the ports are solved [Hz]; nothing where there is none."""
    response = study.reader.response
    if frequencies and response != "fullwave":
        msg = (
            f"--frequencies is given, but the model is {response!r}, which gives patterns only; "
            "leave it out, or give --model fullwave."
        )
        raise ConfigError(msg)
    band = frequencies or tuple(sorted(set(study.radio.channels_hz)))
    return band if response == "fullwave" and len(band) > 1 else ()
