"""Whether a reader is matched, and what would match it, in sentences."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.loads import LoadedReader
from octant.em.reader.match_search import OPEN_OHM, SHORT_OHM
from octant.em.reader.matching import (
    MATCHED_DB,
    Match,
    best_real_load_ohm,
    match_reader,
    matched_band_hz,
    port_reflection_db,
    vswr,
)
from octant.geometries.errors import OctantError
from octant.reader_design.setting.feed_choice import TOLERANCE, FeedChoice, ProposedFeed
from octant.reader_design.setting.feed_scores import BearingErrors
from octant.reader_design.showing.workshop import networks_text
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.reader_feed import ReaderFeed
from octant.reader_design.study_file.toml import toml_text

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


@dataclass(frozen=True, kw_only=True, eq=False)
class Behind:
    """What the receiver sees behind ``reader.feed``.

    Parameters
    ----------
    loads : What lies there, in words.
    reflection_db : (f, n) float64 — Reflection at the receiver [dB].
    """

    loads: str
    reflection_db: FloatArray

    @classmethod
    def of(cls, design: Reader, solutions: Sequence[LoadedReader]) -> "Behind | None":
        """Return what receivers see of solutions over a band; None without a feed.

        Parameters
        ----------
        design, solutions : The reader, and its ports at each frequency.
        """
        if solutions[0].feeds is None:
            return None
        share = np.array([ports.reflected_share for ports in solutions])
        level_db = 10.0 * np.log10(np.maximum(share, 1e-20))
        return cls(loads=design.loads_text(), reflection_db=level_db)


def matching_lines(
    admittance_s: ComplexArray,
    frequencies_hz: npt.ArrayLike,
    *,
    at_hz: float,
    load_ohm: float,
    behind: Behind | None = None,
    choice: Callable[[], FeedChoice | None] = lambda: None,
) -> Iterator[str]:
    """Yield whether all ports are matched at a frequency, over which band, and else what would do.

    Parameters
    ----------
    admittance_s, frequencies_hz : (f, n, n) admittances of the ports [S] at frequencies, (f,) [Hz].
    at_hz : Where they are to be matched [Hz]; the nearest of the frequencies counts.
    load_ohm : Resistance of source and load of every port [ohm].
    behind : What the receiver sees behind a feed; None: it is at the antennas.
    choice : Gives the feed that keeps the bearing best; called where the ports are not matched.
    """
    f = np.atleast_1d(np.asarray(frequencies_hz, dtype=np.float64))
    carrier = int(np.abs(f - at_hz).argmin())
    level_db = port_reflection_db(admittance_s, load_ohm).max(axis=1)
    to = f"{load_ohm:g} ohm"
    if behind is not None:
        to, level_db = behind.loads, behind.reflection_db.max(axis=1)
    found = _level_text(level_db, f, carrier)
    if level_db[carrier] <= MATCHED_DB:
        yield f"Matched to {to}: {found}."
        if level_db.max() <= MATCHED_DB:
            return
        wider = match_reader(admittance_s, f, at_hz=float(f[carrier]), source_ohm=load_ohm)
        if wider is not None and wider.reflection_db(admittance_s, f).max() <= MATCHED_DB:
            yield from _network_lines(wider, admittance_s, f, carrier)
        return
    yield f"Not matched to {to}: {found}, where {MATCHED_DB:g} dB or less is usual."
    instead = "" if behind is None else " at the antennas, without reader.feed"
    best_ohm = best_real_load_ohm(admittance_s[carrier : carrier + 1])
    with_load = port_reflection_db(admittance_s, best_ohm).max(axis=1)
    yield (
        f"The best real load at that frequency{instead} is {best_ohm:.3g} ohm (reader.load_ohm): "
        f"{_level_text(with_load, f, carrier)}."
    )
    match = match_reader(admittance_s, f, at_hz=float(f[carrier]), source_ohm=load_ohm)
    if match is None:
        yield "No network of coils and capacitors matches all ports at once."
        return
    chosen = None
    try:
        chosen = choice()
    except OctantError as exc:  # of room or tags, which the ports do not need
        yield f"What a match does to the bearing is not counted: {exc}"
    if chosen is None:
        yield from _network_lines(match, admittance_s, f, carrier)
    else:
        yield from _choice_lines(chosen, f, carrier)


def _network_lines(
    match: Match, admittance_s: ComplexArray, f: FloatArray, carrier: int
) -> Iterator[str]:
    """Yield the networks and what they reach, ideal and with parts that can be bought."""
    ideal = match.reflection_db(admittance_s, f).max(axis=1)
    bought = match.bought(admittance_s, f)
    real = bought.reflection_db(admittance_s, f).max(axis=1)
    worst = bought.worst_db(admittance_s, f, tolerance=TOLERANCE)
    name = "an L-network" if len(match.networks[0].parts) == 2 else "a Pi-network"
    yield (
        f"Or {name} at each antenna ({networks_text(tuple(map(str, match.networks)))}; parts "
        f"without losses): {_level_text(ideal, f, carrier, floor_db=-40.0)}."
    )
    yield (
        f"With values of the E24 series: {_level_text(real, f, carrier, floor_db=-40.0)}; all of "
        f"them off by {100.0 * TOLERANCE:g} % in the worst sense: "
        f"{_level_text(worst, f, carrier, floor_db=-40.0)}."
    )
    shown = [str(network) for network in bought.networks]
    entries = ", ".join(f'"{one}"' for one in (shown[:1] if len(set(shown)) == 1 else shown))
    yield f"These in the study file: [reader.feed] match = [{entries}]"
    if len(set(shown)) == 1:
        return
    one = match.alike.bought(admittance_s, f)
    level = one.reflection_db(admittance_s, f).max(axis=1)
    if level.max() <= MATCHED_DB:
        worst = one.worst_db(admittance_s, f, tolerance=TOLERANCE)
        yield (
            f'Or one network for all: match = ["{one.networks[0]}"]: '
            f"{_level_text(level, f, carrier, floor_db=-40.0)}; off by {100.0 * TOLERANCE:g} %: "
            f"{_level_text(worst, f, carrier, floor_db=-40.0)}."
        )


def _choice_lines(choice: FeedChoice, f: FloatArray, carrier: int) -> Iterator[str]:
    """Yield the best feed, what it does to the bearing, and the best one without a multiplexer."""
    best = choice.best
    yield (
        f"Of {best.tried} feeds of E24 values that reach {MATCHED_DB:g} dB over the band, this "
        f"{'keeps the bearing best' if choice.keeps_bearing else 'loses least of the bearing'}: "
        f"{_feed_text(best, f, carrier)}."
    )
    if not choice.keeps_bearing:
        yield "None of them is as good as the reader before it in every score at every frequency."
    yield from _error_lines(choice.before, best)
    if choice.own_receivers is not None:
        yield (
            "The best without a multiplexer, each antenna with a receiver of its own: "
            f"{_feed_text(choice.own_receivers, f, carrier)}."
        )
        yield from _error_lines(choice.before, choice.own_receivers)
    lossless = choice.best.feed.multiplexer_loss_db == 0.0
    put = "; put in the loss of your multiplexer" if lossless else ""
    yield f"The first in the study file{put}:"
    yield from _table_lines(best.feed)


def _table_lines(feed: ReaderFeed) -> Iterator[str]:
    """Yield the table ``[reader.feed]``, keys at their defaults left out."""
    yield "[reader.feed]"
    default = msgspec.to_builtins(ReaderFeed())
    keys = {key: v for key, v in msgspec.to_builtins(feed).items() if v != default[key]}
    yield from toml_text(keys).splitlines()


def _error_lines(before: BearingErrors, proposed: ProposedFeed) -> Iterator[str]:
    """Yield the scores of bearing before and behind a feed."""
    at = ", ".join(f"{one / 1e9:.4g}" for one in proposed.frequencies_hz)
    yield f"Bearing in free space at {at} GHz, before and behind it:"
    after, degrees = proposed.errors, 180.0 / np.pi
    for name, unit, old, new in (
        ("vector sum, rms error", "°", before.vector_rms_rad, after.vector_rms_rad),
        ("strongest antenna, rms error", "°", before.strongest_rms_rad, after.strongest_rms_rad),
        ("wrong antenna strongest", " %", before.wrong_share, after.wrong_share),
    ):
        scale = degrees if unit == "°" else 100.0
        was, now = (", ".join(f"{scale * v:.1f}" for v in values) for values in (old, new))
        yield f"  {name}: {was}{unit} before, {now}{unit} behind."


def _feed_text(proposed: ProposedFeed, f: FloatArray, carrier: int) -> str:
    """Return networks, multiplexer and reflection of a feed in words."""
    networks = networks_text(tuple(map(str, proposed.match.networks)))
    off = "" if proposed.match.off is None else f", and a multiplexer that {_off_text(proposed)}"
    return (
        f"{networks}{off}; {_level_text(proposed.reflection_db, f, carrier, floor_db=-40.0)}; all "
        f"parts off by {100.0 * TOLERANCE:g} % in the worst sense: "
        f"{_level_text(proposed.worst_db, f, carrier, floor_db=-40.0)}"
    )


def _off_text(proposed: ProposedFeed) -> str:
    """Return what the multiplexer does with the antennas that are not connected."""
    feed = proposed.feed
    end = complex(feed.off_resistance_ohm, feed.off_reactance_ohm)
    ends = {SHORT_OHM: "shorts the ways", OPEN_OHM: "leaves the ways open"}
    text = ends.get(end.real) if end.imag == 0.0 else None
    text = text or f"ends the ways with {end:g} ohm"
    cable = "" if feed.cable_m == 0.0 else f", each behind {1e3 * feed.cable_m:.3g} mm of line"
    return f"{text} that are not connected{cable}"


def _level_text(
    level_db: FloatArray, f: FloatArray, carrier: int, *, floor_db: float | None = None
) -> str:
    """Return the reflection at the carrier and over which band it is low enough, in words."""
    level = float(level_db[carrier])
    ratio = float(vswr(10.0 ** (0.1 * level)))
    least = floor_db is not None and level < floor_db
    shown = f"below {floor_db:g} dB" if least else f"up to {level:.1f} dB (VSWR {ratio:.2g})"
    text = f"reflection {shown} at {f[carrier] / 1e9:.4g} GHz"
    band = matched_band_hz(f, level_db, around_hz=float(f[carrier])) if len(f) > 1 else None
    if band is None:
        return text
    low, high = band
    if low == f[0] and high == f[-1]:
        return f"{text}, {MATCHED_DB:g} dB or less over the whole band"
    return (
        f"{text}, {MATCHED_DB:g} dB or less from {low / 1e9:.4g} to {high / 1e9:.4g} GHz "
        f"({(high - low) / 1e6:.3g} MHz)"
    )
