"""From the study file to the scene: rooms of every kind, materials, antennas in their places."""

from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError, GeometryError
from octant.geometries.furniture import box
from octant.geometries.mesh_files import save_bodies
from octant.geometries.rooms import box_room
from octant.reader_design.setting.placing import place_antenna
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import load_study, parse_study

TAG = '[[tag]]\nid = "a"\nposition_m = [2.0, 0.5, 3.0]\nantenna = "dipole"\n'
BOX = 'name = "x"\n[room]\nbox_m = [7, 7, 3]\norigin_m = [-1, -1, 0]\n'


def built(text, directory=None, layout=None):
    study = parse_study(text, source="s", directory=directory or Path.cwd())
    chosen = None if layout is None else study.layouts[layout]
    return build_setting(study, chosen)


def test_box_room_stands_at_its_origin_and_lifts_heights():
    scene = built(BOX.replace("-1, 0]", "-1, 2]") + TAG.replace("3.0]", "4.5]"))
    np.testing.assert_allclose(scene.scene.bounds_m, [[-1, -1, 2], [6, 6, 5]])
    assert scene.reader_z_m == pytest.approx(2.3)
    assert scene.map_z_m == pytest.approx(2.3)
    assert scene.notes == ()


def test_tags_on_the_ceiling_hang_below_it_and_the_note_says_how_far():
    scene = built(BOX + TAG + "[solver]\nstandoff_m = 0.02\n")
    np.testing.assert_allclose(scene.tag("a").position_m, [2.0, 0.5, 2.98])
    np.testing.assert_allclose(scene.tag("a").given_m, [2.0, 0.5, 3.0])
    np.testing.assert_allclose(scene.tag("a").point_m, [2.0, 0.5])
    (note,) = scene.notes
    assert note == (
        "tag 'a' at (2, 0.5, 3) m lies on a surface and is moved 2 cm off it, to "
        "(2, 0.5, 2.98) m (solver.standoff_m)."
    )


def test_tags_in_the_air_stay_where_they_are():
    scene = built(BOX + TAG.replace("3.0]", "2.9]"))
    np.testing.assert_array_equal(scene.tag("a").position_m, [2.0, 0.5, 2.9])
    assert scene.notes == ()


def test_unknown_tags_are_refused_with_the_nearest():
    with pytest.raises(ConfigError, match="'a'"):
        built(BOX + TAG).tag("A")


def test_tag_antennas_are_cut_for_the_carrier_at_every_channel():
    text = BOX + TAG + "axis = [0, 3, 4]\n[radio]\nchannels_hz = [2.402e9, 2.48e9]\n"
    scene = built(text)
    antennas = scene.tag("a").antennas
    assert [a.frequency_hz for a in antennas] == [2.402e9, 2.48e9]
    assert [r.frequency_hz for r in scene.radios] == [2.402e9, 2.48e9]
    half_wave = 0.5 * 299_792_458.0 / 2.4e9
    assert [a.length_m for a in antennas] == pytest.approx([half_wave, half_wave])
    np.testing.assert_allclose(antennas[0].axis, [0.0, 0.6, 0.8])


def test_each_surface_and_each_object_has_its_own_material():
    text = BOX + (
        'material = {walls = "brick", floor = {name = "concrete", thickness_m = 0.2}, '
        "ceiling = {eps_r = 2.0, sigma_s_per_m = 0.1}}\n"
        '[[room.object]]\nkind = "cylinder"\nradius_m = 0.2\nheight_m = 1\n'
        'position_m = [3, 3, 0]\nmaterial = "pec"\n'
    )
    radio = built(text).radios[0]
    assert [m.name for m in radio.materials][:2] == ["brick", "concrete"]
    assert [m.thickness_m for m in radio.materials] == [None, 0.2, None, None]
    assert radio.materials[2].relative_permittivity(2.4e9).real == 2.0
    assert radio.materials[3].is_pec


def test_l_shaped_rooms_come_from_an_outline_and_doorways_open_them():
    outline = (
        'name = "x"\n[room]\noutline_m = [[0,0],[6,0],[6,3],[3,3],[3,6],[0,6]]\nheight_m = 3\n'
    )
    closed = built(outline).scene
    assert closed.inside_room([[1.0, 5.0, 1.0], [5.0, 5.0, 1.0]]).tolist() == [True, False]
    door = "[[room.doorway]]\nwall = 0\noffset_m = 1.0\nwidth_m = 1.0\nheight_m = 2.0\n"
    opened = built(outline + door).scene
    assert len(closed.shell_corners_m) > 0
    assert len(opened.shell_corners_m) == 0


