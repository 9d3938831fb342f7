"""Neighbouring control: gains, theory, filters, peers, and the thesis' figures over 50 seeds."""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from octant.geometries.errors import NavigationError
from octant.navigation.estimators.pose_filters import DeadReckoning, WheelMotion
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    KalmanBucy,
    RssAssumptions,
    UnscentedKalman,
)
from octant.navigation.robot.drive import DifferentialDrive, linear_model
from octant.navigation.robot.odometry import Rolling
from octant.navigation.sensing.rss_models import LogExponentialLaw, RssNoise, TagMesh, tag_grid
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import World, drive, run_seeds
from octant.navigation.tracking.controllers import (
    NeighbouringControl,
    OpenLoop,
    PredictiveControl,
)
from octant.navigation.tracking.neighbouring import (
    riccati_gains,
    stability_report,
)
from octant.navigation.tracking.nominal import BoundedIlqr
from octant.navigation.tracking.problem import (
    TrackingProblem,
    stabilisation_weights,
    tracking_weights,
)
from octant.navigation.tracking.trajectories import desired_trajectory

REFERENCE = json.loads(
    (Path(__file__).parents[2] / "reference/navigation/closed_loop.json").read_text()
)["lqr_neighbouring"]
ROBOT = DifferentialDrive(max_wheel_speed_m_per_s=10 * 0.0825)
EIGHT = desired_trajectory(shapes.lemniscate(), period_s=0.1)
MESH = TagMesh(tags_m=tag_grid(5, spacing_m=3.0, height_m=3.0), law=LogExponentialLaw())
MOTION = WheelMotion(robot=ROBOT, period_s=0.1, rate_sigma_rad_per_s=0.1)
EKF = ExtendedKalman(motion=MOTION, sensor=MESH, noise=RssAssumptions())
WORLD = World(
    robot=ROBOT,
    period_s=0.1,
    sensor=MESH,
    noise=RssNoise(),
    rate_sigma_rad_per_s=0.1,
    start_covariance=[0.05**2, 0.05**2, math.radians(3.0) ** 2],
)


def neighbouring(curve, start, weights):
    fine = TrackingProblem(
        desired=desired_trajectory(curve, period_s=0.05),
        start=np.array(start),
        weights=weights,
        robot=ROBOT,
        substeps=2,
    )
    nominal = BoundedIlqr().solve(fine)
    poses, rates = nominal.poses[:-1:2], nominal.wheel_rates[::2]
    gains = riccati_gains(poses, rates, ROBOT, weights=weights, period_s=0.1)
    return NeighbouringControl(nominal_poses=poses, nominal_rates=rates, gains=gains.gains)


@pytest.fixture(scope="module")
def control():
    return neighbouring(shapes.lemniscate(), (0.5, 0.0, 0.0), tracking_weights())


def median_and_90(values):
    return float(np.median(values)), float(np.quantile(values, 0.9))


def test_riccati_gains_are_the_reference_to_its_digits():
    rates = EIGHT.wheel_rates(ROBOT)
    for k, wanted in REFERENCE["u_d"].items():
        assert rates[int(k)] == pytest.approx(wanted, abs=1e-8)
    found = riccati_gains(
        EIGHT.poses[:-1], rates[:-1], ROBOT, weights=tracking_weights(), period_s=0.1
    )
    for k, wanted in REFERENCE["C"].items():
        assert found.gains[int(k)] == pytest.approx(np.array(wanted), abs=1e-7)


def test_the_linear_model_is_the_derivative_of_the_pose_rate():
    rng = np.random.default_rng(1)
    poses, rates = rng.normal(size=(5, 3)), rng.normal(size=(5, 2))
    f, g = linear_model(poses, rates, ROBOT)
    for column in range(3):
        step = 1e-6 * np.eye(3)[column]
        slope = (ROBOT.pose_rate(poses + step, rates) - ROBOT.pose_rate(poses - step, rates)) / 2e-6
        assert f[:, :, column] == pytest.approx(slope, abs=1e-9)
    for column in range(2):
        step = 1e-6 * np.eye(2)[column]
        slope = (ROBOT.pose_rate(poses, rates + step) - ROBOT.pose_rate(poses, rates - step)) / 2e-6
        assert g[:, :, column] == pytest.approx(slope, abs=1e-9)


