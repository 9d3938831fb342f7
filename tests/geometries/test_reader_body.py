"""The reader's body: symmetric, of the areas asked for, and conforming where sheets meet."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries.errors import GeometryError
from octant.geometries.reader_body import (
    fitted_monopole_plane_m,
    ground_plane_outline_m,
    reader_body,
)

SHAPES = ["square", "round", "octagon"]


def triangles(reader):
    return reader.body.triangles_m


def ground(reader):
    corners = triangles(reader)
    return corners[(corners[:, :, 2] == 0.0).all(axis=1)]


def plates(reader):
    corners = triangles(reader)
    return corners[(corners[:, :, 2] > 0.0).any(axis=1)]


def area(corners):
    a, b, c = np.moveaxis(corners, 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def sides_of_edges(reader):
    """Number of triangles at each edge of the body's own mesh, without joining anything."""
    faces = reader.body.faces
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return {tuple(e): int(n) for e, n in zip(unique.tolist(), count, strict=True)}


def test_the_thesis_reader():
    reader = reader_body()
    assert reader.antennas == 8
    assert (reader.antenna_radius_m, reader.plate_height_m) == (0.10, 0.08)
    assert (reader.plate_height_axis_m, reader.plate_outer_radius_m) == (0.08, 0.10)
    assert area(ground(reader)) == pytest.approx(0.2**2)
    assert area(plates(reader)) == pytest.approx(8 * 0.10 * 0.08)
    np.testing.assert_allclose(reader.body.bounds_m, [(-0.1, -0.1, 0), (0.1, 0.1, 0.08)])
    assert reader.body.material == "pec"


def test_antenna_three_is_the_front_and_the_plates_stand_half_way():
    reader = reader_body()
    np.testing.assert_allclose(np.degrees(reader.element_azimuths_rad), 45.0 * np.arange(8))
    np.testing.assert_allclose(np.degrees(reader.plate_azimuths_rad), 22.5 + 45.0 * np.arange(8))
    np.testing.assert_allclose(reader.element_feet_m[0], (0.1, 0, 0))
    np.testing.assert_allclose(reader.element_feet_m[2], (0, 0.1, 0), atol=1e-17)


@pytest.mark.parametrize("shape", SHAPES)
@given(
    n=st.integers(3, 17),
    radius=st.floats(0.02, 0.0999),
    reach=st.floats(0.01, 0.0999),
    heights=st.tuples(st.floats(0.0, 0.2), st.floats(0.0, 0.2)),
    falls=st.lists(st.floats(0.3, 1.0), max_size=3),
)
def test_areas_are_those_of_elementary_geometry(shape, n, radius, reach, heights, falls):
    if shape == "round":  # the inscribed polygon's apothem is a little short of the radius
        radius, reach = 0.99 * radius, 0.99 * reach
    rim, axis = (h if h > 1e-3 else 0.0 for h in heights)
    profile = []
    if min(rim, axis) > 0.0 and falls:  # inner heights that fall from axis to rim, or do not
        profile = [max(axis, rim) * fall for fall in sorted(falls, reverse=True)]
        rim = min(rim, profile[-1])
    reader = reader_body(
        antennas=n,
        antenna_radius_m=radius,
        plate_outer_radius_m=reach,
        plate_height_m=rim,
        plate_height_axis_m=axis,
        plate_profile_m=profile,
        ground_plane_shape=shape,
    )
    step = 2 * n
    sides = step * math.ceil(32 / step)
    expected = {
        "square": 0.04,
        "octagon": 8 * 0.01 * math.tan(math.pi / 8),
        "round": 0.5 * sides * 0.01 * math.sin(2 * math.pi / sides),
    }[shape]
    assert area(ground(reader)) == pytest.approx(expected, rel=1e-9)
    mean = (0.5 * (rim + axis) + sum(profile)) / (len(profile) + 1)
    assert area(plates(reader)) == pytest.approx(n * reach * mean, rel=1e-9)
    a, b, c = np.moveaxis(ground(reader), 1, 0)
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()  # up, and no triangle without area
    assert reader.has_plates == (max(rim, axis) > 0.0)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("n", [3, 4, 7, 8])
