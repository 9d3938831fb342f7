"""The search: the study's reader, a survey, then the refinement of the best design found.

Everything follows from the seed and the scores alone, so the same search over kept evaluations
takes the same steps to the same end.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, SweepStateError
from octant.reader_design.experiments.optimise.evaluation import Evaluation, Slopes
from octant.reader_design.experiments.optimise.goals import Targets
from octant.reader_design.experiments.optimise.gradient import Limits, ascend
from octant.reader_design.experiments.optimise.space import Box, boxes, survey_designs
from octant.reader_design.study_file.optimise import Optimise
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]
Objective = Callable[[FloatArray], float]

FIRST_STEP = 0.15
"""First step of the refinement, as a share of each parameter's bounds [-]."""
LAST_STEP = 0.01
"""Step below which the refinement ends [-]."""
INFEASIBLE = 30.0
"""What an infeasible design counts in the refinement [-]: worse than any goal missed by 30 dB."""
PATIENCE = 40
"""Steps in a row to designs that are known already after which the refinement ends [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One design that the search tried.

    Attributes
    ----------
    number : From 0, in the order of the search.
    stage : ``reader``, ``survey`` or ``refinement``.
    evaluation : What became of it.
    attainment : How well it reaches the goals [-]; minus infinity when it is infeasible.
    """

    number: int
    stage: str
    evaluation: Evaluation
    attainment: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """A finished search.

    Attributes
    ----------
    trials : In their order; the first is the study's ``[reader]``.
    targets : The goals that it was judged by.
    """

    trials: tuple[Trial, ...]
    targets: Targets

    @property
    def reader(self) -> Trial:
        """The study's own ``[reader]``."""
        return self.trials[0]

    @property
    def winner(self) -> Trial:
        """The feasible design that reaches the goals best; the earlier of equals."""
        return max(self.trials, key=lambda trial: (trial.attainment, -trial.number))

    def best_of(self, stage: str) -> Trial | None:
        """Return the best feasible design of a stage; None where there is none.

        Parameters
        ----------
        stage : ``reader``, ``survey`` or ``refinement``.
        """
        found = [t for t in self.trials if t.stage == stage and t.evaluation.feasible]
        return max(found, key=lambda t: (t.attainment, -t.number)) if found else None


class _BudgetSpentError(Exception):
    """The refinement may evaluate no further design, or finds no new one."""


@dataclass(slots=True, kw_only=True)
class _Log:
    """What the search has tried so far; grows while it runs."""

    evaluate: Callable[[Reader], Evaluation]
    attainment: Callable[[Any], float]
    trials: list[Trial] = field(default_factory=list)
    by_design: dict[Reader, Trial] = field(default_factory=dict)

    def tried(self, design: Reader, stage: str) -> Trial:
        """Return the trial of a design, evaluated now unless it is known."""
        if design not in self.by_design:
            evaluation = self.evaluate(design)
            trial = Trial(
                number=len(self.trials),
                stage=stage,
                evaluation=evaluation,
                attainment=self.attainment(evaluation),
            )
            self.trials.append(trial)
            self.by_design[design] = trial
        return self.by_design[design]


def table_of(study: Study) -> Optimise:
    """Return the study's table ``[optimise]``; refuses a study without it.

    Parameters
    ----------
    study : The study.
    """
    if study.optimise is None:
        msg = (
            "the study has no table [optimise], but a search needs one; add it, with what is "
            "varied, such as parameters = {plate_height_m = [0.05, 0.10]}, and a goal: "
            '[[optimise.goal]] with score = "margin_db" and value = 2.6.'
        )
        raise ConfigError(msg)
    return study.optimise


def planned_evaluations(study: Study, table: Optimise) -> int:
    """Return how many designs a search evaluates at most: reader, survey, budgets of refinement.

    Parameters
    ----------
    study, table : The study and its search.
    """
    combinations = len(boxes(study, table))
    points = 1 + (table.survey if table.parameters.given() else 0)
    return 1 + combinations * points + min(table.starts, combinations) * table.evaluations


