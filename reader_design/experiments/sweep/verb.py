"""``octant sweep``: every combination of a study's ``[sweep]``, scored, in one table."""

from pathlib import Path

import click

from octant.reader_design.options import Ended, RunOptions, experiment


@click.command()
@click.option("--merge", is_flag=True, help="Only make the tables of what is computed already.")
@experiment()
def sweep(*, study: Path | None, options: RunOptions, merge: bool) -> Ended:
    """Score every combination of the values in STUDY's table [sweep].

    Leaves one small file a cell in --out/cells, sweep.nc and sweep.csv with all scores, and
    study.toml; report.html shows them side by side. However a run ends, the same command goes on
    where it stopped.
    """
    from octant.geometries.files import write_text
    from octant.reader_design.experiments.sweep.compute import study_plan, sweep_study
    from octant.reader_design.experiments.sweep.cost import plan_lines
    from octant.reader_design.experiments.sweep.page import sweep_report
    from octant.reader_design.experiments.sweep.results import open_sweep
    from octant.reader_design.experiments.sweep.table import CSV_FILE, TABLE_FILE, known_rows
    from octant.reader_design.keeping.results import files_of
    from octant.reader_design.setting.cost import sweep_cost
    from octant.reader_design.setting.setting import Sampling
    from octant.reader_design.showing.pages import render_report
    from octant.reader_design.study_file.loading import load_study, to_toml
    from octant.reader_design.study_file.tables_read import check_tables

    loaded = options.seeded(load_study(study))
    check_tables(loaded, "sweep")
    if options.dry_run:
        plan = study_plan(loaded)
        rows = known_rows(plan, options.out, progress=options.progress)
        return Ended(lines=plan_lines(plan, rows, workers=options.workers))
    if not merge:
        cost = sweep_cost(
            loaded, room_spacing_m=Sampling().room_spacing_m, room_azimuths=Sampling().room_azimuths
        )
        options.approve(cost)
    outcome = sweep_study(
        loaded,
        options.out,
        workers=options.workers,
        cluster=options.cluster,
        merge_only=merge,
        force=options.force,
        progress=options.progress,
    )
    if outcome.scored_count:
        text = to_toml(loaded, relative_to=options.out)
        page = render_report(sweep_report(open_sweep(options.out), text))
        report = options.out / "report.html"
        if not report.is_file() or report.read_bytes() != page.encode("utf-8"):
            write_text(report, page)
    return Ended(
        lines=outcome.lines(),
        failed=bool(outcome.failed),
        written=files_of(options.out, (CSV_FILE, TABLE_FILE, "report.html")),
        tables=(options.out / CSV_FILE,),
    )
