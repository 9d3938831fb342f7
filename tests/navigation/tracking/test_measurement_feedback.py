"""Measurement feedback of chapter 6: exact gradients, training, replay against fresh noise."""

import math
from dataclasses import replace

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.rss_models import LogExponentialLaw, RssNoise, TagMesh, tag_grid
from octant.navigation.sensing.tag_frames import Hearing, Polling, RssCodes
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import run_seeds
from octant.navigation.tracking.controllers import MeasurementFeedback
from octant.navigation.tracking.measurement_feedback import (
    FeedbackTask,
    FeedbackTraining,
    replay_and_fresh_m,
    run_feedback,
    run_heard,
)
from octant.navigation.tracking.problem import TrackingProblem, tracking_weights
from octant.navigation.tracking.trajectories import desired_trajectory

ROBOT = DifferentialDrive(max_wheel_speed_m_per_s=12.1 * 0.0825)
TAGS = tag_grid(3, spacing_m=3.0, height_m=3.0)


def task_of(curve, start):
    problem = TrackingProblem(
        desired=desired_trajectory(curve, period_s=0.1),
        start=np.array(start),
        weights=tracking_weights(),
        robot=ROBOT,
    )
    return FeedbackTask(problem=problem, tags_m=TAGS, law=LogExponentialLaw())


LINE = task_of(shapes.line(), (-3.5, -4.0, 0.0))
SINE = task_of(shapes.sine(), (-2.5, 1.5, 0.0))


def test_the_gradient_is_central_differences():
    rng = np.random.default_rng(1)
    noise = RssNoise().draw(LINE.record_shape, rng)
    gains = rng.normal(0.0, 2e-3, (600, 2, 9))
    exact = run_feedback(LINE, gains, noise).gradient
    for flat in rng.choice(gains.size, 15, replace=False):
        index = np.unravel_index(flat, gains.shape)
        step = np.zeros_like(gains)
        step[index] = 1e-8
        ahead, behind = (run_feedback(LINE, gains + s * step, noise).cost for s in (1, -1))
        slope = (ahead - behind) / 2e-8
        assert exact[index] == pytest.approx(slope, rel=1e-6, abs=1e-6 * np.abs(exact).max())


def test_the_loop_is_the_thesis_law_in_plain_words():
    rng = np.random.default_rng(2)
    noise = RssNoise().draw(LINE.record_shape, rng)
    gains = rng.normal(0.0, 5e-3, (600, 2, 9))
    run = run_feedback(LINE, gains, noise)
    mesh, law = TagMesh(tags_m=TAGS, law=LogExponentialLaw()), MeasurementFeedback(gains=gains)
    pose = LINE.problem.start
    for k in range(600):
        rss = mesh.rss_dbm(pose[None, :2]) + noise[k]
        rates = ROBOT.saturate(law.wheel_rates(k, pose[None], rss))[0]
        assert rates == pytest.approx(run.wheel_rates[k], abs=1e-9)
        pose = ROBOT.step_euler(pose, rates, period_s=0.1)
    assert pose == pytest.approx(run.poses[-1], abs=1e-7)


def test_the_gradient_knows_the_range_of_the_tags():
    rng = np.random.default_rng(3)
    near = replace(LINE, range_m=6.0)
    noise = RssNoise().draw(near.record_shape, rng)
    gains = rng.normal(0.0, 2e-3, (600, 2, 9))
    exact = run_feedback(near, gains, noise).gradient
    assert (exact == 0.0).any()
    for flat in rng.choice(np.flatnonzero(exact), 8, replace=False):
        index = np.unravel_index(flat, gains.shape)
        step = np.zeros_like(gains)
        step[index] = 1e-8
        ahead, behind = (run_feedback(near, gains + s * step, noise).cost for s in (1, -1))
        slope = (ahead - behind) / 2e-8
        assert exact[index] == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(exact).max())


def test_what_is_heard_at_once_and_in_fine_codes_is_the_same_run():
    rng = np.random.default_rng(4)
    near = replace(LINE, range_m=6.0)
    noise = RssNoise().draw(near.record_shape, rng)
    gains = rng.normal(0.0, 2e-3, (600, 2, 9))
    fine = RssCodes(bits=16, floor_dbm=-800.0, full_scale_dbm=500.0)
    exact = run_feedback(near, gains, noise)
    coded = run_heard(near, gains, noise, Hearing(tags_m=TAGS, range_m=6.0, codes=fine))
    assert coded.poses[:20] == pytest.approx(exact.poses[:20], abs=1e-3)
    polled = Hearing(tags_m=TAGS, polling=Polling(tags=9, bit_rate_hz=1e9))
    at_once = run_heard(LINE, gains, noise, polled)
    assert at_once.cost == pytest.approx(run_feedback(LINE, gains, noise).cost, rel=1e-9)


@pytest.mark.parametrize(("task", "limit_m"), [(LINE, 0.07), (SINE, 0.08)], ids=["line", "sine"])
def test_a_replayed_record_is_followed_and_fresh_noise_is_not(task, limit_m):
    for seed in run_seeds(1, 2):
        errors, _, _ = replay_and_fresh_m(task, RssNoise(), FeedbackTraining(), seed)
        assert errors[0] <= limit_m
        assert errors[1] > 2.0 * errors[0]


def test_training_over_many_records_generalises_better_than_over_one():
    rng = np.random.default_rng(5)
    training = FeedbackTraining(iterations=500, momentum=0.98)
    many = RssNoise().draw((8, *LINE.record_shape), rng)
    fresh = RssNoise().draw((6, *LINE.record_shape), rng)
    errors = []
    for records in (many[:1], many):
        gains, costs = training.train(LINE, records)
        assert costs.min() < 0.01 * costs[0]
        runs = [run_feedback(LINE, gains, noise) for noise in fresh]
        errors.append(np.median([run.cost for run in runs]))
    assert errors[1] < errors[0]


def test_bad_training_and_tasks_are_one_sentence():
    with pytest.raises(NavigationError, match="momentum"):
        FeedbackTraining(momentum=-0.1)
    with pytest.raises(NavigationError, match="shape"):
        FeedbackTraining(iterations=1).train(LINE, np.zeros((1, 5, 9)))
    held = TrackingProblem(
        desired=LINE.problem.desired,
        start=np.array([0.0, 0.0, math.pi]),
        weights=tracking_weights(),
        robot=ROBOT,
        substeps=2,
    )
    with pytest.raises(NavigationError, match="substeps"):
        FeedbackTask(problem=held, tags_m=TAGS, law=LogExponentialLaw())
