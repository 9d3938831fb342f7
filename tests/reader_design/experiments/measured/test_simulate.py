"""A simulated log holds what the model says, on ways that a robot can drive."""

import msgspec
import numpy as np
import pytest

from octant.em.decibels import power_dbm
from octant.geometries.errors import ConfigError
from octant.navigation.logs.log_csv import read_log, write_log
from octant.navigation.logs.records import _ROW_ARRAYS
from octant.navigation.robot.motion import move
from octant.reader_design import cli
from octant.reader_design.experiments.measured.simulate import (
    Readings,
    _at_channel,
    simulated_log,
    with_antenna,
)
from octant.reader_design.experiments.measured.simulate_ways import (
    TURN_RAD,
    way_over_floor,
    way_through_tags,
)
from octant.reader_design.setting.robot import robot_space, study_robot
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study, vary

STUDY = """
[radio]
frequency_hz = 2.4e9
channels_hz = [2.40e9, 2.48e9]
[room]
box_m = [4.0, 3.0, 2.5]
material = "concrete"
[[room.object]]
kind = "box"
size_m = [0.6, 0.6, 0.8]
position_m = [1.7, 1.2, 0.0]
material = "metal"
[[tag]]
id = "A"
position_m = [0.7, 1.5, 2.4]
[[tag]]
id = "B"
position_m = [3.3, 1.5, 2.4]
[reader]
response = "isolated"
[solver]
max_reflections = 1
[mission]
start_m = [0.7, 0.6]
tags = ["A", "B"]
"""


@pytest.fixture(scope="module")
def setting(tmp_path_factory):
    study = parse_study(STUDY, source="study.toml", directory=tmp_path_factory.mktemp("study"))
    return build_setting(study)


@pytest.fixture(scope="module")
def way(setting):
    return way_through_tags(setting, step_m=0.3)


def changed(setting, **values):
    study = vary(setting.study, {key.replace("__", "."): v for key, v in values.items()})
    return build_setting(study).with_responses(setting.responses)


def same(first, second):
    for name in _ROW_ARRAYS:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name), err_msg=name)
    assert (first.ids, first.kept) == (second.ids, second.kept)


def test_a_log_read_back_is_the_log_that_was_simulated_to_the_bit(setting, way, tmp_path):
    sick = changed(
        setting,
        sensor__sensitivity_dbm=-20.0,
        sensor__drop_out_probability=0.1,
        robot__wheel_slip=0.02,
        robot__wheel_scale=0.02,
        robot__encoder_counts=500,
    )
    log = simulated_log(sick, way, Readings(noise_db=2.0, hop=True, runs=2))
    assert log.censored.any()
    assert log.heard.any()
    write_log(tmp_path / "log.csv", log)
    back = read_log(tmp_path / "log.csv", threshold_dbm=-20.0)
    same(back, log)
    assert back.threshold_dbm == log.threshold_dbm


def test_levels_are_those_of_the_links_where_nothing_errs(setting, way):
    log = simulated_log(setting, way, Readings())
    level = log.rss_dbm.reshape(len(way), 2, 8)
    for t, tag in enumerate(setting.tags):
        np.testing.assert_allclose(level[:, t], power_dbm(setting.link(tag).rss_w(way)), rtol=1e-12)
    assert np.isnan(log.frequency_hz).all()  # the mean over two channels is at neither
    mean = simulated_log(setting, way, Readings(local_mean=True)).rss_dbm.reshape(level.shape)
    expected = power_dbm(setting.link(setting.tags[0]).power(way).local_mean_w)
    np.testing.assert_allclose(mean[:, 0], expected, rtol=1e-12)


def test_a_hopping_reading_is_at_its_one_channel_and_their_mean_is_the_link(setting, way):
    log = simulated_log(setting, way, Readings(hop=True))
    assert set(log.frequency_hz) == {2.40e9, 2.48e9}
    for t, tag in enumerate(setting.tags):
        power_w = []
        for number, frequency in enumerate((2.40e9, 2.48e9)):
            one = _at_channel(setting, number)
            power_w.append(one.link(one.tags[t]).rss_w(way))
            there = (log.frequency_hz == frequency) & (log.sources == t)
            expected = power_dbm(power_w[-1])[there[log.sources == t].reshape(len(way), 8)]
            np.testing.assert_allclose(log.rss_dbm[there], expected, rtol=1e-12)
        np.testing.assert_allclose(np.mean(power_w, axis=0), setting.link(tag).rss_w(way))


