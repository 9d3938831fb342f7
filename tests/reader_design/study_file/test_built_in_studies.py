"""The studies that come with Octant, by name; and other values of keys in a layout."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.geometries.mesh_files import load_bodies
from octant.reader_design.experiments.missions.advice import advise
from octant.reader_design.experiments.missions.compute import drive_missions
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import (
    BUILT_IN,
    layout_study,
    load_study,
    parse_study,
    to_toml,
    vary,
)

ROOT = Path(__file__).resolve().parents[3]
OFFICE = ROOT / "reader_design" / "study_file" / "office.glb"
ROOM = """
[room]
box_m = [5.0, 4.0, 3.0]
[[tag]]
id = "a"
position_m = [2.0, 1.0, 2.9]
[mission]
start_m = [1.0, 1.0]
tags = ["a"]
[[layout]]
name = "other"
[layout.values]
{values}
"""


def study_of(values):
    return parse_study(ROOM.format(values=values), source="test", directory=Path())


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_built_in_study_is_named_in_place_of_a_file_and_reads_back(name, tmp_path, monkeypatch):
    (tmp_path / name).write_text("no study")
    monkeypatch.chdir(tmp_path)
    study = load_study(name)
    assert study == load_study(built_in=name) == load_study(built_in=f"{name}_study")
    text = to_toml(study, relative_to=tmp_path)
    assert parse_study(text, source="again", directory=tmp_path) == study
    with pytest.raises(ConfigError, match="TOML"):
        load_study(f"./{name}")
    assert load_study() == load_study("office")


def test_defaults_are_those_with_which_missions_arrive():
    study = study_of('"mission.noise_db" = 2.0')
    assert study.tags[0].antenna == "conical_patch"
    assert study.tags[0].axis == (0.0, 0.0, -1.0)
    assert study.mission.navigator == "tracker"
    assert study.radio.channels_hz == ()
    assert not study.solver.transmission


def test_a_layout_changes_keys_and_what_it_says_is_written_back():
    study = study_of('"tag.antenna" = "dipole"\n"mission.navigator" = "thesis"')
    other = layout_study(study, study.layouts[0])
    assert (other.tags[0].antenna, other.tags[0].axis) == ("dipole", (0.0, 0.0, 1.0))
    assert other.mission.navigator == "thesis"
    assert layout_study(study, None) is study
    assert build_setting(study, study.layouts[0]).study == other
    assert parse_study(to_toml(study), source="again", directory=Path()) == study


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ('"reader.gap_m" = 0.01', "'reader.gap_m'"),
        ('"gap_m" = 0.01', "'gap_m'"),
        ('"mission.tags" = ["a"]', "'mission.tags'"),
        ('mission = "a"', "'mission'"),
        ('"mission.noise_db" = -1.0', "noise_db"),
        ('"mission.navigatr" = "thesis"', "navigatr"),
    ],
)
def test_a_layout_that_cannot_be_is_refused_with_its_name(values, words):
    with pytest.raises(ConfigError, match=rf"layout 'other': values.*{words}"):
        study_of(values)


def test_the_mesh_of_the_office_is_what_its_script_makes():
    made = {b.name: b for b in runpy.run_path(str(ROOT / "tools" / "make_office.py"))["office"]()}
    stored = {b.name: b for b in load_bodies(OFFICE, material="wood")}
    assert stored.keys() == made.keys()
    for name, body in made.items():
        corners = [np.unique(b.vertices_m.round(5), axis=0) for b in (body, stored[name])]
        np.testing.assert_allclose(*corners, atol=1e-5)
    assert OFFICE.stat().st_size < 10_000


@pytest.mark.slow
def test_the_office_arrives_and_its_last_row_says_why_the_thesis_means_do_not():
    """With the coarsest solution of its own reader; the channel of the row is one of the four."""
    study = vary(load_study("office"), {"cells_per_wavelength": 5.0})
    own = build_setting(study)
    (layout,) = study.layouts
    there = build_setting(study, layout)
    place = study.radio.channels_hz.index(there.study.radio.frequency_hz)
    rooms = (own, there.with_responses([own.responses[place]]))
    found = [advise(room, drive_missions(room, runs=5)) for room in rooms]
    assert found[0] is None
    assert found[1].sentence.startswith("No run reached every tag")
    assert {c.path[-1] for c in found[1].changes} >= {"navigator", "antenna", "channels_hz"}
