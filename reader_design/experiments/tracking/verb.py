"""``octant track``: the controllers of thesis chapters 6 and 7."""

from pathlib import Path

import click

from octant.reader_design.options import Ended, RunOptions, experiment


@click.command()
@experiment(out="octant-track", study=False)
def track(*, study: Path | None, options: RunOptions) -> Ended:
    """Follow trajectories from the RSS of tags, by every controller and estimator.

    Without STUDY the built-in study of thesis chapters 6 and 7 runs: measurement feedback, nominal
    and neighbouring optimal control, EKF SLAM, and the same with RSS from the room solver. Writes
    results.nc, tracking.csv, costs.csv, slam.csv, figures, study.toml and report.html to --out; the
    same command again goes on where the last one stopped.
    """
    from octant.reader_design.experiments.tracking.compute import plan_line, run_tracking
    from octant.reader_design.experiments.tracking.page import summary_lines
    from octant.reader_design.study_file.loading import load_study
    from octant.reader_design.study_file.tables_read import check_tables

    loaded = load_study(study, built_in="track_study")
    check_tables(loaded, "track")
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
    written = f"written: {options.out / 'report.html'}, results.nc, tables and figures"
    return Ended(lines=(*summary_lines(content), written))
