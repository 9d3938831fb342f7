"""Links of a study's tags and the sensor of its missions: each honours what the study states."""

import math
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.reader.response import reader_response
from octant.geometries.errors import ConfigError
from octant.geometries.reader_body import reader_body
from octant.navigation.missions.run import run_missions
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.rss_detector import RssQuantiser, ThermalNoise
from octant.navigation.sensing.sensor import FieldSensor
from octant.reader_design.experiments.missions.compute import (
    drive_missions,
    mission_space,
    mission_starts,
    study_mission,
    study_navigator,
)
from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study, to_toml
from octant.reader_design.study_file.sensor import Sensor

STUDY = """
seed = 3
[room]
box_m = [5.0, 5.0, 3.0]
[radio]
channels_hz = [2.35e9, 2.40e9, 2.48e9]
[[tag]]
id = "dipole"
position_m = [2.0, 0.5, 2.9]
antenna = "dipole"
axis = [0.3, 0.2, 1.0]
[[tag]]
id = "patch"
position_m = [3.0, 3.5, 2.8]
antenna = "patch"
azimuth_deg = 30.0
[reader]
response = "isolated"
height_m = 0.4
[solver]
max_reflections = 0
[mission]
navigator = "thesis"
start_m = [2.0, 3.5]
tags = ["dipole", "patch"]
controller = "vector_sum"
runs = 2
max_time_s = 20.0
"""
POSE = np.array([[1.2, 2.6, 0.4]])
LINKS = {"a": None, "b": None}
AZIMUTHS = np.arange(8) * (np.pi / 4)


def study_of(text=STUDY):
    return parse_study(text, source="s.toml", directory=Path.cwd())


def setting_of(study):
    body = reader_body()
    return build_setting(study).with_responses(
        reader_response(body, make_antenna("dipole", f), model="isolated", gap_m=0.005)
        for f in study.radio.frequencies_hz
    )


def vector(antenna, direction):
    """Far-field vector of an antenna towards a unit vector of the room."""
    theta, phi = math.acos(direction[2]), math.atan2(direction[1], direction[0])
    along, across = antenna.far_field(theta, phi)
    hat = (math.cos(theta) * math.cos(phi), math.cos(theta) * math.sin(phi), -math.sin(theta))
    return along * np.array(hat) + across * np.array((-math.sin(phi), math.cos(phi), 0.0))


def friis_w(place_m, height_m, frequency_hz, **tag):
    """Power between a tag and an upright dipole at the pose, straight and polarised."""
    sight = np.array((*POSE[0, :2], height_m)) - place_m
    distance = float(np.linalg.norm(sight))
    carrier_m = 299_792_458.0 / 2.4e9
    sender = make_antenna(frequency_hz=frequency_hz, length_m=carrier_m / 2.0, **tag)
    taker = make_antenna("dipole", frequency_hz)
    gain = vector(sender, sight / distance) @ vector(taker, -sight / distance)
    return abs(gain) ** 2 * (299_792_458.0 / frequency_hz / (4.0 * math.pi * distance)) ** 2


@pytest.mark.parametrize("height_m", [None, 0.9])
def test_a_link_averages_friis_over_channels_with_the_tags_own_antenna(height_m):
    setting = setting_of(study := study_of())
    for name, tag in (
        ("dipole", {"kind": "dipole", "axis": (0.3, 0.2, 1.0)}),
        ("patch", {"kind": "patch", "azimuth_rad": math.radians(30.0)}),
    ):
        link = setting.link(setting.tag(name), height_m=height_m)
        place = setting.tag(name).position_m
        each = [friis_w(place, height_m or 0.4, f, **tag) for f in study.radio.frequencies_hz]
        # All elements are alike and see the plane wave from one direction.
        assert link.rss_w(POSE)[0] == pytest.approx(np.full(8, np.mean(each)), rel=1e-5)
        assert np.ptp(each) > 0.02 * np.mean(each)


