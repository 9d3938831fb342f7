"""Laws of the table [sweep]: any key, lists and ranges, and the errors of the keys themselves."""

from pathlib import Path

import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.sweep.plan import combinations, plan_sweep
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import load_study, parse_study, to_toml, vary
from octant.reader_design.study_file.sweep import parameter_paths

ROOM = 'name = "x"\n[room]\nbox_m = [5, 5, 3]\n'
TAG = '[[tag]]\nid = "a"\nposition_m = [2.0, 0.5, 2.9]\nantenna = "dipole"\n'


def parsed(sweep, head=ROOM + TAG):
    return parse_study(f"{head}[sweep]\n{sweep}\n", source="s.toml", directory=Path.cwd())


def plan(sweep, head=ROOM + TAG + '[reader]\nresponse = "isolated"\n'):
    study = parsed(sweep, head)
    setting = build_setting(study)
    return plan_sweep(setting)


def test_every_key_of_the_reader_is_a_bare_name_and_every_table_is_reached_by_path():
    paths = parameter_paths()
    for name in (
        *("antenna", "antenna_length_m", "antenna_radius_m", "plate_height_m", "gap_m"),
        *("ground_plane_m", "ground_plane_shape", "antennas", "plate_height_axis_m"),
        *("plate_outer_radius_m", "monopole_plane_m", "load_ohm", "height_m", "wire_radius_m"),
    ):
        assert paths[name] == ("reader", name)
    for name in ("radio.frequency_hz", "tag.antenna", "room.object.size_m", "solver.rays", "room"):
        assert paths[name] == tuple(name.split("."))
    assert not [name for name in paths if name.startswith(("mission", "sweep", "map"))]


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ("{from = 0.05, to = 0.12, count = 8}", [0.05, 0.06, 0.07, 0.08, 0.09, 0.10, 0.11, 0.12]),
        ("{from = 0.05, to = 0.12, step = 0.02}", [0.05, 0.07, 0.09, 0.11]),
        ("{from = 0.3, to = 0.1, step = 0.1}", [0.3, 0.2, 0.1]),
        ("[1, 0.5]", [1.0, 0.5]),
    ],
)
def test_ranges_are_written_out_and_lists_keep_their_order(given, values):
    assert list(parsed(f"gap_m = {given}").sweep["gap_m"]) == values


def test_whole_numbers_stay_whole():
    assert parsed("antennas = {from = 6, to = 10, step = 2}").sweep["antennas"] == (6, 8, 10)


@pytest.mark.parametrize(
    "sweep",
    [
        "gap_m = [0.005, 0.02]",
        '"radio.channels_hz" = [[], [2.402e9, 2.48e9]]',
        '"room.material" = ["wood", {eps_r = 3.0, thickness_m = 0.1}]',
        '"tag.antenna" = ["dipole", "patch"]\nheight_m = [0.3, 0.5]',
        "room = [{free_space = true}, {box_m = [4, 4, 3]}]",
        '"solver.diffraction" = [true, false]\nground_plane_shape = ["round"]',
    ],
)
def test_sweeps_read_back_from_the_resolved_study(sweep):
    study = parsed(sweep)
    assert parse_study(to_toml(study), source="again", directory=Path("/")) == study


@pytest.mark.parametrize(
    ("sweep", "parts"),
    [
        ("gapm = [1]", ["sweep.gapm", "'gap_m'"]),
        ('"radio.frequncy_hz" = [1]', ["'radio.frequency_hz'"]),
        ('"mission.runs" = [1]', ["sweep.'mission.runs'", "swept"]),
        ("gap_m = []", ["sweep.gap_m", "empty list"]),
        ("gap_m = 0.005", ["sweep.gap_m", "a list"]),
        ("gap_m = [0.005, -1]", ["sweep.gap_m[1]", "reader.gap_m is -1 m", "from 1e-6 to 100 m"]),
        ('gap_m = ["wide"]', ["sweep.gap_m[0]", "reader.gap_m is 'wide'", "a number"]),
        ("antennas = [6, 8.5]", ["sweep.antennas[1]", "8.5", "a whole number"]),
        ('antenna = ["dipol"]', ["sweep.antenna[0]", "did you mean 'dipole'"]),
        ("gap_m = [0.1, 0.1]", ["sweep.gap_m[1]", "once"]),
        ("gap_m = [nan]", ["sweep.gap_m[0]", "finite"]),
        ("gap_m = {from = 1, to = 2}", ["neither count nor step"]),
        ("gap_m = {from = 1, to = 2, count = 3, step = 1}", ["both count and step"]),
        ("gap_m = {from = 1, to = 1, count = 3}", ["from 1 to itself"]),
        ("gap_m = {from = 1, to = 2, count = 1}", ["sweep.gap_m.count", "from 2 to 10000"]),
        ("gap_m = {from = 1, too = 2}", ["sweep.gap_m.too", "'to'"]),
        ("gap_m = {from = 0, to = 1, step = 1e-9}", ["sweep.gap_m", "at most 10000"]),
        ('gap_m = [0.1]\n"reader.gap_m" = [0.2]', ["the same key reader.gap_m"]),
        ('"room.material" = ["concret"]', ["sweep.'room.material'[0]", "'concrete'"]),
        ('"tag.antenna" = ["none.ffe"]', ["sweep.'tag.antenna'[0]", "none.ffe", "not exist"]),
        ('"room.object.yaw_deg" = [1]', ["[[room.object]]"]),
        (
            "antenna_radius_m = [0.1, -0.1]",
            ["reader.antenna_radius_m", "-0.1 m", "from 1e-6 to 100 m"],
        ),
    ],
)
def test_wrong_sweeps_are_refused_as_the_key_itself_would_be(sweep, parts):
    with pytest.raises(ConfigError) as caught:
        parsed(sweep)
    message = str(caught.value)
    assert "\n" not in message
    for part in ("s.toml", *parts):
        assert part in message


