"""Furniture is closed, faces outwards, has its closed-form volume, and stands where it is put."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box, cabinet, cylinder, sphere
from octant.geometries.mesh_files import mesh_object, save_bodies

lengths = st.floats(0.01, 10.0)


def signed_volume_m3(body):
    corners = body.triangles_m - body.vertices_m.mean(axis=0)
    return float(np.linalg.det(corners).sum() / 6.0)


def assert_closed(body):
    faces = body.faces
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there = {tuple(e) for e in directed.tolist()}
    assert len(there) == len(directed)  # consistent winding
    assert there == {(b, a) for a, b in there}  # each edge once in either direction
    assert len(body.vertices_m) - len(directed) // 2 + len(faces) == 2  # Euler


@given(st.tuples(lengths, lengths, lengths), st.floats(-360, 360))
def test_a_box_is_closed_and_has_its_volume_and_area_however_it_is_turned(size, yaw):
    body = box(size, material="wood", position_m=(1, 2, 3), yaw_deg=yaw)
    a, b, c = size
    assert_closed(body)
    assert signed_volume_m3(body) == pytest.approx(a * b * c, rel=1e-9)
    assert body.area_m2 == pytest.approx(2 * (a * b + b * c + c * a), rel=1e-9)


def test_a_box_stands_on_its_lowest_corner_and_turns_about_it():
    straight = box((2, 1, 3), material="wood", position_m=(5, 6, 7))
    np.testing.assert_array_equal(straight.bounds_m, [(5, 6, 7), (7, 7, 10)])
    turned = box((2, 1, 3), material="wood", position_m=(5, 6, 7), yaw_deg=90)
    np.testing.assert_array_equal(turned.bounds_m, [(4, 6, 7), (5, 8, 10)])


def test_a_cabinet_is_the_metal_box_of_the_thesis():
    body = cabinet(position_m=(1.75, 2.2, 0.0))
    assert (body.name, body.material) == ("cabinet", "metal")
    np.testing.assert_allclose(body.bounds_m, [(1.75, 2.2, 0), (3.25, 2.55, 1)])


@given(lengths, lengths, st.integers(3, 60), st.floats(-360, 360))
def test_a_cylinder_is_the_inscribed_prism(radius, height, sides, yaw):
    body = cylinder(
        radius, height, material="concrete", sides=sides, position_m=(1, 2, 3), yaw_deg=yaw
    )
    assert_closed(body)
    base = 0.5 * sides * radius**2 * math.sin(2 * math.pi / sides)
    assert signed_volume_m3(body) == pytest.approx(base * height, rel=1e-8)
    side = 2 * radius * math.sin(math.pi / sides) * height
    assert body.area_m2 == pytest.approx(2 * base + sides * side, rel=1e-8)


def test_a_cylinder_stands_on_the_centre_of_its_base():
    body = cylinder(0.5, 2.0, material="concrete", sides=4, position_m=(1, 2, 3))
    np.testing.assert_allclose(body.bounds_m, [(0.5, 1.5, 3), (1.5, 2.5, 5)], atol=1e-15)


@pytest.mark.parametrize("subdivisions", [0, 1, 2, 3])
def test_a_sphere_is_a_closed_polyhedron_inscribed_in_it(subdivisions):
    body = sphere(0.5, material="wood", subdivisions=subdivisions, position_m=(1, 2, 3), yaw_deg=9)
    assert_closed(body)
    assert len(body.faces) == 20 * 4**subdivisions
    assert np.linalg.norm(body.vertices_m - (1, 2, 3), axis=1) == pytest.approx(0.5)
    whole = 4.0 / 3.0 * math.pi * 0.125
    assert 1.0 - 0.5 / 3.2**subdivisions < signed_volume_m3(body) / whole < 1.0
    assert body.area_m2 < math.pi


def test_a_mesh_object_is_scaled_turned_and_moved_in_this_order(tmp_path):
    file = tmp_path / "brick.stl"
    file_units = box((200, 100, 50), material="brick", position_m=(100, 0, 0))
    save_bodies([file_units], file)
    (placed,) = mesh_object(
        file, unit="mm", material="brick", position_m=(3, 4, 5), yaw_deg=90, name="block"
    )
    assert placed.name == "block"
    np.testing.assert_allclose(placed.bounds_m, [(2.9, 4.1, 5), (3.0, 4.3, 5.05)], atol=1e-7)


def test_several_bodies_of_a_mesh_object_keep_their_names_behind_the_given_one(tmp_path):
    file = tmp_path / "desk.glb"
    save_bodies([box((1, 1, 1), material="m", name=n) for n in ("top", "leg")], file)
    named = mesh_object(file, material="wood", name="desk")
    assert [b.name for b in named] == ["desk.top", "desk.leg"]
    assert [b.name for b in mesh_object(file, material="wood")] == ["top", "leg"]
    table = mesh_object(file, materials_by_name={"top": "wood", "leg": "metal"})
    assert [b.material for b in table] == ["wood", "metal"]


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: box((1, 0, 1), material="wood"), "in y is 0 m"),
        (lambda: box((1, 1), material="wood"), "shape"),
        (lambda: cabinet(yaw_deg=math.nan), "yaw_deg"),
        (lambda: cabinet(position_m=(0, 0, math.nan)), "position_m"),
        (lambda: cylinder(-1, 1, material="wood"), "radius_m"),
        (lambda: cylinder(1, math.inf, material="wood"), "height_m"),
        (lambda: cylinder(1, 1, material="wood", sides=2), "sides"),
        (lambda: cylinder(1, 1, material="wood", sides=5.5), "sides"),
        (lambda: sphere(0, material="wood"), "radius_m"),
        (lambda: sphere(1, material="wood", subdivisions=7), "subdivisions"),
    ],
)
def test_furniture_that_cannot_be_is_refused_in_one_sentence(call, says):
    with pytest.raises(GeometryError, match=says) as caught:
        call()
    assert "\n" not in str(caught.value)
