"""Whether ports are matched, in sentences: numbers worked out here from circuits."""

import math
import re
import tomllib

import numpy as np
import pytest

from octant.em.reader.ladders import Ladder
from octant.reader_design.showing.matching_lines import matching_lines

F_HZ = np.linspace(2.3e9, 2.5e9, 41)


def lines_of(z, *, at_hz=2.4e9, load_ohm=50.0):
    y = 1.0 / np.broadcast_to(np.asarray(z, dtype=complex), F_HZ.shape)
    return list(matching_lines(y[:, None, None], F_HZ, at_hz=at_hz, load_ohm=load_ohm))


def test_a_matched_port_says_its_level_and_band():
    (line,) = lines_of(70.0)
    level = 20 * math.log10(20 / 120)
    assert line == (
        f"Matched to 50 ohm: reflection up to {level:.1f} dB (VSWR 1.4) at 2.4 GHz, -10 dB or less "
        "over the whole band."
    )


def test_a_resonant_port_is_matched_between_the_frequencies_where_it_crosses():
    # Series resonance of 50 ohm with Q = 20: |Γ| = -10 dB where the reactance is 2/3 of 50 ohm.
    q = 20.0
    z = 50.0 * (1.0 + 1j * q * (F_HZ / 2.4e9 - 2.4e9 / F_HZ))
    (line,) = lines_of(z)
    low, high = (float(x) for x in re.search(r"from ([\d.]+) to ([\d.]+) GHz", line).groups())
    half = 2.0 / 3.0 / q / 2.0
    assert (low, high) == pytest.approx((2.4 * (1 - half), 2.4 * (1 + half)), abs=0.002)
    assert "below" not in line


def test_a_port_that_is_matched_at_the_carrier_only_is_told_what_matches_the_band():
    z = 95.0 * (1.0 + 2j * (F_HZ / 2.4e9 - 2.4e9 / F_HZ))
    first, network, *_ = lines_of(z)
    assert first.startswith("Matched to 50 ohm")
    assert "whole band" not in first
    assert "less over the whole band" in network


def test_what_would_match_is_named_and_holds():
    z = 213.0 + 59.0j
    first, load, network, bought, key = lines_of(z)
    level = 20 * math.log10(abs((z - 50) / (z + 50)))
    assert first.startswith(f"Not matched to 50 ohm: reflection up to {level:.1f} dB (VSWR 4.6)")
    assert f"is {abs(z):.3g} ohm (reader.load_ohm)" in load
    found = re.search(r": ([\d.]+) (nH|pF) across, ([\d.]+) (nH|pF) in series;", network)
    w = 2j * math.pi * 2.4e9
    shunt, series = (
        w * float(value) * 1e-9 if unit == "nH" else 1 / (w * float(value) * 1e-12)
        for value, unit in (found.groups()[:2], found.groups()[2:])
    )
    seen = series + 1 / (1 / z + 1 / shunt)
    assert abs((seen - 50) / (seen + 50)) < 0.01
    assert "below -40 dB at 2.4 GHz" in network
    assert "E24" in bought
    ladder = Ladder.of_text(tomllib.loads(key.partition("[reader.feed] ")[2])["match"][0])
    bought_db = re.search(r"series: reflection up to (-[\d.]+) dB", bought)[1]
    seen = complex(ladder.seen_by_source_ohm(2.4e9, antenna_ohm=z))
    assert 20 * math.log10(abs((seen - 50) / (seen + 50))) == pytest.approx(
        float(bought_db), abs=0.06
    )


def test_ports_that_only_react_have_no_network():
    last = lines_of(1e-9 + 30.0j)[-1]
    assert last == "No network of coils and capacitors matches all ports at once."
