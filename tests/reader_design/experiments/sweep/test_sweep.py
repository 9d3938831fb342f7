"""Laws of the sweep: what names a cell, what it holds, that nothing is computed twice."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.sweep import plan as plan_module
from octant.reader_design.experiments.sweep.cells import run_sweep
from octant.reader_design.experiments.sweep.plan import plan_sweep
from octant.reader_design.keeping.workers import open_crew
from octant.reader_design.setting.evaluation import scored_cell
from octant.reader_design.setting.setting import Sampling, build_setting
from octant.reader_design.study_file.loading import load_study, parse_study

STUDY = """
name = "small"
[room]
box_m = [4.0, 4.0, 3.0]
origin_m = [-1.0, -1.0, 0.0]
[[tag]]
id = "A"
position_m = [1.0, 1.0, 2.9]
antenna = "dipole"
[[tag]]
id = "B"
position_m = [2.0, 0.5, 2.9]
antenna = "dipole"
[reader]
response = "isolated"
[solver]
max_reflections = 1
[sweep]
antenna = ["dipole", "monopole"]
antenna_radius_m = [0.05, 0.10]
"""
SAMPLING = Sampling(room_spacing_m=1.0, free_azimuths=2, room_azimuths=2, travel_step_m=0.5)


def setting_of(text=STUDY, sampling=SAMPLING):
    study = parse_study(text, source="test", directory=Path.cwd())
    return build_setting(study, sampling=sampling)


@pytest.fixture(scope="module")
def setting():
    return setting_of()


def same(first, second):
    for field in dataclasses.fields(first):
        a, b = getattr(first, field.name), getattr(second, field.name)
        if field.name == "seconds":
            continue
        assert np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b, field.name


def test_designs_are_every_combination_and_the_first_list_varies_slowest():
    designs = plan_sweep(build_setting(load_study("thesis"))).designs
    assert len(set(designs)) == 2 * 2 * 3
    assert [d.antenna for d in designs] == ["dipole"] * 6 + ["monopole"] * 6
    assert [d.plate_height_m for d in designs[:3]] == [0.0, 0.08, 0.15]
    assert {d.antenna_radius_m for d in designs[:3]} == {0.05}


def test_cell_holds_the_scores_of_both_surroundings(setting):
    plan = plan_sweep(setting)
    cell = scored_cell(plan.cells[0].setting)
    assert cell.reason == ""
    assert cell.free_rss_w.shape == (10, 16, 8)
    assert cell.travel_rss_w.shape == (11, 8)
    # directly under a vertical dipole nothing is received along its axis
    assert cell.travel_rss_w[0].max() < 1e-12 * cell.travel_rss_w.max()
    # isolated antennas of one pattern cannot tell directions apart, save by rounding at ties
    assert cell.free.right_share == pytest.approx((16 + 8) / 16 / 8)
    assert cell.room is not None
    assert any("isolated" in note for note in cell.notes)


def test_free_space_received_power_is_friis(setting):
    plan = plan_sweep(setting)
    cell = scored_cell(plan.cells[2].setting)  # monopoles on the plane itself
    wavelength, height = 299792458.0 / 2.4e9, 2.9 - 0.3
    distance = cell.distances_m[:, None, None]
    slant = np.hypot(distance, height)
    half = np.pi / 2

    def field(theta):
        return np.cos(half * np.cos(theta)) / np.sin(theta)

    theta = np.arctan2(distance, height)
    # peak gains of the half-wave dipole 1.6409 and the quarter-wave monopole 3.2819
    expected = (wavelength / (4 * np.pi * slant)) ** 2 * 1.6409 * 3.2819 * field(theta) ** 4
    np.testing.assert_allclose(cell.free_rss_w, np.broadcast_to(expected, (10, 16, 8)), rtol=1e-3)


def test_keys_differ_between_designs_and_with_everything_that_changes_the_numbers(setting):
    base = plan_sweep(setting)
    assert len(set(base.keys)) == len(base.designs)
    changes = {
        "tag": STUDY.replace("[1.0, 1.0, 2.9]", "[1.0, 1.1, 2.9]"),
        "material": STUDY.replace("[room]", '[room]\nmaterial = "wood"'),
        "size": STUDY.replace("[4.0, 4.0, 3.0]", "[4.0, 4.1, 3.0]"),
        "order": STUDY.replace("max_reflections = 1", "max_reflections = 2"),
        "model": STUDY.replace('"isolated"', '"rays"'),
        "power": STUDY.replace("[room]", "[radio]\ntag_power_w = 2.0\n[room]", 1),
        "frequency": STUDY.replace("[room]", "[radio]\nfrequency_hz = 2.45e9\n[room]", 1),
        "gap": STUDY.replace("[reader]", "[reader]\ngap_m = 0.006"),
    }
    keys = {name: plan_sweep(setting_of(text)).keys[0] for name, text in changes.items()}
    finer = dataclasses.replace(SAMPLING, room_azimuths=4)
    keys["sampling"] = plan_sweep(setting_of(sampling=finer)).keys[0]
    assert len({*keys.values(), base.keys[0]}) == len(keys) + 1


def test_keys_do_not_change_with_what_does_not_matter(setting):
    renamed = (
        STUDY.replace('"small"', '"other"') + "plate_height_m = [0.08]\n[map]\nspacing_m = 9\n"
    )
    assert plan_sweep(setting_of(renamed)).keys == plan_sweep(setting).keys


def test_keys_are_the_same_when_the_room_is_built_again(setting):
    assert plan_sweep(setting_of()).keys == plan_sweep(setting).keys


def test_cells_are_read_back_bit_by_bit_and_not_computed_again(setting, tmp_path, monkeypatch):
    plan = plan_sweep(setting)
    first = run_sweep(plan, tmp_path)
    assert [cell.key for cell in first] == list(plan.keys)
    assert {p.name for p in tmp_path.iterdir()} == {f"{key[:32]}.nc" for key in plan.keys}

    def never(*_):
        raise AssertionError

    monkeypatch.setattr(plan_module, "scored_cell", never)
    for a, b in zip(first, run_sweep(plan, tmp_path), strict=True):
        same(a, b)


def test_design_that_cannot_be_built_is_recorded_with_its_reason_and_stops_nobody(tmp_path):
    text = STUDY.replace("[0.05, 0.10]", "[0.002, 0.10]")
    plan = plan_sweep(setting_of(text))
    cells = run_sweep(plan, tmp_path)
    failed = [c for c in cells if c.reason]
    assert [c.design.label() for c in failed] == ["monopole r_a = 0.2 cm h_p = 8 cm"]
    assert "monopole_plane_m" in failed[0].reason
    assert failed[0].free is None
    again = run_sweep(plan, tmp_path)
    assert [c.reason for c in again] == [c.reason for c in cells]
    assert len(list(tmp_path.iterdir())) == 4


@pytest.mark.slow
def test_processes_compute_the_same_bits(tmp_path):
    # At full sampling the sums are long enough for linear algebra to split them among threads.
    text = STUDY.replace('antenna = ["dipole", "monopole"]\n', "").replace(
        "box_m", "free_space = true\n#"
    )
    plan = plan_sweep(setting_of(text.replace("origin_m", "#"), Sampling()))
    with open_crew(workers=2) as crew:
        there = run_sweep(plan, tmp_path / "there", crew=crew)
    for a, b in zip(run_sweep(plan, tmp_path / "here"), there, strict=True):
        same(a, b)


def test_reference_tag_is_the_missions_first(setting):
    assert setting.reference_tag.id == "A"
    driven = setting_of(
        STUDY + '[mission]\nnavigator = "thesis"\nstart_m = [0.0, 0.0]\ntags = ["B", "A"]\n'
    )
    assert driven.reference_tag.id == "B"


def test_study_without_tags_cannot_be_scored():
    text = STUDY[: STUDY.index("[[tag]]")] + STUDY[STUDY.index("[reader]") :]
    setting = setting_of(text)
    with pytest.raises(ConfigError, match=r"\[\[tag\]\]"):
        _ = setting.reference_tag
    plan = plan_sweep(setting)
    with pytest.raises(ConfigError, match=r"\[\[tag\]\]"):
        scored_cell(plan.cells[0].setting)


def test_free_space_study_has_no_room_scores():
    start = STUDY.index("box_m")
    text = STUDY[:start] + "free_space = true\n" + STUDY[STUDY.index("[[tag]]") :]
    setting = setting_of(text)
    plan = plan_sweep(setting)
    cell = scored_cell(plan.cells[0].setting)
    assert cell.room is None
    assert cell.free is not None