def search(
    study: Study,
    table: Optimise,
    evaluate: Callable[[Reader], Evaluation],
    prepare: Callable[[Sequence[Reader]], object] | None = None,
    attainment: Callable[[Any], float] | None = None,
    *,
    slopes: Callable[[Reader, tuple[str, ...]], Slopes] | None = None,
) -> Search:
    """Return every design that the search of a study's ``[optimise]`` tries, judged by its goals.

    The refinement maximises `Targets.attainment`, which has kinks where the goal that limits it
    changes. Nelder and Mead's simplex needs no derivatives; it starts anew with half the step when
    it has shrunk, which is known to free it from points that are none. It promises a local maximum
    only. Refuses a gain over a ``[reader]`` without scores, and a survey without a feasible design.

    Parameters
    ----------
    study, table : The study, for its reader and seed, and its search.
    evaluate : Returns a design's `Evaluation`; called once for each design.
    prepare : Receives all designs of the survey before they are evaluated, so that workers can
        compute them at the same time.
    attainment : Judges what ``evaluate`` returned in place of the goals: more is better, minus
        infinity is infeasible [-].
    slopes : Returns the derivatives of a design's scores by keys, for the method ``gradient``.
    """
    if table.method != "gradient":
        slopes = None
    elif slopes is None or attainment is not None:
        msg = (
            'optimise.method is "gradient", which has derivatives of goals only, not of an '
            'objective of your own; give "nelder-mead" or "cobyqa".'
        )
        raise ConfigError(msg)
    reader = evaluate(study.reader)
    reference = reader if reader.feasible else None
    by_goals = attainment is None
    if by_goals and reference is None and any(g.score == "gain_db" for g in table.goals):
        msg = (
            "optimise.goal asks for gain_db, the gain over [reader], but the reader has no scores: "
            f"{reader.reason} Give a [reader] within the limits, or level_dbm instead."
        )
        raise ConfigError(msg)
    targets = Targets(goals=table.goals, distances_m=table.distances_m, reference=reference)
    log = _Log(
        evaluate=lambda design: _known_or(reader, design, evaluate),
        attainment=attainment or targets.attainment,
    )
    log.tried(reader.design, "reader")
    generator = np.random.default_rng(study.seed)
    frequency = study.radio.frequency_hz
    best: list[tuple[Trial, Box]] = []
    survey = [
        (box, survey_designs(box, table.survey, frequency_hz=frequency, generator=generator))
        for box in boxes(study, table)
    ]
    if prepare is not None:
        prepare([design for _, designs in survey for design in designs])
    for box, designs in survey:
        trials = [log.tried(design, "survey") for design in designs]
        first = max(trials, key=lambda t: t.attainment)
        best += [(first, box)] if first.evaluation.feasible else []
    if not best:
        raise SweepStateError(_nothing_feasible(log.trials))
    best.sort(key=lambda pair: -pair[0].attainment)
    for trial, box in best[: table.starts] if table.evaluations else ():
        start = box.point(trial.evaluation.design, frequency_hz=frequency)
        if slopes is not None:
            _ascend(study, log, box, start=trial, targets=targets, slopes=slopes)
        else:
            _refine(table, log, box, start=start, generator=generator)
    return Search(trials=tuple(log.trials), targets=targets)


def _known_or(
    reader: Evaluation, design: Reader, evaluate: Callable[[Reader], Evaluation]
) -> Evaluation:
    """Return the reader's evaluation for its own design, else a new one."""
    return reader if design == reader.design else evaluate(design)


def _nothing_feasible(trials: Sequence[Trial]) -> str:
    reasons = list(dict.fromkeys(t.evaluation.reason for t in trials if t.evaluation.reason))
    return (
        f"none of the {len(trials)} designs of the survey is feasible, so there is nothing to "
        f"refine; the first reason: {reasons[0]} Change optimise.parameters, choices or limits."
    )


def _ascend(
    study: Study,
    log: _Log,
    box: Box,
    *,
    start: Trial,
    targets: Targets,
    slopes: Callable[[Reader, tuple[str, ...]], Slopes],
) -> None:
    """Refine by derivatives from a trial until nothing is gained, or the budget is spent."""
    table = table_of(study)
    most = len(log.trials) + table.evaluations

    def tried(design: Reader) -> Evaluation:
        if design not in log.by_design and len(log.trials) >= most:
            raise _BudgetSpentError
        return log.tried(design, "refinement").evaluation

    with suppress(_BudgetSpentError):
        ascend(
            box,
            start.evaluation,
            targets=targets,
            limits=Limits(footprint_m=table.footprint_m, height_m=table.height_m),
            frequency_hz=study.radio.frequency_hz,
            tried=tried,
            slopes=slopes,
        )


def _refine(
    table: Optimise, log: _Log, box: Box, *, start: FloatArray, generator: np.random.Generator
) -> None:
    """Run the method of the table from a point until its budget is spent."""
    most = len(log.trials) + table.evaluations
    idle = [0]

    def cost(point: FloatArray) -> float:
        design = box.design(point)
        new = design not in log.by_design
        idle[0] = 0 if new else idle[0] + 1
        if (new and len(log.trials) >= most) or idle[0] > PATIENCE:
            raise _BudgetSpentError
        attainment = log.tried(design, "refinement").attainment
        return -attainment if np.isfinite(attainment) else INFEASIBLE

    try:
        for _ in _rounds(table.method, cost, start, generator):
            pass
    except _BudgetSpentError:
        return


def _rounds(
    method: str, cost: Objective, start: FloatArray, generator: np.random.Generator
) -> Iterator[None]:
    """Yield after each round, restarted with half the step; the budget ends them by exception."""
    from scipy.optimize import differential_evolution, minimize

    limits = [(0.0, 1.0)] * start.size
    if method == "differential-evolution":
        differential_evolution(
            cost, limits, x0=start, rng=generator, init="halton", polish=False, tol=0.0
        )
        return
    step, point = FIRST_STEP, start
    while step > LAST_STEP:
        if method == "cobyqa":
            radii = {"initial_tr_radius": step, "final_tr_radius": LAST_STEP}
            found = minimize(cost, point, method="COBYQA", bounds=limits, options=radii)
        else:
            corners = np.vstack([point, point + _inward(point, step) * np.eye(point.size)])
            options: dict[str, Any] = {
                "initial_simplex": corners,
                "xatol": LAST_STEP,
                "fatol": 1e-3,
            }
            found = minimize(cost, point, method="Nelder-Mead", bounds=limits, options=options)
        point, step = np.clip(found.x, 0.0, 1.0), 0.5 * step
        yield


def _inward(point: FloatArray, step: float) -> FloatArray:
    """Return the step from a point along each axis, turned round where it would leave the cube."""
    return np.where(point + step <= 1.0, step, -step)
