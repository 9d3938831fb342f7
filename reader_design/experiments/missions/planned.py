"""Navigators that know the room: their field maps, kept, and their ways on the floor plan."""

import math

import numpy as np

from octant.geometries.errors import ConfigError
from octant.navigation.missions.records import Mission
from octant.navigation.navigators.map_navigator import CountingNavigator, Follower, MapNavigator
from octant.navigation.navigators.ways import SPACING_M, floor_plan, occupancy
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import RobotSpace
from octant.navigation.robot.motion import Integration
from octant.reader_design.mapping.field_maps import mapped_tags
from octant.reader_design.mapping.pose_filter import MapStore, study_pose_filter
from octant.reader_design.setting.setting import Setting


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
    radius_m = min(test.radius_m for test in mission.arrivals)
    hears = tuple(tag.id for tag in mapped_tags(setting))
    return MapNavigator(
        hears=hears,
        targets=tuple(hears.index(tag_id) for tag_id in table.tags),
        filter=study_pose_filter(
            setting, space, maps, bounds_m=(low, high), blocked=blocked, method=method
        ),
        follower=follower,
        start_pose=start if known else None,
        arrival_radius_m=radius_m,
        tag_sd_m=table.map.tag_sd_m,
    )
