"""The robot's pose by field maps: on a closed-form field of few waves, free of the room solver."""

import math
from dataclasses import replace

import numpy as np
import pytest

from octant.em.power.field_maps import FieldMap
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.navigators._pose_kernels import pose_log_likelihood
from octant.navigation.navigators.interface import STILL, Odometry
from octant.navigation.navigators.map_navigator import (
    SURE_SDS,
    CountingNavigator,
    Follower,
    MapNavigator,
)
from octant.navigation.navigators.pose_particles import PoseFilter
from octant.navigation.navigators.readings import supposed_shares
from octant.navigation.navigators.ways import floor_plan
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import move

SIDE_M, WAVENUMBER, TAGS, ANTENNAS, HEADINGS = 2.4, 50.0, 3, 8, 64
RING = 2.0 * np.pi / ANTENNAS * np.arange(ANTENNAS)
LOW, HIGH = np.zeros(2), np.full(2, SIDE_M)


def power_w(tag, x, y, azimuth):
    """Coherent power, and sum of the paths' powers [W], of an antenna that looks to an azimuth."""
    rng = np.random.default_rng(tag)
    images = np.array([*rng.uniform(-0.5, SIDE_M + 0.5, (1, 2)), *rng.uniform(-4.0, 6.0, (4, 2))])
    strength = np.array([1.0, *rng.uniform(0.3, 0.6, 4)])
    x, y, azimuth = (np.asarray(v, dtype=float)[..., None] for v in (x, y, azimuth))
    dx, dy = images[:, 0] - x, images[:, 1] - y
    length = np.sqrt(dx**2 + dy**2 + 1.5**2)
    # 1.1 + cos of the angle between the antenna's direction and the image's.
    pattern = 1.1 + (np.cos(azimuth) * dx + np.sin(azimuth) * dy) / length
    field = 1e-3 * strength / length * pattern * np.exp(-1j * WAVENUMBER * length)
    return np.abs(field.sum(-1)) ** 2, (np.abs(field) ** 2).sum(-1)


def codes(power, top_dbm):
    return np.clip(np.rint(255 + (10 * np.log10(power) + 30 - top_dbm) / 0.25), 0, 255)


@pytest.fixture(scope="module")
def maps():
    x, node = np.linspace(0, SIDE_M, 97), np.linspace(0, SIDE_M, 25)
    heading = 2.0 * np.pi / HEADINGS * np.arange(HEADINGS)
    top = -20.0
    levels, means = [], []
    for tag in range(TAGS):
        for axis, kept, which in ((x, levels, 0), (node, means, 1)):
            gx, gy, gh = np.meshgrid(axis, axis, heading, indexing="ij")
            kept.append(codes(power_w(tag, gx, gy, gh)[which], top)[:, :, None])
    return FieldMap(
        x_m=x,
        y_m=x,
        levels=np.array(levels).astype(np.uint8),
        node_x_m=node,
        node_y_m=node,
        means=np.array(means).astype(np.uint8),
        ring=np.zeros(ANTENNAS, int),
        shift_rad=RING,
        top_dbm=np.full(TAGS, top),
    )


def reading(pose, rng, *, noise_db=1.0, levels_db=(0.0, 0.0, 0.0), gains_db=0.0):
    power = np.array([power_w(t, pose[0], pose[1], pose[2] + RING)[0] for t in range(TAGS)])
    error = noise_db * rng.standard_normal(power.shape) + np.array(levels_db)[:, None] + gains_db
    return power * 10.0 ** (0.1 * error)


@pytest.fixture
def pose_filter(maps):
    return PoseFilter(
        maps=maps,
        shares=np.full(TAGS, 0.03),
        floors_w=np.zeros(TAGS),
        low_m=LOW,
        high_m=HIGH,
        blocked=None,
        wavelength_m=2.0 * np.pi / WAVENUMBER,
        noise_db=1.0,
        fading_db=np.full(TAGS, 5.0),
    )


def drive(pose_filter, belief, pose, rng, *, steps, slip=0.03, **errors):
    """Drive in an arc whose way the odometry gets wrong by a slip."""
    for _ in range(steps):
        belief = pose_filter.moved(belief, Odometry(distance_m=0.06, turn_rad=0.1), rng)
        pose = move(pose, distance_m=0.06 * (1.0 - slip), turn_rad=0.1 * (1.0 + slip))
        belief = pose_filter.observed(belief, reading(pose, rng, **errors), rng)
    return belief, pose


