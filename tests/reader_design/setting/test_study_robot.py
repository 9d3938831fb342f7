"""The table ``[robot]``: one robot for missions, tracking and docking, whatever its wheels."""

from pathlib import Path

import numpy as np
import pytest
from slow_rest import slow_after

from octant.em.reader.response import sector_response
from octant.geometries.errors import ConfigError
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.place_particles import seen_after
from octant.navigation.navigators.thesis import _moved
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.kinematics import CarDrive, SynchroDrive
from octant.navigation.robot.motion import move
from octant.navigation.robot.odometry import Rolling
from octant.navigation.robot.robot import Robot
from octant.reader_design.experiments.docking.compute import docking_job
from octant.reader_design.experiments.missions.compute import mission_job, mission_space
from octant.reader_design.experiments.tracking.chapters import neighbouring_runs
from octant.reader_design.experiments.tracking.settings import settings_of
from octant.reader_design.setting.robot import study_robot
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study, to_toml

TEXT = """
seed = 3
[room]
free_space = true
[[tag]]
id = "a"
position_m = [4.0, 2.0, 3.0]
antenna = "dipole"
[[tag]]
id = "b"
position_m = [0.0, 3.0, 3.0]
antenna = "dipole"
[[tag]]
id = "c"
position_m = [1.0, -1.0, 3.0]
antenna = "dipole"
[mission]
start_m = [0.0, 0.0]
heading_deg = 90.0
tags = ["a"]
{mission}
[track]
chapters = ["neighbouring"]
runs = 2
rss_sigma_db = 2.0
{track}
[[track.trajectory]]
name = "mine"
shape = "line"
waypoints_m = [[0.0, 0.0], [3.0, 3.0]]
duration_s = 20.0
[dock]
tag = "a"
landmark_position_m = [6.0, 2.0, 0.6]
start_low_m = [1.0, 1.0]
start_high_m = [2.0, 3.0]
{dock}
[robot]
{robot}
"""
CAR = 'kinematics = "car"\nwheelbase_m = 0.3\nsteering_limit_deg = 40\n'
ROBOTS = {
    "none": "",
    "scout": 'preset = "scout"',
    "sputnik": 'preset = "sputnik"',
    "car": CAR,
    "synchro": 'kinematics = "synchro"\nturn_acceleration_deg_per_s2 = 360',
    "real": (
        "wheel_acceleration_rad_per_s2 = 20\ndead_band_rad_per_s = 0.05\nencoder_counts = 2000\n"
        "wheel_slip = 0.01\nwheel_scale = 0.005\nlinear_slip_m_per_s = -0.002"
    ),
}


def study_of(robot="", *, mission="", track="", dock=""):
    if "navigator" not in mission:
        mission = f'navigator = "thesis"\n{mission}'
    text = TEXT.format(robot=robot, mission=mission, track=track, dock=dock)
    return parse_study(text, source="test", directory=Path())


def setting_of(study):
    azimuths = 2.0 * np.pi * np.arange(8) / 8
    return build_setting(study).with_responses(
        sector_response(azimuths, frequency_hz=f) for f in study.radio.frequencies_hz
    )


@pytest.mark.parametrize("navigator", ["thesis", "tracker"])
@pytest.mark.parametrize("robot", ROBOTS)
def test_every_robot_drives_a_mission(robot, navigator):
    study = study_of(ROBOTS[robot], mission=f'navigator = "{navigator}"\nnoise_db = 0.5')
    job = mission_job(setting_of(study))
    result = job(np.random.SeedSequence(1))
    assert result.outcome == "completed", result.reason
    assert np.hypot(*(result.poses[-1, :2] - [4.0, 2.0])) < 0.4
    if robot == "car":  # never tighter than its least radius
        step = np.linalg.norm(np.diff(result.poses[:, :2], axis=0), axis=1)
        turn = np.abs(np.angle(np.exp(1j * np.diff(result.poses[:, 2]))))
        assert (turn <= step / job.robot.least_radius_m * 1.1 + 1e-9).all()
        assert turn.max() > 0.05


