import numpy as np
import pytest

from octant.navigation.robot.motion import AT_REST, Motion

POSE = np.array([1.0, -2.0, 0.7])


def test_constant_speeds_drive_a_circle_about_a_fixed_centre():
    motion = Motion(speed_m_per_s=0.4, turn_rate_rad_per_s=-0.5)
    times = np.linspace(-9.0, 9.0, 37)
    poses = motion.poses(POSE, times)
    left = np.column_stack((-np.sin(poses[:, 2]), np.cos(poses[:, 2])))
    centre = POSE[:2] + 0.4 / -0.5 * np.array([-np.sin(0.7), np.cos(0.7)])
    assert poses[:, :2] + 0.4 / -0.5 * left == pytest.approx(np.tile(centre, (37, 1)), abs=1e-12)
    assert poses[:, 2] == pytest.approx(0.7 - 0.5 * times, abs=1e-12)
    assert poses[18] == pytest.approx(POSE, abs=1e-15)


def test_a_robot_that_does_not_turn_drives_straight():
    poses = Motion(speed_m_per_s=0.5).poses(POSE, [-2.0, 3.0])
    ahead = np.array([np.cos(0.7), np.sin(0.7)])
    assert poses[:, :2] == pytest.approx(POSE[:2] + np.array([[-1.0], [1.5]]) * ahead)


def test_only_a_robot_without_speeds_rests():
    assert AT_REST.rests
    assert (AT_REST.poses(POSE, [-1.0, 5.0]) == POSE).all()
    assert not Motion(speed_m_per_s=0.1).rests
    assert not Motion(turn_rate_rad_per_s=-0.1).rests
