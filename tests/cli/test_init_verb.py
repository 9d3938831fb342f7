"""``octant init`` and ``octant demo``: from a mesh to a study, and a first look without one."""

from importlib import resources

import numpy as np
import pytest
from PIL import Image

from octant.geometries.bodies import Body
from octant.geometries.furniture import box
from octant.geometries.mesh_files import save_bodies
from octant.geometries.rooms import box_room
from octant.reader_design.study_file.loading import load_study


@pytest.fixture
def mesh(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    desk = box((1.2, 0.7, 0.7), position_m=(3.5, 2.8, 0), material="m", name="desk")
    save_bodies([*box_room((5, 4, 2.6), material="m"), desk], tmp_path / "office.glb")
    return tmp_path / "office.glb"


def test_init_writes_a_study_and_a_picture_and_says_what_it_guessed(octant, mesh, tmp_path):
    call = octant("init", "office.glb")
    assert call.code == 0
    assert call.out == "written: office.toml and office.png\n"
    for said in ("unit m: glTF says so", "up y: body 'floor' is flat along y", "octant map office"):
        assert said in call.err
    assert (tmp_path / "office.png").stat().st_size > 10_000
    study = load_study(tmp_path / "office.toml")
    assert study.room.materials["desk"] == "chipboard"
    assert "exists already" in octant("init", "office.glb").refused()
    assert octant("init", "office.glb", "--force").code == 0
    assert "a .toml file" in octant("init", mesh, "--out", "a.txt").refused()


@pytest.mark.slow
def test_what_init_writes_is_mapped_and_driven_as_it_stands(octant, mesh, tmp_path):
    assert octant("init", mesh, "--out", tmp_path / "s.toml").code == 0
    text = (tmp_path / "s.toml").read_text()
    quick = text.replace("[reader] ", '[reader]\nresponse = "isolated"\n#').replace(
        "max_reflections = 3", "max_reflections = 1"
    )
    (tmp_path / "s.toml").write_text(quick)
    assert octant("map", tmp_path / "s.toml", "--out", tmp_path / "m.nc", "-q").code == 0
    call = octant(
        "navigate", tmp_path / "s.toml", "--out", tmp_path / "d", "--runs", "2", "--workers", "1"
    )
    assert call.code == 0, call.err
    assert "2 of 2" in call.out


@pytest.mark.parametrize("verb", ["map", "study", "scene", "navigate"])
@pytest.mark.usefixtures("mesh")
def test_a_mesh_where_a_study_is_due_leads_to_init(octant, verb):
    options = ["--picture", "a.png"] if verb == "scene" else []
    said = octant(verb, "office.glb", *options).refused()
    assert said.endswith("write a study for it: octant init office.glb")


@pytest.mark.usefixtures("mesh")
def test_places_outside_a_turned_room_say_that_it_was_turned(octant, study_file):
    text = (
        '[room]\nmesh = "office.glb"\nmaterial = "concrete"\n[[tag]]\nid = "a"\n'
        "position_m = [2.0, 2.0, 9.0]\n"
    )
    assert 'give room.up = "z"' in octant("map", study_file(text), "--isotropic").refused()
    text = text.replace('material = "concrete"', 'material = "concrete"\nup = "z"')
    assert "turned" not in octant("map", study_file(text), "--isotropic").refused()


def test_bodies_without_a_material_are_named_at_once_with_a_line_to_paste(octant, study_file):
    sheet = Body(
        name="glass door",
        vertices_m=np.array([(0.0, 0, 0), (2, 0, 0), (2, 2, 2)]),
        faces=np.array([(0, 1, 2)]),
        material="m",
    )
    path = study_file('[room]\nmesh = "a.obj"\nunit = "m"\nmaterials = { floor = "wood" }\n')
    save_bodies([*box_room((5, 4, 2.6), material="m"), sheet], path.parent / "a.obj")
    said = octant("paths", path, "--tx", "1,1,1", "--rx", "2,1,1").refused()
    assert "3 bodies of" in said
    assert (
        'materials = { walls = "concrete", ceiling = "concrete", "glass door" = "glass" }' in said
    )


def test_the_demonstration_needs_no_full_wave_solution_and_little_room():
    study = load_study("demo")
    assert study.reader.response == "files"
    data = resources.files("octant.reader_design.study_file") / "demo_reader.csv"
    assert len(data.read_bytes()) < 300_000


@pytest.mark.slow
def test_the_demonstrations_reader_is_the_full_wave_solution():
    from octant.reader_design.setting.design import response_at

    study = load_study("demo")
    theta, phi = np.radians(np.meshgrid([40.0, 65.0, 90.0, 117.0], np.arange(0, 360, 22.5)))
    stored, solved = (
        response_at(study.reader, 2.45e9, model).far_field(theta, phi)
        for model in ("files", "fullwave")
    )
    assert np.abs(stored - solved).max() < 0.01 * np.abs(solved).max()


def test_a_plan_that_is_a_picture_becomes_a_study_beside_it(octant, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plan = np.full((60, 80), 255, dtype=np.uint8)
    plan[[0, -1]], plan[:, [0, -1]] = 0, 0
    Image.fromarray(plan).save("plan.png")
    assert "--metres-per-pixel 0.05" in octant("init", "plan.png").refused()
    content = (tmp_path / "plan.png").read_bytes()
    call = octant("init", "plan.png", "--metres-per-pixel", "0.1", "--force")
    assert call.code == 0, call.err
    assert (tmp_path / "plan.png").read_bytes() == content
    assert (tmp_path / "plan_room.png").is_file()
    assert "metres_per_pixel = 0.1" in (tmp_path / "plan.toml").read_text()
