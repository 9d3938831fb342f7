"""Mesh files: the unit is never guessed, up is up, and bodies come back as they were written."""

import base64
import json
import math
import struct
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box, cylinder
from octant.geometries.mesh_files import (
    METRES_PER_UNIT,
    Body,
    load_bodies,
    metres_per_unit,
    readable_extensions,
    save_bodies,
)
from octant.geometries.rooms import box_room

# A tetrahedron 4 m long, 3 m deep and 1 m high, with corners that float32 holds exactly.
CORNERS = [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 1.0)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
TETRAHEDRON = Body(name="tetrahedron", vertices_m=CORNERS, faces=FACES, material="wood")

ASCII_SOLID = """solid {name}
facet normal 0 0 1
outer loop
vertex 0 0 {z}
vertex {x} 0 {z}
vertex 0 1 {z}
endloop
endfacet
endsolid {name}
"""


def volume_m3(bodies):
    corners = np.concatenate([body.triangles_m for body in bodies])
    return float(np.linalg.det(corners).sum() / 6.0)


def gltf(nodes, *, primitives=None, positions=CORNERS, accessor=None, **header):
    """A glTF file as the specification describes it, without any help of the code under test."""
    points = struct.pack(f"<{3 * len(positions)}f", *np.ravel(positions))
    index = struct.pack(f"<{3 * len(FACES)}H", *np.ravel(FACES))
    data = base64.b64encode(points + index).decode()
    low, high = np.min(positions, axis=0).tolist(), np.max(positions, axis=0).tolist()
    position = {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3"}
    indices = {"bufferView": 1, "componentType": 5123, "count": 3 * len(FACES), "type": "SCALAR"}
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [i for i, n in enumerate(nodes) if not n.pop("inner", False)]}],
            "nodes": nodes,
            "meshes": [{"name": "mesh", "primitives": primitives or [primitive]}],
            "accessors": [position | {"min": low, "max": high} | (accessor or {}), indices],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
                {"buffer": 0, "byteOffset": len(points), "byteLength": len(index)},
            ],
            "buffers": [
                {
                    "uri": "data:application/octet-stream;base64," + data,
                    "byteLength": len(points) + len(index),
                }
            ],
        }
        | header
    )


# ------------------------------------------------------------------------------- units


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("m", 1), ("CM", 0.01), (" mm ", 0.001), ("in", 0.0254), ("feet", 0.3048), ("yd", 0.9144)],
)
def test_units_have_their_legal_length(unit, metres):
    assert metres_per_unit(unit) == pytest.approx(metres, rel=1e-15)


def test_a_foot_is_twelve_inches_and_a_yard_three_feet():
    assert METRES_PER_UNIT["ft"] == pytest.approx(12 * METRES_PER_UNIT["in"], rel=1e-15)
    assert METRES_PER_UNIT["yd"] == pytest.approx(3 * METRES_PER_UNIT["ft"], rel=1e-15)


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "off"])
@pytest.mark.parametrize("unit", ["m", "mm", "ft"])
def test_a_length_scales_with_its_unit_and_a_volume_with_its_cube(tmp_path, kind, unit):
    file = tmp_path / f"t.{kind}"
    save_bodies([TETRAHEDRON], file)
    loaded = load_bodies(file, unit=unit, material="wood")
    scale = METRES_PER_UNIT[unit]
    assert volume_m3(loaded) == pytest.approx(2.0 * scale**3, rel=1e-6)
    np.testing.assert_allclose(loaded[0].bounds_m[1], np.array([4, 3, 1]) * scale, rtol=1e-6)


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "off"])
def test_a_file_that_does_not_say_its_unit_is_refused_without_one(tmp_path, kind):
    file = tmp_path / f"t.{kind}"
    save_bodies([TETRAHEDRON], file)
    with pytest.raises(GeometryError, match="does not say in which unit"):
        load_bodies(file, material="wood")
    with pytest.raises(GeometryError, match=r"'metr' is unknown.*did you mean 'metre'"):
        load_bodies(file, unit="metr", material="wood")


# ------------------------------------------------------------------------ round trips


