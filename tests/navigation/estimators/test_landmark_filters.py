import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from octant.geometries.errors import NavigationError
from octant.navigation.estimators.kalman import consistency_band
from octant.navigation.estimators.landmark_filters import (
    ATTITUDE,
    LandmarkFilter,
    LandmarkNoise,
    attitude_transition,
    position_transition,
    turn_sensitivity,
)
from octant.navigation.estimators.landmark_trials import drive, estimate, paper_manoeuvre
from octant.navigation.sensing.landmark_sensor import LandmarkSensor

SLIPS = (-0.01, 0.008)
PAIR = LandmarkFilter(coupled=False)


@pytest.fixture(scope="module")
def drives():
    return drive(
        paper_manoeuvre(), LandmarkSensor(), LandmarkFilter(), slips=SLIPS, repetitions=100, seed=1
    )


@pytest.mark.parametrize(("rate", "period"), [(0.7, 0.3), (-2.0, 1.1), (1e-9, 0.2), (0.0, 0.5)])
def test_the_transitions_are_matrix_exponentials(rate, period):
    position = np.array([[0, rate, -1], [-rate, 0, 0], [0, 0, 0.0]])
    np.testing.assert_allclose(
        position_transition(rate, period), expm(position * period), atol=1e-14
    )
    attitude = np.array([[0, -1.0], [0, 0]])
    np.testing.assert_allclose(attitude_transition(period), expm(attitude * period), atol=1e-15)


@pytest.mark.parametrize("rate", [0.6, 1e-3, 1e-6, 0.0, -0.4])
def test_the_turn_sensitivity_is_the_derivative_of_the_step(rate):
    place, speed, period, small = np.array([1.5, -0.7]), 0.3, 0.4, 1e-5

    def step(w):
        motion = position_transition(w, period)
        return motion[:2, :2] @ place + motion[:2, 2] * speed

    want = (step(rate + small) - step(rate - small)) / (2 * small)
    got = turn_sensitivity(place, speed_m_per_s=speed, turn_rate_rad_per_s=rate, period_s=period)
    np.testing.assert_allclose(got, want, atol=1e-9)


