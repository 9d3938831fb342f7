"""Pose estimators: filters against one another and against closed forms, SLAM, particles."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from octant.geometries.errors import NavigationError
from octant.navigation.estimators.ekf_slam import SlamTask, run_slam, tag_innovation
from octant.navigation.estimators.fingerprint import FingerprintFilter
from octant.navigation.estimators.kalman import Gaussian, innovate, update
from octant.navigation.estimators.particle import ParticleFilter
from octant.navigation.estimators.pose_filters import WheelMotion
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    KalmanBucy,
    RssAssumptions,
    UnscentedKalman,
    predict_motion,
)
from octant.navigation.robot.drive import DifferentialDrive, linear_model
from octant.navigation.sensing.rss_maps import RssMap
from octant.navigation.sensing.rss_models import LogExponentialLaw, TagMesh, tag_grid
from octant.navigation.tracking.closed_loop import run_seeds

REFERENCE = json.loads(
    (Path(__file__).parents[2] / "reference/navigation/closed_loop.json").read_text()
)["ekf_slam_step"]
ROBOT = DifferentialDrive()
MESH = TagMesh(tags_m=tag_grid(4, spacing_m=2.5, height_m=2.7), law=LogExponentialLaw())
MOTION = WheelMotion(robot=ROBOT, period_s=0.1, rate_sigma_rad_per_s=0.4)
RATES = np.array([[4.0, 2.5]])


class Plane:
    """RSS that is linear in the place: every Kalman filter is exact on it."""

    slopes = np.array([[3.0, -1.0], [0.5, 2.0], [-2.0, 1.0], [1.0, 1.0], [4.0, 0.0]])

    def rss_dbm(self, places_m):
        return places_m @ self.slopes.T - 60.0

    def slopes_db_per_m(self, places_m):
        return np.tile(self.slopes, (len(places_m), 1, 1))


def belief_of(states):
    rng = np.random.default_rng(4)
    root = 0.1 * rng.normal(size=(states, states))
    mean = np.zeros((1, states))
    mean[0, :3] = [0.4, -0.7, 0.9]
    return Gaussian(mean=mean, covariance=(root @ root.T + 0.01 * np.eye(states))[None])


def test_jacobians_are_those_of_the_runge_kutta_step():
    motion = WheelMotion(robot=ROBOT, period_s=0.1, rate_sigma_rad_per_s=0.1, method="rk2")
    pose = np.array([[0.3, -0.2, 0.8]])
    by_pose, by_rates = motion.jacobians(pose, RATES)
    for matrix, values, moved in (
        (by_pose, pose, lambda v: motion.moved(v, RATES)),
        (by_rates, RATES, lambda v: motion.moved(pose, v)),
    ):
        for column in range(values.shape[1]):
            step = 1e-6 * np.eye(values.shape[1])[column]
            slope = (moved(values + step) - moved(values - step)) / 2e-6
            assert matrix[:, :, column] == pytest.approx(slope, abs=1e-9)


@pytest.mark.parametrize("states", [3, 4])
def test_the_extended_filter_is_the_joseph_update_with_all_readings(states):
    assumed = RssAssumptions(sigma_db=3.0, mean_sigma_db=1.0 if states == 4 else 0.0)
    belief, rss = belief_of(states), MESH.rss_dbm(np.array([[0.5, -0.6]])) + 2.0
    found = ExtendedKalman(motion=MOTION, sensor=MESH, noise=assumed).step(belief, RATES, rss, [])
    moved = predict_motion(MOTION, belief, RATES)
    slopes = np.zeros((1, 16, states))
    slopes[:, :, :2] = MESH.slopes_db_per_m(moved.mean[:, :2])
    slopes[:, :, 3:] = 1.0
    whole = update(
        moved,
        innovate(
            moved,
            rss,
            observation=slopes,
            measurement_noise=9.0 * np.eye(16),
            predicted=MESH.rss_dbm(moved.mean[:, :2]),
        ),
    )
    assert found.mean == pytest.approx(whole.mean, abs=1e-12)
    assert found.covariance == pytest.approx(whole.covariance, abs=1e-13)


@pytest.mark.parametrize("states", [3, 4])
def test_the_unscented_filter_is_the_kalman_filter_where_readings_are_linear(states):
    assumed = RssAssumptions(sigma_db=0.7, mean_sigma_db=1.0 if states == 4 else 0.0)
    belief, rss = belief_of(states), Plane().rss_dbm(np.array([[0.5, -0.6]])) + 0.3
    one, other = (
        kind(motion=MOTION, sensor=Plane(), noise=assumed).step(belief, RATES, rss, [])
        for kind in (ExtendedKalman, UnscentedKalman)
    )
    assert one.mean == pytest.approx(other.mean, abs=1e-11)
    assert one.covariance == pytest.approx(other.covariance, abs=1e-12)


def test_the_continuous_filter_tends_to_its_differential_equations():
    """(7.44), (7.45) with N_C = s² T and W_C = s_u² T, integrated by other means."""
    assumed = RssAssumptions(sigma_db=5.0, mean_sigma_db=0.0)
    belief, rss = belief_of(3), MESH.rss_dbm(np.array([[0.45, -0.66]]))

    def slope(_, flat):
        mean, spread = flat[:3], flat[3:].reshape(3, 3)
        f, g = (m[0] for m in linear_model(mean[None], RATES, ROBOT))
        h = np.zeros((16, 3))
        h[:, :2] = MESH.slopes_db_per_m(mean[None, :2])[0]
        gain = spread @ h.T / (25.0 * 0.1)
        drift = ROBOT.pose_rate(mean, RATES[0]) + gain @ (rss - MESH.rss_dbm(mean[None, :2]))[0]
        growth = f @ spread + spread @ f.T + 0.4**2 * 0.1 * g @ g.T - gain @ h @ spread
        return np.concatenate([drift, growth.ravel()])

    first = np.concatenate([belief.mean[0], belief.covariance[0].ravel()])
    exact = solve_ivp(slope, (0.0, 0.1), first, rtol=1e-11, atol=1e-13, method="LSODA").y[:, -1]
    errors = []
    for substeps in (20, 40):
        bucy = KalmanBucy(motion=MOTION, sensor=MESH, noise=assumed, substeps=substeps)
        found = bucy.step(belief, RATES, rss, [])
        both = np.concatenate([found.mean[0], found.covariance[0].ravel()])
        errors.append(np.abs(both - exact).max())
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.1)
    assert errors[1] < 2e-3


def test_without_a_reading_only_the_motion_counts():
    belief = belief_of(3)
    for kind in (ExtendedKalman, UnscentedKalman):
        found = kind(motion=MOTION, sensor=MESH, noise=RssAssumptions()).step(
            belief, RATES, None, []
        )
        assert found.mean == pytest.approx(MOTION.moved(belief.mean, RATES))
        assert np.trace(found.covariance[0]) > np.trace(belief.covariance[0])


def test_particles_tend_to_the_kalman_filter_where_it_is_exact():
    assumed = RssAssumptions(sigma_db=0.5, mean_sigma_db=0.0)
    kalman = ExtendedKalman(motion=MOTION, sensor=Plane(), noise=assumed)
    particles = ParticleFilter(
        motion=MOTION, sensor=Plane(), sigma_db=0.5, particles=40000, jitter_m=0.0, jitter_rad=0.0
    )
    rngs, pose = [np.random.default_rng(1)], np.array([[0.0, 0.0, 0.3]])
    spread = np.diag([0.01, 0.02, 0.0004])
    exact, sampled = kalman.begin(pose, spread, rngs), particles.begin(pose, spread, rngs)
    for k in range(3):
        rss = Plane().rss_dbm(np.array([[0.03 * k, 0.05]]))
        exact = kalman.step(exact, RATES, rss, rngs)
        sampled = particles.step(sampled, RATES, rss, rngs)
    sigma = np.sqrt(np.diagonal(exact.covariance[0]))
    assert (np.abs(kalman.poses(exact) - particles.poses(sampled))[0] < 0.05 * sigma).all()
    assert sampled.weights.sum(axis=1) == pytest.approx(1.0)


def survey():
    axis = np.linspace(-2.0, 2.0, 21)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel()])
    return RssMap(x_m=axis, y_m=axis, rss=MESH.rss_dbm(places).reshape(21, 21, -1))


def test_a_fingerprint_without_noise_is_found_within_the_survey_grid():
    prints = FingerprintFilter(motion=MOTION, survey=survey(), sigma_m=0.1, neighbours=1)
    places = np.random.default_rng(2).uniform(-1.9, 1.9, (30, 2))
    fixes = prints.fix_m(MESH.rss_dbm(places))
    assert np.abs(fixes - places).max() < 0.2
    belief = prints.begin(np.zeros((1, 3)), 0.04 * np.eye(3), [])
    heard = prints.step(belief, np.zeros((1, 2)), MESH.rss_dbm(np.array([[0.2, 0.0]])), [])
    assert 0.1 < prints.poses(heard)[0, 0] < 0.2


def test_the_slam_step_is_the_reference_to_its_digits():
    spread = np.diag(REFERENCE["S_diag"])
    spread[0, 3] = spread[3, 0] = REFERENCE["S_03"]
    belief = Gaussian(mean=np.array([REFERENCE["mu"]]), covariance=spread[None])
    found = tag_innovation(belief, 0, np.array([REFERENCE["z"]]), np.diag([1.5**2, 0.9**2]))
    assert found.residual[0] == pytest.approx(REFERENCE["innovation"], abs=1e-8)
    assert found.observation[0] == pytest.approx(np.array(REFERENCE["H"]), abs=1e-8)
    gain = belief.covariance[0] @ found.observation[0].T @ np.linalg.inv(found.covariance[0])
    assert gain == pytest.approx(np.array(REFERENCE["K"]), abs=1e-8)
    after = update(belief, found)
    assert after.mean[0] == pytest.approx(REFERENCE["mu_new"], abs=1e-8)
    assert np.diagonal(after.covariance[0]) == pytest.approx(REFERENCE["S_new_diag"], abs=1e-8)


def test_a_tag_behind_the_robot_gives_a_small_wrapped_innovation():
    belief = Gaussian(mean=np.array([[0.0, 0.0, 0.0, -2.0, 0.1]]), covariance=np.eye(5)[None])
    measured = np.array([[2.0, -math.pi + 0.05]])  # the tag really stands on the other side of -x
    found = tag_innovation(belief, 0, measured, np.eye(2))
    assert abs(found.residual[0, 1]) < 0.2


def slam_task(**changes):
    given = {
        "motion": WheelMotion(robot=ROBOT, period_s=0.1, rate_sigma_rad_per_s=0.01),
        "start": [1.0, 0.0, math.pi / 2],
        "wheel_rates_rad_per_s": [2.0, 2.0],
        "steps": 182,
        "tags_m": [[-0.2, 0.1], [2.1, 0.1], [2.1, 3.1], [-0.2, 3.1]],
    }
    return SlamTask(**{**given, **changes})


def test_slam_is_consistent_and_never_diverges_in_a_hundred_runs():
    record = run_slam(slam_task(), run_seeds(1, 100))
    assert np.median(record.final_error_m) <= 0.007
    assert np.quantile(record.final_error_m, 0.9) <= 0.016
    assert 2.0 <= record.nees.mean() <= 3.5
    assert not record.diverged.any()


def test_slam_with_good_sensors_finds_the_tags_and_beats_dead_reckoning():
    task = slam_task(
        motion=WheelMotion(robot=ROBOT, period_s=0.1, rate_sigma_rad_per_s=0.3),
        tag_sigma_m=0.1,
        range_sigma_m=0.05,
        bearing_sigma_rad=0.05,
    )
    record = run_slam(task, run_seeds(2, 10))
    assert np.median(record.final_error_m) < 0.5 * np.median(record.reckoned_error_m)
    off = record.final.mean[:, 3:] - np.ravel(task.tags_m)
    assert np.sqrt(np.mean(off**2)) < 0.1


def test_bad_filters_are_one_sentence():
    with pytest.raises(NavigationError, match="covariance of range and bearing"):
        slam_task(range_sigma_m=0.0)
    with pytest.raises(NavigationError, match="SLAM needs"):
        slam_task(steps=0)
    with pytest.raises(NavigationError, match="must not be zero"):
        ParticleFilter(motion=MOTION, sensor=MESH, sigma_db=0.0)
    with pytest.raises(NavigationError, match="must not be zero"):
        FingerprintFilter(motion=MOTION, survey=survey(), sigma_m=0.0)
