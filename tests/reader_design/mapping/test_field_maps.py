"""Field maps of a study: which of its edges they contain, and the file that keeps them."""

from pathlib import Path

import numpy as np

from octant.reader_design.mapping import field_maps
from octant.reader_design.mapping.field_maps import (
    MappedTag,
    compute_map,
    map_context,
    map_forecast,
)
from octant.reader_design.mapping.map_file import TagMapCodec
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study

STUDY = """
[room]
box_m = [3.0, 3.0, 2.6]
material = "concrete"

[[tag]]
id = "one"
position_m = [1.0, 0.9, 2.5]
antenna = "dipole"

[solver]
max_reflections = 1

[mission]
navigator = "map"
start_m = [0.6, 0.6]
heading_deg = 0.0
tags = ["one"]
"""
CABINET = """
[[room.object]]
kind = "box"
size_m = [0.4, 0.6, 1.2]
position_m = [1.8, 1.2, 0.0]
material = "metal"
"""


def setting_of(*, furniture="", told="", solver=""):
    text = STUDY.replace("[[tag]]", f"{furniture}[[tag]]", 1).replace(
        "max_reflections = 1", f"max_reflections = 1\n{solver}"
    )
    return build_setting(parse_study(text + told, source="study", directory=Path()))


def edges_in(setting):
    context = map_context(setting)
    return len(context.radios[0].wedges) if context.solver.diffraction else 0


def test_maps_contain_the_edges_of_furniture_unless_the_study_says_otherwise():
    edges = edges_in(setting_of(furniture=CABINET))
    assert edges >= edges_in(setting_of()) + 8
    assert f"{edges} edges that diffract" in map_forecast(setting_of(furniture=CABINET))
    for solver in ("", "diffraction = true"):
        assert edges_in(setting_of(furniture=CABINET, told="map.edges = false", solver=solver)) == 0


def test_too_many_edges_are_left_out_unless_the_study_asks_for_them(monkeypatch):
    monkeypatch.setattr(field_maps, "MOST_WEDGES", 7)
    assert edges_in(setting_of(furniture=CABINET)) == 0
    assert edges_in(setting_of(furniture=CABINET, told="map.edges = true")) >= 8


def test_a_map_is_kept_as_it_is():
    setting = setting_of(furniture=CABINET, told="map.spacing_m = 0.2")
    tag = setting.tags[0]
    case = MappedTag(position_m=(1.0, 0.9, 2.5), antennas=tag.antennas, power_w=1.0)
    made, codec = compute_map(map_context(setting), case), TagMapCodec()
    kept = codec.decode(codec.encode(made, case), case)
    for one, other in ((made.field, kept.field), (made.paths, kept.paths)):
        for name in one.__dataclass_fields__:
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert np.count_nonzero(kept.paths.images[:, 6]) > 5
    assert kept.paths.fields[0].dtype == np.complex64
