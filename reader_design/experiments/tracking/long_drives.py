"""Whether the error grows with the way, thesis 6.5.4 and 7.5.3: the chapter ``long``."""

from collections.abc import Iterator
from itertools import count

import numpy as np

from octant.navigation.estimators.pose_filters import DeadReckoning
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import run_seeds
from octant.navigation.tracking.measurement_feedback import FeedbackTraining, replay_and_fresh_m
from octant.navigation.tracking.trajectories import Curve
from octant.reader_design.experiments.tracking.chapters import (
    EKF,
    FRESH,
    REPLAY,
    Start,
    driven,
    feedback_outcome,
    feedback_task,
    neighbouring_setup,
    thesis_filter,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FloatArray,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    Row,
    middle_and_90,
    rows_of,
)
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.settings import OwnTask, Settings
from octant.reader_design.experiments.tracking.task_figure import COLOURS
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

DEAD = "neighbouring, dead reckoning"
FEEDBACK = "measurement feedback"
FEEDBACK_LAPS = 3
"""Most laps of chapter 6's feedback: the iterations that its training needs grow with the laps, and
with ten the robot is still a metre off after forty thousand."""
LAP_COLUMNS = ("trajectory", "method", "lap", "driven_m", "average_m_median", "average_m_90")
TREND_COLUMNS = (
    "trajectory",
    "method",
    "laps",
    "driven_m",
    "growth_mm_per_100_m",
    "standard_error_mm_per_100_m",
    "last_lap_over_second",
)
"""Columns of long.csv and of long_trends.csv [m]; without the first lap, which holds the start."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each closed trajectory with each method.

    Parameters
    ----------
    settings : The study.
    """
    return [
        Part(chapter="long", task=name, method=method)
        for name in _closed(settings)
        for method in (EKF, DEAD, FEEDBACK)
    ]


def _closed(settings: Settings) -> dict[str, OwnTask]:
    """Return the lemniscate and the study's own trajectories that end as they begin."""
    found = {}
    for name, task in settings.tasks.items():
        place, velocity, _ = task.curve.motion(np.array([0.0, task.curve.duration_s]))
        if velocity.any() and np.allclose([place[0], velocity[0]], [place[1], velocity[1]]):
            found[name] = task
    return found


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return a trajectory driven many times over.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    one = _closed(settings)[part.task]
    curve, start = one.curve, one.start
    laps = _laps(settings, part)
    whole = shapes.repeated(curve, laps)
    task = f"{part.task}, {laps} laps"
    if part.method == FEEDBACK:
        outcomes = _feedback(settings, whole, start, task, curve.duration_s)
    else:
        setup = neighbouring_setup(settings, whole, start, weights=one.weights)
        estimator = (
            thesis_filter(settings) if part.method == EKF else DeadReckoning(motion=settings.motion)
        )
        outcomes = (
            driven(
                settings, setup, part.method, setup.control, estimator, chapter="long", task=task
            ),
        )
    rows = []
    for outcome in outcomes:
        length_m = outcome.runs.desired.length_m / laps
        for lap, errors in enumerate(_lap_errors_m(outcome, laps).T, start=1):
            rows.append((part.task, outcome.method, lap, lap * length_m, *middle_and_90(errors)))
    return PartRecord(outcomes=outcomes, rows=tuple(rows))


def _feedback(
    settings: Settings, curve: Curve, start: Start, task: str, lap_s: float
) -> tuple[Outcome, ...]:
    """Return one run of chapter 6's feedback, its noise replayed and fresh."""
    work = feedback_task(settings, curve, start)
    laps = round(curve.duration_s / lap_s)
    training = FeedbackTraining(iterations=laps * settings.track.training_iterations)
    seed = run_seeds(settings.study.seed, 1)[0]
    _, *both = replay_and_fresh_m(
        work, settings.noise, training, seed, settings.hearing(work.tags_m)
    )
    return tuple(
        feedback_outcome(work, f"{FEEDBACK}, {method}", [one], chapter="long", task=task)
        for method, one in zip((REPLAY, FRESH), both, strict=True)
    )


def _laps(settings: Settings, part: Part) -> int:
    laps = settings.track.long_laps
    return min(laps, FEEDBACK_LAPS) if part.method == FEEDBACK else laps


def _lap_errors_m(outcome: Outcome, laps: int) -> FloatArray:
    """Return the average error of every run in every lap, (r, laps) [m]."""
    errors = outcome.runs.errors_m[:, :-1]
    averages: FloatArray = errors.reshape(len(errors), laps, -1).mean(axis=2)
    return averages


