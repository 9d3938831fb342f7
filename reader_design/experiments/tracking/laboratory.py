"""The experiments of thesis 7.6, and sliding mode (7.6.5): the chapter ``laboratory``."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np

from octant.navigation.estimators.pose_filters import DeadReckoning, PoseEstimator
from octant.navigation.sensing.rss_models import RssNoise
from octant.navigation.tracking import shapes
from octant.navigation.tracking.controllers import TrackingController
from octant.navigation.tracking.sliding_mode import SlidingModeControl
from octant.navigation.tracking.trajectories import Curve
from octant.reader_design.experiments.tracking.chapters import (
    EKF,
    LABORATORY_TAGS_M,
    PUBLISHED_FIT,
    Start,
    driven,
    neighbouring_setup,
    thesis_filter,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    middle_and_90,
    outcomes_of,
    rows_of,
)
from octant.reader_design.experiments.tracking.settings import Settings, with_robot
from octant.reader_design.experiments.tracking.task_figure import tracking_figure
from octant.reader_design.showing.style import NamedFigure
from octant.reader_design.study_file.robot import Robot

WITHOUT, SLIDING = "neighbouring, no RSS", "sliding mode + EKF"
COLUMNS = (
    "experiment",
    "robot",
    "method",
    "runs",
    "average_m_median",
    "average_m_90",
    "first_leg_m_median",
    "last_leg_m_median",
    "final_m_median",
    "final_m_90",
    "final_heading_deg_median",
    "published",
)
"""Columns of laboratory.csv [m], [deg]; the legs are those of the U-shape."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """One of the thesis' experiments.

    Parameters
    ----------
    robot : Preset of the table ``[robot]``.
    curve, start : The way, and where the robot starts: x [m], y [m], heading [rad].
    tags_m : Its tags, heights as printed [m].
    holds : Whether it is a point that is held.
    published : What the thesis reports.
    legs_s : End of the first leg and begin of the last one [s]; None: one leg.
    """

    robot: str
    curve: Curve
    start: Start
    tags_m: tuple[tuple[float, float, float], ...]
    published: str
    holds: bool = False
    legs_s: tuple[float, float] | None = None


U_LEGS_M = (7.5, 4.0, 5.0)
U_TAGS_M = ((1.7, 5.0, 0.7), (-1.5, 4.9, 0.7), (-1.5, 2.1, 0.7), (1.0, 2.6, 0.7))
U_DURATION_S = 60.0
"""The thesis prints no duration of 7.6.2; with this the robot drives 0.27 m/s."""
_WHOLE_M = sum(U_LEGS_M)

EXPERIMENTS = {
    "line (7.6.1)": Experiment(
        robot="scout",
        curve=shapes.line((1.0, 0.0), (1.0, 3.0), duration_s=30.0),
        start=(1.0, 0.0, 0.5 * math.pi),
        tags_m=LABORATORY_TAGS_M,
        published="final 0.13 m; without RSS it leaves the line",
    ),
    "u-shape (7.6.2)": Experiment(
        robot="sputnik",
        curve=shapes.placed(
            shapes.u_shape(U_LEGS_M, duration_s=U_DURATION_S), (0.0, 0.0), 0.5 * math.pi
        ),
        start=(0.0, 0.0, 0.5 * math.pi),
        tags_m=U_TAGS_M,
        published="first leg 0.10 m, last leg 0.08 m, final 0.5 m",
        legs_s=(
            U_DURATION_S * U_LEGS_M[0] / _WHOLE_M,
            U_DURATION_S * (U_LEGS_M[0] + U_LEGS_M[1]) / _WHOLE_M,
        ),
    ),
    "point (7.6.3)": Experiment(
        robot="scout",
        curve=shapes.fixed_pose((2.0, 4.0, 0.5 * math.pi), duration_s=30.0),
        start=(0.0, 0.0, 0.5 * math.pi),
        tags_m=LABORATORY_TAGS_M,
        published="final 0.2 m and 20°",
        holds=True,
    ),
}
"""Where the U starts and to which side it turns is not printed: its first leg leads from the origin
along +y among its tags, and it turns to the left. The tags of 7.6.3 are taken to be those of 7.6.1,
in the same laboratory."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each experiment with each method.

    Parameters
    ----------
    settings : The study.
    """
    del settings
    return [
        Part(chapter="laboratory", task=name, method=method)
        for name, one in EXPERIMENTS.items()
        for method in (EKF, WITHOUT, SLIDING)
        if not (one.holds and method == SLIDING)
    ]


def in_the_laboratory(settings: Settings, one: Experiment) -> Settings:
    """Return the settings of an experiment: its robot, its tags, and noise as of Table 6.1.

    Parameters
    ----------
    settings, one : The study, whose ``[[tag]]`` and samples count where it has any; and which.
    """
    given, scale = settings.given_tags_m, settings.track.laboratory_wheel_scale
    table = msgspec.convert({"preset": one.robot, "wheel_scale": scale}, Robot)
    return replace(
        with_robot(settings, table),
        law=PUBLISHED_FIT if settings.samples is None else settings.law,
        noise=RssNoise(mean_db=0.0, sigma_db=settings.track.laboratory_rss_sigma_db),
        given_tags_m=np.array(one.tags_m) if given is None else given,
    )


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return an experiment driven many times by one method.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    one = EXPERIMENTS[part.task]
    there = in_the_laboratory(settings, one)
    weights = settings.stabilisation if one.holds else None
    setup = neighbouring_setup(there, one.curve, one.start, weights=weights)
    controller: TrackingController = setup.control
    estimator: PoseEstimator[Any] = thesis_filter(there)
    if part.method == WITHOUT:
        estimator = DeadReckoning(motion=there.motion)
    elif part.method == SLIDING:
        controller = SlidingModeControl(desired=setup.desired, robot=there.robot)
    outcome = driven(
        there,
        setup,
        part.method,
        controller,
        estimator,
        chapter="laboratory",
        task=part.task,
    )
    found, time = outcome.measures(), setup.desired.time_s
    legs: tuple[float | None, float | None] = (None, None)
    if one.legs_s is not None:
        errors = outcome.runs.errors_m
        first, last = time < one.legs_s[0], time > one.legs_s[1]
        legs = tuple(float(np.median(errors[:, leg].mean(axis=1))) for leg in (first, last))  # type: ignore[assignment]
    row = (
        part.task,
        one.robot,
        part.method,
        len(found["average_m"]),
        *middle_and_90(found["average_m"]),
        *legs,
        *middle_and_90(found["final_m"]),
        float(np.median(found["final_heading_deg"])),
        one.published if part.method == EKF else None,
    )
    return PartRecord(outcomes=(outcome,), rows=(row,))


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    track, rows = settings.track, rows_of(records)
    ours, theirs = (
        [float(r[4] or 0.0) for r in rows if r[2] == m and str(r[0])[:5] != "point"]
        for m in (EKF, SLIDING)
    )
    return (
        (
            "The laboratories' noise is not printed. Here tags send as in Table 6.1 (or in the "
            f"study's samples), readings scatter by {track.laboratory_rss_sigma_db:g} dB as that "
            "table does about its fit, and each wheel rolls all the time by "
            f"{100.0 * track.laboratory_wheel_scale:g} % (one sigma) more or less than the robot "
            "believes. With four tags so close to the floor the law (6.2) is used below the "
            "distances of its calibration."
        ),
        (
            f"Sliding mode (7.6.5) with the same filter averages {np.mean(theirs):.2f} m where the "
            f"neighbouring control has {np.mean(ours):.2f} m; the thesis reports about 0.25 m for "
            "both, and that sliding mode needs reference velocities and does not hold a point."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    caption = f"The experiments of 7.6, driven {settings.track.runs} times each."
    return (
        ChapterTable(file="laboratory.csv", caption=caption, header=COLUMNS, rows=rows_of(records)),
    )


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield the panels of each experiment [m], [s].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    numbers = dict(zip(EXPERIMENTS, ("7.9, 7.10", "7.13", "7.14"), strict=True))
    for name, one in EXPERIMENTS.items():
        shown = [o for o in outcomes_of(records) if o.task == name]
        tags = np.array(one.tags_m) if settings.given_tags_m is None else settings.given_tags_m
        yield NamedFigure(
            file=f"laboratory_{name.split(' ')[0]}.png",
            section="laboratory",
            title=f"{name} (thesis Figs. {numbers[name]})",
            caption="With the readings of four tags, without them, and by sliding mode.",
            figure=tracking_figure(shown, title=f"Experiment: {name}", tags_m=tags),
        )


CHAPTER = FurtherChapter(
    heading="The experiments of 7.6, and sliding mode (7.6.5)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
