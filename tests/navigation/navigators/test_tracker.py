"""The tracker of the tag's place, on a closed-form field: free of the room solver."""

from dataclasses import replace

import numpy as np
import pytest
from slow_rest import slow_after

from octant.geometries.errors import NavigationError
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.navigators import tracker_navigator
from octant.navigation.missions.run import run_mission, run_missions
from octant.navigation.navigators._place_kernels import place_log_likelihood
from octant.navigation.navigators.interface import STILL, Odometry
from octant.navigation.navigators.place_particles import (
    PlaceBelief,
    PlaceFilter,
    levels_learned,
)
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.odometry import Rolling
from octant.navigation.sensing.pattern_match import power_table
from octant.navigation.sensing.sensor import FieldSensor

ROBOT = DifferentialDrive()
TAG = (2.0, 0.5)
FLOOR = Rolling(slip_sd=0.02, scale_sd=0.01, tick_rad=0.003)


@pytest.fixture
def table(free_space_link):
    return power_table(free_space_link(), (0.0, 0.0), sides=1)


@pytest.fixture
def tracker(table):
    def make(mission, **options):
        tables = (table,) * len(mission.tag_ids)
        return replace(tracker_navigator(mission, tables=tables, robot=ROBOT), **options)

    return make


class Deceived:
    """A link that now and then shows a whole reading turned by half: a capture."""

    def __init__(self, link, every):
        self.link, self.every, self.count = link, every, 0

    def rss_w(self, poses):
        self.count += 1
        rss = self.link.rss_w(poses)
        return np.roll(rss, 4, axis=1) if self.count % self.every == 0 else rss


class Silent:
    def rss_w(self, poses):
        return np.zeros((len(poses), 8))


def particles_of(rng, count):
    """Particles (9, count) within 4 m, their errors known to 1 to 9 dB each, somehow correlated."""
    low, high = [-4, -4, -30, -9, -9, -9, 1, -1, 1], [4, 4, 0, 9, 9, 9, 80, 1, 80]
    particles = rng.uniform(low, high, (count, 9)).T.copy()
    particles[7] *= np.sqrt(particles[6] * particles[8])
    return particles


def explained(
    table,
    particles,
    rss_db,
    *,
    noise_db=2.0,
    fading_db=4.0,
    trust=1.0,
    reference_db=None,
    independent=8.0,
):
    result = np.empty((3, particles.shape[1]))
    if reference_db is None:
        reference_db = 10.0 * np.log10(table.reference_w)
    power, reach = table.power_w, table.reach_m
    place_log_likelihood(
        *(particles, reach, power, reference_db, rss_db),
        *(noise_db, fading_db, trust, 0.02, independent, result),
    )
    return result


def by_numpy(table, particle, rss_db, noise, fading, trust):
    """The log-likelihood of one particle by array operations, for a table of any sides.

    Also mean and covariance of the two errors that all antennas share, after the reading.
    """
    ahead, left, diffuse_db, heading, *mean, first, both, second = particle
    mean, covariance = np.array(mean), np.array([[first, both], [both, second]])
    place = ahead, left
    rows, bearings, sides, antennas = table.power_w.shape
    rho, phi = np.hypot(*place), np.arctan2(place[1], place[0])
    u = np.sqrt(rho / table.reach_m) * (rows - 1)
    v = phi / (2 * np.pi) % 1.0 * bearings
    w = (heading + phi + np.pi) / (2 * np.pi) % 1.0 * sides
    expected = 0.0
    for i, a in ((int(u), 1 - u % 1), (int(u) + 1, u % 1)):
        for j, b in ((int(v) % bearings, 1 - v % 1), ((int(v) + 1) % bearings, v % 1)):
            for k, c in ((int(w) % sides, 1 - w % 1), ((int(w) + 1) % sides, w % 1)):
                expected = expected + a * b * c * table.power_w[i, j, k]
    diffuse = 10.0 ** (diffuse_db / 10.0) * table.reference_w + 0.02 * expected.mean()
    share = diffuse / (expected + diffuse)
    common = diffuse / (expected.mean() + diffuse)
    own = np.diag(noise**2 + fading**2 * share * (2 - share))
    errors = (own + fading**2 * common * (2 - common)) / trust
    of_both = np.ones((antennas, 2))
    total = of_both @ covariance @ of_both.T + errors
    error = rss_db - 10.0 * np.log10(expected + diffuse) - of_both @ mean
    gain = covariance @ of_both.T @ np.linalg.inv(total)
    determinants = np.linalg.slogdet(total)[1] - np.linalg.slogdet(own / trust)[1]
    determinants += trust * np.linalg.slogdet(own)[1]
    log_likelihood = -0.5 * (error @ np.linalg.solve(total, error) + determinants)
    return log_likelihood, mean + gain @ error, covariance - gain @ of_both @ covariance


