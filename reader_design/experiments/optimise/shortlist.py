"""The short list: the Pareto front of a search, ranked, one of each kind, with reasons."""

from dataclasses import dataclass

import numpy as np

from octant.reader_design.experiments.optimise.goals import (
    Targets,
    direction,
    goal_name,
    value_text,
)
from octant.reader_design.experiments.optimise.search import Search, Trial
from octant.reader_design.setting.pareto import pareto_front
from octant.reader_design.study_file.optimise import Goal
from octant.reader_design.study_file.reader import Reader

LEAST_DIFFERENCE = 0.15
"""Least relative difference in some parameter between two designs of the short list [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Listed:
    """One place of the short list.

    Attributes
    ----------
    trial, reason : The design, and why it stands there, in words and numbers.
    """

    trial: Trial
    reason: str


def front(search: Search) -> tuple[Trial, ...]:
    """Return the feasible designs that none beats in every goal's score, best attainment first.

    Parameters
    ----------
    search : A finished search.
    """
    feasible = [t for t in search.trials if t.evaluation.feasible]
    signs = np.array([direction(goal) for goal in search.targets.goals])
    merits = signs * np.array([search.targets.scores(t.evaluation) for t in feasible])
    kept = [t for t, on in zip(feasible, pareto_front(merits, maximise=True), strict=True) if on]
    return tuple(sorted(kept, key=lambda t: (-t.attainment, t.number)))


def short_list(search: Search, count: int) -> tuple[Listed, ...]:
    """Return the best of the Pareto front, the winner first, with reasons.

    Designs that differ by less than 15 % in every parameter stand for one.

    Parameters
    ----------
    search, count : A finished search; how many designs at most.
    """
    chosen: list[Trial] = []
    for trial in front(search):
        if len(chosen) == count:
            break
        if all(_differ(trial.evaluation.design, c.evaluation.design) for c in chosen):
            chosen.append(trial)
    return tuple(
        Listed(trial=trial, reason=_reason(search, trial, place))
        for place, trial in enumerate(chosen)
    )


def _differ(a: Reader, b: Reader) -> bool:
    mine, other = a.as_dict(), b.as_dict()
    for name, value in mine.items():
        if isinstance(value, float) and isinstance(other[name], float):
            if abs(value - other[name]) > LEAST_DIFFERENCE * max(abs(value), abs(other[name])):
                return True
        elif value != other[name]:
            return True
    return False


def _reason(search: Search, trial: Trial, place: int) -> str:
    targets, goals = search.targets, search.targets.goals
    scores, met = targets.scores(trial.evaluation), targets.met(trial.evaluation)
    lead = "Chosen" if place == 0 else f"Place {place + 1}"
    if all(met):
        head = f"{lead}, because it meets every goal"
    else:
        missed = [
            f"{goal_words(goal)} (goal {value_text(goal, goal.value)})"
            for goal, done in zip(goals, met, strict=True)
            if not done
        ]
        head = f"{lead}; it meets {sum(met)} of {len(goals)} goals and misses {', '.join(missed)}"
    listed = ", ".join(
        f"{goal_words(goal)} {value_text(goal, value)}"
        for goal, value in zip(goals, scores, strict=True)
    )
    return f"{head}: {listed}.{_against_reader(targets, trial, search.reader)}"


def _against_reader(targets: Targets, trial: Trial, reader: Trial) -> str:
    """Return in which scores the study's reader is beaten, and in which it is better."""
    if trial.number == reader.number or not reader.evaluation.feasible:
        return ""
    pairs = zip(
        targets.goals,
        targets.scores(trial.evaluation),
        targets.scores(reader.evaluation),
        strict=True,
    )
    better = [direction(goal) * (mine - its) for goal, mine, its in pairs]
    worse = [
        goal_words(goal) for goal, gain in zip(targets.goals, better, strict=True) if gain < 0.0
    ]
    if not worse:
        return " In none of these does the study's reader come before it."
    return f" The study's reader is better in {' and '.join(worse)}."


def goal_words(goal: Goal) -> str:
    """Return a goal's score in words without unit, such as ``worst margin over the neighbours``.

    Parameters
    ----------
    goal : The goal.
    """
    return goal_name(goal).split(" [", maxsplit=1)[0]
