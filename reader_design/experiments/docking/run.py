"""A docking study end to end: missions in every room, experiments, figures, tables, report."""

from collections.abc import Sequence
from pathlib import Path

from octant.em.reader.response import ReaderResponse
from octant.geometries.files import write_text
from octant.navigation.docking.files import write_docking_csv, write_docking_trajectory_csv
from octant.navigation.docking.task import DockingResult
from octant.reader_design.experiments.docking.experiments import (
    docking_experiment,
    filter_experiment,
    straight_experiment,
)
from octant.reader_design.experiments.docking.figures import (
    filter_figures,
    law_figures,
    mission_figures,
    save_figures,
)
from octant.reader_design.experiments.docking.missions import (
    dock_table,
    docking_job,
    docking_space,
    run_dockings,
)
from octant.reader_design.experiments.docking.page import docking_report, summary_lines
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.scene import StudyScene, build_study_scene
from octant.reader_design.showing.pages import render_report
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

FILES = ("docking.csv", "trajectory.csv", "study.toml", "report.html")
"""What a docking study leaves beside its figures."""

_LEAST_REPETITIONS = 20  # fewer errors cannot be tested for a Gaussian
_MOST_REPETITIONS = 100


def docking_rooms(study: Study) -> tuple[StudyScene, ...]:
    """Return the study's room and its layouts, once the station is known to fit in each.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``.

    Returns
    -------
    tuple of StudyScene
        The study's own room first.

    Raises
    ------
    ConfigError
        When a room cannot be built, or its station is inside something.
    """
    rooms = tuple(build_study_scene(study, layout) for layout in (None, *study.layouts))
    for room in rooms:
        docking_space(study, room)
    return rooms


def run_docking_study(
    study: Study,
    rooms: Sequence[StudyScene],
    responses: Sequence[ReaderResponse],
    out: Path,
    *,
    runs: int | None = None,
    workers: int = 1,
    progress: Progress,
) -> tuple[str, ...]:
    """Return what a docking study found, in sentences; write its files.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``.
    rooms : sequence of StudyScene
        From `docking_rooms`.
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz`` [Hz].
    out : Path
        Folder for results.
    runs : int or None
        Runs in each room; None: the study's.
    workers : int
        Processes that share them.
    progress : Progress
        Told how far it is.

    Returns
    -------
    tuple of str
        How the runs of each room ended, and why some failed.
    """
    table = dock_table(study)
    jobs = {room.name: docking_job(study, room, responses) for room in rooms}
    number = table.runs if runs is None else runs
    results: dict[str, tuple[DockingResult, ...]] = {}
    for name, job in jobs.items():
        with progress.count(number, label=name) as done:
            results[name] = run_dockings(study, job, runs=number, workers=workers, progress=done)
    progress.say("the docking paper's experiments")
    first = jobs[rooms[0].name]
    repetitions = min(max(number, _LEAST_REPETITIONS), _MOST_REPETITIONS)
    dockings = docking_experiment(
        first.task,
        first.setting.camera,
        seed=study.seed,
        runs=min(number, _MOST_REPETITIONS),
        workers=workers,
    )
    experiment = filter_experiment(seed=study.seed, repetitions=repetitions)
    figures = {
        **mission_figures(
            {room.name: (room, results[room.name]) for room in rooms}, dockings, tag_id=table.tag
        ),
        **filter_figures(experiment, straight_experiment(seed=study.seed)),
        **law_figures(first.task.fine.law),
    }
    paths = save_figures(figures, out / "figures")
    write_text(out / "study.toml", to_toml(study, relative_to=out))
    write_docking_csv(out / "docking.csv", results)
    write_docking_trajectory_csv(out / "trajectory.csv", results[rooms[0].name][0])
    report = docking_report(results, experiment, dockings, name=study.name, figures=paths)
    write_text(out / "report.html", render_report(report))
    return summary_lines(results)
