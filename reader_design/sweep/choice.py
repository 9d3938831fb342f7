"""Which of the scored designs to build, and why: constraints, ordered criteria, Pareto front."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from octant.geometries.errors import SweepStateError
from octant.reader_design.sweep.pareto import undominated
from octant.reader_design.sweep.scores import Scores


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A design that competes, with its scores.

    Attributes
    ----------
    label : str
        Human name of the design, with its dimensions [cm].
    key : str
        Hash of the cell it was computed in [-].
    free : Scores
        Scores in free space (units as in Scores: [rad], [dB], [W], [-]).
    room : Scores or None
        Scores in the room; None when the study has none.
    """

    label: str
    key: str
    free: Scores
    room: Scores | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Criteria:
    """The rules of the choice: one constraint, then four criteria in order of weight.

    Attributes
    ----------
    least_usable_share : float
        A design whose strongest antenna is usable in a smaller share of samples [-], in free space
        or in the room, ranks below all others.
    share_tolerance : float
        Shares of right antennas that differ by no more than this [-] count as equal.
    error_tolerance : float
        RMS errors of the vector sum within this fraction of the smallest [-] count as equal.
    margin_tolerance_db : float
        Worst margins that differ by no more than this [dB] count as equal.

    Notes
    -----
    The order follows the use: the navigator takes the strongest antenna for the tag's direction
    (thesis (5.2)), so a wrong one sends the robot astray; then counts how well all antennas
    together give the bearing, then how much noise the decision of a facing antenna stands, and at
    last the level, which matters less because the tag's power can be raised. The tolerances keep
    sampling noise and the error of the models (about 0.5 dB at best) from deciding.
    """

    least_usable_share: float = 0.95
    share_tolerance: float = 0.02
    error_tolerance: float = 0.05
    margin_tolerance_db: float = 0.5

    def sentences(self) -> tuple[str, ...]:
        """Return the rules in words, one sentence each, tolerances in [dB] and percent [%].

        Returns
        -------
        tuple of str
            In the order in which they act.
        """
        usable = (
            f"A design must receive a usable signal in at least {self.least_usable_share:.0%} of "
            "the samples, in free space and in the room; others rank last."
        )
        share = (
            "First: the share of directions whose strongest antenna is the nearest in angle, mean "
            f"of free space and room; within {100 * self.share_tolerance:.0f} percentage points "
            "of the best counts as equal."
        )
        error = (
            "Then: the rms bearing error of the RSS-weighted vector sum, root mean square of free "
            f"space and room; within {self.error_tolerance:.0%} counts as equal."
        )
        margin = (
            "Then: the margin of the antenna that faces the tag over its stronger neighbour, "
            "worst case in free space and mean in the room, averaged; within "
            f"{self.margin_tolerance_db:g} dB counts as equal."
        )
        level = (
            "Last: the median level of the strongest antenna, mean of free space and room in dB; "
            "if that is equal too, the design that stands first in the sweep."
        )
        return usable, share, error, margin, level


