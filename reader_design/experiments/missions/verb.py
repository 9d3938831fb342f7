"""``octant navigate``: a study's mission, driven many times in the study's own room."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import (
    Ended,
    RunOptions,
    drive_options,
    experiment,
    number,
    quick_option,
    runs_wanted,
)
from octant.reader_design.study_file.quantities import Count, Deviation
from octant.reader_design.terminal.colour import judged
from octant.reader_design.terminal.tables import text_table

if TYPE_CHECKING:
    from octant.navigation.missions.records import MissionResult
    from octant.reader_design.drives.files import DriveFile
    from octant.reader_design.experiments.missions.localise import Localised
    from octant.reader_design.setting.setting import Setting


_FILES = ("missions.csv", "missions_summary.csv", "trajectory.csv")
_REPORT = "report.html"
ANIMATION = "animation.json"
_MORE = ("localisation.csv", "orientation.csv")
_LEARNED = "learned.toml"
_OUTPUTS = (*_FILES, *_MORE, _LEARNED, _REPORT, "figures/*.png")
_WHAT = {
    "missions.csv": "a row for each run",
    "missions_summary.csv": "shares and medians with their intervals",
    "trajectory.csv": "run 0, step by step",
    "localisation.csv": "errors of the robot's place",
    "orientation.csv": "errors of run 0's heading",
    _LEARNED: "what run 0 has found of tags and antennas, for mission.map.learned",
}
_FIGURES = {
    "trajectory": ("Way of the robot", "Run 0: desired way dashed, tags as crosses."),
    "percentiles": (
        "Errors by percentile",
        "Distance to the desired way and heading error that run 0 kept for a share of the time.",
    ),
    "rss": ("RSS over time", "What every antenna read in run 0."),
    "membership": ("Fuzzy controller", "Terms of its input and output, and the speeds it gives."),
    "localisation": ("Place of the robot", "Errors of the place by map and by bearings."),
    "orientation_error": ("Heading of the robot", "Errors of the heading propagated back."),
}


@click.command()
@click.option("--runs", type=number(Count), help="Repetitions; default: the study's.")
@click.option(
    "--noise-db",
    type=number(Deviation),
    help="Noise of each RSS reading [dB]; default: the study's.",
)
@click.option(
    "--compare",
    is_flag=True,
    help="STUDY is a comparison file: layouts x links x readers x controllers x worlds.",
)
@click.option(
    "--animate",
    type=click.Path(path_type=Path),
    help="Write run 0 here as an animated GIF: robot, antennas, RSS and the field under them.",
)
@click.option(
    "--localise",
    is_flag=True,
    help="Also find the robot's place and earlier headings by a distance-RSS map.",
)
@drive_options
@quick_option
@experiment()
def navigate(
    *,
    study: Path | None,
    options: RunOptions,
    runs: int | None,
    noise_db: float | None,
    compare: bool,
    animate: Path | None,
    localise: bool,
    export: "tuple[DriveFile, ...]",
    export_run: tuple[int, ...],
    quick: bool,
) -> Ended:
    """Drive the robot through the tags of STUDY with the reader of its table [reader].

    Writes missions.csv (one row a run), missions_summary.csv, trajectory.csv (run 0: poses and
    the RSS of every antenna), study.toml, and figures of the path, of the errors by percentile, of
    the RSS over time and of a fuzzy controller's rules.

    With --compare, STUDY names layouts (study files) and what is to be compared in them, and errors
    of what navigators are told, each swept until missions break; this writes compare.csv and
    report.html, and keeps every cell. The same command again goes on where the last one stopped.

    With --localise, the robot reads all tags at every place that it passes: localisation.csv has
    the errors of its place by a distance-RSS map and by bearings, orientation.csv those of run 0's
    heading propagated back (thesis 5.2.2.1, 5.4.3), and both have a figure.

    With --export mcap, runs are written with ROS 2 messages (poses, readings, bearing, map, room)
    for Foxglove and RViz, with --export tum and csv as trajectories.
    """
    if compare:
        _refuse_beside_compare(
            {"--animate": animate is not None, "--localise": localise, "--export": bool(export)}
        )
        return _compare(study, options, runs=runs_wanted(runs, quick=quick), noise_db=noise_db)
    from octant.geometries.files import write_text
    from octant.navigation.missions.metrics import measure
    from octant.navigation.missions.summary import summarise, summary_sentences
    from octant.reader_design.drives.export import OUTPUTS, DriveExport, write_drives
    from octant.reader_design.experiments.missions.advice import advise
    from octant.reader_design.experiments.missions.compute import drive, mission_runs
    from octant.reader_design.experiments.missions.localise import (
        localisation_lines,
        localise_runs,
    )
    from octant.reader_design.experiments.missions.logs import mission_logs
    from octant.reader_design.keeping.results import (
        STUDY_FILE,
        files_of,
        refuse_another,
        write_once,
    )
    from octant.reader_design.keeping.workers import open_crew
    from octant.reader_design.mapping.pose_filter import MapStore
    from octant.reader_design.setting.cost import mission_cost, reader_cost
    from octant.reader_design.setting.setting import build_setting, check_navigator, mission_table
    from octant.reader_design.setting.solving import solved
    from octant.reader_design.study_file.loading import load_study, replace, to_toml, vary
    from octant.reader_design.study_file.tables_read import check_tables

    loaded, out, progress = load_study(study), options.out, options.progress
    check_tables(loaded, "navigate")
    _refuse_animation(animate, out, options)
    check_navigator(loaded)
    wanted = {"mission.runs": runs_wanted(runs, quick=quick), "mission.noise_db": noise_db}
    changed = vary(loaded, {key: value for key, value in wanted.items() if value is not None})
    loaded = options.seeded(replace(changed, sweep=loaded.sweep))
    wanted_drives = DriveExport(kinds=export, runs=export_run)
    wanted_drives.check(mission_table(loaded).runs)
    text, folder = to_toml(loaded, relative_to=out), out / "runs"
    setting = build_setting(loaded)
    if not options.dry_run:
        refuse_another(out, text, force=options.force, outputs=(*_OUTPUTS, OUTPUTS))
        options.approve(
            reader_cost(loaded).and_then(mission_cost(loaded, mission_table(loaded).runs))
        )
        write_text(out / STUDY_FILE, text)
    for note in setting.notes:
        progress.say(note)
    setting = solved(setting, progress)
    if options.dry_run:
        return _forecast(setting, folder)
    driven = mission_runs(setting, maps=MapStore(folder=out / "field_maps", progress=progress))
    with open_crew(workers=options.workers, cluster=options.cluster) as crew:
        results = drive(driven, folder=folder, crew=crew, progress=progress)
        found = localise_runs(
            driven if localise else (), results, folder=folder, crew=crew, progress=progress
        )
    setting = driven[0].setting
    metrics = [measure(result) for result in results]
    write_once(
        folder / "finished.json",
        [loaded, results, *([found] if found else [])],
        lambda: _publish(setting, results, out, found, progress),
        force=options.force,
        progress=progress,
    )
    drives = write_drives(
        mission_logs(driven, results, wanted_drives.numbers),
        wanted_drives,
        out,
        stamp=folder / "drives.json",
        inputs=[loaded, [results[k] for k in wanted_drives.numbers]],
        force=options.force,
        progress=progress,
    )
    advice = advise(setting, results)
    lines = [
        *summary_sentences(summarise(metrics)),
        *(advice.text().splitlines() if advice else ()),
        *(localisation_lines(found, results) if found else ()),
    ]
    if animate is not None:
        write_once(
            folder / ANIMATION,
            [loaded, results[0], str(animate)],
            lambda: [write_animation(animate, setting, results[0], progress)],
            force=options.force,
            progress=Progress(),
        )
    more = (*(_MORE if found else ()), *([_LEARNED] if results[0].learned else []))
    return Ended(
        lines=tuple(lines),
        written=(
            *files_of(out, (*_FILES, *more, _REPORT, "figures/*.png")),
            *([animate] if animate else ()),
            *drives,
        ),
        tables=tuple(out / name for name in (*_FILES[:2], *more) if name.endswith(".csv")),
        verdict=judged(sum(m.success for m in metrics) / len(metrics)),
    )


def _refuse_beside_compare(given: Mapping[str, bool]) -> None:
    for option in (name for name, wanted in given.items() if wanted):
        msg = f"{option} is for one study, but --compare drives many; give one of them."
        raise ConfigError(msg)


def _refuse_animation(animate: Path | None, out: Path, options: RunOptions) -> None:
    """Refuse a file that is no GIF, or is there and was not written by these runs."""
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.keeping.results import wrote

    if animate is None:
        return
    if animate.suffix.lower() != ".gif":
        msg = f"--animate is {animate}, but an animation is a GIF; name a file that ends in .gif."
        raise ConfigError(msg)
    if not options.dry_run and not wrote(out / "runs" / ANIMATION, animate):
        refuse_overwrite(animate, force=options.force)


def _forecast(setting: "Setting", folder: Path) -> Ended:
    """Return what would be driven; field maps, which decide what is kept, are not made for it."""
    from octant.reader_design.experiments.missions.compute import count_kept, mission_runs
    from octant.reader_design.mapping.field_maps import map_forecast

    runs = setting.mission.runs
    if setting.mission.navigator == "map":
        return Ended(lines=(f"{map_forecast(setting)}.", f"{runs} runs, after their field maps."))
    there = count_kept(mission_runs(setting), folder=folder)
    return Ended(lines=(f"{runs} runs, of which {there} are driven already.",))


def write_animation(
    path: Path,
    setting: "Setting",
    result: "MissionResult",
    progress: Progress,
    *,
    most_frames: int | None = None,
) -> Path:
    """Return the animation of a run, once written.

    Parameters
    ----------
    path, setting, result : A ``.gif``; the room with its reader; the run ([s], [m], [W]).
    progress : Shows the frames.
    most_frames : Number of frames at most; None: that of `frame_samples`.
    """
    from octant.reader_design.experiments.missions.animation import (
        MOST_FRAMES,
        drive_frames,
        frame_samples,
        run_scenery,
        write_gif,
    )
    from octant.reader_design.experiments.missions.drive_figures import drive_of

    scenery = run_scenery(setting, result)
    drive = drive_of(result)
    samples = frame_samples(len(drive.time_s), most=most_frames or MOST_FRAMES).tolist()
    frames = drive_frames(drive, scenery, title=setting.study.name, samples=samples)
    with progress.track(frames, total=len(samples), label="frames of the animation") as drawn:
        write_gif(path, drawn)
    return path


def _publish(
    setting: "Setting",
    results: "Sequence[MissionResult]",
    out: Path,
    found: "Sequence[Localised]",
    progress: Progress,
) -> list[Path]:
    """Return the files of a mission, once written."""
    from octant.geometries.files import write_text
    from octant.navigation.missions.files import write_missions_csv, write_trajectory_csv
    from octant.navigation.missions.metrics import measure
    from octant.navigation.missions.summary import summarise, write_summary_csv
    from octant.reader_design.experiments.missions.advice import advise
    from octant.reader_design.experiments.missions.drive_figures import (
        drive_of,
        percentile_figure,
        rss_time_figure,
        trajectory_figure,
    )
    from octant.reader_design.experiments.missions.figures import controller_figure
    from octant.reader_design.experiments.missions.localise import (
        localisation_figure,
        orientation_figure,
        write_localisation,
    )
    from octant.reader_design.experiments.missions.page import mission_report
    from octant.reader_design.mapping.learned_file import learned_text
    from octant.reader_design.showing.pages import ReportLink, render_report
    from octant.reader_design.showing.plan import plan_of
    from octant.reader_design.showing.style import save_figure
    from octant.reader_design.study_file.loading import to_toml

    missions, summary, trajectory = (out / name for name in _FILES)
    write_missions_csv(missions, results)
    write_summary_csv(summary, summarise([measure(result) for result in results]))
    write_trajectory_csv(trajectory, results[0])
    first, mission = drive_of(results[0]), results[0].mission
    points = dict(zip(mission.tag_ids, mission.tag_points_m, strict=True))
    title = f"{setting.study.name}: {setting.reader.label()}"
    shown = [(setting.name, first, plan_of(setting.scene, setting.reader_z_m))]
    figures = {
        "trajectory": trajectory_figure(shown, points, title=title),
        "percentiles": percentile_figure([(setting.name, first)], title=title),
        "rss": rss_time_figure(first, mission.tag_ids, title=title),
    }
    rules = controller_figure(setting.mission, name=setting.study.name)
    if rules is not None:
        figures["membership"] = rules
    tables = [missions, summary, trajectory]
    if results[0].learned is not None:
        write_text(out / _LEARNED, learned_text(results[0].learned))
        tables.append(out / _LEARNED)
    if found:
        tables += write_localisation(found, results, out)
        figures["localisation"] = localisation_figure(found, results, title=title)
        figures["orientation_error"] = orientation_figure(found[0], results[0], title=title)
    paths = {name: out / "figures" / f"{name}.png" for name in figures}
    with progress.track(figures.items(), label="figures") as drawn:
        for name, figure in drawn:
            save_figure(figure, paths[name])
    report = out / _REPORT
    files = [ReportLink(file=table.name, what=_WHAT[table.name]) for table in tables]
    entries = [(*_FIGURES[name], path) for name, path in paths.items()]
    page = mission_report(
        setting,
        results,
        advise(setting, results),
        {"mission": entries},
        files=[ReportLink(file="study.toml", what="the resolved study"), *files],
        study_toml=to_toml(setting.study, relative_to=out),
    )
    write_text(report, render_report(page))
    return [*tables, *paths.values(), report]


def _compare(
    file: Path | None,
    options: RunOptions,
    *,
    runs: int | None,
    noise_db: float | None,
) -> Ended:
    import msgspec

    from octant.reader_design.experiments.missions.comparison import (
        plan_comparison,
        run_comparison,
    )
    from octant.reader_design.experiments.missions.comparison_page import HEADER, table_row
    from octant.reader_design.experiments.missions.comparison_table import load_comparison
    from octant.reader_design.keeping.results import files_of
    from octant.reader_design.setting.cost import mission_cost

    if file is None:
        msg = "--compare needs a comparison file, but none is given; name one as STUDY."
        raise ConfigError(msg)
    comparison = load_comparison(file)
    if runs is not None:
        comparison = msgspec.structs.replace(comparison, runs=runs)
    if options.seed is not None:
        comparison = msgspec.structs.replace(comparison, seed=options.seed)
    if noise_db is not None:
        controllers = tuple(
            msgspec.structs.replace(entry, mission={**entry.mission, "noise_db": noise_db})
            for entry in comparison.controllers
        )
        comparison = msgspec.structs.replace(comparison, controllers=controllers)
    if options.dry_run:
        cells = plan_comparison(comparison)
        return Ended(lines=(f"{len(cells)} cells of {comparison.runs} runs.",))
    for cell in plan_comparison(comparison):
        options.approve(mission_cost(cell.study, comparison.runs))
    outcomes = run_comparison(
        comparison,
        options.out,
        force=options.force,
        progress=options.progress,
        workers=options.workers,
        cluster=options.cluster,
    )
    out = options.out
    return Ended(
        lines=tuple(text_table(HEADER, [table_row(o) for o in outcomes], words=HEADER[:4])),
        written=files_of(out, ("compare.csv", "report.html", "figures/*.png")),
        tables=(out / "compare.csv",),
    )
