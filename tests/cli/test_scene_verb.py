"""``octant scene``: the room as GLB, for viewers and as a mesh again, and as a picture."""

import numpy as np
import pytest
import trimesh

from octant.geometries.mesh_files import load_bodies
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import load_study

ROOM = """
name = "two rooms"
[room]
outline_m = [[0, 0], [5, 0], [5, 2], [2, 2], [2, 4], [0, 4]]
height_m = 3.0
material = { walls = { name = "concrete", thickness_m = 0.1 }, floor = "wood", ceiling = "glass" }
[[room.object]]
kind = "cabinet"
size_m = [0.5, 0.35, 1.0]
position_m = [1.3, 0.7, 0.0]
[[room.object]]
kind = "cabinet"
size_m = [0.4, 0.3, 1.0]
position_m = [3.1, 0.9, 0.1]
[[tag]]
id = "A"
position_m = [1.0, 3.0, 2.9]
antenna = "dipole"
[mission]
navigator = "thesis"
start_m = [0.5, 0.5]
tags = ["A"]
"""
ENDS = ("--tx", "4,1,2.5", "--rx", "1,1.5,0.5")


def test_glb_of_a_room_is_the_room_again(octant, study_file, tmp_path):
    study, glb = study_file(ROOM), tmp_path / "room.glb"
    call = octant("scene", study, "--glb", glb)
    assert call.code == 0, call.err
    bodies = build_setting(load_study(study)).scene.bodies
    back = load_bodies(glb)
    assert [(b.name, b.material) for b in back] == [(b.name, b.material) for b in bodies]
    for one, other in zip(back, bodies, strict=True):
        np.testing.assert_array_equal(one.vertices_m, other.vertices_m.astype(np.float32))
        np.testing.assert_array_equal(one.faces, other.faces)
    again = study_file('[room]\nmesh = "room.glb"\n', "again.toml")
    paths = [octant("paths", s, *ENDS, "-q").out for s in (study, again)]
    # The same paths; the cabinets' float32 coordinates move levels by 1e-4 dB at most.
    assert [line.split()[:5] for line in paths[0].splitlines()[:2]] == [
        line.split()[:5] for line in paths[1].splitlines()[:2]
    ]


def test_the_scene_goes_to_a_folder_and_the_same_again_is_complete(
    octant, study_file, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    study = study_file(ROOM)
    first, again = octant("scene", study), octant("scene", study)
    files = [tmp_path / "octant-scene" / name for name in ("scene.glb", "scene.png")]
    assert first.out == "written: octant-scene/scene.glb and octant-scene/scene.png\n"
    assert all(file.stat().st_size > 1000 for file in files)
    assert (again.code, again.out) == (0, first.out)
    assert "complete already" in again.err
    other = octant("scene", study, "--azimuth-deg", "10").refused()
    assert "scene.png exists already" in other
    assert octant("scene", study, "--azimuth-deg", "10", "--force").code == 0


def test_glb_with_paths_holds_tubes_from_end_to_end(octant, study_file, tmp_path):
    glb = tmp_path / "paths.glb"
    call = octant("scene", study_file(ROOM), "--glb", glb, *ENDS, "--strongest", 5)
    assert call.out.startswith("5 strongest of ")
    bodies = {b.name: b for b in load_bodies(glb)}
    tubes = [b for name, b in bodies.items() if name.startswith("path ")]
    assert len(tubes) == 5
    assert [int(name.split()[1].strip(",")) for name in bodies if name.startswith("path")] == [
        *range(1, 6)
    ]
    for tube in tubes:
        legs = len(tube.faces) // 12
        assert tube.material == f"path of order {legs - 1}"
        for place in ((4.0, 1.0, 2.5), (1.0, 1.5, 0.5)):
            near = np.linalg.norm(tube.vertices_m - place, axis=1).min()
            assert near < 0.01
    assert bodies["transmitter"].bounds_m.mean(axis=0) == pytest.approx((4, 1, 2.5), abs=1e-6)


@pytest.mark.parametrize("colour", ["gain", "order"])
def test_picture_is_written_whole(octant, study_file, tmp_path, colour):
    picture = tmp_path / "room.png"
    call = octant("scene", study_file(ROOM), "--picture", picture, *ENDS, "--colour-by", colour)
    assert call.code == 0, call.err
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_place_without_paths_is_shown_without_paths(octant, study_file, tmp_path):
    picture = tmp_path / "room.png"
    call = octant(
        "scene", study_file(ROOM), "--picture", picture, "--tx", "1,3.9,2", "--rx", "4,0.1,1",
        "--max-reflections", 0,
    )  # fmt: skip
    assert call.code == 0, call.err
    assert call.out.startswith("0 strongest of 0 paths")


def test_free_space_has_a_picture_too(octant, study_file, tmp_path):
    picture = tmp_path / "free.png"
    study = study_file("[room]\nfree_space = true\n")
    call = octant("scene", study, "--picture", picture, "--tx", "0,0,2", "--rx", "3,0,1")
    assert call.code == 0, call.err
    assert "there is no body" in octant("scene", study, "--glb", tmp_path / "x.glb").refused()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--glb", "room.obj"), "a .glb file"),
        (("--picture", "room.jpg"), "a .png file"),
        (("--picture", "p.png", "--tx", "1,1,1"), "both ends"),
        (("--picture", "p.png", "--elevation-deg", "-5"), "above 0"),
        (("--picture", "p.png", "--colour-by", "delay"), "delay"),
    ],
)
def test_what_cannot_be_shown_is_refused(
    octant, study_file, tmp_path, monkeypatch, arguments, says
):
    monkeypatch.chdir(tmp_path)
    assert says in octant("scene", study_file(ROOM), *arguments).refused()
    assert not (tmp_path / "p.png").exists()


