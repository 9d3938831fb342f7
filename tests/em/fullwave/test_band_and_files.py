"""What is made of solutions: bands, convergence studies, caches, Touchstone files."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from octant.em.fullwave import cache as cache_module
from octant.em.fullwave.band import FullwaveBand, solve_band
from octant.em.fullwave.cache import cached_solution, solution_key
from octant.em.fullwave.convergence import convergence_study, error_estimate
from octant.em.fullwave.mesh import reader_mesh
from octant.em.fullwave.single import dipole_mesh
from octant.em.fullwave.solve import solve_reader
from octant.em.fullwave.touchstone import write_touchstone
from octant.geometries.errors import AntennaError, GeometryError
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
CHANNELS_HZ = np.linspace(2.402e9, 2.480e9, 16)
THETA = np.radians(np.arange(0.0, 181.0, 5.0))


@pytest.fixture(scope="module")
def mesh():
    return reader_mesh(
        reader_body(antenna_radius_m=0.05), frequency_hz=2.44e9, cells_per_wavelength=7.0
    )


@pytest.fixture(scope="module")
def band(mesh):
    return solve_band(mesh, CHANNELS_HZ.tolist())


@pytest.mark.parametrize("channel", [1, 6, 11])
def test_between_the_solutions_a_band_equals_direct_solutions(mesh, band, channel):
    frequency_hz = float(CHANNELS_HZ[channel])
    assert np.abs(band.frequencies_hz - frequency_hz).min() > 1e6
    direct, between = solve_reader(mesh, frequency_hz=frequency_hz), band.at(frequency_hz)
    found = error_estimate(between, direct, finer_cells_per_wavelength=7.0)
    assert found.strong_db < 0.05
    assert found.weak_db < 0.05
    assert found.impedance < 1e-3
    np.testing.assert_allclose(between.s_matrix, direct.s_matrix, rtol=0.0, atol=1e-4)
    a, b = (r.pattern_grid(THETA, 24) for r in (between, direct))
    np.testing.assert_allclose(a, b, rtol=0.0, atol=2e-3)
    assert between.balance_error < 1e-2


def test_at_a_solved_frequency_a_band_is_that_solution(band):
    for solved in band.results:
        again = band.at(solved.frequency_hz)
        np.testing.assert_allclose(again.admittance_s, solved.admittance_s, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(again.far_field(1.0, 2.0), solved.far_field(1.0, 2.0), rtol=1e-9)


def test_bands_that_cannot_be_are_refused(band, mesh):
    with pytest.raises(AntennaError, match="was solved from"):
        band.at(2.5e9)
    with pytest.raises(AntennaError, match="at least two of each"):
        solve_band(mesh, [2.4e9])
    with pytest.raises(AntennaError, match="rising"):
        FullwaveBand(results=band.results[::-1])


def test_a_convergence_study_shows_differences_that_shrink():
    def solve(cells):
        return solve_reader(
            reader_mesh(
                reader_body(plate_height_m=0.04),
                frequency_hz=FREQUENCY_HZ,
                cells_per_wavelength=cells,
            )
        )

    study = convergence_study(solve, (5.0, 8.0, 12.0))
    coarse, middle, finest = study.results
    assert coarse.error.strong_db > middle.error.strong_db > 0.0
    assert finest.error is None
    assert len(study.lines()) == 3
    assert "to 1/12" in study.lines()[0]
    with pytest.raises(GeometryError, match="rising"):
        convergence_study(solve, (10.0, 5.0))


def test_a_cached_solution_is_the_same_bit_for_bit_and_solved_once(tmp_path, monkeypatch):
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    calls = []

    def counted(*args, **kwargs):
        calls.append(1)
        return solve_reader(*args, **kwargs)

    monkeypatch.setattr(cache_module, "solve_reader", counted)
    first, again = (cached_solution(mesh, tmp_path / "new") for _ in range(2))
    assert len(calls) == 1
    for name in ("admittance_s", "halves_a_per_m", "radiated_share"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
    assert np.array_equal(first.far_field(1.0, 2.0), again.far_field(1.0, 2.0))
    assert first.warnings == again.warnings
    (file,) = (tmp_path / "new").iterdir()
    file.write_bytes(file.read_bytes()[:100])  # cut short
    mended = cached_solution(mesh, tmp_path / "new")
    assert len(calls) == 2
    assert np.array_equal(mended.admittance_s, first.admittance_s)


def test_many_may_share_a_cache(tmp_path):
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: cached_solution(mesh, tmp_path), range(8)))
    assert all(np.array_equal(r.admittance_s, found[0].admittance_s) for r in found)
    assert [p.suffix for p in tmp_path.iterdir()] == [".npz"]


def test_every_input_changes_the_key():
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    keys = {
        solution_key(mesh),
        solution_key(mesh, frequency_hz=2.41e9),
        solution_key(mesh, load_ohm=75.0),
        solution_key(mesh, surface_impedance_ohm=1.0),
        solution_key(mesh, symmetry=False),
        solution_key(dipole_mesh(frequency_hz=FREQUENCY_HZ, feed_gap_m=0.001)),
        solution_key(dipole_mesh(frequency_hz=FREQUENCY_HZ, wire_radius_m=0.0004)),
    }
    assert len(keys) == 7
    assert solution_key(mesh, frequency_hz=FREQUENCY_HZ, load_ohm=50.0) in keys


def test_a_touchstone_file_reads_back_as_the_matrices(tmp_path, band):
    path = tmp_path / "reader.s8p"
    write_touchstone(path, band.results)
    lines = path.read_text().splitlines()
    assert lines[1] == "# Hz S RI R 50"
    numbers = [float(x) for line in lines if line[0] not in "!#" for x in line.split()]
    table = np.array(numbers).reshape(len(band.results), 1 + 2 * 64)
    np.testing.assert_allclose(table[:, 0], band.frequencies_hz)
    values = (table[:, 1::2] + 1j * table[:, 2::2]).reshape(-1, 8, 8)
    np.testing.assert_allclose(values, [r.s_matrix for r in band.results], atol=1e-12)


def test_touchstone_needs_one_resistance(tmp_path):
    result = solve_reader(dipole_mesh(frequency_hz=FREQUENCY_HZ), load_ohm=50.0 + 5.0j)
    with pytest.raises(AntennaError, match="one resistance"):
        write_touchstone(tmp_path / "a.s1p", [result])
    with pytest.raises(AntennaError, match="at least one"):
        write_touchstone(tmp_path / "a.s1p", [])


def test_surface_currents_carry_the_port_current_up_the_dipole():
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    result = solve_reader(mesh)
    density = result.surface_currents(0)
    corners = mesh.vertices_m[mesh.faces[result.basis.given_face]]
    middle = corners.mean(axis=1)
    near_feed = np.abs(middle[:, 2]) < 0.0027
    current_a = np.abs(density[near_feed, 2].mean()) * 4.0 * 0.0005
    source_v = np.sqrt(8.0 * 50.0)
    expected_a = abs(source_v / (50.0 + result.input_impedance_ohm[0]))
    assert current_a == pytest.approx(expected_a, rel=0.02)
