import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive

ROBOT = DifferentialDrive()


def test_scout_has_the_thesis_wheels_axle_and_top_speed():
    assert (ROBOT.wheel_radius_m, ROBOT.axle_length_m) == (0.0825, 0.30)
    assert ROBOT.max_wheel_rate_rad_per_s == pytest.approx(0.75 / 0.0825)
    assert ROBOT.max_turn_rate_rad_per_s == pytest.approx(2 * 0.75 / 0.30)


def test_right_wheel_alone_turns_the_robot_left_about_the_left_wheel():
    rate = ROBOT.pose_rate([0.0, 0.0, 0.0], [1.0, 0.0])
    # r/2 forward and r/l to the left: thesis (3.6) written out for u_R = 1, u_L = 0.
    assert rate == pytest.approx([0.0825 / 2, 0.0, 0.0825 / 0.30])


def test_no_sideways_motion():
    rng = np.random.default_rng(3)
    poses = rng.uniform(-3, 3, (50, 3))
    rates = ROBOT.pose_rate(poses, rng.uniform(-9, 9, (50, 2)))
    sideways = -rates[:, 0] * np.sin(poses[:, 2]) + rates[:, 1] * np.cos(poses[:, 2])
    assert np.abs(sideways).max() < 1e-15
    assert np.abs(rates).max() > 0.1


def test_wheel_rates_invert_the_twist():
    rates = ROBOT.wheel_rates(speed_m_per_s=[0.2, -0.1], turn_rate_rad_per_s=[0.5, -1.0])
    assert ROBOT.twist(rates) == pytest.approx(np.array([[0.2, 0.5], [-0.1, -1.0]]))


@pytest.mark.parametrize(
    ("step", "expected"),
    [
        ("step_euler", [-0.736142219, 2.154760058, 4.0]),
        ("step_arc", [-0.946003119, 2.067054526, 4.0]),
    ],
)
def test_twenty_half_second_steps_of_a_constant_twist_end_at_the_reference_pose(step, expected):
    # v = 0.5 m/s, ω = 0.4 rad/s; made outside this project, to 9 digits.
    rates = ROBOT.wheel_rates(speed_m_per_s=0.5, turn_rate_rad_per_s=0.4)
    pose = np.zeros(3)
    for _ in range(20):
        pose = getattr(ROBOT, step)(pose, rates, period_s=0.5)
    assert pose == pytest.approx(expected, abs=1e-9)


def test_arc_is_the_limit_of_ever_smaller_euler_steps():
    rates = np.array([3.0, 1.0])
    pose = np.array([0.3, -0.2, 0.7])
    arc = ROBOT.step_arc(pose, rates, period_s=1.0)
    assert np.linalg.norm(ROBOT.step_euler(pose, rates, period_s=1.0)[:2] - arc[:2]) > 0.03
    for _ in range(20000):
        pose = ROBOT.step_euler(pose, rates, period_s=1.0 / 20000)
    assert pose == pytest.approx(arc, abs=1e-5)


def test_arc_without_a_turn_is_straight():
    rates = ROBOT.wheel_rates(speed_m_per_s=0.4, turn_rate_rad_per_s=0.0)
    pose = ROBOT.step_arc([1.0, 2.0, np.pi / 3], rates, period_s=0.5)
    assert pose == pytest.approx([1.1, 2.0 + 0.2 * np.sin(np.pi / 3), np.pi / 3])


def test_each_wheel_saturates_on_its_own():
    limit = 0.75 / 0.0825
    assert ROBOT.saturate([2 * limit, -0.5]) == pytest.approx([limit, -0.5])
    assert ROBOT.saturate([-2 * limit, 0.5]) == pytest.approx([-limit, 0.5])


@pytest.mark.parametrize("name", ["wheel_radius_m", "axle_length_m", "max_wheel_speed_m_per_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_impossible_robots_are_refused_by_name(name, value):
    with pytest.raises(NavigationError, match=name):
        DifferentialDrive(**{name: value})