def test_sampled_gains_tend_to_the_continuous_riccati_equation():
    weights, errors = tracking_weights(), []

    def slope(t, flat):
        at = np.array([t])
        _, velocity, acceleration = shapes.lemniscate().motion(at)
        speed = np.hypot(*velocity[0])
        turn = (
            velocity[0, 0] * acceleration[0, 1] - velocity[0, 1] * acceleration[0, 0]
        ) / speed**2
        pose = np.array([[0.0, 0.0, np.arctan2(velocity[0, 1], velocity[0, 0])]])
        rates = ROBOT.wheel_rates(speed_m_per_s=[speed], turn_rate_rad_per_s=[turn])
        f, g = (m[0] for m in linear_model(pose, rates, ROBOT))
        p = flat.reshape(3, 3)
        gain = np.linalg.solve(weights.inputs, g.T @ p)
        return (-f.T @ p - weights.state - p @ f + p @ g @ gain).ravel()

    exact = (
        solve_ivp(
            slope, (60.0, 55.0), weights.final.ravel(), rtol=1e-10, atol=1e-12, method="LSODA"
        )
        .y[:, -1]
        .reshape(3, 3)
    )
    for period in (0.02, 0.01):
        fine = desired_trajectory(shapes.lemniscate(), period_s=period)
        found = riccati_gains(
            fine.poses[:-1],
            fine.wheel_rates(ROBOT)[:-1],
            ROBOT,
            weights=weights,
            period_s=period,
        )
        errors.append(np.abs(found.cost_to_go[round(55.0 / period)] - exact).max())
    assert errors[1] < 0.6 * errors[0] < 0.05


def test_the_theory_of_stability_holds_and_notices_what_breaks_it():
    weights, rates = tracking_weights(), EIGHT.wheel_rates(ROBOT)[:-1]
    riccati = riccati_gains(EIGHT.poses[:-1], rates, ROBOT, weights=weights, period_s=0.1)
    report = stability_report(
        EIGHT.poses[:-1], rates, ROBOT, riccati=riccati, weights=weights, period_s=0.1
    )
    assert report.lyapunov_decay > 0.0
    assert report.observability > 0.0
    assert report.controllability > 0.0
    still = np.zeros((600, 2))
    standing = np.tile([0.0, 0.0, 0.3], (600, 1))
    frozen = stability_report(
        standing, still, ROBOT, riccati=riccati, weights=weights, period_s=0.1
    )
    assert frozen.controllability < 1e-12  # a standing robot cannot be steered sideways


def test_the_lemniscate_is_followed_within_ten_centimetres(control):
    record = drive(control, EKF, WORLD, EIGHT, start=(0.5, 0.0, 0.0), seeds=run_seeds(1, 50))
    average = median_and_90(record.average_error_m)
    assert average[0] <= 0.10
    assert average[1] <= 0.12
    within = median_and_90(record.share_within_m(0.9))
    assert within[0] <= 0.18
    assert within[1] <= 0.23


def test_the_point_is_held_within_five_centimetres():
    weights = stabilisation_weights()
    point = shapes.fixed_pose([3.0, 8.0, math.pi / 2])
    start = (0.0, 0.0, math.radians(28.6))
    record = drive(
        neighbouring(point, start, weights),
        EKF,
        WORLD,
        desired_trajectory(point, period_s=0.1),
        start=start,
        seeds=run_seeds(1, 50),
    )
    final = median_and_90(record.final_error_m)
    assert final[0] <= 0.05
    assert final[1] <= 0.11


def test_an_ignored_noise_mean_ruins_the_way(control):
    ignoring = ExtendedKalman(motion=MOTION, sensor=MESH, noise=RssAssumptions(mean_sigma_db=0.0))
    record = drive(control, ignoring, WORLD, EIGHT, start=(0.5, 0.0, 0.0), seeds=run_seeds(1, 6))
    assert 0.3 < np.median(record.average_error_m) < 0.5


@pytest.mark.parametrize("kind", [KalmanBucy, UnscentedKalman], ids=lambda k: k.__name__)
def test_the_peers_of_the_filter_do_as_well(control, kind):
    estimator = kind(motion=MOTION, sensor=MESH, noise=RssAssumptions())
    record = drive(control, estimator, WORLD, EIGHT, start=(0.5, 0.0, 0.0), seeds=run_seeds(1, 10))
    assert np.median(record.average_error_m) <= 0.10


def test_predictive_control_does_as_well_and_keeps_the_limits():
    control = PredictiveControl(desired=EIGHT, robot=ROBOT, weights=tracking_weights())
    record = drive(control, EKF, WORLD, EIGHT, start=(0.5, 0.0, 0.0), seeds=run_seeds(1, 10))
    assert np.median(record.average_error_m) <= 0.12
    assert np.abs(record.wheel_rates).max() <= ROBOT.max_wheel_rate_rad_per_s