def test_without_a_sensor_table_missions_are_those_of_a_reader_with_log_normal_errors():
    setting = setting_of(study := study_of())
    links = {t: setting.link(setting.tag(t)) for t in study.mission.tags}
    azimuths = setting.responses[0].azimuths_rad
    sensor = FieldSensor(links=links, azimuths_rad=azimuths, noise_db=1.0)
    mission, robot = study_mission(setting, links), DifferentialDrive()
    space = mission_space(setting)
    mine = run_missions(
        mission,
        sensor,
        study_navigator(setting, mission, robot=robot),
        robot,
        runs=2,
        seed=3,
        blocked=space.footprint,
        starts=mission_starts(study.mission, space, mission.tag_points_m),
    )
    for given, wanted in zip(drive_missions(setting), mine, strict=True):
        assert (given.poses == wanted.poses).all()
        assert (given.rss_w == wanted.rss_w).all()


def test_the_sensor_table_reaches_the_missions():
    quiet = "[sensor]\nread_probability = 0.0\n"
    results = drive_missions(setting_of(study_of(STUDY + quiet)), noise_db=0.0)
    assert [result.outcome for result in results] == ["no signal", "no signal"]
    assert not np.any(results[0].rss_w)


def test_a_sensor_table_is_the_sensor_that_it_describes():
    plain = study_sensor(Sensor(), LINKS, AZIMUTHS, noise_db=1.5)
    reader = FieldSensor(links=LINKS, azimuths_rad=AZIMUTHS, noise_db=1.5)
    for name in (field.name for field in fields(reader)):
        assert np.array_equal(getattr(plain, name), getattr(reader, name))
    table = Sensor(
        dwell_s=0.02,
        bandwidth_hz=1e6,
        noise_figure_db=10.0,
        samples=4,
        required_snr_db=12.0,
        sensitivity_dbm=-120.0,
        bits=8,
        floor_dbm=-95.0,
        drop_out_probability=0.1,
        read_probability=0.9,
    )
    full = study_sensor(table, LINKS, AZIMUTHS, noise_db=0.5)
    assert full.thermal == ThermalNoise(bandwidth_hz=1e6, noise_figure_db=10.0, samples=4)
    assert full.quantiser == RssQuantiser(bits=8, floor_dbm=-95.0, full_scale_dbm=0.0)
    # -174 + 60 + 10 + 12 dBm lies above the given limit.
    assert 10.0 * np.log10(full.sensitivity_w) + 30.0 == pytest.approx(-91.975, abs=1e-3)
    deaf = study_sensor(Sensor(sensitivity_dbm=-80.0), LINKS, AZIMUTHS, noise_db=0.0)
    assert deaf.sensitivity_w == pytest.approx(1e-11, rel=1e-12)
    assert (full.dwell_s, full.noise_db) == (0.02, 0.5)
    assert (full.drop_out_probability, full.read_probability) == (0.1, 0.9)


def test_a_sensor_table_is_written_out_and_read_back():
    study = study_of(STUDY + "[sensor]\ndwell_s = 0.1\nbits = 8\n")
    assert study.sensor == Sensor(dwell_s=0.1, bits=8)
    text = to_toml(study)
    assert "# bandwidth_hz  not given: no thermal noise" in text
    assert study_of(text) == study
    assert study_of().sensor == Sensor()


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("dwell_s = -1.0", "sensor.dwell_s"),
        ("dwell_s = 0.2", "one round of 8 antennas takes 1.6 s"),
        ("bits = 0", "sensor.bits"),
        ("read_probability = 1.5", "sensor.read_probability"),
        ("required_snr_db = 3.0", "without sensor.bandwidth_hz"),
        ("floor_dbm = 0.0", "the codes must rise"),
        ("dwel_s = 0.1", "'dwell_s'"),
    ],
)
def test_sensors_that_cannot_be_are_refused(table, said):
    with pytest.raises(ConfigError, match=said):
        study_of(STUDY + f"[sensor]\n{table}\n")
