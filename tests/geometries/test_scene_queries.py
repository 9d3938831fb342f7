"""What a scene answers about points and sides, against asking every facet in turn."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import l_shaped_room
from slow_images import inside, polygons

from octant.geometries.closed_parts import inside_parts
from octant.geometries.furniture import box, cylinder
from octant.geometries.occlusion import winding_numbers
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene


def cluttered(seed):
    rng = np.random.default_rng(seed)
    things = [
        box(rng.uniform(0.3, 1.0, 3), material="wood", yaw_deg=k * 20.0, name=f"box{k}")
        for k in range(3)
    ]
    things = [
        replace(b, vertices_m=b.vertices_m + rng.uniform((0.3, 0.3, 0.0), (2.0, 1.4, 1.0)))
        for b in things
    ]
    things[0] = replace(things[0], faces=things[0].faces[:, ::-1])  # inside out
    things.append(cylinder(0.3, 0.8, material="metal", sides=7, position_m=(1.0, 2.2, 0.4)))
    return build_scene(l_shaped_room((4.0, 3.0, 2.5), (1.7, 1.2)), objects=things), rng


@pytest.mark.parametrize("seed", range(3))
def test_distances_are_those_to_the_nearest_facet_of_all(seed):
    scene, rng = cluttered(seed)
    points = rng.uniform((-0.5, -0.5, -0.5), (4.5, 3.5, 3.0), (150, 3))
    distance, plane_of = scene.distance_to_facets_m(points)
    for point, mine, plane in zip(points, distance, plane_of, strict=True):
        heights = [
            (abs(normal @ point - offset), p)
            for normal, offset, outline, p in polygons(scene)
            if inside(point - (normal @ point - offset) * normal, normal, outline)
        ]
        expected = min(heights, default=(np.inf, -1))
        assert mine == pytest.approx(expected[0], abs=1e-12)
        assert plane == expected[1]
    near, _ = scene.distance_to_facets_m(points, within_m=0.2)
    assert near[distance <= 0.2] == pytest.approx(distance[distance <= 0.2])
    assert np.isinf(near[distance > 0.2]).all()
    assert 0 < (distance <= 0.2).sum() < 150


@pytest.mark.parametrize("seed", range(3))
def test_the_outer_side_of_a_facet_is_where_its_part_does_not_wind(seed):
    scene, _ = cluttered(seed)
    parts = (*scene.solids, scene.shell_corners_m)
    assert len(parts) == 5
    assert (scene.facet_part >= 0).all()
    for facet, plane in enumerate(scene.facets.facet_plane):
        own = np.flatnonzero(scene.facets.triangle_facet == facet)
        part = scene.facet_part[facet]
        assert set(scene.triangle_part[own]) == {part}
        edges = scene.facets.outline_room_m(facet)
        middle = edges[0].mean(axis=0)
        normal = scene.facets.plane_normal[plane]
        inward = np.cross(normal, edges[0, 1] - edges[0, 0])
        middle = middle + 1e-3 * inward / np.linalg.norm(inward)
        side = scene.facet_outer_side[facet]
        ends = middle + np.array([[1e-4], [-1e-4]]) * side * normal
        winding = np.round(winding_numbers(ends, parts[part])).astype(int) % 2
        assert winding.tolist() == [0, 1]


def test_a_point_is_inside_the_parts_that_wind_about_it():
    scene = build_scene(
        box_room((4.0, 3.0, 2.5)),
        objects=(
            box((1.0, 1.0, 1.0), material="wood", position_m=(1.0, 1.0, 0.0)),
            box((1.0, 1.0, 1.0), material="wood", position_m=(1.5, 1.2, 0.5)),
        ),
    )
    parts = (*scene.solids, scene.shell_corners_m)
    assert inside_parts(np.array([1.7, 1.5, 0.7]), parts).tolist() == [True, True, True]
    assert inside_parts(np.array([0.5, 0.5, 0.7]), parts).tolist() == [False, False, True]
    assert inside_parts(np.array([-0.5, 0.5, 0.7]), parts).tolist() == [False, False, False]


def test_a_point_on_the_apex_of_many_facets_is_moved_off_them():
    apex = cylinder(0.5, 0.8, material="metal", sides=24)
    cone = replace(
        apex,
        vertices_m=np.where(
            (apex.vertices_m[:, 2] > 0.4)[:, None], (0.0, 0.0, 0.8), apex.vertices_m
        ),
    )
    scene = build_scene(box_room((5.0, 5.0, 3.0), origin_m=(-2.5, -2.5, 0.0)), objects=(cone,))
    points, moved = scene.stand_off([(0.0, 0.0, 0.8)], 0.05)
    assert moved.all()
    assert not scene.inside_solid(points).any()
    assert scene.distance_to_facets_m(points)[0][0] > 0.01