def test_one_upright_antenna_hears_the_same_from_all_sides(setting):
    turned = np.array([[1.0, 0.5, 0.0], [1.0, 0.5, 2.0]])
    log = simulated_log(with_antenna(setting, "dipole"), turned, Readings())
    assert log.antenna_numbers == (0,)
    np.testing.assert_allclose(log.rss_dbm[:2], log.rss_dbm[2:], atol=1e-9)


def test_odometry_of_perfect_wheels_leads_along_the_way(setting, way):
    log = simulated_log(setting, way, Readings())
    pose = log.poses[0]
    for row in range(len(log)):
        pose = move(pose, distance_m=log.distance_m[row], turn_rad=log.turn_rad[row])
        np.testing.assert_allclose(pose[:2], log.poses[row, :2], atol=1e-9)


def test_odometry_of_real_wheels_errs_as_they_slip(setting):
    straight = np.column_stack([np.linspace(0.4, 3.4, 40), np.full(40, 0.4), np.zeros(40)])
    slipping = changed(setting, robot__wheel_scale=0.02)
    found = [
        simulated_log(slipping, straight, Readings(seed=seed)).distance_m.sum()
        for seed in range(12)
    ]
    # two wheels of 2 % each: 2 % / sqrt(2) of 3 m, by 12 draws
    assert 0.4 < np.std(found, ddof=1) / (3.0 * 0.02 / np.sqrt(2.0)) < 1.7
    assert np.mean(found) == pytest.approx(3.0, abs=0.05)


def test_the_same_seed_gives_the_same_log_and_another_another(setting, way):
    first = simulated_log(setting, way, Readings(noise_db=1.0, seed=5))
    same(simulated_log(setting, way, Readings(noise_db=1.0, seed=5)), first)
    other = simulated_log(setting, way, Readings(noise_db=1.0, seed=6))
    assert np.std(other.rss_dbm - first.rss_dbm) == pytest.approx(np.sqrt(2.0), rel=0.15)


def test_a_way_leads_under_every_tag_over_free_floor(setting, way):
    robot = study_robot(setting.study, "mission")
    space = robot_space(
        setting.scene, setting.reader, radius_m=robot.radius_m, height_m=robot.height_m
    )
    assert space(way[:, :2]).all()
    for tag in setting.tags:
        assert np.min(np.hypot(*(way[:, :2] - tag.point_m).T)) < 1e-9
    assert np.max(np.hypot(*np.diff(way[:, :2], axis=0).T)) <= 0.3 + 1e-9
    turns = np.abs(np.diff(np.unwrap(way[:, 2])))
    assert turns.max() <= TURN_RAD + 1e-9


def test_lanes_cover_the_free_floor(setting):
    poses = way_over_floor(setting, spacing_m=0.5, step_m=0.1)
    robot = study_robot(setting.study, "mission")
    space = robot_space(
        setting.scene, setting.reader, radius_m=robot.radius_m, height_m=robot.height_m
    )
    assert space(poses[:, :2]).all()
    rng = np.random.default_rng(1)
    points = rng.uniform([0.0, 0.0], [4.0, 3.0], (300, 2))
    free = points[space(points)]
    away = np.hypot(*(free[:, None] - poses[None, :, :2]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() < 0.5


def test_what_cannot_be_simulated_is_refused(setting):
    bare = build_setting(msgspec.structs.replace(setting.study, tags=(), mission=None))
    with pytest.raises(ConfigError, match=r"no \[\[tag\]\]"):
        way_through_tags(bare, step_m=0.1)
    with pytest.raises(ConfigError, match="nothing to read"):
        simulated_log(bare, np.zeros((1, 3)), Readings())


def test_the_verb_writes_a_log_once(tmp_path, capsys):
    (tmp_path / "study.toml").write_text(STUDY)
    out = tmp_path / "log.csv"
    call = ["simulate-log", str(tmp_path / "study.toml"), "--out", str(out), "--quiet"]
    call += ["--antenna", "dipole", "--step-m", "0.5"]
    assert cli.run(call) == 0
    said = capsys.readouterr().out
    assert f"written: {out}" in said
    assert read_log(out).ids == ("A", "B")
    assert cli.run(call) == 2
    assert "exists already" in capsys.readouterr().err