@pytest.mark.parametrize("kind", ["glb", "gltf", "3mf", "obj"])
def test_named_bodies_come_back_in_place_order_and_winding(tmp_path, kind):
    bodies = (*box_room((5, 4, 3), origin_m=(-1, 2, 0)), TETRAHEDRON)
    file = tmp_path / f"room.{kind}"
    save_bodies(bodies, file)
    labels = {b.name: b.material for b in bodies}
    unit = "m" if kind == "obj" else None
    back = load_bodies(file, unit=unit, materials_by_name=labels)
    assert [(b.name, b.material) for b in back] == [(b.name, b.material) for b in bodies]
    for a, b in zip(back, bodies, strict=True):
        np.testing.assert_allclose(a.triangles_m, b.triangles_m, atol=1e-12)


@pytest.mark.parametrize("kind", ["stl", "ply", "off"])
def test_formats_without_names_give_one_body_called_after_the_file(tmp_path, kind):
    file = tmp_path / f"room.{kind}"
    save_bodies(box_room((5, 4, 3)), file)
    (back,) = load_bodies(file, unit="m", material="brick")
    assert back.name == "room"
    assert back.area_m2 == pytest.approx(2 * (20 + 15 + 12))
    assert volume_m3([back]) == pytest.approx(-60.0)


@pytest.mark.parametrize(
    ("kind", "relative"),
    [("obj", 0.0), ("3mf", 1e-15), ("off", 1e-14), ("glb", 6e-8), ("stl", 6e-8), ("ply", 6e-8)],
)
def test_the_digits_that_a_format_keeps(tmp_path, kind, relative):
    body = cylinder(math.pi, math.e, material="wood", sides=7, yaw_deg=1.0)
    file = tmp_path / f"c.{kind}"
    save_bodies([body], file)
    (back,) = load_bodies(file, unit=None if kind in {"glb", "3mf"} else "m", material="wood")
    error = np.abs(back.triangles_m - body.triangles_m).max()
    assert error <= relative * math.pi


def test_nothing_is_merged_or_left_out(tmp_path):
    """Doubled corners, a doubled and a degenerate triangle all survive the way through a GLB."""
    messy = Body(
        name="messy",
        vertices_m=[*CORNERS, CORNERS[0]],
        faces=[*FACES, FACES[0], (0, 4, 1)],
        material="wood",
    )
    file = tmp_path / "messy.glb"
    save_bodies([messy], file)
    (back,) = load_bodies(file, material="wood")
    np.testing.assert_array_equal(back.faces, messy.faces)
    np.testing.assert_array_equal(back.vertices_m, messy.vertices_m)


def test_an_stl_repeats_every_corner(tmp_path):
    file = tmp_path / "t.stl"
    save_bodies([TETRAHEDRON], file)
    (back,) = load_bodies(file, unit="m", material="wood")
    assert len(back.vertices_m) == 3 * len(FACES)


