"""Navigators that know the room: their field maps, kept, and their ways on the floor plan."""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.power.field_maps import FieldMap, MapError, joined
from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.missions.records import Mission
from octant.navigation.navigators.map_navigator import CountingNavigator, Follower, MapNavigator
from octant.navigation.navigators.pose_particles import PoseFilter, misplaced_share
from octant.navigation.navigators.ways import SPACING_M, floor_plan, occupancy
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import RobotSpace
from octant.navigation.robot.motion import Integration
from octant.reader_design.experiments.missions.field_maps import (
    EXACT_PLACES,
    FieldMapCodec,
    MappedTag,
    compute_map,
    error_of,
    error_sentence,
    exacter,
    map_context,
    map_forecast,
    mapped_tags,
)
from octant.reader_design.keeping.keeper import map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]

FADING_DB = 5.57
"""Deviation of the level of an exponential power [dB]: of a field of very many waves."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapStore:
    """Where field maps are kept, and who computes them.

    Parameters
    ----------
    folder : Their folder; None: they are not kept.
    crew, progress : Workers that share the tags, None: this process; shows maps.
    """

    folder: Path | None = None
    crew: Crew | None = None
    progress: Progress | None = None


def study_maps(
    setting: Setting, space: RobotSpace, store: MapStore
) -> tuple[FieldMap, tuple[MapError, ...]]:
    """Return the field maps of all tags of a room, and how far they are from a more exact field.

    Parameters
    ----------
    setting, space : The reader in a room of a study with a mission; where the robot can stand.
    store : Where maps are kept.
    """
    tags, context = mapped_tags(setting), map_context(setting)
    cases = [
        MappedTag(position_m=tuple(tag.position_m.tolist()), antennas=tag.antennas) for tag in tags
    ]
    say = (store.progress or Progress()).say
    say(f"{map_forecast(setting)}.")
    with tempfile.TemporaryDirectory() as scratch:
        kept = map_cases(
            compute_map,
            cases,
            context=context,
            folder=store.folder or Path(scratch),
            codec=FieldMapCodec(),
            crew=store.crew,
            progress=store.progress,
            label="field maps",
        )
    found = joined([one.value for one in kept])
    say(error_sentence(error_of(setting, found, tags, space), "the solver"))
    errors = error_of(exacter(setting), found, tags, space, places=EXACT_PLACES)
    say(error_sentence(errors, "one more reflection and diffraction"))
    return found, errors


def planned_navigator(
    setting: Setting,
    mission: Mission,
    space: RobotSpace,
    *,
    robot: DifferentialDrive,
    method: Integration,
    maps: MapStore,
) -> MapNavigator | CountingNavigator:
    """Return the navigator ``map`` or ``counting`` of a study's mission.

    Parameters
    ----------
    setting, space : What it is told of the room; where it believes that it can stand.
    mission, robot, method : Arrival radius, step and period [m], [s]; the robot; how its odometry
        adds up a period's motion.
    maps : Where field maps are kept.
    """
    table = setting.mission
    points = np.array([setting.tag(tag_id).point_m for tag_id in table.tags])
    start = np.array([*table.start_m, math.radians(table.heading_deg)])
    if setting.scene.has_room:
        low, high = setting.scene.bounds_m[:, :2]
    else:
        corners = np.vstack([points, start[:2]])
        low, high = corners.min(axis=0) - 1.0, corners.max(axis=0) + 1.0
    blocked = occupancy(low, high, space)
    plan = floor_plan(
        low, high, points, blocked=blocked,
        spacing_m=min(SPACING_M, 0.7 * space.footprint.radius_m),
    )  # fmt: skip
    for number, tag_id in enumerate(table.tags):
        if table.map.start == "known" and not math.isfinite(plan.length_m(start[:2], number)):
            msg = (
                f"there is no way from the start to tag {tag_id!r} for a robot of radius "
                f"{space.footprint.radius_m:g} m; make it smaller, or the doors wider."
            )
            raise ConfigError(msg)
    follower = Follower(
        plan=plan, robot=robot, cruise_step_m=mission.cruise_step_m, period_s=mission.sample_time_s
    )
    known = table.map.start == "known"
    if known and (table.starts or table.random_starts):
        msg = (
            f'mission.navigator "{table.navigator}" is told one start, mission.start_m, but the '
            'runs start elsewhere; leave starts and random_starts out, or give map.start "unknown".'
        )
        raise ConfigError(msg)
    if table.navigator == "counting":
        return CountingNavigator(follower=follower, start_pose=start, method=method)
    found, errors = study_maps(setting, space, maps)
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / max(r.frequency_hz for r in setting.radios)
    survey = misplaced_share(table.map.tag_sd_m, wavelength_m=wavelength_m)
    shares = np.array([error.share + survey + table.map.field_error for error in errors])
    radius_m = min(test.radius_m for test in mission.arrivals)
    try:
        return MapNavigator(
            hears=tuple(tag.id for tag in mapped_tags(setting)),
            filter=PoseFilter(
                maps=found,
                shares=np.minimum(shares, 1.0),
                floors_w=np.array([error.floor_w for error in errors]),
                low_m=low,
                high_m=high,
                blocked=blocked,
                wavelength_m=wavelength_m,
                radius_m=setting.reader.antenna_radius_m,
                noise_db=max(table.noise_db, 0.5),
                fading_db=fading_of(found),
                level_db=table.map.level_sd_db,
                gain_db=table.map.gain_sd_db,
                particles=table.map.particles,
                method=method,
            ),
            follower=follower,
            start_pose=start if known else None,
            arrival_radius_m=radius_m,
            tag_sd_m=table.map.tag_sd_m,
        )
    except NavigationError as exc:
        raise ConfigError(str(exc)) from exc


def fading_of(maps: FieldMap) -> FloatArray:
    """Return the deviation of the coherent level around the local mean of each tag, (t,) [dB].

    Many channels average fading out; at most that of an exponential power is taken.

    Parameters
    ----------
    maps : Of all tags.
    """
    rng = np.random.default_rng(0)
    low, high = (np.array([x[k], y[k]]) for k in (0, -1) for x, y in ((maps.x_m, maps.y_m),))
    poses = np.column_stack(
        [rng.uniform(low, high, (2000, 2)), rng.uniform(-math.pi, math.pi, 2000)]
    )
    found = []
    for tag in range(maps.tags):
        here, mean = maps.rss_w(poses, tag=tag), maps.local_mean_w(poses, tag=tag)
        sound = (here > 0.0) & (mean > 0.0)
        error = 10.0 * np.log10(here[sound] / mean[sound])
        found.append(float(np.clip(np.std(error), 1.0, FADING_DB)))
    return np.array(found)