@dataclass(frozen=True, slots=True, kw_only=True)
class Merit:
    """The five numbers that decide about one candidate.

    Attributes
    ----------
    usable_share : float
        The smaller usable share of free space and room [-].
    right_share : float
        Share of right antennas [-], mean of free space and room.
    vector_rms_rad : float
        Error of the vector sum [rad], root mean square over free space and room.
    margin_db : float
        Worst margin in free space and mean margin in the room, averaged [dB].
    level_dbm : float
        Median level [dBm], mean of free space and room.
    """

    usable_share: float
    right_share: float
    vector_rms_rad: float
    margin_db: float
    level_dbm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The chosen design and the whole ranking.

    Attributes
    ----------
    ranking : tuple of int
        Indices of the candidates, best first [-].
    merits : tuple of Merit
        The deciding numbers in the order of the candidates ([-], [rad], [dB], [dBm]).
    pareto : tuple of bool
        Whether no other candidate is at least as good in all four criteria and better in one.
    decided_by : str
        Criterion that separated the chosen design from the second.
    reason : tuple of str
        Why, in sentences with numbers.
    """

    ranking: tuple[int, ...]
    merits: tuple[Merit, ...]
    pareto: tuple[bool, ...]
    decided_by: str
    reason: tuple[str, ...]

    @property
    def chosen(self) -> int:
        """Index of the chosen candidate [-]."""
        return self.ranking[0]


def merit(candidate: Candidate) -> Merit:
    """Return the five deciding numbers of a candidate ([-], [rad], [dB], [dBm]).

    Parameters
    ----------
    candidate : Candidate
        Its scores; without a room those of free space alone count.

    Returns
    -------
    Merit
        See there.

    Notes
    -----
    In a room the worst margin is a fading dip at a single place and says nothing about the
    design, so the mean stands for it; in free space the worst one does.
    """
    free = candidate.free
    room = candidate.room
    if room is None:
        return Merit(
            usable_share=free.usable_share,
            right_share=free.right_share,
            vector_rms_rad=free.vector_rms_rad,
            margin_db=free.margin_worst_db,
            level_dbm=free.level_median_dbm,
        )
    return Merit(
        usable_share=min(free.usable_share, room.usable_share),
        right_share=0.5 * (free.right_share + room.right_share),
        vector_rms_rad=math.sqrt(0.5 * (free.vector_rms_rad**2 + room.vector_rms_rad**2)),
        margin_db=0.5 * (free.margin_worst_db + room.margin_mean_db),
        level_dbm=0.5 * (free.level_median_dbm + room.level_median_dbm),
    )


def _steps(
    criteria: Criteria,
) -> tuple[tuple[str, Callable[[Merit, Sequence[Merit]], bool]], ...]:
    """Return the ordered criteria: a name, and whether a design keeps up with those left."""

    def share(m: Merit, field: Sequence[Merit]) -> bool:
        return m.right_share >= max(f.right_share for f in field) - criteria.share_tolerance

    def error(m: Merit, field: Sequence[Merit]) -> bool:
        least = min(f.vector_rms_rad for f in field)
        return m.vector_rms_rad <= least * (1.0 + criteria.error_tolerance)

    def margin(m: Merit, field: Sequence[Merit]) -> bool:
        return m.margin_db >= max(f.margin_db for f in field) - criteria.margin_tolerance_db

    def level(m: Merit, field: Sequence[Merit]) -> bool:
        return m.level_dbm >= max(f.level_dbm for f in field)

    return (
        ("share of right antennas", share),
        ("bearing error of the vector sum", error),
        ("margin over the neighbours", margin),
        ("level", level),
    )


def _select(merits: Sequence[Merit], left: list[int], criteria: Criteria) -> tuple[int, str]:
    """Return the best of the candidates that are left, and the criterion that decided."""
    usable = [i for i in left if merits[i].usable_share >= criteria.least_usable_share]
    if not usable:
        most = max(merits[i].usable_share for i in left)
        usable = [i for i in left if merits[i].usable_share >= most]
    decided = "usable signal" if len(usable) < len(left) else "only one design"
    pool = usable
    for name, passes in _steps(criteria):
        field = [merits[i] for i in pool]
        kept = [i for i in pool if passes(merits[i], field)]
        if len(kept) < len(pool):
            decided = name
        pool = kept
    if len(pool) > 1:
        decided = "order of the sweep"
    return pool[0], decided


def pareto_front(merits: Sequence[Merit]) -> tuple[bool, ...]:
    """Return which candidates no other one dominates in share, error, margin and level [-].

    Parameters
    ----------
    merits : sequence of Merit
        Deciding numbers ([-], [rad], [dB], [dBm]).

    Returns
    -------
    tuple of bool
        True: no other is at least as good in all four and better in one.
    """
    rows = [(m.right_share, -m.vector_rms_rad, m.margin_db, m.level_dbm) for m in merits]
    return tuple(bool(kept) for kept in undominated(rows))


def _numbers(candidate: Candidate) -> str:
    """Return the numbers behind a candidate's rank, as half a sentence."""
    free, room = candidate.free, candidate.room

    def text(scores: Scores) -> str:
        return (
            f"the strongest antenna is the right one in {scores.right_share:.0%} of the "
            f"directions, the vector sum is {math.degrees(scores.vector_rms_rad):.1f}° rms off"
        )

    out = (
        f"in free space {text(free)} and the facing antenna leads its neighbours by "
        f"{free.margin_worst_db:+.1f} dB at worst"
    )
    if room is not None:
        out += (
            f"; in the room {text(room)} and the facing antenna leads by "
            f"{room.margin_mean_db:+.1f} dB on average"
        )
    return out


