"""A study's docking missions: task, reader, camera, obstacles and starts, ready to be run."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from octant.em.reader.response import ReaderResponse
from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.control.docking_law import DockingLaw, TwistLimits
from octant.navigation.docking.run import DockingJob
from octant.navigation.docking.setting import DockingSetting
from octant.navigation.docking.task import (
    CoarseStage,
    DockingResult,
    DockingTask,
    FineStage,
    task_filter,
)
from octant.navigation.missions.batches import run_seeded
from octant.navigation.missions.starts import RandomStarts
from octant.navigation.robot.collisions import RobotSpace, footprint
from octant.navigation.robot.docking_world import WheelSlip
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor
from octant.navigation.sensing.sensor import FieldSensor
from octant.reader_design.setting.links import tag_link
from octant.reader_design.setting.scene import StudyScene
from octant.reader_design.study_file.dock import Dock
from octant.reader_design.study_file.schema import Study

_FREE_SPACE_START_M = 4.0


def dock_table(study: Study) -> Dock:
    """Return the study's table ``[dock]`` [m], [deg], [s].

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    Dock
        The table.

    Raises
    ------
    ConfigError
        When the study has none.
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

    Returns
    -------
    DockingTask
        Ready to be run.

    Raises
    ------
    NavigationError
        When a value is out of range.

    Warns
    -----
    PhysicsWarning
        When the gains are outside the region of bounded curvature.
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


def docking_space(study: Study, built: StudyScene) -> RobotSpace:
    """Return where the study's robot can stand in one of its rooms, once its station is checked.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``.
    built : StudyScene
        The room [m].

    Returns
    -------
    RobotSpace
        The floor.

    Raises
    ------
    ConfigError
        When the study has no table ``[dock]``, the landmark is inside something, or the robot does
        not fit into the dock.
    """
    table = dock_table(study)
    task = docking_task(table)
    try:
        task.landmark.check(built.scene)
    except NavigationError as exc:
        msg = f"dock.landmark_position_m: {exc}"
        raise ConfigError(msg) from exc
    space = RobotSpace(
        footprint=footprint(
            built.scene, radius_m=table.robot_radius_m, height_m=table.robot_height_m
        ),
        scene=built.scene,
        height_m=table.robot_height_m,
    )
    if not space(task.goal[None, :2])[0]:
        x, y = task.goal[:2]
        msg = (
            f"dock.stand_off_m puts the dock at ({x:g}, {y:g}) m, where a robot of radius "
            f"{table.robot_radius_m:g} m does not fit; give it more room."
        )
        raise ConfigError(msg)
    return space


def docking_job(study: Study, built: StudyScene, responses: Sequence[ReaderResponse]) -> DockingJob:
    """Return what makes one docking mission of a study from its seed, in one of its rooms.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``.
    built : StudyScene
        The room [m].
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz`` [Hz].

    Returns
    -------
    DockingJob
        For `octant.navigation.missions.batches.run_seeded`.

    Raises
    ------
    ConfigError
        As `docking_space`.
    """
    table = dock_table(study)
    task, space = docking_task(table), docking_space(study, built)
    link = tag_link(study, built, built.tag(table.tag), responses)
    return DockingJob(
        task=task,
        setting=DockingSetting(
            reader=FieldSensor(
                links={table.tag: link},
                azimuths_rad=responses[0].azimuths_rad,
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
        ),
        starts=_starts(table, task, space),
    )


def run_dockings(
    study: Study,
    job: DockingJob,
    *,
    runs: int | None = None,
    workers: int = 1,
    progress: Callable[[int], object] | None = None,
) -> tuple[DockingResult, ...]:
    """Return the docking missions of a study in one of its rooms.

    Parameters
    ----------
    study : Study
        With a table ``[dock]``; its seed is used.
    job : DockingJob
        From `docking_job`.
    runs : int or None
        Number of runs; None: the table's.
    workers : int
        Processes that share them; the results are the same to the bit.
    progress : callable or None
        Called with the number of finished runs.

    Returns
    -------
    tuple of DockingResult
        Run 0 first.
    """
    return run_seeded(
        job,
        runs=dock_table(study).runs if runs is None else runs,
        seed=study.seed,
        workers=workers,
        progress=progress,
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
