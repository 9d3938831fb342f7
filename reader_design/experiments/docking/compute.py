"""The docking missions of a study, in each of its rooms."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from octant.geometries.errors import ConfigError, NavigationError
from octant.geometries.scene import Scene
from octant.navigation.control.docking_law import DockingLaw, TwistLimits
from octant.navigation.docking.run import DockingJob
from octant.navigation.docking.task import (
    CoarseStage,
    DockingResult,
    DockingSetting,
    DockingTask,
    FineStage,
    task_filter,
)
from octant.navigation.missions.starts import RandomStarts
from octant.navigation.robot.floor import RobotSpace, WheelSlip
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor
from octant.reader_design.experiments.docking.published import (
    FilterExperiment,
    filter_experiment,
    published_job,
    straight_experiment,
)
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.seeded import count_seeded, map_seeded
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.setting.inventory import study_inventory
from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.setting.robot import robot_space, study_robot
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.dock import Dock
from octant.reader_design.study_file.schema import Study

_FREE_SPACE_START_M = 4.0
_LEAST_REPETITIONS = 20  # fewer errors cannot be tested for a Gaussian
_MOST_REPETITIONS = 100


def dock_table(study: Study) -> Dock:
    """Return the study's table ``[dock]`` [m], [deg], [s].

    Parameters
    ----------
    study : The study.
    """
    if study.dock is None:
        msg = "the study has no table [dock], which is needed to dock; add tag and landmark."
        raise ConfigError(msg)
    return study.dock


def docking_task(study: Study) -> DockingTask:
    """Return the docking task of a study [m], [rad], [s].

    Parameters
    ----------
    study : With a table ``[dock]``, and perhaps ``[robot]``.
    """
    table, rolling = dock_table(study), study_robot(study, "dock").rolling
    return DockingTask(
        tag_id=table.tag,
        landmark=Landmark(
            position_m=np.array(table.landmark_position_m),
            heading_rad=math.radians(table.landmark_heading_deg),
        ),
        stand_off_m=table.stand_off_m,
        staging_m=table.staging_m,
        tolerance_m=table.tolerance_m,
        tolerance_rad=math.radians(table.tolerance_deg),
        tries=table.tries,
        coarse=CoarseStage(period_s=table.reading_time_s),
        fine=FineStage(
            law=DockingLaw(
                gamma_per_s=table.gamma_per_s,
                h=table.h,
                k_per_s=table.k_per_s,
                approach=table.approach,
            ),
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
            start_error=_start_error(table),
        ),
        slip=WheelSlip(
            linear_m_per_s=rolling.linear_m_per_s,
            angular_rad_per_s=rolling.angular_rad_per_s,
        ),
    )


def _start_error(table: Dock) -> tuple[float, float, float] | None:
    if table.start_error_m is None and table.start_error_deg is None:
        return None
    x, y = table.start_error_m or (0.0, 0.0)
    return x, y, math.radians(table.start_error_deg or 0.0)


def _camera(table: Dock, scene: Scene) -> LandmarkSensor:
    """Return the station's camera: the paper's, turned about with what it stands on in reverse."""
    paper = LandmarkSensor()
    backwards = table.approach == "reverse"
    side = np.array([-1.0, -1.0, 1.0]) if backwards else np.ones(3)
    return LandmarkSensor(
        position_m=side * paper.position_m,
        yaw_rad=paper.yaw_rad + math.pi * backwards,
        width_rad=math.radians(table.camera_width_deg),
        farthest_m=table.camera_range_m,
        position_sd_m=table.position_sd_m,
        attitude_sd_rad=math.radians(table.attitude_sd_deg),
        detection_probability=table.detection_probability,
        false_probability=table.false_probability,
        scene=scene,
    )


def docking_space(setting: Setting) -> RobotSpace:
    """Return where the study's robot can stand in one of its rooms, once its station is checked.

    Parameters
    ----------
    setting : A room of a study with a table ``[dock]`` [m].
    """
    task, robot = docking_task(setting.study), study_robot(setting.study, "dock")
    try:
        task.landmark.check(setting.scene)
    except NavigationError as exc:
        msg = f"dock.landmark_position_m: {exc}"
        raise ConfigError(msg) from exc
    space = robot_space(
        setting.scene, setting.reader, radius_m=robot.radius_m, height_m=robot.height_m
    )
    if not space(task.goal[None, :2])[0]:
        x, y = task.goal[:2]
        msg = (
            f"dock.stand_off_m puts the dock at ({x:g}, {y:g}) m, where the robot of radius "
            f"{space.footprint.radius_m:g} m does not fit; give it more room."
        )
        raise ConfigError(msg)
    return space


def docking_job(setting: Setting) -> DockingJob:
    """Return what makes one docking mission of a study from its seed, in one of its rooms.

    Parameters
    ----------
    setting : The reader in a room of a study with a table ``[dock]`` [m].
    """
    table = dock_table(setting.study)
    task, space = docking_task(setting.study), docking_space(setting)
    link, robot = setting.link(setting.tag(table.tag)), study_robot(setting.study, "dock")
    return DockingJob(
        task=task,
        setting=DockingSetting(
            reader=study_sensor(
                setting.study.sensor,
                {table.tag: link},
                link.azimuths_rad,
                noise_db=table.noise_db,
                inventory=study_inventory(
                    setting,
                    {table.tag: link},
                    key="dock.reading_time_s",
                    period_s=table.reading_time_s,
                ),
            ),
            camera=_camera(table, setting.scene),
            robot=robot.drive,
            odometry=robot.odometry or "exact",
            # The task's slip has the constant ones.
            rolling=replace(robot.rolling, linear_m_per_s=0.0, angular_rad_per_s=0.0),
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
    study : With a table ``[dock]``.
    """
    rooms = tuple(build_setting(study, layout) for layout in (None, *study.layouts))
    for room in rooms:
        docking_space(room)
    return rooms


