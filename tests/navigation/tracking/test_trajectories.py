"""Desired trajectories: their feed-forward drives an ideal robot along them."""

import numpy as np
import pytest
from dead_reckoning import dead_reckon

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.tracking import shapes
from octant.navigation.tracking.trajectories import Curve, check_feasible, desired_trajectory

ROBOT = DifferentialDrive(max_wheel_speed_m_per_s=10 * 0.0825)
CURVES = [
    shapes.line(),
    shapes.sine(),
    shapes.sigmoid(),
    shapes.parabola(),
    shapes.ellipse(),
    shapes.lemniscate(),
    shapes.u_shape(),
    shapes.spline([[0, 0], [2, 0], [2, 2], [0, 2]], duration_s=40.0, closed=True),
    shapes.spline([[0, 0], [2, 1], [4, 0]], duration_s=30.0),
]


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: c.name)
def test_velocity_and_acceleration_are_derivatives_of_the_place(curve):
    time = np.random.default_rng(1).uniform(0.1, curve.duration_s - 0.1, 40)
    step = 1e-4
    ahead, here, behind = (curve.motion(time + s) for s in (step, 0.0, -step))
    assert here[1] == pytest.approx((ahead[0] - behind[0]) / (2 * step), abs=1e-6)
    if curve.name != "u-shape":  # whose acceleration jumps where an arc begins
        assert here[2] == pytest.approx((ahead[1] - behind[1]) / (2 * step), abs=1e-6)


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: c.name)
def test_the_feed_forward_reproduces_the_trajectory(curve):
    desired = desired_trajectory(curve, period_s=0.002)
    check_feasible(desired, ROBOT)
    middle_v = 0.5 * (desired.speed_m_per_s[1:] + desired.speed_m_per_s[:-1])
    middle_w = 0.5 * (desired.turn_rate_rad_per_s[1:] + desired.turn_rate_rad_per_s[:-1])
    poses = dead_reckon(desired.poses[0], distance_m=0.002 * middle_v, turn_rad=0.002 * middle_w)
    assert np.abs(poses - desired.poses).max() < 2e-3
    assert np.abs(np.diff(desired.poses[:, 2])).max() < 0.1  # unwrapped


def test_the_thesis_numbers_of_its_trajectories():
    lengths = {c.name: desired_trajectory(c, period_s=0.01).length_m for c in CURVES}
    assert lengths["ellipse"] == pytest.approx(19.38, abs=0.01)  # 19.6 m driven in the thesis
    assert lengths["lemniscate"] == pytest.approx(28.3, abs=0.1)  # 30.8 m driven
    assert lengths["u-shape"] == pytest.approx(16.5 - 4 * 0.5 + 0.5 * np.pi, abs=1e-3)
    eight = desired_trajectory(shapes.lemniscate(), period_s=0.1)
    assert eight.poses[0, 2] == pytest.approx(np.arctan2(2.0, 1.0))
    assert eight.wheel_rates(ROBOT)[0] == pytest.approx([8.51492695] * 2, abs=1e-8)


def test_a_point_keeps_its_heading_and_stands_still():
    desired = desired_trajectory(shapes.fixed_pose([1.0, 2.0, 0.5]), period_s=0.6)
    assert (desired.poses == [1.0, 2.0, 0.5]).all()
    assert not desired.wheel_rates(ROBOT).any()


def test_what_the_wheels_cannot_do_is_refused_with_the_worst_place():
    fast = desired_trajectory(shapes.lemniscate(duration_s=30.0), period_s=0.1)
    with pytest.raises(NavigationError, match=r"infeasible: at 0 s its speed of 1.4 m/s"):
        check_feasible(fast, ROBOT)
    bend = desired_trajectory(
        shapes.u_shape((3.0, 0.4, 3.0), corner_radius_m=0.05, duration_s=15.0), period_s=0.05
    )
    with pytest.raises(NavigationError, match="curvature of 20"):
        check_feasible(bend, ROBOT)


def test_bad_curves_are_one_sentence():
    with pytest.raises(NavigationError, match="multiple"):
        desired_trajectory(shapes.line(), period_s=0.7)
    with pytest.raises(NavigationError, match="duration must be"):
        Curve(name="x", duration_s=0.0, motion=lambda t: t)
    with pytest.raises(NavigationError, match="no two neighbours alike"):
        shapes.spline([[0, 0], [0, 0], [1, 1]], duration_s=5.0)
    with pytest.raises(NavigationError, match="corner_radius_m"):
        shapes.u_shape(corner_radius_m=3.0)