@pytest.mark.parametrize("trust", [1.0, 0.3])
def test_the_likelihood_is_the_gaussian_of_correlated_decibels(free_space_link, trust):
    table = power_table(free_space_link(), (0.0, 0.0), sides=3, bearings=12, distances=9)
    rng = np.random.default_rng(0)
    particles = particles_of(rng, 40)
    rss_db = rng.uniform(-80, -50, 8)
    result = explained(table, particles, rss_db, noise_db=2.0, fading_db=4.0, trust=trust)
    learned = levels_learned(particles, *result[1:], np.ones(40))
    assert np.array_equal(levels_learned(particles, *result[1:], np.zeros(40)), particles)
    for p in range(40):
        log, mean, covariance = by_numpy(table, particles[:, p], rss_db, 2.0, 4.0, trust)
        assert result[0, p] == pytest.approx(log, abs=1e-8)
        assert learned[4:6, p] == pytest.approx(mean, abs=1e-8)
        assert learned[6:, p] == pytest.approx(covariance[[0, 0, 1], [0, 1, 1]], abs=1e-8)


def test_antennas_that_hear_nothing_say_nothing(table):
    rng = np.random.default_rng(0)
    few = replace(table, power_w=table.power_w[..., :5].copy())
    particles, heard = particles_of(rng, 20), rng.uniform(-80, -50, 5)
    five = explained(few, particles, heard, reference_db=-60.0)
    padded = np.concatenate([heard, np.full(3, -np.inf)])
    assert explained(table, particles, padded, reference_db=-60.0) == pytest.approx(five, abs=1e-9)


@pytest.mark.parametrize("copies", [2, 4])
def test_copies_of_the_same_antennas_make_it_no_surer(free_space_link, copies):
    """Errors of antennas are those of one field: 16 or 32 are no better witnesses than 8."""
    table, rng = power_table(free_space_link(), (0.0, 0.0), sides=1), np.random.default_rng(0)
    many = replace(table, power_w=np.repeat(table.power_w, copies, axis=3))
    reading = table.power_w[20, 3, 0] * 10.0 ** (0.1 * rng.normal(0.0, 2.0, 8))

    def surprise(table, rss_w):
        place_filter, own = PlaceFilter(table=table, trust=0.2), np.random.default_rng(1)
        some = PlaceBelief(places=particles_of(own, 2000), weights=np.full(2000, 1 / 2000))
        weights = place_filter.observed(some, rss_w, own).weights
        return np.std(np.log(weights))

    once, often = surprise(table, reading), surprise(many, np.repeat(reading, copies))
    assert once > 0.1
    assert often == pytest.approx(once, rel=1e-9)


@pytest.mark.parametrize("off_db", [-10.0, 10.0])
def test_a_level_that_is_off_is_found_out(table, free_space_link, off_db):
    rng, place_filter, link = np.random.default_rng(0), PlaceFilter(table=table), free_space_link()
    pose, factor = np.array([-3.0, -1.0, 0.3]), 10.0 ** (0.1 * off_db)
    belief = place_filter.start(rng, heading_rad=0.0, heading_sd_rad=0.05)
    for _ in range(30):
        belief = place_filter.observed(belief, factor * link.rss_w(pose[None])[0], rng)
        belief = place_filter.moved(belief, Odometry(distance_m=0.09), rng)
        pose[:2] += 0.09 * np.cos(pose[2]), 0.09 * np.sin(pose[2])
    estimate = place_filter.estimate(belief)
    assert estimate.level_db == pytest.approx(off_db, abs=6.0)
    assert abs(estimate.distance_m - np.hypot(*pose[:2])) < 0.9


def test_a_contact_counts_against_the_places_it_was_on_the_way_to(table):
    place_filter, rng = PlaceFilter(table=table), np.random.default_rng(0)
    places = np.zeros((9, 4))
    places[:2] = [[0.3, 1.5, -0.3, 0.0], [0.0, 0.0, 0.0, 0.3]]
    belief = PlaceBelief(places=places, weights=np.full(4, 0.25))
    ahead, far, behind, beside = place_filter.moved(belief, Odometry(contact=True), rng).weights
    assert ahead < 0.6 * far < far < 1.01 * behind
    assert beside == pytest.approx(behind, rel=0.01)


