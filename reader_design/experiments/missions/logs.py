"""Runs of a mission as logs that drives' files are written from."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np

from octant.navigation.control.polar import pose_in_goal_frame
from octant.navigation.missions.records import MissionResult
from octant.reader_design.drives.log import DriveLog, Surroundings
from octant.reader_design.drives.surroundings import carrier, surroundings
from octant.reader_design.experiments.missions.compute import MissionRuns
from octant.reader_design.setting.robot import study_robot
from octant.reader_design.setting.setting import Setting


def mission_log(
    setting: Setting, result: MissionResult, *, run: int, around: Surroundings | None = None
) -> DriveLog:
    """Return a run of a mission; the belief is the navigator's, or else that of the wheels.

    Parameters
    ----------
    setting, result, run : The room that it was driven in, with its reader; the run and its number.
    around : What stands there, where it is known already.
    """
    mission, robot = result.mission, study_robot(setting.study, "mission")
    origin = np.array([*mission.start_m, mission.heading_rad])
    belief = result.reckoned
    if belief is not None and result.believed_poses is not None:
        believed = result.believed_poses
        belief = believed if np.isfinite(believed).any() else belief
    way = mission.waypoints_m
    legs = np.diff(way, axis=0)
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    return DriveLog(
        name=f"{setting.study.name}, run {run}",
        time_s=result.time_s,
        poses=result.poses,
        carrier=carrier(setting, robot),
        floor_m=setting.scene.floor_height_m,
        belief=belief,
        odometry=(None if result.reckoned is None else pose_in_goal_frame(result.reckoned, origin)),
        origin=origin,
        commands=result.commands,
        rss_w=result.rss_w,
        targets=tuple(mission.tag_ids[k] for k in result.targets),
        states=result.modes,
        wanted=np.column_stack([way, [*headings, headings[-1]]]),
        tags_m={tag.id: tag.position_m for tag in setting.tags},
        believed_tag_m=result.believed_points_m,
        around=surroundings(setting, robot) if around is None else around,
        facts={"outcome": result.outcome, "reason": result.reason},
    )


def mission_logs(
    driven: Sequence[MissionRuns], results: Sequence[MissionResult], numbers: Iterable[int]
) -> dict[str, Callable[[], DriveLog]]:
    """Return what makes the logs of some runs, by the names of their files.

    Parameters
    ----------
    driven, results, numbers : Who drove, and in which room; all runs; which are wanted.
    """
    settings = [one.setting for one in driven for _ in range(one.runs)]
    # Placements share one reader, which the first of them has solved.
    responses = driven[0].setting.responses
    return {
        f"run {number}": partial(
            mission_log,
            settings[number].with_responses(responses),
            results[number],
            run=number,
        )
        for number in numbers
    }
