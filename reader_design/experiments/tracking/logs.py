"""Tracked trajectories as logs that drives' files are written from."""

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np
import numpy.typing as npt

from octant.navigation.robot.motion import move
from octant.reader_design.drives.log import Carrier, DriveLog
from octant.reader_design.experiments.tracking.compute import TrackingContent
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.settings import Settings
from octant.reader_design.setting.robot import study_robot

FloatArray = npt.NDArray[np.float64]

_MESHED = ("nominal", "neighbouring")


def tracking_log(settings: Settings, outcome: Outcome, *, run: int) -> DriveLog:
    """Return one run of a method in a task; its belief is the estimate.

    Its odometry is that of wheels which turn as commanded; what disturbs them is in the true poses.
    The chapters' robots have no bearing-sensitive reader, and their readings are not kept.

    Parameters
    ----------
    settings, outcome, run : The study, the method's runs, and the number of one.
    """
    runs, body = outcome.runs, study_robot(settings.study, "track")
    feedback = outcome.chapter == "feedback"
    robot = settings.feedback_robot if feedback else settings.robot
    commands = np.vstack([robot.twist(runs.wheel_rates[run]), np.zeros(2)])
    return DriveLog(
        name=f"{outcome.chapter}, {outcome.task}, {outcome.method}, run {run}",
        time_s=runs.desired.time_s,
        poses=runs.poses[run],
        carrier=Carrier(radius_m=body.radius_m, height_m=body.height_m),
        belief=runs.estimates[run],
        odometry=_reckoned(commands, runs.desired.time_s),
        origin=runs.poses[run][0],
        commands=commands,
        wanted=runs.desired.poses,
        tags_m=_tags_m(settings, outcome.chapter),
        facts={
            "chapter": outcome.chapter,
            "task": outcome.task,
            "method": outcome.method,
            "tag_heights": "above the robot's antenna",
        },
    )


def _reckoned(commands: FloatArray, time_s: FloatArray) -> FloatArray:
    """Return the pose since the start by speed and turn rate, (s, 2) [m/s], [rad/s], alone."""
    period_s = np.diff(time_s)
    turn = commands[:-1, 1] * period_s
    heading = np.concatenate(([0.0], np.cumsum(turn)))
    start = np.column_stack((np.zeros((len(turn), 2)), heading[:-1]))
    steps = move(start, distance_m=commands[:-1, 0] * period_s, turn_rad=turn)
    places = np.vstack((np.zeros(2), np.cumsum(steps[:, :2], axis=0)))
    return np.column_stack((places, heading))


def tracking_logs(
    content: TrackingContent, numbers: Iterable[int]
) -> dict[str, Callable[[], DriveLog]]:
    """Return what makes the logs of some runs of every method, by the names of their files.

    Parameters
    ----------
    content, numbers : What was computed; which runs; methods that were run less often have fewer.
    """
    return {
        f"{one.chapter} {one.task} {one.method} run {number}": partial(
            tracking_log, content.settings, one, run=number
        )
        for one in content.outcomes
        for number in numbers
        if number < len(one.runs.poses)
    }


def _tags_m(settings: Settings, chapter: str) -> dict[str, FloatArray]:
    """Return the tags of a chapter; those of chapters that place their own are left out."""
    if settings.given_tags_m is not None:
        names = [tag.id for tag in settings.study.tags]
        return dict(zip(names, settings.given_tags_m, strict=True))
    if chapter == "feedback":
        places = settings.feedback_tags_m
    elif chapter in _MESHED:
        places = settings.mesh.tags_m
    else:
        return {}
    return {f"tag {i}": place for i, place in enumerate(places, start=1)}
