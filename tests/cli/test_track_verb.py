"""``octant track``: a small study leaves its files; bad input is one sentence and exit code 2."""

import csv

import pytest

from octant.reader_design.experiments.tracking.results import COLUMNS
from octant.reader_design.showing.netcdf import read_dataset
from octant.reader_design.study_file.loading import load_study, parse_study, to_toml

SMALL = """
name = "small"
[room]
box_m = [12.0, 12.0, 3.0]
origin_m = [-6.0, -6.0, 0.0]
material = "concrete"
[track]
chapters = ["rss", "neighbouring", "slam"]
runs = 1
slam_runs = 3
[[track.trajectory]]
name = "my loop"
shape = "spline"
waypoints_m = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]]
closed = true
duration_s = 30.0
"""
ROOM = '[room]\nbox_m = [12.0, 12.0, 3.0]\norigin_m = [-6.0, -6.0, 0.0]\nmaterial = "concrete"\n'


def test_one_chapter_alone_leaves_its_table_and_a_report(octant, study_file, tmp_path):
    text = SMALL.replace('["rss", "neighbouring", "slam"]', '["rss"]')
    call = octant("track", study_file(text), "--out", tmp_path / "out", "-q", "--workers", "1")
    assert call.code == 0, call.err
    assert (tmp_path / "out" / "tracking.csv").is_file()
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.slow
def test_a_small_study_leaves_tables_figures_and_a_report(octant, study_file, tmp_path):
    study, out = study_file(SMALL), tmp_path / "out"
    done = octant("track", study, "--out", out, "-q", "--workers", "1")
    assert done.code == 0, done.err
    assert "lemniscate, average error" in done.out
    assert "NEES(3)" in done.out
    assert "my loop, neighbouring + EKF" in done.out
    rows = list(csv.DictReader((out / "tracking.csv").read_text().splitlines()))
    assert tuple(rows[0]) == COLUMNS
    assert {"point", "lemniscate", "my loop"} == {row["task"] for row in rows}
    data = read_dataset(out / "results.nc")
    assert data["average_m"].dims == ("outcome", "run")
    assert data["slam_nees"].shape == (2, 3)
    names = {path.name for path in (out / "figures").iterdir()}
    assert names == {
        "fig_6_3_rss.png",
        "fig_7_6_stabilisation.png",
        "fig_7_7_lemniscate.png",
        "own_1.png",
        "fig_7_15_slam.png",
    }
    report = (out / "report.html").read_text()
    assert report.count("data:image/png;base64") == 5
    assert "Theorem 7.4" in report
    assert load_study(out / "study.toml") == load_study(study)
    before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}
    again = octant("track", study, "--out", out)
    assert again.code == 0
    assert "complete already" in again.err
    assert again.out == done.out
    assert {p: p.read_bytes() for p in out.rglob("*") if p.is_file()} == before
    other = study_file(
        SMALL.replace('chapters = ["rss", "neighbouring", "slam"]', 'chapters = ["slam"]')
    )
    assert "another study" in octant("track", other, "--out", out, "-q").refused()
    changed = octant("track", other, "--out", out, "--force")
    assert changed.code == 0
    assert "parts" not in changed.err  # all of them were kept
    assert set(read_dataset(out / "results.nc").dims) == {"slam", "slam_run"}


@pytest.mark.slow
def test_a_killed_study_goes_on_where_it_stopped_with_the_same_bits(
    octant, study_file, tmp_path, monkeypatch
):
    from octant.reader_design.experiments.tracking import compute

    text = SMALL.replace('["rss", "neighbouring", "slam"]', '["rss", "slam"]')
    study, out = study_file(text), tmp_path / "out"
    assert octant("track", study, "--out", tmp_path / "whole", "-q", "--workers", "1").code == 0
    with monkeypatch.context() as patch:
        patch.setitem(compute._CHAPTERS, "slam", interrupted)
        stopped = octant("track", study, "--out", out, "-q", "--workers", "1")
    assert stopped.code == 130
    assert not (out / "report.html").exists()
    assert len(list((out / "cases").iterdir())) == 1
    plan = octant("track", study, "--out", out, "--dry-run")
    assert plan.out == "3 parts, of which 1 are computed already.\n"
    assert octant("track", study, "--out", out, "-q", "--workers", "1").code == 0
    whole, resumed = (read_dataset(f / "results.nc") for f in (tmp_path / "whole", out))
    assert whole.equals(resumed)


FURTHER = """
name = "further"
[room]
box_m = [12.0, 12.0, 3.0]
origin_m = [-6.0, -6.0, 0.0]
material = "concrete"
[track]
chapters = ["tags", "law", "slam line"]
tag_counts = [4]
tag_ranges_m = [5.0]
"""


