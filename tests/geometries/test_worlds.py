"""Rooms of robots and drawings: DAE, SDF, URDF, map_server, DXF; places, names, and refusals."""

import math

import numpy as np
import pytest
from PIL import Image

from octant.geometries.errors import GeometryError
from octant.geometries.mesh_files import Reading, files_named, load_bodies
from octant.geometries.scene import build_scene

SQUARE = (
    '<geometry id="g" name="sheet"><mesh><source id="p"><float_array id="a" count="12">'
    "0 0 0 2 0 0 2 1 0 0 1 0</float_array><technique_common>"
    '<accessor source="#a" count="4" stride="3"><param name="X" type="float"/>'
    '<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>'
    '</source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
    '<polylist count="1" material="paint"><input semantic="VERTEX" source="#v" offset="0"/>'
    "<vcount>4</vcount><p>0 1 2 3</p></polylist></mesh></geometry>"
)


def dae(*, unit=1.0, up="Z_UP", node='<instance_geometry url="#g"/>', version="1.4.1", more=""):
    return (
        f'<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="{version}">'
        f'<asset><unit meter="{unit}" name="u"/><up_axis>{up}</up_axis></asset>'
        f"<library_geometries>{SQUARE}</library_geometries><library_visual_scenes>"
        f'<visual_scene id="s"><node id="n" name="panel">{node}</node></visual_scene>'
        f'</library_visual_scenes>{more}<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


def room(tmp_path, name, text, **options):
    file = tmp_path / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return load_bodies(file, material="wood", **options)


def normal(body):
    a, b, c = body.triangles_m[0]
    return np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))


# ------------------------------------------------------------------------------ COLLADA


@pytest.mark.parametrize(
    ("up", "low", "high"),
    [
        ("Z_UP", (0, 0, 0), (2, 1, 0)),
        ("Y_UP", (0, 0, 0), (2, 0, 1)),
        ("X_UP", (-1, 0, 0), (0, 0, 2)),  # right -y, up +x (COLLADA 1.4.1, "up_axis")
    ],
)
def test_a_collada_file_stands_upright_in_its_unit(tmp_path, up, low, high):
    (body,) = room(tmp_path, "a.dae", dae(unit=0.01, up=up))
    np.testing.assert_allclose(body.bounds_m, 0.01 * np.array([low, high]), atol=1e-12)
    assert body.name == "panel"


def test_a_mirrored_node_keeps_its_face_to_the_outside(tmp_path):
    turned = '<scale>1 1 -1</scale><translate>0 0 1</translate><instance_geometry url="#g"/>'
    (body,) = room(tmp_path, "a.dae", dae(node=turned))
    assert body.bounds_m[0, 2] == -1.0
    np.testing.assert_allclose(normal(body), (0.0, 0.0, -1.0), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (dae()[:-90], "cannot be read as a COLLADA file"),
        (dae(version="1.3"), r"COLLADA 1\.3, but 1\.4 and 1\.5"),
        (dae(node='<instance_geometry url="http://a/b.dae#g"/>'), "refers to 'http"),
        (dae(node='<instance_geometry url="../b.dae#g"/>'), "refers to"),
        (dae(node='<instance_geometry url="#h"/>'), "cannot be read as COLLADA"),
        (dae(node='<instance_controller url="#g"/>'), "skinned"),
        (dae(unit=-1), "positive length"),
        ('<!DOCTYPE a [<!ENTITY e "x">]>' + dae(), "DOCTYPE"),
    ],
)
def test_a_bad_collada_file_is_refused_in_one_sentence(tmp_path, text, said):
    with pytest.raises(GeometryError, match=said):
        room(tmp_path, "a.dae", text)


def test_without_pycollada_a_sentence_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "collada", None)
    with pytest.raises(GeometryError, match=r'pip install "octant\[worlds\]"'):
        room(tmp_path, "a.dae", dae())


