"""A navigator that is driven from outside drives as the mission's own loop does."""

import numpy as np
import pytest

import octant
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.robot.motion import move
from octant.reader_design.setting.robot import study_robot

pytestmark = pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
TAGS = (octant.Tag("A", (1.5, 1.0, 2.0)), octant.Tag("B", (0.5, 2.5, 2.0)))


def mission(navigator="tracker"):
    return octant.Mission(
        octant.Room.free_space(),
        TAGS,
        octant.Reader(response="isolated"),
        start=(0.0, 0.0, 90.0),
        navigator=navigator,
        tracker={"reach_m": 3.0},
        noise_db=1.0,
    )


@pytest.fixture(scope="module")
def drives():
    return mission().run(1, seed=7, progress=False).results[0]


def test_a_pilot_fed_alike_drives_as_the_mission_does(drives):
    task = mission()
    pilot, reader = task.pilot(seed=7, progress=False)
    robot = study_robot(task.study, "mission").drive
    pose, odometry, driven, k = pilot.start, octant.Odometry(), (0.0, 0.0), 0
    reached = []
    while not pilot.done:
        rss_w = reader.read(
            pose, pilot.tag_id, speed_m_per_s=driven[0], turn_rate_rad_per_s=driven[1]
        )
        step = pilot.step(rss_w, odometry)
        if step.reached is not None:
            reached.append(step.reached)
            odometry, driven = octant.Odometry(), (0.0, 0.0)
            continue
        np.testing.assert_array_equal(pose, drives.poses[k])
        np.testing.assert_array_equal(rss_w, drives.rss_w[k])
        np.testing.assert_allclose(
            [step.speed_m_per_s, step.turn_rate_rad_per_s], drives.commands[k], atol=1e-12
        )
        driven = step.speed_m_per_s, step.turn_rate_rad_per_s
        rates = robot.wheel_rates(speed_m_per_s=driven[0], turn_rate_rad_per_s=driven[1])
        way, turn = pilot.period_s * robot.twist(rates)
        odometry = octant.Odometry(distance_m=float(way), turn_rad=float(turn))
        pose = move(pose, distance_m=way, turn_rad=turn, method="euler")
        pose[2] = wrap_angle(pose[2])
        k += 1
        if k < len(drives.poses):
            # the mission's wheels round by an ulp elsewhere: follow it exactly
            np.testing.assert_allclose(pose, drives.poses[k], atol=1e-12)
            pose = drives.poses[k]
    assert reached == ["A", "B"]
    assert drives.outcome == "completed"
    with pytest.raises(NavigationError, match="nothing is left"):
        pilot.step(rss_w)


def test_readings_of_another_shape_are_refused():
    pilot, reader = mission("thesis").pilot(seed=1, progress=False)
    for rss_w in (np.zeros(7), np.zeros((2, 8)), -np.ones(8), np.full(8, np.nan), 1.0):
        with pytest.raises(NavigationError, match="8 powers"):
            pilot.step(rss_w)
    with pytest.raises(NavigationError, match="heading"):
        reader.read((1.0, 2.0), "A")
    with pytest.raises(NavigationError, match="'C'"):
        reader.read((1.0, 2.0, 0.0), "C")
