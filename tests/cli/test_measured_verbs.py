"""octant compare and octant calibrate: from a log's file to a fitted study, and bad input."""

import csv

import numpy as np
import pytest
from click.testing import CliRunner
from measured_room import log_of, measured_study, some_poses, study_text, truth_dbm

from octant.navigation.logs.log_csv import write_log
from octant.reader_design.cli import octant as program
from octant.reader_design.study_file.loading import load_study


def call(*words):
    return CliRunner().invoke(program, [*map(str, words)], catch_exceptions=False)


def table(file):
    return list(csv.DictReader(file.read_text("utf-8").splitlines()))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study, and a log of a flat whose wall differs from it."""
    where = tmp_path_factory.mktemp("verbs")
    poses = some_poses(260)
    true = measured_study(where, sigma=0.06)
    level = truth_dbm(true, poses) + np.random.default_rng(6).normal(1.0, 3.0, (len(poses), 4))
    write_log(where / "log.csv", log_of(level, poses))
    (where / "study.toml").write_text(study_text(where))
    return where


def test_compare_writes_what_it_says_and_no_more_the_second_time(folder):
    words = ("compare", folder / "study.toml", "--log", folder / "log.csv", "--out", folder / "cmp")
    result = call(*words)
    assert result.exit_code == 0, result.output
    assert "local means" in result.stdout
    for name in ("compare.csv", "report.html", "study.toml", "figures/residuals.png"):
        assert (folder / "cmp" / name).stat().st_size > 0
    rows = table(folder / "cmp" / "compare.csv")
    bias = np.mean([float(r["measured_dbm"]) - float(r["predicted_dbm"]) for r in rows])
    assert bias == pytest.approx(0.0, abs=1.5)
    assert {r["id"] for r in rows} == {"a", "b", "c", "d"}
    again = call(*words)
    assert again.exit_code == 0
    assert "complete already" in again.stderr
    assert again.stdout == result.stdout


def test_calibrate_writes_a_study_that_fits_the_log_better(folder):
    fit = ("--fit", "level,sigma:material", "--log", folder / "log.csv", "--out", folder / "cal")
    result = call("calibrate", folder / "study.toml", *fit)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("Held-out error ")
    fitted = load_study(folder / "cal" / "fitted.toml")
    assert fitted.room.objects[0].material.sigma_s_per_m == pytest.approx(0.06, rel=0.15)
    rows = {row["parameter"]: row for row in table(folder / "cal" / "calibrated.csv")}
    wall = rows["sigma:material"]
    assert float(wall["low"]) < 0.06 < float(wall["high"])
    assert float(wall["before"]) == pytest.approx(0.02)
    text = (folder / "cal" / "fitted.toml").read_text()
    assert "# Fitted to a log, with 95 % intervals. Held-out error" in text
    assert "# sigma:material: 0.0" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--fit", "sigma"), "has no material ''"),
        (("--fit", "level", "--prior", "level:a"), "write NAME=MEAN:SD"),
        (("--fit", "level", "--prior", "level:z=1:1"), "it is not fitted"),
        (("--fit", "level", "--folds", "one"), "write anchors, or a number"),
        (("--fit", "level", "--log", "nowhere.csv"), "nowhere.csv does not exist"),
        (("--fit", "level", "--least", "500"), "choose larger cells"),
    ],
)
def test_bad_input_is_said_in_one_sentence(octant, folder, words, said):
    log = () if "--log" in words else ("--log", folder / "log.csv")
    sentence = octant("calibrate", folder / "study.toml", *words, *log, "--dry-run").refused()
    assert said in sentence


def test_a_log_in_milliwatts_is_noticed(octant, folder):
    rows = table(folder / "log.csv")
    wrong = folder / "milliwatts.csv"
    with wrong.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        for row in rows:
            writer.writerow(row | {"rss_dbm": repr(10.0 ** (0.1 * float(row["rss_dbm"])))})
    sentence = octant("compare", folder / "study.toml", "--log", wrong, "--dry-run").refused()
    assert "mw" in sentence.lower()
