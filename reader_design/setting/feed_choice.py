"""The table ``[reader.feed]`` that matches a reader over a band and keeps its bearing best."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from octant.em.reader.fullwave.loads import LoadedReader
from octant.em.reader.match_search import Chosen, all_matches, chosen_match, off_states
from octant.em.reader.matching import Match
from octant.reader_design.setting.feed_scores import BearingErrors, FeedScores
from octant.reader_design.study_file.reader_feed import ReaderFeed
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

TOLERANCE = 0.05
"""Tolerance of parts that can be bought [-]: E24 values are made for 5 %."""
WORTH = 0.02
"""Share by which the scores must be better for one more part or a line [-]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProposedFeed:
    """A feed of parts that can be bought, what it reaches, and what it does to the bearing.

    Parameters
    ----------
    feed : The table ``[reader.feed]``.
    match : Its networks.
    reflection_db, worst_db : (f,) float64 — Greatest reflection of all antennas behind it [dB], as
        it is and with parts off by `TOLERANCE`.
    frequencies_hz : Where bearing is scored [Hz].
    errors : Scores there, behind the feed.
    tried : How many feeds that reach the level were compared [-].
    """

    feed: ReaderFeed
    match: Match
    reflection_db: FloatArray
    worst_db: FloatArray
    frequencies_hz: tuple[float, ...]
    errors: BearingErrors
    tried: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FeedChoice:
    """The best feed, the best one without a multiplexer, and the reader as it is.

    Parameters
    ----------
    before : Scores of the reader as the study has it.
    best : The best feed of all.
    own_receivers : The best one with a receiver at each antenna; None where it is the best of all,
        or where none was tried or reaches the level.
    """

    before: BearingErrors
    best: ProposedFeed
    own_receivers: ProposedFeed | None

    @property
    def keeps_bearing(self) -> bool:
        """Whether no score is worse than before at any frequency."""
        return bool((self.best.errors.over(self.before) <= 1.0).all())


def chosen_feed(
    study: Study, solutions: Sequence[LoadedReader], *, at_hz: float
) -> FeedChoice | None:
    """Return the feed that matches a reader and keeps its bearing best; None where none does.

    Parameters
    ----------
    study : Its reader, and the tag whose bearing is scored in free space.
    solutions : The reader's ports at rising frequencies, the band over which it must be matched;
        bearing is scored at the first, the middle and the last.
    at_hz : Where the networks match at best [Hz]; the nearest of the frequencies counts.
    """
    design, present = study.reader, study.reader.line
    if not study.tags or (present and (present.off_file or present.network_files)):
        return None
    f = np.array([ports.frequency_hz for ports in solutions])
    y = np.stack([ports.admittance_s for ports in solutions])
    carrier = int(np.abs(f - at_hz).argmin())
    scored = sorted({0, len(f) // 2, len(f) - 1})
    scores = FeedScores.of(study, [solutions[i] for i in scored])
    before = scores.behind(design.feeding())

    def behind(match: Match) -> BearingErrors:
        return scores.behind(_feed_of(match, present).feeding(design.load_ohm))

    def cost(match: Match) -> float:
        return _cost(behind(match).over(before), match)

    def best_of(candidates: Sequence[Match]) -> Chosen | None:
        return chosen_match(candidates, y, f, judge=cost, tolerance=TOLERANCE)

    def proposed(chosen: Chosen) -> ProposedFeed:
        feed = _feed_of(chosen.match, present)
        feeding = feed.feeding(design.load_ohm)
        share = np.array([feeding.on(ports).reflected_share.max() for ports in solutions])
        return ProposedFeed(
            feed=feed,
            match=chosen.match,
            reflection_db=10.0 * np.log10(np.maximum(share, 1e-20)),
            worst_db=chosen.match.worst_db(y, f, tolerance=TOLERANCE),
            frequencies_hz=scores.frequencies_hz,
            errors=behind(chosen.match),
            tried=chosen.tried,
        )

    every = tuple(
        all_matches(
            y[carrier],
            at_hz=float(f[carrier]),
            source_ohm=design.load_ohm,
            off=off_states(design.feeding(), float(f[carrier])),
        )
    )
    best = best_of(every)
    if best is None:
        return None
    own = best_of([m for m in every if m.off is None]) if best.match.off is not None else None
    return FeedChoice(
        before=before,
        best=proposed(best),
        own_receivers=None if own is None else proposed(own),
    )


def _cost(ratios: FloatArray, match: Match) -> float:
    """Return what is to be least: the worst ratio where a score is lost, else their mean [-]."""
    if float(ratios.max()) > 1.0:
        return float(ratios.max())
    more = len(match.networks[0].parts) - 2
    more += match.off is not None and match.off.cable is not None
    return float(ratios.mean()) * (1.0 + WORTH * more)


def _feed_of(match: Match, present: ReaderFeed | None) -> ReaderFeed:
    """Return the table of networks, with all else that it has already."""
    shown = tuple(map(str, match.networks))
    feed = replace(present or ReaderFeed(), match=shown[:1] if len(set(shown)) == 1 else shown)
    off = match.off
    if off is None or feed.multiplexer_loss_db is not None:
        return feed
    if off.cable is not None and feed.cable_m == 0.0:
        feed = replace(feed, cable_m=off.cable.length_m, cable_velocity=off.cable.velocity)
    return replace(feed, multiplexer_loss_db=0.0, off_resistance_ohm=off.off_ohm.real)