def test_a_run_depends_on_its_seed_alone(control):
    start, seeds = (0.5, 0.0, 0.0), run_seeds(3, 4)
    together = drive(control, EKF, WORLD, EIGHT, start=start, seeds=seeds)
    alone = drive(control, EKF, WORLD, EIGHT, start=start, seeds=seeds[2:3])
    assert (together.poses[2] == alone.poses[0]).all()
    again = drive(control, EKF, WORLD, EIGHT, start=start, seeds=run_seeds(3, 4))
    assert (together.poses == again.poses).all()


def test_encoders_make_dead_reckoning_follow_the_real_wheels(control):
    largest = {}
    for tick in (0.0, 0.01):
        world = World(
            robot=ROBOT,
            period_s=0.1,
            sensor=MESH,
            noise=RssNoise(),
            rate_sigma_rad_per_s=0.5,
            start_covariance=np.full(3, 1e-12),
            rolling=Rolling(tick_rad=tick),
        )
        reckoned = DeadReckoning(motion=MOTION)
        record = drive(control, reckoned, world, EIGHT, start=(0.5, 0, 0), seeds=run_seeds(1, 3))
        off = record.poses[..., :2] - record.estimates[..., :2]
        largest[tick] = np.linalg.norm(off, axis=-1).max()
    assert largest[0.01] < 0.05  # counts are never lost
    assert largest[0.0] > 0.5  # and commands are not what the wheels do


def test_a_new_controller_and_a_new_estimator_are_one_class_each():
    @dataclass(frozen=True)
    class Pursuit:
        desired: object

        def wheel_rates(self, step, poses, rss_dbm):
            del rss_dbm
            goal = self.desired.poses[min(step + 5, self.desired.steps)]
            away = goal[:2] - poses[:, :2]
            bearing = np.arctan2(away[:, 1], away[:, 0]) - poses[:, 2]
            turn = 3.0 * np.arctan2(np.sin(bearing), np.cos(bearing))
            return ROBOT.wheel_rates(
                speed_m_per_s=2.0 * np.hypot(*away.T), turn_rate_rad_per_s=turn
            )

    @dataclass(frozen=True)
    class NearestOfFour:
        motion: object
        sensor: object

        def begin(self, poses, covariance, rngs):
            del covariance, rngs
            return poses

        def step(self, belief, wheel_rates, rss_dbm, rngs):
            del rngs
            moved = self.motion.moved(belief, wheel_rates)
            if rss_dbm is None:
                return moved
            best, lowest = moved, np.full(len(moved), np.inf)
            for dx, dy in ((0.0, 0.0), (0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)):
                there = moved + np.array([dx, dy, 0.0])
                cost = np.sum((self.sensor.rss_dbm(there[:, :2]) - rss_dbm) ** 2, axis=1)
                best = np.where((cost < lowest)[:, None], there, best)
                lowest = np.minimum(cost, lowest)
            return best

        def poses(self, belief):
            return belief

    quiet = World(
        robot=ROBOT,
        period_s=0.1,
        sensor=MESH,
        noise=RssNoise(mean_db=0.0, sigma_db=1.0),
        rate_sigma_rad_per_s=0.1,
        start_covariance=np.full(3, 1e-4),
    )
    record = drive(
        Pursuit(EIGHT),
        NearestOfFour(MOTION, MESH),
        quiet,
        EIGHT,
        start=(0.5, 0.0, 0.0),
        seeds=run_seeds(1, 2),
    )
    assert record.average_error_m.max() < 0.3


def test_bad_worlds_and_filters_are_one_sentence(control):
    with pytest.raises(NavigationError, match="covariance must not be zero"):
        WheelMotion(robot=ROBOT, period_s=0.1, rate_sigma_rad_per_s=0.0)
    with pytest.raises(NavigationError, match="must not be zero"):
        RssAssumptions(sigma_db=0.0)
    slow = desired_trajectory(shapes.lemniscate(), period_s=0.2)
    with pytest.raises(NavigationError, match="sample it at the same"):
        drive(control, EKF, WORLD, slow, start=(0, 0, 0), seeds=run_seeds(1, 1))
    with pytest.raises(NavigationError, match="horizon"):
        PredictiveControl(desired=EIGHT, robot=ROBOT, weights=tracking_weights(), horizon=0)
    with pytest.raises(NavigationError, match="runs is 0"):
        run_seeds(1, 0)


def test_open_loop_plays_its_rates():
    play = OpenLoop(rates=np.arange(6.0).reshape(3, 2))
    assert (play.wheel_rates(1, np.zeros((4, 3)), np.zeros((4, 2))) == [2.0, 3.0]).all()