def test_a_car_backs_up_to_a_tag_inside_its_tightest_circle():
    text = TEXT.replace("[4.0, 2.0, 3.0]", "[0.4, -0.1, 3.0]")
    text = text.format(robot=CAR, mission='navigator = "tracker"', track="", dock="")
    job = mission_job(setting_of(parse_study(text, source="test", directory=Path())))
    assert job.robot.encircles(-0.1, -0.4)  # on the right of the start, hardly behind
    result = job(np.random.SeedSequence(1))
    assert result.outcome == "completed"
    ahead = np.stack([np.cos(result.poses[:-1, 2]), np.sin(result.poses[:-1, 2])])
    assert (np.diff(result.poses[:, :2], axis=0).T * ahead).sum(axis=0).min() < -0.01


@pytest.mark.parametrize("robot", ROBOTS)
def test_every_robot_follows_a_line(robot):
    settings = settings_of(study_of(ROBOTS[robot], track="wheel_sigma_rad_per_s = 0.01"))
    (outcome,), _ = neighbouring_runs(settings, "mine")
    assert (outcome.runs.final_error_m < 0.3).all()


@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
@pytest.mark.parametrize(
    "robot", slow_after(2, ["none", "car", "scout", "sputnik", "synchro", "real"])
)
def test_every_robot_docks(robot):
    job = docking_job(setting_of(study_of(ROBOTS[robot])))
    results = [job(seed) for seed in np.random.SeedSequence(5).spawn(2)]
    assert sum(result.success for result in results) == 2, [r.reason for r in results]


def test_presets_are_the_thesis_robots():
    robots = {name: study_robot(study_of(ROBOTS[name]), "mission") for name in ROBOTS}
    assert robots["none"] == Robot()
    for name, axle_m, radius_m in (("scout", 0.30, 0.19), ("sputnik", 0.26, 0.17)):
        drive = robots[name].drive
        assert (drive.wheel_radius_m, drive.axle_length_m) == (0.0825, axle_m)
        assert drive.max_wheel_speed_m_per_s == pytest.approx(0.75)
        assert robots[name].radius_m == radius_m
    assert isinstance(robots["car"].drive, CarDrive)
    assert robots["car"].drive.least_radius_m == pytest.approx(0.3 / np.tan(np.radians(40.0)))
    assert isinstance(robots["synchro"].drive, SynchroDrive)
    assert robots["synchro"].drive.max_turn_rate_rad_per_s == pytest.approx(np.pi / 2)


def test_keys_of_the_verbs_tables_still_count_and_robot_has_them_for_all():
    old = study_of(
        mission="robot_radius_m = 0.3\nwheel_slip = 0.02\nencoder_counts = 100",
        track="wheel_rate_rad_per_s = 11.0\nencoder_counts = 100",
        dock="robot_height_m = 1.1\nlinear_slip_m_per_s = 0.0",
    )
    new = study_of(
        "radius_m = 0.3\nheight_m = 1.1\nwheel_slip = 0.02\nencoder_counts = 100\n"
        "linear_slip_m_per_s = 0.0\nmax_wheel_rate_rad_per_s = 11.0"
    )
    assert study_robot(old, "mission").rolling == study_robot(new, "mission").rolling
    assert study_robot(old, "mission").rolling == Rolling(slip_sd=0.02, tick_rad=0.02 * np.pi)
    assert study_robot(old, "mission").radius_m == study_robot(new, "dock").radius_m == 0.3
    assert study_robot(old, "dock").height_m == study_robot(new, "mission").height_m == 1.1
    assert study_robot(old, "dock").rolling.linear_m_per_s == 0.0
    assert study_robot(study_of(), "dock").rolling.linear_m_per_s == -0.01
    assert settings_of(old).robot == settings_of(new).robot
    assert settings_of(old).feedback_robot.max_wheel_rate_rad_per_s == pytest.approx(12.1)
    assert settings_of(new).feedback_robot.max_wheel_rate_rad_per_s == pytest.approx(11.0)
    assert mission_space(build_setting(new)).footprint.radius_m == 0.3
    tick = 0.02 * np.pi
    for study in (old, new):
        settings = settings_of(study)
        world = settings.world(settings.mesh, tags_m=settings.mesh.tags_m)
        assert world.rolling.tick_rad == tick


