"""Ways on a floor plan: their length against geometry, and that they never touch."""

import math

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.navigators.ways import floor_plan, occupancy

LOW, HIGH = (0.0, 0.0), (4.0, 3.0)


def wall(points):
    """A wall at x = 2 from y = 0 to 2.5, 0.2 m thick."""
    x, y = np.asarray(points).T
    return (np.abs(x - 2.0) < 0.1) & (y < 2.5)


def inside_wall(place):
    """Whether a place is in the wall by more than half a square of the occupancy grid."""
    x, y = place
    return abs(x - 2.0) < 0.0875 and y < 2.4875


def driven(plan, start, goal, step=0.05):
    place, length = np.array(start), 0.0
    for _ in range(500):
        point = plan.towards(place, goal)
        left = math.dist(place, point)
        if left < 1e-9:
            break
        move = min(step, left)
        place = place + (point - place) * move / left
        length += move
        assert not inside_wall(place)
    return place, length


def test_without_anything_in_the_way_it_is_straight():
    plan = floor_plan(LOW, HIGH, [(3.55, 2.22)], blocked=None)
    assert plan.towards(np.array([0.3, 0.4]), 0) == pytest.approx([3.55, 2.22])


def test_round_a_wall_it_is_hardly_longer_than_the_shortest():
    plan = floor_plan(LOW, HIGH, [(3.0, 0.5)], blocked=wall, margin_m=0.05)
    place, length = driven(plan, (1.0, 0.5), 0)
    corner = math.dist((1.0, 0.5), (1.9, 2.5))
    assert place == pytest.approx([3.0, 0.5])
    assert 2.0 * corner + 0.2 <= length < 1.1 * (2.0 * corner + 0.2)


def test_a_goal_on_a_shelf_ends_on_the_nearest_free_floor():
    plan = floor_plan(LOW, HIGH, [(2.0, 1.0)], blocked=wall)
    assert not wall(plan.ends_m)[0]
    assert math.dist(plan.ends_m[0], (2.0, 1.0)) < 0.21


def test_where_there_is_no_way_the_length_is_infinite():
    plan = floor_plan(LOW, HIGH, [(3.0, 0.5)], blocked=lambda p: np.abs(p[:, 0] - 2.0) < 0.1)
    assert plan.length_m(np.array([1.0, 1.0]), 0) == math.inf
    with pytest.raises(NavigationError, match="nowhere"):
        floor_plan(LOW, HIGH, [(3.0, 0.5)], blocked=lambda p: np.ones(len(p), bool))


def test_an_occupancy_grid_says_what_it_was_made_from():
    grid = occupancy(LOW, HIGH, lambda p: ~wall(p), step_m=0.02)
    points = np.random.default_rng(0).uniform(LOW, HIGH, (500, 2))
    clear = np.abs(np.abs(points[:, 0] - 2.0) - 0.1) > 0.02
    clear &= np.abs(points[:, 1] - 2.5) > 0.02
    assert (grid(points) == wall(points))[clear].all()
    assert grid(np.array([[-1.0, 1.0]])).all()


def test_with_a_margin_the_straight_way_keeps_off_a_corner_but_leads_out_of_a_narrow_place():
    plan = floor_plan(LOW, HIGH, [(3.0, 0.5)], blocked=wall)
    over_the_corner = np.array([1.6, 2.4]), np.array([2.4, 2.72])
    assert plan.sees(*over_the_corner)
    assert not plan.sees(*over_the_corner, margin_m=0.1)
    beside, off, along = np.array([1.87, 1.5]), np.array([1.5, 1.5]), np.array([1.87, 0.5])
    assert plan.sees(beside, off, margin_m=0.2)
    assert plan.sees(beside, along)
    assert not plan.sees(beside, along, margin_m=0.2)


def least_clearance(margin_m):
    """How near the way round the wall comes to it, over the part beside its end."""
    plan = floor_plan(LOW, HIGH, [(3.0, 0.5)], blocked=wall)
    place, least = np.array([1.0, 0.5]), math.inf
    for _ in range(500):
        point = plan.towards(place, 0, margin_m=margin_m)
        left = math.dist(place, point)
        if left < 1e-9:
            return least
        place = place + (point - place) * min(0.05, left) / left
        least = min(least, plan.clearance_m(place))
    raise AssertionError


def test_a_margin_keeps_the_way_off_walls_by_as_much():
    assert least_clearance(0.0) < 0.03
    assert least_clearance(0.1) > 0.07
