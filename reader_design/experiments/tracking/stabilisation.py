"""Chapter 6's feedback holds a point, thesis 6.5.5: the chapter ``stabilisation``."""

from collections.abc import Iterator

import numpy as np

from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import run_seeds
from octant.navigation.tracking.measurement_feedback import FeedbackTraining, replay_and_fresh_m
from octant.navigation.tracking.nominal import BoundedIlqr
from octant.navigation.tracking.problem import Weights
from octant.navigation.tracking.trajectories import Curve
from octant.reader_design.experiments.tracking.chapters import (
    FRESH,
    ILQR,
    REPLAY,
    Start,
    feedback_outcome,
    feedback_task,
    without_estimates,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    Row,
    middle_and_90,
    outcomes_of,
    rows_of,
)
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.settings import POINT_GOAL, POINT_START, Settings
from octant.reader_design.experiments.tracking.task_figure import tracking_figure
from octant.reader_design.showing.style import NamedFigure

COLUMNS = (
    "point",
    "method",
    "runs",
    "final_m_median",
    "final_m_90",
    "final_heading_deg_median",
    "final_heading_deg_90",
    "cost_median",
    "lowest_cost",
)
"""Columns of stabilisation.csv [m], [deg]; lowest_cost is that of the nominal inputs, for which the
whole state is known."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each point.

    Parameters
    ----------
    settings : The study.
    """
    return [Part(chapter="stabilisation", task=name) for name in _points(settings)]


def _points(settings: Settings) -> dict[str, tuple[Curve, Start, Weights]]:
    """Return the point of thesis 7.5.2.1 and the study's own, with weights."""
    thesis = shapes.fixed_pose(POINT_GOAL), POINT_START, settings.stabilisation
    own = {
        one.curve.name: (one.curve, one.start, one.weights or settings.stabilisation)
        for one in settings.own
        if not one.curve.motion(np.zeros(1))[1].any() and one.curve.name != "point"
    }
    return {"point": thesis, **own}


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return the feedback trained to hold a point: its noise replayed, and fresh noise.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    curve, start, weights = _points(settings)[part.task]
    work = feedback_task(settings, curve, start, weights=weights)
    training = FeedbackTraining(iterations=settings.track.training_iterations)
    hearing = settings.hearing(work.tags_m)
    pairs = [
        replay_and_fresh_m(work, settings.noise, training, seed, hearing)[1:]
        for seed in run_seeds(settings.study.seed, settings.track.runs)
    ]
    best = BoundedIlqr().solve(work.problem)
    outcomes: list[Outcome] = []
    rows: list[Row] = []
    for number, method in enumerate((REPLAY, FRESH)):
        runs = [pair[number] for pair in pairs]
        outcome = feedback_outcome(work, method, runs, chapter="stabilisation", task=part.task)
        outcomes.append(outcome)
        costs = float(np.median([run.cost for run in runs]))
        rows.append((part.task, method, len(runs), *_finals(outcome), costs, best.cost))
    record = without_estimates(work.problem.desired, [best.poses], best.wheel_rates[None])
    nominal = Outcome(chapter="stabilisation", task=part.task, method=ILQR, runs=record)
    rows.append((part.task, ILQR, 1, *_finals(nominal), best.cost, best.cost))
    return PartRecord(outcomes=(*outcomes, nominal), rows=tuple(rows))


def _finals(outcome: Outcome) -> tuple[float, ...]:
    found = outcome.measures()
    return (*middle_and_90(found["final_m"]), *middle_and_90(found["final_heading_deg"]))


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings, records
    return (
        (
            "The thesis says that the feedback of chapter 6 holds a point once the final weight is "
            "larger than the running one (6.5.5), and shows no run. With the weights of 7.5.2.1 it "
            "does, to centimetres, against the noise that it was trained with; fresh noise moves "
            "it off by decimetres. No feedback can cost less than the nominal inputs, which know "
            "the whole state."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    caption = f"Errors at the end, median and 90 % over {settings.track.runs} runs, and cost J."
    return (
        ChapterTable(
            file="stabilisation.csv", caption=caption, header=COLUMNS, rows=rows_of(records)
        ),
    )


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield the panels of each point [m], [s].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    for number, name in enumerate(dict.fromkeys(part.task for part, _ in records), start=1):
        shown = [o for o in outcomes_of(records) if o.task == name]
        yield NamedFigure(
            file=f"stabilisation_{number}.png",
            section="stabilisation",
            title=f"Measurement feedback holds a point: {name} (thesis 6.5.5)",
            caption="The feedback reaches the point with its heading; the noise decides how near.",
            figure=tracking_figure(
                shown,
                title=f"Measurement feedback: {name}",
                tags_m=settings.feedback_tags_m,
            ),
        )


CHAPTER = FurtherChapter(
    heading="Measurement feedback at a point (6.5.5)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
