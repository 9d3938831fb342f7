"""Docking missions as logs that drives' files are written from."""

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from octant.navigation.control.polar import pose_from_goal_frame, pose_of_polar
from octant.navigation.docking.task import DockingResult
from octant.reader_design.drives.log import DriveLog, Surroundings
from octant.reader_design.drives.surroundings import carrier, surroundings
from octant.reader_design.experiments.docking.compute import DockingContent
from octant.reader_design.setting.robot import study_robot
from octant.reader_design.setting.setting import Setting


def docking_log(
    setting: Setting, result: DockingResult, *, run: int, around: Surroundings | None = None
) -> DriveLog:
    """Return a docking mission; the robot believes a pose only where its filter sees the station.

    Parameters
    ----------
    setting, result, run : The room that it was driven in, with its reader; the run and its number.
    around : What stands there, where it is known already.
    """
    task, robot = result.task, study_robot(setting.study, "dock")
    # A row stands for the period that begins then; of two at one time the later one counts.
    last = np.flatnonzero(np.append(np.diff(result.time_s) > 0.0, True))
    rss_w = result.rss_w
    if rss_w is not None and rss_w.shape[1] == 0:
        rss_w = None
    staging = task.landmark.goal(task.staging_m)
    return DriveLog(
        name=f"{setting.name}, run {run}",
        time_s=result.time_s[last],
        poses=result.poses[last],
        carrier=carrier(setting, robot),
        floor_m=setting.scene.floor_height_m,
        belief=pose_from_goal_frame(pose_of_polar(result.polar[last]), task.goal),
        odometry=None if result.odometry is None else result.odometry[last],
        origin=result.poses[0],
        commands=result.twist[last],
        rss_w=None if rss_w is None else rss_w[last],
        targets=(task.tag_id,) * len(last),
        states=tuple(result.phases[k] for k in last),
        wanted=np.array([result.poses[0], staging, task.goal]),
        tags_m={tag.id: tag.position_m for tag in setting.tags},
        around=surroundings(setting, robot) if around is None else around,
        facts={"outcome": result.outcome, "reason": result.reason},
    )


def docking_logs(
    content: DockingContent, numbers: Iterable[int]
) -> dict[str, Callable[[], DriveLog]]:
    """Return what makes the logs of some runs in every room, by the names of their files.

    Parameters
    ----------
    content, numbers : What was computed; which runs.
    """
    rooms = list(content.rooms.values())
    responses = rooms[0][0].responses
    return {
        f"{room.name} run {number}": partial(
            docking_log, room.with_responses(responses), runs[number], run=number
        )
        for room, runs in rooms
        for number in numbers
    }