@dataclass(frozen=True, slots=True, kw_only=True)
class DockingContent:
    """Everything that a docking study computed.

    Parameters
    ----------
    study, rooms : The study, and room and runs by the room's name.
    published : The docking paper's closed loop, by whether slips were compensated.
    """

    study: Study
    rooms: Mapping[str, tuple[Setting, tuple[DockingResult, ...]]]
    published: Mapping[bool, tuple[DockingResult, ...]]

    @property
    def results(self) -> dict[str, tuple[DockingResult, ...]]:
        """The missions by room."""
        return {name: runs for name, (_, runs) in self.rooms.items()}


def docking_jobs(rooms: Sequence[Setting]) -> dict[str | bool, tuple[DockingJob, int]]:
    """Return jobs and their runs: missions by room, the paper's by whether slips are compensated.

    Parameters
    ----------
    rooms : The `docking_rooms` of a study; they share one reader.
    """
    runs = dock_table(rooms[0].study).runs
    responses = rooms[0].solved().responses
    missions = {room.name: docking_job(room.with_responses(responses)) for room in rooms}
    first = missions[rooms[0].name]
    task, setting = first.task, first.setting
    most = min(runs, _MOST_REPETITIONS)
    return {
        **{name: (job, runs) for name, job in missions.items()},
        True: (published_job(task, setting, compensate_slips=True), most),
        False: (published_job(task, setting, compensate_slips=False), max(2, most // 10)),
    }


def compute_docking(
    study: Study,
    rooms: Sequence[Setting],
    jobs: Mapping[str | bool, tuple[DockingJob, int]],
    folder: Path,
    *,
    crew: Crew | None = None,
    progress: Progress | None = None,
) -> DockingContent:
    """Return what a docking study computes; runs that the folder holds are read.

    Parameters
    ----------
    study, rooms, jobs : A study with a table ``[dock]``, its `docking_rooms` and `docking_jobs`.
    folder, crew : Where runs are kept, and who shares them; None: this process computes.
    progress : Shows how many runs are done.
    """
    results = {
        name: map_seeded(
            job,
            runs=runs,
            seed=study.seed,
            kind=DockingResult,
            folder=folder,
            crew=crew,
            progress=progress,
            label=name if isinstance(name, str) else "docking on estimates",
        )
        for name, (job, runs) in jobs.items()
    }
    return DockingContent(
        study=study,
        rooms={room.name: (room, results[room.name]) for room in rooms},
        published={compensated: results[compensated] for compensated in (True, False)},
    )


def kept_runs(study: Study, jobs: Mapping[str | bool, tuple[DockingJob, int]], folder: Path) -> str:
    """Return how many runs a docking study has, and how many the folder holds.

    Parameters
    ----------
    study, jobs, folder : A study, its `docking_jobs`, and where runs are kept.
    """
    total = sum(runs for _, runs in jobs.values())
    kept = sum(
        count_seeded(job, runs=runs, seed=study.seed, kind=DockingResult, folder=folder)
        for job, runs in jobs.values()
    )
    return f"{total} runs, of which {kept} are computed already."


def landmark_filters(study: Study) -> tuple[FilterExperiment, FilterExperiment]:
    """Return the paper's landmark filters over many drives, and on the simpler drive.

    Parameters
    ----------
    study : For its seed, and its runs: there are 20 to 100 drives.
    """
    repetitions = min(max(dock_table(study).runs, _LEAST_REPETITIONS), _MOST_REPETITIONS)
    return (
        filter_experiment(seed=study.seed, repetitions=repetitions),
        straight_experiment(seed=study.seed),
    )