def test_value_that_only_some_combinations_can_have_makes_the_others_infeasible():
    planned = plan("antenna_radius_m = [0.1, 0.12]\nground_plane_m = [0.2, 0.3]").cells
    assert [bool(cell.reason) for cell in planned] == [False, False, True, False]
    assert "stand on the ground plane" in planned[2].reason
    assert len({cell.key for cell in planned}) == 4


def test_room_that_a_tag_does_not_fit_in_makes_its_cells_infeasible():
    planned = plan('"room.box_m" = [[5, 5, 3], [1, 5, 3]]').cells
    assert planned[0].reason == ""
    assert "outside the room" in planned[1].reason


def test_first_parameter_of_the_file_varies_slowest():
    study = parsed('ground_plane_shape = ["round", "square"]\ngap_m = [0.01, 0.02]')
    assert [tuple(values.values()) for values in combinations(study)] == [
        ("round", 0.01),
        ("round", 0.02),
        ("square", 0.01),
        ("square", 0.02),
    ]


def test_labels_name_every_swept_parameter_and_the_thesis_keeps_its_own():
    cells = plan(
        'gap_m = [0.005]\nload_ohm = [75]\n"radio.frequency_hz" = [2.45e9]\n'
        '"room.box_m" = [[5, 5, 3]]\n"room.material" = ["wood"]'
    ).cells
    assert cells[0].label == (
        "dipole r_a = 10 cm h_p = 8 cm gap = 0.5 cm load = 75 ohm radio.frequency = 2.45 GHz "
        "room.box = (5, 5, 3) m room.material = wood"
    )
    study = load_study("thesis")
    setting = build_setting(study)
    thesis = plan_sweep(setting).cells
    assert [cell.label for cell in thesis] == [cell.design.label() for cell in thesis]


@pytest.mark.parametrize(
    "sweep",
    [
        '"radio.frequency_hz" = [2.4e9, 2.45e9]',
        '"radio.channels_hz" = [[], [2.402e9, 2.48e9]]',
        '"tag.antenna" = ["dipole", "patch"]',
        '"tag.position_m" = [[2, 1, 2.9], [2, 2, 2.9]]',
        '"room.material" = ["concrete", "wood"]',
        '"room.box_m" = [[5, 5, 3], [5, 6, 3]]',
        '"solver.max_reflections" = [1, 2]',
        '"solver.diffraction" = [false, true]',
        "antenna_length_m = [0.05, 0.06]",
        "wire_radius_m = [0.0005, 0.001]",
        "height_m = [0.3, 0.4]",
        'response = ["rays", "isolated"]',
        "cells_per_wavelength = [10, 14]",
        "room = [{free_space = true}, {box_m = [5, 5, 3]}]",
    ],
)
def test_every_swept_parameter_names_its_cells_apart(sweep):
    planned = plan(sweep, ROOM + TAG).cells
    assert [cell.reason for cell in planned] == ["", ""]
    assert planned[0].key != planned[1].key
    assert planned[0].label != planned[1].label


def test_cells_see_the_swept_values_and_what_depends_on_them():
    cells = plan('"tag.antenna" = ["dipole", "patch"]\nheight_m = [0.3, 0.5]').cells
    studies = [cell.setting.study for cell in cells]
    assert [s.tags[0].axis for s in studies] == [(0, 0, 1)] * 2 + [(0, 0, -1)] * 2
    assert [s.map.height_m for s in studies] == [0.3, 0.5, 0.3, 0.5]
    assert [cell.setting.reader_z_m for cell in cells] == [0.3, 0.5, 0.3, 0.5]
    assert [cell.design.height_m for cell in cells] == [0.3, 0.5, 0.3, 0.5]


def test_variant_has_no_sweep_and_all_checks():
    study = parsed("gap_m = [0.005, 0.02]")
    assert vary(study, {"gap_m": 0.02}).reader.gap_m == 0.02
    assert vary(study, {"gap_m": 0.02}).sweep == {}
    with pytest.raises(ConfigError, match="stand on the ground plane"):
        vary(study, {"ground_plane_m": 0.1})


def test_what_the_reader_sends_is_swept_with_cells_of_their_own():
    woken = (
        ROOM + TAG + 'kind = "passive"\n[rfid]\npower_w = 1.0\n[reader]\nresponse = "isolated"\n'
    )
    cells = plan('"rfid.power_w" = [0.5, 1.0]\n"tag.sensitivity_dbm" = [-18, -20]', woken).cells
    assert len({cell.key for cell in cells}) == 4
    assert [cell.setting.study.rfid.power_w for cell in cells] == [0.5, 0.5, 1.0, 1.0]
