"""``octant tolerance``: what build errors do to a study's reader."""

from pathlib import Path

import click

from octant.reader_design.options import (
    QUICK_SAMPLES,
    Ended,
    RunOptions,
    experiment,
    number,
    quick_option,
)
from octant.reader_design.study_file.quantities import Count


@click.command()
@click.option("--samples", type=number(Count), help="Readers built; default: the study's.")
@quick_option
@experiment()
def tolerance(
    *, study: Path | None, options: RunOptions, samples: int | None, quick: bool
) -> Ended:
    """Build the reader of STUDY many times with the errors of its table [tolerance].

    Every reader is solved by full wave and scored as the study's [tolerance] says, as is every
    [[tolerance.rival]] with the same errors. Writes tolerance.nc (every reader), tolerance.csv (one
    row a design and score), study.toml, figures and report.html. The same command again goes on
    where the last one stopped; more --samples keep the readers that are there.
    """
    from octant.reader_design.experiments.tolerance.results import FILES
    from octant.reader_design.experiments.tolerance.run import (
        plan_lines,
        run_tolerance,
        tolerance_cost,
    )
    from octant.reader_design.keeping.results import files_of
    from octant.reader_design.study_file.loading import load_study
    from octant.reader_design.study_file.tables_read import check_tables

    loaded = options.seeded(load_study(study))
    check_tables(loaded, "tolerance")
    samples = QUICK_SAMPLES if samples is None and quick else samples
    if options.dry_run:
        return Ended(lines=plan_lines(loaded, options.out, samples=samples))
    options.approve(tolerance_cost(loaded, samples=samples))
    options.progress.say(plan_lines(loaded, options.out, samples=samples)[0])
    lines = run_tolerance(
        loaded,
        options.out,
        samples=samples,
        workers=options.workers,
        cluster=options.cluster,
        force=options.force,
        progress=options.progress,
    )
    return Ended(
        lines=lines,
        written=files_of(options.out, (*FILES, "figures/*.png")),
        tables=(options.out / "tolerance.csv",),
    )
