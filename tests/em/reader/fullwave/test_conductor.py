"""Lossy metal: closed forms of sheets and wires, first-order losses, power balance, limits."""

import math
from dataclasses import replace

import numpy as np
import pytest

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.band import solve_band
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.mesh import BESIDE, reader_mesh
from octant.em.reader.fullwave.ported import ported_mesh, strip
from octant.em.reader.fullwave.single import dipole_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.errors import AntennaError
from octant.geometries.furniture import box
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
COPPER = Conductor(conductivity_s_per_m=5.8e7)
HALF_WAVE_M = 0.5 * SPEED_OF_LIGHT_M_PER_S / FREQUENCY_HZ


def small_reader(**keys):
    body = reader_body(antennas=4, ground_plane_m=0.12, antenna_radius_m=0.045, plate_height_m=0.03)
    return reader_mesh(body, frequency_hz=FREQUENCY_HZ, cells_per_wavelength=5.0, **keys)


def resistance_ohm(conductor, frequency_hz=FREQUENCY_HZ):
    """Return the surface resistance sqrt(pi f mu / sigma)."""
    return math.sqrt(math.pi * frequency_hz * 4e-7 * math.pi / conductor.conductivity_s_per_m)


def test_skin_depth_of_copper_at_one_gigahertz_is_that_of_tables():
    assert COPPER.skin_depth_m(1e9) == pytest.approx(2.09e-6, rel=2e-3)


def test_sheets_are_both_sides_in_parallel_when_thick_and_a_resistor_when_thin():
    r = resistance_ohm(COPPER)
    assert COPPER.sheet_ohm(FREQUENCY_HZ) == pytest.approx(0.5 * r * (1 + 1j), rel=1e-12)
    thin = replace(COPPER, thickness_m=1e-8)
    assert thin.sheet_ohm(FREQUENCY_HZ) == pytest.approx(1.0 / (5.8e7 * 1e-8), rel=1e-3)


def test_wires_are_direct_current_at_low_frequencies_and_a_skin_at_high_ones():
    radius_m = 0.0005
    along = COPPER.wire_ohm(1.0, radius_m) / (4.0 * radius_m)
    inside = 2j * math.pi * 1.0 * 5e-8  # 50 nH/m
    assert along == pytest.approx(1.0 / (5.8e7 * math.pi * radius_m**2) + inside, rel=1e-9)
    along = COPPER.wire_ohm(FREQUENCY_HZ, radius_m) / (4.0 * radius_m)
    skin = resistance_ohm(COPPER) / (2.0 * math.pi * radius_m)
    assert along == pytest.approx(skin * (1 + 1j), rel=3e-3)


def half_wave(radius_m, conductor=None):
    mesh = dipole_mesh(
        frequency_hz=FREQUENCY_HZ, wire_radius_m=radius_m, feed_gap_m=0.0, conductor=conductor
    )
    return solve_reader(mesh)


def current_a(result, width_m):
    """Return currents along a dipole's rows of cells [A], and the rows' lengths [m]."""
    basis = result.basis
    along = result.surface_currents(0)[:, 2] * basis.areas_m2
    ends = np.unique(np.round(basis.vertices_m[:, 2], 9))
    row = np.searchsorted(ends, basis.corners_m.mean(axis=1)[:, 2]) - 1
    parts = [np.bincount(row, part) for part in (along.real, along.imag, basis.areas_m2)]
    return width_m * (parts[0] + 1j * parts[1]) / parts[2], np.diff(ends)


@pytest.mark.parametrize("radius_m", [1e-4, 1e-3])
def test_a_dipole_has_the_loss_resistance_of_its_current_on_round_wire(radius_m):
    """R_s / (2 pi a) times the integral of I^2 over that at the feed, I that of perfect metal."""
    poor = Conductor(conductivity_s_per_m=1e7)
    perfect, lossy = half_wave(radius_m), half_wave(radius_m, poor)
    current, rows_m = current_a(perfect, 4.0 * radius_m)
    ring_m = radius_m - 0.5 * poor.skin_depth_m(FREQUENCY_HZ)
    per_m = resistance_ohm(poor) / (2.0 * math.pi * ring_m)
    heat_w = 0.5 * per_m * float((np.abs(current) ** 2 * rows_m).sum())
    share = heat_w / (heat_w + perfect.radiated_share[0])
    assert 1.0 - lossy.radiation_efficiency[0] == pytest.approx(share, rel=0.01)
    fed = (perfect.embedded_voltages_v @ perfect.admittance_s)[0, 0] * math.sqrt(400.0)
    rise = lossy.impedance_ohm[0, 0] - perfect.impedance_ohm[0, 0]
    reaction = (1 + 1j) * per_m * (current**2 * rows_m).sum() / fed**2
    assert rise == pytest.approx(reaction, rel=0.02)


def test_thin_wires_lose_what_a_sinusoidal_current_does():
    """R_s L / (4 pi a): C. A. Balanis, Antenna Theory, equation 2-90b; thicker wires lose more."""
    over = []
    for radius_m in (1e-3, 1e-4, 1e-6):
        metal = Conductor(conductivity_s_per_m=1e7 * (1e-4 / radius_m) ** 2)
        expected = resistance_ohm(metal) * HALF_WAVE_M / (4.0 * math.pi * radius_m)
        share = 1.0 / half_wave(radius_m, metal).radiation_efficiency[0] - 1.0
        over.append(share * half_wave(radius_m).impedance_ohm[0, 0].real / expected)
    assert over == sorted(over, reverse=True)
    assert 1.0 < over[-1] < 1.1


