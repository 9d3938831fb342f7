import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene
from octant.navigation.missions.starts import ListedStarts, RandomStarts
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import Floor, RobotSpace, footprint
from octant.navigation.robot.odometry import Rolling, RollingWheels

ROBOT = DifferentialDrive()


def rates(speed, turn=0.0):
    return ROBOT.wheel_rates(speed_m_per_s=speed, turn_rate_rad_per_s=turn)


def rolled(pose, wheels, **options):
    return Floor(robot=ROBOT, step="euler", **options).roll(pose, wheels, period_s=1.0)


def test_a_free_step_is_the_kinematic_one():
    reached, contact = rolled(np.zeros(3), rates(0.1, 0.2), blocked=lambda p: p[:, 0] > 1.0)
    assert reached == pytest.approx([0.1, 0.0, 0.2])
    assert not contact


def test_without_sliding_it_stops_at_the_last_free_point():
    reached, contact = rolled(np.zeros(3), rates(0.1), blocked=lambda p: p[:, 0] > 0.055)
    assert contact
    assert reached == pytest.approx([0.05, 0.0, 0.0])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_slides_along_a_wall_by_what_points_along_it(side):
    pose = np.array([0.0, 0.0, side * np.radians(60.0)])
    wall = {"contact": "slide", "blocked": lambda p: p[:, 0] > 0.0105}
    reached, contact = rolled(pose, rates(0.1, 0.3), **wall)
    assert contact
    assert reached[0] <= 0.0105
    # The wall runs along y, 30 degrees off the heading: cos 30 of what was left of the way.
    stop = 0.02 * np.sin(np.radians(60.0))
    along = 0.08 * np.cos(np.radians(30.0))
    assert side * reached[1] == pytest.approx(stop + along, abs=1e-9)
    assert reached[2] == pytest.approx(pose[2] + 0.3)


def test_head_on_it_stays_and_still_turns():
    around = {"contact": "slide", "blocked": lambda p: np.hypot(*p.T) > 1e-6}
    reached, contact = rolled(np.zeros(3), rates(0.1, 0.3), **around)
    assert contact
    assert reached == pytest.approx([0.0, 0.0, 0.3])


def test_slip_has_its_standard_deviation_and_scale_stays_for_a_run():
    slipping = RollingWheels(Rolling(slip_sd=0.05), ROBOT, np.random.default_rng(0))
    rolled = np.array([slipping.roll(np.ones(2), period_s=1.0) for _ in range(4000)])
    assert rolled.std() == pytest.approx(0.05, rel=0.05)
    assert rolled.mean() == pytest.approx(1.0, abs=0.003)
    scales = np.array(
        [
            [
                RollingWheels(Rolling(scale_sd=0.02), ROBOT, np.random.default_rng(s)).roll(
                    np.ones(2), period_s=1.0
                )
            ]
            for s in range(500)
        ]
    )
    assert scales.std() == pytest.approx(0.02, rel=0.1)
    same = RollingWheels(Rolling(scale_sd=0.02), ROBOT, np.random.default_rng(0))
    assert np.array_equal(same.roll(np.ones(2), period_s=1.0), same.roll(np.ones(2), period_s=1.0))


def test_encoders_count_whole_ticks_and_lose_none():
    wheels = RollingWheels(Rolling(tick_rad=0.3), ROBOT, np.random.default_rng(0))
    counted = np.array([wheels.count(np.array([0.1, 0.25])) for _ in range(30)])
    assert counted / 0.3 == pytest.approx(np.round(counted / 0.3))
    assert np.abs(counted.sum(axis=0) - [3.0, 7.5]).max() <= 0.3
    exact = RollingWheels(Rolling(), ROBOT, np.random.default_rng(0))
    assert exact.count(np.array([0.1, 0.2])) == pytest.approx([0.1, 0.2])


def test_perfect_wheels_draw_nothing():
    rng = np.random.default_rng(0)
    RollingWheels(Rolling(), ROBOT, rng).roll(np.ones(2), period_s=1.0)
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


@pytest.fixture(scope="module")
def scene():
    block = box((1.0, 1.0, 0.5), position_m=(2.0, 2.0, 0.0), material="metal")
    shelf = box((1.0, 1.0, 0.2), position_m=(0.5, 0.5, 1.0), material="metal")
    return build_scene(box_room((5.0, 5.0, 3.0)), objects=[block, shelf])


def test_the_robot_touches_walls_and_low_objects_at_its_radius(scene):
    robot = footprint(scene, radius_m=0.2, height_m=0.8)
    points = np.array([[0.201, 2.5], [0.199, 2.5], [1.799, 2.5], [1.801, 2.5], [1.85, 1.85]])
    np.testing.assert_array_equal(robot(points), [False, True, False, True, False])
    corner = np.array([[2.0 - 0.2 / np.sqrt(2) + d] * 2 for d in (-1e-6, 1e-6)])
    np.testing.assert_array_equal(robot(corner), [False, True])


def test_it_passes_below_what_hangs_higher_than_itself(scene):
    under = np.array([[1.0, 0.5]])
    assert not footprint(scene, radius_m=0.2, height_m=0.8)(under)[0]
    assert footprint(scene, radius_m=0.2, height_m=1.1)(under)[0]


def test_it_cannot_stand_inside_an_object_or_outside_the_room(scene):
    robot = footprint(scene, radius_m=0.2, height_m=0.4)
    space = RobotSpace(footprint=robot, scene=scene, height_m=0.4)
    points = np.array([[2.5, 2.5], [7.0, 7.0], [4.0, 4.0]])
    np.testing.assert_array_equal(space(points), [False, False, True])
    np.testing.assert_array_equal(space.outside(points), [False, True, False])


def test_free_space_has_no_obstacles():
    robot = footprint(free_space_scene(), radius_m=0.2, height_m=0.8)
    assert np.isinf(robot.clearance_m([[0.0, 0.0]]))[0]


def test_a_robot_without_size_is_refused(scene):
    with pytest.raises(NavigationError, match="radius_m"):
        footprint(scene, radius_m=0.0, height_m=0.5)
    with pytest.raises(NavigationError, match="height_m"):
        footprint(scene, radius_m=0.1, height_m=-1.0)