# ------------------------------------------------------------------------------ SDF


def sdf(inside, version="1.7"):
    return f'<sdf version="{version}">{inside}</sdf>'


def link(geometry, pose="0 0 0 0 0 0", kind="visual", name="v"):
    part = f'<{kind} name="{name}"><geometry>{geometry}</geometry></{kind}>'
    return f'<link name="l"><pose>{pose}</pose>{part}</link>'


BOX = "<box><size>2 4 6</size></box>"


@pytest.fixture
def world(tmp_path):
    """A world with a nested include, a scaled and mirrored DAE and a ground plane."""
    (tmp_path / "models/panel/meshes").mkdir(parents=True)
    (tmp_path / "models/panel/meshes/panel.dae").write_text(dae(unit=0.5, up="Y_UP"))
    (tmp_path / "models/panel/model.config").write_text(
        '<model><name>panel</name><sdf version="1.4">old.sdf</sdf>'
        '<sdf version="1.6">model-1_6.sdf</sdf></model>'
    )
    mesh = "<mesh><uri>model://panel/meshes/panel.dae</uri><scale>2 2 -2</scale></mesh>"
    (tmp_path / "models/panel/model-1_6.sdf").write_text(
        sdf(f'<model name="panel"><pose>9 9 9 0 0 0</pose>{link(mesh)}</model>', "1.6")
    )
    (tmp_path / "models/pair").mkdir()
    pair = (
        '<model name="pair"><include><uri>model://panel</uri><name>a</name>'
        "<pose>0 0 1 0 0 1.570796</pose></include><include><uri>model://panel</uri>"
        "<name>b</name></include></model>"
    )
    (tmp_path / "models/pair/model.sdf").write_text(sdf(pair))
    (tmp_path / "worlds").mkdir()
    return (
        "<world name='w'><include><uri>model://sun</uri></include>"
        "<include><uri>model://ground_plane</uri></include>"
        f"<model name='crate'><pose>1 2 3 0 0 0</pose>{link(BOX, '0 0 0 0 0 1.5707963')}</model>"
        "<include><uri>model://pair</uri><pose>5 0 0 0 0 0</pose></include></world>"
    )


def test_a_world_stands_where_its_includes_and_poses_put_it(tmp_path, world):
    bodies = {b.name: b for b in room(tmp_path, "worlds/w.world", sdf(world))}
    assert set(bodies) == {"ground_plane", "crate", "pair.a", "pair.b"}
    np.testing.assert_allclose(bodies["crate"].bounds_m, [(-1, 1, 0), (3, 3, 6)], atol=1e-6)
    # 2 x 1 units of 0.5 m, twice as large, a quarter turn at (5, 0, 1)
    np.testing.assert_allclose(bodies["pair.a"].bounds_m, [(4, 0, 1), (5, 2, 1)], atol=1e-6)
    np.testing.assert_allclose(bodies["pair.b"].bounds_m, [(14, 9, 9), (16, 10, 9)], atol=1e-6)
    np.testing.assert_allclose(normal(bodies["pair.a"]), (0, 0, -1), atol=1e-6)  # mirrored
    # The plane ends a metre beyond everything else.
    ground = bodies["ground_plane"].bounds_m
    np.testing.assert_allclose(ground, [(-2, -1, 0), (17, 11, 0)], atol=1e-6)
    names = {file.name for file in files_named(tmp_path / "worlds/w.world")}
    assert names == {"model.sdf", "model-1_6.sdf", "panel.dae"}


def test_visual_and_collision_are_told_apart(tmp_path):
    small = link("<box><size>1 1 1</size></box>", kind="collision").replace(
        "</link>", link(BOX)[link(BOX).index("<visual") :]
    )
    text = sdf(f"<model name='m'>{small}</model>")
    heights = [
        float(
            np.ptp(room(tmp_path, "m.sdf", text, reading=Reading(geometry=kind))[0].bounds_m[:, 2])
        )
        for kind in ("visual", "collision")
    ]
    assert heights == [6.0, 1.0]


