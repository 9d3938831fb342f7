"""Matching: against closed forms, textbook examples and circuits worked out another way."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from octant.em.reader.ladders import Ladder, Part, l_networks, pi_networks
from octant.em.reader.matching import (
    Match,
    best_real_load_ohm,
    conjugate_match_ohm,
    match_reader,
    matched_band_hz,
    port_reflection_db,
    vswr,
)
from octant.geometries.errors import AntennaError

FREQUENCY_HZ = 500e6


def reflection(z, r0):
    return abs((z - r0) / (z + r0))


def test_the_textbook_example():
    # Pozar, Microwave Engineering, example 5.1: 200 - j100 ohm to 100 ohm at 500 MHz.
    values = {
        tuple(part.kind for _, part in n.parts): tuple(part.value for _, part in n.parts)
        for n in l_networks(200 - 100j, source_ohm=100.0, frequency_hz=FREQUENCY_HZ)
    }
    assert values["C", "L"] == pytest.approx((0.92e-12, 38.8e-9), rel=0.01)
    assert values["L", "C"] == pytest.approx((46.1e-9, 2.61e-12), rel=0.01)


@given(
    st.floats(1.0, 2000.0), st.floats(-2000.0, 2000.0), st.floats(5.0, 500.0), st.floats(1e8, 6e9)
)
@example(7.0, 1.4e-45, 7.0, 1e8)
def test_every_network_matches_and_there_is_one(r, x, r0, frequency_hz):
    found = l_networks(complex(r, x), source_ohm=r0, frequency_hz=frequency_hz)
    higher = max((r * r + x * x) / r, r0)
    lower = min((r * r + x * x) / r, r0)
    quality = 2.0 * math.sqrt(higher / lower)
    bridges = pi_networks(complex(r, x), source_ohm=r0, frequency_hz=frequency_hz, quality=quality)
    assert len(bridges) >= 2
    for network in found + bridges:
        w = 2j * math.pi * frequency_hz
        z = complex(r, x)
        for place, part in network.parts:
            own = w * part.value if part.kind == "L" else 1 / (w * part.value)
            z = z + own if place == "in series" else z * own / (z + own)
        assert reflection(z, r0) < 1e-6
        seen = network.seen_by_source_ohm(frequency_hz, antenna_ohm=complex(r, x))
        assert complex(seen) == pytest.approx(z, rel=1e-9)
        back = complex(network.seen_by_antenna_ohm(frequency_hz, source_ohm=r0))
        assert back == pytest.approx(complex(r, -x), rel=1e-5, abs=1e-5 * abs(complex(r, x)))
    if abs(x) > 1e-3 * r:
        assert found


def test_vswr_of_a_resistance_is_its_ratio():
    for r in (10.0, 50.0, 121.0):
        assert vswr(reflection(r, 50.0) ** 2) == pytest.approx(max(r / 50.0, 50.0 / r))
    assert vswr(1.0) == math.inf


def test_the_band_of_a_straight_level_ends_where_it_crosses():
    f = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    level = np.array([-4.0, -8.0, -16.0, -12.0, -12.0])
    assert matched_band_hz(f, level, around_hz=3.0) == pytest.approx((2.25, 5.0))
    assert matched_band_hz(f, level, around_hz=2.0) is None
    assert matched_band_hz(f, level, around_hz=6.0) is None


def test_the_best_real_load_of_one_port_is_the_size_of_its_impedance():
    z = 120.0 - 80.0j
    found = best_real_load_ohm(np.array([[[1.0 / z]]]))
    assert found == pytest.approx(abs(z), rel=1e-4)
    level = port_reflection_db(np.array([[[1.0 / z]]]), found)
    assert level[0, 0] == pytest.approx(20 * math.log10(reflection(z, abs(z))))


def coupled(z_self=75.0 + 42.0j, z_mutual=20.0 - 30.0j):
    return np.linalg.inv(np.array([[z_self, z_mutual], [z_mutual, z_self]]))


def test_two_equal_coupled_antennas_are_matched_as_the_closed_form_says():
    # Simultaneous conjugate match of a symmetric two-port (Gonzalez, 3.6): with
    # Z = Z11 - Z12² / (Z11 + Z*), found here by bisection-free algebra in r and x.
    seen = conjugate_match_ohm(coupled())
    z11, z12 = 75.0 + 42.0j, 20.0 - 30.0j
    np.testing.assert_allclose(seen, z11 - z12**2 / (z11 + np.conj(seen)), rtol=1e-8)
    r11, x11, r12, x12 = z11.real, z11.imag, z12.real, z12.imag
    theta = math.sqrt((1 - (r12 / r11) ** 2) * (1 + (x12 / r11) ** 2))
    expected = r11 * theta + 1j * (x11 - r12 * x12 / r11)  # Roberts (1946)
    np.testing.assert_allclose(seen, expected, rtol=1e-8)


def test_networks_on_coupled_ports_match_both_and_hold_over_the_band():
    y = coupled()
    match = match_reader(y[None], FREQUENCY_HZ, at_hz=FREQUENCY_HZ, source_ohm=50.0)
    assert match.reflection_db(y[None], [FREQUENCY_HZ]).max() < -80.0
    # Off the frequency, by chain matrices instead of loads: drive port 1, end port 2.
    f = 1.1 * FREQUENCY_HZ
    network = match.networks[0]
    end = complex(network.seen_by_antenna_ohm(f, source_ohm=50.0))
    z = np.linalg.inv(y)
    z_in = z[0, 0] - z[0, 1] ** 2 / (z[1, 1] + end)
    expected = reflection(complex(network.seen_by_source_ohm(f, antenna_ohm=z_in)), 50.0)
    found = match.reflection_db(y[None], [f])[0, 0]
    assert found == pytest.approx(20 * math.log10(expected), abs=1e-6)


def test_parts_of_the_e24_series_are_the_nearest():
    assert Part(kind="L", value=5.05e-9).e24().value == pytest.approx(5.1e-9)
    assert Part(kind="C", value=0.97e-12).e24().value == pytest.approx(1.0e-12)
    assert Part(kind="C", value=0.97e-12).e24(-1).value == pytest.approx(0.91e-12)
    assert Part(kind="C", value=9.1e-12).e24(1).value == pytest.approx(10e-12)
    ladder = Ladder.of_text("3.7 nH in series, 0.4 pF across")
    assert str(ladder.nearest_e24) == "3.6 nH in series, 0.39 pF across"


def test_bought_parts_are_the_best_of_those_around_and_their_errors_are_counted():
    y, f = coupled()[None], [FREQUENCY_HZ]
    match = match_reader(y, f, at_hz=FREQUENCY_HZ, source_ohm=50.0)
    bought = match.bought(y, f)
    level = float(bought.reflection_db(y, f).max())
    near = [[part.e24(step).value for step in (-1, 0, 1)] for _, part in match.networks[0].parts]
    kinds = match.networks[0].kind
    tried = []
    for values in itertools.product(*near):
        text = ", ".join(
            f"{1e9 * v:.6g} nH {place}" if kind == "L" else f"{1e12 * v:.6g} pF {place}"
            for v, (place, kind) in zip(values, kinds, strict=True)
        )
        one = Match(networks=(Ladder.of_text(text),) * 2, source_ohm=50.0)
        tried.append(float(one.reflection_db(y, f).max()))
    assert level == pytest.approx(min(tried), abs=1e-6)
    # All parts at both ends of 5 %, one after another.
    ends = []
    for factors in itertools.product((0.95, 1.05), repeat=2):
        parts = tuple(
            Part(kind=part.kind, value=k * part.value)
            for k, (_, part) in zip(factors, bought.networks[0].parts, strict=True)
        )
        one = Match(networks=(bought.networks[0].of_parts(parts),) * 2, source_ohm=50.0)
        ends.append(float(one.reflection_db(y, f).max()))
    assert bought.worst_db(y, f, tolerance=0.05)[0] == pytest.approx(max(ends))


def test_one_network_for_unequal_antennas_is_the_best_of_its_kind():
    y = np.diag([1.0 / (190 + 60j), 1.0 / (220 + 40j)])[None]
    f = [FREQUENCY_HZ]
    match = match_reader(y, f, at_hz=FREQUENCY_HZ, source_ohm=50.0)
    assert len(match.different) == 2
    one = match.alike.bought(y, f)
    assert len(one.different) == 1
    level = one.reflection_db(y, f).max()
    both = [Match(networks=(n, n), source_ohm=50.0) for n in match.networks]
    assert level < min(each.reflection_db(y, f).max() for each in both)


@pytest.mark.parametrize("text", ["", "3 nH", "3 nF in series, 2", "0 pF across", "-1 pF across"])
def test_texts_that_are_no_networks_are_refused(text):
    with pytest.raises(AntennaError, match="is no network"):
        Ladder.of_text(text)


def test_an_antenna_without_resistance_is_refused():
    with pytest.raises(AntennaError, match="resistance must be above 0"):
        l_networks(-3.0 + 1.0j, source_ohm=50.0, frequency_hz=1e9)
    assert conjugate_match_ohm(np.array([[1j]])) is None
