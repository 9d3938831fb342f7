"""The report of ``octant dock``: missions, the published experiments, and what is claimed."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from octant.geometries.files import write_text
from octant.navigation.docking.files import write_docking_csv, write_docking_trajectory_csv
from octant.navigation.docking.task import DockingResult
from octant.navigation.estimators.kalman import consistency_band
from octant.reader_design.drives.export import OUTPUTS
from octant.reader_design.experiments.docking.compute import (
    DockingContent,
    compute_docking,
    dock_table,
    docking_jobs,
    docking_rooms,
    kept_runs,
    landmark_filters,
)
from octant.reader_design.experiments.docking.published import (
    BLACKOUT_S,
    SLIPS,
    WRONG_START,
    FilterExperiment,
)
from octant.reader_design.experiments.docking.textbook_page import (
    derived_section,
    law_section,
    shown,
)
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import STUDY_FILE, refuse_another, write_once
from octant.reader_design.keeping.workers import open_crew
from octant.reader_design.setting.cost import Cost, docking_cost, reader_cost
from octant.reader_design.setting.solving import solved
from octant.reader_design.showing.pages import (
    Report,
    ReportSection,
    ReportTable,
    render_report,
)
from octant.reader_design.showing.style import save_figure
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study


def summary_lines(rooms: Mapping[str, Sequence[DockingResult]]) -> tuple[str, ...]:
    """Return how the missions of each room ended, and why some failed [m], [s].

    Parameters
    ----------
    rooms : Runs by room.
    """
    lines = []
    for name, runs in rooms.items():
        docked = [result for result in runs if result.success]
        line = f"{name}: {len(docked)} of {len(runs)} runs docked"
        if docked:
            position, lateral = (
                [getattr(result, key) for result in docked]
                for key in ("position_error_m", "lateral_error_m")
            )
            line += (
                f"; final position {_pair(position)} m, lateral {_pair(lateral)} m (median / 90 %),"
                f" {np.median([result.time_s[-1] for result in docked]):.0f} s"
            )
        lines.append(f"{line}.")
        failed = [result for result in runs if not result.success]
        for outcome in dict.fromkeys(result.outcome for result in failed):
            alike = [result.reason for result in failed if result.outcome == outcome]
            reasons = list(dict.fromkeys(alike))
            first = "" if len(reasons) == 1 else "the first because "
            lines.append(f"{len(alike)} x {outcome}: {first}{reasons[0]}.")
    return (*lines, _tolerances(rooms))


def _tolerances(rooms: Mapping[str, Sequence[DockingResult]]) -> str:
    task = next(iter(rooms.values()))[0].task
    return (
        f"Docked is within {task.tolerance_m:g} m and {np.degrees(task.tolerance_rad):.3g} degrees "
        "of the docking pose."
    )


def docking_report(
    content: DockingContent, filters: FilterExperiment, figures: Mapping[str, Path]
) -> Report:
    """Return the report of a docking study [m], [s].

    Parameters
    ----------
    content, filters, figures : What was computed, its landmark filters, and PNG files by name.
    """
    rooms = content.results
    runs = [result for each in rooms.values() for result in each]
    docked = sum(result.success for result in runs)
    return Report(
        title=f"Docking: {content.study.name}",
        subtitle="From across the room to a station: first by the reader, then by a landmark",
        summary=summary_lines(rooms),
        warnings=(),
        facts=(
            ("docked", f"{docked} of {len(runs)} runs"),
            ("docked is", _tolerances(rooms).removeprefix("Docked is ").rstrip(".")),
            ("first try", f"{sum(r.success and r.tries == 1 for r in runs)} runs"),
            ("contacts", f"{sum(r.contacts for r in runs)} in all runs"),
        ),
        sections=(
            _missions_section(rooms, figures),
            _docking_section(content.published, figures),
            _filter_section(filters, figures),
            law_section(dock_table(content.study), figures),
            derived_section(dock_table(content.study), figures),
        ),
    )


def _missions_section(
    rooms: Mapping[str, Sequence[DockingResult]], figures: Mapping[str, Path]
) -> ReportSection:
    rows = tuple(
        (
            name,
            f"{sum(r.success for r in runs)} of {len(runs)}",
            f"{np.mean([r.tries for r in runs]):.2f}",
            str(sum(r.contacts for r in runs)),
            _pair([r.staged_m for r in runs if np.isfinite(r.staged_m)]),
            _pair([r.position_error_m for r in runs if r.success]),
            _pair([r.lateral_error_m for r in runs if r.success]),
            f"{np.median([r.time_s[-1] for r in runs]):.0f}",
        )
        for name, runs in rooms.items()
    )
    return ReportSection(
        heading="Missions from random starts",
        paragraphs=(
            (
                "With the reader's bearings from many places and its odometry the robot finds the "
                "station's tag, which hangs over the staging place. There it turns until its "
                "camera sees the landmark, takes some images, and follows the docking law on the "
                "filter's estimate. After a failed try it goes back to the staging place."
            ),
        ),
        tables=(
            ReportTable(
                caption=f"{_tolerances(rooms)} Median / 90 %; staging and final errors in m, time "
                "in s.",
                header=(
                    "room",
                    "docked",
                    "tries",
                    "contacts",
                    "staged within [m]",
                    "final position [m]",
                    "final lateral [m]",
                    "time [s]",
                ),
                rows=rows,
            ),
        ),
        figures=(
            shown(figures, "dock_ways", "Paths to the dock", "Starts are dots."),
            shown(
                figures,
                "dock_errors",
                "Final places",
                "In the circle there is contact.",
            ),
        ),
    )


def _docking_section(
    dockings: Mapping[bool, Sequence[DockingResult]], figures: Mapping[str, Path]
) -> ReportSection:
    rows = tuple(
        (
            "v - b̂, ω - ŝ" if compensated else "none",
            f"{sum(r.success for r in runs)} of {len(runs)}",
            str(sum(r.outcome == "stalled" for r in runs)),
            _pair([r.position_error_m for r in runs if r.success]),
            _pair([r.lateral_error_m for r in runs if r.success]),
        )
        for compensated, runs in dockings.items()
    )
    return ReportSection(
        heading="Docking on estimated states",
        paragraphs=(
            (
                "One try from beside the staging place. Without compensation, a slip against the "
                "motion stops the robot at the distance |b|/γ before the dock."
            ),
            *wrong_start_lines(dockings[True]),
        ),
        tables=(
            ReportTable(
                caption="Final errors in m, median / 90 % of the runs that docked.",
                header=(
                    "slip compensation",
                    "docked",
                    "stalled",
                    "final position [m]",
                    "final lateral [m]",
                ),
                rows=rows,
            ),
        ),
        figures=(
            shown(
                figures,
                "dock_run",
                "One docking",
                "Path, commands, polar state and Lyapunov function; paper, figures 18 and 19.",
            ),
            shown(figures, "dock_stall", "Stall", "With and without slip compensation."),
        ),
    )


def wrong_start_lines(runs: Sequence[DockingResult]) -> tuple[str, ...]:
    """Return how runs from a wrong estimate ended, by whether the landmark was in view [m], [deg].

    The docking paper's claim (VIII) is for a visible landmark.

    Parameters
    ----------
    runs : Runs of one task.
    """
    error = runs[0].task.fine.start_error
    if error is None:
        return ()
    # A false report or two do not make a view.
    viewed = [np.count_nonzero(run.seen[run.time_s < _VIEW_S]) >= _LEAST_SIGHTINGS for run in runs]
    saw, blind = (
        [run.success for run, view in zip(runs, viewed, strict=True) if view == wanted]
        for wanted in (True, False)
    )
    text = (
        f"The loop is closed at once on an estimate that is off by ({error[0]:g}, {error[1]:g}) m "
        f"and {np.degrees(error[2]):.3g} degrees. With the landmark in view in the first "
        f"{_VIEW_S:g} s {sum(saw)} of {len(saw)} runs docked, of the others {sum(blind)} of "
        f"{len(blind)}."
    )
    return (text,)


def _filter_rows(experiment: FilterExperiment) -> tuple[tuple[str, ...], ...]:
    drives = experiment.drives
    end, runs = drives.blackout_end(BLACKOUT_S), np.arange(drives.truth.shape[1])
    at_20 = int(np.searchsorted(drives.time_s, 20.0))
    low, high = consistency_band(degrees=5, samples=len(runs))
    settled = drives.time_s > 10.0
    rows = []
    for key, label in (
        ("slips", "coupled filter"),
        ("pair", "the paper's pair of filters"),
        ("no slips", "coupled, slips not estimated"),
        ("wrong start", "coupled, wrong start"),
    ):
        made = experiment.estimates[key]
        error, mean = made.position_error_m(drives), made.nees[settled].mean(axis=1)
        inside = np.mean((low <= mean) & (mean <= high))
        rows.append(
            (
                label,
                _pair(error[at_20]),
                _pair(error[end, runs]),
                "-" if np.isnan(mean).any() else f"{mean.mean():.2f} ({100 * inside:.0f} %)",
                f"{np.nanmean(made.nis[settled]):.2f}",
            )
        )
    return tuple(rows)


def _filter_section(experiment: FilterExperiment, figures: Mapping[str, Path]) -> ReportSection:
    runs = experiment.drives.truth.shape[1]
    low, high = consistency_band(degrees=5, samples=runs)
    b, s = SLIPS
    dx, dy, turn = WRONG_START
    return ReportSection(
        heading="Landmark filters",
        paragraphs=(
            (
                f"{runs} drives with slips b = {b:g} m/s and s = {s:g} rad/s; the landmark "
                f"is lost after some 23 s. A wrong start is off by ({dx:g}, {dy:g}) m and "
                f"{turn:g} rad. The true motion has the process noise that the filters assume, so "
                "that their consistency can be judged: the mean NEES of five states should lie "
                f"between {low:.2f} and {high:.2f}."
            ),
        ),
        tables=(
            ReportTable(
                caption=(
                    "Error of the landmark's place, median / 90 % in m; mean NEES after 10 s and "
                    "the share of time in the 95 % band; mean NIS, 3 for a consistent filter."
                ),
                header=(
                    "filter",
                    "after 20 s [m]",
                    f"{BLACKOUT_S:g} s unseen [m]",
                    "NEES [-]",
                    "NIS [-]",
                ),
                rows=_filter_rows(experiment),
            ),
        ),
        figures=(
            shown(figures, "dock_filter_path", "Paths (Fig. 6)", "In the landmark's frame."),
            shown(figures, "dock_filter_no_slips", "No slips estimated (Fig. 7-9)", "Run 0."),
            shown(figures, "dock_filter_slips", "Slips estimated (Fig. 11-13)", "Run 0."),
            shown(figures, "dock_slips", "Slips (Fig. 14-16)", "Forced b = -0.01 m/s."),
            shown(figures, "dock_filter_straight", "Simpler drive (Fig. 17)", "Constant speed."),
            shown(figures, "dock_histograms", "Errors (Fig. 10)", "p: D'Agostino and Pearson."),
            shown(figures, "dock_consistency", "Consistency", "Mean over the runs."),
        ),
    )


def _pair(values: Sequence[float] | np.ndarray) -> str:
    if not len(values):
        return "-"
    return f"{np.median(values):.3f} / {np.quantile(values, 0.9):.3f}"


_VIEW_S, _LEAST_SIGHTINGS = 2.0, 5
FILES = ("docking.csv", "trajectory.csv", "report.html")
"""What a docking study leaves beside its figures and study.toml."""
CASES = "cases"


def publish(content: DockingContent, out_dir: Path, progress: Progress) -> list[Path]:
    """Return the files of a docking study, once written.

    Parameters
    ----------
    content, out_dir, progress : What was computed, the folder of the results; shows figures.
    """
    from octant.reader_design.experiments.docking.figures import docking_figures

    with progress.during("landmark filters and figures"):
        filters, straight = landmark_filters(content.study)
        figures = docking_figures(content, filters, straight)
    paths = {name: out_dir / "figures" / f"{name}.png" for name in figures}
    with progress.track(figures.items(), label="figures") as drawn:
        for name, figure in drawn:
            save_figure(figure, paths[name])
    docking, trajectory, report = (out_dir / name for name in FILES)
    write_docking_csv(docking, content.results)
    write_docking_trajectory_csv(trajectory, next(iter(content.results.values()))[0])
    write_text(report, render_report(docking_report(content, filters, paths)))
    return [docking, trajectory, report, *paths.values()]


def run_docking_study(
    study: Study,
    out_dir: Path,
    *,
    workers: int | None = 1,
    cluster: str | None = None,
    force: bool = False,
    progress: Progress | None = None,
    approve: Callable[[Cost], None] | None = None,
) -> DockingContent:
    """Return the content of a docking study and write its files, unless they are there already.

    Parameters
    ----------
    study, out_dir : With a table ``[dock]``; folder of the results, whose runs are read.
    workers, cluster : Who shares the runs, as in `open_crew`.
    force, progress : Replace another study's results; shows how many runs are done.
    approve : Refuses what takes too long or too much memory, before anything is written.
    """
    progress = progress or Progress()
    rooms = docking_rooms(study)  # a bad station is refused before anything is computed
    if approve is not None:
        approve(reader_cost(study).and_then(docking_cost(study, dock_table(study))))
    text, cases = to_toml(study, relative_to=out_dir), out_dir / CASES
    refuse_another(out_dir, text, force=force, outputs=(*FILES, "figures/dock_*.png", OUTPUTS))
    write_text(out_dir / STUDY_FILE, text)
    for note in dict.fromkeys(note for room in rooms for note in room.notes):
        progress.say(note)
    solved(rooms[0], progress)
    jobs = docking_jobs(rooms)
    with open_crew(workers=workers, cluster=cluster) as crew:
        content = compute_docking(study, rooms, jobs, cases, crew=crew, progress=progress)
    write_once(
        cases / "finished.json",
        [study, content.results],
        lambda: publish(content, out_dir, progress),
        force=force,
        progress=progress,
    )
    return content


def plan_line(study: Study, out_dir: Path) -> str:
    """Return how many runs a docking study has, and how many the folder holds.

    Parameters
    ----------
    study, out_dir : A study with a table ``[dock]``, and the folder of its results.
    """
    jobs = docking_jobs(docking_rooms(study))
    return kept_runs(study, jobs, out_dir / CASES)