def test_motion_moves_the_place_in_the_robots_frame_and_turns_the_heading(table):
    exact = PlaceFilter(table=table, travel_sd=1e-12, heading_sd_rad=1e-12)
    belief = PlaceBelief(
        places=np.array([[1.0, 0.0, -20.0, 0.3, 2.0, -3.0, 9.0, 1.0, 4.0]]).T, weights=[1.0]
    )
    # A quarter circle of radius 1 to the left ends at (1, 1), facing +y of the old frame.
    quarter = Odometry(distance_m=np.pi / 2, turn_rad=np.pi / 2)
    chord = Odometry(distance_m=np.sqrt(2.0), turn_rad=np.pi / 2)
    rng = np.random.default_rng(0)
    moved = exact.moved(belief, chord, rng)
    assert moved.places[:4, 0] == pytest.approx([-1.0, 0.0, -20.0, 0.3 + np.pi / 2], abs=1e-9)
    assert exact.moved(belief, quarter, rng).places[3, 0] == pytest.approx(0.3 + np.pi / 2)
    # Ornstein-Uhlenbeck: the part of the place fades, the tag's stays.
    alike = np.exp(-np.sqrt(2.0) / exact.shared_m)
    variance = exact.shared_db**2 + alike**2 * (4.0 - exact.shared_db**2)
    assert moved.places[4:, 0] == pytest.approx([2.0, -3.0 * alike, 9.0, alike, variance])
    turned = exact.moved(belief, Odometry(turn_rad=1.0), rng)
    assert turned.places[4:, 0] == pytest.approx(belief.places[4:, 0])


def test_after_a_contact_the_way_is_any_part_of_what_the_wheels_turned(table):
    rng, count = np.random.default_rng(0), 4000
    exact = PlaceFilter(table=table, travel_sd=1e-12, heading_sd_rad=1e-12)
    places = np.zeros((9, count))
    places[0] = 1.0
    belief = PlaceBelief(places=places, weights=np.full(count, 1.0 / count))
    moved = exact.moved(belief, Odometry(distance_m=0.1, contact=True), rng).places[0]
    assert (moved.min(), moved.max()) == pytest.approx((0.9, 1.0), abs=1e-3)
    assert moved.mean() == pytest.approx(0.95, abs=0.002)


def test_readings_from_many_poses_agree_on_the_place(table, free_space_link):
    rng, place_filter, link = np.random.default_rng(0), PlaceFilter(table=table), free_space_link()
    pose = np.array([-2.0, -1.0, 0.0])
    belief = place_filter.start(rng, heading_rad=0.0, heading_sd_rad=0.05)
    first = place_filter.estimate(belief)
    step = Odometry(distance_m=0.1, turn_rad=0.05)
    for _ in range(25):
        belief = place_filter.observed(belief, link.rss_w(pose[None])[0], rng)
        belief = place_filter.moved(belief, step, rng)
        pose += [0.1 * np.cos(pose[2] + 0.025), 0.1 * np.sin(pose[2] + 0.025), 0.05]
    estimate = place_filter.estimate(belief)
    away = -pose[:2]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    wanted = [cosine * away[0] + sine * away[1], cosine * away[1] - sine * away[0]]
    assert np.linalg.norm(estimate.place_m - wanted) < 0.15
    assert estimate.share > 0.95 > 0.2 > first.share
    assert estimate.spread_m < 0.3
    assert belief.effective_size > 500


@pytest.mark.parametrize(("cells", "wanted"), [(1, 2000), (8, 4000), (40, 10000)])
def test_a_belief_divided_among_more_cells_has_more_particles(table, cells, wanted):
    rng, place_filter = np.random.default_rng(0), PlaceFilter(table=table, trust=1e-3)
    places = np.zeros((9, 9000))
    places[0], places[1] = 0.25 + 0.5 * (np.arange(9000) % cells), 0.25
    weights = np.where(np.arange(9000) < 3000, 1.0 / 3000, 0.0)
    belief = PlaceBelief(places=places, weights=weights)
    drawn = place_filter.observed(belief, np.full(8, 1e-6), rng)
    assert len(drawn.weights) == pytest.approx(wanted, rel=0.02)
    assert place_filter.particles <= len(drawn.weights) <= place_filter.most


@pytest.mark.parametrize(("share", "kept"), [(0.3, True), (0.2, False)])
def test_it_keeps_to_a_place_until_another_is_clearly_more_probable(table, share, kept):
    places = np.zeros((9, 2))
    places[0] = [2.0, -3.0]
    belief = PlaceBelief(places=places, weights=[share, 1.0 - share])
    place_filter = PlaceFilter(table=table, loyalty=3.0)
    assert place_filter.estimate(belief).place_m[0] == pytest.approx(-3.0)
    estimate = place_filter.estimate(belief, held_m=np.array([2.2, 0.1]))
    assert estimate.place_m[0] == pytest.approx(2.0 if kept else -3.0)
    assert estimate.share == pytest.approx(share if kept else 1.0 - share)


def test_without_a_signal_the_belief_stays(table):
    rng, place_filter = np.random.default_rng(0), PlaceFilter(table=table)
    belief = place_filter.start(rng, heading_rad=0.0, heading_sd_rad=0.1)
    assert place_filter.observed(belief, np.zeros(8), rng) is belief


