"""Scenes of Mitsuba and Sionna RT where a study file or ``octant audit`` takes a mesh."""

import csv
import io

import pytest

BOX = """<scene version="2.1.0">
  <bsdf type="itu-radio-material" id="wall"><string name="type" value="{material}"/>
    <float name="thickness" value="0.2"/></bsdf>
  <shape type="cube" id="mesh-room"><transform name="to_world">
    <scale x="2.5" y="2.5" z="1.5"/><translate x="2.5" y="2.5" z="1.5"/></transform>
    <ref id="wall" name="bsdf"/></shape>
</scene>"""
ENDS = ("--tx", "3.5,2,2.9", "--rx", "1,1,0.5", "--csv", "-")
SAME = "box_m = [5, 5, 3]\nmaterial = { name = 'concrete', thickness_m = 0.2 }"


@pytest.fixture
def box(tmp_path):
    def write(material="concrete"):
        (tmp_path / "scene.xml").write_text(BOX.format(material=material))
        return tmp_path / "scene.xml"

    return write


def paths(octant, study):
    call = octant("paths", study, *ENDS)
    assert call.code == 0, call.err
    return list(csv.DictReader(io.StringIO(call.out)))


@pytest.mark.parametrize(
    "room", ['mesh = "scene.xml"', '[[room.mesh]]\nfile = "scene.xml"\nunit = "m"']
)
def test_a_mitsuba_box_of_slabs_is_the_parametric_one(octant, study_file, box, room):
    box()
    ours = paths(octant, study_file(f"[room]\n{room}"))
    same = paths(octant, study_file(f"[room]\n{SAME}"))
    assert len(ours) == 63
    for column in ("length_m", "gain_db"):
        values = [sorted(float(row[column]) for row in rows) for rows in (ours, same)]
        assert values[0] == pytest.approx(values[1], abs=1e-9)


def test_materials_of_the_study_replace_those_of_the_scene(octant, study_file, box):
    box("unobtainium")
    refused = octant("paths", study_file('[room]\nmesh = "scene.xml"'), *ENDS).refused()
    assert "'unobtainium' is unknown" in refused
    table = "[room]\nmesh = 'scene.xml'\nmaterials = { room = 'wood' }"
    assert len(paths(octant, study_file(table))) == 63


def test_a_mesh_that_holds_no_materials_needs_them_in_the_study(octant, study_file, tmp_path):
    (tmp_path / "room.stl").write_text("solid")
    refused = octant("paths", study_file('[room]\nmesh = "room.stl"\nunit = "m"'), *ENDS).refused()
    assert "room.material is missing" in refused


def test_a_scene_is_audited_as_any_mesh(octant, box):
    call = octant("audit", box())
    assert (call.code, call.err) == (0, "")
    assert "12 triangles" in call.out
