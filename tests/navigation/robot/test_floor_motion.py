import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.missions.starts import ListedStarts, RandomStarts
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor_motion import Floor
from octant.navigation.robot.rolling import Rolling, RollingWheels

ROBOT = DifferentialDrive()


def rates(speed, turn=0.0):
    return ROBOT.wheel_rates(speed_m_per_s=speed, turn_rate_rad_per_s=turn)


def floor(**options):
    return Floor(robot=ROBOT, period_s=1.0, **options)


def test_a_free_step_is_the_kinematic_one():
    reached, contact = floor(blocked=lambda p: p[:, 0] > 1.0).moved(np.zeros(3), rates(0.1, 0.2))
    assert reached == pytest.approx([0.1, 0.0, 0.2])
    assert not contact


def test_without_sliding_it_stops_at_the_last_free_point():
    reached, contact = floor(blocked=lambda p: p[:, 0] > 0.055).moved(np.zeros(3), rates(0.1))
    assert contact
    assert reached == pytest.approx([0.05, 0.0, 0.0])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_slides_along_a_wall_by_what_points_along_it(side):
    pose = np.array([0.0, 0.0, side * np.radians(60.0)])
    sliding = floor(contact="slide", blocked=lambda p: p[:, 0] > 0.0105)
    reached, contact = sliding.moved(pose, rates(0.1, 0.3))
    assert contact
    assert reached[0] <= 0.0105
    # The wall runs along y, 30 degrees off the heading: cos 30 of what was left of the way.
    stop = 0.02 * np.sin(np.radians(60.0))
    along = 0.08 * np.cos(np.radians(30.0))
    assert side * reached[1] == pytest.approx(stop + along, abs=1e-9)
    assert reached[2] == pytest.approx(pose[2] + 0.3)


def test_head_on_it_stays_and_still_turns():
    sliding = floor(contact="slide", blocked=lambda p: np.hypot(*p.T) > 1e-6)
    reached, contact = sliding.moved(np.zeros(3), rates(0.1, 0.3))
    assert contact
    assert reached == pytest.approx([0.0, 0.0, 0.3])


def test_slip_has_its_standard_deviation_and_scale_stays_for_a_run():
    slipping = RollingWheels(Rolling(slip_sd=0.05), np.random.default_rng(0))
    rolled = np.array([slipping.roll(np.ones(2)) for _ in range(4000)])
    assert rolled.std() == pytest.approx(0.05, rel=0.05)
    assert rolled.mean() == pytest.approx(1.0, abs=0.003)
    scales = np.array(
        [
            [RollingWheels(Rolling(scale_sd=0.02), np.random.default_rng(s)).roll(np.ones(2))]
            for s in range(500)
        ]
    )
    assert scales.std() == pytest.approx(0.02, rel=0.1)
    same = RollingWheels(Rolling(scale_sd=0.02), np.random.default_rng(0))
    assert np.array_equal(same.roll(np.ones(2)), same.roll(np.ones(2)))


def test_encoders_count_whole_ticks_and_lose_none():
    wheels = RollingWheels(Rolling(tick_rad=0.3), np.random.default_rng(0))
    counted = np.array([wheels.count(np.array([0.1, 0.25])) for _ in range(30)])
    assert counted / 0.3 == pytest.approx(np.round(counted / 0.3))
    assert np.abs(counted.sum(axis=0) - [3.0, 7.5]).max() <= 0.3
    exact = RollingWheels(Rolling(), np.random.default_rng(0))
    assert exact.count(np.array([0.1, 0.2])) == pytest.approx([0.1, 0.2])


def test_perfect_wheels_draw_nothing():
    rng = np.random.default_rng(0)
    RollingWheels(Rolling(), rng).roll(np.ones(2))
    assert rng.random() == np.random.default_rng(0).random()
    with pytest.raises(NavigationError, match="slip_sd is -1"):
        Rolling(slip_sd=-1.0)


def test_listed_starts_are_taken_in_turn():
    starts = ListedStarts(poses=[[0.0, 0.0, 0.0], [1.0, 0.0, 0.5]])
    seeds = np.random.SeedSequence(3).spawn(4)
    assert [starts.start(seed)[0] for seed in seeds] == [0.0, 1.0, 0.0, 1.0]
    with pytest.raises(NavigationError, match="empty"):
        ListedStarts(poses=np.zeros((0, 3)))


def test_random_starts_are_free_spread_out_and_fixed_by_the_seed():
    starts = RandomStarts(low_m=(0.0, 0.0), high_m=(2.0, 1.0), fits=lambda p: p[:, 0] > 0.5)
    seeds = np.random.SeedSequence(3).spawn(400)
    drawn = np.array([starts.start(seed) for seed in seeds])
    assert drawn[:, 0].min() > 0.5
    assert drawn.mean(axis=0) == pytest.approx([1.25, 0.5, 0.0], abs=0.3)
    again = [starts.start(seed) for seed in np.random.SeedSequence(3).spawn(2)]
    assert np.array_equal(again, drawn[:2])
    nowhere = RandomStarts(
        low_m=(0.0, 0.0), high_m=(1.0, 1.0), fits=lambda p: np.zeros(len(p), dtype=bool)
    )
    with pytest.raises(NavigationError, match="found no room"):
        nowhere.start(seeds[0])