@pytest.mark.parametrize(
    ("geometry", "size"),
    [
        (BOX, (2, 4, 6)),
        ("<sphere><radius>2</radius></sphere>", (4, 4, 4)),
        ("<cylinder><radius>1</radius><length>3</length></cylinder>", (2, 2, 3)),
        ("<capsule><radius>1</radius><length>3</length></capsule>", (2, 2, 5)),
        ("<ellipsoid><radii>1 2 3</radii></ellipsoid>", (2, 4, 6)),
        ("<cone><radius>1</radius><length>3</length></cone>", (2, 2, 3)),
        ("<plane><normal>1 0 0</normal><size>2 3</size></plane>", (0, 2, 3)),
    ],
)
def test_each_simple_geometry_has_its_size_about_its_origin(tmp_path, geometry, size):
    (body,) = room(tmp_path, "m.sdf", sdf(f"<model name='m'>{link(geometry)}</model>"))
    span = np.ptp(body.bounds_m, axis=0)
    np.testing.assert_allclose(np.sort(span), np.sort(size), atol=0.06)
    np.testing.assert_allclose(body.bounds_m.sum(axis=0), 0.0, atol=0.06)


def test_poses_may_be_relative_to_frames_in_degrees(tmp_path):
    text = sdf(
        "<model name='m'><frame name='f'><pose degrees='true'>1 0 0 0 0 90</pose></frame>"
        f"<link name='l'><pose relative_to='f'>2 0 0 0 0 0</pose>"
        f"<visual name='v'><geometry>{BOX}</geometry></visual></link></model>",
        "1.9",
    )
    (body,) = room(tmp_path, "m.sdf", text)
    np.testing.assert_allclose(body.bounds_m, [(-1, 1, -3), (3, 3, 3)], atol=1e-9)


MESH = "<mesh><uri>{}</uri></mesh>"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (sdf("<world name='w'/>"), "holds no visual geometry"),
        (sdf("<world name='w'/>", "0.9"), r"SDF 0\.9, but 1\.3 to 1\.12"),
        (sdf("<world name='w'><model")[:-3], "cannot be read as an SDF file"),
        (
            sdf("<world name='w'><include><uri>https://fuel/x</uri></include></world>"),
            "include.* https://fuel/x, line 1: .*address on a network.*gz fuel",
        ),
        (
            sdf("<world name='w'><include><uri>model://chair</uri></include></world>"),
            r"w\.world > <include> model://chair, line 1: .*does not exist.*resource_path",
        ),
        (
            sdf(f"<model name='m'>{link(MESH.format('../../secret.stl'))}</model>"),
            "leads out of the folders",
        ),
        (
            sdf(f"<model name='m'>{link(MESH.format('file:///etc/hostname'))}</model>"),
            "leads out of the folders",
        ),
        (sdf(f"<model name='m'>{link(MESH.format('no.stl'))}</model>"), r"w\.world > m: 'no\.stl'"),
        (sdf(f"<model name='m'>{link('<heightmap/>')}</model>"), "<heightmap> .* is not read"),
        (sdf(f"<model name='m'>{link(BOX, '0 0 nan 0 0 0')}</model>"), "6 finite number"),
        (sdf(f"<model name='m'>{link(BOX, '0 0')}</model>"), "6 finite number"),
        ("<robot/>", "starts with <robot>"),
    ],
)
def test_a_bad_world_is_refused_with_the_chain_that_led_there(tmp_path, text, said):
    with pytest.raises(GeometryError, match=said):
        room(tmp_path / "a", "w.world", text)