@pytest.mark.parametrize("rolling", slow_after(1, [FLOOR, Rolling()]), ids=["slipping", "exact"])
def test_all_tags_are_reached_within_12_cm_of_the_way(thesis_setup, tracker, rolling):
    mission, sensor = thesis_setup(noise_db=1.0)
    mission = replace(mission, rolling=rolling)
    results = run_missions(mission, sensor, tracker(mission), ROBOT, runs=5, seed=1)
    metrics = [measure(result) for result in results]
    assert all(run.success for run in metrics)
    assert np.median([run.rmse_m for run in metrics]) <= 0.08
    assert max(np.max(run.arrival_errors_m) for run in metrics) < 0.25


def test_captured_readings_do_not_keep_it_from_the_tags(thesis_setup, tracker):
    mission, sensor = thesis_setup(noise_db=1.0)
    links = {tag: Deceived(link, 5) for tag, link in sensor.links.items()}
    deceived = FieldSensor(links=links, azimuths_rad=sensor.azimuths_rad, noise_db=1.0)
    results = run_missions(mission, deceived, tracker(mission), ROBOT, runs=3, seed=1)
    assert all(measure(result).success for result in results)


def test_a_run_is_the_same_to_the_bit_again_and_differs_by_the_seed(thesis_setup, tracker):
    mission, sensor = thesis_setup(noise_db=1.0)
    mission = replace(mission, max_time_s=8.0, rolling=FLOOR)
    robot = tracker(mission)
    one, two = (run_missions(mission, sensor, robot, ROBOT, runs=2, seed=5) for _ in range(2))
    assert all(np.array_equal(a.poses, b.poses) for a, b in zip(one, two, strict=True))
    assert not np.array_equal(one[0].poses, one[1].poses)


def test_an_unreachable_tag_ends_the_run_and_not_the_robot(thesis_setup, tracker):
    mission, sensor = thesis_setup()
    shut = replace(mission, contact="slide", contact_limit=15)
    walled = run_mission(
        shut,
        sensor,
        tracker(shut),
        ROBOT,
        np.random.default_rng(0),
        blocked=lambda points: np.abs(points).max(axis=1) > 0.6,
    )
    assert walled.outcome == "stuck"
    assert "touched obstacles 15 times" in walled.reason
    assert "evade" in walled.modes
    assert np.abs(walled.poses[:, :2]).max() <= 0.6
    silent = FieldSensor(
        links=dict.fromkeys(mission.tag_ids, Silent()), azimuths_rad=sensor.azimuths_rad
    )
    result = run_mission(mission, silent, tracker(mission), ROBOT, np.random.default_rng(0))
    assert result.outcome == "no signal"


def test_patience_over_the_belief_begins_anew(thesis_setup, tracker):
    mission, sensor = thesis_setup()
    robot = tracker(mission, patience=2)
    rng = np.random.default_rng(0)
    rss = sensor.read(np.zeros(3), mission.tag_ids[0], rng)
    memory = robot.begin(0, None, heading_rad=0.0)
    first = robot.decide(memory, rss, STILL, rng).memory
    second = robot.decide(first, rss, STILL, rng).memory
    assert first.belief is not None
    assert (second.belief, second.readings) == (None, 0)


def test_the_next_leg_keeps_the_heading_and_forgets_the_place(thesis_setup, tracker):
    mission, sensor = thesis_setup()
    robot = tracker(mission)
    rng = np.random.default_rng(0)
    memory = robot.begin(0, None, heading_rad=0.7)
    rss = sensor.read(np.zeros(3), mission.tag_ids[0], rng)
    memory = robot.decide(memory, rss, Odometry(turn_rad=0.2), rng).memory
    following = robot.begin(1, memory, heading_rad=0.7)
    assert following.heading_rad == pytest.approx(0.9, abs=0.02)
    assert (following.belief, following.target) == (None, 1)
    with pytest.raises(NavigationError, match="4 filters"):
        robot.begin(4, memory, heading_rad=0.0)


@pytest.mark.parametrize("option", [{"trust": 0.0}, {"outlier_share": 1.0}, {"noise_db": 0.0}])
def test_filters_that_cannot_be_are_refused(table, option):
    with pytest.raises(NavigationError, match=next(iter(option))):
        PlaceFilter(table=table, **option)


def test_the_record_says_where_the_tag_was_believed_in_the_room(thesis_setup, tracker):
    mission, sensor = thesis_setup(noise_db=1.0)
    result = run_mission(mission, sensor, tracker(mission), ROBOT, np.random.default_rng(2))
    last = len(result.time_s) - 1
    ends = [*(np.flatnonzero(np.diff(result.targets))), last]
    for target, row in enumerate(ends):
        believed = result.believed_points_m[row - 4 : row]
        assert np.linalg.norm(believed - mission.tag_points_m[target], axis=1).max() < 0.3
