"""``octant dock``: docking missions of a study, and the docking paper's experiments."""

from pathlib import Path

import click

from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options


@click.command()
@click.argument("study", type=click.Path(path_type=Path), required=False)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("octant-dock"),
    show_default=True,
    help="Folder for results.",
)
@click.option("--runs", type=click.IntRange(min=1), help="Runs in each room; default: the study's.")
@click.option(
    "--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Processes."
)
@common_options
def dock(
    *, study: Path | None, out: Path, runs: int | None, workers: int, force: bool, quiet: bool
) -> None:
    """Dock at the station of STUDY from random starts, in its room and in every layout.

    The bearing-sensitive reader brings the robot to the staging place under the station's tag, the
    landmark filter and the docking law finish. Without STUDY a built-in station in a concrete room
    is used. Writes docking.csv (one row a run), trajectory.csv (run 0), study.toml, figures of the
    missions and of the docking paper's experiments, and report.html.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.experiments.docking.compute import (
        FILES,
        docking_rooms,
        run_docking_study,
    )
    from octant.reader_design.setting.links import study_responses
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study, built_in="dock_study")
    files = [out / name for name in FILES]
    refuse_overwrite(*files, force=force)
    rooms = docking_rooms(loaded)  # a bad station is refused before anything is computed
    progress = Progress(quiet=quiet)
    for note in dict.fromkeys(note for room in rooms for note in room.notes):
        progress.say(note)
    responses = study_responses(loaded)
    lines = run_docking_study(
        loaded, rooms, responses, out, runs=runs, workers=workers, progress=progress
    )
    for line in lines:
        click.echo(line)
    click.echo(f"written: {', '.join(str(p) for p in files)} and {out / 'figures'}")