@pytest.mark.parametrize(
    ("bodies", "name", "says"),
    [
        ([], "a.glb", "there is no body"),
        ([TETRAHEDRON, TETRAHEDRON], "a.glb", "names repeat"),
        ([TETRAHEDRON], "a.step", "can be written"),
        ([TETRAHEDRON], "nowhere/a.glb", "does not exist"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path, bodies, name, says):
    with pytest.raises(GeometryError, match=says):
        save_bodies(bodies, tmp_path / name)


# ---------------------------------------------------------------------- the vertical axis


def test_gltf_is_y_up_by_its_specification(tmp_path):
    """+Y is up in glTF: the corner at (0, 0, 1) is 1 m towards the viewer, -y here."""
    file = tmp_path / "t.gltf"
    file.write_text(gltf([{"name": "n", "mesh": 0}]))
    (body,) = load_bodies(file, material="wood")
    np.testing.assert_array_equal(body.vertices_m, [(0, 0, 0), (4, 0, 0), (0, 0, 3), (0, -1, 0)])
    assert volume_m3([body]) == pytest.approx(2.0)  # turned, not mirrored


def test_a_z_up_gltf_is_taken_as_it_is(tmp_path):
    file = tmp_path / "t.gltf"
    file.write_text(gltf([{"name": "n", "mesh": 0}]))
    (body,) = load_bodies(file, material="wood", up="z")
    np.testing.assert_array_equal(body.vertices_m, CORNERS)


def test_a_written_glb_stands_upright_for_other_programs(tmp_path):
    """The file itself, read by trimesh without Octant, has the height along y."""
    import trimesh

    file = tmp_path / "room.glb"
    save_bodies(box_room((5, 4, 3)), file)
    extents = trimesh.load_scene(str(file)).extents
    np.testing.assert_allclose(extents, (5, 3, 4))


@pytest.mark.parametrize("kind", ["stl", "obj"])
def test_other_formats_are_z_up_unless_told_otherwise(tmp_path, kind):
    file = tmp_path / f"t.{kind}"
    save_bodies([TETRAHEDRON], file)
    (as_is,) = load_bodies(file, unit="m", material="wood")
    np.testing.assert_array_equal(as_is.bounds_m, [(0, 0, 0), (4, 3, 1)])
    (turned,) = load_bodies(file, unit="m", material="wood", up="y")
    np.testing.assert_array_equal(turned.bounds_m, [(0, -1, 0), (4, 0, 3)])
    with pytest.raises(GeometryError, match="up is 'x'"):
        load_bodies(file, unit="m", material="wood", up="x")


# --------------------------------------------------------------------------- scene graphs


def test_placed_and_mirrored_instances_keep_their_names_volume_and_outside(tmp_path):
    nodes = [
        {"name": "group", "translation": [10, 0, 0], "children": [1, 2]},
        {"name": "left", "mesh": 0, "inner": True},
        {"name": "right", "mesh": 0, "scale": [-1, 1, 1], "inner": True},
        {"name": "big", "mesh": 0, "scale": [2, 2, 2], "rotation": [0, 1, 0, 0]},
    ]
    file = tmp_path / "t.gltf"
    file.write_text(gltf(nodes))
    bodies = {b.name: b for b in load_bodies(file, material="wood", up="z")}
    assert set(bodies) == {"left", "right", "big"}
    np.testing.assert_allclose(bodies["left"].bounds_m, [(10, 0, 0), (14, 3, 1)])
    np.testing.assert_allclose(bodies["right"].bounds_m, [(6, 0, 0), (10, 3, 1)])
    np.testing.assert_allclose(bodies["big"].bounds_m, [(-8, 0, -2), (0, 6, 0)], atol=1e-9)
    assert volume_m3([bodies["left"]]) == pytest.approx(2.0)
    assert volume_m3([bodies["right"]]) == pytest.approx(2.0)
    assert volume_m3([bodies["big"]]) == pytest.approx(16.0)


def test_a_node_without_a_name_is_called_after_its_mesh(tmp_path):
    file = tmp_path / "t.gltf"
    file.write_text(gltf([{"mesh": 0}]))
    assert [b.name for b in load_bodies(file, material="wood")] == ["mesh"]


def test_one_object_of_two_materials_gives_a_body_for_each(tmp_path):
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    file = tmp_path / "t.gltf"
    file.write_text(
        gltf(
            [{"name": "Room", "mesh": 0}],
            primitives=[primitive | {"material": 0}, primitive | {"material": 1}],
            materials=[{"name": "brick"}, {"name": "oak"}],
        )
    )
    table = {"Room.brick": "brick", "Room.oak": "wood"}
    bodies = load_bodies(file, materials_by_name=table)
    assert {b.name: b.material for b in bodies} == table


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco_mesh_compression"),
        ({"extensionsRequired": ["EXT_mesh_gpu_instancing"]}, "EXT_mesh_gpu_instancing"),
        ({"accessor": {"normalized": True}}, "normalised"),
        ({"accessor": {"sparse": {"count": 1}}}, "sparse"),
        ({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 6}]}, "fan"),
        ({"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}, "holds no triangles"),
    ],
)
def test_gltf_geometry_that_would_come_out_wrong_is_refused(tmp_path, changes, says):
    file = tmp_path / "t.gltf"
    file.write_text(gltf([{"name": "n", "mesh": 0}], **changes))
    with pytest.raises(GeometryError, match=says):
        load_bodies(file, material="wood")


