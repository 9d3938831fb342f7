"""Odometric localisation against the reference, closed forms and encoders."""

import json
from pathlib import Path

import numpy as np
import pytest
from dead_reckoning import dead_reckon
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import move
from octant.navigation.robot.odometry import (
    Rolling,
    RollingWheels,
    counted_rotation,
    wheel_travel,
)
from octant.navigation.tracking.shapes import lemniscate
from octant.navigation.tracking.trajectories import desired_trajectory

REFERENCE = json.loads(
    (Path(__file__).parents[2] / "reference/navigation/closed_loop.json").read_text()
)["odometry"]
ROBOT = DifferentialDrive()


def integrals(period_s):
    """Way and turn of every interval of the figure of eight, as encoders would count them."""
    fine = desired_trajectory(lemniscate(), period_s=period_s / 200)
    speed, step = fine.speed_m_per_s, fine.period_s
    parts = step / 3.0 * (speed[:-2:2] + 4.0 * speed[1:-1:2] + speed[2::2])  # Simpson
    return parts.reshape(-1, 100).sum(axis=1), np.diff(fine.poses[::200, 2])


@pytest.mark.parametrize("case", REFERENCE["figure8"], ids=lambda c: f"{c['method']}-{c['T']}")
def test_the_figure_of_eight_from_increments_ends_where_the_reference_ends(case):
    distance, turn = integrals(case["T"])
    desired = desired_trajectory(lemniscate(), period_s=case["T"])
    poses = dead_reckon(desired.poses[0], distance_m=distance, turn_rad=turn, method=case["method"])
    assert poses[-1] == pytest.approx(case["final"], abs=2e-9)
    error = np.linalg.norm(poses[:, :2] - desired.poses[:, :2], axis=1).max()
    assert error == pytest.approx(case["max_err"], abs=2e-9)


@pytest.mark.parametrize("method", ["euler", "rk2", "exact"])
def test_a_constant_twist_ends_where_the_reference_ends(method):
    poses = dead_reckon(
        np.zeros(3), distance_m=np.full(20, 0.25), turn_rad=np.full(20, 0.2), method=method
    )
    wanted = REFERENCE["constant_twist_v0.5_w0.4_T0.5_n20"][method]
    assert poses[-1] == pytest.approx(wanted, abs=1e-9)


@given(st.floats(-1.0, 1.0), st.floats(-3.0, 3.0).filter(lambda w: abs(w) > 1e-3), st.floats(-3, 3))
def test_the_exact_step_is_the_circle_of_the_textbook(way, turn, heading):
    moved = move([0.0, 0.0, heading], distance_m=way, turn_rad=turn)
    radius = way / turn
    x = radius * (np.sin(heading + turn) - np.sin(heading))
    y = -radius * (np.cos(heading + turn) - np.cos(heading))
    assert moved == pytest.approx([x, y, heading + turn], abs=1e-10)


def test_all_steps_agree_on_a_straight_line_and_differ_by_their_order_on_an_arc():
    straight = [
        move([0, 0, 0.7], distance_m=0.3, turn_rad=0.0, method=m) for m in ("euler", "rk2", "exact")
    ]
    assert np.ptp(straight, axis=0).max() == 0.0
    errors = {}
    for method in ("euler", "rk2"):
        for turn in (0.2, 0.1):
            exact = move([0, 0, 0], distance_m=turn, turn_rad=turn)
            other = move([0, 0, 0], distance_m=turn, turn_rad=turn, method=method)
            errors[method, turn] = np.linalg.norm(exact - other)
    assert errors["euler", 0.2] / errors["euler", 0.1] == pytest.approx(4.0, rel=0.02)
    assert errors["rk2", 0.2] / errors["rk2", 0.1] == pytest.approx(8.0, rel=0.02)


def test_the_exact_step_is_the_robots_own_arc():
    rates = np.array([3.0, -1.5])
    way, turn = wheel_travel(0.4 * rates, ROBOT)
    arc = ROBOT.step_arc([1.0, 2.0, 0.5], rates, period_s=0.4)
    assert move([1.0, 2.0, 0.5], distance_m=way, turn_rad=turn) == pytest.approx(arc, abs=1e-15)


def test_an_encoder_loses_less_than_one_count_over_any_time():
    rates = np.random.default_rng(1).normal(0.0, 5.0, (500, 2))
    turned = np.cumsum(0.1 * rates, axis=0)
    counted = counted_rotation(turned, tick_rad=0.05)
    assert np.allclose(np.round(counted / 0.05), counted / 0.05, atol=1e-9)
    off = turned - counted
    assert (off > -1e-9).all()
    assert (off < 0.05 + 1e-9).all()


def test_a_wrong_method_or_tick_is_one_sentence():
    with pytest.raises(NavigationError, match="must be one of"):
        move([0, 0, 0], distance_m=1.0, turn_rad=0.0, method="heun")
    with pytest.raises(NavigationError, match="tick_rad is 0"):
        counted_rotation(np.ones((1, 2)), tick_rad=0.0)


def test_turned_is_the_inverse_of_roll():
    rolling = Rolling(slip_sd=0.05, scale_sd=0.02, linear_m_per_s=-0.01, angular_rad_per_s=0.1)
    robot = DifferentialDrive()
    forth, back = (RollingWheels(rolling, robot, np.random.default_rng(3)) for _ in range(2))
    for rotations in ([0.3, 0.5], [-1.0, 2.0], [0.0, 0.1]):
        rolled = forth.roll(np.array(rotations), period_s=0.7)
        np.testing.assert_allclose(back.turned(rolled, period_s=0.7), rotations, atol=1e-12)