def test_a_mesh_that_an_included_model_lacks_is_named_with_the_includes(tmp_path, world):
    (tmp_path / "models/panel/meshes/panel.dae").unlink()
    said = (
        r"w\.world > <include> model://pair.* > <include> model://panel.* > pair\.a: .*panel\.dae"
    )
    with pytest.raises(GeometryError, match=said):
        room(tmp_path, "worlds/w.world", sdf(world))


def test_models_that_include_themselves_are_refused(tmp_path):
    text = "<model name='m'><include><uri>m.sdf</uri></include></model>"
    with pytest.raises(GeometryError, match="without end"):
        room(tmp_path, "m.sdf", sdf(text))


def test_a_resource_path_is_searched_by_key_and_by_environment(tmp_path, world, monkeypatch):
    (tmp_path / "models").rename(tmp_path / "elsewhere")
    text, folder = sdf(world), str(tmp_path / "elsewhere")
    with pytest.raises(GeometryError, match="model://pair"):
        room(tmp_path, "worlds/w.world", text)
    options = {"reading": Reading(resource_path=(folder,))}
    assert len(room(tmp_path, "worlds/w.world", text, **options)) == 4
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", folder)
    assert len(room(tmp_path, "worlds/w.world", text)) == 4


# ------------------------------------------------------------------------------ URDF


def test_links_of_a_urdf_stand_where_their_joints_put_them(tmp_path):
    (tmp_path / "sheet.dae").write_text(dae())
    text = (
        "<robot name='r'><link name='base'/><link name='arm'><visual><origin xyz='0 0 1'/>"
        "<geometry><mesh filename='sheet.dae' scale='1 -1 1'/></geometry></visual></link>"
        "<joint name='j' type='fixed'><origin xyz='1 0 0' rpy='0 0 3.14159265'/>"
        "<parent link='base'/><child link='arm'/></joint></robot>"
    )
    (body,) = room(tmp_path, "r.urdf", text)
    assert body.name == "arm"
    np.testing.assert_allclose(body.bounds_m, [(-1, 0, 1), (1, 1, 1)], atol=1e-9)
    np.testing.assert_allclose(normal(body), (0, 0, 1), atol=1e-9)
    with pytest.raises(GeometryError, match="the link 'no'"):
        room(tmp_path, "r.urdf", text.replace("parent link='base'", "parent link='no'"))
    macro = text.replace("<robot ", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro' ")
    with pytest.raises(GeometryError, match="xacro xacro"):
        room(tmp_path, "r.urdf", macro.replace("<link name='base'/>", "<xacro:link/>"))


# ------------------------------------------------------------------------------ floor plans


def plan(tmp_path, cells, *, name="map.pgm", yaml=None, **options):
    Image.fromarray(np.asarray(cells, dtype=np.uint8)).save(tmp_path / name)
    header = yaml or f"image: {name}\nresolution: 0.1\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n"
    return {b.name: b for b in room(tmp_path, "map.yaml", header, **options)}


def box_map(nx=40, ny=30):
    cells = np.full((ny, nx), 254)
    cells[[0, -1]] = 0
    cells[:, [0, -1]] = 0
    return cells


@pytest.mark.parametrize("name", ["map.pgm", "map.png"])
def test_a_map_becomes_walls_of_few_faces_on_its_free_floor(tmp_path, name):
    bodies = plan(tmp_path, box_map(), name=name, reading=Reading(height_m=3.0))
    np.testing.assert_allclose(bodies["walls"].bounds_m, [(-1, 2, 0), (3, 5, 3)], atol=1e-9)
    np.testing.assert_allclose(bodies["floor"].bounds_m, [(-0.9, 2.1, 0), (2.9, 4.9, 0)], atol=1e-9)
    assert len(bodies["walls"].faces) == 2 * 8  # inner and outer rectangle, not one box a cell
    assert bodies["floor"].area_m2 == pytest.approx(3.8 * 2.8)
    inside = build_scene(list(bodies.values())).inside_room([(0, 3, 1), (-0.95, 3, 1)])
    assert inside.tolist() == [True, False]


def test_an_oblique_wall_of_stairs_becomes_one_line(tmp_path):
    cells = box_map(120, 120)
    for i in range(20, 100):
        cells[i, i : i + 3] = 0
    walls = plan(tmp_path, cells)["walls"]
    # The stairs have 160 sides a side; the room has 8 sides, a straight bar 4 to 8.
    assert len(walls.faces) <= 2 * (8 + 10)


def test_the_first_row_of_a_map_is_the_farthest_along_y(tmp_path):
    cells = box_map()
    cells[2:4, 5:8] = 0
    walls = plan(tmp_path, cells)["walls"]
    block = walls.triangles_m[:, 0, :2]
    near = block[(block[:, 0] > -0.6) & (block[:, 0] < -0.1) & (block[:, 1] < 4.89)]
    np.testing.assert_allclose(near[:, 1].max(), 4.8)


def test_outlines_enclose_the_area_of_their_cells(tmp_path):
    rng = np.random.default_rng(3)
    cells = np.where(rng.random((20, 25)) < 0.4, 0, 254)
    walls = plan(tmp_path, cells)["walls"]
    foot = walls.triangles_m[0::2]  # one triangle a wall, with its foot as first side
    a, b = foot[:, 0, :2] - (-1.0, 2.0), foot[:, 1, :2] - (-1.0, 2.0)
    area = 0.5 * np.sum(a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1])
    assert area == pytest.approx(0.01 * (cells == 0).sum(), rel=0.1)


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("image: map.pgm\n", "lacks resolution, origin"),
        ("image: ../map.pgm\nresolution: 0.1\norigin: [0,0,0]\n", "must lie beside it"),
        ("image: http://a/map.pgm\nresolution: 0.1\norigin: [0,0,0]\n", "must lie beside it"),
        ("image: no.pgm\nresolution: 0.1\norigin: [0,0,0]\n", r"map\.yaml > no\.pgm: .*not exist"),
        ("image: map.pgm\nresolution: x\norigin: [0,0,0]\n", "resolution is 'x'"),
        ("image: map.pgm\nresolution: 0.1\norigin: [0,0]\n", "3 number"),
        ("image: map.pgm\nresolution: -1\norigin: [0,0,0]\n", "resolution -1 m"),
        ("image: map.yaml\nresolution: 1\norigin: [0,0,0]\n", "cannot be read as an image"),
        (
            "image: map.pgm\nresolution: 1\norigin: [0,0,0]\nnegate: 1\noccupied_thresh: 1\n",
            "no wall",
        ),
    ],
)
def test_a_bad_map_is_refused_in_one_sentence(tmp_path, header, said):
    with pytest.raises(GeometryError, match=said):
        plan(tmp_path, box_map(), yaml=header)


