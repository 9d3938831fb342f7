"""What is made of solutions: bands, convergence studies, surface currents."""

import numpy as np
import pytest

from octant.em.reader.fullwave.band import FullwaveBand, solve_band, solve_band_adaptively
from octant.em.reader.fullwave.convergence import convergence_study, error_estimate
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.single import dipole_mesh
from octant.em.reader.fullwave.solve import solve_reader
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


def test_a_wide_band_is_sampled_until_it_is_predicted_within_60_db():
    # 201 frequencies over more than an octave, each solved by itself too.
    mesh = dipole_mesh(frequency_hz=3.5e9, cells_per_wavelength=6.0)
    wanted = np.linspace(1.5e9, 3.5e9, 201)
    calls = []
    band = solve_band_adaptively(mesh, wanted.tolist(), progress=calls.append)
    assert calls == list(range(1, len(band.results) + 1))
    assert len(band.results) < 12
    assert band.error < 1e-3
    for frequency_hz in wanted:
        direct = solve_reader(mesh, frequency_hz=float(frequency_hz))
        between = band.at(float(frequency_hz))
        assert np.abs(between.s_matrix - direct.s_matrix).max() < 1e-3
    assert np.abs(band.at(1.5e9).s_matrix - band.results[0].s_matrix).max() < 1e-12


def test_a_band_of_few_frequencies_is_those():
    mesh = dipole_mesh(frequency_hz=2.48e9, cells_per_wavelength=6.0)
    band = solve_band_adaptively(mesh, [2.48e9, 2.402e9])
    assert band.frequencies_hz.tolist() == [2.402e9, 2.48e9]


@pytest.mark.slow
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
