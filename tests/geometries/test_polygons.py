"""Ear clipping fills exactly the polygon, and crossed outlines are refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries._polygons import (
    check_simple,
    mesh_of_triangles,
    signed_area_m2,
    triangulate_polygon,
    triangulate_polygon_3d,
)
from octant.geometries.errors import GeometryError


def triangle_areas(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def covered_times(points, triangles, probes):
    """How many triangles hold each probe strictly inside."""
    count = np.zeros(len(probes), dtype=int)
    for tri in points[triangles]:
        sides = [
            (b[0] - a[0]) * (probes[:, 1] - a[1]) - (b[1] - a[1]) * (probes[:, 0] - a[0])
            for a, b in zip(tri, np.roll(tri, -1, axis=0), strict=True)
        ]
        count += (np.min(sides, axis=0) > 0.0).astype(int)
    return count


@st.composite
def star_outlines(draw):
    """Any polygon that is seen whole from its centre is simple, however jagged."""
    radii = draw(st.lists(st.floats(0.1, 3.0), min_size=3, max_size=24))
    angle = 2.0 * math.pi * np.arange(len(radii)) / len(radii)
    points = np.array(radii)[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    if draw(st.booleans()):
        points = points[::-1]
    return points + draw(st.floats(-100.0, 100.0))


@given(star_outlines())
def test_triangles_fill_the_polygon_once(points):
    triangles = triangulate_polygon(points)
    areas = triangle_areas(points, triangles)
    assert triangles.shape == (len(points) - 2, 3)
    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(abs(signed_area_m2(points)), rel=1e-9)


@given(star_outlines())
def test_star_outlines_are_simple(points):
    check_simple(points, name="star")


def test_a_spiral_is_filled_without_overlap():
    spiral = np.array(
        [
            (0, 0),
            (5, 0),
            (5, 5),
            (1, 5),
            (1, 2),
            (3, 2),
            (3, 3),
            (2, 3),
            (2, 4),
            (4, 4),
            (4, 1),
            (0, 1),
        ],
        dtype=float,
    )
    triangles = triangulate_polygon(spiral)
    probes = np.random.default_rng(3).uniform(0.0, 5.0, (4000, 2))
    count = covered_times(spiral, triangles, probes)
    assert set(np.unique(count)) == {0, 1}
    assert triangle_areas(spiral, triangles).sum() == pytest.approx(abs(signed_area_m2(spiral)))
    # The corridor's cells on the unit grid, arm by arm: 5 + 4 + 3 + 2 + 1.
    assert abs(signed_area_m2(spiral)) == pytest.approx(15.0)


def test_corners_on_a_straight_side_are_kept():
    square = np.array([(0, 0), (1, 0), (2, 0), (2, 2), (1, 2), (0.5, 2), (0, 2), (0, 1)], float)
    triangles = triangulate_polygon(square)
    assert len(triangles) == 6
    assert set(triangles.ravel()) == set(range(8))
    assert (triangle_areas(square, triangles) > 0.0).all()


@pytest.mark.parametrize(
    ("points", "says"),
    [
        ([(0, 0), (1, 0)], "at least 3"),
        ([(0, 0), (1, 0), (2, 0)], "no area"),
        ([(0, 0), (2, 2), (2, 0), (0, 1)], "meets side"),
        ([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)], "repeats"),
        ([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], "meets side"),  # touches its own side
        ([(0, 0), (3, 0), (1, 0), (1, 1)], "meets side"),  # folds back on itself
    ],
)
def test_outlines_that_are_not_simple_are_refused(points, says):
    with pytest.raises(GeometryError, match=says):
        check_simple(np.array(points, dtype=float), name="outline")


def test_a_crossed_polygon_cannot_be_cut():
    pentagram = np.array([(0, 3), (2, -3), (-3, 1), (3, 1), (-2, -3)], dtype=float)
    with pytest.raises(GeometryError, match="crosses or touches itself"):
        triangulate_polygon(pentagram)


@given(star_outlines(), st.integers(0, 2**31))
def test_polygons_in_space_keep_their_normal(points, seed):
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    points = points - points.mean(axis=0)
    space = points @ axes[:2] + rng.normal(size=3)
    triangles = triangulate_polygon_3d(space, name="polygon")
    a, b, c = (space[triangles[:, k]] for k in range(3))
    area_vector = 0.5 * np.cross(b - a, c - a).sum(axis=0)
    expected = signed_area_m2(points) * np.cross(axes[0], axes[1])
    np.testing.assert_allclose(area_vector, expected, atol=1e-9)


def test_a_polygon_with_a_repeated_corner_gives_an_empty_triangle_instead_of_an_error():
    space = np.array([(0, 0, 0), (1, 0, 0), (1, 0, 0), (0, 1, 0)], dtype=float)
    triangles = triangulate_polygon_3d(space, name="polygon")
    a, b, c = (space[triangles[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    assert sorted(areas) == pytest.approx([0.0, 0.5])


def test_a_mesh_keeps_every_triangle_and_stores_each_place_once():
    soup = np.array(
        [[(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0), (-0.0, 1, 0)]], float
    )
    vertices, faces = mesh_of_triangles(soup)
    assert len(vertices) == 4
    np.testing.assert_array_equal(vertices[faces], soup)