def dxf(unit=4):
    legs = [(0, 0, 4000, 0), (4000, 0, 4000, 3000), (4000, 3000, 0, 3000), (0, 3000, 0, 0)]
    entity = "0\nLINE\n8\nwalls\n10\n{}\n20\n{}\n30\n0\n11\n{}\n21\n{}\n31\n0\n"
    lines = "".join(entity.format(*leg) for leg in legs)
    head = f"0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{unit}\n0\nENDSEC\n"
    return f"{head}0\nSECTION\n2\nENTITIES\n{lines}0\nENDSEC\n0\nEOF\n"


def test_a_drawing_becomes_walls_in_its_unit(tmp_path):
    bodies = {b.name: b for b in room(tmp_path, "a.dxf", dxf(), reading=Reading(height_m=2.8))}
    np.testing.assert_allclose(bodies["walls"].bounds_m, [(0, 0, 0), (4, 3, 2.8)], atol=1e-9)
    assert bodies["floor"].area_m2 == pytest.approx(4.1 * 3.1)
    with pytest.raises(GeometryError, match=r"says no unit \(\$INSUNITS\)"):
        room(tmp_path, "a.dxf", dxf(0))
    with pytest.raises(GeometryError, match="DXF"):
        room(tmp_path, "a.dxf", dxf()[:70])


