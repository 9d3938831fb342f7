"""A study's mission: sensor, navigator, floor and starts, put together and driven."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.missions.records import Mission, MissionResult
from octant.navigation.missions.run import run_missions
from octant.navigation.missions.starts import ListedStarts, RandomStarts, Starts
from octant.navigation.navigators.arrival import ArrivalTest, arrival_tests
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import RobotSpace
from octant.navigation.robot.odometry import Rolling
from octant.navigation.sensing.sensor import PowerLink
from octant.reader_design.experiments.missions.navigators import study_navigator
from octant.reader_design.keeping.workers import worker_map
from octant.reader_design.setting.links import mission_table, open_link, tag_link
from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.setting.robot import robot_space
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

_AROUND_M = 1.0


def study_mission(
    study: Study,
    built: Setting,
    links: Mapping[str, PowerLink],
    responses: Sequence[ReaderResponse],
) -> Mission:
    """Return the mission of a study in one of its rooms [m], [rad], [s].

    Parameters
    ----------
    study : Study
        With a mission.
    built : Setting
        The room.
    links : mapping of str to PowerLink
        Link of each tag of the mission; the arrival thresholds [W] come from them.
    responses : sequence of ReaderResponse
        The reader's: where a tag's link gives nothing, as behind metal, the threshold is that of
        free space.
    """
    table = mission_table(study)
    points = np.array([built.tag(tag_id).point_m for tag_id in table.tags])
    arrivals: list[ArrivalTest] = []
    for tag_id, point in zip(table.tags, points, strict=True):
        try:
            arrivals += arrival_tests(links, [tag_id], point[None], radius_m=table.arrival_radius_m)
        except NavigationError:
            lone = {tag_id: open_link(study, built, tag_id, responses)}
            arrivals += arrival_tests(
                lone, [tag_id], np.zeros((1, 2)), radius_m=table.arrival_radius_m
            )
    counts = table.encoder_counts
    return Mission(
        start_m=np.array(table.start_m),
        heading_rad=math.radians(table.heading_deg),
        tag_ids=table.tags,
        tag_points_m=points,
        arrivals=tuple(arrivals),
        sample_time_s=table.sample_time_s,
        cruise_step_m=table.cruise_step_m,
        max_time_s=table.max_time_s,
        silent_limit=table.silent_limit,
        contact=table.contact,
        rolling=Rolling(
            slip_sd=table.wheel_slip,
            scale_sd=table.wheel_scale,
            tick_rad=0.0 if counts is None else 2.0 * math.pi / counts,
        ),
    )


def mission_space(study: Study, built: Setting) -> RobotSpace:
    """Return where the robot of a study's mission can stand in one of its rooms.

    Parameters
    ----------
    study : Study
        With a mission.
    built : Setting
        The room [m].
    """
    table = mission_table(study)
    return robot_space(
        built.scene, study.reader, radius_m=table.robot_radius_m, height_m=table.robot_height_m
    )


def mission_starts(study: Study, space: RobotSpace, points_m: FloatArray) -> Starts | None:
    """Return the starts of a study's runs, checked [m], [rad].

    Parameters
    ----------
    study : Study
        With a mission.
    space : RobotSpace
        Where the robot can stand.
    points_m : (k, 2) float64
        Points under the tags [m]; in free space the random starts lie around them.

    Returns
    -------
    Starts or None
        None: all runs start at the mission's own start.
    """
    table = mission_table(study)
    if table.random_starts:
        if space.scene.has_room:
            low, high = space.scene.bounds_m[:, :2]
        else:
            way = np.vstack([points_m, table.start_m])
            low, high = way.min(axis=0) - _AROUND_M, way.max(axis=0) + _AROUND_M
        return RandomStarts(low_m=low, high_m=high, fits=space)
    places = [("mission.start_m", table.start_m)] if not table.starts else []
    places += [(f"mission.starts[{i}]", start[:2]) for i, start in enumerate(table.starts)]
    for key, place in places:
        if not space(np.array(place)[None])[0]:
            msg = (
                f"{key} is {list(place)} m, but a robot of radius "
                f"{space.footprint.radius_m:g} m does not fit there; start on free floor."
            )
            raise ConfigError(msg)
    if not table.starts:
        return None
    poses = np.array(table.starts)
    poses[:, 2] = np.radians(poses[:, 2])
    return ListedStarts(poses=poses)


def drive_missions(
    study: Study,
    built: Setting,
    responses: Sequence[ReaderResponse],
    *,
    runs: int | None = None,
    noise_db: float | None = None,
    seed: int | None = None,
    workers: int = 1,
    progress: Callable[[int], object] | None = None,
) -> tuple[MissionResult, ...]:
    """Return the runs of a study's mission in one of its rooms.

    Parameters
    ----------
    study : Study
        With a mission.
    built : Setting
        The room.
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz``.
    runs : int or None
        Number of runs; None: the study's.
    noise_db : float or None
        Noise of each reading [dB]; None: the study's.
    seed : int or None
        Base seed; None: the study's.
    workers : int
        Processes that share the runs.
    progress : callable or None
        Called with the number of finished runs.

    Returns
    -------
    tuple of MissionResult
        Run 0 first.
    """
    table = mission_table(study)
    wanted = dict.fromkeys(table.tags)
    links = {t: tag_link(study, built, built.tag(t), responses) for t in wanted}
    robot = DifferentialDrive()
    mission = study_mission(study, built, links, responses)
    space = mission_space(study, built)
    with worker_map(workers) as mapper:
        return run_missions(
            mission,
            study_sensor(
                study.sensor,
                links,
                responses[0].azimuths_rad,
                noise_db=table.noise_db if noise_db is None else noise_db,
            ),
            study_navigator(study, built, mission, responses, robot=robot),
            robot,
            runs=table.runs if runs is None else runs,
            seed=study.seed if seed is None else seed,
            mapper=mapper,
            blocked=space.footprint,
            outside=space.outside,
            starts=mission_starts(study, space, mission.tag_points_m),
            progress=progress,
        )
