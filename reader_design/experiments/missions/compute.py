"""A study's mission in one of its rooms: floor, starts, sensor, navigator, placed objects."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.power.backscatter import BackscatterLink
from octant.geometries.errors import ConfigError, GeometryError, NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.control.controllers import (
    Controller,
    FuzzyController,
    PatternController,
    VectorSumController,
)
from octant.navigation.missions.batches import run_seeded
from octant.navigation.missions.navigators import thesis_navigator, tracker_navigator
from octant.navigation.missions.records import Mission, MissionResult
from octant.navigation.missions.run import MissionJob
from octant.navigation.missions.starts import ListedStarts, RandomStarts, Starts
from octant.navigation.navigators.arrival import ArrivalTest, arrival_tests
from octant.navigation.navigators.interface import Navigator
from octant.navigation.navigators.own import OwnNavigator, Told, find_navigator, place_of
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import RobotSpace
from octant.navigation.sensing.bearing import FRONT_AZIMUTH_RAD
from octant.navigation.sensing.pattern_match import PatternMatcher, PowerTable
from octant.navigation.sensing.sensor import PowerLink
from octant.reader_design.experiments.missions.planned import planned_navigator
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.seeded import count_seeded, map_seeded
from octant.reader_design.keeping.workers import Crew, worker_map
from octant.reader_design.mapping.field_maps import mapped_tags
from octant.reader_design.mapping.pose_filter import MapStore
from octant.reader_design.setting.inventory import study_inventory
from octant.reader_design.setting.links import mission_tables
from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.setting.robot import free_place_m, study_robot
from octant.reader_design.setting.robot import mission_space as study_space
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.setting.truth import World, true_world
from octant.reader_design.study_file.mission import NAVIGATORS
from octant.reader_design.study_file.mission import Mission as MissionTable
from octant.reader_design.study_file.room import RoomObject
from octant.reader_design.study_file.rules import mission_rules

FloatArray = npt.NDArray[np.float64]


_AROUND_M = 1.0
_WATT_PER_NANOWATT = 1e-9
_DRAWS = 100


def study_mission(setting: Setting, links: Mapping[str, PowerLink]) -> Mission:
    """Return the mission of a study in one of its rooms [m], [rad], [s].

    Parameters
    ----------
    setting : The reader in a room of a study with a mission.
    links : Link of each tag of the mission; the arrival thresholds [W] come from them, or from free
        space where a tag's link gives nothing, as behind metal.
    """
    table = setting.mission
    points = np.array([setting.tag(tag_id).point_m for tag_id in table.tags])
    # A threshold is what the tag would send: whether it wakes there is another question.
    known = {
        tag_id: link.always_awake() if isinstance(link, BackscatterLink) else link
        for tag_id, link in links.items()
    }
    arrivals: list[ArrivalTest] = []
    for tag_id, point in zip(table.tags, points, strict=True):
        try:
            arrivals += arrival_tests(known, [tag_id], point[None], radius_m=table.arrival_radius_m)
        except NavigationError:
            lone = {tag_id: setting.open_link(setting.tag(tag_id))}
            arrivals += arrival_tests(
                lone, [tag_id], np.zeros((1, 2)), radius_m=table.arrival_radius_m
            )
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
        rolling=study_robot(setting.study, "mission").rolling,
    )


def mission_space(setting: Setting) -> RobotSpace:
    """Return where the robot of a study's mission can stand in one of its rooms.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission [m].
    """
    return study_space(setting.study, setting.scene)


def mission_starts(table: MissionTable, space: RobotSpace, points_m: FloatArray) -> Starts | None:
    """Return the starts of a study's runs, checked [m], [rad]; None: all at the mission's start.

    Parameters
    ----------
    table, space : ``[mission]``; where the robot can stand.
    points_m : (k, 2) float64 — Under the tags; random starts in free space lie around them [m].
    """
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
            better = free_place_m(space, place)
            hint = f", such as {key} = {list(better)}" if better and not table.starts else ""
            msg = (
                f"{key} is {list(place)} m, but a robot of radius "
                f"{space.footprint.radius_m:g} m does not fit there; start on free floor{hint}."
            )
            raise ConfigError(msg)
    if not table.starts:
        return None
    poses = np.array(table.starts)
    poses[:, 2] = np.radians(poses[:, 2])
    return ListedStarts(poses=poses)


def mission_job(
    setting: Setting,
    *,
    noise_db: float | None = None,
    own: type | None = None,
    world: World | None = None,
    maps: MapStore | None = None,
) -> MissionJob:
    """Return what makes one run of a study's mission from its seed, in one of its rooms.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission [m].
    noise_db : Noise of each reading [dB]; None: the world's or the study's.
    own : A navigator's class in place of the one that the study names.
    world : How the world differs from what the navigator is told; None: not at all.
    maps : Where field maps are kept; None: they are computed anew.
    """
    told, table = setting, setting.mission
    setting = told if world is None else world.setting
    heard = mapped_tags(told) if table.navigator == "map" else ()
    names = dict.fromkeys((*table.tags, *(tag.id for tag in heard)))
    links = {tag_id: setting.link(setting.tag(tag_id)) for tag_id in names}
    known = links if world is None else {n: told.link(told.tag(n)) for n in table.tags}
    if noise_db is None:
        noise_db = None if world is None else world.noise_db
    robot = study_robot(setting.study, "mission").drive
    mission = study_mission(setting, known)
    space = mission_space(setting)
    return MissionJob(
        mission=mission,
        sensor=study_sensor(
            setting.study.sensor,
            links if world is None else world.erring(links),
            setting.responses[0].azimuths_rad,
            noise_db=table.noise_db if noise_db is None else noise_db,
            inventory=study_inventory(
                setting, links, key="mission.sample_time_s", period_s=table.sample_time_s
            ),
        ),
        navigator=study_navigator(told, mission, robot=robot, own=own, maps=maps),
        robot=robot,
        blocked=space.footprint,
        outside=space.outside,
        starts=mission_starts(table, space, mission.tag_points_m),
        carried=None if world is None else world.carried(space),
        earlier=table.map.earlier_missions if table.navigator == "map" else 0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionRuns:
    """Runs of a mission in one room.

    Attributes
    ----------
    job, setting : Makes one run from its seed; the room [m].
    runs, seed : Number of runs, and their base seed.
    """

    job: MissionJob
    setting: Setting
    runs: int
    seed: int


def mission_runs(
    setting: Setting,
    *,
    runs: int | None = None,
    noise_db: float | None = None,
    own: type | None = None,
    maps: MapStore | None = None,
) -> tuple[MissionRuns, ...]:
    """Return the runs of a study's mission, shared evenly by placements of objects and by worlds.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission [m], driven in as it is where objects
        are not placed at random.
    runs, noise_db : Number of runs in all and noise [dB]; None: the study's.
    own : As for `mission_job`.
    maps : Where field maps are kept; None: they are computed anew.
    """
    table, seed, truth = setting.mission, setting.study.seed, setting.study.truth
    total = table.runs if runs is None else runs
    drawn = truth is not None and truth.draws > 1
    if table.placement_m == 0.0 and not drawn:
        world = None if truth is None else true_world(setting, np.random.default_rng(seed))
        job = mission_job(setting, noise_db=noise_db, own=own, world=world, maps=maps)
        return (MissionRuns(job=job, setting=setting, runs=total, seed=seed),)
    found = []
    draws = max(table.placements if table.placement_m else 1, truth.draws if truth else 1)
    for share, child in _shares(np.random.SeedSequence(seed), total, draws):
        rng = np.random.default_rng(child)
        there = placed(setting, rng) if table.placement_m else setting
        world = None if truth is None else true_world(there, rng)
        job = mission_job(there, noise_db=noise_db, own=own, world=world, maps=maps)
        own_seed = int(child.generate_state(1)[0])
        found.append(MissionRuns(job=job, setting=there, runs=share, seed=own_seed))
    return tuple(found)


def drive(
    runs: Sequence[MissionRuns],
    *,
    folder: Path,
    crew: Crew | None = None,
    progress: Progress | None = None,
    label: str = "missions",
) -> tuple[MissionResult, ...]:
    """Return the results of runs, run 0 first; those that the folder holds are read.

    Parameters
    ----------
    runs, folder, label : From `mission_runs`; where results are kept; what runs are called.
    crew, progress : Workers that share the runs, None: this process; shows runs.
    """
    return tuple(
        result
        for one in runs
        for result in map_seeded(
            one.job,
            runs=one.runs,
            seed=one.seed,
            kind=MissionResult,
            folder=folder,
            crew=crew,
            progress=progress,
            label=label,
        )
    )


def count_kept(runs: Sequence[MissionRuns], *, folder: Path) -> int:
    """Return how many of the runs a folder holds.

    Parameters
    ----------
    runs, folder : As for `drive`.
    """
    return sum(
        count_seeded(one.job, runs=one.runs, seed=one.seed, kind=MissionResult, folder=folder)
        for one in runs
    )


def drive_missions(
    setting: Setting,
    *,
    runs: int | None = None,
    noise_db: float | None = None,
    own: type | None = None,
    workers: int = 1,
    progress: Callable[[int], object] | None = None,
) -> tuple[MissionResult, ...]:
    """Return the runs of a study's mission in one of its rooms, without keeping them.

    Parameters
    ----------
    setting, runs, noise_db, own : As for `mission_runs` ([m], [dB]).
    workers, progress : Processes that share the runs; called with the number of finished runs.
    """
    with worker_map(workers) as mapper:
        return tuple(
            result
            for one in mission_runs(setting, runs=runs, noise_db=noise_db, own=own)
            for result in run_seeded(
                one.job, runs=one.runs, seed=one.seed, mapper=mapper, progress=progress
            )
        )


def study_controller(table: MissionTable, pattern: PowerTable | None = None) -> Controller:
    """Return the controller that a mission names; its full scale in the study is in [nW].

    Parameters
    ----------
    table, pattern : ``[mission]``; the reader's patterns [W], for the controller ``pattern``.
    """
    gain_per_s = 0.5 / table.sample_time_s
    if table.controller == "vector_sum":
        return VectorSumController(gain_per_s=gain_per_s)
    if table.controller == "pattern":
        if pattern is None:
            msg = 'mission.controller is "pattern", which needs the reader\'s patterns; give them.'
            raise ConfigError(msg)
        return PatternController(matcher=PatternMatcher(table=pattern), gain_per_s=gain_per_s)
    return FuzzyController(
        steering_input=table.steering_input,
        full_scale_w=table.full_scale_nw * _WATT_PER_NANOWATT,
        rules=mission_rules(table),
    )


def study_navigator(
    setting: Setting,
    mission: Mission,
    *,
    robot: DifferentialDrive,
    own: type | None = None,
    maps: MapStore | None = None,
) -> Navigator[Any]:
    """Return the navigator that a study's mission names.

    Parameters
    ----------
    setting : The reader in its room: how the tags hang is taken from it, and not where.
    mission, robot : From `study_mission` [m], [rad], [s]; the robot.
    own : As for `mission_job`.
    maps : Where field maps are kept; None: they are computed anew.
    """
    table, method = setting.mission, study_robot(setting.study, "mission").odometry
    if own is not None or table.navigator not in NAVIGATORS:
        return OwnNavigator(
            place=find_navigator(table.navigator) if own is None else place_of(own),
            kind=own,
            told=Told(
                tag_ids=mission.tag_ids,
                heading_rad=mission.heading_rad,
                azimuths_rad=wrap_angle(setting.responses[0].azimuths_rad - FRONT_AZIMUTH_RAD),
                period_s=mission.sample_time_s,
                cruise_step_m=mission.cruise_step_m,
                arrival_radius_m=table.arrival_radius_m,
                robot=robot,
                tables=mission_tables(setting),
            ),
        )
    if table.navigator in {"map", "counting"}:
        return planned_navigator(
            setting, mission, mission_space(setting), robot=robot, method=method or "exact",
            maps=maps or MapStore(),
        )  # fmt: skip
    if table.navigator == "tracker":
        return tracker_navigator(
            mission,
            tables=mission_tables(setting),
            robot=robot,
            trust=table.tracker.trust,
            fading_db=table.tracker.fading_db,
            level_db=table.tracker.level_db,
            method=method or "rk2",
        )
    pattern = mission_tables(setting)[0] if table.controller == "pattern" else None
    return thesis_navigator(
        mission,
        azimuths_rad=setting.responses[0].azimuths_rad,
        controller=study_controller(table, pattern),
        robot=robot,
        rotation=table.rotation,
        rerotate_for_s=table.rerotate_for_s,
        method=method or "exact",
    )


def placed(setting: Setting, rng: np.random.Generator) -> Setting:
    """Return a setting with objects at random places that leave start and tags free [m].

    Parameters
    ----------
    setting : With a mission, whose ``placement_m`` says how far the room's own objects move along x
        and y [m].
    rng : Source of the places.
    """
    study, layout, table = setting.study, setting.layout, setting.mission
    places = [table.start_m, *(t.position_m[:2] for t in study.tags if t.id in table.tags)]
    for _ in range(_DRAWS):
        if layout is None:
            objects = _moved(study.room.objects, table.placement_m, rng)
            room = msgspec.structs.replace(study.room, objects=objects)
            moved, there = msgspec.structs.replace(study, room=room), None
        else:
            objects = _moved(layout.objects, table.placement_m, rng)
            moved, there = study, msgspec.structs.replace(layout, objects=objects)
        try:
            other = build_setting(moved, there)
        except (ConfigError, GeometryError):
            continue
        if bool(mission_space(other)(np.array(places)).all()):
            return other.with_responses(setting.responses)
    msg = (
        f"mission.placement_m is {table.placement_m:g} m, but in {_DRAWS} draws the objects always "
        "covered the start or a tag's point; move them less, or start them farther off."
    )
    raise ConfigError(msg)


def _shares(
    seeds: np.random.SeedSequence, total: int, count: int
) -> Iterator[tuple[int, np.random.SeedSequence]]:
    """Yield the number of runs and the seed of each placement that gets any."""
    for number, child in enumerate(seeds.spawn(count)):
        share = total * (number + 1) // count - total * number // count
        if share:
            yield share, child


def _moved(
    objects: tuple[RoomObject, ...], reach_m: float, rng: np.random.Generator
) -> tuple[RoomObject, ...]:
    moved = []
    for thing in objects:
        dx, dy = rng.uniform(-reach_m, reach_m, 2)
        x, y, z = thing.position_m
        moved.append(msgspec.structs.replace(thing, position_m=(float(x + dx), float(y + dy), z)))
    return tuple(moved)
