"""Ways on which a log is simulated: through the tags, over the free floor, or as a file says."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.navigation.angles import wrap_angle
from octant.navigation.navigators.ways import FloorPlan, floor_plan, occupancy
from octant.navigation.robot.floor import RobotSpace
from octant.reader_design.setting.robot import free_place_m, robot_space, study_robot
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.tables import read_columns

FloatArray = npt.NDArray[np.float64]

TURN_RAD = math.radians(30.0)
"""Turn on the spot from one reading to the next [rad]."""
_AROUND_M = 1.0
_LEAST_PIECE_M = 0.05
_MOST_PIECES = 10_000


def poses_of_file(path: Path) -> FloatArray:
    """Return the poses of a CSV file, (m, 3) [m], [rad].

    Parameters
    ----------
    path : With the columns x_m, y_m and heading_deg.
    """
    poses = read_columns(path, ["x_m", "y_m", "heading_deg"])
    poses[:, 2] = np.radians(poses[:, 2])
    return poses


def way_through_tags(setting: Setting, *, step_m: float) -> FloatArray:
    """Return poses on the shortest way under one tag after another, (m, 3) [m], [rad].

    From the mission's start, and to its tags where the study has a mission; else to all tags.

    Parameters
    ----------
    setting : The room and its tags.
    step_m : Way between readings [m].
    """
    mission = setting.study.mission
    ids = [tag.id for tag in setting.tags] if mission is None else mission.tags
    if not ids:
        msg = "the study has no [[tag]], so that there is no way through them; add tags."
        raise ConfigError(msg)
    points = np.array([setting.tag(tag_id).point_m for tag_id in ids])
    plan, space = _plan(setting, points)
    start, heading = points[0], 0.0
    if mission is not None:
        start, heading = np.array(mission.start_m), math.radians(mission.heading_deg)
    if not space(start[None])[0]:
        free = free_place_m(space, start)
        if free is None:
            msg = "the robot fits nowhere on the floor of the room; make robot.radius_m less."
            raise ConfigError(msg)
        start = np.array(free)
    corners = [start]
    for goal in range(len(points)):
        corners += list(_corners(plan, corners[-1], goal))
    return poses_along(corners, heading_rad=heading, step_m=step_m)


def way_over_floor(setting: Setting, *, spacing_m: float, step_m: float) -> FloatArray:
    """Return poses on lanes over all free floor that one can drive to, (m, 3) [m], [rad].

    Parameters
    ----------
    setting : The room.
    spacing_m : Distance of neighbouring lanes [m].
    step_m : Way between readings [m].
    """
    if not setting.has_room:
        msg = 'the study is in free space, which has no floor to cover; give "tags" or a file.'
        raise ConfigError(msg)
    low, high = setting.scene.bounds_m[:, :2]
    plan, space = _plan(setting, np.zeros((0, 2)))
    lanes = list(_lanes(low, high, space, spacing_m=spacing_m, step_m=step_m))
    if not lanes:
        msg = "the robot fits on no lane over the floor; make --spacing-m or robot.radius_m less."
        raise ConfigError(msg)
    starts = np.array([lane[0] for lane in lanes])
    plan, _ = _plan(setting, starts)
    corners = [lanes[0][0], lanes[0][1]]
    for number, lane in enumerate(lanes[1:], 1):
        if math.isfinite(plan.length_m(corners[-1], number)):
            corners += [*_corners(plan, corners[-1], number), lane[1]]
    return poses_along(corners, heading_rad=0.0, step_m=step_m)


def poses_along(
    corners_m: Sequence[FloatArray], *, heading_rad: float, step_m: float
) -> FloatArray:
    """Return poses along straight pieces, turning on the spot between them, (m, 3) [m], [rad].

    Parameters
    ----------
    corners_m : (2,) float64 each — Ends of the pieces, one after another [m].
    heading_rad : Heading at the first [rad].
    step_m : Way between poses [m], evened out over each piece.
    """
    poses = [np.array([*corners_m[0], heading_rad])]
    for corner in corners_m[1:]:
        away = corner - poses[-1][:2]
        length = math.hypot(*away)
        if length < _LEAST_PIECE_M:
            continue
        turn = float(wrap_angle(math.atan2(away[1], away[0]) - poses[-1][2]))
        turns = math.ceil(abs(turn) / TURN_RAD - 1e-9)
        before = poses[-1]
        poses += [before + np.array([0.0, 0.0, turn * k / turns]) for k in range(1, turns + 1)]
        steps = max(1, math.ceil(length / step_m - 1e-9))
        last = poses[-1]
        poses += [last + np.array([*(away * k / steps), 0.0]) for k in range(1, steps)]
        poses.append(np.array([*corner, last[2]]))
    found = np.array(poses)
    found[:, 2] = wrap_angle(found[:, 2])
    return found


def _plan(setting: Setting, goals_m: FloatArray) -> tuple[FloorPlan, RobotSpace]:
    robot = study_robot(setting.study, "mission")
    space = robot_space(
        setting.scene, setting.reader, radius_m=robot.radius_m, height_m=robot.height_m
    )
    if setting.has_room:
        low, high = setting.scene.bounds_m[:, :2]
    else:
        low, high = goals_m.min(axis=0) - _AROUND_M, goals_m.max(axis=0) + _AROUND_M
    goals = goals_m if len(goals_m) else 0.5 * (low + high)[None]
    return floor_plan(low, high, goals, blocked=occupancy(low, high, space)), space


def _corners(plan: FloorPlan, start_m: FloatArray, goal: int) -> Iterator[FloatArray]:
    """Yield the corners of the way from a place to a goal."""
    place = start_m
    for _ in range(_MOST_PIECES):
        after = plan.towards(place, goal)
        if math.dist(after, place) < 1e-6:
            return
        yield after
        place = after


def _lanes(
    low: FloatArray, high: FloatArray, space: RobotSpace, *, spacing_m: float, step_m: float
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield both ends of each free stretch of the lanes, to and fro along the longer side."""
    along = int(np.argmax(high - low))
    across = 1 - along
    count = max(1, math.floor((high[across] - low[across]) / spacing_m))
    first = 0.5 * (low[across] + high[across] - (count - 1) * spacing_m)
    line = np.arange(low[along], high[along], min(step_m, _LEAST_PIECE_M))
    for number in range(count):
        points = np.empty((len(line), 2))
        points[:, along], points[:, across] = line, first + number * spacing_m
        free = np.concatenate([[False], space(points), [False]])
        edges = np.flatnonzero(np.diff(free.astype(np.int8)))
        stretches = [(points[a], points[b - 1]) for a, b in edges.reshape(-1, 2) if b - a > 1]
        yield from (
            stretches if number % 2 == 0 else [(end, start) for start, end in stretches[::-1]]
        )