def test_free_space_has_no_bodies_but_may_hold_objects():
    assert built('name = "x"\n[room]\nfree_space = true\n').scene.bodies == ()
    text = 'name = "x"\n[room]\nfree_space = true\n[[room.object]]\nkind = "cabinet"\n'
    scene = built(text + "size_m = [1, 1, 1]\nposition_m = [1, 1, 0]\nyaw_deg = 90\n").scene
    assert not scene.has_room
    assert [body.name for body in scene.bodies] == ["cabinet 1"]
    np.testing.assert_allclose(scene.bounds_m, [[0, 1, 0], [1, 2, 1]], atol=1e-12)


def test_mesh_rooms_take_materials_by_body_name(tmp_path):
    save_bodies(box_room((4.0, 4.0, 3.0)), tmp_path / "lab.glb")
    text = (
        'name = "x"\n[room]\nmesh = "lab.glb"\norigin_m = [1, 0, 0]\nmaterial = "brick"\n'
        'materials = {floor = "wood"}\n'
    )
    scene = built(text, tmp_path).scene
    labels = {body.name: body.material for body in scene.bodies}
    assert labels == {"walls": "brick", "floor": "wood", "ceiling": "brick"}
    np.testing.assert_allclose(scene.bounds_m, [[1, 0, 0], [5, 4, 3]], atol=1e-6)


def test_several_mesh_files_make_one_room(tmp_path):
    save_bodies(box_room((4.0, 4.0, 3.0)), tmp_path / "shell.obj")
    save_bodies([box((1.0, 1.0, 1.0), material="x")], tmp_path / "block.stl")
    text = (
        'name = "x"\n[[room.mesh]]\nfile = "shell.obj"\nunit = "m"\nmaterial = "concrete"\n'
        '[[room.mesh]]\nfile = "block.stl"\nunit = "m"\nmaterial = "metal"\n'
    )
    scene = built(text, tmp_path).scene
    assert {body.material for body in scene.bodies} == {"concrete", "metal"}
    assert scene.inside_solid([[0.5, 0.5, 0.5]]).tolist() == [True]


def test_units_scale_mesh_objects(tmp_path):
    save_bodies([box((1000.0, 500.0, 250.0), material="x")], tmp_path / "block.stl")
    text = BOX + (
        '[[room.object]]\nkind = "mesh"\nfile = "block.stl"\nunit = "mm"\nmaterial = "metal"\n'
        "position_m = [1, 1, 0]\n"
    )
    body = built(text, tmp_path).scene.bodies[-1]
    np.testing.assert_allclose(body.vertices_m.max(axis=0), [2.0, 1.5, 0.25], atol=1e-6)


def test_missing_units_are_refused_when_the_room_is_built(tmp_path):
    save_bodies(box_room((4.0, 4.0, 3.0)), tmp_path / "lab.stl")
    with pytest.raises(GeometryError, match="unit"):
        built('name = "x"\n[room]\nmesh = "lab.stl"\nmaterial = "wood"\n', tmp_path)


def test_layouts_add_their_objects_to_the_studys_room():
    layout = (
        '[[layout]]\nname = "more"\n[[layout.object]]\nkind = "cabinet"\nsize_m = [1, 1, 1]\n'
        "position_m = [3, 3, 0]\n"
    )
    scene = built(BOX + TAG + layout, layout=0)
    assert scene.name == "more"
    assert scene.scene.inside_solid([[3.5, 3.5, 0.5]]).tolist() == [True]
    assert scene.notes[0].startswith("in layout 'more': tag 'a'")


def test_every_layout_of_the_built_in_study_can_be_used():
    study = load_study("thesis")
    names = [build_setting(study, layout).name for layout in study.layouts]
    assert names == ["non-reverberant", "file-cabinet", "metal-objects"]


def test_antennas_where_two_walls_meet_leave_both():
    scene = built(BOX).scene
    moved, note = place_antenna(scene, (-1.0, 2.0, 3.0), 0.05, name="tag", key="k")
    np.testing.assert_allclose(moved, [-0.95, 2.0, 2.95])
    assert "7.07 cm" in note
