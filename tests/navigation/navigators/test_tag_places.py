"""Tags that hang half a wavelength beside their survey: found while driving, and the pose by them.

The truth is the reader link with the tags moved, which traces every pose.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.field_maps import joined, make_field_map, plan_map
from octant.em.power.node_paths import trace_node_paths
from octant.em.power.path_maps import make_path_map
from octant.em.power.received_power import reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings
from octant.geometries.errors import NavigationError
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.navigation.navigators.drawing import systematic
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.pose_particles import PoseFilter
from octant.navigation.navigators.tag_places import TagSurvey
from octant.navigation.robot.motion import move

CARRIER_HZ, WAVELENGTH_M = 2.4e9, 0.125
TAGS = np.array([[1.0, 2.6, 2.4], [3.0, 1.0, 2.4], [2.6, 3.0, 2.4]])
OFF = np.array([[0.05, -0.04, 0.03], [-0.06, 0.02, 0.05], [0.03, 0.07, -0.04]])
LOW, HIGH = np.array([1.2, 0.9]), np.array([2.8, 2.3])
RING = 2.0 * np.pi / 8.0 * np.arange(8)
SOLVER = SolverSettings(max_reflections=2)
SD_M = 0.05


@pytest.fixture(scope="module")
def room():
    scene = build_scene(box_room((4.0, 3.8, 2.6), material="concrete"))
    return [radio_scene(scene, CARRIER_HZ)], [sector_response(RING, frequency_hz=CARRIER_HZ)]


@pytest.fixture(scope="module")
def links(room):
    """Links of the tags as they hang."""
    radios, responses = room
    antenna = make_antenna("dipole", CARRIER_HZ)
    return [
        reader_link(
            radios, tag_position_m=place, tag_antenna=[antenna], tag_power_w=1.0,
            response=responses, reader_height_m=0.3, solver=SOLVER,
        )
        for place in TAGS + OFF
    ]  # fmt: skip


@pytest.fixture(scope="module")
def survey_filter(room):
    plan = plan_map(LOW, HIGH, wavelength_m=WAVELENGTH_M, spacing_m=0.03)
    antennas = [make_antenna("dipole", CARRIER_HZ)]
    traced = [
        trace_node_paths(
            room[0], plan.node_x_m, plan.node_y_m, tag_position_m=tag, tag_antennas=antennas,
            reader_z_m=0.3, solver=SOLVER,
        )
        for tag in TAGS
    ]  # fmt: skip
    sent = {"tag_power_w": 1.0, "reader_z_m": 0.3}
    maps = [make_field_map(some, *room, plan, **sent) for some in traced]
    paths = [make_path_map(some.strongest(), *room, plan, **sent) for some in traced]
    count = len(TAGS)
    return PoseFilter(
        maps=joined(maps),
        shares=np.full(count, 0.03),
        floors_w=np.zeros(count),
        low_m=LOW,
        high_m=HIGH,
        blocked=None,
        wavelength_m=WAVELENGTH_M,
        fading_db=np.full(count, 5.0),
        noise_db=1.0,
        survey=TagSurvey(
            paths=tuple(paths),
            sd_m=np.full((count, 3), SD_M),
            known_m=np.zeros((count, 3)),
            known_sd_m=np.full((count, 3), SD_M),
        ),
    )


START = np.array([1.6, 1.2, 0.4])


def driven(pose_filter, links, *, steps=22, slip=0.04, told=START):
    """Return belief and true pose after an arc in which the wheels slip."""
    rng = np.random.default_rng(5)
    return on(pose_filter, pose_filter.start(rng, pose=told), START, links, rng, steps, slip=slip)


def on(pose_filter, belief, pose, links, rng, steps, *, slip=0.04):
    for _ in range(steps):
        belief = pose_filter.moved(belief, Odometry(distance_m=0.08, turn_rad=0.16), rng)
        pose = move(pose, distance_m=0.08 * (1.0 - slip), turn_rad=0.16 * (1.0 + slip))
        power = np.array([link.rss_w(pose[None])[0] for link in links])
        reading = power * 10.0 ** (0.1 * rng.standard_normal(power.shape))
        belief = pose_filter.observed(belief, reading, rng)
    return belief, pose


def test_places_of_tags_and_the_pose_are_found_together(survey_filter, links):
    belief, pose = driven(survey_filter, links)
    estimate = survey_filter.estimate(belief)
    assert math.dist(estimate.pose[:2], pose[:2]) < 0.02
    # A third of the survey's error at most is left, and it says how much.
    left = belief.places.mean_m() - OFF
    assert np.sqrt(np.mean(left**2)) < SD_M / 3.0
    assert np.all(belief.places.sd_m() < SD_M / 2.0)
    assert not survey_filter.lost(belief)
    # What is found serves as survey of the next drive, a tenth of which the first one still is.
    learned = survey_filter.learned(belief, ("a", "b", "c"))
    start = survey_filter.taught(learned).start(np.random.default_rng(0), pose=pose)
    assert start.places.mean_m() == pytest.approx(0.9 * belief.places.mean_m(), abs=0.004)
    assert start.level_db == pytest.approx(belief.level_db)
    assert learned.of(("c", "a"), antennas=8).offset_m == pytest.approx(learned.offset_m[[2, 0]])
    with pytest.raises(NavigationError, match="learn anew"):
        learned.of(("a", "d"), antennas=8)


def test_believing_the_survey_the_pose_is_not_found_as_well(survey_filter, links):
    belief, pose = driven(replace(survey_filter, survey=None), links)
    estimate = survey_filter.estimate(belief)
    assert math.dist(estimate.pose[:2], pose[:2]) > 0.03


def test_a_robot_that_is_carried_finds_itself_by_the_places_that_it_keeps(survey_filter, links):
    belief, _ = driven(survey_filter, links)
    found = belief.places.mean_m()
    carried, rng = np.array([1.55, 1.8, -2.0]), np.random.default_rng(2)
    belief, pose = on(survey_filter, belief, carried, links, rng, 4)
    assert math.dist(survey_filter.estimate(belief).pose[:2], pose[:2]) > 0.3
    # It need not know yet where it is, but that it is not where it believes to be.
    assert survey_filter.lost(belief)
    belief, pose = on(survey_filter, belief, pose, links, rng, 20)
    assert math.dist(survey_filter.estimate(belief).pose[:2], pose[:2]) < 0.02
    assert not survey_filter.lost(belief)
    kept = np.sqrt(np.mean((belief.places.mean_m() - OFF) ** 2))
    assert kept < np.sqrt(np.mean((found - OFF) ** 2)) + 0.005


def test_a_pose_that_is_not_known_moves_no_place(survey_filter, links):
    rng = np.random.default_rng(1)
    before = survey_filter.start(rng, pose=None)
    assert not before.proven
    belief, _ = on(survey_filter, before, START, links, rng, 2)
    assert belief.places is before.places
    assert survey_filter.lost(belief)


def test_as_many_places_are_supposed_as_the_survey_leaves_open(survey_filter):
    rng = np.random.default_rng(0)
    counts = []
    for sd_m in (0.005, 0.02, 0.05):
        sd = np.full((3, 3), sd_m)
        survey = replace(survey_filter.survey, sd_m=sd, known_sd_m=sd)
        counts.append(len(survey.start(rng).weights[0]))
    # 80 in each cube of 2 cm of a normal distribution's volume, (2 pi)^(3/2) sd^3.
    assert counts == [survey.least, round(80 * (2 * np.pi) ** 1.5), survey.most]


def test_where_only_the_local_mean_tells_poses_are_spread_by_a_wavelength(
    survey_filter,
):
    rng, pose = np.random.default_rng(0), START
    belief = survey_filter.start(rng, pose=pose, sd_m=0.001, sd_rad=0.001)
    spread = {}
    for faded in (0.0, 1.0):
        trusted = np.tile([1.0 - faded, 0.0, faded, 0.0], (3, 1))
        drawn = survey_filter._drawn_anew(
            replace(belief, trusted=trusted), 2000, rng, scouts=pose[:, None]
        )
        spread[faded] = float(np.std(drawn.poses[0]))
    assert spread[0.0] < 0.01
    assert spread[1.0] == pytest.approx(survey_filter.wavelength_m, rel=0.1)


def test_systematic_drawing_takes_each_particle_as_often_as_it_weighs():
    weights = np.array([0.1, 0.0, 0.6, 0.3])
    chosen = systematic(weights, 1000, np.random.default_rng(0))
    assert np.bincount(chosen, minlength=4) == pytest.approx(1000 * weights, abs=1.0)


def test_a_survey_of_other_tags_is_refused(survey_filter):
    with pytest.raises(NavigationError, match="shape"):
        replace(survey_filter.survey, sd_m=np.full((1, 3), SD_M))