def test_an_extension_that_only_changes_the_looks_is_no_obstacle(tmp_path):
    file = tmp_path / "t.gltf"
    file.write_text(gltf([{"name": "n", "mesh": 0}], extensionsRequired=["KHR_materials_unlit"]))
    assert len(load_bodies(file, material="wood")) == 1


def test_a_3mf_file_declares_its_unit_and_may_not_be_contradicted(tmp_path):
    file, inches = tmp_path / "t.3mf", tmp_path / "inches.3mf"
    save_bodies([TETRAHEDRON], file)
    with zipfile.ZipFile(file) as source, zipfile.ZipFile(inches, "w") as target:
        for entry in source.namelist():
            data = source.read(entry)
            assert (b'unit="millimeter"' in data) == entry.endswith(".model")
            target.writestr(entry, data.replace(b'unit="millimeter"', b'unit="inch"'))
    (small,) = load_bodies(file, material="wood", unit="mm")
    np.testing.assert_allclose(small.bounds_m[1], (4, 3, 1))
    (large,) = load_bodies(inches, material="wood")
    np.testing.assert_allclose(large.bounds_m[1], np.array([4, 3, 1]) * 25.4)
    with pytest.raises(GeometryError, match="declares its unit as inch"):
        load_bodies(inches, material="wood", unit="m")


def test_the_solids_of_an_ascii_stl_are_bodies_of_their_own(tmp_path):
    file = tmp_path / "two.stl"
    file.write_text(
        ASCII_SOLID.format(name="Floor", x=2, z=0) + ASCII_SOLID.format(name="Table top", x=1, z=5)
    )
    floor, table = load_bodies(file, unit="m", material="wood")
    assert (floor.name, table.name) == ("Floor", "Table top")
    assert (floor.area_m2, table.area_m2) == (pytest.approx(1.0), pytest.approx(0.5))


# --------------------------------------------------------------------------- Wavefront OBJ

L_SHAPE = "v 0 0 0\nv 4 0 0\nv 4 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n"


def obj(tmp_path, text, **options):
    file = tmp_path / "model.obj"
    file.write_text(text)
    return load_bodies(file, unit="m", **({"material": "wood"} | options))


@pytest.mark.parametrize("first", range(6))
@pytest.mark.parametrize("reverse", [False, True])
def test_a_concave_polygon_of_an_obj_is_filled_once(tmp_path, first, reverse):
    ring = [1 + (first + k) % 6 for k in range(6)][:: -1 if reverse else 1]
    (body,) = obj(tmp_path, L_SHAPE + "f " + " ".join(map(str, ring)))
    assert body.area_m2 == pytest.approx(4 + 2)  # a fan from most corners would give more
    a, b, c = np.moveaxis(body.triangles_m, 1, 0)
    up = np.cross(b - a, c - a)[:, 2]
    assert (up < 0.0).all() if reverse else (up > 0.0).all()


def test_objects_groups_and_materials_of_an_obj_keep_bodies_apart(tmp_path):
    text = (
        L_SHAPE + "f 1 2 3\n"
        "o Room\nusemtl brick\nf 1 2 3\nusemtl oak\nf 1 2 3\nf 2 3 4\nusemtl brick\nf 3 4 5\n"
        "o Door leaf\nf 1 2 3\n"
        "g hinge\nf 1 2 3\n"
    )
    bodies = obj(tmp_path, text)
    sizes = {b.name: len(b.faces) for b in bodies}
    assert sizes == {
        "model": 1,
        "Room.brick": 2,
        "Room.oak": 2,
        "Door leaf": 1,
        "Door leaf.hinge": 1,
    }


