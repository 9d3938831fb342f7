"""What is said about a mesh room: where its floor is, and walls drawn with both their faces."""

import pytest

from octant.geometries.bodies import Body
from octant.geometries.errors import ConfigError
from octant.geometries.furniture import box
from octant.geometries.mesh_files import save_bodies
from octant.geometries.rooms import box_room
from octant.reader_design.setting.advice import opaque_wall_note, refuse_buried, refuse_under_floor
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import load_study

STUDY = """
[radio]
frequency_hz = 2.4e9
[room]
mesh = "{file}"
unit = "m"
{room}
[[tag]]
id = "A"
position_m = [1.0, 1.0, 2.5]
antenna = "dipole"
[reader]
response = "isolated"
[solver]
{solver}
"""


def floored(bottom_m):
    """A room 5 x 4 x 3 m whose floor, at z = 0, is a slab's top, or has a pit in its corner."""
    walls = [b for b in box_room((5.0, 4.0, 3.0)) if b.name != "floor"]
    if bottom_m == "pit":
        rows = [(0, 0, 4, 4, 0.0), (4, 0, 5, 3, 0.0), (4, 3, 5, 4, -3.0)]
        for k, (x0, y0, x1, y1, z) in enumerate(rows):
            corners = [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]
            walls.append(
                Body(
                    name=f"floor {k}",
                    vertices_m=corners,
                    faces=[[0, 1, 2], [0, 2, 3]],
                    material="concrete",
                )
            )
        return walls
    if not bottom_m:
        return list(box_room((5.0, 4.0, 3.0)))
    slab = box((5.0, 4.0, bottom_m), position_m=(0.0, 0.0, -bottom_m), material="concrete")
    return [*walls, slab]


def setting_of(bodies, folder, room="material = 'concrete'", solver="max_reflections = 1"):
    file = folder / "room.obj"
    save_bodies(bodies, file)
    study = folder / "study.toml"
    study.write_text(STUDY.format(file=file.name, room=room, solver=solver))
    return build_setting(load_study(study))


@pytest.mark.parametrize(
    ("bottom_m", "lowest_m"), [(0.5, -0.5), (0.04, -0.04), ("pit", -3.0), (0.0, None)]
)
def test_the_floor_that_tags_see_is_said_where_it_is_not_the_lowest_point(
    bottom_m, lowest_m, tmp_path
):
    setting = setting_of(floored(bottom_m), tmp_path)
    assert setting.seen_floor_m == (None if lowest_m is None else pytest.approx(0.0, abs=1e-6))
    assert len(setting.notes) == (lowest_m is not None)
    if lowest_m is None:
        return
    assert f"lowest point, z = {lowest_m:g} m" in setting.notes[0]
    assert "room.floor_m = 0 " in setting.notes[0]
    given = setting_of(floored(bottom_m), tmp_path, "material = 'concrete'\nfloor_m = 0.0")
    assert given.notes == ()
    assert given.reader_z_m == pytest.approx(0.3)
    assert given.map_z_m == pytest.approx(0.3)
    if lowest_m < -0.3:
        with pytest.raises(ConfigError, match=r"the map would be at z = .*give room\.floor_m = 0"):
            refuse_under_floor(setting.scene, setting.seen_floor_m, setting.map_z_m, name="the map")


def test_a_table_below_the_only_tag_is_no_floor(tmp_path):
    table = box((1.0, 1.0, 0.7), position_m=(0.5, 0.5, 0.0), material="wood")
    assert setting_of([*floored(0.0), table], tmp_path).seen_floor_m is None


def test_a_floor_belongs_to_a_mesh(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(
        "[radio]\nfrequency_hz = 2.4e9\n[room]\nbox_m = [3, 3, 3]\nmaterial = 'wood'\nfloor_m = 1.0"
    )
    with pytest.raises(ConfigError, match=r"room\.floor_m is given, but it belongs to mesh or"):
        load_study(study)


def test_a_reader_in_a_solid_or_outside_is_refused(tmp_path):
    crate = box((1.0, 1.0, 1.0), position_m=(2.0, 2.0, 0.0), material="wood")
    scene = setting_of([*floored(0.0), crate], tmp_path).scene
    refuse_buried(scene, [(1.0, 1.0, 0.3)], name="pose")
    with pytest.raises(ConfigError, match=r"pose 2 .* \(2.5, 2.5, 0.3\) m, inside a solid object"):
        refuse_buried(scene, [(1.0, 1.0, 0.3), (2.5, 2.5, 0.3)], name="pose")
    with pytest.raises(ConfigError, match=r"pose 1 .* outside the room"):
        refuse_buried(scene, [(7.0, 1.0, 0.3)], name="pose")


@pytest.mark.parametrize(
    ("thickness_m", "material", "says"),
    [
        (0.0, '{name = "brick", thickness_m = 0.1}', None),
        (0.1, '{name = "brick", thickness_m = 0.1}', "loses as in two walls"),
        (0.1, '"brick"', "lets nothing through"),
        (0.1, '"metal"', None),
        (1.5, '"brick"', None),
    ],
)
def test_a_wall_drawn_with_both_its_faces_is_named(thickness_m, material, says, tmp_path):
    wall = box((0.1, 3.5, 2.5), position_m=(2.45, 0.2, 0.2), material="any", name="wall")
    if thickness_m == 0.0:
        corners = [(2.5, 0, 0), (2.5, 4, 0), (2.5, 4, 3), (2.5, 0, 3)]
        wall = Body(name="wall", vertices_m=corners, faces=[[0, 1, 2], [0, 2, 3]], material="any")
    elif thickness_m > 1.0:
        wall = box((1.5, 1.5, 1.5), position_m=(2.45, 0.2, 0.2), material="any", name="wall")
    room = box((5.0, 4.0, 3.0), material="any", name="shell")
    room_table = f'materials = {{shell = "concrete", wall = {material}}}'
    on, off = (
        setting_of((room, wall), tmp_path, room_table, f"transmission = {flag}").notes
        for flag in ("true", "false")
    )
    assert off == ()
    assert [says in note and "one sheet" in note for note in on] == ([True] if says else [])


def test_places_behind_walls_of_known_thickness_are_explained(tmp_path):
    wall = "material = {name = 'plasterboard', thickness_m = 0.06}"
    shut = setting_of(floored(0.0), tmp_path, wall)
    assert "solver.transmission = true" in opaque_wall_note(shut.study, shut.scene, 3)
    assert opaque_wall_note(shut.study, shut.scene, 0) == ""
    clear = setting_of(floored(0.0), tmp_path, wall, "transmission = true")
    assert opaque_wall_note(clear.study, clear.scene, 3) == ""
    thick = setting_of(floored(0.0), tmp_path)
    assert opaque_wall_note(thick.study, thick.scene, 3) == ""
