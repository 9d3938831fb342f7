"""The docking missions of a study, in each of its rooms."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from octant.em.antennas.embedded import ReaderResponse
from octant.geometries.errors import ConfigError, NavigationError
from octant.geometries.files import write_text
from octant.navigation.control.docking_law import DockingLaw, TwistLimits
from octant.navigation.docking.files import write_docking_csv, write_docking_trajectory_csv
from octant.navigation.docking.run import DockingJob
from octant.navigation.docking.task import (
    CoarseStage,
    DockingResult,
    DockingSetting,
    DockingTask,
    FineStage,
    task_filter,
)
from octant.navigation.missions.batches import run_seeded
from octant.navigation.missions.starts import RandomStarts
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import RobotSpace, WheelSlip
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor
from octant.reader_design.experiments.docking.figures import (
    law_figures,
    mission_figures,
    save_figures,
)
from octant.reader_design.experiments.docking.filter_figures import filter_figures
from octant.reader_design.experiments.docking.page import docking_report, summary_lines
from octant.reader_design.experiments.docking.published import (
    docking_experiment,
    filter_experiment,
    straight_experiment,
)
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import worker_map
from octant.reader_design.setting.links import tag_link
from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.setting.robot import robot_space
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.showing.pages import render_report
from octant.reader_design.study_file.dock import Dock
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

_FREE_SPACE_START_M = 4.0
FILES = ("docking.csv", "trajectory.csv", "study.toml", "report.html")
"""What a docking study leaves beside its figures."""

_LEAST_REPETITIONS = 20  # fewer errors cannot be tested for a Gaussian
_MOST_REPETITIONS = 100


def dock_table(study: Study) -> Dock:
    """Return the study's table ``[dock]`` [m], [deg], [s].

    Parameters
    ----------
    study : Study
        The study.
    """
    if study.dock is None:
        msg = "the study has no table [dock], which is needed to dock; add tag and landmark."
        raise ConfigError(msg)
    return study.dock


def docking_task(table: Dock) -> DockingTask:
    """Return the docking task of a table ``[dock]`` [m], [rad], [s].

    Parameters
    ----------
    table : Dock
        The table.
    """
    return DockingTask(
        tag_id=table.tag,
        landmark=Landmark(
            position_m=np.array(table.landmark_position_m),
            heading_rad=math.radians(table.landmark_heading_deg),
        ),
        stand_off_m=table.stand_off_m,
        staging_m=table.staging_m,
        tries=table.tries,
        coarse=CoarseStage(period_s=table.reading_time_s),
        fine=FineStage(
            law=DockingLaw(gamma_per_s=table.gamma_per_s, h=table.h, k_per_s=table.k_per_s),
            limits=TwistLimits(
                max_speed_m_per_s=table.max_speed_m_per_s,
                max_turn_rate_rad_per_s=math.radians(table.max_turn_rate_deg_per_s),
                saturation=table.saturation,
            ),
            filter=task_filter(
                position_sd_m=table.position_sd_m,
                attitude_sd_rad=math.radians(table.attitude_sd_deg),
            ),
            compensate_slips=table.compensate_slips,
            period_s=table.sample_time_s,
            latch_radius_m=table.latch_radius_m,
        ),
        slip=WheelSlip(
            linear_m_per_s=table.linear_slip_m_per_s,
            angular_rad_per_s=math.radians(table.angular_slip_deg_per_s),
        ),
    )


def docking_space(study: Study, built: Setting) -> RobotSpace:
    """Return where the study's robot can stand in one of its rooms, once its station is checked.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``.
    built : Setting
        The room [m].
    """
    table = dock_table(study)
    task = docking_task(table)
    try:
        task.landmark.check(built.scene)
    except NavigationError as exc:
        msg = f"dock.landmark_position_m: {exc}"
        raise ConfigError(msg) from exc
    space = robot_space(
        built.scene, study.reader, radius_m=table.robot_radius_m, height_m=table.robot_height_m
    )
    if not space(task.goal[None, :2])[0]:
        x, y = task.goal[:2]
        msg = (
            f"dock.stand_off_m puts the dock at ({x:g}, {y:g}) m, where the robot of radius "
            f"{space.footprint.radius_m:g} m does not fit; give it more room."
        )
        raise ConfigError(msg)
    return space


def docking_job(study: Study, built: Setting, responses: Sequence[ReaderResponse]) -> DockingJob:
    """Return what makes one docking mission of a study from its seed, in one of its rooms.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``.
    built : Setting
        The room [m].
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz`` [Hz].
    """
    table = dock_table(study)
    task, space = docking_task(table), docking_space(study, built)
    link = tag_link(study, built, built.tag(table.tag), responses)
    return DockingJob(
        task=task,
        setting=DockingSetting(
            reader=study_sensor(
                study.sensor,
                {table.tag: link},
                responses[0].azimuths_rad,
                noise_db=table.noise_db,
            ),
            camera=LandmarkSensor(
                width_rad=math.radians(table.camera_width_deg),
                farthest_m=table.camera_range_m,
                position_sd_m=table.position_sd_m,
                attitude_sd_rad=math.radians(table.attitude_sd_deg),
                detection_probability=table.detection_probability,
                false_probability=table.false_probability,
                scene=built.scene,
            ),
            robot=DifferentialDrive(),
            blocked=space.footprint,
            outside=space.outside,
        ),
        starts=_starts(table, task, space),
    )


def _starts(table: Dock, task: DockingTask, space: RobotSpace) -> RandomStarts:
    if table.start_low_m is not None and table.start_high_m is not None:
        low, high = np.array(table.start_low_m), np.array(table.start_high_m)
    elif space.scene.has_room:
        low, high = space.scene.bounds_m[:, :2]
    else:
        staging = task.landmark.goal(task.staging_m)[:2]
        low, high = staging - _FREE_SPACE_START_M, staging + _FREE_SPACE_START_M
    return RandomStarts(low_m=low, high_m=high, fits=space)


def docking_rooms(study: Study) -> tuple[Setting, ...]:
    """Return the study's room and its layouts, once the station is known to fit in each.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``.
    """
    rooms = tuple(build_setting(study, layout) for layout in (None, *study.layouts))
    for room in rooms:
        docking_space(study, room)
    return rooms


def run_docking_study(
    study: Study,
    rooms: Sequence[Setting],
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
    rooms : sequence of Setting
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
    """
    table = dock_table(study)
    jobs = {room.name: docking_job(study, room, responses) for room in rooms}
    number = table.runs if runs is None else runs
    results: dict[str, tuple[DockingResult, ...]] = {}
    for name, job in jobs.items():
        with progress.count(number, label=name) as done, worker_map(workers) as mapper:
            results[name] = run_seeded(
                job, runs=number, seed=study.seed, mapper=mapper, progress=done
            )
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
