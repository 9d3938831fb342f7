"""One dipole, and one on a plate: against the exact-kernel tube, thin limit and image theory."""

import math

import numpy as np
import pytest

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave._polygon_mesh import mesh_polygon
from octant.em.reader.fullwave._strips import Strip, strip_triangles
from octant.em.reader.fullwave.basis import surface_basis
from octant.em.reader.fullwave.linear_solve import solve_currents
from octant.em.reader.fullwave.ports import feed_excitation
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.em.reader.fullwave.single import dipole_mesh, monopole_mesh
from octant.em.reader.fullwave.solve import solve_reader

FREQUENCY_HZ = 2.4e9
HALF_WAVE_M = 0.5 * SPEED_OF_LIGHT_M_PER_S / FREQUENCY_HZ
THIN_HALF_WAVE_OHM = 73.13 + 42.54j
THIN_HALF_WAVE_GAIN_DB = 2.151


def impedance(**changes):
    result = solve_reader(dipole_mesh(frequency_hz=FREQUENCY_HZ, **changes))
    assert result.balance_error < 1e-5
    return result.input_impedance_ohm[0]


@pytest.mark.parametrize(
    ("feed_gap_m", "expected_ohm"),
    [(0.0057, 91.3 + 50.5j), (0.001, 95.5 + 46.9j)],  # exact-kernel tube of radius 0.5 mm
)
def test_a_thick_dipole_has_the_impedance_of_the_tube(feed_gap_m, expected_ohm):
    found = impedance(length_m=0.0625, wire_radius_m=0.0005, feed_gap_m=feed_gap_m)
    assert abs(found / expected_ohm - 1.0) < 0.03


def test_thinner_dipoles_approach_the_thin_limit():
    off = [
        abs(impedance(wire_radius_m=radius, feed_gap_m=0.0) - THIN_HALF_WAVE_OHM)
        for radius in (5e-4, 5e-5, 5e-6, 5e-8)
    ]
    assert off == sorted(off, reverse=True)
    assert off[-1] < 0.05 * abs(THIN_HALF_WAVE_OHM)


def test_the_dipole_has_the_gain_of_a_half_wave():
    result = solve_reader(dipole_mesh(frequency_hz=FREQUENCY_HZ, length_m=0.0625))
    broadside = (np.abs(result.far_field(math.pi / 2, 0.3)[0]) ** 2).sum()
    gain_db = 10.0 * math.log10(broadside / result.radiated_share[0])
    assert gain_db == pytest.approx(THIN_HALF_WAVE_GAIN_DB, abs=0.05)


def disc_with_two_monopoles(length_m, width_m):
    """Return a plate in z = 0 with a strip up and a strip down from one foot, sharing vertices."""
    foot = np.array(((0.0, -0.5, 0.0), (0.0, 0.0, 0.0), (0.0, 0.5, 0.0))) * width_m
    strip = Strip(foot_m=foot, length_m=length_m, cells=12, grounded=True)
    vertices, faces = strip_triangles(strip)
    half = np.array(((-0.03, 0.0), (0.0, 0.0), (0.03, 0.0), (0.03, 0.03), (-0.03, 0.03)))

    def size(points_m):
        return np.clip(0.7 * np.linalg.norm(points_m, axis=1), 0.001, 0.01)

    points, plate = mesh_polygon(half, size, foot[2:, :2])
    points = np.column_stack((points, np.zeros(len(points))))
    parts = [
        (vertices, faces),
        (vertices * (1.0, 1.0, -1.0), faces),
        (points, plate),
        (points * (1.0, -1.0, 1.0), plate),
    ]
    starts = np.cumsum([0, *(len(v) for v, _ in parts)])
    everything = np.concatenate([v for v, _ in parts])
    all_faces = np.concatenate([f + s for (_, f), s in zip(parts, starts, strict=False)])
    used, inverse = np.unique(np.round(everything, 9) + 0.0, axis=0, return_inverse=True)
    return used, inverse.reshape(-1)[all_faces], len(faces)


def test_graded_tips_are_nearer_to_the_fine_mesh_than_even_cells():
    fine = impedance(length_m=0.0625, cells_per_wavelength=140.0)
    graded, even = (impedance(length_m=0.0625, graded_tips=g) for g in (True, False))
    assert abs(graded / fine - 1.0) < 0.015
    assert abs(graded / fine - 1.0) < 0.5 * abs(even / fine - 1.0)


@pytest.mark.parametrize("feed_m", [0.00285, 0.0])
def test_two_monopoles_back_to_back_on_a_plate_are_one_dipole(feed_m):
    """Driven against each other they leave the plate without current, whatever its size."""
    vertices, faces, each = disc_with_two_monopoles(0.03125, 0.002)
    basis = surface_basis(vertices, faces)
    up = np.array((0.0, 0.0, feed_m))
    foot = np.zeros(3)
    halves = feed_excitation(basis, np.arange(each), foot, up)
    below = feed_excitation(basis, each + np.arange(each), -up, foot)
    if feed_m == 0.0:
        below = feed_excitation(basis, each + np.arange(each), foot, foot, axis=(0.0, 0.0, 1.0))
    excitation = basis.gathered(np.array([halves, below]))
    currents = solve_currents(basis, impedance_matrix(basis, frequency_hz=FREQUENCY_HZ), excitation)
    admittance = np.einsum("ism,jsm->ij", excitation, currents)
    together = admittance.sum()  # 1 V upwards across each feed: 2 V across the dipole
    found = 2.0 / (0.5 * together)
    expected = impedance(length_m=0.0625, feed_gap_m=2.0 * feed_m, graded_tips=False)
    assert abs(found / expected - 1.0) < 0.01


@pytest.mark.slow
def test_a_monopole_on_a_growing_plane_tends_to_half_the_dipole_and_spares_the_lower_half():
    """By image theory an infinite plane gives half the dipole's Z; finite ones ripple around it."""
    half_dipole = 0.5 * impedance(length_m=0.0625, feed_gap_m=0.0057)
    found = [
        solve_reader(
            monopole_mesh(
                frequency_hz=FREQUENCY_HZ,
                plane_m=side * 2.0 * HALF_WAVE_M,
                length_m=0.03125,
                feed_gap_m=0.00285,
                cells_per_wavelength=8.0,
            )
        )
        for side in (1.0, 1.5, 2.0, 2.5)
    ]
    assert all(result.balance_error < 1e-3 for result in found)
    average = np.mean([result.input_impedance_ohm[0] for result in found])
    assert abs(average / half_dipole - 1.0) < 0.05
    up, down = (
        (np.abs(found[-1].far_field(np.radians(angles), 0.4)[0]) ** 2).sum(axis=-1).mean()
        for angles in (np.arange(40.0, 90.0, 5.0), np.arange(100.0, 150.0, 5.0))
    )
    assert up > 5.0 * down
