"""Rooms from worlds, plans and meshes of unknown unit, in Python and in what their keys count."""

import numpy as np
import pytest
from PIL import Image

import octant
from octant.geometries.errors import ConfigError
from octant.geometries.furniture import box
from octant.geometries.mesh_files import save_bodies
from octant.reader_design.keeping.keys import digest


def test_a_map_is_loaded_with_the_height_of_its_walls(tmp_path):
    cells = np.full((30, 40), 254, dtype=np.uint8)
    cells[[0, -1]] = cells[:, [0, -1]] = 0
    Image.fromarray(cells).save(tmp_path / "m.pgm")
    (tmp_path / "m.yaml").write_text("image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n")
    room = octant.Room.load(tmp_path / "m.yaml", material="concrete", height_m=3.0)
    assert repr(room).startswith("<Room: 4 x 3 x 3 m, 2 bodies")
    with pytest.raises(ConfigError, match=r"geometry .* belongs to mesh = FILE\.sdf"):
        octant.Room.load(tmp_path / "m.yaml", material="concrete", geometry="visual")


def test_unit_and_axis_are_guessed_where_they_are_auto(tmp_path):
    save_bodies([box((8000, 2800, 6000), material="m", name="room")], tmp_path / "a.obj")
    room = octant.Room.load(tmp_path / "a.obj", unit="auto", up="auto", material="wood")
    assert repr(room).startswith("<Room: 8 x 6 x 2.8 m")
    assert room.table.unit == "mm"
    report = octant.audit(tmp_path / "a.obj", up="auto")
    assert "up: y, because along y it is 2.8 m, an ordinary height" in repr(report)
    assert "6 flat faces in the scene" in repr(report)
    assert "an odd shape for a room" in repr(octant.audit(tmp_path / "a.obj", up="z"))


def test_a_world_is_found_by_its_resource_path_whose_files_count_in_keys(tmp_path):
    (tmp_path / "far/crate").mkdir(parents=True)
    model = (
        "<sdf version='1.7'><model name='crate'><link name='l'><visual name='v'><geometry><box>"
        "<size>1 2 {}</size></box></geometry></visual></link></model></sdf>"
    )
    (tmp_path / "far/crate/model.sdf").write_text(model.format(3))
    (tmp_path / "w").mkdir()
    (tmp_path / "w/a.world").write_text(
        "<sdf version='1.7'><world name='w'><include><uri>model://crate</uri></include></world>"
        "</sdf>"
    )
    options = {"material": "wood", "resource_path": [tmp_path / "far"]}
    room = octant.Room.load(tmp_path / "w/a.world", **options)
    assert repr(room).startswith("<Room: 1 x 2 x 3 m, 1 body")
    before = digest(room.table)
    assert before == digest(octant.Room.load(tmp_path / "w/a.world", **options).table)
    (tmp_path / "far/crate/model.sdf").write_text(model.format(33))
    assert digest(room.table) != before
