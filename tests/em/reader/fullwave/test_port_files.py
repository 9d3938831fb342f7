"""Touchstone files at the ports: loads and networks, and what a solution makes of them."""

import numpy as np
import pytest

import octant
from octant.em.antennas.pattern_files.touchstone import write_touchstone
from octant.em.reader.fullwave.port_files import loads_of_file, network_of_file
from octant.geometries.errors import PatternFileError, PhysicsWarning

F_HZ = 2.4e9
BAND = [2.3e9, 2.5e9]


@pytest.fixture(scope="module")
def solved():
    reader = octant.Reader(
        antennas=4,
        antenna_radius_m=0.08,
        plate_height_m=0.0,
        cells_per_wavelength=5,
    )
    return reader.solve(F_HZ, step_deg=30, progress=False)


def of_one(path, z_ohm, reference_ohm=50.0):
    z = np.asarray(z_ohm, dtype=complex).reshape(-1, 1, 1)
    s = (z - reference_ohm) / (z + reference_ohm)
    write_touchstone(path, BAND if len(z) == 2 else [F_HZ], s, reference_ohm=reference_ohm)
    return path


@pytest.mark.parametrize("reference_ohm", [50.0, 75.0])
def test_a_load_is_the_impedance_of_its_reflection(reference_ohm, tmp_path):
    path = of_one(tmp_path / "a.s1p", 30.0 - 12.0j, reference_ohm)
    np.testing.assert_allclose(loads_of_file(path, F_HZ, ports=3), [30.0 - 12.0j] * 3, rtol=1e-13)


def test_between_its_frequencies_a_files_reflection_is_interpolated(tmp_path):
    path = of_one(tmp_path / "a.s1p", [40.0, 60.0 + 8.0j])
    mean = 0.5 * sum((z - 50.0) / (z + 50.0) for z in (40.0, 60.0 + 8.0j))
    (load,) = loads_of_file(path, F_HZ, ports=1)
    assert load == pytest.approx(50.0 * (1.0 + mean) / (1.0 - mean))
    for f_hz, z in zip(BAND, (40.0, 60.0 + 8.0j), strict=True):
        assert loads_of_file(path, f_hz, ports=1)[0] == pytest.approx(z)


def test_a_reader_with_the_loads_of_a_file_is_the_reader_with_these_loads(solved, tmp_path):
    same = solved.loaded(of_one(tmp_path / "same.s1p", 50.0))
    np.testing.assert_allclose(same.s.values, solved.s.values, atol=1e-13)
    np.testing.assert_allclose(same.pattern.values, solved.pattern.values, atol=1e-12)
    found = solved.loaded(of_one(tmp_path / "other.s1p", 72.0))
    other = octant.Reader(
        antennas=4, antenna_radius_m=0.08, plate_height_m=0.0, cells_per_wavelength=5, load_ohm=72.0
    ).solve(F_HZ, step_deg=30, progress=False)
    np.testing.assert_allclose(found.s.values, other.s.values, atol=1e-12)
    np.testing.assert_allclose(found.z.values, other.z.values, rtol=1e-10)
    np.testing.assert_allclose(found.pattern.values, other.pattern.values, atol=1e-11)
    assert "loads of" in next(iter(found.lines()))
    assert "other.s1p" in next(iter(found.lines()))


def test_complex_loads_that_match_take_most_and_keep_the_power_balance(solved, tmp_path):
    z = solved.z.values[0].mean()
    matched = solved.loaded(of_one(tmp_path / "a.s1p", z.conj()))
    for one, other in zip(matched.results, solved.results, strict=True):
        assert one.reflected_share.max() < other.reflected_share.max()
        np.testing.assert_allclose(
            one.radiated_share + one.lost_share, one.accepted_share, rtol=5e-3
        )


def test_the_readers_own_network_comes_back_from_its_file(solved, tmp_path):
    file = solved.to_touchstone(tmp_path / "reader")
    again = solved.with_network(file)
    np.testing.assert_allclose(again.s.values, solved.s.values, atol=1e-12)
    np.testing.assert_allclose(again.pattern.values, solved.pattern.values, atol=1e-10)
    # at another reference, as scikit-rf writes it, it is the same network
    skrf = pytest.importorskip("skrf")
    network = skrf.Network(str(file))
    network.renormalize(75.0)
    network.write_touchstone("at75", dir=str(tmp_path))
    other = solved.with_network(tmp_path / "at75.s4p")
    np.testing.assert_allclose(other.s.values, solved.s.values, atol=1e-9)
    # what is written stands at load_ohm, whatever the loads
    loaded = solved.loaded(of_one(tmp_path / "a.s1p", 20.0 + 30.0j))
    assert loaded.to_touchstone(tmp_path / "b").read_bytes() == file.read_bytes()


def test_a_measured_network_that_does_not_fit_is_warned_of(solved, tmp_path):
    s = solved.s.values * 0.5
    write_touchstone(tmp_path / "a.s4p", [F_HZ], s)
    with pytest.warns(PhysicsWarning, match=r"a\.s4p: radiated and accepted power"):
        solved.with_network(tmp_path / "a.s4p")


@pytest.mark.parametrize(
    ("s", "f_hz", "said"),
    [
        ([[[1.2]]], F_HZ, "above 0 ohm"),
        ([[[1.0]]], F_HZ, "open end"),
        ([[[0.0]]], 5e9, "goes from"),
        ([np.diag([0.1, 0.2])], F_HZ, "1 or 4 are needed"),
        ([np.full((4, 4), 0.2)], F_HZ, "couples its ports"),
    ],
)
def test_files_that_are_no_loads_are_refused(s, f_hz, said, tmp_path):
    s = np.array(s)
    path = tmp_path / f"bad.s{s.shape[1]}p"
    write_touchstone(path, [F_HZ], s)
    with pytest.raises(PatternFileError, match=said):
        loads_of_file(path, f_hz, ports=4)
    if s.shape[1] != 4:
        with pytest.raises(PatternFileError, match=r"ports|goes from"):
            network_of_file(path, f_hz, ports=4)