def off_m(pose_filter, belief, pose):
    return math.dist(pose_filter.estimate(belief).pose[:2], pose[:2])


def test_from_a_known_start_slip_is_made_up_for_and_levels_are_found(pose_filter):
    rng, pose = np.random.default_rng(3), np.array([1.2, 1.0, 0.3])
    belief = pose_filter.start(rng, pose=pose)
    gains = np.array([1.5, -1.0, 0.5, 0.0, -1.5, 0.5, 0.5, -0.5])
    belief, pose = drive(
        pose_filter, belief, pose, rng, steps=60, levels_db=(2.0, -2.0, 0.0), gains_db=gains
    )
    estimate = pose_filter.estimate(belief)
    assert off_m(pose_filter, belief, pose) < 0.02
    assert abs(wrap_angle(estimate.pose[2] - pose[2])) < 0.05
    assert belief.level_db[0] - belief.level_db[1] == pytest.approx(4.0, abs=1.0)
    assert np.corrcoef(belief.gain_db, gains)[0, 1] > 0.8
    assert not pose_filter.lost(belief)


@pytest.mark.parametrize("seed", [2, 4, 5])
def test_from_nowhere_the_pose_is_found(pose_filter, seed):
    rng, pose = np.random.default_rng(seed), np.array([1.4, 0.9, 2.0])
    belief, pose = drive(pose_filter, pose_filter.start(rng, pose=None), pose, rng, steps=25)
    assert off_m(pose_filter, belief, pose) < 0.03
    assert len(belief.weights) < 4000


@pytest.mark.parametrize("seed", [4, 5, 6, 7])
def test_a_carried_robot_is_found_again(pose_filter, seed):
    rng, pose = np.random.default_rng(seed), np.array([1.2, 1.0, 0.3])
    belief, pose = drive(pose_filter, pose_filter.start(rng, pose=pose), pose, rng, steps=10)
    pose = np.array([1.2, 1.4, 3.0])
    belief, pose = drive(pose_filter, belief, pose, rng, steps=1)
    assert off_m(pose_filter, belief, pose) > 0.1
    belief, pose = drive(pose_filter, belief, pose, rng, steps=60)
    assert off_m(pose_filter, belief, pose) < 0.03


def test_the_limit_of_the_lost_pose_follows_from_how_well_the_maps_fit(pose_filter):
    rng = np.random.default_rng(1)
    poses = np.column_stack([rng.uniform(0.3, 2.1, (40, 2)), rng.uniform(-np.pi, np.pi, 40)])
    fitting = np.array([reading(pose, rng, noise_db=0.0) for pose in poses]).swapaxes(0, 1)
    assert pose_filter.limit_of(poses, fitting, rng) == pose_filter.rivals_limit == 0.35
    poor = fitting * rng.exponential(size=fitting.shape)
    limit = pose_filter.limit_of(poses, poor, rng)
    assert 0.5 < limit <= 0.95
    belief = replace(pose_filter.start(rng, pose=poses[0]), rivals=0.45)
    assert pose_filter.lost(belief)
    assert not replace(pose_filter, rivals_limit=limit).lost(belief)


