"""Few directions give all others: a source of some size has so many details and no more."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.far_field import CurrentSamples, FarField, band_limited
from octant.geometries.errors import AntennaError

FREQUENCY_HZ = 2.4e9
WAVENUMBER = 2.0 * math.pi * FREQUENCY_HZ / SPEED_OF_LIGHT_M_PER_S


def random_currents(size, seed, *, cases=2, count=40):
    """Return currents on a sphere of circumference ``size`` wavelengths, or within it."""
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    points[1::2] *= rng.uniform(0.0, 1.0, (len(points[1::2]), 1))
    shape = (cases, count, 3)
    return CurrentSamples(
        points_m=size / WAVENUMBER * points,
        moments_a_m=rng.standard_normal(shape) + 1j * rng.standard_normal(shape),
        frequency_hz=FREQUENCY_HZ,
    )


@given(
    st.floats(0.01, 30.0),
    st.integers(0, 2**32 - 1),
    st.integers(1, 50),
    st.lists(st.floats(0.0, math.pi), min_size=1, max_size=5),
)
@example(size=7.1, seed=0, columns=240, theta=[0.0, 0.5 * math.pi, math.pi])
@example(size=0.34375, seed=2, columns=1, theta=[1.0])
@example(size=1.46875, seed=6633, columns=4, theta=[1.0])
@example(size=60.0, seed=1, columns=3, theta=[0.0, 1.0, math.pi])
def test_the_fields_everywhere_follow_from_few_directions(size, seed, columns, theta):
    currents = random_currents(size, seed)
    phi = 2.0 * math.pi * np.arange(columns) / columns
    exact = currents.far_field(np.array(theta)[:, None], phi)
    field = band_limited(currents)
    found = field.on_grid(theta, columns)
    scale = float(np.abs(field.values).max())
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=1e-8 * scale)


def test_the_thesis_reader_needs_about_a_thousand_directions():
    values = band_limited(random_currents(WAVENUMBER * 0.1414, 3)).values
    assert values.shape[1] * values.shape[2] < 1200  # of 29,040 on the 1.5 degree grid


@pytest.mark.parametrize("size", [0.1, 7.0])
def test_powers_are_those_of_a_fine_rule_over_the_sphere(size):
    currents = random_currents(size, 5)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    phi = 2.0 * math.pi * np.arange(80) / 80
    fields = currents.far_field(np.arccos(nodes)[:, None], phi)
    expected = np.einsum("itpc,jtpc,t->ij", fields.conj(), fields, weights / 160.0)
    found = band_limited(currents).power_matrix()
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


def test_an_elementary_dipole_has_the_power_of_the_textbook():
    moment = CurrentSamples(
        points_m=np.zeros((1, 3)), moments_a_m=[[[0.0, 0.0, 1.0]]], frequency_hz=FREQUENCY_HZ
    )
    power = float(band_limited(moment).power_matrix()[0, 0].real)
    eta = 4e-7 * math.pi * SPEED_OF_LIGHT_M_PER_S
    # eta k^2 / (12 pi) for 1 A m is radiated: |E R|^2 / (2 eta) over the sphere
    assert 4.0 * math.pi * power / (2.0 * eta) == pytest.approx(
        eta * WAVENUMBER**2 / (12.0 * math.pi), rel=1e-9
    )


def test_grids_that_fix_nothing_are_refused():
    with pytest.raises(AntennaError, match="an even number of values of phi"):
        FarField(values=np.zeros((1, 4, 5, 2)))
