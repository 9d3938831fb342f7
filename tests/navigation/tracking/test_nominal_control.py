"""Nominal control: exact gradients, three solvers, and the thesis' figures."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.tracking import shapes
from octant.navigation.tracking.nominal import (
    BoundedIlqr,
    GainDescent,
    InputSearch,
    gain_cost,
    input_cost,
)
from octant.navigation.tracking.problem import TrackingProblem, Weights, tracking_weights
from octant.navigation.tracking.trajectories import desired_trajectory

REFERENCE = json.loads(
    (Path(__file__).parents[2] / "reference/navigation/closed_loop.json").read_text()
)["adjoint_nominal"]
ROBOT = DifferentialDrive(max_wheel_speed_m_per_s=10 * 0.0825)


def problem(curve, start, *, robot=ROBOT, substeps=12):
    return TrackingProblem(
        desired=desired_trajectory(curve, period_s=0.05),
        start=np.array(start),
        weights=tracking_weights(),
        robot=robot,
        substeps=substeps,
    )


ELLIPSE = problem(shapes.ellipse(), (3.0, -0.2, math.pi / 4))


def summary(task, solution):
    errors = np.linalg.norm(solution.poses[:, :2] - task.desired.poses[:, :2], axis=1)
    heading = abs(solution.poses[-1, 2] - task.desired.poses[-1, 2])
    return errors[:-1].mean(), errors[-1], math.degrees(heading)


def test_the_adjoint_gradient_is_the_reference_to_its_digits():
    gains = np.tile([[0.05, 0.02, 0.01], [0.03, 0.04, 0.012]], (100, 1, 1))
    cost, gradient, poses, rates = gain_cost(ELLIPSE, gains)
    assert cost == pytest.approx(REFERENCE["J"], abs=1e-8)
    assert np.abs(rates).max() == pytest.approx(REFERENCE["max_abs_u"], abs=1e-8)
    for k, pose in REFERENCE["state_at"].items():
        assert poses[12 * int(k)] == pytest.approx(pose, abs=1e-8)
    for k, slope in REFERENCE["dJ_dK"].items():
        assert gradient[int(k[1:])] == pytest.approx(np.array(slope), abs=1e-8)


def test_adjoint_gradients_are_central_differences():
    rng = np.random.default_rng(4)
    gains = rng.normal(0.0, 0.3, (100, 2, 3))
    rates = rng.normal(0.0, 2.0, (100, 2))
    for values, cost_of in (
        (gains, lambda g: gain_cost(ELLIPSE, g)[0]),
        (rates, lambda u: input_cost(ELLIPSE, u)[0]),
    ):
        exact = gain_cost(ELLIPSE, values)[1] if values is gains else input_cost(ELLIPSE, values)[1]
        for flat in rng.choice(values.size, 12, replace=False):
            index = np.unravel_index(flat, values.shape)
            step = np.zeros_like(values)
            step[index] = 1e-6
            slope = (cost_of(values + step) - cost_of(values - step)) / 2e-6
            assert exact[index] == pytest.approx(slope, rel=1e-6, abs=1e-6 * np.abs(exact).max())


def test_a_wheel_at_its_limit_has_no_gradient():
    slow = problem(
        shapes.ellipse(),
        (3.0, -0.2, 0.8),
        robot=DifferentialDrive(max_wheel_speed_m_per_s=0.01 * 0.0825),
    )
    _, gradient, _, rates = gain_cost(slow, np.full((100, 2, 3), 1.0))
    cut = (np.abs(rates).reshape(100, 12, 2) >= 0.01 - 1e-12).all(axis=1)
    assert cut.sum() > 50
    assert not gradient[cut].any()


def test_two_modern_solvers_find_the_same_minimum():
    short = shapes.line((0.0, 0.0), (2.0, 1.0), duration_s=6.0)
    task = problem(short, (0.2, -0.3, 0.0))
    one = BoundedIlqr(tolerance=1e-13, first_rates_rad_per_s=((3.0, 3.0),)).solve(task)
    other = InputSearch(iterations=600, first_rates_rad_per_s=((3.0, 3.0),)).solve(task)
    assert one.cost == pytest.approx(other.cost, rel=1e-6)
    assert one.iterations < other.iterations
    for solution in (one, other):
        assert np.abs(solution.wheel_rates).max() <= ROBOT.max_wheel_rate_rad_per_s


def test_the_ilqr_minimum_has_no_downhill_direction_within_the_bounds():
    solution = BoundedIlqr(tolerance=1e-13, first_rates_rad_per_s=((0.1, 0.1),)).solve(ELLIPSE)
    rates = solution.wheel_rates[::12]
    cost, gradient, _ = input_cost(ELLIPSE, rates)
    assert cost == pytest.approx(solution.cost, rel=1e-12)
    limit = ROBOT.max_wheel_rate_rad_per_s
    free = np.where(
        ((rates >= limit) & (gradient < 0.0)) | ((rates <= -limit) & (gradient > 0.0)),
        0.0,
        gradient,
    )
    start = input_cost(ELLIPSE, np.full((100, 2), 0.1))[1]
    assert np.abs(free).max() < 1e-3 * np.abs(start).max()


@pytest.mark.parametrize(
    ("curve", "start", "average_m"),
    [
        (shapes.ellipse(), (3.0, -0.2, math.pi / 4), 0.07),
        (shapes.parabola(), (-4.0, 5.0, 0.0), 0.21),
        (shapes.sigmoid(), (-3.0, -3.0, math.pi / 4), 0.14),
    ],
    ids=["ellipse", "parabola", "sigmoid"],
)
def test_curves_are_followed_as_closely_as_is_attainable(curve, start, average_m):
    task = problem(curve, start)
    assert summary(task, BoundedIlqr().solve(task))[0] <= average_m


def test_the_point_is_reached_to_two_centimetres_and_a_degree():
    task = problem(shapes.fixed_pose([3.0, 8.0, math.pi / 2]), (0.0, 0.0, math.radians(28.6)))
    _, final, heading = summary(task, BoundedIlqr().solve(task))
    assert final <= 0.02
    assert heading <= 1.0


def test_eight_poses_reach_the_goal():
    for angle in 0.25 * math.pi * np.arange(8):
        task = problem(
            shapes.fixed_pose([0.0, 0.0, math.pi / 2]),
            (4 * math.cos(angle), 4 * math.sin(angle), angle),
        )
        _, final, heading = summary(task, BoundedIlqr().solve(task))
        assert final <= 0.05
        assert heading <= 1.0


def test_the_printed_update_with_a_unit_free_step_only_goes_down():
    solution = GainDescent(iterations=300).solve(ELLIPSE)
    assert solution.cost == pytest.approx(solution.costs.min())
    assert solution.cost < 0.2 * solution.costs[0]


def test_bad_problems_are_one_sentence():
    with pytest.raises(NavigationError, match="never moves"):
        GainDescent().solve(problem(shapes.line(), (0.0, 0.0, 0.0)))
    with pytest.raises(NavigationError, match="momentum"):
        GainDescent(momentum=1.0)
    with pytest.raises(NavigationError, match="substeps"):
        problem(shapes.line(), (0.0, 0.0, 1.0), substeps=7)


@pytest.mark.parametrize(
    ("weight", "match"),
    [
        ([[1.0, 0.2, 0.0], [0.1, 1.0, 0.0], [0.0, 0.0, 1.0]], "not symmetric"),
        ([1.0, 1.0, 0.0], "singular"),
        ([1.0, -1.0, 1.0], "indefinite"),
        ([1.0, 1.0], "shape"),
        ([[1.0, 0.0], [1.0]], "numbers"),
    ],
)
def test_bad_weights_are_one_sentence(weight, match):
    with pytest.raises(NavigationError, match=match):
        Weights(state=weight, final=[1.0, 1.0, 1.0], inputs=[1.0, 1.0])