def test_the_likelihood_is_that_of_the_formula(maps):
    """One share, no level known beforehand, against NumPy's multivariate normal."""
    rng = np.random.default_rng(0)
    pose = np.array([[1.0], [1.1], [0.4]])
    rss_db = 10.0 * np.log10(reading(pose[:, 0], rng))
    trusted = np.tile([1.0, 1e-300, 1e-300], (TAGS, 1))
    logs, parts = np.empty(1), np.empty((1, TAGS, 3))
    share, level_db, noise_db, fading_db = 0.1, 2.0, 1.0, 5.0
    grid, node_grid = np.array([0, 0, 0.025, 0.025]), np.array([0, 0, 0.1, 0.1])
    pose_log_likelihood(
        pose, grid, maps.levels, node_grid, maps.means, maps.powers_w, maps.ring,
        RING * HEADINGS / (2.0 * np.pi), rss_db, np.zeros(TAGS), np.full(TAGS, level_db**2),
        np.zeros(ANTENNAS), np.array([share, 1.0]), np.zeros(TAGS), noise_db,
        np.full(TAGS, fading_db), 15.0, 1.0, trusted, logs, parts,
    )  # fmt: skip
    wanted = 0.0
    node = np.round(pose.T / 0.1) * 0.1
    node[:, 2] = pose[2]
    for tag in range(TAGS):
        here = maps.rss_w(pose.T, tag=tag)[0]
        diffuse = share * maps.local_mean_w(node, tag=tag)[0]
        part = diffuse / (here + diffuse)
        part *= 2.0 - part
        error = rss_db[tag] - 10.0 * np.log10(here + diffuse) + 2.51 * fading_db / 5.57 * part
        covariance = np.diag(noise_db**2 + fading_db**2 * part) + level_db**2
        size = np.linalg.slogdet(covariance)[1]
        wanted -= 0.5 * (error @ np.linalg.solve(covariance, error) + size)
    assert logs[0] == pytest.approx(wanted, rel=1e-6)


def test_the_readings_decide_between_the_expected_error_and_what_may_well_be():
    assert supposed_shares(0.04) == pytest.approx([0.04, 0.2, 1.0])
    assert supposed_shares(0.04, 0.5) == pytest.approx([0.04, 0.5, 1.0])
    assert supposed_shares(0.0, 1.0) == pytest.approx([0.001, 0.95, 1.0])


ROBOT = DifferentialDrive()
GOAL = np.array([[2.0, 1.6]])


def driven(navigator, pose, rng, *, limit=120, slip=0.03):
    """Return where a navigator declares arrival, or None."""
    memory, odometry = navigator.begin(0, None, heading_rad=0.0), STILL
    for _ in range(limit):
        told = reading(pose, rng) if isinstance(navigator, MapNavigator) else np.zeros(ANTENNAS)
        decision = navigator.decide(memory, told, odometry, rng)
        if decision.reached:
            return pose
        way, turn = (float(v) for v in ROBOT.twist(decision.rates))
        odometry = Odometry(distance_m=way, turn_rad=turn)
        pose = move(pose, distance_m=way * (1.0 - slip), turn_rad=turn * (1.0 + slip) + slip * way)
        memory = decision.memory
    return None


@pytest.fixture
def follower():
    plan = floor_plan(LOW, HIGH, GOAL, blocked=None)
    return Follower(plan=plan, robot=ROBOT, cruise_step_m=0.09, period_s=1.0)


def test_the_map_navigator_arrives_where_counting_does_not(pose_filter, follower):
    start, rng = np.array([0.4, 0.4, 2.0]), np.random.default_rng(0)
    by_map = MapNavigator(
        hears=("a", "b", "c"),
        targets=(0,),
        filter=pose_filter,
        follower=follower,
        start_pose=start,
        arrival_radius_m=0.1,
        tag_sd_m=0.01,
    )
    by_wheels = CountingNavigator(follower=follower, start_pose=start)
    assert math.dist(driven(by_map, start, rng)[:2], GOAL[0]) < 0.04
    assert math.dist(driven(by_wheels, start, rng)[:2], GOAL[0]) > 0.05
    # A survey that is not good enough for the radius never lets it say so.
    unsure = replace(by_map, tag_sd_m=0.1 / SURE_SDS)
    assert driven(unsure, start, rng, limit=60) is None
    with pytest.raises(NavigationError, match="tag number 2"):
        by_map.begin(1, None, heading_rad=0.0)


def test_the_robot_drives_to_where_the_tag_was_found_to_hang(pose_filter, follower):
    start, rng, off_m = np.array([0.4, 0.4, 2.0]), np.random.default_rng(0), np.zeros((TAGS, 3))
    off_m[1, :2] = 0.15, -0.1
    by_map = MapNavigator(
        hears=("a", "b", "c"),
        targets=(1,),
        filter=replace(pose_filter, base_m=off_m),
        follower=follower,
        start_pose=start,
        arrival_radius_m=0.1,
        tag_sd_m=0.01,
    )
    assert math.dist(driven(by_map, start, rng)[:2], GOAL[0] + off_m[1, :2]) < 0.04
