"""Which triangles share a plane, and the facets they make: the rounding rule and a slow twin."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rooms import l_shaped_room
from slow_facets import facet_outlines

from octant.geometries._plane_geometry import weld
from octant.geometries.bodies import Body, place
from octant.geometries.errors import GeometryError
from octant.geometries.facets import build_facets
from octant.geometries.furniture import box, cylinder
from octant.geometries.planes import group_planes, rounding_m
from octant.geometries.rooms import Doorway, box_room
from octant.geometries.scene import build_scene


def cut(body, times, rng):
    """The same surface, each triangle cut at an inner place into three, again and again."""
    vertices, faces = body.vertices_m, body.faces
    for _ in range(times):
        weights = rng.dirichlet((4.0, 4.0, 4.0), len(faces))
        new = len(vertices) + np.arange(len(faces))
        vertices = np.concatenate((vertices, np.einsum("tk,tka->ta", weights, vertices[faces])))
        a, b, c = faces.T
        faces = np.concatenate(
            [np.column_stack(t) for t in ((a, b, new), (b, c, new), (c, a, new))]
        )
    return Body(name=body.name, vertices_m=vertices, faces=faces, material=body.material)


def stored(body):
    """The body as a float32 file gives it back."""
    rounded = body.vertices_m.astype(np.float32).astype(np.float64)
    return Body(name=body.name, vertices_m=rounded, faces=body.faces, material=body.material)


def as_segments(outlines):
    """Outlines as comparable sets of rounded directed edges."""
    return sorted(sorted(np.round(o.reshape(-1, 6), 5).tolist()) for o in outlines)


@given(seed=st.integers(0, 10_000))
def test_facets_are_those_of_the_slow_twin(seed):
    rng = np.random.default_rng(seed)
    room = (
        box_room((4.0, 3.0, 2.5), materials={"floor": "wood"}),
        l_shaped_room((4.0, 3.0, 2.5), (1.7, 1.2)),
        box_room((4.0, 3.0, 2.5), doorways=[Doorway(wall=1, offset_m=0.5, width_m=1, height_m=2)]),
    )[seed % 3]
    bodies = [cut(b, int(rng.integers(0, 3)), rng) for b in room]
    for k in range(3):
        where = (*rng.uniform(0.2, 2.0, 2), float(rng.choice([0.0, 0.5])))
        yaw = float(rng.choice([0.0, 27.0]))
        solid = box(rng.uniform(0.3, 1.0, 3), material="wood", position_m=where, yaw_deg=yaw)
        bodies.append(cut(solid, k, rng))
    bodies.append(cylinder(0.4, 1.0, material="metal", sides=9, position_m=(3.0, 2.0, 0.0)))
    offset = np.cumsum([0] + [len(b.vertices_m) for b in bodies])
    vertices = np.concatenate([b.vertices_m for b in bodies])
    faces = np.concatenate([b.faces + n for b, n in zip(bodies, offset, strict=False)])
    faces = weld(vertices, 1e-6)[faces]
    material = np.repeat([len(b.material) for b in bodies], [len(b.faces) for b in bodies])
    rounding = rounding_m(vertices, coordinate_bits=24, extent_m=6.0)
    facets = build_facets(vertices, faces, material, tolerance_m=6e-6, rounding_m=rounding)
    slow = facet_outlines(vertices, faces, material, 6e-6)
    count = len(facets.facet_plane)
    ours = as_segments([facets.outline_room_m(i) for i in range(count)])
    assert ours == as_segments([outline for _, _, outline in slow])
    groups = {tuple(np.flatnonzero(facets.triangle_facet == i)) for i in range(count)}
    assert groups == {tuple(members) for _, members, _ in slow}


def test_vertices_are_welded_to_the_first_of_their_place():
    rng = np.random.default_rng(3)
    places = rng.uniform(0, 5, (200, 3))
    vertices = places[rng.integers(0, 200, 1000)] + rng.uniform(-2e-8, 2e-8, (1000, 3))
    apart = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    assert weld(vertices, 1e-7).tolist() == np.argmax(apart <= 1e-7, axis=1).tolist()
    assert weld(np.zeros((0, 3)), 1e-7).tolist() == []


@pytest.mark.parametrize(("yaw", "times"), [(0.0, 5), (0.4, 2), (0.4, 5), (1.1, 6)])
def test_float32_leaves_a_remeshed_room_its_six_faces(yaw, times):
    rng = np.random.default_rng(times)
    coarse = [place(b, yaw_rad=yaw, position_m=(3.3, -1.7, 0.9)) for b in box_room((5.0, 5.0, 3.0))]
    fine = [stored(cut(b, times, rng)) for b in coarse]
    facets = build_scene(fine).facets
    assert len(facets.plane_normal) == len(facets.facet_plane) == 6
    assert sorted(facets.area_m2(i) for i in range(6)) == pytest.approx(
        [15, 15, 15, 15, 25, 25], rel=1e-6
    )
    by_bits = build_scene(fine, coordinate_bits=53).facets
    assert (len(by_bits.plane_normal) > 60) == (yaw > 0.0)


def test_uneven_panels_of_a_turned_float32_wall_are_one_facet():
    """Strips of 5 cm beside a panel of 2 m: a strip fixes its plane badly, the panel fixes it."""
    sheets = []
    for k, (x0, x1, rows) in enumerate([(0.0, 0.05, 3), (0.05, 0.1, 7), (0.1, 2.0, 1)]):
        levels = np.linspace(0.0, 2.5, rows + 1)
        corners = [(x, 0.0, z) for z in levels for x in (x0, x1)]
        faces = []
        for r in range(rows):
            faces += [(2 * r, 2 * r + 1, 2 * r + 3), (2 * r, 2 * r + 3, 2 * r + 2)]
        sheet = Body(name=f"panel{k}", vertices_m=corners, faces=faces, material="wood")
        sheets.append(stored(place(sheet, yaw_rad=0.7, position_m=(4.1, 2.3, 0.0))))
    facets = build_scene(sheets).facets
    assert len(facets.facet_plane) == 1
    assert facets.area_m2(0) == pytest.approx(5.0)
    assert len(facets.outline_m) == 4


def test_pieces_apart_share_a_plane_only_where_rounding_lets_them():
    def tops(step):
        return [
            box((0.5, 0.5, 1.0 + k * step), material="wood", position_m=(k, 0.3 * k, 0.0))
            for k in range(3)
        ]

    assert len(build_scene((), objects=tops(0.0)).facets.plane_normal) == 2 + 3 * 4
    assert len(build_scene((), objects=tops(1e-4)).facets.plane_normal) == 4 + 3 * 4


def test_small_steps_stay_steps_in_a_large_hall():
    """What merges is the rounding of the corners in question, not a share of the scene."""
    hall = box_room((1000.0, 800.0, 30.0))
    stairs = [
        box((0.3, 0.1, 0.1 + 2e-4 * k), material="wood", position_m=(1.0 + 0.3 * k, 1.0, 0.0))
        for k in range(4)
    ]
    planes = build_scene(hall, objects=stairs).facets.plane_normal
    assert (np.abs(planes[:, 2]) > 0.999).sum() == 2 + 4


def test_a_gentle_dome_is_not_followed():
    """However small the triangles, no corner is off its plane by more than rounding tells."""
    n, radius = 60, 10.0
    i = np.arange(n + 1)
    x, y = np.meshgrid(i * 0.004, i * 0.004, indexing="ij")
    vertices = np.stack((x, y, np.sqrt(radius**2 - x**2 - y**2)), axis=-1).reshape(-1, 3)
    a = (i[:-1, None] * (n + 1) + i[None, :-1]).ravel()
    faces = np.concatenate(
        (np.stack((a, a + n + 1, a + n + 2), 1), np.stack((a, a + n + 2, a + 1), 1))
    )
    tolerance = rounding_m(vertices, coordinate_bits=24, extent_m=0.34)
    label = group_planes(vertices, faces, tolerance)
    assert label.min() == 0
    assert label.max() > 20
    for plane in range(label.max() + 1):
        corners = vertices[faces[label == plane]].reshape(-1, 3)
        middle = corners.mean(axis=0)
        normal = np.linalg.svd(corners - middle)[2][2]
        assert np.abs((corners - middle) @ normal).max() < 8.0 * tolerance.max()


def test_the_number_of_bits_has_a_range():
    with pytest.raises(GeometryError, match="coordinate_bits = 0"):
        build_scene(box_room((1.0, 1.0, 1.0)), coordinate_bits=0)
