"""A study's mission: links of the tags, sensor, controller and obstacles, ready to be driven."""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.reader_response import ReaderResponse
from octant.em.received_power import ReaderLink, reader_link
from octant.geometries.errors import ConfigError, PhysicsWarning
from octant.geometries.scene import Scene
from octant.navigation.arrival import arrival_tests
from octant.navigation.controllers import Controller, FuzzyController, VectorSumController
from octant.navigation.missions import Mission, MissionResult, run_missions
from octant.navigation.robot import DifferentialDrive
from octant.navigation.sensing import PowerLink
from octant.reader_design.config.schema import Mission as MissionTable
from octant.reader_design.config.schema import Study
from octant.reader_design.rooms.study_scene import PlacedTag, StudyScene
from octant.reader_design.study.sensors import study_sensor
from octant.reader_design.sweep.design import design_of, design_responses
from octant.reader_design.sweep.samples import standing_room

WATT_PER_NANOWATT = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorObstacles:
    """Says where the robot's centre cannot be; picklable, unlike a closure.

    Parameters
    ----------
    scene : Scene
        Room and objects.
    reader_z_m : float
        Height coordinate of the reader's ground plane [m].
    clearance_m : float
        Radius of the robot [m].
    """

    scene: Scene
    reader_z_m: float
    clearance_m: float

    def __call__(self, points_m: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Return at which points of the floor the robot does not fit [-].

        Parameters
        ----------
        points_m : (m, 2) float64
            Places of its centre [m].

        Returns
        -------
        (m,) bool
            True where a wall or an object is in the way.
        """
        fits = standing_room(
            self.scene, points_m, reader_z_m=self.reader_z_m, clearance_m=self.clearance_m
        )
        return ~fits


def study_responses(study: Study) -> tuple[ReaderResponse, ...]:
    """Return the response of the reader of a study's table ``[reader]``, one for each frequency.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    tuple of ReaderResponse
        In the order of ``study.radio.frequencies_hz`` [Hz].

    Raises
    ------
    GeometryError, AntennaError
        When the reader cannot be built.

    Warns
    -----
    PhysicsWarning
        For everything that the responses say does not hold.
    """
    responses = design_responses(study, design_of(study.reader))
    for text in dict.fromkeys(text for response in responses for text in response.warnings):
        warnings.warn(text, PhysicsWarning, stacklevel=2)
    return responses


def tag_link(
    study: Study,
    built: StudyScene,
    tag: PlacedTag,
    responses: Sequence[ReaderResponse],
    *,
    height_m: float | None = None,
) -> ReaderLink:
    """Return the link of one tag to the reader: RSS [W] for any pose, mean over the channels.

    Parameters
    ----------
    study : Study
        The study.
    built : StudyScene
        One of its rooms.
    tag : PlacedTag
        One of the room's tags.
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz``.
    height_m : float or None
        Ground plane above the floor [m]; None: the study's.

    Returns
    -------
    ReaderLink
        Coherent RSS and local mean [W] of every antenna.
    """
    return reader_link(
        built.radios,
        tag_position_m=tag.position_m,
        tag_antenna=tag.antennas,
        tag_power_w=study.radio.tag_power_w,
        response=responses,
        reader_height_m=study.reader.height_m if height_m is None else height_m,
        max_reflections=study.solver.max_reflections,
        max_diffractions=study.solver.max_diffractions,
        search=study.solver.search,
        rays=study.solver.rays,
    )


def mission_table(study: Study) -> MissionTable:
    """Return the study's table ``[mission]`` [m], [deg], [s].

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    Mission
        The table.

    Raises
    ------
    ConfigError
        When the study has none.
    """
    if study.mission is None:
        msg = "the study has no table [mission], which is needed to drive; add start_m and tags."
        raise ConfigError(msg)
    return study.mission


def study_mission(study: Study, built: StudyScene, links: Mapping[str, PowerLink]) -> Mission:
    """Return the mission of a study in one of its rooms [m], [rad], [s].

    Parameters
    ----------
    study : Study
        With a mission.
    built : StudyScene
        The room.
    links : mapping of str to PowerLink
        Link of each tag of the mission; the arrival thresholds [W] come from them.

    Returns
    -------
    Mission
        For `octant.navigation.missions.run_missions`.

    Raises
    ------
    ConfigError
        When the study has no mission.
    NavigationError
        When the mission cannot be driven.
    """
    table = mission_table(study)
    points = np.array([built.tag(tag_id).point_m for tag_id in table.tags])
    return Mission(
        start_m=np.array(table.start_m),
        heading_rad=math.radians(table.heading_deg),
        tag_ids=table.tags,
        tag_points_m=points,
        arrivals=arrival_tests(links, table.tags, points, radius_m=table.arrival_radius_m),
        sample_time_s=table.sample_time_s,
        cruise_step_m=table.cruise_step_m,
        max_time_s=table.max_time_s,
        rotation=table.rotation,
    )


def study_controller(table: MissionTable) -> Controller:
    """Return the controller that a mission names; its full scale in the study is in [nW].

    Parameters
    ----------
    table : Mission
        The table ``[mission]``.

    Returns
    -------
    Controller
        Fuzzy, or proportional to the vector sum's bearing.
    """
    if table.controller == "vector_sum":
        return VectorSumController(gain_per_s=0.5 / table.sample_time_s)
    return FuzzyController(
        steering_input=table.steering_input,
        full_scale_w=table.full_scale_nw * WATT_PER_NANOWATT,
    )


def drive_missions(
    study: Study,
    built: StudyScene,
    responses: Sequence[ReaderResponse],
    *,
    runs: int | None = None,
    noise_db: float | None = None,
    workers: int = 1,
    progress: Callable[[int], object] | None = None,
) -> tuple[MissionResult, ...]:
    """Return the runs of a study's mission in one of its rooms.

    Parameters
    ----------
    study : Study
        With a mission.
    built : StudyScene
        The room.
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz``.
    runs : int or None
        Number of runs [-]; None: the study's.
    noise_db : float or None
        Noise of each reading [dB]; None: the study's.
    workers : int
        Processes that share the runs [-].
    progress : callable or None
        Called with the number of finished runs.

    Returns
    -------
    tuple of MissionResult
        Run 0 first.

    Raises
    ------
    ConfigError
        When the study has no mission.
    NavigationError
        When the mission cannot be driven.
    """
    table = mission_table(study)
    wanted = dict.fromkeys(table.tags)
    links = {t: tag_link(study, built, built.tag(t), responses) for t in wanted}
    robot = DifferentialDrive()
    return run_missions(
        study_mission(study, built, links),
        study_sensor(
            study.sensor,
            links,
            responses[0].azimuths_rad,
            noise_db=table.noise_db if noise_db is None else noise_db,
        ),
        study_controller(table),
        robot,
        runs=table.runs if runs is None else runs,
        seed=study.seed,
        workers=workers,
        blocked=FloorObstacles(
            scene=built.scene,
            reader_z_m=built.reader_z_m,
            clearance_m=max(0.5 * study.reader.ground_plane_m, 0.5 * robot.axle_length_m),
        ),
        progress=progress,
    )
