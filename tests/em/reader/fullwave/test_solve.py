"""Laws that every solution must keep: reciprocity, energy, symmetry, convergence, determinism."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from octant.em.blocks import THREADS_VARIABLE
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.basis import surface_basis
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.em.reader.fullwave.single import dipole_mesh
from octant.em.reader.fullwave.solve import excitations, port_step_of, solve_reader
from octant.geometries.bodies import Body
from octant.geometries.errors import AntennaError, GeometryError
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
DESIGNS = (
    "dipole_r10_h8",
    "dipole_r5_h8",
    "dipole_r10_h0",
    "round100_dipole_r10_h8",
    "monopole0_r10_h8",
)
THETA = np.radians(np.arange(0.0, 181.0, 10.0))


def coarse_mesh(**changes):
    body = reader_body(plate_height_m=0.04, **changes)
    return reader_mesh(body, frequency_hz=FREQUENCY_HZ, cells_per_wavelength=6.0)


@pytest.mark.parametrize("name", DESIGNS)
def test_the_scattering_matrix_is_symmetric_and_passive(solved, name):
    s = solved(name).s_matrix
    np.testing.assert_allclose(s, s.T, rtol=0.0, atol=1e-6)
    assert np.linalg.norm(s, 2) < 1.0


@pytest.mark.parametrize("name", DESIGNS)
def test_radiated_power_is_accepted_power(solved, name):
    assert solved(name).balance_error < 1e-3


@pytest.mark.parametrize("name", DESIGNS)
def test_a_quarter_turn_of_the_square_reader_moves_the_antennas_on_by_two(solved, name):
    result = solved(name)
    phi = np.radians(np.arange(0.0, 360.0, 10.0))
    pattern = result.far_field(THETA[:, None], phi)
    moved = np.roll(np.roll(pattern, 2, axis=0), 9, axis=2)
    np.testing.assert_allclose(moved, pattern, rtol=0.0, atol=1e-9)


def test_an_eighth_of_a_turn_of_the_round_reader_moves_the_antennas_on_by_one(solved):
    result = solved("round100_dipole_r10_h8")
    assert result.basis.sectors == 8
    phi = np.radians(np.arange(0.0, 360.0, 5.0))
    pattern = result.far_field(THETA[:, None], phi)
    moved = np.roll(np.roll(pattern, 1, axis=0), 9, axis=2)
    np.testing.assert_allclose(moved, pattern, rtol=0.0, atol=1e-9)
    grid = result.pattern_grid(THETA, 72)
    np.testing.assert_allclose(grid, pattern, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("shape", ["square", "round"])
def test_the_solution_by_rotational_modes_is_the_plain_one(shape):
    mesh = coarse_mesh(ground_plane_shape=shape, antenna_radius_m=0.09)
    fast, plain = solve_reader(mesh), solve_reader(mesh, symmetry=False)
    assert fast.basis.sectors == (8 if shape == "round" else 4)
    assert plain.basis.sectors == 1
    # Far fields are then those of one sector's ports, turned.
    assert port_step_of(excitations(fast.basis, mesh)) == 8 // fast.basis.sectors
    assert fast.unknowns == plain.unknowns
    scale = float(np.abs(plain.admittance_s).max())
    np.testing.assert_allclose(fast.admittance_s, plain.admittance_s, rtol=0.0, atol=1e-9 * scale)
    np.testing.assert_allclose(
        fast.pattern_grid(THETA, 24), plain.pattern_grid(THETA, 24), rtol=0.0, atol=1e-9
    )
    np.testing.assert_allclose(fast.radiated_share, plain.radiated_share, rtol=1e-9)


@pytest.mark.parametrize("sectors", [1, 4])
def test_the_matrix_is_the_same_bit_for_bit_on_any_number_of_threads(monkeypatch, sectors):
    mesh = coarse_mesh()
    basis = surface_basis(mesh.vertices_m, mesh.faces, sectors=sectors)
    matrices = []
    for threads in (1, 2, 5):
        monkeypatch.setenv(THREADS_VARIABLE, str(threads))
        matrices.append(impedance_matrix(basis, frequency_hz=FREQUENCY_HZ))
    assert np.array_equal(matrices[0], matrices[1])
    assert np.array_equal(matrices[0], matrices[2])
    if sectors == 1:
        assert np.array_equal(matrices[0][:, 0, :], matrices[0][:, 0, :].T)


def test_solutions_and_patterns_are_the_same_bits_at_any_number_of_blas_threads():
    body, found = reader_body(plate_height_m=0.03, ground_plane_m=0.2), []
    mesh = reader_mesh(body, frequency_hz=FREQUENCY_HZ, cells_per_wavelength=4.0)
    for threads in (1, 2):
        with threadpool_limits(limits=threads, user_api="blas"):
            result = solve_reader(mesh, symmetry=False)
            found.append(
                [
                    result.admittance_s,
                    result.unloaded.shorted_v.values,
                    result.far_field(THETA[:, None], THETA),
                    result.pattern_grid(THETA, 72),
                    result.radiated_share,
                    result.surface_currents(0),
                ]
            )
    for one, two in zip(*found, strict=True):
        assert one.tobytes() == two.tobytes()


@pytest.mark.slow
def test_halving_the_elements_moves_strong_gains_little(solved):
    coarse = solved("dipole_r10_h8", 10.0).pattern_grid(THETA, 36)
    fine = solved("dipole_r10_h8", 20.0).pattern_grid(THETA, 36)
    a, b = (10.0 * np.log10((np.abs(f) ** 2).sum(axis=-1)) for f in (coarse, fine))
    strong = b > b.max(axis=(1, 2), keepdims=True) - 10.0
    assert np.sqrt(((a - b)[strong] ** 2).mean()) < 0.15


@pytest.mark.slow
@pytest.mark.parametrize("radius_m", [0.02, 0.03])
def test_antennas_deep_between_plates_still_radiate_what_they_accept(radius_m):
    body = reader_body(antenna_radius_m=radius_m)
    result = solve_reader(reader_mesh(body, frequency_hz=FREQUENCY_HZ))
    assert result.accepted_share.max() < 0.05
    assert result.balance_error < 1e-3


@pytest.mark.slow
def test_a_plate_below_the_reader_turns_power_up_and_none_is_lost():
    floor = Body(
        name="floor",
        vertices_m=0.2 * np.array(((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)))
        - (0.0, 0.0, 0.06),
        faces=np.array(((0, 1, 2), (0, 2, 3))),
        material="pec",
    )
    body = reader_body(plate_height_m=0.04)
    below = []
    for surroundings in ((), (floor,)):
        mesh = reader_mesh(
            body, frequency_hz=FREQUENCY_HZ, cells_per_wavelength=7.0, surroundings=surroundings
        )
        result = solve_reader(mesh)
        assert result.balance_error < 1e-3
        down = result.far_field(np.radians((120.0, 140.0, 160.0))[:, None], THETA)
        below.append((np.abs(down) ** 2).sum(axis=-1).mean() / result.radiated_share.mean())
    assert below[1] < 0.8 * below[0]


@pytest.mark.slow
def test_lossy_metal_turns_part_of_the_accepted_power_into_heat():
    mesh = coarse_mesh()
    result = solve_reader(mesh, surface_impedance_ohm=1.0 + 1.0j)
    assert result.lost_share.min() > 1e-3
    assert result.balance_error < 1e-3
    perfect = solve_reader(mesh)
    assert np.all(perfect.lost_share == 0.0)


def test_complex_loads_follow_circuit_theory():
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    plain = solve_reader(mesh)
    z = plain.input_impedance_ohm[0]
    matched = solve_reader(mesh, load_ohm=z.conjugate())
    assert abs(matched.s_matrix[0, 0]) < 1e-9
    assert matched.radiated_share[0] == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(matched.input_impedance_ohm, z, rtol=1e-12)
    np.testing.assert_allclose(plain.impedance_ohm[0, 0], z, rtol=1e-12)
    np.testing.assert_allclose(plain.s_matrix[0, 0], (z - 50.0) / (z + 50.0), rtol=1e-12)


def with_series_load(mesh, height_m):
    """Return a dipole's mesh with one more feed, on the edge across its strip nearest a height."""
    levels = np.unique(np.round(mesh.vertices_m[:, 2], 9))
    cut = levels[1:-1][np.argmin(np.abs(levels[1:-1] - levels[0] - height_m))]
    at_cut = mesh.vertices_m[np.abs(mesh.vertices_m[:, 2] - cut) < 1e-8].mean(axis=0)[None]
    return replace(
        mesh,
        feed_bottom_m=np.concatenate((mesh.feed_bottom_m, at_cut)),
        feed_top_m=np.concatenate((mesh.feed_top_m, at_cut)),
        strip_of_feed=np.append(mesh.strip_of_feed, 0),
        phase_centres_m=np.concatenate((mesh.phase_centres_m, at_cut)),
    )


