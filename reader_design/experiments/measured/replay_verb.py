"""``octant replay``: a recorded drive through the estimators of the navigators."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from octant.geometries.errors import ConfigError
from octant.reader_design.options import Ended, RunOptions, experiment, number
from octant.reader_design.study_file.quantities import Deviation, Distance, DurationOrZero
from octant.reader_design.terminal.completion import files

if TYPE_CHECKING:
    from collections.abc import Sequence

    from octant.reader_design.experiments.measured.replay import Estimator, Replayed
    from octant.reader_design.experiments.measured.replay_results import Limits
    from octant.reader_design.experiments.measured.replay_run import Replay

ESTIMATORS = ("strongest", "vector_sum", "pattern", "tracker", "map")
_FILES = ("replay.csv", "replay_summary.csv", "patterns.csv")
_REPORT = "report.html"
_OUTPUTS = (*_FILES, _REPORT, "figures/*.png")
_WHAT = {
    "replay.csv": "a row for each round of antennas",
    "replay_summary.csv": "a row for each tag, and one of all",
    "patterns.csv": "gains of the antennas over the bearing",
}


@click.command()
@click.option(
    "--log",
    "log_file",
    type=click.Path(path_type=Path),
    shell_complete=files(".csv", ".mcap"),
    help="The log, read as the table [log] says; default: log.file of the study.",
)
@click.option(
    "--estimator",
    type=click.Choice(ESTIMATORS),
    default="vector_sum",
    show_default=True,
    help="A bearing method, the tracker (places of tags), or the map (pose of the robot).",
)
@click.option(
    "--azimuths-deg",
    "azimuths",
    metavar="DEG,...",
    help="Directions of the log's antennas from the robot's front, counter-clockwise [deg], in the "
    "order of their numbers; default: those of the study's reader.",
)
@click.option(
    "--patterns",
    default="study",
    show_default=True,
    metavar="study|spin|FILE",
    shell_complete=files(".csv"),
    help="Patterns of the study's reader, from turns on the spot in the log, or of a CSV with "
    "bearing_deg,gain_1_db,...",
)
@click.option(
    "--round-s",
    "window_s",
    type=number(DurationOrZero),
    default=0.0,
    metavar="S",
    help="Readings within so many seconds are of one round of the antennas [s].",
)
@click.option(
    "--combine-s",
    "combine_s",
    type=number(DurationOrZero),
    default=0.0,
    metavar="S",
    help="Bearings count readings of the last so many seconds, turned by the odometry [s].",
)
@click.option(
    "--level-sd-db",
    type=number(Deviation),
    metavar="DB",
    help="How unknown the tags' level is [dB]; default: free; of the map mission.map.level_sd_db.",
)
@click.option(
    "--start",
    type=click.Choice(["known", "unknown"]),
    default="known",
    show_default=True,
    help="Whether the map is told the first true pose.",
)
@click.option(
    "--converged-m",
    type=number(Distance),
    default=0.5,
    show_default=True,
    help="A place has converged when its error stays below this [m].",
)
@click.option(
    "--converged-deg",
    type=click.FloatRange(0.1, 180.0),
    default=30.0,
    show_default=True,
    help="The same of a bearing, where no place is estimated [deg].",
)
@experiment()
def replay(
    *,
    study: Path | None,
    options: RunOptions,
    log_file: Path | None,
    estimator: "Estimator",
    azimuths: str | None,
    patterns: str,
    window_s: float,
    combine_s: float,
    level_sd_db: float | None,
    start: str,
    converged_m: float,
    converged_deg: float,
) -> Ended:
    """Put a recorded drive through an estimator, and hold what it says against the truth.

    The log's levels (gaps, repeated times and "not heard" included) and odometry go to the bearing
    methods, the tracker or the map of the navigators, for any number of antennas at any azimuths.
    Where the log has true poses, bearings and places are compared with them. Writes replay.csv (a
    row a round), replay_summary.csv (a row a tag), figures and report.html; the same command again
    goes on with the tags that the tracker has not followed yet.
    """
    from octant.geometries.files import write_text
    from octant.reader_design.experiments.measured.replay_results import Limits, sentences
    from octant.reader_design.experiments.measured.replay_run import (
        ReplayOptions,
        prepared,
        run_replay,
    )
    from octant.reader_design.keeping.results import STUDY_FILE, files_of, refuse_another
    from octant.reader_design.setting.cost import replay_cost
    from octant.reader_design.setting.measured import measured_log, with_log
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.study_file.loading import load_study, to_toml

    loaded = options.seeded(with_log(load_study(study)))
    out, progress = options.out, options.progress
    text = to_toml(loaded, relative_to=out)
    if not options.dry_run:
        refuse_another(out, text, force=options.force, outputs=_OUTPUTS)
    measured = measured_log(loaded, build_setting(loaded).scene, file=log_file, motion=True)
    ready = prepared(
        loaded,
        measured.log,
        ReplayOptions(
            estimator=estimator,
            azimuths_rad=None if azimuths is None else _radians(azimuths),
            patterns=patterns,
            window_s=window_s,
            combine_s=combine_s,
            level_sd_db=level_sd_db,
            known_start=start == "known",
        ),
    )
    if options.dry_run:
        line = f"{len(ready.rounds)} rounds of {len(ready.ids)} tags by {estimator}."
        return Ended(lines=(line, *measured.notes, *ready.notes))
    options.approve(replay_cost(estimator, len(ready.rounds)))
    for note in (*measured.notes, *ready.notes):
        progress.say(note)
    write_text(out / STUDY_FILE, text)
    found = run_replay(
        ready, out, progress=progress, workers=options.workers, cluster=options.cluster
    )
    limits = Limits(place_m=converged_m, bearing_rad=math.radians(converged_deg))
    _publish(ready, found, limits, out, log=measured.file, text=text)
    return Ended(
        lines=sentences(estimator, found, limits),
        written=files_of(out, (*_FILES, _REPORT, "figures/*.png")),
        tables=(out / _FILES[1],),
    )


def _radians(text: str) -> tuple[float, ...]:
    """Return directions of the command line [rad]."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if not numbers or not all(abs(value) <= 3600.0 for value in numbers):
        msg = (
            f"--azimuths-deg is {text[:60]!r}, but directions are needed in degrees with commas "
            "between them, such as 0,72,144,216,288."
        )
        raise ConfigError(msg)
    return tuple(math.radians(value) for value in numbers)