def heat_w(result, ohm, port):
    """Return half the integral of R |J|^2 over all triangles, by the rule of edge middles [W]."""
    basis = result.basis
    source_v = math.sqrt(8.0 * float(result.load_ohm[port].real))
    halves = source_v * np.tensordot(
        result.embedded_voltages_v[port], result.halves_a_per_m, axes=(0, 0)
    )
    corners, total = basis.corners_m, 0.0
    for k in range(3):
        point = 0.5 * (corners[:, k] + corners[:, (k + 1) % 3])
        out = (halves * basis.edge_lengths_m)[:, :, None] * (point[:, None] - corners)
        current = out.sum(axis=1) / (2.0 * basis.areas_m2[:, None])
        squares = (np.abs(current) ** 2).sum(axis=1)
        total += float((0.5 * ohm.real * squares * basis.areas_m2).sum() / 3.0)
    return total


def test_what_is_lost_is_to_first_order_that_of_perfect_metals_currents():
    perfect = solve_reader(small_reader())
    mesh = small_reader(conductor=Conductor(conductivity_s_per_m=1e8, roughness_factor=1.5))
    lossy = solve_reader(mesh)
    assert lossy.basis.sectors == perfect.basis.sectors == 4
    ohm = mesh.surface_impedance_ohm(FREQUENCY_HZ)[perfect.basis.given_face]
    assert len(np.unique(ohm)) == 2
    for port in (0, 1):
        expected = heat_w(perfect, ohm, port)
        assert 1e-4 < expected < 1e-2
        assert lossy.lost_share[port] == pytest.approx(expected, rel=5e-3)


def test_accepted_power_is_radiated_or_lost_and_none_is_made():
    poor = Conductor(conductivity_s_per_m=1e4, thickness_m=1e-5)
    result = solve_reader(small_reader(conductor=poor))
    assert result.lost_share.min() > 0.02
    assert result.balance_error < 5e-5
    real = 0.5 * (result.admittance_s + result.admittance_s.conj().T)
    assert np.linalg.eigvalsh(real - result.unloaded.heat_s).min() > 0.0
    assert np.linalg.svd(result.s_matrix, compute_uv=False).max() < 1.0


def test_ever_better_metal_is_perfect_in_the_end():
    perfect = solve_reader(small_reader())
    assert np.array_equal(
        perfect.admittance_s, solve_reader(small_reader(), surface_impedance_ohm=0.0).admittance_s
    )
    off = [
        np.abs(
            solve_reader(small_reader(conductor=Conductor(conductivity_s_per_m=sigma))).admittance_s
            - perfect.admittance_s
        ).max()
        for sigma in (1e8, 1e12)
    ]
    assert off[1] == pytest.approx(0.01 * off[0], rel=0.02)


def test_losses_by_rotational_modes_are_those_of_the_plain_solution():
    mesh = small_reader(conductor=replace(COPPER, conductivity_s_per_m=1e5))
    fast, plain = solve_reader(mesh), solve_reader(mesh, symmetry=False)
    np.testing.assert_allclose(fast.lost_share, plain.lost_share, rtol=1e-8)


def test_metal_beside_the_reader_stays_perfect():
    body = box((0.1, 0.1, 0.05), material="metal", position_m=(-0.05, -0.05, -0.1))
    mesh = small_reader(conductor=COPPER, surroundings=(body,))
    ohm = mesh.surface_impedance_ohm(FREQUENCY_HZ)
    assert (mesh.antenna_of_face == BESIDE).any()
    assert np.array_equal(ohm == 0.0, mesh.antenna_of_face == BESIDE)


def test_over_a_band_losses_are_those_of_each_frequency():
    mesh = dipole_mesh(frequency_hz=FREQUENCY_HZ, conductor=replace(COPPER, roughness_factor=2.0))
    band = solve_band(mesh, [2.40e9, 2.41e9, 2.43e9, 2.44e9, 2.45e9])
    direct, between = solve_reader(mesh, frequency_hz=2.42e9), band.at(2.42e9)
    np.testing.assert_allclose(between.lost_share, direct.lost_share, rtol=1e-4)


def test_over_an_infinite_plane_wires_lose_what_half_a_dipole_does():
    keys = {"width_m": 0.002, "across": (0.0, 1.0, 0.0), "rows": 14}
    quarter = 0.03
    poor = Conductor(conductivity_s_per_m=1e5)
    up = ("arm", *strip((0, 0, 0), (0, 0, quarter), **keys))
    over = ported_mesh(
        [up],
        [("ground", "arm")],
        frequency_hz=FREQUENCY_HZ,
        ground=True,
        conductor=poor,
        wires_m={"arm": 0.0005},
    )
    down = ("low", *strip((0, 0, -quarter), (0, 0, 0), **keys))
    whole = ported_mesh(
        [down, up],
        [("low", "arm")],
        frequency_hz=FREQUENCY_HZ,
        conductor=poor,
        wires_m={"arm": 0.0005, "low": 0.0005},
    )
    one, two = solve_reader(over, load_ohm=25.0), solve_reader(whole, load_ohm=50.0)
    assert one.lost_share[0] > 1e-3
    np.testing.assert_allclose(one.lost_share, two.lost_share, rtol=1e-4)
    np.testing.assert_allclose(one.radiation_efficiency, two.radiation_efficiency, rtol=1e-6)


def test_what_is_outside_the_model_is_said():
    assert small_reader(conductor=COPPER).warnings == small_reader().warnings
    thick = small_reader(conductor=replace(COPPER, thickness_m=0.003))
    assert "not thin against 5 mm" in thick.warnings[-1]
    assert "skin depth" in Conductor(conductivity_s_per_m=1.0).doubts(FREQUENCY_HZ)[0]
    with pytest.raises(AntennaError, match=r"roughness_factor is 0\.5"):
        replace(COPPER, roughness_factor=0.5)
