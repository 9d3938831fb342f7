"""Networks for antennas behind a multiplexer: against the algebra of S-matrices of a whole feed."""

import numpy as np
import pytest

from octant.em.reader.feeding import Cable, Feeding, Multiplexer
from octant.em.reader.fullwave.far_field import FarField
from octant.em.reader.fullwave.loads import LoadedReader, UnloadedReader
from octant.em.reader.ladders import Ladder
from octant.em.reader.match_search import (
    OPEN_OHM,
    SHORT_OHM,
    all_matches,
    chosen_match,
    off_states,
)
from octant.em.reader.matching import Match, OffState

F_HZ = 2.4e9
LINE = Cable(length_m=0.02, velocity=0.66)
N = 4


def ports(frequency_hz=F_HZ):
    """Four coupled antennas of two kinds around an axis, each resonant near the frequency."""
    z = np.full((N, N), 4.0 - 6.0j) + np.diag([180.0, 150.0] * 2).astype(complex)
    detuned = frequency_hz / F_HZ - F_HZ / frequency_hz
    for i in range(N):
        z[i, i - 1] = z[i - 1, i] = -25.0 + 10.0j
        z[i, i] += 1j * (40.0 + 300.0 * detuned)
    return LoadedReader(
        unloaded=UnloadedReader(
            frequency_hz=frequency_hz,
            admittance_s=np.linalg.inv(z),
            heat_s=np.zeros((N, N), dtype=complex),
            shorted_v=FarField(values=np.zeros((N, 3, 4, 2), dtype=complex)),
            phase_centres_m=np.zeros((N, 3)),
            unknowns=1,
        ),
        load_ohm=np.full(N, 50.0 + 0j),
    )


OFF = [
    None,
    OffState(off_ohm=OPEN_OHM),
    OffState(off_ohm=SHORT_OHM, cable=LINE),
    OffState(off_ohm=30.0 - 70.0j, cable=LINE),
]


@pytest.mark.parametrize("off", OFF)
def test_the_reflection_of_a_match_is_that_of_the_feed_it_stands_for(off):
    texts = ("0.5 pF across, 6 nH in series", "7 nH in series, 0.3 pF across")
    match = Match(networks=tuple(map(Ladder.of_text, texts)) * 2, source_ohm=50.0, off=off)
    band = [ports(f) for f in (2.3e9, 2.5e9)]
    found = match.reflection_db(np.stack([one.admittance_s for one in band]), (2.3e9, 2.5e9))
    # Written out here: the match's own way to a feed is checked with it.
    behind = {} if off is None else {"multiplexer": Multiplexer(loss_db=0.0, off_ohm=off.off_ohm)}
    if off is not None and off.cable is not None:
        behind["cable"] = off.cable
    feed = Feeding(loads_ohm=(50.0 + 0j,), ladders=match.networks, **behind)
    for one, level_db in zip(band, found, strict=True):
        expected = 10.0 * np.log10(feed.on(one).reflected_share)
        np.testing.assert_allclose(level_db, expected, atol=1e-6)
        same = match.feeding().on(one).reflected_share
        np.testing.assert_allclose(10.0 * np.log10(same), expected, atol=1e-6)


@pytest.mark.parametrize("off", OFF[:3])
def test_every_candidate_matches_all_antennas_while_the_others_are_off(off):
    one = ports()
    found = list(all_matches(one.admittance_s, at_hz=F_HZ, source_ohm=50.0, off=(off,)))
    assert {len(match.networks[0].parts) for match in found} == {2, 3}
    for match in found:
        assert match.feeding().on(one).reflected_share.max() < 1e-8


def test_the_choice_costs_no_more_than_any_candidate_and_any_step_beside_it():
    f = np.array([2.38e9, 2.4e9, 2.42e9])
    y = np.stack([ports(one).admittance_s for one in f])
    every = list(all_matches(y[1], at_hz=F_HZ, source_ohm=50.0, off=off_states(None, F_HZ)))

    def judge(match):  # some smooth cost that is not the reflection
        values = [part.value for _, part in match.networks[0].parts]
        return sum((1e9 * value - 4.0) ** 2 + value for value in values)

    chosen = chosen_match(every, y, f, judge=judge, tolerance=0.05)

    def able(match):
        return match.worst_db(y, f, tolerance=0.05).max() <= -10.0

    assert able(chosen.match)
    assert str(chosen.match.networks[0]) == str(chosen.match.nearest_e24.networks[0])
    beside = [*chosen.match.neighbours(), *(match.nearest_e24 for match in every)]
    tried = [judge(match) for match in beside if able(match)]
    assert len(tried) > 5
    assert chosen.cost <= min(tried) + 1e-9
    assert chosen.cost < np.median(tried)


def test_what_is_there_already_is_kept():
    there = Feeding(
        loads_ohm=(50.0 + 0j,),
        cable=LINE,
        multiplexer=Multiplexer(loss_db=1.0, off_ohm=75.0 + 0j),
    )
    assert off_states(there, F_HZ) == (OffState(off_ohm=75.0 + 0j, cable=LINE),)
    only_cable = off_states(Feeding(loads_ohm=(50.0 + 0j,), cable=LINE), F_HZ)
    assert {None if state is None else state.cable for state in only_cable} == {None, LINE}
    assert len(off_states(None, F_HZ)) == 5


def test_where_no_feed_reaches_the_level_none_is_chosen():
    wide = np.array([1.6e9, 2.4e9, 3.2e9])
    y = np.stack([ports(one).admittance_s for one in wide])
    every = list(all_matches(y[1], at_hz=F_HZ, source_ohm=50.0, off=(None,)))
    assert every
    assert chosen_match(every, y, wide, judge=lambda _: 0.0, tolerance=0.05) is None
