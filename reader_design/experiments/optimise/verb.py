"""``octant optimise``: search for a reader design that reaches the goals of a study."""

from pathlib import Path

import click

from octant.reader_design.cli import InterruptedRunError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("octant-optimise"),
    show_default=True,
    help="Folder for results.",
)
@click.option("--dry-run", is_flag=True, help="Say what would be computed, and leave.")
@common_options
def optimise(*, study: Path, out: Path, dry_run: bool, force: bool, quiet: bool) -> None:
    """Search for a reader as the table [optimise] of STUDY asks: survey, then refinement.

    Leaves optimise.csv (every design), pareto.csv, best.toml (the study with the chosen reader),
    figures, a drawing to build from (PNG, SVG, PDF), study.toml and report.html in --out. Every
    evaluation is kept there; the same command again goes on where the last one stopped.
    """
    from octant.reader_design.experiments.optimise.run import plan_lines, run_optimise
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    if dry_run:
        for line in plan_lines(loaded, out):
            click.echo(line)
        return
    try:
        outcome = run_optimise(loaded, out, force=force, progress=Progress(quiet=quiet))
    except KeyboardInterrupt as exc:
        msg = f"what was computed is kept in {out}; the same command goes on from there."
        raise InterruptedRunError(msg) from exc
    for line in outcome.lines():
        click.echo(line)
