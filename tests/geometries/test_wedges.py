"""Which sectors of air diffract."""

import numpy as np
import pytest
from lattice_scenes import lattice_scene

from octant.geometries.bodies import Body
from octant.geometries.edges import find_edges
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.geometries.wedges import facets_rested_on, find_wedges, no_wedges


def sheets(*corners, material="metal"):
    """One body of parallelograms, each from a corner, a side and another."""
    vertices, faces = [], []
    for a, u, v in (np.array(c, float) for c in corners):
        n = len(vertices)
        vertices += [a, a + u, a + u + v, a + v]
        faces += [[n, n + 1, n + 2], [n, n + 2, n + 3]]
    return Body(
        name="sheets", vertices_m=np.array(vertices), faces=np.array(faces), material=material
    )


def along(wedges, axis, place):
    """Rows of the wedges parallel to an axis whose line runs through a place."""
    offset = np.asarray(place) - wedges.origin_m
    aside = np.linalg.norm(np.cross(offset, wedges.axis), axis=1)
    return np.flatnonzero((np.abs(wedges.axis @ np.asarray(axis, float)) > 0.999) & (aside < 1e-6))


def test_a_cabinet_on_the_floor_has_no_edges_where_it_stands():
    cabinet = box((1.0, 0.6, 0.9), material="metal", position_m=(1.0, 1.0, 0.0))
    scene = build_scene(box_room((4.0, 3.0, 2.5)), objects=(cabinet,))
    wedges = find_wedges(scene)
    middle = wedges.origin_m + 0.5 * wedges.length_m[:, None] * wedges.axis
    half = 0.5 * wedges.exterior_rad[:, None]
    air = middle + 1e-3 * (np.cos(half) * wedges.tangent + np.sin(half) * wedges.normal)
    inside = scene.inside_room(air)
    assert inside.sum() == 8
    assert middle[inside, 2].min() > 0.4
    assert not scene.inside_solid(air).any()


@pytest.mark.parametrize("fold_deg", [40.0, 90.0, 130.0])
def test_a_fold_of_a_sheet_has_two_wedges_that_make_a_full_turn(fold_deg):
    a = np.radians(fold_deg)
    fold = sheets(
        ((0, 0, 0), (1, 0, 0), (0, 0, 2)), ((0, 0, 0), (np.cos(a), np.sin(a), 0), (0, 0, 2))
    )
    wedges = find_wedges(build_scene((), objects=(fold,)))
    rows = along(wedges, (0, 0, 1), (0, 0, 0))
    angles = np.sort(wedges.exterior_rad[rows])
    if fold_deg == 90.0:  # the inner corner's images are exact
        assert angles == pytest.approx([1.5 * np.pi])
    else:
        assert angles == pytest.approx(np.sort([a, 2.0 * np.pi - a]))
    assert len(wedges) == 6 + len(rows)  # and the rims


def test_a_junction_of_three_sheets_has_three_wedges():
    turns = np.radians([0.0, 100.0, 230.0])
    star = sheets(*(((0, 0, 0), (np.cos(t), np.sin(t), 0), (0, 0, 2)) for t in turns))
    wedges = find_wedges(build_scene((), objects=(star,)))
    rows = along(wedges, (0, 0, 1), (0, 0, 0))
    assert np.sort(wedges.exterior_rad[rows]) == pytest.approx(np.radians([100.0, 130.0, 130.0]))
    assert wedges.exterior_rad[rows].sum() == pytest.approx(2.0 * np.pi)


def test_rims_are_half_planes_whose_two_faces_are_one_facet():
    wedges = find_wedges(build_scene((), objects=(sheets(((0, 0, 0), (1, 0, 0), (0, 0, 2))),)))
    assert len(wedges) == 4
    assert np.array_equal(wedges.exterior_rad, np.full(4, 2.0 * np.pi))
    assert np.array_equal(wedges.facets[:, 0], wedges.facets[:, 1])


@pytest.mark.parametrize(("other", "count"), [("metal", 0), ("wood", 2)])
def test_a_flush_seam_diffracts_only_between_two_materials(other, count):
    left = sheets(((0, 0, 0), (1, 0, 0), (0, 0, 2)))
    right = sheets(((1, 0, 0), (1, 0, 0), (0, 0, 2)), material=other)
    wedges = find_wedges(build_scene((), objects=(left, right)))
    rows = along(wedges, (0, 0, 1), (1, 0, 0))
    assert len(rows) == count  # one on either side
    assert wedges.exterior_rad[rows] == pytest.approx(np.full(count, np.pi))


def test_triangles_of_one_plane_make_no_edges():
    rng = np.random.default_rng(2)
    inner = np.column_stack((rng.uniform(0.2, 0.8, 5), rng.uniform(0.2, 0.8, 5)))
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    from scipy.spatial import Delaunay

    points = np.vstack((corners, inner))
    body = Body(
        name="flat",
        vertices_m=np.column_stack((points, np.zeros(9))),
        faces=Delaunay(points).simplices.astype(np.int64),
        material="metal",
    )
    assert len(find_wedges(build_scene((), objects=(body,)))) == 4


@pytest.mark.parametrize("yaw_deg", [0.0, 27.0])
def test_frames_lead_from_face_0_through_the_air_to_face_n(yaw_deg):
    cabinet = box((1.0, 0.6, 0.9), material="metal", position_m=(0.2, 0.1, 0.3), yaw_deg=yaw_deg)
    scene = build_scene((), objects=(cabinet,))
    wedges = find_wedges(scene)
    assert len(wedges) == 12
    planes = scene.facets.plane_normal[scene.facets.facet_plane[wedges.facets]]
    assert wedges.face_normals == pytest.approx(planes, abs=1e-12)  # outwards, into the air
    middle = wedges.origin_m + 0.5 * wedges.length_m[:, None] * wedges.axis
    for turn, inside in ((0.0, False), (1.5 * np.pi, False), (1.75 * np.pi, True)):
        offset = np.cos(turn) * wedges.tangent + np.sin(turn) * wedges.normal
        on_air_side = middle + 1e-3 * offset + (0.0 if inside else 1e-6) * planes.sum(axis=1)
        assert scene.inside_solid(on_air_side).all() == inside


