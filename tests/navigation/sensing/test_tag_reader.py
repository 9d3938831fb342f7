"""The readings of a designed reader of many tags: sums of antennas, ranges and bearings, SLAM."""

import math

import numpy as np
import pytest

from octant.navigation.estimators.pose_filters import WheelMotion
from octant.navigation.estimators.slam_filter import SlamEstimator
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.rss_models import LogDistanceLaw
from octant.navigation.sensing.sensor import FieldSensor
from octant.navigation.sensing.tag_reader import RangeBearingReader, TagReader

AZIMUTHS = np.arange(8) * math.pi / 4.0
LAW = LogDistanceLaw(rss_1m_dbm=-40.0, exponent=2.0)
PLACES = {"a": (2.0, 1.0), "b": (-1.0, 3.0)}
HEIGHT_M = 1.5


class Cosines:
    """Antennas whose power is 1 + cos about their azimuth, over eight, in free space."""

    def __init__(self, place):
        self.place = place

    def rss_w(self, poses):
        offset = np.array(self.place) - poses[:, :2]
        distance = np.sqrt(np.sum(offset**2, axis=1) + HEIGHT_M**2)
        towards = np.arctan2(offset[:, 1], offset[:, 0]) - poses[:, 2] + math.pi / 2.0
        total = 10.0 ** ((LAW.rss_dbm(distance) - 30.0) / 10.0)
        return total[:, None] * (1.0 + np.cos(towards[:, None] - AZIMUTHS)) / 8.0


def reader(kind=TagReader, sensitivity_w=0.0, **more):
    sensor = FieldSensor(
        links={name: Cosines(place) for name, place in PLACES.items()},
        azimuths_rad=AZIMUTHS,
        sensitivity_w=sensitivity_w,
    )
    return kind(sensor=sensor, low_m=np.full(2, -5.0), high_m=np.full(2, 5.0), **more)


POSES = np.array([[0.0, 0.0, 0.3], [1.0, -1.0, -2.0]])


def read(one, poses=POSES):
    rngs = [np.random.default_rng(i) for i in range(len(poses))]
    return one.read(poses, np.zeros((len(poses), 2)), rngs)


def test_the_sum_of_the_antennas_follows_the_law_whatever_the_heading():
    offset = POSES[:, None, :2] - np.array(list(PLACES.values()))
    distance = np.sqrt(np.sum(offset**2, axis=2) + HEIGHT_M**2)
    assert read(reader()) == pytest.approx(LAW.rss_dbm(distance), abs=1e-9)
    assert np.isnan(read(reader(sensitivity_w=1.0))).all()


def test_range_and_bearing_are_those_of_the_tag():
    found = read(reader(RangeBearingReader, law=LAW, height_m=HEIGHT_M)).reshape(2, 2, 2)
    for run, (x, y, heading) in enumerate(POSES):
        for tag, place in enumerate(PLACES.values()):
            away = np.subtract(place, (x, y))
            assert found[run, tag, 0] == pytest.approx(np.hypot(*away))
            bearing = math.atan2(away[1], away[0]) - heading
            assert math.remainder(found[run, tag, 1] - bearing, math.tau) == pytest.approx(
                0.0, abs=1e-9
            )


def test_outside_its_rectangle_it_reads_what_it_would_at_the_rim():
    outside, rim = np.array([[9.0, 0.0, 0.1]]), np.array([[5.0, 0.0, 0.1]])
    assert (read(reader(), outside) == read(reader(), rim)).all()


def test_slam_with_good_readings_finds_robot_and_tags_and_without_any_reckons():
    motion = WheelMotion(robot=DifferentialDrive(), period_s=0.1, rate_sigma_rad_per_s=0.3)
    true_tags = np.array(list(PLACES.values()))
    slam = SlamEstimator(
        motion=motion, tags_m=true_tags, tag_sigma_m=0.2, range_sigma_m=0.1, bearing_sigma_rad=0.1
    )
    board = reader(RangeBearingReader, law=LAW, height_m=HEIGHT_M)
    rng, pose = np.random.default_rng(1), np.array([[0.0, 0.0, 0.3]])
    beliefs = [slam.begin(pose, np.zeros((3, 3)), [np.random.default_rng(2)]) for _ in range(3)]
    reckoned, rates = pose, np.array([[4.0, 3.4]])
    for _ in range(200):
        pose = motion.moved(pose, rates + rng.normal(0.0, 0.3, (1, 2)))
        reckoned = motion.moved(reckoned, rates)
        measured = read(board, pose)
        for i, given in enumerate((measured, None, np.full_like(measured, np.nan))):
            beliefs[i] = slam.step(beliefs[i], rates, given, [rng])
    found = beliefs[0].mean[0]
    assert found[:2] == pytest.approx(pose[0, :2], abs=0.1)
    assert found[3:].reshape(2, 2) == pytest.approx(true_tags, abs=0.1)
    for silent in beliefs[1:]:
        assert slam.poses(silent) == pytest.approx(reckoned, abs=1e-9)
    assert np.hypot(*(reckoned - pose)[0, :2]) > 0.1


def test_a_run_that_hears_nothing_is_not_touched_by_what_another_hears():
    motion = WheelMotion(robot=DifferentialDrive(), period_s=0.1, rate_sigma_rad_per_s=0.3)
    slam = SlamEstimator(motion=motion, tags_m=np.array(list(PLACES.values())))
    rngs = [np.random.default_rng(i) for i in range(2)]
    belief = slam.begin(POSES, 0.01 * np.eye(3), rngs)
    measured = read(reader(RangeBearingReader, law=LAW, height_m=HEIGHT_M))
    measured[1] = np.nan
    rates = np.full((2, 2), 2.0)
    heard, silent = slam.step(belief, rates, measured, rngs), slam.step(belief, rates, None, rngs)
    assert (heard.mean[1] == silent.mean[1]).all()
    assert (heard.covariance[1] == silent.covariance[1]).all()
    assert not np.allclose(heard.mean[0], silent.mean[0], atol=1e-3)
