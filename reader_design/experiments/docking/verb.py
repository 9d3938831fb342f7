"""``octant dock``: docking missions of a study, and the docking paper's experiments."""

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
from octant.reader_design.terminal.colour import judged

if TYPE_CHECKING:
    from octant.reader_design.drives.files import DriveFile


@click.command()
@click.option("--runs", type=number(Count), help="Runs in each room; default: the study's.")
@drive_options
@quick_option
@experiment()
def dock(
    *,
    study: Path | None,
    options: RunOptions,
    runs: int | None,
    export: "tuple[DriveFile, ...]",
    export_run: tuple[int, ...],
    quick: bool,
) -> Ended:
    """Dock at the station of STUDY from random starts, in its room and in every layout.

    The bearing-sensitive reader brings the robot to the staging place under the station's tag, the
    landmark filter and the docking law finish. Writes docking.csv (one row a run), trajectory.csv
    (run 0), study.toml, figures of the missions and of the docking paper's experiments, and
    report.html; the same command again goes on where the last one stopped. With --export mcap,
    runs in each room are written with ROS 2 messages, with tum and csv as trajectories.
    """
    from octant.reader_design.drives.export import DriveExport, write_drives
    from octant.reader_design.experiments.docking.compute import dock_table
    from octant.reader_design.experiments.docking.logs import docking_logs
    from octant.reader_design.experiments.docking.page import (
        CASES,
        FILES,
        plan_line,
        run_docking_study,
        summary_lines,
    )
    from octant.reader_design.keeping.results import files_of
    from octant.reader_design.study_file.loading import load_study, replace, vary
    from octant.reader_design.study_file.tables_read import check_tables

    loaded, out = options.seeded(load_study(study, built_in="dock_study")), options.out
    check_tables(loaded, "dock")
    runs = runs_wanted(runs, quick=quick)
    if runs is not None:
        loaded = replace(vary(loaded, {"dock.runs": runs}), sweep=loaded.sweep)
    wanted = DriveExport(kinds=export, runs=export_run)
    wanted.check(dock_table(loaded).runs)
    if options.dry_run:
        return Ended(lines=(plan_line(loaded, out),))
    content = run_docking_study(
        loaded,
        out,
        workers=options.workers,
        cluster=options.cluster,
        force=options.force,
        progress=options.progress,
        approve=options.approve,
    )
    drives = write_drives(
        docking_logs(content, wanted.numbers),
        wanted,
        out,
        stamp=out / CASES / "drives.json",
        inputs=[
            loaded,
            [[runs[k] for k in wanted.numbers] for runs in content.results.values()],
        ],
        force=options.force,
        progress=options.progress,
    )
    runs_of_all = [run for each in content.results.values() for run in each]
    return Ended(
        lines=summary_lines(content.results),
        written=(*files_of(out, (*FILES, "figures/*.png")), *drives),
        tables=(out / "docking.csv",),
        verdict=judged(sum(run.success for run in runs_of_all) / len(runs_of_all)),
    )