def test_a_series_load_at_the_feed_adds_to_the_impedance_and_none_changes_nothing():
    plain = dipole_mesh(frequency_hz=FREQUENCY_HZ, feed_gap_m=0.0)
    alone = solve_reader(plain).input_impedance_ohm[0]
    half_m = 0.25 * SPEED_OF_LIGHT_M_PER_S / FREQUENCY_HZ
    middle = with_series_load(plain, half_m)
    coil_ohm = 5.0 + 40.0j
    found = solve_reader(middle, load_ohm=(50.0, coil_ohm))
    np.testing.assert_allclose(found.input_impedance_ohm[0], alone + coil_ohm, rtol=1e-9)
    heated = 5.0 * 50.0 * 4.0 / abs(alone + coil_ohm + 50.0) ** 2
    np.testing.assert_allclose(found.coupled_share[0], heated, rtol=1e-9)
    above = with_series_load(plain, 1.4 * half_m)
    shorted = solve_reader(above, load_ohm=(50.0, 1e-6))
    np.testing.assert_allclose(shorted.input_impedance_ohm[0], alone, rtol=1e-6)
    loaded = solve_reader(above, load_ohm=(50.0, coil_ohm))
    assert loaded.input_impedance_ohm[0].imag > alone.imag + 20.0  # a coil lengthens the dipole
    assert abs(loaded.radiated_share[0] - loaded.accepted_share[0]) < 1e-5


