"""Many networks that match a reader, and the one among them that a judge likes best.

Antennas that are not connected act on the pattern of the one that is, by what ends them: with a
multiplexer that is free, apart from the match. So the candidates are many, and each is a little
network algebra.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.feeding import Cable, Feeding
from octant.em.reader.ladders import Ladder, l_networks, pi_networks
from octant.em.reader.matching import (
    MATCHED_DB,
    PI_QUALITIES,
    Match,
    OffState,
    conjugate_match_ohm,
    networks_by_kind,
)

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

OPEN_OHM, SHORT_OHM = 1e6, 0.0
"""What reflective multiplexers end antennas with that are not connected [ohm]."""
_ROUNDS, _SETTLED = 30, 1e-6
_STARTS = 3
_BETTER = 1e-9


def off_states(feeding: Feeding | None, frequency_hz: float) -> tuple[OffState | None, ...]:
    """Return what may be done with the antennas that are not connected.

    Parameters
    ----------
    feeding : What is there already: its cable and multiplexer are kept; None: nothing.
    frequency_hz : Where a line added to a multiplexer's ways turns the phase by an eighth [Hz].

    Returns
    -------
    tuple of OffState or None
        None stands for receivers of their own.
    """
    there = None if feeding is None else feeding.multiplexer
    own = None if feeding is None else feeding.cable
    if there is not None:
        return (OffState(off_ohm=there.off_ohm, cable=own),)
    velocity = Cable(length_m=0.0).velocity
    eighth_m = round(velocity * SPEED_OF_LIGHT_M_PER_S / (8.0 * frequency_hz), 4)
    cables = (None, Cable(length_m=eighth_m)) if own is None else (own,)
    ends = (OPEN_OHM, SHORT_OHM)
    return (None, *(OffState(off_ohm=end, cable=cable) for end in ends for cable in cables))


def all_matches(
    admittance_s: ComplexArray,
    *,
    at_hz: float,
    source_ohm: float,
    off: Iterable[OffState | None],
) -> Iterator[Match]:
    """Yield L- and Pi-networks that match all ports at one frequency, with parts of any value.

    Parameters
    ----------
    admittance_s : (n, n) complex128 — Admittances of the ports there [S].
    at_hz, source_ohm : Frequency [Hz]; source and load [ohm].
    off : What becomes of the antennas that are not connected.
    """
    seen = conjugate_match_ohm(admittance_s)
    if seen is None:
        return

    def l_of(z: complex) -> tuple[Ladder, ...]:
        return l_networks(z, source_ohm=source_ohm, frequency_hz=at_hz)

    def pi_of(quality: float) -> Callable[[complex], tuple[Ladder, ...]]:
        return lambda z: pi_networks(z, source_ohm=source_ohm, frequency_hz=at_hz, quality=quality)

    for state in off:
        for of_port in (l_of, *map(pi_of, PI_QUALITIES[::2])):
            for kind, networks in networks_by_kind([of_port(complex(z)) for z in seen]).items():
                start = Match(networks=networks, source_ohm=source_ohm, off=state)
                found = (
                    start if state is None else _settled(start, kind, admittance_s, at_hz, of_port)
                )
                if found is not None:
                    yield found


def _settled(
    match: Match,
    kind: tuple[object, int],
    admittance_s: ComplexArray,
    at_hz: float,
    of_port: Callable[[complex], tuple[Ladder, ...]],
) -> Match | None:
    """Return the networks that match what each antenna shows while they end the others."""
    before = np.full(len(match.networks), np.inf + 0j)
    for _ in range(_ROUNDS):
        seen = match.seen_ohm(admittance_s, at_hz)
        if not (np.isfinite(seen).all() and (seen.real > 0.0).all()):
            return None
        if float(np.abs(seen - before).max()) <= _SETTLED * float(np.abs(seen).max()):
            return match
        by_value = {z: of_port(z) for z in map(complex, seen)}
        networks = networks_by_kind([by_value[complex(z)] for z in seen]).get(kind)
        if networks is None:
            return None
        match, before = replace(match, networks=networks), seen
    return None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chosen:
    """Networks of E24 values that a judge likes best.

    Parameters
    ----------
    match, cost : The networks, and what the judge says of them [-].
    tried : How many candidates reach the level over the band [-].
    """

    match: Match
    cost: float
    tried: int


def chosen_match(
    candidates: Iterable[Match],
    admittance_s: ComplexArray,
    frequencies_hz: npt.ArrayLike,
    *,
    judge: Callable[[Match], float],
    tolerance: float,
) -> Chosen | None:
    """Return the best match of E24 values with at most `MATCHED_DB` over a band; None without any.

    The candidates with the nearest values come first; from the best of them the search goes on part
    by part to the values beside them, as long as that is better. If any of the best hold the level
    with parts at the ends of their tolerance, so does what is returned.

    Parameters
    ----------
    candidates : Networks of any values.
    admittance_s, frequencies_hz : (f, n, n) admittances [S] at frequencies, (f,) [Hz].
    judge : Cost of a match [-]; the least is best.
    tolerance : Greatest relative error of a part [-].
    """
    f = np.atleast_1d(np.asarray(frequencies_hz, dtype=np.float64))

    def reached(match: Match) -> bool:
        return float(match.reflection_db(admittance_s, f).max()) <= MATCHED_DB

    def safe(match: Match) -> bool:
        worst_db = match.worst_db(admittance_s, f, tolerance=tolerance)
        return float(worst_db.max()) <= MATCHED_DB

    every = [match.nearest_e24 for match in candidates]
    rounded = {(match.off, tuple(map(str, match.networks))): match for match in every}
    able = [(judge(match), match) for match in rounded.values() if reached(match)]
    if not able:
        return None
    able.sort(key=lambda pair: pair[0])
    held = [pair for pair in able if safe(pair[1])]
    climbs = [
        _climbed(cost, match, allowed=safe if held else reached, judge=judge)
        for cost, match in (held or able)[:_STARTS]
    ]
    best = min(climbs, key=lambda one: one.cost)
    return replace(best, tried=len(able) + sum(one.tried for one in climbs))


def _climbed(
    cost: float,
    match: Match,
    *,
    allowed: Callable[[Match], bool],
    judge: Callable[[Match], float],
) -> Chosen:
    """Return where single steps of parts lead that are allowed and better; with steps tried [-]."""
    best, tried = Chosen(match=match, cost=cost, tried=0), 0
    better = True
    while better:
        better = False
        for near in best.match.neighbours():
            if not allowed(near):
                continue
            tried += 1
            near_cost = judge(near)
            if near_cost < best.cost - _BETTER:
                best, better = Chosen(match=near, cost=near_cost, tried=0), True
                break
    return replace(best, tried=tried)