def test_place_and_slip_are_observable_for_any_motion_that_takes_time():
    nodes, weights = np.polynomial.legendre.leggauss(16)
    gramian, before = np.zeros((3, 3)), np.eye(3)
    rates, periods = np.array([0.5, -0.2]), np.array([1.0, 2.0])
    for rate, period in zip(rates, periods, strict=True):
        seen = position_transition(rate, 0.5 * period * (nodes + 1.0))[:, :2] @ before
        gramian += 0.5 * period * np.einsum("k,kij,kil->jl", weights, seen, seen)
        before = position_transition(rate, period) @ before

    def grow(_, flat, rate):
        phi = flat[:9].reshape(3, 3)
        a = np.array([[0, rate, -1], [-rate, 0, 0], [0, 0, 0.0]])
        return np.concatenate([(a @ phi).ravel(), (phi[:2].T @ phi[:2]).ravel()])

    flat = np.concatenate([np.eye(3).ravel(), np.zeros(9)])
    for rate, period in zip(rates, periods, strict=True):
        flat = solve_ivp(grow, (0, period), flat, args=(rate,), rtol=1e-11, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(gramian, flat[9:].reshape(3, 3), atol=1e-8)
    assert np.linalg.matrix_rank(gramian) == 3


def test_prediction_follows_the_true_motion_with_slips():
    filter_ = LandmarkFilter()
    drives = drive(
        paper_manoeuvre(),
        LandmarkSensor(),
        LandmarkFilter(
            noise=LandmarkNoise(
                position_m2_per_s=0,
                attitude_rad2_per_s=0,
                linear_slip_m2_per_s3=0,
                angular_slip_rad2_per_s3=0,
            )
        ),
        slips=(0.0, 0.0),
        repetitions=1,
        seed=1,
    )
    track = filter_.start(drives.truth[0][:, [0, 1, ATTITUDE]])
    for k in range(1, len(drives.time_s)):
        track = filter_.predict(track, drives.commands[k], period_s=drives.periods_s[k : k + 1])
    np.testing.assert_allclose(track.belief.mean, drives.truth[-1], atol=1e-11)


@pytest.mark.slow
def test_after_a_blackout_of_30_s_the_slips_make_the_difference(drives):
    end = drives.blackout_end(30.0)
    runs = np.arange(len(end))
    for filter_ in (LandmarkFilter(), PAIR):
        error = estimate(drives, filter_).position_error_m(drives)[end, runs]
        assert np.median(error) <= 0.065
        assert np.quantile(error, 0.9) <= 0.115
    without = LandmarkFilter(estimate_slips=False)
    error = estimate(drives, without).position_error_m(drives)[end, runs]
    assert 0.5 < np.median(error) < 0.7


def test_from_a_wrong_start_the_estimate_converges_within_20_s(drives):
    estimates = estimate(drives, LandmarkFilter(), start_error=(2.0, -1.5, 2.5))
    error = estimates.position_error_m(drives)[np.searchsorted(drives.time_s, 20.0)]
    assert np.median(error) <= 0.032
    assert np.quantile(error, 0.9) <= 0.058


@pytest.mark.slow
def test_the_coupled_filter_is_consistent_and_the_pair_is_not(drives):
    low, high = consistency_band(degrees=5, samples=100)
    settled = drives.time_s > 10.0
    mean = estimate(drives, LandmarkFilter()).nees[settled].mean(axis=1)
    assert np.mean((low <= mean) & (mean <= high)) >= 0.95
    assert estimate(drives, PAIR).nees[settled].mean(axis=1).min() > high


def test_the_innovations_are_chi_squared(drives):
    nis = estimate(drives, LandmarkFilter()).nis[drives.time_s > 10.0]
    low, high = consistency_band(degrees=3, samples=int(np.isfinite(nis).sum()), probability=0.999)
    assert low < np.nanmean(nis) < high


def test_the_gate_keeps_false_detections_out():
    sensor = LandmarkSensor(false_probability=0.2)
    filter_ = LandmarkFilter(gate_probability=0.99)
    drives = drive(paper_manoeuvre(), sensor, filter_, slips=SLIPS, repetitions=30, seed=2)
    k = np.searchsorted(drives.time_s, 20.0)
    gated = estimate(drives, filter_).position_error_m(drives)[k]
    believing = LandmarkFilter(restart_after=1)  # takes every outlier for the truth
    fooled = estimate(drives, believing).position_error_m(drives)[k]
    assert np.median(gated) < 0.05
    assert np.quantile(fooled, 0.9) > 10.0 * np.quantile(gated, 0.9)


def test_the_pair_is_the_coupled_filter_without_its_cross_terms():
    still = np.array([[0.0, 0.0]])
    track = PAIR.start([[1.0, 0.5, 0.2]])
    for twist in ([[0.2, 0.3]], still, [[0.1, -0.4]]):
        track = PAIR.predict(track, twist, period_s=0.3)
        track = PAIR.correct(track, [[0.9, 0.4, 0.1]])
    covariance = track.belief.covariance[0]
    assert np.abs(covariance[:3, 3:]).max() == 0.0
    coupled = LandmarkFilter().predict(
        LandmarkFilter().start([[1.0, 0.5, 0.2]]), [[0.2, 0.3]], period_s=0.3
    )
    assert np.abs(coupled.belief.covariance[0, :2, 3:]).min() > 0.0


def test_a_standing_robot_neither_slips_nor_forgets():
    filter_ = LandmarkFilter()
    track = filter_.start([[1.0, 0.5, 0.2]])
    after = filter_.predict(track, [[0.0, 0.0]], period_s=100.0)
    np.testing.assert_array_equal(after.belief.mean, track.belief.mean)
    np.testing.assert_array_equal(after.belief.covariance, track.belief.covariance)


@pytest.mark.parametrize("period", [0.0, -0.1, np.nan])
def test_a_sample_time_that_is_not_positive_is_refused(period):
    filter_ = LandmarkFilter()
    with pytest.raises(NavigationError, match="sample time is"):
        filter_.predict(filter_.start([1.0, 0.0, 0.0]), [0.1, 0.0], period_s=period)


def test_noise_without_measurement_variance_is_refused():
    with pytest.raises(NavigationError, match="measured_attitude_rad2"):
        LandmarkNoise(measured_attitude_rad2=0.0)
