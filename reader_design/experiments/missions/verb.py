"""``octant navigate``: a study's mission, driven many times in the study's own room."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options

if TYPE_CHECKING:
    from octant.navigation.missions.metrics import MissionMetrics
    from octant.navigation.missions.records import MissionResult
    from octant.reader_design.setting.setting import Setting


_FILES = ("missions.csv", "missions_summary.csv", "trajectory.csv", "study.toml")


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder for results.")
@click.option("--runs", type=click.IntRange(min=1), help="Repetitions; default: the study's.")
@click.option(
    "--noise-db",
    type=click.FloatRange(min=0.0),
    help="Noise of each RSS reading [dB]; default: the study's.",
)
@click.option(
    "--compare",
    is_flag=True,
    help="STUDY is a comparison file: layouts x links x readers x controllers.",
)
@click.option(
    "--animate",
    type=click.Path(path_type=Path),
    help="Write run 0 here as an animated GIF: robot, antennas, RSS and the field under them.",
)
@common_options
def navigate(
    *,
    study: Path,
    out: Path,
    runs: int | None,
    noise_db: float | None,
    compare: bool,
    animate: Path | None,
    force: bool,
    quiet: bool,
) -> None:
    """Drive the robot through the tags of STUDY with the reader of its table [reader].

    Writes missions.csv (one row a run), missions_summary.csv, trajectory.csv (run 0: poses and
    the RSS of every antenna), study.toml, and figures of the way, of the errors by percentile and
    of the RSS over time.

    With --compare, STUDY names layouts (study files) and what is to be compared in them; this
    writes compare.csv and report.html, keeps every cell, and goes on where it was interrupted.
    """
    if compare:
        if animate is not None:
            msg = "--animate shows one run, but --compare drives many; give one of them."
            raise ConfigError(msg)
        _compare(
            study,
            out,
            runs=runs,
            noise_db=noise_db,
            force=force,
            progress=Progress(quiet=quiet),
        )
        return
    from octant.geometries.files import refuse_overwrite, write_text
    from octant.navigation.missions.files import write_missions_csv, write_trajectory_csv
    from octant.navigation.missions.metrics import measure
    from octant.navigation.missions.summary import summarise, summary_sentences, write_summary_csv
    from octant.reader_design.experiments.missions.animation import drive_frames, write_gif
    from octant.reader_design.experiments.missions.drive_figures import drive_of
    from octant.reader_design.experiments.missions.drives import drive_missions
    from octant.reader_design.experiments.missions.placements import drive_placements
    from octant.reader_design.experiments.missions.scenery import run_scenery
    from octant.reader_design.setting.links import mission_table, study_responses
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.study_file.loading import load_study, to_toml

    loaded = load_study(study)
    if animate is not None and animate.suffix.lower() != ".gif":
        msg = f"--animate is {animate}, but an animation is a GIF; name a file that ends in .gif."
        raise ConfigError(msg)
    table = mission_table(loaded)
    files = {name: out / name for name in _FILES}
    refuse_overwrite(*files.values(), *([animate] if animate else []), force=force)
    built = build_setting(loaded)
    progress = Progress(quiet=quiet)
    for note in built.notes:
        progress.say(note)
    design = loaded.reader
    responses = study_responses(loaded)
    number = table.runs if runs is None else runs
    with progress.count(number, label="missions") as done:
        if table.placement_m > 0.0:
            results, built = drive_placements(
                loaded, None, responses, runs=number, noise_db=noise_db, progress=done
            )
        else:
            results = drive_missions(
                loaded, built, responses, runs=number, noise_db=noise_db, progress=done
            )
    write_text(files["study.toml"], to_toml(loaded, relative_to=out))
    write_missions_csv(files["missions.csv"], results)
    write_trajectory_csv(files["trajectory.csv"], results[0])
    _write_figures(out / "figures", built, results[0], title=f"{loaded.name}: {design.label()}")
    metrics = [measure(result) for result in results]
    summary = summarise(metrics)
    write_summary_csv(files["missions_summary.csv"], summary)
    for line in (*mission_summary(metrics, results), *summary_sentences(summary)):
        click.echo(line)
    click.echo(f"written: {', '.join(str(p) for p in files.values())} and {out / 'figures'}")
    if animate is not None:
        scenery = run_scenery(loaded, built, responses, results[0])
        frames = drive_frames(drive_of(results[0]), scenery, title=loaded.name)
        click.echo(f"written: {animate}, {write_gif(animate, frames)} frames")


def mission_summary(
    metrics: Sequence["MissionMetrics"], results: Sequence["MissionResult"]
) -> Iterator[str]:
    """Yield lines that say how the runs of a mission ended [m], [deg], [s].

    Parameters
    ----------
    metrics : sequence of MissionMetrics
        Of every run.
    results : sequence of MissionResult
        The runs.
    """
    runs = len(metrics)
    reached = sum(m.success for m in metrics)
    yield f"{reached} of {runs} run{'' if runs == 1 else 's'} reached every tag."
    rmse, p90 = (
        np.array([getattr(m, key) for m in metrics]) for key in ("rmse_m", "p90_position_m")
    )
    heading = np.degrees([m.p90_heading_rad for m in metrics])
    yield (
        f"RMSE to the straight segments: median {np.median(rmse):.3f} m, worst {rmse.max():.3f} m; "
        f"90 % of the time within {np.median(p90):.3f} m and {np.median(heading):.1f} degrees "
        "(median of the runs)."
    )
    failed = [r.reason for r, m in zip(results, metrics, strict=True) if not m.success]
    for reason in dict.fromkeys(failed):
        yield f"{failed.count(reason)} x not a success: {reason}."


def _write_figures(folder: Path, built: "Setting", result: "MissionResult", *, title: str) -> None:
    from octant.reader_design.experiments.missions.drive_figures import (
        drive_of,
        percentile_figure,
        rss_time_figure,
        trajectory_figure,
    )
    from octant.reader_design.showing.plan import plan_of
    from octant.reader_design.showing.style import save_figure

    drive = drive_of(result)
    mission = result.mission
    points = dict(zip(mission.tag_ids, mission.tag_points_m, strict=True))
    plan = plan_of(built.scene, built.reader_z_m)
    save_figure(
        trajectory_figure([(built.name, drive, plan)], points, title=title),
        folder / "trajectory.png",
    )
    save_figure(percentile_figure([(built.name, drive)], title=title), folder / "percentiles.png")
    save_figure(rss_time_figure(drive, mission.tag_ids, title=title), folder / "rss.png")


def _compare(
    file: Path,
    out: Path,
    *,
    runs: int | None,
    noise_db: float | None,
    force: bool,
    progress: Progress,
) -> None:
    import msgspec

    from octant.reader_design.cli import InterruptedRunError
    from octant.reader_design.experiments.missions.comparison_file import load_comparison
    from octant.reader_design.experiments.missions.comparison_page import table_row
    from octant.reader_design.experiments.missions.comparison_run import run_comparison

    comparison = load_comparison(file)
    if runs is not None:
        comparison = msgspec.structs.replace(comparison, runs=runs)
    if noise_db is not None:
        controllers = tuple(
            msgspec.structs.replace(entry, mission={**entry.mission, "noise_db": noise_db})
            for entry in comparison.controllers
        )
        comparison = msgspec.structs.replace(comparison, controllers=controllers)
    try:
        outcomes = run_comparison(comparison, out, force=force, progress=progress)
    except KeyboardInterrupt as exc:
        msg = f"what was driven is kept in {out}; the same command goes on from there."
        raise InterruptedRunError(msg) from exc
    for outcome in outcomes:
        click.echo(" | ".join(table_row(outcome)))
    click.echo(f"written: {out / 'compare.csv'}, {out / 'report.html'} and {out / 'figures'}")
