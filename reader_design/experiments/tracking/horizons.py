"""A receding horizon beside the neighbouring control, thesis 7.5.4: the chapter ``horizon``."""

from collections.abc import Iterator

import numpy as np

from octant.navigation.tracking import shapes
from octant.navigation.tracking.controllers import PredictiveControl, TrackingController
from octant.reader_design.experiments.tracking.chapters import (
    EKF,
    driven,
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
    middle_and_90,
    outcomes_of,
    rows_of,
)
from octant.reader_design.experiments.tracking.settings import OwnTask, Settings
from octant.reader_design.experiments.tracking.task_figure import COLOURS
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

CIRCLE_OFFSET_M = 0.5
"""How far outside the circle the robot starts, along its direction; the thesis has no run [m]."""
CONVERGED_M = 0.1
"""Distance within which the robot has converged: the thesis' average error of 7.5.2.2 [m]."""
COLUMNS = (
    "trajectory",
    "method",
    "horizon_s",
    "runs",
    "average_m_median",
    "average_m_90",
    "converged_s_median",
    "converged_s_90",
)
"""Columns of horizon.csv [m], [s]; the time until the robot is first within `CONVERGED_M`."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each trajectory with each horizon, and with the neighbouring control.

    Parameters
    ----------
    settings : The study.
    """
    return [
        Part(chapter="horizon", task=name, run=horizon)
        for name in _tasks(settings)
        for horizon in (0, *settings.track.horizons)
    ]


def _tasks(settings: Settings) -> dict[str, OwnTask]:
    """Return the circle, the lemniscate and the study's own trajectories."""
    track, radius_m = settings.track, settings.track.circle_radius_m
    circle = shapes.ellipse(half_axes_m=(radius_m, radius_m), duration_s=track.circle_duration_s)
    start = (radius_m + CIRCLE_OFFSET_M, 0.0, 0.5 * np.pi)
    return {"circle": OwnTask(curve=circle, start=start)} | settings.tasks


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return a trajectory driven with one horizon, or by the neighbouring control (run 0).

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    task = _tasks(settings)[part.task]
    setup = neighbouring_setup(settings, task.curve, task.start, weights=task.weights)
    controller: TrackingController = setup.control
    method, horizon_s = EKF, None
    if part.run:
        horizon_s = part.run * settings.track.period_s
        method = f"receding horizon of {horizon_s:.3g} s + EKF"
        controller = PredictiveControl(
            desired=setup.desired,
            robot=settings.robot,
            weights=setup.weights,
            horizon=part.run,
            iterations=settings.track.horizon_iterations,
        )
    outcome = driven(
        settings,
        setup,
        method,
        controller,
        thesis_filter(settings),
        chapter="horizon",
        task=part.task,
    )
    average = outcome.measures()["average_m"]
    times = converged_s(outcome.runs.errors_m, settings.track.period_s)
    row = (
        part.task,
        method,
        horizon_s,
        len(average),
        *middle_and_90(average),
        *middle_and_90(times),
    )
    return PartRecord(outcomes=(outcome,), rows=(row,))


def converged_s(errors_m: FloatArray, period_s: float) -> FloatArray:
    """Return when each run is first within `CONVERGED_M`, (r,) [s]; its whole time if it never is.

    Parameters
    ----------
    errors_m : (r, k) float64 — Distances to the desired place in every period [m].
    period_s : Sample period [s].
    """
    within = errors_m <= CONVERGED_M
    first = np.where(within.any(axis=1), within.argmax(axis=1), errors_m.shape[1] - 1)
    times: FloatArray = period_s * first.astype(np.float64)
    return times


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings
    words = []
    for task in dict.fromkeys(part.task for part, _ in records):
        rows = rows_of(records, task)
        ours, others = rows[0], rows[1:]
        quicker = sum(float(row[6] or 0.0) < float(ours[6] or 0.0) for row in others)
        words.append(
            f"on the {task} it converges in {ours[6]:.2g} s, and {quicker} of {len(others)} "
            "horizons do so sooner"
        )
    return (
        (
            "Thesis 7.5.4 compares with published results of a receding horizon in words: that the "
            "neighbouring control converges faster, and has no horizon to choose. Driven here with "
            f"the same filter, robot and noise: {'; '.join(words)}."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings
    caption = f"Average error, and time until the robot is first within {CONVERGED_M:g} m."
    return (
        ChapterTable(file="horizon.csv", caption=caption, header=COLUMNS, rows=rows_of(records)),
    )


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield paths and errors by horizon [m], [s].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings
    outcomes = outcomes_of(records)
    names = tuple(dict.fromkeys(o.task for o in outcomes))
    with figure_style():
        figure, axes = new_figure(
            width_in=10.4,
            height_in=3.7 * len(names),
            title="Receding horizon and neighbouring control",
            rows=len(names),
            columns=2,
        )
        for (plan, error), name in zip(axes, names, strict=True):
            some = [o for o in outcomes if o.task == name]
            desired = some[0].runs.desired
            plan.plot(*desired.poses[:, :2].T, color="#999999", linewidth=4, alpha=0.5)
            for outcome, colour in zip(some, COLOURS, strict=False):
                plan.plot(*outcome.runs.poses[0, :, :2].T, color=colour, linewidth=1.0)
                middle = np.median(outcome.runs.errors_m, axis=0)
                error.semilogy(desired.time_s, middle, color=colour, label=outcome.method, lw=1.0)
            plan.set_aspect("equal", adjustable="datalim")
            plan.set_title(f"{name} (grey: desired), run 0")
            plan.set_xlabel("x [m]")
            plan.set_ylabel("y [m]")
            error.set_title("error: median over the runs")
            error.set_xlabel("time [s]")
            error.set_ylabel("distance to the desired place [m]")
        figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    yield NamedFigure(
        file="horizon.png",
        section="horizon",
        title="Receding horizon (thesis 7.5.4)",
        caption="Each horizon and the neighbouring control, with the same filter and noise.",
        figure=figure,
    )


CHAPTER = FurtherChapter(
    heading="Receding horizon (7.5.4)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