def test_gain_is_realised_power_times_directivity_over_the_sphere(solved):
    result = solved("dipole_r10_h8")
    nodes, weights = np.polynomial.legendre.leggauss(40)
    phi = np.radians(np.arange(0.0, 360.0, 4.5))
    power = (np.abs(result.far_field(np.arccos(nodes)[:, None], phi)) ** 2).sum(axis=-1)
    np.testing.assert_allclose(power.mean(axis=2) @ weights / 2.0, result.radiated_share, rtol=1e-8)


@pytest.mark.parametrize("name", DESIGNS)
def test_available_power_is_shared_out_between_source_loads_and_space(solved, name):
    result = solved(name)
    total = result.reflected_share + result.coupled_share + result.radiated_share
    np.testing.assert_allclose(total, 1.0, atol=1e-3)


def test_a_mesh_beyond_memory_is_refused_before_it_is_solved():
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ, cells_per_wavelength=20000.0)
    with pytest.raises(GeometryError, match="GiB is allowed here; take fewer"):
        solve_reader(mesh)


def test_a_matrix_beyond_the_machines_memory_is_refused(monkeypatch):
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    monkeypatch.setattr("octant.em.reader.fullwave.solve.memory_bytes", lambda: 1e4)
    with pytest.raises(GeometryError, match="GiB is allowed here"):
        solve_reader(mesh)


def test_a_load_without_resistance_is_refused():
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    with pytest.raises(AntennaError, match="above 0 ohm"):
        solve_reader(mesh, load_ohm=-5.0)


def test_a_feed_beside_the_antenna_is_refused():
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ)
    off = np.array(((0.0, 0.0, 1.0),))
    with pytest.raises(GeometryError, match="no triangle of the antenna lies along the feed"):
        solve_reader(
            replace(mesh, feed_bottom_m=mesh.feed_bottom_m + off, feed_top_m=mesh.feed_top_m + off)
        )
    with pytest.raises(GeometryError, match="no edge of the antenna's mesh lies at the feed"):
        solve_reader(replace(mesh, feed_bottom_m=off, feed_top_m=off))
