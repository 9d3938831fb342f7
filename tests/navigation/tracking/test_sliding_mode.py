"""Sliding mode: the surfaces are reached as designed; on them the error decays in closed form."""

import math

import numpy as np
import pytest

from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.tracking import shapes
from octant.navigation.tracking.sliding_mode import SlidingModeControl
from octant.navigation.tracking.trajectories import desired_trajectory

ROBOT = DifferentialDrive(max_wheel_speed_m_per_s=5.0)
PERIOD_S = 0.01


def driven(curve, pose, **gains):
    """Poses of an ideal robot under the law, and its surfaces."""
    desired = desired_trajectory(curve, period_s=PERIOD_S)
    law = SlidingModeControl(desired=desired, robot=ROBOT, **gains)
    poses, surfaces = [np.array([pose])], []
    for k in range(desired.steps):
        surfaces.append(np.concatenate(law.surfaces(k, poses[-1])))
        rates = law.wheel_rates(k, poses[-1], np.zeros((1, 1)))
        poses.append(ROBOT.step_arc(poses[-1], rates, period_s=PERIOD_S))
    return desired, np.concatenate(poses), np.array(surfaces)


def test_on_both_surfaces_the_error_decays_as_the_closed_form():
    """With u = c v y: du/dt = -c v² u / sqrt(1 + u²), so that w - artanh(1 / w) falls by c v² t."""
    speed, steep, aside = 0.4, 5.0, 0.5
    line = shapes.line((0.0, 0.0), (8.0, 0.0), duration_s=8.0 / speed)
    heading = -math.atan(steep * speed * aside)
    start = [-aside * math.sin(heading), aside * math.cos(heading), heading]
    _, _, surfaces = driven(line, start, approach_s_per_m2=steep)
    assert np.abs(surfaces[:, [0, 2]]).max() < 0.01
    time = PERIOD_S * np.arange(len(surfaces))
    w = np.sqrt(1.0 + (steep * speed * surfaces[:, 1]) ** 2)
    fallen = w - np.arctanh(1.0 / w)
    shown = surfaces[:, 1] < -0.02
    assert fallen[shown] == pytest.approx((fallen[0] - steep * speed**2 * time)[shown], abs=0.02)


def test_outside_its_layer_a_surface_is_reached_at_a_constant_rate():
    line = shapes.line((0.0, 0.0), (6.0, 0.0), duration_s=20.0)
    _, _, surfaces = driven(line, [-1.5, 0.0, 0.0])
    ahead = surfaces[:200, 0]
    assert np.diff(ahead) / PERIOD_S == pytest.approx(np.full(199, -0.3), abs=1e-6)


def test_a_robot_far_off_ends_on_the_lemniscate():
    desired, poses, _ = driven(shapes.lemniscate(), [0.5, -1.0, 2.0])
    error = np.hypot(*(poses - desired.poses)[:, :2].T)
    assert error[-1] < 0.02
    assert error[0] > 1.0
