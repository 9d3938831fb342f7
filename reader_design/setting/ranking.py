"""Which of the scored designs to build: constraints, ordered criteria, Pareto front.

The rules are data of the study (table ``[choice]``);
:mod:`octant.reader_design.setting.reasons` says them, and the outcome, in words.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from octant.geometries.errors import SweepStateError
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.setting.pareto import pareto_front
from octant.reader_design.setting.reasons import (
    MISSIONS,
    ONLY_ONE,
    ORDER,
    SIZE,
    USABLE,
    chosen_sentence,
    comparison_sentence,
    criterion_name,
    missions_sentence,
    model_sentence,
)
from octant.reader_design.study_file.choice import Choice as Rules
from octant.reader_design.study_file.choice import Criterion
from octant.reader_design.study_file.scores import (
    Scores,
    higher_is_better,
    score_unit,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A design that competes, with its scores.

    Attributes
    ----------
    label : Human name of the design, with its dimensions [cm].
    key : Hash of the cell it was computed in.
    free, room : Scores in free space and in the room, the latter None without a room.
    width_m, height_m : Size of the reader [m], see `Reader.size_m`; 0 where it is not known and no
        constraint is to act.
    """

    label: str
    key: str
    free: Scores
    room: Scores | None
    width_m: float = 0.0
    height_m: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Merit:
    """The numbers that decide about one candidate.

    Attributes
    ----------
    usable_share : The smaller usable share of free space and room [-].
    excess_m : By how much the reader exceeds the greatest allowed width or height, the greater of
        the two [m]; 0 where it fits.
    values : One for each criterion, in the unit of its score [rad, dB, dBm, W or -].
    """

    usable_share: float
    excess_m: float
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The chosen design and the whole ranking.

    Attributes
    ----------
    rules : What the ranking obeys; lengths in [m].
    ranking : Indices of the candidates, best first.
    merits : The deciding numbers in the order of the candidates ([-], [rad], [dB], [dBm]).
    pareto : Whether no other candidate is at least as good in all criteria and better in one.
    decided : What separated each design of the ranking from the next.
    reason : Why the first was chosen, in sentences with numbers.
    comparisons : For each design of the ranking, one sentence with numbers: what it has over the
        next.
    """

    rules: Rules
    ranking: tuple[int, ...]
    merits: tuple[Merit, ...]
    pareto: tuple[bool, ...]
    decided: tuple[str, ...]
    reason: tuple[str, ...]
    comparisons: tuple[str, ...]

    @property
    def chosen(self) -> int:
        """Index of the chosen candidate."""
        return self.ranking[0]

    @property
    def decided_by(self) -> str:
        """What separated the chosen design from the second."""
        return self.decided[0]

    @property
    def shortlist(self) -> tuple[int, ...]:
        """Indices of the designs of the short list, best first."""
        return self.ranking[: self.rules.shortlist]


def criterion_value(criterion: Criterion, free: Scores, room: Scores | None) -> float:
    """Return what a criterion compares: a score or the mean of both, of bearing errors their rms.

    Parameters
    ----------
    criterion : Names of the scores.
    free : In free space.
    room : In the room; None: free space stands for it where the criterion names a score there.
    """
    values = []
    if criterion.free and (room is not None or not criterion.room):
        values.append(getattr(free, criterion.free))
    if criterion.room and room is not None:
        values.append(getattr(room, criterion.room))
    if not values:
        values.append(getattr(free, criterion.free or criterion.room))
    if score_unit(criterion.free or criterion.room) == "rad":
        return math.sqrt(sum(v * v for v in values) / len(values))
    return float(sum(values) / len(values))


def merit(candidate: Candidate, rules: Rules | None = None) -> Merit:
    """Return the deciding numbers of a candidate ([-], [m], [rad], [dB], [dBm]).

    Parameters
    ----------
    candidate : Its scores; without a room those of free space alone count.
    rules : Default: those of a study that names none.
    """
    rules = rules or Rules()
    free, room = candidate.free, candidate.room
    excess = [0.0]
    if rules.greatest_width_m is not None:
        excess.append(candidate.width_m - rules.greatest_width_m)
    if rules.greatest_height_m is not None:
        excess.append(candidate.height_m - rules.greatest_height_m)
    return Merit(
        usable_share=min(s.usable_share for s in (free, room) if s is not None),
        excess_m=max(excess),
        values=tuple(criterion_value(c, free, room) for c in rules.criteria),
    )


def better_is_more(criterion: Criterion) -> bool:
    """Return whether a criterion wants its score high.

    Parameters
    ----------
    criterion : Names of the scores.
    """
    return higher_is_better(criterion.free or criterion.room)


def _keeps_up(value: float, best: float, criterion: Criterion) -> bool:
    """Return whether a value stays behind the best by no more than the tolerance."""
    allowed = criterion.tolerance * (abs(best) if criterion.relative else 1.0)
    behind = best - value if better_is_more(criterion) else value - best
    return behind <= allowed


def _select(merits: Sequence[Merit], left: list[int], rules: Rules) -> tuple[int, str]:
    """Return the best of the candidates that are left, and what decided."""
    least = min(merits[i].excess_m for i in left)
    pool = [i for i in left if merits[i].excess_m <= max(least, LENGTHS.same_m)]
    decided = SIZE if len(pool) < len(left) else ONLY_ONE
    usable = [i for i in pool if merits[i].usable_share >= rules.least_usable_share]
    if not usable:
        most = max(merits[i].usable_share for i in pool)
        usable = [i for i in pool if merits[i].usable_share >= most]
    decided = USABLE if len(usable) < len(pool) else decided
    pool = usable
    for k, criterion in enumerate(rules.criteria):
        values = [merits[i].values[k] for i in pool]
        best = max(values) if better_is_more(criterion) else min(values)
        kept = [i for i in pool if _keeps_up(merits[i].values[k], best, criterion)]
        decided = criterion_name(criterion) if len(kept) < len(pool) else decided
        pool = kept
    return pool[0], ORDER if len(pool) > 1 else decided


def choose(candidates: Sequence[Candidate], *, model: str, rules: Rules | None = None) -> Choice:
    """Return the ranking of the candidates and the reason for the first; units as in Merit.

    The selection is repeated on the designs that are left, so every place obeys the same rules.

    Parameters
    ----------
    candidates : Scored designs, in the order of the sweep; at least one.
    model : Model of the reader's response, so that the reason can say how far to trust it.
    rules : The study's table ``[choice]``; default: that of a study that names none.
    """
    if not candidates:
        msg = (
            "the sweep left 0 scored designs, but 1 is needed for a choice; "
            "see the reasons of the failed cells and change [sweep] or [reader]."
        )
        raise SweepStateError(msg)
    rules = rules or Rules()
    merits = tuple(merit(c, rules) for c in candidates)
    left = list(range(len(candidates)))
    ranking: list[int] = []
    decided: list[str] = []
    while left:
        index, by = _select(merits, left, rules)
        ranking.append(index)
        decided.append(by)
        left.remove(index)
    values = np.array([m.values for m in merits])
    pairs = [
        comparison_sentence(merits[a], merits[b], by, label=candidates[b].label, rules=rules)
        for a, b, by in zip(ranking, ranking[1:], decided, strict=False)
    ]
    first = ranking[0]
    reason = [
        *chosen_sentence(candidates[first], merits[first], rules),
        *pairs[:1],
        model_sentence(model),
    ]
    return Choice(
        rules=rules,
        ranking=tuple(ranking),
        merits=merits,
        pareto=tuple(pareto_front(values, [better_is_more(c) for c in rules.criteria]).tolist()),
        decided=tuple(decided),
        reason=tuple(reason),
        comparisons=(*pairs, "It is the last of the ranking."),
    )


def after_missions(
    choice: Choice, candidates: Sequence[Candidate], reached: Mapping[int, int], *, runs: int
) -> Choice:
    """Return the ranking in which designs that drove stand by how many runs reached every tag.

    The reason says whether that changed which design is chosen.

    Parameters
    ----------
    choice, candidates : By the scores alone, and of what.
    reached : Runs that reached every tag, by the index of each candidate that drove: the first ones
        of the ranking.
    runs : Of how many runs of each.
    """
    first = sorted(choice.ranking[: len(reached)], key=lambda i: -reached[i])
    ranking = (*first, *choice.ranking[len(reached) :])
    decided, comparisons = [], []
    for a, b in itertools.pairwise(ranking):
        if a in reached and b in reached and reached[a] != reached[b]:
            decided.append(MISSIONS)
            comparisons.append(
                missions_sentence(reached[a], reached[b], runs, label=candidates[b].label)
            )
            continue
        _, by = _select(choice.merits, [a, b], choice.rules)
        decided.append(by)
        one, other = choice.merits[a], choice.merits[b]
        label = candidates[b].label
        comparisons.append(comparison_sentence(one, other, by, label=label, rules=choice.rules))
    before, now = choice.chosen, ranking[0]
    if now == before:
        told = "Its missions did not change the choice that the scores alone make"
    else:
        told = (
            f"By the scores alone {candidates[before].label} would have been chosen, of whose runs "
            f"{reached[before]} of {runs} reached every tag"
        )
    return replace(
        choice,
        ranking=ranking,
        decided=(*decided, ONLY_ONE),
        reason=(
            *chosen_sentence(candidates[now], choice.merits[now], choice.rules),
            *comparisons[:1],
            f"{told}; {reached[now]} of {runs} did with this one.",
            choice.reason[-1],
        ),
        comparisons=(*comparisons, choice.comparisons[-1]),
    )
