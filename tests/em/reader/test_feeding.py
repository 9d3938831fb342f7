"""Between antennas and receiver: against nodal analysis, closed forms and superposition."""

import math

import numpy as np
import pytest

from octant.em.antennas.pattern_files.touchstone import write_touchstone
from octant.em.reader.feeding import Cable, Feeding, Multiplexer
from octant.em.reader.fullwave._circuit import embedded_voltages, scattering
from octant.em.reader.fullwave.feeds import of_chain, renormalised
from octant.em.reader.ladders import Ladder
from octant.geometries.errors import AntennaError, PatternFileError

F_HZ = 2.4e9
N = 3


@pytest.fixture
def admittance_s():
    """Reciprocal and passive, as of three coupled antennas."""
    rng = np.random.default_rng(5)
    z = rng.normal(size=(2, N, N)) * 8.0
    z = 0.5 * (z + z.transpose(0, 2, 1))
    return np.linalg.inv(np.diag([70.0, 90.0, 120.0]) + z[0] + 1j * (np.diag([30, -20, 60]) + z[1]))


def feeds(**keys):
    keys = {"loads_ohm": (50.0 + 0j,), **keys}
    return Feeding(**keys).feeds_at(F_HZ, N)


def test_networks_and_complex_receivers_do_what_nodal_analysis_says(admittance_s):
    loads = (40.0 + 10.0j, 55.0 - 20.0j, 70.0 + 0j)
    texts = ("0.8 pF across, 6 nH in series", "5 nH in series, 0.5 pF across", "2 pF in series")
    quality = {"coil": 30.0, "capacitor": 200.0}
    ladders = tuple(Ladder.of_text(text).with_quality(**quality) for text in texts)
    made = feeds(loads_ohm=loads, ladders=ladders)
    voltages, at_receiver, current = made.driven(admittance_s)
    w = 2.0 * math.pi * F_HZ

    def coil(value):
        return 1j * w * value + w * value / 30.0

    def capacitor(value):
        return 1.0 / (1j * w * value) + 1.0 / (w * value) / 200.0

    # Nodes 0 to 2 at the antennas, 3 to 5 at the receivers.
    nodal = np.zeros((6, 6), dtype=complex)
    nodal[:3, :3] = admittance_s
    for i, (series, across) in enumerate(
        (
            (coil(6e-9), (0, capacitor(0.8e-12))),
            (coil(5e-9), (4, capacitor(0.5e-12))),
            (capacitor(2e-12), None),
        )
    ):
        nodal[[i, i + 3], [i, i + 3]] += 1.0 / series
        nodal[[i, i + 3], [i + 3, i]] -= 1.0 / series
        if across is not None:
            nodal[across[0], across[0]] += 1.0 / across[1]
        nodal[i + 3, i + 3] += 1.0 / loads[i]
    for j, load in enumerate(loads):
        source = np.zeros(6, dtype=complex)
        source[j + 3] = 1.0 / load
        v = np.linalg.solve(nodal, source)
        np.testing.assert_allclose(voltages[j], v[:3], rtol=1e-10)
        assert at_receiver[j] == pytest.approx(v[j + 3])
        assert current[j] == pytest.approx((1.0 - v[j + 3]) / load)
    # The ports before the receivers, for an S-matrix: nodes 3 to 5 without their loads.
    nodal[[3, 4, 5], [3, 4, 5]] -= 1.0 / np.array(loads)
    reduced = nodal[3:, 3:] - nodal[3:, :3] @ np.linalg.solve(nodal[:3, :3], nodal[:3, 3:])
    np.testing.assert_allclose(
        made.outer_scattering(admittance_s), scattering(reduced, np.array(loads)), atol=1e-12
    )


def test_a_matched_cable_takes_its_loss_and_turns_the_phase_and_nothing_else(admittance_s):
    cable = Cable(length_m=0.7, loss_db_per_m=2.0, loss_at_hz=0.25 * F_HZ, velocity=0.66)
    found, _, _ = feeds(cable=cable).driven(admittance_s)
    bare = embedded_voltages(admittance_s, np.full(N, 50.0 + 0j))
    turn = 2.0 * math.pi * F_HZ * 0.7 / (0.66 * 299792458.0)
    factor = 10.0 ** (-2.0 * 0.7 * 2.0 / 20.0) * np.exp(-1j * turn)  # twice the loss at 4 times f
    np.testing.assert_allclose(found, factor * bare, rtol=1e-10)


