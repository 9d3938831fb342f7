"""``octant navigate --compare`` and ``--animate``: resumption, numbers, frames, refusals."""

import csv

import numpy as np
import pytest
from PIL import Image

from octant.navigation.missions.run import MissionJob
from octant.reader_design.experiments.missions.animation import frame_samples
from octant.reader_design.experiments.missions.comparison import (
    COLUMNS,
    plan_comparison,
)
from octant.reader_design.experiments.missions.comparison_table import load_comparison

YARD = """
name = "yard"
seed = 3
[room]
free_space = true
[[tag]]
id = "a"
position_m = [1.2, 0.2, 3.0]
antenna = "dipole"
[reader]
antennas = 4
cells_per_wavelength = 4
[mission]
navigator = "thesis"
start_m = [0.0, 0.0]
heading_deg = 0.0
tags = ["a"]
max_time_s = 14.0
runs = 7
"""
COMPARISON = """
name = "try"
seed = 3
runs = 2
[[layout]]
study = "yard.toml"
published_rmse_m = 0.09
[[controller]]
name = "five rules"
mission.controller = "fuzzy"
[[controller]]
name = "vector sum"
mission.controller = "vector_sum"
mission.rotation = "vector_sum"
"""


def test_a_controller_may_have_a_robot_of_its_own(study_file):
    study_file(YARD, "yard.toml")
    text = COMPARISON + 'robot.preset = "sputnik"\n'
    cells = plan_comparison(load_comparison(study_file(text, "compare.toml")))
    assert [cell.study.robot.preset for cell in cells] == [None, "sputnik"]


@pytest.fixture(scope="module", autouse=True)
def one_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("OCTANT_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture
def comparison(study_file):
    study_file(YARD, "yard.toml")
    return study_file(COMPARISON, "compare.toml")


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_comparison_resumes_and_its_numbers_are_those_of_single_runs(
    octant, comparison, study_file, tmp_path, monkeypatch
):
    out = tmp_path / "out"
    call = octant("navigate", comparison, "--compare", "--out", out, "--workers", "1")
    assert call.code == 0, call.err
    assert "cells" in call.err
    table = out / "compare.csv"
    rows = rows_of(table)
    assert tuple(rows[0]) == COLUMNS
    assert [row["controller"] for row in rows] == ["five rules", "vector sum"]
    assert "every combination" in (out / "report.html").read_text()

    study = study_file(YARD.replace('"a"]', '"a"]\ncontroller = "fuzzy"'), "single.toml")
    options = ("--out", tmp_path / "one", "--runs", "2", "-q", "--workers", "1")
    single = octant("navigate", study, *options)
    assert single.code == 0, single.err
    runs = rows_of(tmp_path / "one" / "missions.csv")
    assert float(rows[0]["rmse_median_m"]) == np.median([float(r["rmse_m"]) for r in runs])
    assert int(rows[0]["successes"]) == sum(int(r["success"]) for r in runs)
    assert float(rows[0]["time_median_s"]) == np.median([float(r["time_s"]) for r in runs])
    for column in ("p90_position_m", "p90_heading_deg"):
        stem, unit = column.rsplit("_", 1)
        median = np.median([float(r[column]) for r in runs])
        assert float(rows[0][f"{stem}_median_{unit}"]) == pytest.approx(median, rel=1e-12)
    kept = out / "cells" / rows[0]["cell"] / "missions.csv"
    assert kept.read_bytes() == (tmp_path / "one" / "missions.csv").read_bytes()

    before = table.read_bytes()
    again = octant("navigate", comparison, "--compare", "--out", out)
    assert again.code == 0
    assert "complete already" in again.err
    other = octant("navigate", comparison, "--compare", "--out", out, "--runs", "3")
    assert "another study" in other.refused()
    table.unlink()
    monkeypatch.setattr(MissionJob, "__call__", never)
    again = octant("navigate", comparison, "--compare", "--out", out, "-q")
    assert again.code == 0, again.err
    assert table.read_bytes() == before


def never(*_):
    raise AssertionError


@pytest.mark.slow
def test_an_interrupted_comparison_keeps_its_runs_and_says_so(
    octant, comparison, tmp_path, monkeypatch
):
    out, whole = tmp_path / "out", MissionJob.__call__

    def interrupted(job, seed):
        if "VectorSum" in type(job.navigator.controller).__name__:
            raise KeyboardInterrupt
        return whole(job, seed)

    monkeypatch.setattr(MissionJob, "__call__", interrupted)
    call = octant("navigate", comparison, "--compare", "--out", out, "-q", "--workers", "1")
    assert call.code == 130
    assert str(out) in call.err
    assert len(list((out / "cells" / "runs").glob("*.msgpack"))) == 1
    assert not (out / "compare.csv").exists()


def test_a_mission_that_is_driven_already_is_complete(octant, study_file, tmp_path, monkeypatch):
    study, out = study_file(YARD), tmp_path / "o"
    call = octant("navigate", study, "--out", out, "--runs", "2", "-q", "--workers", "1")
    assert call.code == 0, call.err
    figures = {path.stem for path in (out / "figures").iterdir()}
    assert figures == {"trajectory", "percentiles", "rss", "membership"}
    monkeypatch.setattr(MissionJob, "__call__", never)
    again = octant("navigate", study, "--out", out, "--runs", "2")
    assert again.code == 0, again.err
    assert "complete already" in again.err
    assert again.out == call.out
    assert "another study" in octant("navigate", study, "--out", out, "--runs", "3").refused()
    plan = octant("navigate", study, "--out", out, "--runs", "2", "--dry-run")
    assert plan.out == "2 runs, of which 2 are driven already.\n"


def test_an_animation_has_one_frame_a_sample(octant, study_file, tmp_path):
    study = study_file(YARD)
    gif = tmp_path / "run.gif"
    options = ("--out", tmp_path / "o", "--runs", "1", "--animate", gif, "-q", "--workers", "1")
    call = octant("navigate", study, *options)
    assert call.code == 0, call.err
    samples = len(rows_of(tmp_path / "o" / "trajectory.csv"))
    with Image.open(gif) as picture:
        assert picture.n_frames == samples
        first = np.asarray(picture.convert("RGB")).copy()
        picture.seek(samples - 1)
        assert (np.asarray(picture.convert("RGB")) != first).any()
    assert gif.stat().st_size < 3e6


@pytest.mark.parametrize(("samples", "most"), [(1, 5), (5, 5), (6, 5), (430, 120)])
def test_the_frames_of_a_long_run_are_spread_evenly_and_end_with_it(samples, most):
    frames = frame_samples(samples, most=most)
    assert len(frames) == min(samples, most)
    assert frames[0] == 0
    assert frames[-1] == samples - 1
    steps = np.diff(frames)
    assert not steps.size or steps.max() - steps.min() <= 1


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('study = "yard.toml"', 'study = "gone.toml"', "gone.toml"),
        ('"fuzzy"', '"fuzy"', "controller"),
        ('name = "vector sum"', 'name = "five rules"', "five rules"),
        ("runs = 2", "runs = 0", "runs"),
        ("published_rmse_m", "publishd_rmse_m", "published_rmse_m"),
        ("[[layout]]", "[[layout]]\nstudy = 'yard.toml'\n[[layout]]", "yard"),
        ("[[layout]]", "[[layout", "not TOML"),
    ],
)
def test_bad_comparisons_are_refused_before_anything_is_driven(
    octant, comparison, tmp_path, old, new, told
):
    comparison.write_text(comparison.read_text().replace(old, new))
    out = tmp_path / "out"
    assert told in octant("navigate", comparison, "--compare", "--out", out).refused()
    assert not out.exists()


