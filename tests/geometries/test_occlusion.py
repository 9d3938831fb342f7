import numpy as np
import pytest

from octant.geometries.furniture import box, cylinder
from octant.geometries.occlusion import build_bvh, segments_blocked, winding_numbers
from octant.geometries.scene import build_scene


def brute_force(corners, p, q):
    """Segment against every triangle, by signed volumes."""

    def volume(a, b, c, d):
        return np.einsum("...i,...i->...", np.cross(b - a, c - a), d - a)

    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sides = volume(a, b, c, p) * volume(a, b, c, q) < 0
    s = np.stack([volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)])
    return bool((sides & ((s > 0).all(axis=0) | (s < 0).all(axis=0))).any())


@pytest.mark.parametrize("count", [1, 4, 5, 60, 700])
def test_the_hierarchy_answers_as_every_triangle_asked_in_turn(count):
    rng = np.random.default_rng(count)
    corners = rng.uniform(0, 10, (count, 1, 3)) + rng.normal(0, 0.8, (count, 3, 3))
    bvh = build_bvh(corners, np.zeros(count, np.int64), extent_m=17.0)
    starts, ends = rng.uniform(0, 10, (2, 400, 3))
    expected = [brute_force(corners, p, q) for p, q in zip(starts, ends, strict=True)]
    assert segments_blocked(bvh, starts, ends).tolist() == expected
    assert count < 60 or 0 < sum(expected) < 400


def test_segments_along_the_axes_are_answered():
    bvh = build_bvh(
        np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], float), np.zeros(1, np.int64), extent_m=1.0
    )
    starts = [(0.2, 0.2, 1), (0.2, 0.2, 1), (0.9, 0.9, 1), (0.2, 0.2, 0.5), (-1, 0.2, 0)]
    ends = [(0.2, 0.2, -1), (0.2, 0.2, 0.5), (0.9, 0.9, -1), (0.2, 0.2, 0), (1, 0.2, 0)]
    assert segments_blocked(bvh, starts, ends).tolist() == [True, False, False, False, False]


def test_no_ray_slips_through_the_seam_of_two_triangles():
    lower, upper = [[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]
    corners = np.array([lower, upper], float)
    bvh = build_bvh(corners, np.zeros(2, np.int64), extent_m=1.0)
    rng = np.random.default_rng(0)
    on = np.repeat(rng.uniform(0.01, 0.99, (500, 1)), 2, axis=1)
    aim = np.column_stack((on, np.zeros(500)))
    start = rng.uniform((-1, -1, 0.5), (2, 2, 2), (500, 3))
    assert segments_blocked(bvh, start, aim + (aim - start)).all()


def test_planes_that_a_segment_ends_on_do_not_block_it():
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], float)
    bvh = build_bvh(corners, np.array([7]), extent_m=1.0)
    segment = ([(0.2, 0.2, 1)], [(0.2, 0.2, -1)])
    assert segments_blocked(bvh, *segment).tolist() == [True]
    assert segments_blocked(bvh, *segment, start_planes=7).tolist() == [False]
    assert segments_blocked(bvh, *segment, end_planes=7).tolist() == [False]


def test_an_empty_hierarchy_blocks_nothing():
    bvh = build_bvh(np.zeros((0, 3, 3)), np.zeros(0, np.int64), extent_m=1.0)
    assert segments_blocked(bvh, [(0, 0, 0)], [(1, 1, 1)]).tolist() == [False]


def test_winding_numbers_tell_inside_from_outside():
    body = cylinder(1.0, 2.0, material="metal", sides=16)
    points = np.random.default_rng(2).uniform((-2, -2, -1), (2, 2, 3), (300, 3))
    winding = winding_numbers(points, body.triangles_m)
    inner = np.hypot(points[:, 0], points[:, 1]) < np.cos(np.pi / 16)
    outer = np.hypot(points[:, 0], points[:, 1]) > 1.0
    between = (points[:, 2] > 0) & (points[:, 2] < 2)
    assert winding[inner & between] == pytest.approx(1.0, abs=1e-12)
    assert np.abs(winding[outer | ~between]).max() < 1e-12


def test_solids_standing_in_a_scene_are_found():
    scene = build_scene((), objects=(box((1, 1, 1), material="wood"),))
    assert len(scene.solids) == 1
    assert scene.inside_solid([(0.5, 0.5, 0.5), (1.5, 0.5, 0.5)]).tolist() == [True, False]