def test_a_quarter_wave_line_turns_impedances_over(admittance_s):
    cable = Cable(length_m=0.25 * 299792458.0 / F_HZ, velocity=1.0, impedance_ohm=75.0)
    one = admittance_s[:1, :1]
    made = Feeding(loads_ohm=(50.0 + 0j,), cable=cable).feeds_at(F_HZ, 1)
    _, volts, amperes = made.driven(one)
    assert volts[0] / amperes[0] == pytest.approx(75.0**2 * one[0, 0])


@pytest.mark.parametrize("off_ohm", [50.0 + 0j, 12.0 - 30.0j, 0j])
def test_a_multiplexer_ends_the_others_as_it_says(admittance_s, off_ohm):
    found, _, _ = feeds(multiplexer=Multiplexer(loss_db=1.5, off_ohm=off_ohm)).driven(admittance_s)
    for j in range(N):
        loads = np.full(N, off_ohm)
        loads[j] = 50.0
        expected = 10.0 ** (-1.5 / 20.0) * embedded_voltages(admittance_s, loads)[j]
        np.testing.assert_allclose(found[j], expected, rtol=1e-10, atol=1e-15)


def test_leakage_adds_the_other_antennas(admittance_s):
    found, _, _ = feeds(multiplexer=Multiplexer(loss_db=1.0, leakage_db=-30.0)).driven(admittance_s)
    bare = embedded_voltages(admittance_s, np.full(N, 50.0 + 0j))
    way, leak = 10.0 ** (-1.0 / 20.0), 10.0 ** (-30.0 / 20.0)
    for j in range(N):
        expected = leak * bare.sum(axis=0) + (way - leak) * bare[j]
        np.testing.assert_allclose(found[j], expected, rtol=1e-10, atol=1e-15)


def test_two_ports_of_files_are_what_they_were_made_of(admittance_s, tmp_path):
    ladder = Ladder.of_text("0.7 pF across, 3.3 nH in series, 1.2 pF across")
    s = of_chain(ladder.chain(F_HZ))
    at_75 = renormalised(s, np.full(2, 50.0 + 0j), np.full(2, 75.0 + 0j))
    write_touchstone(tmp_path / "net.s2p", [F_HZ], at_75[None], reference_ohm=75.0)
    cable = Cable(length_m=0.3, loss_db_per_m=1.0)
    more = {"cable": cable, "multiplexer": Multiplexer(loss_db=0.8, leakage_db=-40.0)}
    of_file = feeds(network_files=(str(tmp_path / "net.s2p"),), **more)
    of_parts = feeds(ladders=(ladder,), **more)
    for one, other in zip(of_file.driven(admittance_s), of_parts.driven(admittance_s), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9)
    skrf = pytest.importorskip("skrf")
    network = skrf.Network(str(tmp_path / "net.s2p"))
    network.renormalize(50.0)
    np.testing.assert_allclose(network.s[0], s, atol=1e-9)


def test_an_off_state_of_a_file_is_its_impedance(admittance_s, tmp_path):
    off = 8.0 - 200.0j
    write_touchstone(tmp_path / "off.s1p", [F_HZ], [[[(off - 50.0) / (off + 50.0)]]])
    of_file = Multiplexer(loss_db=1.0, off_file=str(tmp_path / "off.s1p"))
    given = Multiplexer(loss_db=1.0, off_ohm=off)
    one, other = (feeds(multiplexer=m).driven(admittance_s)[0] for m in (of_file, given))
    np.testing.assert_allclose(one, other, rtol=1e-9)


@pytest.mark.parametrize(
    ("s", "said"),
    [
        ([[0.1, 0.2], [0.9, 0.1]], "passes more one way"),
        ([[0.1, 2.0], [2.0, 0.1]], "gives out more than it is given"),
        ([[0.1]], "has 1 ports"),
    ],
)
def test_files_that_are_no_networks_are_refused(tmp_path, s, said):
    path = tmp_path / f"bad.s{len(s)}p"
    write_touchstone(path, [F_HZ], np.array(s)[None])
    with pytest.raises(PatternFileError, match=said):
        feeds(network_files=(str(path),))


def test_a_multiplexer_that_would_amplify_is_refused():
    with pytest.raises(AntennaError, match="raise its loss"):
        feeds(multiplexer=Multiplexer(loss_db=0.0, leakage_db=-20.0))