def test_a_study_with_a_robot_is_written_and_read_back():
    study = study_of(CAR + ROBOTS["real"])
    again = parse_study(to_toml(study), source="again", directory=Path())
    assert again == study


@pytest.mark.parametrize(
    ("robot", "tables", "words"),
    [
        ("wheelbase_m = 0.3", {}, "robot.wheelbase_m is 0.3.*'car'"),
        ('kinematics = "car"', {}, "robot.wheelbase_m is not given"),
        ('kinematics = "synchro"\naxle_m = 0.3', {}, "robot.axle_m"),
        ("max_turn_rate_deg_per_s = 30", {}, "'synchro'"),
        ("radius_m = 0.2", {"mission": "robot_radius_m = 0.3"}, "mission.robot_radius_m is 0.3"),
        ("encoder_counts = 9", {"track": "encoder_counts = 8"}, "track.encoder_counts is 8"),
        ("linear_slip_m_per_s = 0.1", {"dock": "linear_slip_m_per_s = 0.0"}, "leave dock.linear"),
        ("steering_limit_deg = 90", {}, "robot.steering_limit_deg"),
    ],
)
def test_robots_that_contradict_themselves_are_refused(robot, tables, words):
    with pytest.raises(ConfigError, match=words):
        study_of(robot, **tables)


@pytest.mark.parametrize("chapter", ["nominal", "stabilisation"])
def test_planned_controls_of_a_car_are_refused(chapter):
    text = TEXT.replace('["neighbouring"]', f'["{chapter}"]')
    text = text.format(robot=CAR, mission='navigator = "thesis"', track="", dock="")
    with pytest.raises(ConfigError, match="leave these chapters out"):
        settings_of(parse_study(text, source="test", directory=Path()))


def test_docking_gets_the_same_robot_as_missions():
    setting = setting_of(study_of(ROBOTS["real"]))
    robot, rolling = mission_job(setting).robot, docking_job(setting).setting.rolling
    assert robot == docking_job(setting).setting.robot == DifferentialDrive()
    assert rolling.tick_rad > 0.0
    assert rolling.linear_m_per_s == 0.0  # the task's slip has it
    assert docking_job(setting).task.slip.linear_m_per_s == -0.002


@pytest.mark.parametrize("method", ["euler", "rk2", "exact"])
def test_the_step_of_odometry_reaches_every_verb(method):
    key = f'odometry = "{method}"'
    for navigator in ("thesis", "tracker"):
        setting = setting_of(study_of(key, mission=f'navigator = "{navigator}"'))
        found = mission_job(setting).navigator
        assert (found.method if navigator == "thesis" else found.filters[0].method) == method
    assert docking_job(setting).setting.odometry == method
    assert settings_of(setting.study).motion.method == method


@pytest.mark.parametrize("method", ["euler", "rk2", "exact"])
def test_navigators_add_up_motion_as_the_step_says(method):
    """Against `motion.move`: the thesis' dead reckoning, and a place as seen after the motion."""
    pose = np.array([0.3, -0.2, 0.7])
    want = move(pose, distance_m=0.4, turn_rad=0.9, method=method)
    moved = _moved(tuple(pose), Odometry(distance_m=0.4, turn_rad=0.9), method)
    assert moved == pytest.approx(want)
    place = np.array([1.2, 0.5])

    def body(pose):
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        return np.array([[cos, sin], [-sin, cos]]) @ (place - pose[:2])

    seen = seen_after(body(pose), way_m=0.4, turn_rad=0.9, method=method)
    assert seen == pytest.approx(body(want))
