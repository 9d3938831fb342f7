"""``octant study``: the main job, end to end."""

from pathlib import Path

import click

from octant.reader_design.keeping.workers import prepare_workers
from octant.reader_design.options import Ended, RunOptions, experiment, quick_option

WORKERS_NEED = (
    "octant.reader_design.experiments.study.run",
    "octant.reader_design.experiments.study.figures",
    "matplotlib.backends.backend_agg",
)
"""What workers import while the study is read."""


@click.command()
@quick_option
@experiment()
def study(*, study: Path | None, options: RunOptions, quick: bool) -> Ended:
    """Sweep the reader's design over STUDY, choose one, map the room, drive the missions.

    Leaves results.nc, figures, study.toml and report.html in --out; the same command again goes on
    where the last one stopped. A quick look draws only the first pictures of each part of the page.
    """
    if options.workers != 1 and options.cluster is None and not options.dry_run:
        prepare_workers(WORKERS_NEED)
    from octant.reader_design.experiments.study.run import OUTPUTS, plan_lines, run_study
    from octant.reader_design.keeping.results import files_of
    from octant.reader_design.study_file.loading import load_study
    from octant.reader_design.study_file.tables_read import check_tables

    loaded = options.seeded(load_study(study))
    check_tables(loaded, "study")
    if options.dry_run:
        lines = plan_lines(loaded, options.out, quick=quick, workers=options.workers)
        return Ended(lines=lines)
    outcome = run_study(
        loaded,
        options.out,
        quick=quick,
        force=options.force,
        progress=options.progress,
        workers=options.workers,
        cluster=options.cluster,
        approve=options.approve,
    )
    return Ended(
        lines=outcome.lines(),
        failed=bool(outcome.failed),
        written=files_of(options.out, OUTPUTS),
        tables=tuple(options.out / name for name in ("designs.csv", "missions.csv")),
    )
