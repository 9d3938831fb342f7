"""``octant optimise``: what it leaves, going on after Ctrl-C, refusals."""

import csv
import hashlib

import pytest

from octant.reader_design.experiments.optimise import evaluation
from octant.reader_design.study_file.loading import load_study

STUDY = """
name = "small search"
[room]
free_space = true
[[tag]]
id = "a"
position_m = [0.0, 0.0, 3.0]
antenna = "dipole"
[reader]
response = "isolated"
antenna_length_m = 0.0625
[optimise]
survey = 3
evaluations = 6
parameters = {antenna_length_m = [0.03, 0.12], antenna_radius_m = [0.05, 0.11]}
[[optimise.goal]]
score = "level_dbm"
value = -20.0
[[optimise.goal]]
score = "height_m"
value = 0.06
weight = 100.0
"""


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def digests(folder):
    return {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.suffix in {".csv", ".json", ".toml", ".html", ".svg"}
    }


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A search that ran to its end without interruption."""
    from octant.reader_design.cli import run

    folder = tmp_path_factory.mktemp("search")
    (folder / "study.toml").write_text(STUDY)
    assert run(["optimise", str(folder / "study.toml"), "--out", str(folder / "out"), "-q"]) == 0
    return folder / "out"


def test_leaves_tables_figures_drawing_and_report(finished):
    names = {path.name for path in finished.rglob("*") if path.is_file()}
    assert names >= {
        "optimise.csv",
        "pareto.csv",
        "best.toml",
        "study.toml",
        "report.html",
        "pareto.png",
        "convergence.png",
        "comparison.png",
        "drawing.png",
        "drawing.svg",
        "drawing.pdf",
    }
    page = (finished / "report.html").read_text()
    assert "The short list" in page
    assert page.count("data:image/png;base64,") == 4
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")


def test_tables_tell_every_design_and_why_it_is_infeasible(finished):
    table = rows(finished / "optimise.csv")
    assert table[0]["stage"] == "reader"
    assert [row["number"] for row in table] == [str(i) for i in range(len(table))]
    for row in table:
        if row["reason"]:
            assert row["attainment"] == row["level_dbm"] == ""
        else:
            assert float(row["height_m"]) <= 0.1 + 1e-9
            assert float(row["antenna_radius_m"]) <= 0.1 + 1e-9
    assert any("footprint" in row["reason"] for row in table)
    front = rows(finished / "pareto.csv")
    assert {row["number"] for row in front} <= {r["number"] for r in table if not r["reason"]}


def test_best_study_has_the_winner_as_its_reader(finished):
    best = load_study(finished / "best.toml")
    table = [row for row in rows(finished / "optimise.csv") if not row["reason"]]
    winner = max(table, key=lambda row: float(row["attainment"]))
    assert best.optimise is None
    assert best.reader.antenna_length_m == float(winner["antenna_length_m"])
    assert best.reader.antenna_radius_m == float(winner["antenna_radius_m"])


@pytest.mark.slow
def test_interrupted_search_goes_on_to_the_same_bits(
    octant, study_file, tmp_path, finished, monkeypatch
):
    study, out = study_file(STUDY), tmp_path / "out"
    true_rss, calls = evaluation.rss_over_azimuth, []

    def interrupted(*arguments):
        if len(calls) == 3:
            raise KeyboardInterrupt
        calls.append(arguments[1])
        return true_rss(*arguments)

    monkeypatch.setattr(evaluation, "rss_over_azimuth", interrupted)
    call = octant("optimise", study, "--out", out, "--workers", "1")
    assert call.code == 130
    assert "the same command goes on" in call.err
    assert not (out / "report.html").exists()
    assert len(list((out / "evaluations").iterdir())) >= 3

    monkeypatch.setattr(
        evaluation, "rss_over_azimuth", lambda *a: calls.append(a[1]) or true_rss(*a)
    )
    assert octant("optimise", study, "--out", out, "--workers", "1").code == 0
    assert len(calls) == len(set(calls))  # nothing was computed twice
    assert digests(out) == digests(finished)

    again = octant("optimise", study, "--out", out)
    assert again.code == 0
    assert "is complete already" in again.err


def test_folder_of_another_search_is_kept(octant, study_file, finished):
    other = study_file(STUDY.replace("evaluations = 6", "evaluations = 5"))
    before = digests(finished)
    assert (
        "holds the results of another study"
        in octant("optimise", other, "--out", finished).refused()
    )
    assert digests(finished) == before


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("antenna_length_m = [", "antenna_lenght_m = [", "did you mean 'antenna_length_m'"),
        ("[0.03, 0.12]", "[0.12, 0.03]", "first bound must lie below the second"),
        ("[0.03, 0.12]", "[0.11, 0.12]", "none of the"),
        ("[optimise]", "[optimise]\nfootprint_m = 0.1", "none of the"),
        ('response = "isolated"', 'response = "files"', "pattern_files"),
    ],
)
def test_refusals_are_one_sentence(octant, study_file, tmp_path, old, new, told):
    text = STUDY.replace(old, new, 1)
    if told == "none of the" and "0.11" in new:
        text = text.replace("antenna_length_m = 0.0625", "antenna_length_m = 0.11")
    call = octant("optimise", study_file(text), "--out", tmp_path / "out", "-q")
    assert told in call.refused()


def test_dry_run_says_what_would_be_done_and_does_nothing(octant, study_file, tmp_path):
    call = octant("optimise", study_file(STUDY), "--out", tmp_path / "out", "--dry-run")
    assert call.code == 0
    assert "At most 11 designs" in call.out
    assert "antenna_length_m, antenna_radius_m" in call.out
    assert not (tmp_path / "out").exists()


def test_a_study_without_the_table_is_refused(octant, study_file, tmp_path):
    text = STUDY.partition("[optimise]")[0]
    told = octant("optimise", study_file(text), "--out", tmp_path / "out").refused()
    assert "no table [optimise]" in told
