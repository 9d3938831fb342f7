"""``octant sweep``: every combination of a study's ``[sweep]``, scored, in one table."""

from pathlib import Path

import click

from octant.reader_design.cli import InterruptedRunError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options, worker_options

FAILED_CELLS = 3
"""Exit code of a sweep that finished, but not with scores for every cell [-]."""


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder for results.")
@worker_options
@click.option("--dry-run", is_flag=True, help="Only say what would be computed, and what it takes.")
@click.option("--merge", is_flag=True, help="Only make the tables of what is computed already.")
@common_options
@click.pass_context
def sweep(
    ctx: click.Context,
    *,
    study: Path,
    out: Path,
    workers: int | None,
    cluster: str | None,
    dry_run: bool,
    merge: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Score every combination of the values in STUDY's table [sweep].

    Leaves one small file a cell in --out/cells, sweep.nc and sweep.csv with all scores, and
    study.toml. However a run ends, the same command goes on where it stopped.
    """
    from octant.reader_design.experiments.sweep.dry_run import plan_lines
    from octant.reader_design.experiments.sweep.job import study_plan, sweep_study
    from octant.reader_design.experiments.sweep.table import known_rows
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    progress = Progress(quiet=quiet)
    if dry_run:
        plan = study_plan(loaded)
        rows = known_rows(plan, out, progress=progress)
        for line in plan_lines(plan, rows, workers=workers):
            click.echo(line)
        return
    try:
        outcome = sweep_study(
            loaded,
            out,
            workers=workers,
            cluster=cluster,
            merge_only=merge,
            force=force,
            progress=progress,
        )
    except KeyboardInterrupt as exc:
        msg = f"what was computed is kept in {out}; the same command goes on from there."
        raise InterruptedRunError(msg) from exc
    for line in outcome.lines():
        click.echo(line)
    if outcome.failed:
        ctx.exit(FAILED_CELLS)
