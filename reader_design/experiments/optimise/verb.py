"""``octant optimise``: search for a reader design that reaches the goals of a study."""

import math
from pathlib import Path

import click

from octant.reader_design.options import Ended, RunOptions, experiment


@click.command()
@experiment()
def optimise(*, study: Path | None, options: RunOptions) -> Ended:
    """Search for a reader as the table [optimise] of STUDY asks: survey, then refinement.

    Leaves optimise.csv (every design), pareto.csv, best.toml (the study with the chosen reader),
    figures, a drawing to build from (PNG, SVG, PDF), study.toml and report.html in --out. Every
    evaluation is kept there; the same command again goes on where the last one stopped.
    """
    from octant.reader_design.experiments.optimise.run import OUTPUTS, plan_lines, run_optimise
    from octant.reader_design.experiments.optimise.search import planned_evaluations
    from octant.reader_design.keeping.results import files_of
    from octant.reader_design.setting.cost import reader_cost
    from octant.reader_design.study_file.loading import load_study
    from octant.reader_design.study_file.optimise import Optimise
    from octant.reader_design.study_file.tables_read import check_tables

    loaded = options.seeded(load_study(study))
    check_tables(loaded, "optimise")
    choices = (loaded.optimise or Optimise()).choices.given().values()
    surveyed = math.prod(float(len(values)) for values in choices)
    designs = reader_cost(loaded).times(surveyed, "combinations of choices", "optimise.choices")
    options.approve(designs)
    if options.dry_run:
        return Ended(lines=plan_lines(loaded, options.out))
    most = planned_evaluations(loaded, loaded.optimise or Optimise())
    options.approve(reader_cost(loaded).times(most, "designs", "optimise.survey", "evaluations"))
    outcome = run_optimise(
        loaded,
        options.out,
        force=options.force,
        workers=options.workers,
        cluster=options.cluster,
        progress=options.progress,
    )
    return Ended(
        lines=outcome.lines(),
        written=files_of(options.out, OUTPUTS),
        tables=tuple(options.out / name for name in ("optimise.csv", "pareto.csv")),
    )
