"""``octant tolerance``: what build errors do to a study's reader."""

from pathlib import Path

import click

from octant.reader_design.cli import InterruptedRunError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options


@click.command()
@click.argument("study", type=click.Path(path_type=Path), required=False)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("octant-tolerance"),
    show_default=True,
    help="Folder for results.",
)
@click.option("--samples", type=click.IntRange(min=1), help="Readers built; default: the study's.")
@click.option(
    "--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Processes."
)
@common_options
def tolerance(
    *, study: Path | None, out: Path, samples: int | None, workers: int, force: bool, quiet: bool
) -> None:
    """Build the reader of STUDY many times with the errors of its table [tolerance].

    Every reader is solved by full wave and scored as the study's [tolerance] says, as is every
    [[tolerance.rival]] with the same errors. Writes tolerance.nc (every reader), tolerance.csv (one
    row a design and score), study.toml, figures and report.html. The same command again goes on
    where the last one stopped; more --samples (with --force) keep those that are there.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.experiments.tolerance.results import FILES, write_results
    from octant.reader_design.experiments.tolerance.study import run_tolerance_study
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    files = [out / name for name in FILES]
    refuse_overwrite(*files, force=force)
    try:
        result = run_tolerance_study(
            loaded, out / "cases", samples=samples, workers=workers, progress=Progress(quiet=quiet)
        )
    except KeyboardInterrupt as exc:
        msg = f"what was computed is kept in {out}; the same command goes on from there."
        raise InterruptedRunError(msg) from exc
    for line in write_results(result, out).paragraphs:
        click.echo(line)
    click.echo(f"written: {', '.join(str(p) for p in files)} and {out / 'figures'}")