@pytest.mark.parametrize("reach", [0.06, 0.0951])
def test_sheets_share_their_vertices_where_they_meet(shape, n, reach):
    reader = reader_body(
        antennas=n, antenna_radius_m=0.05, plate_outer_radius_m=reach, ground_plane_shape=shape
    )
    vertices = reader.body.vertices_m
    sides = sides_of_edges(reader)
    places = np.unique(np.round(vertices, 12), axis=0)
    assert len(places) == len(vertices)  # nothing meets without being the same vertex
    shared = [(vertices[list(edge)], count) for edge, count in sides.items() if count > 2]
    feet = [(ends, count) for ends, count in shared if (ends[:, 2] == 0.0).all()]
    assert len(feet) == n
    for ends, count in feet:
        assert count == 3  # two triangles of the ground plane and one of a plate
        assert sorted(np.linalg.norm(ends, axis=1)) == pytest.approx([0.0, reach])
    ((axis, count),) = [(ends, count) for ends, count in shared if ends[:, 2].max() > 0.0]
    assert count == n  # every plate
    np.testing.assert_array_equal(axis[:, :2], 0.0)
    np.testing.assert_array_equal(np.sort(axis[:, 2]), (0.0, 0.08))
    for foot in reader.element_feet_m:
        assert np.linalg.norm(vertices - foot, axis=1).min() < 1e-12


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", [{}, {"plate_height_m": 0.0}, {"plate_outer_radius_m": 0.07}])
def test_the_border_is_the_rim_and_the_plates_free_edges(shape, kind):
    reader = reader_body(ground_plane_shape=shape, antenna_radius_m=0.09, **kind)
    vertices = reader.body.vertices_m
    border = np.array([e for e, n in sides_of_edges(reader).items() if n == 1])
    length = np.linalg.norm(vertices[border[:, 0]] - vertices[border[:, 1]], axis=1).sum()
    rim = ground_plane_outline_m(0.2, shape=shape, antennas=8)
    around = np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).sum()
    of_plates = 8 * (reader.plate_outer_radius_m + 0.08) if reader.has_plates else 0.0
    assert length == pytest.approx(around + of_plates)


@pytest.mark.parametrize("n", [3, 5, 8, 12])
def test_a_round_reader_is_the_same_after_a_turn_to_the_next_antenna(n):
    reader = reader_body(antennas=n, ground_plane_shape="round", antenna_radius_m=0.1)
    turn = 2 * math.pi / n
    rotation = np.array(
        [[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]]
    )
    rim = ground_plane_outline_m(0.2, shape="round", antennas=n)
    assert len(rim) >= 32
    for points in (np.column_stack((rim, 0 * rim[:, 0])), plates(reader).reshape(-1, 3)):
        turned = points @ rotation.T
        distance = np.linalg.norm(turned[:, None, :] - points[None, :, :], axis=2)
        assert distance.min(axis=1).max() < 1e-15


def test_a_round_plane_of_a_32_gon_has_99_4_percent_of_the_circle():
    assert area(ground(reader_body(ground_plane_shape="round"))) == pytest.approx(
        0.994 * math.pi * 0.01, rel=5e-4
    )


def test_octagon_flats_face_the_antennas():
    rim = ground_plane_outline_m(0.2, shape="octagon", antennas=8)
    middles = 0.5 * (rim + np.roll(rim, -1, axis=0))
    np.testing.assert_allclose(np.linalg.norm(middles, axis=1), 0.1)
    eighths = np.degrees(np.arctan2(middles[:, 1], middles[:, 0])) / 45.0
    np.testing.assert_allclose(np.sort(np.round(eighths) % 8), np.arange(8))
    np.testing.assert_allclose(eighths, np.round(eighths), atol=1e-9)


