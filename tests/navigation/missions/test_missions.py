import sys
import textwrap
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from thesis_robot import thesis_robot

from octant.geometries.errors import NavigationError, PhysicsWarning
from octant.navigation.control.controllers import FuzzyController, VectorSumController
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.records import Mission
from octant.navigation.missions.run import run_mission, run_missions
from octant.navigation.navigators.arrival import ArrivalTest
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import AT_REST
from octant.navigation.sensing.sensor import FieldSensor

ROBOT = DifferentialDrive()
TEST = ArrivalTest(threshold_w=1e-9)


def simple(**options):
    settings = {
        "start_m": (0.0, 0.0),
        "heading_rad": 0.0,
        "tag_ids": ("a",),
        "tag_points_m": [(1.0, 0.0)],
        "arrivals": (TEST,),
    }
    return Mission(**(settings | options))


def run(mission, sensor, *, seed=0, controller=None, **options):
    navigator = thesis_robot(mission, sensor, controller)
    return run_mission(mission, sensor, navigator, ROBOT, np.random.default_rng(seed), **options)


def campaign(mission, sensor, **options):
    return run_missions(mission, sensor, thesis_robot(mission, sensor), ROBOT, **options)


def same(one, other):
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
        for name in ("time_s", "poses", "rss_w", "arrival_times_s", "arrival_points_m", "targets")
    ) and (one.modes, one.outcome) == (other.modes, other.outcome)


class SilentLink:
    def rss_w(self, poses):
        return np.zeros((len(poses), 8))