def _command(ready: "Replay", log: str, limits: "Limits") -> str:
    """Return the call that makes the same again."""
    import shlex

    options = ready.options
    words = ["octant", "replay", "study.toml", "--log", log, "--estimator", options.estimator]
    if options.azimuths_rad is not None:
        degrees = ",".join(f"{math.degrees(a):.10g}" for a in options.azimuths_rad)
        words += [f"--azimuths-deg={degrees}"]
    if options.patterns != "study":
        words += ["--patterns", options.patterns]
    numbers = {
        "--round-s": options.window_s,
        "--combine-s": options.combine_s,
        "--level-sd-db": options.level_sd_db,
    }
    for option, value in numbers.items():
        words += [option, f"{value:g}"] if value else []
    words += [] if options.known_start else ["--start", "unknown"]
    words += ["--converged-m", f"{limits.place_m:g}"]
    words += ["--converged-deg", f"{math.degrees(limits.bearing_rad):g}", "--out", "again"]
    return shlex.join(words)


def _publish(
    ready: "Replay",
    found: "Sequence[Replayed]",
    limits: "Limits",
    out: Path,
    *,
    log: Path,
    text: str,
) -> None:
    """Write tables, figures and the page."""
    from octant.geometries.files import write_text
    from octant.reader_design.experiments.measured.replay_figures import (
        errors_figure,
        percentile_figure,
        plan_figure,
    )
    from octant.reader_design.experiments.measured.replay_page import replay_report
    from octant.reader_design.experiments.measured.replay_patterns import write_gains
    from octant.reader_design.experiments.measured.replay_results import (
        summary_of,
        summary_of_all,
        write_replay,
        write_summary,
    )
    from octant.reader_design.showing.pages import ReportLink, render_report
    from octant.reader_design.showing.plan import plan_of
    from octant.reader_design.showing.style import save_figure

    write_replay(out / _FILES[0], found)
    each = [summary_of(one, limits) for one in found]
    write_summary(out / _FILES[1], [*each, summary_of_all(found, limits)])
    tables = [*_FILES[:2]]
    if ready.gains_db is not None:
        write_gains(out / _FILES[2], ready.gains_db)
        tables.append(_FILES[2])
    setting, estimator = ready.setting, ready.options.estimator
    title = f"{setting.study.name}: {log.name} by {estimator}"
    plan = plan_of(setting.scene, setting.reader_z_m)
    figures = {
        "plan": (
            "Where it was, and what was believed",
            "Places are those of the second half of the rounds; tags as crosses.",
            plan_figure(found, plan, ready.points_m, title=title),
        ),
        "errors": (
            "Errors over time",
            "Of every round, tag by tag.",
            errors_figure(found, title=title),
        ),
        "percentiles": (
            "Error of the bearing by percentile",
            "The grey line is what guessing would give.",
            percentile_figure(found, title=title),
        ),
    }
    embedded = []
    for name, (heading, caption, figure) in figures.items():
        path = out / "figures" / f"{name}.png"
        save_figure(figure, path)
        embedded.append((heading, caption, path))
    report = replay_report(
        ready,
        found,
        limits,
        {"replay": embedded},
        log=log.name,
        command=_command(ready, log.name, limits),
        files=[ReportLink(file=name, what=_WHAT[name]) for name in tables],
        study_toml=text,
    )
    write_text(out / _REPORT, render_report(report))
