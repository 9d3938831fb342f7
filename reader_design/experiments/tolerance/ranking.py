"""With what confidence one design is better than another, by the rules of the choice."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import SweepStateError
from octant.navigation.statistics import Interval, wilson
from octant.reader_design.experiments.tolerance.cases import CaseScores
from octant.reader_design.setting.ranking import Candidate, choose
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.study_file.choice import Choice as Rules

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RoomRss:
    """What a design receives in a room, as :func:`room_samples_w` returns it, place by place.

    Attributes
    ----------
    rss_w : (k, a, n) float64 — RSS by place and tag, azimuth of the tag, antenna [W].
    azimuths_rad : (a,) float64 — Azimuths of the tag in the reader frame [rad].
    element_azimuths_rad : (n,) float64 — Azimuths of the antennas [rad].
    """

    rss_w: FloatArray
    azimuths_rad: FloatArray
    element_azimuths_rad: FloatArray


def wins(
    first: Sequence[CaseScores],
    second: Sequence[CaseScores],
    *,
    rules: Rules | None = None,
) -> Interval:
    """Return how often the first design is chosen over the second, with its Wilson interval.

    Readers equal in everything count one half, as does a pair of which neither can be built.

    Parameters
    ----------
    first, second : Scores of two designs, sample by sample with the same errors.
    rules : Rules of the choice; default: those of Rules.
    """
    if len(first) != len(second) or not first:
        msg = (
            f"{len(first)} and {len(second)} samples cannot be compared in pairs; score both "
            "designs with the same errors."
        )
        raise SweepStateError(msg)
    won = sum(_won(a, b, rules) for a, b in zip(first, second, strict=True))
    return wilson(won, len(first))


def _won(first: CaseScores, second: CaseScores, rules: Rules | None) -> float:
    """Return 1 when the first is chosen, 0 when the second is, one half for neither."""
    if first.free is None or second.free is None:
        return 0.5 + 0.5 * (first.free is not None) - 0.5 * (second.free is not None)
    pair = [
        Candidate(label=label, key=label, free=case.free, room=case.room)
        for label, case in (("first", first), ("second", second))
        if case.free is not None
    ]
    # Asked in both orders: what is equal in everything follows the order.
    ahead = choose(pair, model="fullwave", rules=rules).chosen == 0
    behind = choose(pair[::-1], model="fullwave", rules=rules).chosen == 1
    return 0.5 * (ahead + behind)


def wins_over_places(
    first: tuple[CaseScores, RoomRss],
    second: tuple[CaseScores, RoomRss],
    *,
    random: np.random.Generator,
    resamples: int = 200,
    rules: Rules | None = None,
) -> Interval:
    """Return how often the first design is chosen over resampled places of the room.

    The interval is that of the finite number of resamples only; the share itself says how far the
    room's places decide. Places count as independent: they should lie half a wavelength or more
    apart.

    Parameters
    ----------
    first, second : The drawings' scores and what they receive at the same places.
    random, resamples : Generator and number of resamples; both designs get the same places.
    rules : Rules of the choice; default: those of Rules.
    """
    count = len(first[1].rss_w)
    if len(second[1].rss_w) != count:
        msg = (
            f"the designs were probed at {count} and {len(second[1].rss_w)} places, but the same "
            "are needed; probe both in one room with one spacing."
        )
        raise SweepStateError(msg)
    won = 0.0
    for _ in range(resamples):
        places = random.integers(0, count, count)
        pair = [_with_places(case, room, places) for case, room in (first, second)]
        won += _won(pair[0], pair[1], rules)
    return wilson(won, resamples)


def _with_places(case: CaseScores, room: RoomRss, places: npt.NDArray[np.int64]) -> CaseScores:
    """Return a case whose room scores are those of given places."""
    scores = score_rss(room.rss_w[places], room.azimuths_rad, room.element_azimuths_rad)
    return CaseScores(free=case.free, room=scores, levels_dbm=case.levels_dbm)


def confidence_sentence(
    confidence: Interval, *, better: str, worse: str, samples: int, over: str = "built readers"
) -> str:
    """Return e.g. "With 93 % (86 to 97) confidence A is better than B (100 built readers).".

    Parameters
    ----------
    confidence : Share of samples in which it is.
    better, worse : Names of the designs.
    samples, over : Number of samples, and what they are.
    """
    value, low, high = (
        round(100.0 * x) for x in (confidence.value, confidence.low, confidence.high)
    )
    sentence = (
        f"With {value} % ({low} to {high}) confidence {better} is better than {worse} "
        f"({samples} {over})."
    )
    if confidence.low > 0.5:
        return sentence
    if confidence.high < 0.5:
        return f"{sentence} As built, {worse} is the better one."
    return f"{sentence} That does not tell them apart."
