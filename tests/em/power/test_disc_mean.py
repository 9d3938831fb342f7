"""Means over a disc: exact for what is even over it, the Airy pattern for two waves."""

import numpy as np
import pytest
from scipy.special import j1

from octant.em.power.disc_mean import disc_rule_m, mean_over_disc
from octant.geometries.errors import GeometryError


def everywhere(places):
    return np.ones(len(places), dtype=bool)


def test_polynomials_of_fifth_degree_in_both_coordinates_are_exact():
    """Means of x^2 and x^2 y^2 over a disc of radius a: a^2/4 and a^4/24."""
    (x, y), share = disc_rule_m(2.0)[0].T, disc_rule_m(2.0)[1]
    assert share.sum() == pytest.approx(1.0, rel=1e-15)
    assert share @ x**2 == pytest.approx(0.25, rel=1e-14)
    assert share @ (x**2 * y**2) == pytest.approx(1.0 / 24.0, rel=1e-13)
    assert share @ (x**3 * y) == pytest.approx(0.0, abs=1e-15)


def test_every_column_is_averaged():
    def power(places):
        return np.column_stack((np.full(len(places), 3.0), places[:, 0] ** 2))

    mean = mean_over_disc(power, [(0, 0, 1), (5, 0, 1)], diameter_m=0.5, usable=everywhere)
    assert mean[:, 0] == pytest.approx([3.0, 3.0], rel=1e-15)
    assert mean[:, 1] == pytest.approx([0.25**2 / 4, 25 + 0.25**2 / 4], rel=1e-12)


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.0])
def test_two_waves_leave_the_airy_pattern_of_their_difference(turn):
    """|1 + e^{jq.x}|^2 averages to 2 + 2 cos(q.x0) 2 J1(|q| a) / (|q| a)."""
    wavenumber, diameter = 2 * np.pi, 1.0  # wavelength 1
    q = 2 * wavenumber * np.array([np.cos(turn), np.sin(turn)])  # opposite waves

    def power(places):
        return np.abs(1.0 + np.exp(1j * places[:, :2] @ q)) ** 2

    centres = np.array([(0.0, 0.0, 0.3), (0.13, 0.2, 0.3), (0.5, -0.1, 0.3)])
    x = np.linalg.norm(q) * diameter / 2
    exact = 2.0 + 2.0 * np.cos(centres[:, :2] @ q) * 2.0 * j1(x) / x
    mean = mean_over_disc(power, centres, diameter_m=diameter, usable=everywhere)
    np.testing.assert_allclose(mean, exact, atol=0.02)


def test_places_that_cannot_be_used_are_left_out():
    mean = mean_over_disc(
        lambda p: np.where(p[:, 0] < 0.0, 1.0, 9.0),
        [(0.0, 0.0, 0.0), (5.0, 0.0, 0.0)],
        diameter_m=1.0,
        usable=lambda p: p[:, 0] < 0.0,
    )
    assert mean[0] == 1.0
    assert np.isnan(mean[1])


def test_a_disc_without_size_is_refused():
    with pytest.raises(GeometryError, match="above 0 m"):
        disc_rule_m(0.0)
