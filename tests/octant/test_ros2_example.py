"""The ROS 2 example's part without ROS drives; the rest is at least whole."""

import ast
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

import octant

ROS2 = Path(__file__).parents[2] / "examples" / "ros2"
pytestmark = pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")


@pytest.fixture(scope="module")
def loop():
    sys.path.insert(0, str(ROS2 / "octant_drive"))
    try:
        import octant_drive.loop as module
    finally:
        sys.path.pop(0)
    assert "rclpy" not in sys.modules
    return module


@pytest.mark.parametrize("turn", [0.0, 1e-12, 0.3, -2.0])
def test_motion_between_two_poses_is_that_of_the_arc(loop, turn):
    way, heading = 0.4, 1.1
    radius = way / turn if turn else math.inf
    if turn:
        x = radius * (math.sin(heading + turn) - math.sin(heading))
        y = radius * (math.cos(heading) - math.cos(heading + turn))
    else:
        x, y = way * math.cos(heading), way * math.sin(heading)
    odometry = loop.moved((2.0, 3.0, heading), (2.0 + x, 3.0 + y, heading + turn + 2 * math.pi))
    assert odometry.distance_m == pytest.approx(way, rel=1e-3 if abs(turn) == 1e-12 else 1e-12)
    assert odometry.turn_rad == pytest.approx(turn, abs=1e-15 if turn == 0.0 else 1e-12)


def test_heading_of_a_quaternion(loop):
    for yaw in (-3.0, 0.0, 0.7, 3.1):
        q = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        assert loop.yaw_rad(*q) == pytest.approx(yaw)


def test_the_loop_reaches_its_tags_by_readings_and_odometry_in_its_own_frame(loop):
    mission = octant.Mission(
        octant.Room.free_space(),
        [octant.Tag("A", (1.5, 1.0, 2.0)), octant.Tag("B", (0.5, 2.5, 2.0))],
        octant.Reader(response="isolated"),
        start=(0.0, 0.0, 90.0),
        navigator="tracker",
        tracker={"reach_m": 3.0},
    )
    drive = loop.DriveLoop(mission, seed=3)
    pose, wheels = drive.pilot.start.copy(), np.zeros(3)  # odometry starts in axes of its own
    speed = rate = 0.0
    ends = []
    for _ in range(400):
        rss_w = drive.reader.read(
            pose, drive.pilot.tag_id, speed_m_per_s=speed, turn_rate_rad_per_s=rate
        )
        wanted = drive.tick(rss_w.tolist(), tuple(wheels))
        speed, rate = wanted.speed_m_per_s, wanted.turn_rate_rad_per_s
        if wanted.reached:
            ends.append((wanted.reached, pose[:2].copy()))
        if wanted.done:
            break
        for state in (pose, wheels):
            middle = state[2] + 0.5 * rate * drive.period_s
            way = speed * drive.period_s * np.sinc(0.5 * rate * drive.period_s / np.pi)
            state[:] += (way * math.cos(middle), way * math.sin(middle), rate * drive.period_s)
    assert [tag for tag, _ in ends] == ["A", "B"]
    assert math.dist(ends[0][1], (1.5, 1.0)) < 0.3
    assert math.dist(ends[1][1], (0.5, 2.5)) < 0.3


def test_a_mission_comes_from_a_study_by_name(loop):
    assert loop.mission_of("office").study.mission is not None


def test_the_packages_are_whole_and_say_what_is_not_tested():
    for folder in ("octant_drive", "octant_nav2"):
        package = etree.parse(str(ROS2 / folder / "package.xml")).getroot()
        assert package.findtext("name") == folder
    for name in ("rss_node", "drive_node"):
        text = (ROS2 / "octant_drive" / "octant_drive" / f"{name}.py").read_text()
        assert "NOT TESTED" in text
        names = {n.name for n in ast.walk(ast.parse(text)) if isinstance(n, ast.FunctionDef)}
        assert "main" in names
        assert f"{name} = " in (ROS2 / "octant_drive" / "setup.py").read_text()
    source = (ROS2 / "octant_nav2" / "src" / "octant_controller.cpp").read_text()
    plugin = etree.parse(str(ROS2 / "octant_nav2" / "plugins.xml")).getroot()[0].get("type")
    assert f"PLUGINLIB_EXPORT_CLASS({plugin}," in source
    assert "NOT TESTED" in source