def _reason(
    candidates: Sequence[Candidate],
    merits: Sequence[Merit],
    ranking: Sequence[int],
    decided: str,
    *,
    criteria: Criteria,
    model: str,
) -> tuple[str, ...]:
    """Return why the first of the ranking was chosen."""
    best = candidates[ranking[0]]
    sentences = [f"Chosen: {best.label}; {_numbers(best)}."]
    if merits[ranking[0]].usable_share < criteria.least_usable_share:
        sentences.append(
            "No design receives a usable signal in "
            f"{criteria.least_usable_share:.0%} of the samples; this one comes closest with "
            f"{merits[ranking[0]].usable_share:.0%}."
        )
    if len(ranking) > 1:
        second = candidates[ranking[1]]
        a, b = merits[ranking[0]], merits[ranking[1]]
        numbers = {
            "usable signal": f"{a.usable_share:.0%} against {b.usable_share:.0%} usable",
            "share of right antennas": f"{a.right_share:.1%} against {b.right_share:.1%}",
            "bearing error of the vector sum": f"{math.degrees(a.vector_rms_rad):.1f}° against "
            f"{math.degrees(b.vector_rms_rad):.1f}° rms",
            "margin over the neighbours": f"{a.margin_db:+.1f} dB against {b.margin_db:+.1f} dB",
            "level": f"{a.level_dbm:.1f} dBm against {b.level_dbm:.1f} dBm",
        }.get(decided, "all criteria equal within their tolerances")
        sentences.append(f"Next comes {second.label}; what decided is the {decided}: {numbers}.")
    sentences.append(_model_sentence(model))
    return tuple(sentences)


def _model_sentence(model: str) -> str:
    """Return how far the reader's model can be trusted."""
    if model == "rays":
        return (
            "Take the ranking with care: the reader's own metal was modelled by the currents that "
            'rays induce on it (response = "rays"), which leaves out the coupling between antennas '
            "and the mismatch to their loads; levels near an antenna's maximum are known to err by "
            "1 to 3 dB, weak ones by more, so a full-wave check must confirm the choice."
        )
    if model == "isolated":
        return (
            "Take the ranking with care: the antennas were modelled alone "
            '(response = "isolated"), so neither the plates nor the ground plane act and '
            "designs that differ in them only cannot be told apart."
        )
    if model == "fullwave":
        return (
            "The reader's own body was solved by the method of moments "
            '(response = "fullwave"): coupling, mismatch to the loads and diffraction at its edges '
            "are in the ranking; thickness and losses of its metal, and the robot below, are not."
        )
    if model == "files":
        return "The reader is given by pattern files; the choice rests on what they say."
    return f'The reader\'s own body was modelled with response = "{model}".'


def choose(
    candidates: Sequence[Candidate], *, model: str, criteria: Criteria | None = None
) -> Choice:
    """Return the ranking of the candidates and the reason for the first; units as in Merit [-].

    Parameters
    ----------
    candidates : sequence of Candidate
        Scored designs, in the order of the sweep; at least one.
    model : str
        Model of the reader's response, so that the reason can say how far to trust it [-].
    criteria : Criteria, optional
        The rules; default: those of Criteria.

    Returns
    -------
    Choice
        The ranking repeats the selection on the designs that are left, so every place in it obeys
        the same rules.

    Raises
    ------
    SweepStateError
        When there is no candidate.
    """
    if not candidates:
        msg = (
            "the sweep left 0 scored designs, but 1 is needed for a choice; "
            "see the reasons of the failed cells and change [sweep] or [reader]."
        )
        raise SweepStateError(msg)
    criteria = criteria or Criteria()
    merits = tuple(merit(c) for c in candidates)
    left = list(range(len(candidates)))
    ranking: list[int] = []
    decisions: list[str] = []
    while left:
        index, decided = _select(merits, left, criteria)
        ranking.append(index)
        decisions.append(decided)
        left.remove(index)
    return Choice(
        ranking=tuple(ranking),
        merits=merits,
        pareto=pareto_front(merits),
        decided_by=decisions[0],
        reason=_reason(candidates, merits, ranking, decisions[0], criteria=criteria, model=model),
    )
