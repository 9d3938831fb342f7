"""Antennas of two ports behind hybrids: crossed dipoles against closed forms."""

import math

import numpy as np
import pytest

from octant.em.reader.fullwave.elements import copied_around, dipole_parts
from octant.em.reader.fullwave.ported import ported_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.em.reader.hybrids import axial_ratio_db, result_with_hybrids, with_hybrids

F_HZ = 299792458.0
HALF = math.sqrt(0.5)


@pytest.fixture(scope="module")
def crossed():
    """Two dipoles across each other, one a little in front of the other."""
    keys = {"length_m": 0.47, "width_m": 0.004, "cell_m": 0.1}
    parts = []
    for name, axis, x in (("a", (0, 1, 1), 0.005), ("b", (0, -1, 1), -0.005)):
        parts += copied_around(dipole_parts(axis=axis, middle_m=(x, 0, 0), **keys), name, around=1)
    ports = [("a.low", "a.high"), ("b.low", "b.high")]
    return solve_reader(ported_mesh(parts, ports, frequency_hz=F_HZ))


def test_crossed_dipoles_in_quadrature_are_circular_along_their_axis(crossed):
    # One is 0.01 wavelengths in front: 3.6 degrees are made up for by the hybrid.
    for sign in (1.0, -1.0):
        turn = np.exp(1j * math.radians(3.6 - sign * 90.0))
        one = result_with_hybrids(crossed, np.array([[HALF, HALF * turn]]))
        theta, phi = one.far_field(0.5 * math.pi, 0.0)[0]
        ratio = phi / theta
        assert abs(ratio) == pytest.approx(1.0, abs=0.02)
        assert abs(math.degrees(np.angle(ratio))) == pytest.approx(90.0, abs=2.0)
        # Across all tilts of a tag facing it the same: half of a dipole's own way.
        best = crossed.far_field(0.5 * math.pi, 0.0)[0]
        along = np.abs(best @ np.array([1.0, 1.0]) * HALF) ** 2
        tilts = np.radians(np.arange(0.0, 180.0, 15.0))
        found = np.abs(theta * np.cos(tilts) + phi * np.sin(tilts)) ** 2
        np.testing.assert_allclose(found, 0.5 * max(along, np.sum(np.abs(best) ** 2)), rtol=0.06)


def test_the_axial_ratio_is_that_of_the_ellipse():
    turn, long, short = 0.7, 3.0, 0.5
    c, s = math.cos(turn), math.sin(turn)
    ellipse = np.array([c * long - 1j * s * short, s * long + 1j * c * short]) * np.exp(0.3j)
    assert axial_ratio_db(ellipse) == pytest.approx(20.0 * math.log10(long / short))
    assert axial_ratio_db([1.0, 1j]) == pytest.approx(0.0, abs=1e-9)
    assert axial_ratio_db([1.0, 0.0]) == math.inf


def test_power_behind_a_hybrid_adds_up_and_reflections_of_alike_ports_go_to_its_load(crossed):
    shares = np.array([[HALF, -1j * HALF]])
    one = result_with_hybrids(crossed, shares)
    assert one.balance_error < 1e-6
    s = crossed.s_matrix
    back = (shares @ s @ shares.T)[0, 0]
    np.testing.assert_allclose(one.s_matrix[0, 0], back, atol=1e-12)
    assert abs(back) < 0.03
    assert abs(s[0, 0]) > 0.1
    both = shares[0] @ s
    assert one.radiated_share[0] == pytest.approx(1.0 - np.sum(np.abs(both) ** 2), rel=1e-6)
    again = with_hybrids(crossed.unloaded, shares)
    np.testing.assert_allclose(again.admittance_s, one.admittance_s, rtol=1e-12)
    np.testing.assert_allclose(
        one.far_field(1.0, 2.0), (shares @ crossed.far_field(1.0, 2.0)), atol=1e-10
    )
