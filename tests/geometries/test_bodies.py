"""A body is checked when it is made, cannot change, and is placed rigidly."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries.bodies import Body, place
from octant.geometries.errors import GeometryError

TRIANGLE = [(0, 0, 0), (3, 0, 0), (0, 4, 0)]


def make(**changes):
    given = {"name": "t", "vertices_m": TRIANGLE, "faces": [[0, 1, 2]], "material": "wood"}
    return Body(**(given | changes))


def test_area_bounds_and_triangles_of_a_3_4_5_triangle():
    body = make(vertices_m=[*TRIANGLE, (9, 9, 9)])
    assert body.area_m2 == pytest.approx(6.0)
    np.testing.assert_array_equal(body.bounds_m, [(0, 0, 0), (3, 4, 0)])  # the unused one is not
    np.testing.assert_array_equal(body.triangles_m, [TRIANGLE])


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"name": ""}, "name"),
        ({"material": " "}, "material"),
        ({"name": "two\nlines"}, "name"),
        ({"vertices_m": [(0, 0, 0), (1, 0, 0), (0, math.nan, 0)]}, "NaN"),
        ({"vertices_m": [(0, 0), (1, 0), (0, 1)]}, "shape"),
        ({"vertices_m": np.zeros((0, 3))}, "empty"),
        ({"faces": np.zeros((0, 3), dtype=int)}, "empty"),
        ({"faces": [[0, 1, 3]]}, "vertex 3"),
        ({"faces": [[0, 1, -1]]}, "vertex -1"),
        ({"faces": [[0.0, 1.0, 2.0]]}, "whole numbers"),
        ({"faces": [[0, 1]]}, "shape"),
    ],
)
def test_a_body_that_cannot_be_is_refused_in_one_sentence(changes, says):
    with pytest.raises(GeometryError, match=says) as caught:
        make(**changes)
    assert "\n" not in str(caught.value)


def test_a_body_cannot_be_changed_not_even_through_what_it_was_made_of():
    vertices = np.array(TRIANGLE, dtype=float)
    body = make(vertices_m=vertices)
    vertices[0] = 7.0
    assert body.vertices_m[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        body.vertices_m[0, 0] = 1.0
    with pytest.raises(AttributeError):
        body.name = "other"


def test_a_quarter_turn_takes_x_to_y_exactly():
    turned = place(make(), position_m=(10, 20, 30), yaw_rad=math.radians(90.0))
    np.testing.assert_array_equal(turned.vertices_m, [(10, 20, 30), (10, 23, 30), (6, 20, 30)])


@pytest.mark.parametrize("quarters", range(-5, 6))
def test_quarter_turns_are_powers_of_i(quarters):
    turned = place(make(), yaw_rad=quarters * math.pi / 2).vertices_m
    expected = np.array([p[0] + 1j * p[1] for p in TRIANGLE]) * 1j**quarters
    np.testing.assert_array_equal(turned[:, 0] + 1j * turned[:, 1], expected)


@given(
    st.tuples(*[st.floats(-50, 50)] * 3),
    st.floats(-10.0, 10.0),
)
def test_placing_keeps_heights_above_the_position_and_distances_from_it(position, yaw):
    body = make(vertices_m=[(1, 2, 3), (4, -5, 6), (-7, 8, 9.5)])
    placed = place(body, position_m=position, yaw_rad=yaw)
    relative = placed.vertices_m - position
    np.testing.assert_allclose(relative[:, 2], body.vertices_m[:, 2], atol=1e-12)
    z_before = body.vertices_m[:, 0] + 1j * body.vertices_m[:, 1]
    z_after = relative[:, 0] + 1j * relative[:, 1]
    np.testing.assert_allclose(z_after, z_before * np.exp(1j * yaw), atol=1e-12)


def test_a_place_that_is_not_finite_is_refused():
    with pytest.raises(GeometryError, match="position_m"):
        place(make(), position_m=(0, 0, math.inf))
    with pytest.raises(GeometryError, match="yaw_rad"):
        place(make(), yaw_rad=math.nan)