def trend(errors_m: FloatArray, lap_m: float) -> tuple[float, float]:
    """Return by how much the error of a lap grows on 100 m, and its standard error [mm].

    A line is fitted to the laps after the first by least squares, run by run; the standard error
    comes from the spread of the runs, and of one run from that of its laps about the line; NaN of
    one run with fewer than three such laps.

    Parameters
    ----------
    errors_m : (r, laps) float64 — Average error of every run in every lap [m].
    lap_m : Length of a lap [m].
    """
    later = errors_m[:, 1:]
    way = lap_m * np.arange(later.shape[1]) / 100.0
    way -= way.mean()
    square = float(np.sum(way**2))
    slopes = 1000.0 * later @ way / max(square, 1e-300)
    if len(later) > 1:
        return float(slopes.mean()), float(slopes.std(ddof=1) / np.sqrt(len(slopes)))
    if len(way) < 3:
        return float(slopes[0]), float("nan")
    left = later[0] - later[0].mean() - slopes[0] / 1000.0 * way
    freedom = len(way) - 2
    return float(slopes[0]), 1000.0 * float(
        np.sqrt(np.sum(left**2) / freedom / max(square, 1e-300))
    )


def trend_rows(settings: Settings, records: Records) -> tuple[Row, ...]:
    """Return the rows of long_trends.csv, as `TREND_COLUMNS` [m].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    rows: list[Row] = []
    for part, one in records:
        laps = _laps(settings, part)
        for outcome in one.outcomes:
            errors, length_m = _lap_errors_m(outcome, laps), outcome.runs.desired.length_m
            later = float(np.median(errors[:, -1]) / np.median(errors[:, 1]))
            growth, error = trend(errors, length_m / laps)
            grown = growth, None if np.isnan(error) else error
            rows.append((part.task, outcome.method, laps, length_m, *grown, later))
    return tuple(rows)


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    words = [
        f"{row[1]} on the {row[0]}: {float(row[4] or 0.0):+.2g}"
        + (" mm" if row[5] is None else f" ± {float(row[5]):.1g} mm")
        for row in trend_rows(settings, records)
    ]
    return (
        (
            "The thesis says that the error does not accumulate (6.5.4, 7.5.3). By how much the "
            f"error of a lap grows on 100 m after the first, with its standard error: "
            f"{'; '.join(words)}. The readings of the tags hold the neighbouring control on its "
            "way; without them the error grows. The feedback of chapter 6 is "
            "held only against the noise of its training: with fresh noise nothing tells it how "
            "far it has come off."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the tables of laps and of trends.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    return (
        ChapterTable(
            file="long_trends.csv",
            caption="How the error of a lap grows with the way.",
            header=TREND_COLUMNS,
            rows=trend_rows(settings, records),
        ),
        ChapterTable(
            file="long.csv",
            caption="Average error of each lap, median and 90 % over the runs.",
            header=LAP_COLUMNS,
            rows=rows_of(records),
        ),
    )


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield the error of each lap against the way [m].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings
    names = tuple(dict.fromkeys(part.task for part, _ in records))
    for number, name in zip(count(1), names, strict=False):
        rows = rows_of(records, name)
        with figure_style():
            figure, axes = new_figure(
                width_in=7.4, height_in=4.2, title=f"Error of each lap: {name}"
            )
            ax = axes[0, 0]
            methods = tuple(dict.fromkeys(str(row[1]) for row in rows))
            for method, colour in zip(methods, COLOURS, strict=False):
                some = np.array([row[3:6] for row in rows if row[1] == method], float)
                ax.semilogy(some[:, 0], some[:, 1], "o-", color=colour, label=method, markersize=4)
                ax.semilogy(some[:, 0], some[:, 2], "_", color=colour)
            ax.set_title("average error of a lap: median (dots), 90 % (dashes)")
            ax.set_xlabel("way driven [m]")
            ax.set_ylabel("average error of the lap [m]")
            figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        yield NamedFigure(
            file=f"long_{number}.png",
            section="long",
            title=f"The error of a long drive: {name} (thesis 6.5.4)",
            caption="The error of each lap, by what the robot knows of its place.",
            figure=figure,
        )


CHAPTER = FurtherChapter(
    heading="Long drives (6.5.4, 7.5.3)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
