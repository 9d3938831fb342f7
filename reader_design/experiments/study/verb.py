"""``octant study``: the main job, end to end."""

from pathlib import Path

import click

from octant.reader_design.cli import InterruptedRunError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options, worker_options

FAILED_CELLS = 3
"""Exit code of a study that finished, but not with scores for every design [-]."""


@click.command()
@click.argument("study", type=click.Path(path_type=Path), required=False)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("octant-study"),
    show_default=True,
    help="Folder for results.",
)
@click.option("--quick", is_flag=True, help="Coarse sampling, a coarse map, few runs.")
@worker_options
@common_options
@click.pass_context
def study(
    ctx: click.Context,
    *,
    study: Path | None,
    out: Path,
    quick: bool,
    workers: int | None,
    cluster: str | None,
    force: bool,
    quiet: bool,
) -> None:
    """Sweep the reader's design over STUDY, choose one, map the room, drive the missions.

    Without STUDY the built-in study of the thesis' reader runs. Leaves results.nc, figures,
    study.toml and report.html in --out; the same command again goes on where the last one stopped.
    """
    from octant.reader_design.experiments.study.run import run_study
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    try:
        outcome = run_study(
            loaded,
            out,
            quick=quick,
            force=force,
            progress=Progress(quiet=quiet),
            workers=workers,
            cluster=cluster,
        )
    except KeyboardInterrupt as exc:
        msg = f"what was computed is kept in {out}; the same command goes on from there."
        raise InterruptedRunError(msg) from exc
    for line in outcome.lines():
        click.echo(line)
    if outcome.failed:
        ctx.exit(FAILED_CELLS)
