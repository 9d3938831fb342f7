"""Rooms are closed, face inwards, and have the areas and volumes of elementary geometry."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rooms import l_shaped_room

from octant.geometries.errors import GeometryError
from octant.geometries.rooms import Doorway, box_room, prism_room

DOOR = Doorway(wall=1, offset_m=1.0, width_m=0.9, height_m=2.0)


def by_name(bodies):
    return {body.name: body for body in bodies}


def signed_volume_m3(bodies):
    """Divergence theorem over all bodies; negative when the normals point inwards."""
    corners = np.concatenate([body.triangles_m for body in bodies])
    return float(np.linalg.det(corners).sum() / 6.0)


def euler_number(bodies):
    corners = np.concatenate([body.triangles_m for body in bodies]).reshape(-1, 3)
    places, index = np.unique(np.round(corners, 9), axis=0, return_inverse=True)
    faces = index.reshape(-1, 3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, sides = np.unique(edges, axis=0, return_counts=True)
    return len(places) - len(unique) + len(faces), sides


def normals(body):
    a, b, c = np.moveaxis(body.triangles_m, 1, 0)
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def test_a_box_room_has_three_bodies_with_the_areas_of_a_box():
    room = by_name(box_room((5.0, 4.0, 3.0), origin_m=(-1.0, 2.0, 0.5)))
    assert list(room) == ["walls", "floor", "ceiling"]
    assert room["walls"].area_m2 == pytest.approx(2 * (5 + 4) * 3)
    assert room["floor"].area_m2 == room["ceiling"].area_m2 == pytest.approx(20.0)
    np.testing.assert_array_equal(room["walls"].bounds_m, [(-1, 2, 0.5), (4, 6, 3.5)])
    np.testing.assert_array_equal(room["floor"].bounds_m[:, 2], [0.5, 0.5])
    np.testing.assert_array_equal(room["ceiling"].bounds_m[:, 2], [3.5, 3.5])


def test_a_box_room_faces_inwards_everywhere():
    centre = np.array([2.5, 2.0, 1.5])
    for body in box_room((5.0, 4.0, 3.0)):
        towards = centre - body.triangles_m.mean(axis=1)
        assert ((normals(body) * towards).sum(axis=1) > 0.0).all()


@given(
    st.tuples(*[st.floats(0.5, 20.0)] * 3),
    st.tuples(*[st.floats(0.1, 0.9)] * 2),
)
def test_an_l_shaped_room_encloses_the_box_less_the_notch(size, share):
    notch = (size[0] * share[0], size[1] * share[1])
    room = l_shaped_room(size, notch)
    floor = size[0] * size[1] - notch[0] * notch[1]
    assert signed_volume_m3(room) == pytest.approx(-floor * size[2], rel=1e-9)
    assert by_name(room)["floor"].area_m2 == pytest.approx(floor, rel=1e-9)
    assert by_name(room)["walls"].area_m2 == pytest.approx(2 * (size[0] + size[1]) * size[2])


@pytest.mark.parametrize("reverse", [False, True])
def test_a_room_over_any_outline_is_a_sphere_to_a_topologist(reverse):
    outline = [(0, 0), (6, 0), (6, 1), (2, 1), (2, 2), (6, 2), (6, 5), (4, 5), (3, 3.5), (0, 4)]
    room = prism_room(outline[::-1] if reverse else outline, 2.5, origin_m=(10, -20, 1))
    number, sides = euler_number(room)
    assert number == 2
    assert (sides == 2).all()
    x, y = np.array(outline, dtype=float).T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert signed_volume_m3(room) == pytest.approx(-2.5 * area)


def test_a_doorway_takes_its_area_from_its_wall_and_nothing_else():
    closed, opened = box_room((5, 4, 3)), box_room((5, 4, 3), doorways=[DOOR])
    assert by_name(closed)["walls"].area_m2 - by_name(opened)["walls"].area_m2 == pytest.approx(1.8)
    for part in ("floor", "ceiling"):
        assert by_name(opened)[part].area_m2 == pytest.approx(20.0)


def test_the_border_of_a_doorway_is_its_frame_and_its_threshold():
    room = box_room((5, 4, 3), doorways=[DOOR])
    corners = np.concatenate([body.triangles_m for body in room])
    places, index = np.unique(np.round(corners.reshape(-1, 3), 9), axis=0, return_inverse=True)
    faces = index.reshape(-1, 3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, sides = np.unique(edges, axis=0, return_counts=True)
    border = places[unique[sides == 1]]
    # Wall 1 stands at x = 5 and runs from y = 0: the opening spans y = 1 ... 1.9.
    assert (border[..., 0] == 5.0).all()
    assert np.linalg.norm(border[:, 1] - border[:, 0], axis=1).sum() == pytest.approx(
        2 * 2.0 + 2 * 0.9
    )
    assert border[..., 1].min() == pytest.approx(1.0)
    assert border[..., 1].max() == pytest.approx(1.9)
    assert border[..., 2].max() == pytest.approx(2.0)


def test_two_doorways_in_one_wall_and_one_in_a_slanted_wall():
    doors = [
        Doorway(wall=0, offset_m=3.0, width_m=1.0, height_m=2.0),
        Doorway(wall=0, offset_m=0.5, width_m=0.8, height_m=2.1),
        Doorway(wall=1, offset_m=1.0, width_m=0.7, height_m=1.9),
    ]
    outline = [(0, 0), (6, 0), (3, 4)]
    walls = by_name(prism_room(outline, 2.5, doorways=doors))["walls"]
    lost = 1.0 * 2.0 + 0.8 * 2.1 + 0.7 * 1.9
    assert walls.area_m2 == pytest.approx((6 + 5 + 5) * 2.5 - lost)


def test_each_part_has_its_own_material():
    room = box_room((5, 4, 3), material="brick", materials={"floor": "wood"})
    assert [b.material for b in room] == ["brick", "wood", "brick"]


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: box_room((5, 4, 0)), "in z is 0 m"),
        (lambda: box_room((5, -4, 3)), "in y is -4 m"),
        (lambda: box_room((5, math.inf, 3)), "infinite"),
        (lambda: box_room((5, 4)), "shape"),
        (lambda: box_room((5, 4, 3), materials={"flor": "wood"}), "did you mean 'floor'"),
        (lambda: box_room((5, 4, 3), origin_m=(0, 0)), "origin_m"),
        (lambda: prism_room([(0, 0), (2, 2), (2, 0), (0, 2)], 3), "meets side"),
        (lambda: prism_room([(0, 0), (2, 2), (2, 0)], math.nan), "height_m"),
        (
            lambda: box_room(
                (5, 4, 3), doorways=[Doorway(wall=4, offset_m=1, width_m=1, height_m=2)]
            ),
            "wall 4",
        ),
        (
            lambda: box_room(
                (5, 4, 3), doorways=[Doorway(wall=1, offset_m=3.5, width_m=1, height_m=2)]
            ),
            "does not fit",
        ),
        (
            lambda: box_room(
                (5, 4, 3), doorways=[Doorway(wall=1, offset_m=1, width_m=1, height_m=3)]
            ),
            "does not fit",
        ),
        (lambda: box_room((5, 4, 3), doorways=[DOOR, DOOR]), "does not fit"),
        (lambda: Doorway(wall=-1, offset_m=1, width_m=1, height_m=2), "wall"),
        (lambda: Doorway(wall=0, offset_m=0, width_m=1, height_m=2), "offset_m"),
    ],
)
def test_a_room_that_cannot_be_is_refused_in_one_sentence(call, says):
    with pytest.raises(GeometryError, match=says) as caught:
        call()
    assert "\n" not in str(caught.value)