def test_obj_corners_may_count_backwards_carry_normals_and_be_continued(tmp_path):
    (body,) = obj(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 2 0\nvn 0 0 1\nf -3//1 -2/7/1 \\\n 3/8\n")
    np.testing.assert_array_equal(body.triangles_m, [[(0, 0, 0), (1, 0, 0), (1, 2, 0)]])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("v 0 0 0\nv 1 0\n", "line 2.*three finite coordinates"),
        ("v 0 0 0\nv 1 0 x\n", "line 2"),
        ("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "line 2.*finite"),
        (L_SHAPE + "f 1 2\n", "line 7.*three corners"),
        (L_SHAPE + "f 1 2 9\n", "line 7.*vertex 9 of only 6"),
        (L_SHAPE + "f 0 1 2\n", "line 7.*before the first"),
        (L_SHAPE + "f 1 2 -9\n", "line 7.*before the first"),
        (L_SHAPE + "f 1 3 2 6 4\n", "line 7.*crosses"),
        (L_SHAPE, "holds no triangles"),
    ],
)
def test_an_obj_that_cannot_be_read_is_refused_by_line(tmp_path, text, says):
    with pytest.raises(GeometryError, match=says):
        obj(tmp_path, text)


@given(st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 3), min_size=3, max_size=9, unique=True))
def test_an_obj_keeps_every_bit(tmp_path_factory, points):
    file = tmp_path_factory.mktemp("obj") / "t.obj"
    faces = [(i, i + 1, i + 2) for i in range(len(points) - 2)]
    body = replace(TETRAHEDRON, vertices_m=points, faces=faces)
    save_bodies([body], file)
    (back,) = load_bodies(file, unit="m", material="wood")
    np.testing.assert_array_equal(back.vertices_m, points)


# ----------------------------------------------------------------------------- materials


def test_a_table_of_materials_comes_before_the_material_of_the_file(tmp_path):
    file = tmp_path / "room.glb"
    save_bodies(box_room((5, 4, 3)), file)
    bodies = load_bodies(file, material="brick", materials_by_name={"floor": "wood"})
    assert [b.material for b in bodies] == ["brick", "wood", "brick"]


def test_a_body_without_a_material_and_a_material_without_a_body_are_named(tmp_path):
    file = tmp_path / "room.obj"
    save_bodies(box_room((5, 4, 3)), file)
    with pytest.raises(GeometryError, match=r"body 'ceiling'.*has no material"):
        load_bodies(file, unit="m", materials_by_name={"walls": "brick", "floor": "wood"})
    with pytest.raises(GeometryError, match=r"'Floor'.*did you mean 'floor'"):
        load_bodies(file, unit="m", material="brick", materials_by_name={"Floor": "wood"})


def test_a_glb_keeps_the_materials_that_it_was_written_with_unless_told_otherwise(tmp_path):
    file = tmp_path / "room.glb"
    save_bodies(box_room((5, 4, 3), material="brick"), file)
    assert {b.material for b in load_bodies(file)} == {"brick"}
    told = load_bodies(file, materials_by_name={"floor": "wood"})
    assert {b.name: b.material for b in told} == {
        "walls": "brick",
        "floor": "wood",
        "ceiling": "brick",
    }
    assert {b.material for b in load_bodies(file, material="glass")} == {"glass"}


# ---------------------------------------------------------------------------- bad input


def test_a_missing_file_a_folder_and_an_unknown_kind_are_refused(tmp_path):
    with pytest.raises(GeometryError, match="does not exist"):
        load_bodies(tmp_path / "nothing.stl", unit="m", material="wood")
    with pytest.raises(GeometryError, match="is a folder"):
        load_bodies(tmp_path, unit="m", material="wood")
    (tmp_path / "a.step").write_text("ISO-10303-21;")
    with pytest.raises(GeometryError, match=r"'\.step', .* gmsh a\.step -2 -o a\.stl"):
        load_bodies(tmp_path / "a.step", unit="m", material="wood")


@pytest.mark.parametrize("kind", sorted({"stl", "ply", "off", "glb", "gltf", "3mf", "obj"}))
@pytest.mark.parametrize("content", [b"", b"hello world\n", bytes(range(256)) * 3])
def test_a_file_that_is_not_a_mesh_is_refused_in_one_sentence(tmp_path, kind, content):
    assert kind in readable_extensions()
    file = tmp_path / f"broken.{kind}"
    file.write_bytes(content)
    with pytest.raises(GeometryError) as caught:
        load_bodies(file, unit="mm", material="wood")
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_empty_stl_and_a_cloud_of_points_are_refused(tmp_path):
    empty = tmp_path / "empty.stl"
    empty.write_bytes(bytes(84))
    with pytest.raises(GeometryError, match="holds no triangles"):
        load_bodies(empty, unit="m", material="wood")
    cloud = tmp_path / "cloud.ply"
    cloud.write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    )
    with pytest.raises(GeometryError, match="holds no triangles"):
        load_bodies(cloud, unit="m", material="wood")


