"""The world of missions where it differs from the study, and what navigators are told of it."""

from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.missions.compute import mission_job, mission_runs
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.setting.truth import true_world
from octant.reader_design.study_file.loading import parse_study

STUDY = """
seed = 3
[room]
box_m = [4.0, 3.0, 2.6]
material = "concrete"
[[tag]]
id = "a"
position_m = [3.0, 2.0, 2.55]
[reader]
response = "isolated"
plate_height_m = 0.0
[solver]
max_reflections = 1
[mission]
start_m = [0.7, 0.7]
heading_deg = 30.0
tags = ["a"]
runs = 4
wheel_slip = 0.01
"""
POSES = np.array([[1.0, 1.0, 0.3], [2.0, 1.7, -2.0]])


def setting_of(more="", study=STUDY):
    return build_setting(parse_study(study + more, source="test", directory=Path()))


def world_of(more, seed=1):
    return true_world(setting_of("[truth]\n" + more), np.random.default_rng(seed))


def test_without_a_difference_the_world_is_the_study():
    told, world = setting_of(), world_of("")
    links = {"a": world.setting.link(world.setting.tag("a"))}
    found = world.erring(links)["a"].rss_w(POSES)
    assert found == pytest.approx(told.link(told.tag("a")).rss_w(POSES), rel=1e-12)
    assert world.carried(None) is None


def test_levels_and_gains_multiply_what_is_read():
    world = world_of("tag_level_sd_db = 2.0\nantenna_gain_sd_db = 1.0")
    link = world.setting.link(world.setting.tag("a"))
    error_db = 10.0 * np.log10(world.erring({"a": link})["a"].rss_w(POSES) / link.rss_w(POSES))
    assert error_db == pytest.approx(np.tile(world.level_db["a"] + world.gain_db, (2, 1)))
    assert np.std(error_db[0]) > 0.1


def test_materials_order_height_and_furniture_are_those_of_the_truth():
    cabinet = '[[truth.object]]\nkind = "box"\nsize_m = [0.3, 0.3, 1.0]\nposition_m = [2.0, 2.3, 0]'
    cabinet += '\nmaterial = "metal"'
    world = world_of(
        "permittivity_factor = 1.2\nmax_reflections = 2\ndiffraction = true\n"
        f"reader_height_error_m = 0.01\nwheel_slip = 0.05\n{cabinet}\n"
    )
    told, true = setting_of(), world.setting
    walls = told.radios[0].layer_permittivity[0]
    assert true.radios[0].layer_permittivity[0].real == pytest.approx(1.2 * walls.real)
    assert true.radios[0].layer_permittivity[0].imag == pytest.approx(walls.imag)
    assert true.reader_z_m == pytest.approx(told.reader_z_m + 0.01)
    assert true.solver.max_reflections == 2
    assert len(true.scene.bodies) == len(told.scene.bodies) + 1
    assert true.study.mission.wheel_slip == 0.05


def test_a_tilt_leans_the_axis_by_its_deviation():
    leans = []
    for seed in range(60):
        axis = world_of("tag_tilt_sd_deg = 5.0", seed).setting.tag("a").antennas[0].axis
        leans.append(np.degrees(np.arccos(abs(axis[2]))))
    assert np.sqrt(np.mean(np.square(leans))) == pytest.approx(5.0, rel=0.25)


def test_tags_hang_elsewhere_in_each_world_and_the_run_ends_at_the_true_point():
    runs = mission_runs(setting_of("[truth]\ntag_sd_m = 0.02\ndraws = 2\n"))
    points = [one.job.mission.tag_points_m[0] for one in runs]
    assert [one.runs for one in runs] == [2, 2]
    assert 0.0 < np.linalg.norm(points[0] - points[1]) < 0.2
    job = mission_job(setting_of())
    assert job.mission.tag_points_m[0] == pytest.approx([3.0, 2.0])


def test_what_is_put_on_the_start_is_refused_with_the_tables_name():
    box = 'kind = "box"\nsize_m = [0.5, 0.5, 1.0]\nposition_m = [0.7, 0.7, 0]\nmaterial = "wood"'
    with pytest.raises(ConfigError, match=r"\[truth\]"):
        mission_runs(setting_of(f"[truth]\n[[truth.object]]\n{box}"))


def test_a_robot_wider_than_the_way_gets_a_sentence():
    wide = STUDY.replace("runs = 4", 'runs = 4\nrobot_radius_m = 0.6\nnavigator = "counting"')
    wall = '[[room.object]]\nkind = "box"\nsize_m = [0.2, 2.2, 1.0]\nposition_m = [2.0, 1.1, 0]'
    wall += '\nmaterial = "wood"\n'
    with pytest.raises(ConfigError, match="no way from the start"):
        mission_job(setting_of(study=wide.replace("[[tag]]", wall + "[[tag]]", 1)))


def test_the_map_navigator_refuses_tags_that_answer_and_a_start_it_does_not_know():
    by_map = STUDY.replace("runs = 4", 'runs = 4\nnavigator = "map"')
    woken = by_map.replace('id = "a"', 'id = "a"\nkind = "passive"')
    with pytest.raises(ConfigError, match="backscatter"):
        mission_job(setting_of("[rfid]\npower_w = 1.0\n", study=woken))
    with pytest.raises(ConfigError, match="told one start"):
        mission_job(setting_of("random_starts = true\n", study=by_map))


@pytest.mark.slow
def test_one_tag_above_a_small_room_is_reached_by_map_though_the_wheels_slip():
    study = STUDY.replace("runs = 4", 'runs = 2\nnavigator = "map"\nwheel_scale = 0.05')
    (runs,) = mission_runs(setting_of("[mission.map]\nspacing_m = 0.025\n", study=study))
    ends = [runs.job(seed).arrival_points_m[0] for seed in np.random.SeedSequence(1).spawn(6)]
    off_m = np.linalg.norm(np.array(ends) - [3.0, 2.0], axis=1)  # NaN where it does not arrive
    # One tag leaves its own place, here as surveyed, and the robot's hardly apart: not 5 cm.
    assert np.sum(off_m < 0.1) >= 4


def test_readings_have_the_noise_of_the_world_and_navigators_that_of_the_study():
    (runs,) = mission_runs(setting_of("[truth]\nnoise_db = 6.0\n"))
    rng, pose = np.random.default_rng(1), POSES[0]
    level = 10.0 * np.log10([runs.job.sensor.read(pose, "a", rng) for _ in range(200)])
    assert np.std(level, axis=0) == pytest.approx(6.0, rel=0.2)
    assert runs.setting.mission.noise_db == 1.0