def test_no_wedges_is_an_empty_set():
    assert len(no_wedges()) == 0
    assert no_wedges().face_normals.shape == (0, 2, 3)


@pytest.mark.parametrize("seed", range(6))
def test_edges_are_cut_at_every_corner_and_rest_on_every_facet_that_a_search_of_all_pairs_finds(
    seed,
):
    case = lattice_scene(seed)
    scene = build_scene(case.room, objects=case.objects)
    f, tolerance = scene.facets, 1e-6 * scene.extent_m
    edges = find_edges(f, tolerance_m=tolerance)
    outlines = [f.outline_room_m(i) for i in range(len(f.facet_plane))]
    corners = np.concatenate(outlines).reshape(-1, 3)
    start = edges.ends_m[:, 0]
    along = (corners[None] - start[:, None]) @ edges.axis[:, :, None]
    aside = np.linalg.norm(corners[None] - start[:, None] - along * edges.axis[:, None], axis=2)
    inner = (along[..., 0] > tolerance) & (along[..., 0] < edges.length_m[:, None] - tolerance)
    assert not (inner & (aside <= tolerance)).any()
    for i, outline in enumerate(outlines):
        own = edges.edge_of[edges.facet == i]
        perimeter = np.linalg.norm(outline[:, 1] - outline[:, 0], axis=1).sum()
        assert edges.length_m[own].sum() == pytest.approx(perimeter)
    found = set()
    for e, middle in enumerate(edges.ends_m.mean(axis=1)):
        for i, outline in enumerate(outlines):
            p = f.facet_plane[i]
            height = np.abs(edges.ends_m[e] @ f.plane_normal[p] - f.plane_offset_m[p])
            uv = np.array([f.plane_u[p], f.plane_v[p]]) @ middle
            a, b = (outline @ np.array([f.plane_u[p], f.plane_v[p]]).T).swapaxes(0, 1)
            (ax, ay), (bx, by) = (a - uv).T, (b - uv).T
            turn = np.arctan2(ax * by - ay * bx, ax * bx + ay * by).sum()
            span = b - a
            t = np.clip(np.sum((uv - a) * span, axis=1) / np.sum(span**2, axis=1), 0.0, 1.0)
            rim = np.linalg.norm(uv - a - t[:, None] * span, axis=1).min()
            if height.max() <= tolerance < rim and abs(turn) > 1.0:
                found.add((e, i))
    assert set(map(tuple, facets_rested_on(f, edges, tolerance).tolist())) == found


def test_rims_end_in_the_open_but_not_on_a_floor():
    corners = [(1.0, 2.0, 0.0), (3.0, 2.0, 0.0), (3.0, 2.0, 2.0), (1.0, 2.0, 2.0)]
    screen = Body(name="screen", vertices_m=corners, faces=[[0, 1, 2], [0, 2, 3]], material="wood")
    block = box((1.0, 0.6, 1.8), material="wood", position_m=(2.0, 3.0, 0.0), name="block")
    wedges = find_wedges(build_scene(box_room((5.0, 5.0, 3.0)), objects=[screen, block]))
    rim = wedges.exterior_rad > 6.0
    ends = wedges.origin_m[:, 2:] + (wedges.axis[:, 2] * wedges.length_m)[:, None] * np.arange(2)
    assert rim.sum() == 3
    assert (wedges.tips == (rim[:, None] & (ends > 1e-9))).all()


def test_an_edge_that_a_second_body_carries_on_has_no_end_there():
    def sheet(x, name, material):
        corners = [(x, 0.0, 1.0), (x + 1.0, 0.0, 1.0), (x + 1.0, 0.0, 2.0), (x, 0.0, 2.0)]
        faces = [[0, 1, 2], [0, 2, 3]]
        return Body(name=name, vertices_m=corners, faces=faces, material=material)

    for material, inner in (("wood", 0), ("metal", 1)):
        sheets = [sheet(0.0, "one", "wood"), sheet(1.0, "two", material)]
        wedges = find_wedges(build_scene((), objects=sheets))
        for w in np.flatnonzero(np.abs(wedges.axis[:, 0]) > 0.5):
            x = wedges.origin_m[w, 0] + wedges.axis[w, 0] * wedges.length_m[w] * np.arange(2)
            middle = np.abs(x - 1.0) < 1e-9
            assert (wedges.tips[w][middle] == inner).all()
            assert (wedges.tips[w][~middle] == 1).all()


def test_where_the_material_of_an_edge_changes_one_of_both_parts_has_the_joint():
    below = box((1.0, 1.0, 1.0), material="wood", position_m=(1.0, 1.0, 0.0), name="below")
    above = box((1.0, 1.0, 0.5), material="metal", position_m=(1.0, 1.0, 1.0), name="above")
    wedges = find_wedges(build_scene(box_room((4.0, 4.0, 3.0)), objects=[below, above]))
    rise = wedges.axis[:, 2] * wedges.length_m
    ends = wedges.origin_m[:, 2:] + rise[:, None] * np.arange(2)
    for corner in ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)):
        pair = along(wedges, (0, 0, 1), (*corner, 1.0))
        joint = np.abs(ends[pair] - 1.0) < 1e-9
        assert wedges.tips[pair][joint].tolist() == [0, -1]
        assert (wedges.tips[pair][~joint] == 0).all()