def test_nan_vertices_are_refused_in_text_and_binary(tmp_path):
    text = tmp_path / "nan.stl"
    text.write_text(ASCII_SOLID.format(name="s", x="nan", z=0))
    with pytest.raises(GeometryError, match="NaN"):
        load_bodies(text, unit="m", material="wood")
    file = tmp_path / "nan.gltf"
    file.write_text(gltf([{"name": "n", "mesh": 0}], positions=[(math.inf, 0, 0), *CORNERS[1:]]))
    with pytest.raises(GeometryError, match="infinite"):
        load_bodies(file, material="wood")


def test_a_text_file_cut_off_in_the_middle_of_a_number_is_refused(tmp_path):
    file = tmp_path / "cut.stl"
    file.write_text(ASCII_SOLID.format(name="s", x="1.0abc", z=0))
    with pytest.raises(GeometryError, match="cannot be read"):
        load_bodies(file, unit="m", material="wood")


def test_files_are_read_whatever_the_case_of_their_extension(tmp_path):
    file = tmp_path / "BOX.STL"
    save_bodies([box((1, 2, 3), material="wood")], file)
    (body,) = load_bodies(file, unit="m", material="wood")
    assert body.name == "BOX"
    assert volume_m3([body]) == pytest.approx(6.0)


ROOM_STL = """solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid a
solid b
facet normal 0 0 1
outer loop
vertex 0 0 1
vertex 1 0 1
vertex 0 1 1
endloop
endfacet
endsolid b
"""
QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.stl", ROOM_STL.replace("vertex 1 0 0", "vertex 1 0 x"), "damaged or not complete"),
        ("a.stl", ROOM_STL.replace("normal 0 0 1", "normal 0 zero 1"), ""),
        (
            "a.stl",
            ROOM_STL[: ROOM_STL.index("endsolid b")],
            "6 corners, not all within whole solids",
        ),
        ("a.stl", ROOM_STL.replace("vertex 1 0 1", "vertex 1e200 0 1"), r"beyond 1e\+08"),
        ("a.stl", ROOM_STL.replace("\n", "\0\n"), "cannot be read|holds no triangles"),
        (
            "a.obj",
            QUAD + "f 1 2 99999999999999999999\n",
            "names vertex 99999999999999999999 of only 4",
        ),
        ("a.obj", QUAD + "f 1 2 -99999999999999999999\n", "stands before the first vertex"),
        ("a.obj", QUAD.replace("1 1 0", "1e200 1 0") + "f 1 2 3 4\n", "line 3.*at most 1e"),
        ("a.obj", QUAD.replace("1 1 0", "1e14 1 0") + "f 1 2 3 4\n", r"beyond 1e\+08"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1e200 0 0\n0 1 0\n3 0 1 2\n", r"beyond 1e\+08"),
        ("a.gltf", '{"asset": {"version": "2.0"}, "meshes": 3}', "cannot be read as a GLTF mesh"),
        ("a.gltf", '{"meshes": [{"primitives": [{"attributes": {"POSITION": 7}}]}]}', "damaged"),
        ("a.gltf", '{"nodes": [2], "meshes": [{"primitives": [4]}]}', "damaged"),
        ("a.gltf", '{"extensionsRequired": 1}', "damaged"),
    ],
)
def test_damaged_files_are_refused_in_a_sentence_and_libraries_stay_silent(
    name, text, says, tmp_path, capfd, caplog
):
    """A normal that cannot be read is no loss: Octant takes triangles' own."""
    (tmp_path / name).write_text(text)
    with np.errstate(all="raise"):
        if says:
            with pytest.raises(GeometryError, match=says) as caught:
                load_bodies(tmp_path / name, unit="m", material="wood")
            assert "\n" not in str(caught.value)
        else:
            assert len(load_bodies(tmp_path / name, unit="m", material="wood")) == 2
    assert capfd.readouterr() == ("", "")
    assert not caplog.records