def test_a_missing_comparison_and_a_wrong_animation_are_refused(octant, comparison, tmp_path):
    gone = octant("navigate", tmp_path / "gone.toml", "--compare", "--out", tmp_path / "o")
    assert "gone.toml" in gone.refused()
    options = ("--out", tmp_path / "o", "--animate", tmp_path / "a.png")
    assert ".gif" in octant("navigate", tmp_path / "yard.toml", *options).refused()
    assert "--compare" in octant("navigate", comparison, "--compare", *options).refused()


@pytest.mark.slow
def test_runs_are_localised_by_map_and_bearings_and_resume(octant, study_file, tmp_path):
    text = YARD.replace(
        "[reader]",
        "".join(
            f'[[tag]]\nid = "{name}"\nposition_m = [{x}, {y}, 3.0]\nantenna = "dipole"\n'
            for name, x, y in (("b", 2.0, 1.5), ("c", 0.4, 1.4))
        )
        + "[reader]",
    )
    text = text.replace('tags = ["a"]', 'tags = ["a", "b", "c"]').replace("antennas = 4", "")
    study, out = study_file(text, "yard.toml"), tmp_path / "out"
    call = octant("navigate", study, "--localise", "--runs", "2", "--noise-db", "0", "--out", out)
    assert call.code == 0, call.err
    rows = rows_of(out / "localisation.csv")
    assert [row["method"] for row in rows] == ["distance-RSS map", "bearings"] * 2
    assert all(float(row["median_m"]) < 0.1 for row in rows)  # no noise
    assert call.out.count("Localisation by") == 2
    moves = rows_of(out / "orientation.csv")
    assert len(moves) == len(rows_of(out / "trajectory.csv"))
    pairs = [
        [float(r[k]) for k in ("error_deg", "propagated_deg")] for r in moves if r["error_deg"]
    ]
    off = [abs(a - b) for a, b in pairs if np.isfinite(b)]
    assert np.median(off) < 3.0
    for name in ("localisation", "orientation_error", "membership"):
        assert (out / "figures" / f"{name}.png").stat().st_size > 5_000
    before = (out / "localisation.csv").read_bytes()
    again = octant("navigate", study, "--localise", "--runs", "2", "--noise-db", "0", "--out", out)
    assert "complete already" in again.err
    assert (out / "localisation.csv").read_bytes() == before


def test_localise_and_compare_are_refused_together(octant, comparison, tmp_path):
    call = octant("navigate", comparison, "--compare", "--localise", "--out", tmp_path / "out")
    assert "--localise" in call.refused()


def test_an_error_is_swept_until_missions_break(octant, comparison, tmp_path):
    sweep = '[[error]]\nname = "noise"\nkey = "noise_db"\nvalues = [3.0, 30.0, 60.0]\n'
    text = comparison.read_text().replace("runs = 2", "runs = 1\nbreaks_below = 1.0", 1)
    comparison.write_text(text + sweep)
    out = tmp_path / "out"
    call = octant("navigate", comparison, "--compare", "--out", out, "--workers", "1")
    assert call.code == 0, call.err
    rows = [row for row in rows_of(out / "compare.csv") if row["controller"] == "vector sum"]
    assert [row["error"] for row in rows] == ["", "noise", "noise", "noise"]
    assert [row["value"] for row in rows] == ["", "3.0", "30.0", "60.0"]
    driven = [row for row in rows if row["runs"] == "1"]
    failed = [int(row["successes"]) < 1 for row in driven[1:]]
    assert failed == [False] * (len(failed) - 1) + [True]
    assert driven[-1]["failures"].startswith("1 ")
    for row in rows[len(driven) :]:
        assert "broke the missions" in row["failed_because"]
    assert (out / "figures" / "sensitivity.png").is_file()
    assert "How exact a survey must be" in (out / "report.html").read_text()
