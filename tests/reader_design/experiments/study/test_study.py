"""Laws of the main job: what it leaves, how it goes on after a stop, that it destroys nothing."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError, NavigationError, SweepStateError
from octant.navigation.missions.run import MissionJob
from octant.reader_design.experiments.missions import stage
from octant.reader_design.experiments.study import publish
from octant.reader_design.experiments.study import run as study
from octant.reader_design.experiments.study.map_stage import MapCase, map_stage
from octant.reader_design.experiments.study.run import run_study
from octant.reader_design.experiments.sweep import plan as sweep
from octant.reader_design.face.study import open_results
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.showing.netcdf import read_dataset
from octant.reader_design.study_file.loading import load_study, parse_study
from octant.reader_design.study_file.scores import SCORE_NAMES

TEXT = """
name = "tiny <study>"
seed = 5
[room]
box_m = [4.0, 4.0, 3.0]
origin_m = [-1.0, -1.0, 0.0]
[[tag]]
id = "A"
position_m = [1.0, 1.0, 3.0]
antenna = "dipole"
[[tag]]
id = "B"
position_m = [2.0, 0.5, 2.9]
antenna = "dipole"
[reader]
plate_height_m = 0.0
response = "rays"
[sweep]
antenna_radius_m = [0.05, 0.10]
[solver]
max_reflections = 1
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [0.0, 0.0]
tags = ["A", "B"]
runs = 4
max_time_s = 15.0
[[layout]]
name = "With a Cabinet"
[[layout.object]]
kind = "cabinet"
size_m = [0.5, 0.3, 1.0]
position_m = [2.0, 2.0, 0.0]
"""
OUTPUTS = {
    "designs.csv",
    "results.nc",
    "report.html",
    "study.toml",
    "missions.csv",
    "trajectory.csv",
    "missions-with-a-cabinet.csv",
    "trajectory-with-a-cabinet.csv",
}


FIRST_FIGURES = {
    "room.png",
    "sweep_matrix.png",
    "sweep_parallel.png",
    "sweep_pareto.png",
    "rss_azimuth.png",
    "rss_distance.png",
    "map_rss.png",
    "trajectory.png",
}


def small(text=TEXT):
    return parse_study(text, source="test", directory=Path.cwd())


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    return run_study(small(), folder, quick=True)


def never(*_, **__):
    raise AssertionError


def test_study_leaves_its_files_and_nothing_half_written(done):
    names = {p.name for p in done.folder.iterdir()}
    assert names == OUTPUTS | {"cells", "stages", "figures"}
    assert not list(done.folder.rglob(".*"))


def test_a_quick_look_draws_what_stands_first_in_each_part(done):
    assert {p.name for p in (done.folder / "figures").iterdir()} == FIRST_FIGURES


def test_a_whole_study_draws_all_figures(done):
    content = replace(done.content, quick=False)
    setting = content.setting
    room_map = map_stage(MapCase(setting=setting, progress=Progress()), done.folder / "stages")
    rooms = [("the study's room", "room", setting), ("with a cabinet", "with-a-cabinet", setting)]
    groups = publish._groups(content, room_map, rooms)
    figures = [one for group in groups for one in group()]
    assert {one.file for one in figures} >= FIRST_FIGURES | {
        "rss_distance_dipole.png",
        "bearing_error.png",
        "error_distribution.png",
        "map_rss_tags.png",
        "map_bearing_error.png",
        "map_bearing_rms.png",
        "map_capture.png",
        "percentiles.png",
        "rss_time_room.png",
        "rss_time_with-a-cabinet.png",
    }
    sections = {one.section for one in figures}
    assert sections >= {"sweep", "reader", "room", "scene", "mission"}


def test_outcome_says_which_design_why_how_the_missions_went_and_where_the_report_is(done):
    text = "\n".join(done.lines())
    assert done.lines()[0] == done.content.verdict.sentence
    assert done.content.chosen.label in text
    assert "coupling between antennas" in text
    assert "Mission in the study's room: " in text
    assert "Mission in With a Cabinet: " in text
    assert str(done.folder / "report.html") in text
    assert done.failed == ()


def test_results_hold_everything_with_units_and_the_whole_study(done):
    data = read_dataset(done.folder / "results.nc")
    assert {"antenna", "x", "y", "design", "run", "step"} <= set(data.dims)
    for name, item in data.variables.items():
        assert item.attrs["units"], name
        assert item.attrs["long_name"], name
    assert data.attrs["seed"] == 5
    assert load_text(data.attrs["study"]) == small()
    assert data.attrs["chosen_design"] == done.content.chosen.label
    ranks = data["rank"].values
    assert sorted(ranks) == [1, 2]
    best = int(np.argmin(ranks))
    assert data["design"].values[best] == done.content.chosen.label
    for i, place in enumerate(("free", "room")):
        scores = getattr(done.content.chosen, place)
        assert data["right_share"].values[best, i] == scores.right_share


def load_text(text):
    return parse_study(text, source="results", directory=Path.cwd())


def test_study_file_in_the_folder_reads_back_to_the_same_study(done):
    assert load_study(done.folder / "study.toml") == small()


def test_tables_have_one_row_for_each_run_and_the_trajectory_all_antennas(done):
    with (done.folder / "missions.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == study.QUICK_RUNS
    with (done.folder / "trajectory.csv").open() as file:
        header = next(csv.reader(file))
    assert header[-8:] == [f"rss_{i}_w" for i in range(1, 9)]


def test_table_of_designs_has_every_score_with_the_numbers_of_the_results(done):
    with (done.folder / "designs.csv").open() as file:
        rows = list(csv.DictReader(file))
    data = read_dataset(done.folder / "results.nc")
    assert [int(row["rank"]) for row in rows] == data["rank"].values.tolist()
    assert [float(row["antenna_radius_m"]) for row in rows] == [0.05, 0.10]
    for i, place in enumerate(("free", "room")):
        for name in SCORE_NAMES:
            column = [float(row[f"{place}_{name}"]) for row in rows]
            np.testing.assert_array_equal(column, data[name].values[:, i])


def test_results_and_tables_agree(done):
    data = read_dataset(done.folder / "results.nc")
    with (done.folder / "missions.csv").open() as file:
        rmse = [float(row["rmse_m"]) for row in csv.DictReader(file)]
    own = list(data["place"].values).index("the study's room")
    np.testing.assert_array_equal(data["mission_rmse_m"].values[own], rmse)


def test_report_opens_with_the_chosen_design_and_escapes_the_studys_name(done):
    page = (done.folder / "report.html").read_text("utf-8")
    powers = read_dataset(done.folder / "results.nc")["map_rss_w"].values
    assert f"All {np.isfinite(powers).sum()} powers of the antennas in the map were checked" in page
    assert "tiny &lt;study&gt;" in page
    assert "<study>" not in page
    assert page.index("Chosen:") < page.index("<h2")
    assert page.count("data:image/png;base64,") == len(list((done.folder / "figures").iterdir()))
    assert "max_reflections = 1" in page
    assert "is moved 5\u202fcm off it" in page


def test_second_run_computes_and_writes_nothing(done, monkeypatch):
    before = {p: p.stat().st_mtime_ns for p in done.folder.rglob("*.*") if p.name != "study.toml"}
    for module, name in (
        (sweep, "scored_cell"),
        (MissionJob, "__call__"),
        (publish, "write_dataset"),
    ):
        monkeypatch.setattr(module, name, never)
    again = run_study(small(), done.folder, quick=True)
    # the computing time of this run is the only thing that may differ
    assert again.lines() == done.lines()
    assert before == {p: p.stat().st_mtime_ns for p in before}


@pytest.mark.slow
def test_lost_outputs_are_written_again_from_what_was_kept(done, monkeypatch):
    monkeypatch.setattr(sweep, "scored_cell", never)
    monkeypatch.setattr(MissionJob, "__call__", never)
    (done.folder / "report.html").unlink()
    run_study(small(), done.folder, quick=True)
    assert (done.folder / "report.html").exists()


def test_another_study_in_the_same_folder_is_refused_and_nothing_changes(done):
    before = (done.folder / "study.toml").read_bytes()
    for other, quick in ((small(TEXT.replace("seed = 5", "seed = 6")), True), (small(), False)):
        with pytest.raises(ConfigError, match="--force"):
            run_study(other, done.folder, quick=quick)
    assert (done.folder / "study.toml").read_bytes() == before
    assert (done.folder / "results.nc").exists()


def test_results_without_a_study_file_are_not_overwritten(tmp_path):
    (tmp_path / "report.html").write_text("precious")
    with pytest.raises(ConfigError, match="another study"):
        run_study(small(), tmp_path, quick=True)
    assert (tmp_path / "report.html").read_text() == "precious"


@pytest.mark.slow
def test_interrupted_study_goes_on_where_it_stopped(tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(stage, "drive", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_study(small(), tmp_path, quick=True)
    monkeypatch.undo()
    assert len(list((tmp_path / "cells").iterdir())) == 2
    assert not (tmp_path / "report.html").exists()
    monkeypatch.setattr(sweep, "scored_cell", never)
    outcome = run_study(small(), tmp_path, quick=True)
    assert outcome.report.exists()


@pytest.mark.slow
def test_forced_run_replaces_another_studys_results(tmp_path):
    text = TEXT[: TEXT.index("[[layout]]")]
    run_study(small(), tmp_path, quick=True)
    run_study(small(text), tmp_path, quick=True, force=True)
    assert not (tmp_path / "missions-with-a-cabinet.csv").exists()
    assert load_study(tmp_path / "study.toml") == small(text)


@pytest.mark.slow
def test_mission_that_cannot_be_driven_is_a_result_with_its_reason(tmp_path, monkeypatch):
    def refused(*_, **__):
        raise NavigationError("all antennas receive the same.")

    monkeypatch.setattr(stage, "drive", refused)
    outcome = run_study(small(), tmp_path, quick=True)
    assert "could not be driven: all antennas receive the same." in "\n".join(outcome.lines())
    assert not (tmp_path / "missions.csv").exists()
    assert outcome.report.exists()


@pytest.mark.slow
def test_failed_design_is_told_and_does_not_stop_the_study(tmp_path):
    text = TEXT.replace("[0.05, 0.10]", '[0.002, 0.10]\nantenna = ["monopole"]')
    outcome = run_study(small(text[: text.index("[mission]")]), tmp_path, quick=True)
    ((label, reason),) = outcome.failed
    assert "0.2 cm" in label
    assert "monopole_plane_m" in reason
    page = outcome.report.read_text("utf-8").replace("<i>r</i><sub>a</sub>", "r_a")
    page = page.replace("\u202f", " ")
    assert label.split(" h_p")[0] in page
    data = read_dataset(tmp_path / "results.nc")
    assert np.isnan(data["right_share"].values[0]).all()
    assert data["rank"].values.tolist() == [-1, 1]


def test_study_without_any_design_that_can_be_built_says_so(tmp_path):
    text = TEXT.replace("[0.05, 0.10]", '[0.002]\nantenna = ["monopole"]')
    with pytest.raises(SweepStateError, match=r"none of the 1 designs.*monopole_plane_m"):
        run_study(small(text), tmp_path, quick=True)


def test_quick_look_says_that_it_is_one(done):
    assert (done.folder / "study.toml").read_text("utf-8").startswith("# A quick look")
    assert "quick look" in done.report.read_text("utf-8")


@pytest.mark.slow
def test_free_space_study_runs_without_room_scores(tmp_path):
    start, end = TEXT.index("box_m"), TEXT.index("[[tag]]")
    text = TEXT[:start] + "free_space = true\n" + TEXT[end : TEXT.index("[[layout]]")]
    outcome = run_study(small(text), tmp_path, quick=True)
    assert outcome.content.chosen.room is None
    data = read_dataset(tmp_path / "results.nc")
    assert np.isnan(data["right_share"].values[:, 1]).all()


@pytest.mark.slow
def test_layouts_whose_names_give_one_file_name_are_kept_apart(tmp_path):
    layouts = '[[layout]]\nname = "a b"\n[[layout]]\nname = "A-B"\n'
    outcome = run_study(small(TEXT[: TEXT.index("[[layout]]")] + layouts), tmp_path, quick=True)
    slugs = [m.slug for m in outcome.content.missions]
    assert slugs == ["room", "a-b", "a-b-2"]
    stamp = json.loads((tmp_path / "stages" / "finished.json").read_text())
    assert {"missions-a-b.csv", "missions-a-b-2.csv"} <= set(stamp["files"])


FULLWAVE = """
name = "full wave"
[room]
free_space = true
[[tag]]
id = "A"
position_m = [1.0, 1.0, 3.0]
antenna = "dipole"
[reader]
antennas = 4
plate_height_m = 0.0
cells_per_wavelength = 6
[sweep]
antenna_radius_m = [0.08]
[map]
spacing_m = 2.0
"""


@pytest.mark.slow
def test_full_wave_study_says_how_far_the_approximations_are_off(tmp_path):
    outcome = run_study(small(FULLWAVE), tmp_path / "out")
    off = {e.model: e for e in outcome.content.approximations}
    assert set(off) == {"rays", "isolated"}
    # isolated antennas are all alike, so that one in four guesses is right
    assert off["isolated"].other_antenna_share == pytest.approx(0.75, abs=0.01)
    assert off["rays"].strong_rms_db > 0.5
    report = outcome.report.read_text("utf-8")
    assert "How far the approximations are off" in report
    assert f"{off['rays'].strong_rms_db:.1f}" in report
    stored = read_dataset(tmp_path / "out" / "results.nc").attrs
    assert stored["response"] == "fullwave"
    assert {e["model"] for e in json.loads(stored["approximations"])} == {"rays", "isolated"}


@pytest.mark.slow
def test_design_that_the_full_wave_model_refuses_is_a_failed_cell_with_its_reason(tmp_path):
    text = FULLWAVE.replace("[0.08]", "[0.08, 0.001]").replace(
        "plate_height_m = 0.0", "plate_height_m = 0.05"
    )
    outcome = run_study(small(text), tmp_path / "out", quick=True)
    ((label, reason),) = outcome.failed
    assert outcome.content.approximations == ()  # which a quick look leaves out
    assert "r_a = 0.1 cm" in label
    assert "touches" in reason


def test_approximate_study_is_not_compared(done):
    assert done.content.approximations == ()


@pytest.mark.slow
def test_design_of_another_height_and_number_of_antennas_is_driven_as_it_was_scored(tmp_path):
    text = TEXT.replace(
        "antenna_radius_m = [0.05, 0.10]", "antennas = [6, 8]\nheight_m = [0.2, 0.4]"
    )
    text = text.replace('"rays"', '"isolated"')
    outcome = run_study(small(text[: text.index("[[layout]]")]), tmp_path, quick=True)
    chosen = outcome.content.chosen_cell.design
    used = outcome.content.setting.study
    assert (used.reader.antennas, used.reader.height_m) == (chosen.antennas, chosen.height_m)
    assert used.map.height_m == chosen.height_m
    data = read_dataset(tmp_path / "results.nc")
    assert data.sizes["antenna"] == chosen.antennas
    known = np.isfinite(data["free_rss_w"].values).all(axis=(1, 2, 3))
    assert known.tolist() == [c.design.antennas == chosen.antennas for c in outcome.content.cells]
    assert np.isfinite(data["right_share"].values).all()
    assert "antennas = 6 height = 20 cm" in data["design"].values[0]


def test_the_verdict_is_kept_with_the_results(done):
    kept = open_results(done.folder).verdict
    assert (kept.sentence, kept.numbers) == (done.lines()[0], done.content.verdict.numbers)
    assert kept.advice.text() == done.content.verdict.advice.text()


@pytest.mark.slow
def test_missions_decide_between_the_best_designs_where_the_study_says_so(tmp_path):
    text = TEXT[: TEXT.index("[[layout]]")] + "[choice]\nmissions = 2\nby_missions = true\n"
    content = run_study(small(text), tmp_path, quick=True).content
    reached = [sum(m.success for m in one.missions[0].metrics) for one in content.driven]
    assert [one.index for one in content.driven] == list(content.choice.ranking[:2])
    assert reached == sorted(reached, reverse=True)
    assert content.choice.chosen == content.driven[0].index
    told = " ".join(content.choice.reason)
    assert "did not change the choice" in told or "By the scores alone" in told
    assert content.setting.study.reader == content.chosen_cell.design
