import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene
from octant.navigation.robot.collisions import RobotSpace, footprint


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


def test_free_space_has_no_obstacles():
    robot = footprint(free_space_scene(), radius_m=0.2, height_m=0.8)
    assert np.isinf(robot.clearance_m([[0.0, 0.0]]))[0]


def test_a_robot_without_size_is_refused(scene):
    with pytest.raises(NavigationError, match="radius_m"):
        footprint(scene, radius_m=0.0, height_m=0.5)
    with pytest.raises(NavigationError, match="height_m"):
        footprint(scene, radius_m=0.1, height_m=-1.0)