@pytest.mark.parametrize(
    ("asked", "radius", "fits"),
    [
        (0.04, 0.10, 0.04),
        (0.04, 0.05, 0.02729),  # 2 * (50 sin 22.5 / (sin 22.5 + cos 22.5) - 1) mm, by hand
        (0.02, 0.05, 0.02),
        (0.0, 0.05, 0.0),
    ],
)
def test_a_monopole_plane_shrinks_where_it_would_cut_a_plate(asked, radius, fits):
    reader = reader_body(antenna_radius_m=radius, monopole_plane_m=asked)
    assert reader.fitted_monopole_plane_m == pytest.approx(fits, abs=1e-5)
    assert reader.monopole_plane_m == asked


@given(st.integers(3, 24), st.floats(0.02, 0.5), st.floats(0.0, 0.002))
def test_the_largest_monopole_plane_touches_the_plates_when_grown_by_its_margin(n, radius, margin):
    """Sampled, not derived: no point of the plate comes nearer, and one comes as near."""
    try:
        side = fitted_monopole_plane_m(10.0, antenna_radius_m=radius, antennas=n, margin_m=margin)
    except GeometryError:
        return
    along = np.linspace(0.0, 3.0 * radius, 200_001)
    u, v = along * math.cos(math.pi / n), along * math.sin(math.pi / n)
    nearest = np.maximum(np.abs(u - radius), np.abs(v)).min()
    assert nearest == pytest.approx(0.5 * side + margin, abs=3e-5 * radius)


def test_no_monopole_plane_at_all_is_an_error():
    with pytest.raises(GeometryError, match="no plane fits"):
        reader_body(antenna_radius_m=0.003, monopole_plane_m=0.04)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"antenna_radius_m": 0.11}, "antenna_radius_m is 0.11 m.*ends 0.1 m"),
        ({"antenna_radius_m": 0.0}, "antenna_radius_m is 0 m"),
        ({"antenna_radius_m": math.nan}, "antenna_radius_m is nan"),
        ({"antennas": 2}, "antennas is 2"),
        ({"antennas": 8.0}, "antennas is 8.0"),
        ({"plate_height_m": -0.01}, "plate_height_m"),
        ({"plate_height_axis_m": math.inf}, "plate_height_axis_m"),
        ({"plate_outer_radius_m": 0.12}, "plate_outer_radius_m is 0.12 m.*22.5 deg"),
        ({"plate_outer_radius_m": 0.0}, "plate_outer_radius_m"),
        ({"ground_plane_m": 0.0}, "ground_plane_m"),
        ({"ground_plane_m": 0.19}, "antenna_radius_m is 0.1 m"),
        ({"ground_plane_shape": "hexagon"}, "ground_plane_shape is 'hexagon'"),
        ({"ground_plane_shape": "round", "antenna_radius_m": 0.1001}, "antenna_radius_m"),
        ({"monopole_plane_m": -0.01}, "monopole_plane_m"),
        ({"plate_profile_m": (0.05, 0.0)}, "plate_profile_m is 0 m"),
        ({"plate_profile_m": (0.05,), "plate_height_m": 0.0}, "have no height at the axis or"),
        ({"plate_profile_m": (0.02, 0.07)}, "rises from 0.02 to 0.07 m more steeply"),
    ],
)
def test_a_reader_that_cannot_be_is_refused_in_one_sentence(changes, says):
    with pytest.raises(GeometryError, match=says) as caught:
        reader_body(**changes)
    assert "\n" not in str(caught.value)


def test_antennas_may_stand_on_the_very_edge():
    for shape in SHAPES:
        reader = reader_body(antenna_radius_m=0.1, ground_plane_shape=shape)
        assert len(reader.element_feet_m) == 8
    corner = math.hypot(0.1, 0.1)  # with 4 antennas turned into the corners there is more room
    assert reader_body(plate_outer_radius_m=corner, antennas=4).plate_outer_radius_m == corner
