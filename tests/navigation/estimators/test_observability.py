import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from octant.navigation.estimators.observability import (
    attitude_gramian,
    attitude_observability,
    position_gramian,
    slip_deviation,
)

ATTITUDE = np.array([[0.0, -1.0], [0.0, 0.0]])


def gramian(a, outputs, duration):
    """∫ Φᵀ Cᵀ C Φ dτ with Φ a matrix exponential, by adaptive quadrature."""
    c = np.eye(len(a))[:outputs]
    return quad_vec(lambda t: expm(a * t).T @ c.T @ c @ expm(a * t), 0.0, duration)[0]


@pytest.mark.parametrize("rate", [0.0, 1e-4, 0.009, 0.011, 0.2, -1.3])
@pytest.mark.parametrize("duration", [0.3, 1.0, 7.0])
def test_the_gramians_are_the_integrals_of_27(rate, duration):
    position = np.array([[0, rate, -1], [-rate, 0, 0], [0, 0, 0.0]])
    found = position_gramian(duration, turn_rate_rad_per_s=rate)
    np.testing.assert_allclose(found, gramian(position, 2, duration), rtol=1e-8, atol=1e-10)
    assert np.linalg.matrix_rank(found) == 3
    np.testing.assert_allclose(attitude_gramian(duration), gramian(ATTITUDE, 1, duration))


def test_7_has_rank_2_and_the_printed_limit_of_27_is_no_gramian():
    np.testing.assert_array_equal(attitude_observability(), [[1.0, 0.0], [0.0, -1.0]])
    t = 2.0
    assert np.linalg.det(position_gramian(t)) == pytest.approx(t**5 / 12.0)
    printed = np.array([[t, 0, -t], [0, t, 0], [-t, 0, -(t**2)]])
    assert np.linalg.eigvalsh(printed).min() < 0.0 < np.linalg.eigvalsh(position_gramian(t)).min()


def test_the_slip_is_known_as_well_as_a_line_fitted_to_the_places():
    """Independent: the slope of a regression over n images, whose variance tends to 12 R T/t³."""
    variance, period, images = 0.01, 0.1, 400
    times = period * np.arange(images)
    slope = variance / np.sum((times - times.mean()) ** 2)
    found = slip_deviation(
        position_gramian(images * period), measured_variance=variance, period_s=period
    )
    assert found == pytest.approx(np.sqrt(slope), rel=1e-4)
    turning = position_gramian(images * period, turn_rate_rad_per_s=1.0)
    assert slip_deviation(turning, measured_variance=variance, period_s=period) > found
