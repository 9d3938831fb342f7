"""Studies drafted from meshes as different as people have: what is guessed, and that it drives."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from robot_worlds import warehouse

from octant.geometries.bodies import Body
from octant.geometries.errors import ConfigError
from octant.geometries.furniture import box, cabinet
from octant.geometries.guesses import guess_frame, odd_shape
from octant.geometries.material_names import guess_material, known_as
from octant.geometries.mesh_files import frame_of, save_bodies
from octant.geometries.rooms import box_room
from octant.reader_design.drafting.draft import draft_study
from octant.reader_design.drafting.floor import floor_level_m
from octant.reader_design.drafting.picture import plan_picture
from octant.reader_design.setting.robot import mission_space

SIZE = (6.0, 4.0, 2.8)


def sheet(name, corners):
    return Body(
        name=name,
        vertices_m=np.array(corners, dtype=float),
        faces=np.array([(0, 1, 2), (0, 2, 3)]),
        material="m",
    )


def level(name, x, y, z=0.0):
    return sheet(name, [(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)])


def office(*, ceiling=True):
    walls = [b for b in box_room(SIZE, material="m") if ceiling or b.name != "ceiling"]
    pane = sheet("window 1", [(3, 2.5, 0.9), (3, 4, 0.9), (3, 4, 2.0), (3, 2.5, 2.0)])
    shelf = cabinet((1.5, 0.4, 1.8), position_m=(4, 3.4, 0), material="m", name="cabinet")
    return [*walls, pane, shelf]


def turned(bodies, scale=1.0):
    return [
        replace(b, vertices_m=scale * b.vertices_m[:, [0, 2, 1]] * (1.0, 1.0, -1.0)) for b in bodies
    ]


def one_body(tmp_path):
    save_bodies(office(), tmp_path / "room.stl")
    return "room.stl"


def open_above(tmp_path):
    save_bodies(office(ceiling=False), tmp_path / "room.obj")
    return "room.obj"


def y_up_in_millimetres(tmp_path):
    save_bodies(turned(office(), 1000.0), tmp_path / "room.obj")
    return "room.obj"


def only_a_floor(tmp_path):
    save_bodies([level("floor", 4, 3)], tmp_path / "room.ply")
    return "room.ply"


def only_a_slab(tmp_path):
    save_bodies([box((8, 6, 0.2), material="m", name="slab")], tmp_path / "room.obj")
    return "room.obj"


def outdoors(tmp_path):
    houses = [box((20, 15, 12), position_m=(5, 5, 0), material="m", name="building a")]
    save_bodies([level("ground", 40, 40), *houses], tmp_path / "room.obj")
    return "room.obj"


def scan_with_holes(tmp_path):
    import trimesh

    parts = [trimesh.Trimesh(b.vertices_m, b.faces) for b in box_room((4, 3, 2.5), material="m")]
    whole = trimesh.util.concatenate(parts).subdivide().subdivide().subdivide()
    rng = np.random.default_rng(1)
    kept = whole.faces[rng.random(len(whole.faces)) > 0.03]
    noisy = whole.vertices + rng.normal(scale=0.003, size=whole.vertices.shape)
    trimesh.Trimesh(noisy, kept, process=False).export(str(tmp_path / "room.ply"))
    return "room.ply"


def sionna(tmp_path):
    save_bodies(box_room(SIZE, material="m")[:1], tmp_path / "walls.ply")
    save_bodies([level("floor", 3, 2)], tmp_path / "floor.ply")
    shape = (
        '<shape type="ply" id="mesh-{0}"><string name="filename" value="{0}.ply"/>{2}'
        '<ref id="mat-itu_{1}" name="bsdf"/></shape>'
    )
    shift = '<transform name="to_world"><translate x="3" y="2"/></transform>'
    bsdfs = "".join(f'<bsdf type="diffuse" id="mat-itu_{m}"/>' for m in ("brick", "wood"))
    text = shape.format("walls", "brick", "") + shape.format("floor", "wood", shift)
    (tmp_path / "room.xml").write_text(f'<scene version="2.1.0">{bsdfs}{text}</scene>')
    return "room.xml"


def gazebo(tmp_path):
    import trimesh
    from trimesh.exchange.dae import export_collada

    (tmp_path / "models/room").mkdir(parents=True)
    meshes = [trimesh.Trimesh(b.vertices_m, b.faces) for b in office(ceiling=False)]
    (tmp_path / "models/room/room.dae").write_bytes(export_collada(meshes))
    (tmp_path / "models/room/model.sdf").write_text(
        "<sdf version='1.7'><model name='room'><link name='l'><visual name='v'><geometry><mesh>"
        "<uri>model://room/room.dae</uri></mesh></geometry></visual></link></model></sdf>"
    )
    (tmp_path / "room.world").write_text(
        "<sdf version='1.6'><world name='w'><include><uri>model://ground_plane</uri></include>"
        "<include><uri>model://room</uri><pose>10 0 0 0 0 0</pose></include></world></sdf>"
    )
    return "room.world"


def map_server(tmp_path):
    from PIL import Image

    cells = np.full((60, 80), 254, dtype=np.uint8)
    cells[[0, -1]] = 0
    cells[:, [0, -1]] = 0
    Image.fromarray(cells).save(tmp_path / "room.pgm")
    text = "image: room.pgm\nresolution: 0.05\norigin: [-1, -2, 0]\n"
    (tmp_path / "room.yaml").write_text(text)
    return "room.yaml"


@pytest.mark.parametrize(
    "make",
    [
        one_body, open_above, y_up_in_millimetres, only_a_floor, only_a_slab, outdoors,
        scan_with_holes, sionna, gazebo, map_server,
    ],
)  # fmt: skip
def test_a_draft_of_any_room_has_tags_and_a_start_that_can_be_driven(tmp_path, make):
    draft = draft_study(tmp_path / make(tmp_path), tmp_path / "room.toml")
    setting = draft.setting  # built: tags and start are inside, and in no body
    mission = setting.mission
    assert mission.navigator == "tracker"
    assert len(setting.study.radio.channels_hz) == 4
    space = mission_space(setting.study, setting.scene)
    way = [mission.start_m, *(tag.position_m[:2] for tag in setting.tags)]
    legs = [np.linspace(a, b, 20) for a, b in itertools.pairwise(way)]
    assert space(np.concatenate(legs)).all()
    assert all(tag.antenna == "conical_patch" for tag in setting.study.tags)
    floor = setting.scene.floor_height_m
    assert all(0.8 <= tag.position_m[2] - floor <= 4.0 for tag in setting.tags)


def test_every_body_has_a_line_with_the_reason_for_its_material(tmp_path):
    text = draft_study(tmp_path / open_above(tmp_path), tmp_path / "room.toml").text
    assert "cabinet = \"metal\"   # guessed from 'cabinet'" in text
    pane = '"window 1" = { name = "glass", thickness_m = 0.006 }   # guessed from \'window\''
    assert pane in text
    assert "transmission = true" in text  # through the pane; what closes the room is opaque
    assert "walls = \"concrete\"   # guessed from 'wall'" in text
    own = draft_study(tmp_path / sionna(tmp_path), tmp_path / "xml.toml").text
    assert 'walls = "brick"   # from the file' in own


def test_very_many_faces_are_searched_by_rays_and_that_is_said(tmp_path, monkeypatch):
    monkeypatch.setattr("octant.reader_design.drafting.draft.MANY_FACES", 10)
    draft = draft_study(tmp_path / open_above(tmp_path), tmp_path / "room.toml")
    assert draft.setting.solver.search == "rays"
    assert any("too many to search every path" in line for line in draft.said)


def test_a_dense_room_is_drawn_from_above_with_tags_and_start(tmp_path):
    draft = draft_study(tmp_path / open_above(tmp_path), tmp_path / "room.toml")
    (axes,) = plan_picture(draft.setting).axes
    assert axes.get_xlabel()
    assert [text.get_text().strip() for text in axes.texts][:2] == ["1", "2"]
    assert axes.get_legend() is not None


def test_a_mesh_without_a_floor_is_refused_with_what_to_do(tmp_path):
    save_bodies([sheet("wall", [(0, 0, 0), (4, 0, 0), (4, 0, 3), (0, 0, 3)])], tmp_path / "a.obj")
    with pytest.raises(ConfigError, match=r"no level floor.*add a floor"):
        draft_study(tmp_path / "a.obj", tmp_path / "a.toml")
    low = box_room((0.6, 0.6, 2.5), material="m")
    save_bodies(low, tmp_path / "b.obj")
    with pytest.raises(ConfigError, match=r"no way of 0\.8 m"):
        draft_study(tmp_path / "b.obj", tmp_path / "b.toml")


def test_the_floor_is_the_top_of_a_slab_and_no_table():
    from octant.geometries.scene import build_scene

    slab = box((8, 6, 0.25), position_m=(-4, -3, -0.25), material="m", name="slab")
    table = box((3, 2, 0.05), position_m=(0, 0, 0.7), material="m", name="table")
    assert floor_level_m(build_scene([slab, table])) == 0.0


# ------------------------------------------------------------------------------ guesses


@pytest.mark.parametrize(
    ("size", "declared", "up", "expected"),
    [
        ((8, 6, 2.8), None, None, ("m", "z")),
        ((8000, 2800, 6000), None, None, ("mm", "y")),
        ((800, 600, 280), None, None, ("cm", "z")),
        ((8, 2.8, 6), 1.0, "y", (None, "y")),
        ((8, 6, 2.8), 1.0, "y", (None, "z")),  # 6 m high and 2.8 m wide, were y up
        ((20, 30, 10), None, None, ("m", "z")),
        ((8000, 2800, 6000), 1.0, "y", ("mm", "y")),  # an exporter that forgot the unit
        ((20, 2.8, 2), 1.0, "y", (None, "y")),  # a corridor, 2 m wide
    ],
)
def test_unit_and_axis_follow_from_the_size_of_rooms(size, declared, up, expected):
    corners = np.array([(0.0, 0.0, 0.0), size])
    guess = guess_frame([("room", corners)], declared_m=declared, declared_up=up, says="glTF")
    assert (guess.unit, guess.up) == expected
    assert guess.unit_reason
    assert guess.up_reason


def test_a_flat_body_called_floor_says_which_axis_is_up(tmp_path):
    save_bodies([replace(b, material="m") for b in turned(office())], tmp_path / "a.obj")
    guess = frame_of(tmp_path / "a.obj")
    assert (guess.up, guess.against) == ("y", True)
    assert guess.up_reason == "body 'floor' is flat along y, though z is usual in OBJ"


def test_a_room_that_lies_on_its_side_is_remarked():
    assert odd_shape((8.0, 2.8, 6.0)) == "6 m high and 2.8 m wide"
    assert odd_shape((8.0, 6.0, 2.8)) == ""


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Glass_door.001", "glass"), ("door leaf", "wood"), ("DeskTop", "chipboard"),
        ("filing-cabinet", "metal"), ("partition_2", "plasterboard"), ("Wall.North", "concrete"),
        ("SteelBeam", None), ("steel_beam", "metal"), ("Object_12", None),
    ],
)  # fmt: skip
def test_names_of_bodies_suggest_materials(name, expected):
    found = guess_material(name)
    assert (found and found[0]) == expected


def test_other_words_for_materials_lead_to_those_of_the_table():
    from octant.em.medium.materials import material
    from octant.geometries.errors import MaterialRangeError

    for word, name in (("gypsum", "plasterboard"), ("stainless steel", "metal")):
        assert known_as(word) == name
        with pytest.raises(MaterialRangeError, match=f"did you mean '{name}'"):
            material(word)


def test_a_slab_s_floor_is_its_top_though_furniture_begins_below_it(tmp_path):
    draft = draft_study(warehouse(tmp_path), tmp_path / "warehouse.toml")  # refuses a bad start
    # 12.4 cm of slab, set 9.0092 cm deep: walls and racks begin at zero, inside it
    assert draft.setting.scene.floor_height_m == pytest.approx(0.124 - 0.090092, abs=1e-3)
