import json
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.estimators.kalman import (
    Gaussian,
    chi_squared_quantile,
    consistency_band,
    covariance_matrix,
    innovate,
    nees,
    predict,
    update,
    within_gate,
)

REFERENCE = Path(__file__).parents[2] / "reference" / "navigation" / "closed_loop.json"


def belief(mean, variances):
    return Gaussian(mean=np.array(mean, dtype=float), covariance=np.diag(variances))


def test_an_update_is_the_product_of_two_densities():
    # Two scalar Gaussians: the precisions add, the means are weighted by precision.
    prior = belief([1.0], [4.0])
    seen = innovate(prior, [3.0], observation=[[1.0]], measurement_noise=[[1.0]])
    after = update(prior, seen)
    assert after.covariance[0, 0] == pytest.approx(1.0 / (1 / 4.0 + 1 / 1.0), abs=1e-15)
    assert after.mean[0] == pytest.approx((1.0 / 4 + 3.0) / (1 / 4 + 1), abs=1e-15)


def test_the_joseph_form_equals_the_information_form():
    rng = np.random.default_rng(1)
    a, c = rng.normal(size=(4, 4)), rng.normal(size=(2, 4))
    p, r = a @ a.T + np.eye(4), np.diag([0.3, 0.7])
    x, z = rng.normal(size=4), rng.normal(size=2)
    prior = Gaussian(mean=x, covariance=p)
    after = update(prior, innovate(prior, z, observation=c, measurement_noise=r))
    information = np.linalg.inv(p) + c.T @ np.linalg.inv(r) @ c
    want = np.linalg.solve(information, np.linalg.solve(p, x) + c.T @ np.linalg.solve(r, z))
    np.testing.assert_allclose(after.covariance, np.linalg.inv(information), atol=1e-13)
    np.testing.assert_allclose(after.mean, want, atol=1e-13)


def test_a_recursive_filter_equals_batch_least_squares():
    rng = np.random.default_rng(2)
    phi, q = np.array([[1.0, 0.5], [0.0, 1.0]]), np.zeros((2, 2))
    prior = belief([0.0, 0.0], [10.0, 10.0])
    zs = rng.normal(size=6)
    state, rows = prior, []
    for k, z in enumerate(zs):
        state = predict(state, transition=phi, process_noise=q)
        seen = innovate(state, [z], observation=[[1.0, 0.0]], measurement_noise=[[0.2]])
        state = update(state, seen)
        rows.append(np.linalg.matrix_power(phi, k + 1)[0])
    h = np.array(rows)
    information = np.diag([0.1, 0.1]) + h.T @ h / 0.2
    start = np.linalg.solve(information, h.T @ zs / 0.2)
    np.testing.assert_allclose(state.mean, np.linalg.matrix_power(phi, 6) @ start, atol=1e-11)


def test_a_batch_equals_its_members_one_by_one():
    rng = np.random.default_rng(3)
    means, zs = rng.normal(size=(5, 2)), rng.normal(size=(5, 1))
    covariance = np.array([[2.0, 0.3], [0.3, 1.0]])
    many = Gaussian(mean=means, covariance=np.broadcast_to(covariance, (5, 2, 2)))
    c, r = [[1.0, 0.5]], [[0.4]]
    accept = np.array([True, False, True, True, False])
    after = update(many, innovate(many, zs, observation=c, measurement_noise=r), accept=accept)
    for i in range(5):
        one = Gaussian(mean=means[i], covariance=covariance)
        seen = innovate(one, zs[i], observation=c, measurement_noise=r)
        want = update(one, seen) if accept[i] else one
        np.testing.assert_allclose(after.mean[i], want.mean, atol=1e-15)
        np.testing.assert_allclose(after.covariance[i], want.covariance, atol=1e-15)


def test_angle_residuals_and_errors_are_wrapped():
    prior = belief([3.1], [1.0])
    seen = innovate(prior, [-3.1], observation=[[1.0]], measurement_noise=[[1.0]], angles=(0,))
    assert seen.residual[0] == pytest.approx(2 * np.pi - 6.2, abs=1e-14)
    assert nees(prior, [-3.1], angles=(0,)) == pytest.approx((2 * np.pi - 6.2) ** 2, abs=1e-13)


def test_the_gate_cuts_at_the_chi_squared_quantile():
    # Two degrees of freedom: the quantile is -2 ln(1 - p) in closed form.
    limit = -2.0 * np.log(0.01)
    assert chi_squared_quantile(0.99, degrees=2) == pytest.approx(limit, rel=1e-12)
    prior = belief([0.0, 0.0], [1.0, 3.0])
    for factor, inside in ((0.999, True), (1.001, False)):
        z = [factor * np.sqrt(limit * 2.0), 0.0]
        seen = innovate(prior, z, observation=np.eye(2), measurement_noise=np.eye(2))
        assert bool(within_gate(seen, probability=0.99)) is inside


def test_the_consistency_band_of_a_gaussian_sample_holds_its_mean():
    low, high = consistency_band(degrees=3, samples=100)
    # Wilson-Hilferty's closed form of the chi-squared quantile, good to 1e-3 at 300 degrees.
    for z, value in ((-1.959964, low), (1.959964, high)):
        s = 2.0 / (9.0 * 300)
        assert value == pytest.approx(3.0 * (1 - s + z * np.sqrt(s)) ** 3, rel=1e-3)
    rng = np.random.default_rng(4)
    samples = rng.normal(size=(2000, 100, 3))
    means = np.sum(samples**2, axis=2).mean(axis=1)
    assert 0.93 < np.mean((low <= means) & (means <= high)) < 0.97


def test_an_extended_update_of_the_slam_step_follows_the_reference():
    data = json.loads(REFERENCE.read_text())["ekf_slam_step"]
    mu, z = np.array(data["mu"]), np.array(data["z"])
    covariance = np.diag(data["S_diag"])
    covariance[0, 3] = covariance[3, 0] = data["S_03"]
    dx, dy = mu[3:] - mu[:2]
    predicted = [np.hypot(dx, dy), np.arctan2(dy, dx) - mu[2]]
    prior = Gaussian(mean=mu, covariance=covariance)
    seen = innovate(
        prior,
        z,
        observation=data["H"],
        measurement_noise=np.diag([1.5**2, 0.9**2]),
        predicted=predicted,
        angles=(1,),
    )
    np.testing.assert_allclose(seen.residual, data["innovation"], atol=5e-8)
    after = update(prior, seen)
    np.testing.assert_allclose(after.mean, data["mu_new"], atol=5e-8)
    np.testing.assert_allclose(np.diag(after.covariance), data["S_new_diag"], atol=5e-8)


@pytest.mark.parametrize("value", [0.0, [1.0, -1.0], [[1.0, 2.0], [2.0, 1.0]], [[1, 0.5], [0, 1]]])
def test_a_covariance_that_is_none_is_refused(value):
    with pytest.raises(NavigationError, match="noise"):
        covariance_matrix(value, states=2, name="noise")


def test_shapes_that_do_not_belong_together_are_refused():
    with pytest.raises(NavigationError, match="shape"):
        Gaussian(mean=np.zeros(2), covariance=np.eye(3))
    with pytest.raises(NavigationError, match="between 0 and 1"):
        chi_squared_quantile(1.0, degrees=2)