def test_noise_free_thesis_mission_visits_the_tags_in_order(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(mission, sensor)
    assert result.outcome == "completed"
    assert (np.diff(result.arrival_times_s) > 0).all()
    assert (np.diff(result.targets) >= 0).all()
    away = np.linalg.norm(result.arrival_points_m - mission.tag_points_m, axis=1)
    assert (away <= 0.2).all()
    assert (away > 0.05).all()


def test_first_period_rotates_from_90_degrees_and_the_robot_then_heads_for_14(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(mission, sensor)
    heading = np.degrees(result.poses[:, 2])
    assert heading[0] == pytest.approx(90.0)
    assert heading[1] == pytest.approx(0.0, abs=1e-9)  # antenna 1 is the strongest
    assert heading[12] == pytest.approx(np.degrees(np.arctan2(0.5, 2.0)), abs=2.0)


def test_every_leg_begins_with_one_rotation_and_the_run_ends_stopped(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(mission, sensor)
    rotations = [k for k, mode in enumerate(result.modes) if mode == "rotation"]
    legs = np.searchsorted(result.targets, np.arange(4))
    assert rotations == legs.tolist()
    assert result.modes[-1] == "stopped"
    assert set(result.modes[:-1]) == {"rotation", "navigation"}


def test_every_row_is_one_step_of_the_kinematic_model(thesis_setup):
    mission, sensor = thesis_setup(noise_db=1.0)
    result = run(mission, sensor)
    assert result.time_s == pytest.approx(np.arange(len(result.time_s)))
    moves = np.diff(result.poses[:, :2], axis=0)
    heading = result.poses[:-1, 2]
    sideways = -moves[:, 0] * np.sin(heading) + moves[:, 1] * np.cos(heading)
    assert np.abs(sideways).max() < 1e-12  # Euler: along the old heading
    rolled = np.linalg.norm(moves, axis=1)
    driving = np.array(result.modes[:-1]) == "navigation"
    assert rolled[driving] == pytest.approx(np.full(driving.sum(), 0.09))
    assert rolled[~driving] == pytest.approx(np.zeros((~driving).sum()))


def test_logged_rss_is_what_the_sensor_gives_for_the_logged_pose_and_target(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(mission, sensor)
    for k in (0, 30, 60, len(result.time_s) - 1):
        tag_id = mission.tag_ids[result.targets[k]]
        again = sensor.read(result.poses[k], tag_id, np.random.default_rng(0))
        assert result.rss_w[k] == pytest.approx(again, rel=1e-12)


def test_exact_arcs_lead_to_the_tags_too(thesis_setup):
    mission, sensor = thesis_setup()
    euler = run(mission, sensor)
    arc = run(replace(mission, motion="arc"), sensor)
    assert arc.outcome == "completed"
    assert np.abs(arc.poses[5] - euler.poses[5]).max() > 1e-4


@pytest.mark.parametrize("antennas", [4, 6, 12])
def test_other_numbers_of_antennas_reach_the_tags(thesis_setup, antennas):
    mission, sensor = thesis_setup(antennas=antennas, noise_db=1.0)
    result = run(mission, sensor)
    assert measure(result).success
    assert result.rss_w.shape[1] == antennas


@pytest.mark.parametrize("antennas", [3, 5])
def test_odd_numbers_of_antennas_reach_the_tags_on_a_spiral(thesis_setup, antennas):
    mission, sensor = thesis_setup(antennas=antennas)
    assert measure(run(mission, sensor)).success


def test_a_robot_that_starts_under_its_first_tag_still_visits_all(thesis_setup):
    mission, sensor = thesis_setup(noise_db=1.0)
    under = replace(mission, start_m=(1.9, 0.5))
    for controller in (FuzzyController(), VectorSumController()):
        assert measure(run(under, sensor, controller=controller)).success


def test_no_signal_is_a_result_with_its_reason():
    sensor = FieldSensor(links={"a": SilentLink()}, azimuths_rad=np.arange(8) * np.pi / 4)
    result = run(simple(), sensor)
    assert result.outcome == "no signal"
    assert "no antenna received tag a in 5 readings" in result.reason
    assert result.time_s[-1] == 4.0
    assert (result.poses == result.poses[0]).all()
    assert np.isnan(result.arrival_times_s).all()


def test_time_out_is_a_result_with_its_reason(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(replace(mission, max_time_s=30.0), sensor)
    assert result.outcome == "time-out"
    assert "0xFFF2 was not reached within 30 s" in result.reason
    assert result.time_s[-1] == 30.0
    assert np.isfinite(result.arrival_times_s).tolist() == [True, False, False, False]


def test_default_time_out_is_four_times_the_way_and_a_minute():
    mission = simple(cruise_step_m=0.1, sample_time_s=2.0)
    assert mission.time_limit_s == pytest.approx(60 + 4 * 1.0 / 0.05)


def test_collision_ends_the_run_at_the_last_free_point(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(mission, sensor, blocked=lambda points: points[:, 0] > 1.0)
    assert result.outcome == "collision"
    assert "0xFFF9" in result.reason
    assert result.modes[-1] == "stopped"
    assert 0.99 <= result.poses[-1, 0] <= 1.0
    assert measure(result).collided


def test_a_robot_that_leaves_the_room_ends_its_run_where_nothing_is_read_any_more(thesis_setup):
    mission, sensor = thesis_setup()

    class Inside:
        antennas, azimuths_rad, tag_ids = sensor.antennas, sensor.azimuths_rad, sensor.tag_ids

        def read(self, pose, tag_id, rng, *, motion=AT_REST):
            assert pose[0] <= 1.0, "the field is known in the room only"
            return sensor.read(pose, tag_id, rng, motion=motion)

    result = run(mission, Inside(), outside=lambda points: points[:, 0] > 1.0)
    assert result.outcome == "left the room"
    assert "0xFFF9" in result.reason
    assert result.modes[-1] == "stopped"
    assert result.poses[-1, 0] > 1.0
    assert not result.rss_w[-1].any()
    assert np.diff(result.time_s) == pytest.approx(mission.sample_time_s)
    metrics = measure(result)
    assert not any((metrics.success, metrics.collided, metrics.captured))
    with pytest.raises(NavigationError, match="outside the room"):
        run(mission, sensor, outside=lambda points: points[:, 0] < 1.0)


def test_a_thin_wall_inside_one_step_is_not_jumped_over(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(mission, sensor, blocked=lambda p: np.abs(p[:, 0] - 1.005) < 0.006)
    assert result.outcome == "collision"
    assert result.poses[:, 0].max() <= 1.0


def test_a_start_inside_an_obstacle_is_refused(thesis_setup):
    mission, sensor = thesis_setup()
    with pytest.raises(NavigationError, match="inside an obstacle"):
        run(mission, sensor, blocked=lambda points: points[:, 0] < 1.0)


def test_unknown_tags_and_too_fast_missions_are_refused(thesis_setup):
    mission, sensor = thesis_setup()
    with pytest.raises(NavigationError, match=r"'0xFFF3' is unknown.*did you mean"):
        run(replace(mission, tag_ids=("0xFFF3", *mission.tag_ids[1:])), sensor)
    with pytest.raises(NavigationError, match=r"cruise speed is 0\.9 m/s"):
        run(replace(mission, sample_time_s=0.1), sensor)


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"sample_time_s": 0.0}, "sample_time_s is 0.0 s"),
        ({"sample_time_s": -1.0}, "sample_time_s is -1.0 s"),
        ({"cruise_step_m": float("nan")}, "cruise_step_m is nan"),
        ({"max_time_s": 0.0}, "max_time_s is 0.0 s"),
        ({"silent_limit": 0}, "silent_limit is 0"),
        ({"heading_rad": float("inf")}, "heading_rad is inf"),
        ({"contact": "jump"}, "contact is 'jump'"),
        ({"contact_limit": 0}, "contact_limit is 0"),
        ({"motion": "jump"}, "motion is 'jump'"),
        ({"arrivals": ()}, "1 tags and 0 arrival tests"),
        ({"tag_points_m": [(0.0, 0.0)]}, "the way stands still"),
        ({"tag_points_m": [(0.0, 0.0), (1.0, 1.0)]}, "shape"),
        ({"start_m": (0.0, float("nan"))}, "start_m holds NaN"),
    ],
)
def test_missions_that_cannot_be_are_refused(option, words):
    with pytest.raises(NavigationError) as caught:
        simple(**option)
    assert words in str(caught.value)


def test_an_arrival_radius_that_a_step_can_jump_over_is_doubted():
    with pytest.warns(PhysicsWarning, match="may orbit"):
        simple(cruise_step_m=0.3)


def test_missions_and_results_cannot_be_changed(thesis_setup):
    mission, sensor = thesis_setup()
    result = run(replace(mission, max_time_s=5.0), sensor)
    for array in (mission.start_m, mission.tag_points_m, result.poses, result.rss_w):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_runs_differ_from_each_other_and_repeat_with_the_seed(thesis_setup):
    mission, sensor = thesis_setup(noise_db=1.0)
    short = replace(mission, max_time_s=20.0)
    first = campaign(short, sensor, runs=3, seed=7)
    again = campaign(short, sensor, runs=2, seed=7)
    other = campaign(short, sensor, runs=2, seed=8)
    assert all(same(a, b) for a, b in zip(again, first[:2], strict=True))
    assert not same(first[0], first[1])
    assert not same(first[0], other[0])


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_do_not_depend_on_the_number_of_workers(thesis_setup, workers):
    mission, sensor = thesis_setup(noise_db=1.0)
    short = replace(mission, max_time_s=15.0)
    alone = campaign(short, sensor, runs=7, seed=1)
    finished = []
    with ThreadPoolExecutor(workers) as pool:
        shared = campaign(short, sensor, runs=7, seed=1, mapper=pool.map, progress=finished.append)
    assert all(same(a, b) for a, b in zip(alone, shared, strict=True))
    assert finished == list(range(1, 8))


@pytest.mark.slow
def test_results_from_other_processes_are_the_same_bits(tmp_path, monkeypatch):
    # A worker process imports what it unpickles, so the link has to live in a module it can find.
    (tmp_path / "octant_test_link.py").write_text(
        textwrap.dedent(
            """
            import numpy as np

            class Link:
                def rss_w(self, poses):
                    away = np.arctan2(-poses[:, 1], 1.0 - poses[:, 0]) - poses[:, 2] + np.pi / 2
                    distance = np.hypot(poses[:, 1], 1.0 - poses[:, 0])
                    sector = np.cos((away[:, None] - np.arange(8) * np.pi / 4) / 2) ** 8
                    return 1e-6 * distance[:, None] ** 4 * sector
            """
        )
    )
    monkeypatch.syspath_prepend(tmp_path)
    from octant_test_link import Link

    try:
        azimuths = np.arange(8) * np.pi / 4
        sensor = FieldSensor(links={"a": Link()}, azimuths_rad=azimuths, noise_db=1.0)
        mission = simple(arrivals=(ArrivalTest(threshold_w=1e-6 * 0.2**4),), max_time_s=20.0)
        alone = campaign(mission, sensor, runs=3, seed=2)
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            shared = campaign(mission, sensor, runs=3, seed=2, mapper=pool.map)
    finally:
        sys.modules.pop("octant_test_link", None)
    assert all(same(a, b) for a, b in zip(alone, shared, strict=True))
    assert {result.outcome for result in alone} == {"completed"}
    assert not any(result.poses.flags.writeable for result in shared)
    assert all(result.mission is mission for result in shared)


def test_interrupts_pass_through(thesis_setup):
    mission, sensor = thesis_setup()

    def interrupt(_finished):
        raise KeyboardInterrupt

    short = replace(mission, max_time_s=3.0)
    with ThreadPoolExecutor(1) as pool:
        for mapper in (map, pool.map):
            with pytest.raises(KeyboardInterrupt):
                campaign(short, sensor, runs=20, seed=0, mapper=mapper, progress=interrupt)


def test_campaigns_that_cannot_be_are_refused(thesis_setup):
    for option in ({"runs": 0}, {"seed": -1}):
        with pytest.raises(NavigationError, match="correct the one"):
            campaign(*thesis_setup(), **({"runs": 1, "seed": 0} | option))