@pytest.mark.slow
def test_further_chapters_leave_tables_resume_and_take_runs_seed_and_workers(
    octant, study_file, tmp_path
):
    study, out = study_file(FURTHER), tmp_path / "out"
    first = ("track", study, "--runs", "2", "--seed", "5", "-q", "--out")
    assert octant(*first, out, "--workers", "1").code == 0
    tables = {"tags.csv", "law.csv", "slam_line.csv", "tracking.csv"}
    assert tables <= {path.name for path in out.iterdir()}
    report = (out / "report.html").read_text()
    for figure in ("tags", "law", "slam_line"):
        assert (out / "figures" / f"{figure}.png").is_file()
    assert "The law fitted on line (6.3)" in report
    resolved = load_study(out / "study.toml")
    assert (resolved.seed, resolved.track.runs, resolved.track.slam_runs) == (5, 2, 2)
    again = octant(*[word for word in first if word != "-q"], out)
    assert "complete already" in again.err
    shared = tmp_path / "shared"
    assert octant(*first, shared, "--workers", "2").code == 0
    assert all((shared / name).read_bytes() == (out / name).read_bytes() for name in tables)
    victim = next((shared / "cases").glob("*.msgpack"))
    victim.unlink()
    assert "of which 7 are computed already" in octant(*first, shared, "--dry-run").out
    other = tmp_path / "other"
    assert octant("track", study, "--runs", "2", "--seed", "6", "-q", "--out", other).code == 0
    assert (other / "law.csv").read_bytes() != (out / "law.csv").read_bytes()


def interrupted(settings, part):
    del settings, part
    raise KeyboardInterrupt


def test_the_built_in_study_is_a_round_trip_with_every_default_written(tmp_path):
    study = load_study(built_in="track_study")
    text = to_toml(study)
    assert parse_study(text, source="again", directory=tmp_path) == study
    assert "# encoder_counts" in text
    assert "wheel_sigma_rad_per_s = 0.1" in text


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ("", "the study has no [track]"),
        ("[track]\nrun = 3\n", "did you mean 'runs'?"),
        (
            '[track]\n[[track.trajectory]]\nname = "lemniscate"\nshape = "sine"\n',
            "give every one its own name",
        ),
        ('[track]\nchapters = ["slamm"]\n', "did you mean 'slam'"),
        ('[track]\nchapters = ["tags"]\ntag_counts = [5]\n', "give 4 or 9"),
        ("[track]\ntag_count = 7\n", "or another pattern"),
        ("[track]\ntag_bits = 8\ntag_floor_dbm = 10.0\n", "must rise"),
        ('[track]\nrss_samples = "none.csv"\n', "does not exist"),
        ("[track]\nstate_weight = [1.0, 1.0, 0.0]\n", "singular"),
        (
            "[track]\nstate_weight = [[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n",
            "not symmetric",
        ),
        ("[track]\nfinal_weight = [[1.0, 0.0], [0.0]]\n", "array of numbers"),
        ("[track]\nrss_sigma_db = 0.0\n", "covariance"),
        ("[track]\nwheel_sigma_rad_per_s = 0.0\n", "covariance must not be zero"),
        ("[track]\nwheel_sigma_rad_per_s = -1.0\n", "-1.0 rad/s"),
        ("[track]\nwheel_rate_rad_per_s = 5.0\n", "'lemniscate' is infeasible"),
        (
            (
                '[track]\n[[track.trajectory]]\nname = "dash"\nshape = "line"\n'
                "waypoints_m = [[0.0, 0.0], [9.0, 0.0]]\nduration_s = 5.0\n"
            ),
            "'dash' is infeasible",
        ),
        (
            '[track]\n[[track.trajectory]]\nname = "x"\nshape = "spline"\n',
            "track.trajectory[0].waypoints_m has 0 points",
        ),
        (
            '[track]\n[[track.trajectory]]\nname = "x"\nshape = "sine"\nduration_s = 60.05\n',
            "multiple",
        ),
    ],
)
def test_bad_input_is_one_sentence(octant, study_file, tmp_path, table, match):
    study = study_file('name = "bad"\n' + ROOM + table)
    assert match in octant("track", study, "--out", tmp_path / "out").refused()
    assert not (tmp_path / "out").exists()


def test_a_room_too_small_for_the_tags_is_refused(octant, study_file, tmp_path):
    small = '[room]\nbox_m = [5.0, 5.0, 3.0]\nmaterial = "concrete"\n'
    study = study_file('name = "bad"\n' + small + '[track]\nchapters = ["room"]\n')
    assert "take a larger room" in octant("track", study, "--out", tmp_path / "out").refused()
