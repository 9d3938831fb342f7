import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rooms import l_shaped_room

from octant.geometries.bodies import Body, place
from octant.geometries.edges import find_edges
from octant.geometries.furniture import box, cylinder
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene


def sheet(corners, faces, name="sheet", material="metal"):
    return Body(name=name, vertices_m=corners, faces=faces, material=material)


def sheet_ends(edges):
    """Whether a sheet ends at each edge."""
    return np.diff(edges.facet_start) == 1


def test_a_box_has_six_facets_and_twelve_right_angled_edges():
    scene = build_scene(box_room((5.0, 4.0, 3.0)))
    f = scene.facets
    assert len(f.plane_normal) == len(f.facet_plane) == 6
    assert f.facet_is_rectangle.all()
    assert sorted(f.area_m2(i) for i in range(6)) == pytest.approx([12, 12, 15, 15, 20, 20])
    edges = find_edges(f, tolerance_m=1e-6)
    assert len(edges.length_m) == 12
    assert edges.opening_rad == pytest.approx(np.full(12, np.pi / 2))
    assert not sheet_ends(edges).any()


def test_uneven_meshing_with_t_junctions_gives_the_same_facet():
    """A wall of two panels: one triangle pair against four strips, no shared vertices inside."""
    left = sheet([[0, 0, 0], [1, 0, 0], [1, 0, 2], [0, 0, 2]], [[0, 1, 2], [0, 2, 3]])
    levels = np.linspace(0.0, 2.0, 5)
    corners = [(x, 0.0, z) for z in levels for x in (1.0, 3.0)]
    strips = [
        t for k in range(4) for t in ((2 * k, 2 * k + 1, 2 * k + 3), (2 * k, 2 * k + 3, 2 * k + 2))
    ]
    right = sheet(corners, strips, name="right")
    scene = build_scene((left, right))
    assert len(scene.facets.facet_plane) == 1
    assert len(scene.facets.outline_m) == 4
    assert scene.facets.area_m2(0) == pytest.approx(6.0)
    edges = find_edges(scene.facets, tolerance_m=1e-6)
    assert sheet_ends(edges).all()
    assert edges.length_m.sum() == pytest.approx(10.0)


def test_two_materials_in_one_plane_are_two_facets_of_one_plane():
    a = sheet([[0, 0, 0], [1, 0, 0], [1, 0, 2], [0, 0, 2]], [[0, 1, 2], [0, 2, 3]])
    b = sheet([[1, 0, 0], [3, 0, 0], [3, 0, 2], [1, 0, 2]], [[0, 1, 2], [0, 2, 3]], "b", "wood")
    scene = build_scene((a, b))
    assert len(scene.facets.plane_normal) == 1
    assert len(scene.facets.facet_plane) == 2
    edges = find_edges(scene.facets, tolerance_m=1e-6)
    seam = ~sheet_ends(edges)
    assert seam.sum() == 1
    assert edges.opening_rad[seam] == pytest.approx([np.pi])


def test_doubled_and_reversed_triangles_count_once():
    corners = [[0, 0, 0], [2, 0, 0], [2, 0, 1], [0, 0, 1]]
    once = sheet(corners, [[0, 1, 2], [0, 2, 3]])
    twice = sheet(corners, [[0, 1, 2], [0, 2, 3], [2, 1, 0], [0, 2, 3]])
    for body in (once, twice):
        scene = build_scene((body,))
        assert len(scene.facets.facet_plane) == 1
        assert scene.facets.area_m2(0) == pytest.approx(2.0)


def test_a_hole_stays_a_hole():
    """A square frame: the winding about its opening is zero."""
    outer = [(0, 0), (4, 0), (4, 4), (0, 4)]
    inner = [(1, 1), (3, 1), (3, 3), (1, 3)]
    faces = []
    for k in range(4):
        n = (k + 1) % 4
        faces += [(k, n, 4 + n), (k, 4 + n, 4 + k)]
    frame = sheet([(x, y, 0.0) for x, y in outer + inner], faces)
    scene = build_scene((frame,))
    assert len(scene.facets.facet_plane) == 1
    assert not scene.facets.facet_is_rectangle[0]
    assert scene.facets.area_m2(0) == pytest.approx(12.0)
    distance, _ = scene.distance_to_facets_m([(2.0, 2.0, 1.0), (0.5, 2.0, 1.0)])
    assert distance.tolist() == [np.inf, 1.0]


@given(yaw=st.floats(0.0, 6.3), sides=st.integers(3, 40))
def test_a_cylinder_has_one_facet_a_side_and_two_ends(yaw, sides):
    body = place(cylinder(0.4, 1.2, material="metal", sides=sides), yaw_rad=yaw)
    facets = build_scene((), objects=(body,)).facets
    assert len(facets.facet_plane) == sides + 2
    assert sum(facets.area_m2(i) for i in range(sides + 2)) == pytest.approx(body.area_m2)


def test_three_sheets_on_one_edge_are_a_junction():
    fins = [
        sheet(
            [[0, 0, 0], [np.cos(a), np.sin(a), 0], [np.cos(a), np.sin(a), 1], [0, 0, 1]],
            [[0, 1, 2], [0, 2, 3]],
            name=f"fin{k}",
        )
        for k, a in enumerate(np.radians([0.0, 120.0, 240.0]))
    ]
    edges = find_edges(build_scene(fins).facets, tolerance_m=1e-6)
    members = np.diff(edges.facet_start)
    assert sorted(members.tolist()) == [1] * 9 + [3]
    assert edges.opening_rad[members == 3] == pytest.approx([np.radians(120.0)])


def test_inside_and_outside_of_rooms_and_solids():
    scene = build_scene(
        box_room((5.0, 5.0, 3.0), origin_m=(-1.0, -1.0, 0.0)),
        objects=(box((1.0, 1.0, 1.0), material="metal", position_m=(1.0, 1.0, 0.0)),),
    )
    points = [(0, 0, 1), (1.5, 1.5, 0.5), (1.5, 1.5, 1.5), (-1.5, 0, 1), (3, 3, 3.2)]
    assert scene.inside_room(points).tolist() == [True, True, True, False, False]
    assert scene.inside_solid(points).tolist() == [False, True, False, False, False]
    assert free_space_scene().inside_room(points).all()


def test_the_missing_corner_of_an_open_l_room_is_outside():
    bodies = [b for b in l_shaped_room((4.0, 4.0, 3.0), (2.0, 2.0)) if b.name != "ceiling"]
    scene = build_scene(bodies)
    assert len(scene.shell_corners_m) == 0
    assert scene.inside_room([(1.0, 1.0, 1.0), (3.0, 3.0, 1.0)]).tolist() == [True, False]


def test_a_point_on_a_wall_is_moved_into_the_room():
    scene = build_scene(box_room((5.0, 5.0, 3.0)))
    points, moved = scene.stand_off([(2, 2, 3), (0, 2, 1), (1, 1, 1), (5, 5, 3)], 0.05)
    assert moved.tolist() == [True, True, False, True]
    expected = [[2, 2, 2.95], [0.05, 2, 1], [1, 1, 1], [4.95, 4.95, 2.95]]
    assert points == pytest.approx(np.array(expected))


def test_supporting_planes_are_those_of_the_outer_walls():
    scene = build_scene(
        box_room((5.0, 5.0, 3.0)),
        objects=(box((1.0, 1.0, 1.0), material="metal", position_m=(1.0, 1.0, 0.0)),),
    )
    assert np.count_nonzero(scene.supporting_side) == 6
    assert len(scene.inner_bvh.triangles) == 10  # the box's foot lies in the floor's plane
