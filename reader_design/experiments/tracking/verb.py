"""``octant track``: the controllers of thesis chapters 6 and 7."""

from pathlib import Path

import click

from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options, worker_options


@click.command()
@click.argument("study", type=click.Path(path_type=Path), required=False)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("octant-track"),
    show_default=True,
    help="Folder for results.",
)
@worker_options
@common_options
def track(
    *,
    study: Path | None,
    out: Path,
    workers: int | None,
    cluster: str | None,
    force: bool,
    quiet: bool,
) -> None:
    """Follow trajectories from the RSS of tags, by every controller and estimator.

    Without STUDY the built-in study of thesis chapters 6 and 7 runs: measurement feedback, nominal
    and neighbouring optimal control, EKF SLAM, and the same with RSS from the room solver. Writes
    results.nc, tracking.csv, costs.csv, slam.csv, figures, study.toml and report.html to --out; the
    same command again goes on where the last one stopped.
    """
    from octant.reader_design.experiments.tracking.compute import run_tracking
    from octant.reader_design.experiments.tracking.page import summary_lines
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study, built_in="track_study")
    content = run_tracking(
        loaded, out, workers=workers, cluster=cluster, force=force, progress=Progress(quiet=quiet)
    )
    for line in summary_lines(content):
        click.echo(line)
    click.echo(f"written: {out / 'report.html'}, results.nc, tables and figures")