def test_doors_and_windows_of_a_drawing_are_open(tmp_path):
    entity = "0\nLINE\n8\n{}\n10\n{}\n20\n0\n30\n0\n11\n{}\n21\n0\n31\n0\n"
    swing = "0\nARC\n8\nA-DOOR\n10\n1000\n20\n0\n40\n900\n50\n0\n51\n90\n"
    more = entity.format("A-DOOR", 1000, 1900) + entity.format("Windows", 2500, 3500) + swing
    text = dxf().replace("0\nENDSEC\n0\nEOF", more + "0\nENDSEC\n0\nEOF")
    bodies = {b.name: b for b in room(tmp_path, "a.dxf", text, reading=Reading(height_m=2.8))}
    assert set(bodies) == {
        "walls", "a-door lintel", "windows parapet", "windows lintel", "floor",
    }  # fmt: skip
    for name, low, high in (
        ("a-door lintel", (1.0, 2.0), (1.9, 2.8)),
        ("windows parapet", (2.5, 0.0), (3.5, 0.9)),
        ("windows lintel", (2.5, 2.1), (3.5, 2.8)),
    ):
        np.testing.assert_allclose(bodies[name].bounds_m[:, [0, 2]], [low, high], atol=1e-9)
    low = {b.name for b in room(tmp_path, "a.dxf", text, reading=Reading(height_m=2.0))}
    assert "a-door lintel" not in low


@pytest.mark.parametrize(
    ("name", "said"),
    [("a.ifc", "IfcConvert"), ("a.png", "give room.metres_per_pixel"), ("a.gif", "PNG"),
     ("a.xacro", "ros2 run xacro"),
     ("a.fbx", "Blender"), ("a.pcd", "point cloud"), ("a.gbl", r"did you mean '\.glb'")],
)  # fmt: skip
def test_what_is_no_mesh_is_refused_with_what_converts_it(tmp_path, name, said):
    with pytest.raises(GeometryError, match=said):
        room(tmp_path, name, "x")


@pytest.mark.parametrize("suffix", ["png", "jpg", "bmp"])
def test_a_picture_with_a_scale_is_the_room_within_its_dark_lines(tmp_path, suffix):
    cells = np.pad(box_map(), 10, constant_values=254)  # a margin, which is no floor
    Image.fromarray(cells.astype(np.uint8)).save(tmp_path / f"plan.{suffix}", quality=95)
    bodies = {
        b.name: b
        for b in load_bodies(
            tmp_path / f"plan.{suffix}",
            material="wood",
            reading=Reading(height_m=3.0, metres_per_pixel=0.1),
        )
    }
    np.testing.assert_allclose(bodies["walls"].bounds_m, [(1, 1, 0), (5, 4, 3)], atol=1e-9)
    np.testing.assert_allclose(bodies["floor"].bounds_m, [(1.1, 1.1, 0), (4.9, 3.9, 0)], atol=1e-9)
    assert bodies["floor"].area_m2 == pytest.approx(3.8 * 2.8)
    (tmp_path / f"plan.{suffix}").write_bytes(b"cut")
    with pytest.raises(GeometryError, match="cannot be read as an image"):
        load_bodies(
            tmp_path / f"plan.{suffix}", material="wood", reading=Reading(metres_per_pixel=0.1)
        )


def test_a_turned_map_is_turned_about_its_origin(tmp_path):
    yaml = f"image: map.pgm\nresolution: 0.1\norigin: [0, 0, {math.pi / 2}]\n"
    bounds = plan(tmp_path, box_map(), yaml=yaml)["walls"].bounds_m
    np.testing.assert_allclose(bounds[:, :2], [(-3, 0), (0, 4)], atol=1e-9)