def test_files_that_exist_are_kept_without_force(octant, study_file, tmp_path):
    glb = tmp_path / "room.glb"
    glb.write_text("mine")
    assert "--force" in octant("scene", study_file(ROOM), "--glb", glb).refused()
    assert glb.read_text() == "mine"
    assert octant("scene", study_file(ROOM), "--glb", glb, "--force").code == 0


def test_tags_reader_axes_and_way_are_named_nodes(octant, study_file, tmp_path):
    way = tmp_path / "trajectory.csv"
    way.write_text("t_s,x_m,y_m\n0,0.5,0.5\n1,0.5,1.5\n2,1.0,1.5\n")
    study, glb = study_file(ROOM), tmp_path / "all.glb"
    words = ("--glb", glb, "--with", "tags", "--with", "reader", "--with", "axes", *ENDS)
    call = octant("scene", study, *words, "--trajectory", way)
    assert call.code == 0, call.err
    scene = trimesh.load(glb, process=False)
    boxes = {}
    for name in scene.graph.nodes_geometry:
        matrix, mesh = scene.graph[name]
        corners = trimesh.transform_points(scene.geometry[mesh].vertices, matrix)
        corners = corners[:, [0, 2, 1]] * (1.0, -1.0, 1.0)  # glTF is y up
        boxes[name] = corners.min(axis=0), corners.max(axis=0)
    assert {"tag A", "reader", "axis x", "axis y", "axis z", "trajectory trajectory"} <= set(boxes)
    assert {f"antenna {i}" for i in range(1, 9)} <= set(boxes)
    assert any(name.startswith("path 1, order 0") for name in boxes)
    middle = {name: 0.5 * (low + high) for name, (low, high) in boxes.items()}
    np.testing.assert_allclose(middle["tag A"], [1.0, 3.0, 2.9], atol=1e-5)
    np.testing.assert_allclose(middle["reader"][:2], [0.5, 0.5], atol=1e-5)
    # the robot looks along +y: antenna 3 stands ahead of the axis, antenna 1 to its right
    np.testing.assert_allclose(middle["antenna 3"][:2], [0.5, 0.6], atol=1e-5)
    np.testing.assert_allclose(middle["antenna 1"][:2], [0.6, 0.5], atol=1e-5)
    low, high = boxes["trajectory trajectory"]
    np.testing.assert_allclose([*low[:2], *high[:2]], [0.5, 0.5, 1.0, 1.5], atol=0.02)
    np.testing.assert_allclose(boxes["axis x"][1][0], 1.0, atol=1e-5)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--picture", "a.png", "--with", "tags"), "for the GLB file"),
        (("--glb", "a.glb", "--trajectory", "none.csv"), "none.csv"),
        (("--glb", "a.glb", "--with", "robot"), "tags"),
    ],
)
def test_what_cannot_be_shown_is_one_sentence(
    words, said, octant, study_file, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    call = octant("scene", study_file(ROOM), *words)
    assert call.code == 2
    assert said in call.err


def test_a_reader_without_a_place_is_not_shown(octant, study_file, tmp_path):
    text = ROOM[: ROOM.index("[mission]")]
    call = octant("scene", study_file(text), "--glb", tmp_path / "a.glb", "--with", "reader")
    assert call.code == 2
    assert "[mission]" in call.err
