"""A comparison finds no difference where there is none, and says what is wrong where there is."""

from dataclasses import replace

import numpy as np
import pytest
from measured_room import log_of, measured_study, some_poses, truth_dbm

from octant.navigation.logs.frames import axis_frames
from octant.reader_design.experiments.measured.compare import compared
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.advice import opaque_sheet_note
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study, vary

POSES = some_poses(400)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return measured_study(tmp_path_factory.mktemp("compare"))


@pytest.fixture(scope="module")
def level(study):
    return truth_dbm(study, POSES)


def found(study, log):
    return compared(
        build_setting(study), log, antenna="dipole", cell_m=0.5, least=5, progress=Progress()
    )


def test_a_log_of_the_model_itself_agrees_with_it(study, level):
    got = found(study, log_of(level + 2.0, POSES))
    assert got.left_out < 0.01
    for one in got.links:
        # Readings within 0.15 m share a prediction; cells average what that errs.
        assert one.bias_db.value == pytest.approx(2.0, abs=0.1)
        assert one.sd_db.value < 0.35
        assert one.correlation.value > 0.99
    assert got.sd_free_db < 0.3 < min(law.sd_db for law in got.baselines)
    assert got.notes == ()
    named = {one.name: one.count for one in got.by_walls}
    assert sum(named.values()) == len(got.observations)
    assert set(named) == {"in sight", "behind 1 or 2 faces of walls"}


def test_levels_of_the_calibration_shift_the_prediction(study, level):
    lifted = vary(study, {"calibration": {"level_db": {"a": 2.0, "b": -1.0}}})
    got = found(lifted, log_of(level, POSES))
    bias = {one.name: one.bias_db.value for one in got.links}
    assert bias["a"] == pytest.approx(-2.0, abs=0.1)
    assert bias["b"] == pytest.approx(1.0, abs=0.1)
    assert bias["c"] == pytest.approx(0.0, abs=0.1)


def test_what_was_not_heard_is_judged_against_the_threshold(study, level):
    limit = float(np.quantile(level, 0.2))
    hidden = log_of(level, POSES, threshold_dbm=limit, hide_below=limit)
    got = found(study, hidden)
    right, all_of_them = np.sum([one.unheard for one in got.links], axis=0)
    assert all_of_them > 20
    assert right >= 0.9 * all_of_them
    lost = found(study, replace(hidden, threshold_dbm=None))
    assert any("may be lost packets" in note for note in lost.notes)


@pytest.mark.parametrize("name", ["x mirrored", "turned by 180 deg"])
def test_mixed_up_axes_are_named_with_what_sets_them_right(study, level, name):
    frames = axis_frames(*build_setting(study).scene.bounds_m[:, :2])
    wrong = POSES.copy()
    wrong[:, :2] = frames[name].places_m(POSES[:, :2])
    got = found(study, log_of(level, wrong))
    assert any(f"with {name}" in note and "are its axes mixed up" in note for note in got.notes)


def test_walls_that_are_opaque_by_neglect_are_pointed_at(study, level):
    dark = vary(study, {"solver.transmission": False})
    got = found(dark, log_of(level, POSES))
    text = " ".join(got.notes)
    assert "no path arrives in" in text
    assert "inner walls of" in text
    assert "solver.transmission = true" in text
    size, place = [0.1, 3.0, 2.5], [2.4, 0.5, 0.0]
    locker = {"kind": "box", "size_m": size, "position_m": place, "material": "metal"}
    metal = vary(dark, {"room.object": [locker]})
    assert opaque_sheet_note(metal, build_setting(metal).scene) == ""


def test_walls_drawn_with_both_faces_count_as_inner_walls(tmp_path):
    notch = "[[0, 0], [4, 0], [4, 3], [2.1, 3], [2.1, 1], [2, 1], [2, 3], [0, 3]]"
    text = f'name = "u"\n[room]\noutline_m = {notch}\nheight_m = 2.5\nmaterial = "brick"\n'
    shut = parse_study(text, source="test", directory=tmp_path)
    said = opaque_sheet_note(shut, build_setting(shut).scene)
    assert "inner walls of brick" in said
    assert "and the walls a thickness_m" in said
    corner = text.replace(notch, "[[0, 0], [4, 0], [4, 1.5], [2, 1.5], [2, 3], [0, 3]]")
    bent = parse_study(corner, source="test", directory=tmp_path)
    assert opaque_sheet_note(bent, build_setting(bent).scene) == ""


def test_calibrated_levels_raise_what_maps_and_readings_show(study):
    lifted = vary(study, {"calibration": {"level_db": {"a": 3.0}}})
    poses = POSES[:5]
    for tag, factor in ((0, 10.0**0.3), (1, 1.0)):
        links = [build_setting(one) for one in (study, lifted)]
        own, raised = (s.link(s.tags[tag]).rss_w(poses) for s in links)
        np.testing.assert_allclose(raised, factor * own, rtol=1e-12)
