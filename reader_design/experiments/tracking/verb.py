"""``octant track``: the controllers of thesis chapters 6 and 7."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from octant.reader_design.options import (
    Ended,
    RunOptions,
    drive_options,
    experiment,
    number,
    quick_option,
    runs_wanted,
)
from octant.reader_design.study_file.quantities import Count

if TYPE_CHECKING:
    from octant.reader_design.drives.files import DriveFile


@click.command()
@click.option(
    "--runs",
    type=number(Count),
    help="Repetitions of every drive, of SLAM too; default: the study's.",
)
@drive_options
@quick_option
@experiment()
def track(
    *,
    study: Path | None,
    options: RunOptions,
    runs: int | None,
    export: "tuple[DriveFile, ...]",
    export_run: tuple[int, ...],
    quick: bool,
) -> Ended:
    """Follow trajectories from the RSS of tags, by every controller and estimator.

    Measurement feedback, nominal and neighbouring optimal control, EKF SLAM, and the same with RSS
    from the room solver; track.chapters of STUDY names which, and further ones. Writes results.nc,
    tracking.csv, costs.csv, slam.csv, a table of each further chapter, figures, study.toml and
    report.html to --out; the same command again goes on where the last one stopped. With --export
    mcap, runs of every method are written with ROS 2 messages, with tum and csv as trajectories.
    """
    from octant.reader_design.drives.export import DriveExport, write_drives
    from octant.reader_design.experiments.tracking.compute import (
        CASES,
        plan_line,
        run_tracking,
        with_repetitions,
    )
    from octant.reader_design.experiments.tracking.logs import tracking_logs
    from octant.reader_design.experiments.tracking.page import summary_lines
    from octant.reader_design.keeping.results import files_of
    from octant.reader_design.study_file.loading import load_study
    from octant.reader_design.study_file.tables_read import check_tables

    loaded = load_study(study, built_in="track_study")
    check_tables(loaded, "track")
    loaded = with_repetitions(loaded, runs=runs_wanted(runs, quick=quick), seed=options.seed)
    wanted = DriveExport(kinds=export, runs=export_run)
    wanted.check(1 if loaded.track is None else loaded.track.runs)
    if options.dry_run:
        return Ended(lines=(plan_line(loaded, options.out),))
    content = run_tracking(
        loaded,
        options.out,
        workers=options.workers,
        cluster=options.cluster,
        force=options.force,
        progress=options.progress,
        approve=options.approve,
    )
    drives = write_drives(
        tracking_logs(content, wanted.numbers),
        wanted,
        options.out,
        stamp=options.out / CASES / "drives.json",
        inputs=[loaded, content.outcomes],
        force=options.force,
        progress=options.progress,
    )
    tables = sorted(options.out.glob("*.csv"))
    return Ended(
        lines=tuple(summary_lines(content)),
        written=(
            *files_of(options.out, ("report.html", "results.nc", "*.csv", "figures/*.png")),
            *drives,
        ),
        tables=tuple(tables),
    )
