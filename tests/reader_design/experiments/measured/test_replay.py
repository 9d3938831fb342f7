"""Recorded drives of robots with any antennas give bearings and places, or one sentence."""

import math
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.navigation.angles import wrap_angle
from octant.navigation.logs.log_csv import read_log, write_log
from octant.navigation.logs.records import Log, taken
from octant.reader_design import cli
from octant.reader_design.experiments.measured import replay_kept
from octant.reader_design.experiments.measured.replay import Replayed, tracker_said
from octant.reader_design.experiments.measured.replay_patterns import read_gains, write_gains
from octant.reader_design.experiments.measured.replay_results import (
    Limits,
    sentences,
    summary_of,
    summary_of_all,
)
from octant.reader_design.experiments.measured.replay_run import (
    ReplayOptions,
    prepared,
    run_replay,
)
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.measured import measured_log, with_log
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study

STUDY = """
[room]
free_space = true
[[tag]]
id = "A"
position_m = [2.0, 1.0, 1.5]
antenna = "dipole"
[[tag]]
id = "B"
position_m = [-1.0, -2.0, 1.5]
antenna = "dipole"
[reader]
response = "isolated"
"""
TAGS = np.array([[2.0, 1.0], [-1.0, -2.0]])
HEIGHT_M = 1.2
AZIMUTHS = {
    1: (20.0,),
    5: (0.0, 60.0, 150.0, -140.0, -50.0),
    8: (-90.0, -45.0, 0.0, 45.0, 90.0, 135.0, 180.0, -135.0),
}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return parse_study(STUDY, source="study.toml", directory=tmp_path_factory.mktemp("study"))


def drive():
    """Return poses of a spin on the spot and of a way round the middle, (m, 3) [m], [rad]."""
    spin = np.column_stack([np.zeros(25), np.zeros(25), np.linspace(0.0, 2.0 * np.pi, 25)])
    way = [np.array([0.0, 0.0, 2.0 * np.pi])]
    for _ in range(60):
        x, y, h = way[-1]
        way.append(np.array([x + 0.1 * np.cos(h), y + 0.1 * np.sin(h), h + 0.1]))
    return np.vstack([spin, way[1:]])


def recorded(antennas, *, noise_db=1.0, level_dbm=-20.0):
    """Return the log of a robot whose antennas have a broad beam at their azimuths."""
    azimuths = np.radians(AZIMUTHS[antennas])
    poses = drive()
    rng = np.random.default_rng(antennas)
    m = len(poses)
    away = TAGS[None] - poses[:, None, :2]
    bearing = np.arctan2(away[..., 1], away[..., 0]) - poses[:, None, 2]
    distance2 = np.sum(away**2, axis=-1) + HEIGHT_M**2
    gain = 7.0 * np.cos(bearing[..., None] - azimuths)
    level = level_dbm - 10.0 * np.log10(distance2)[..., None] + gain
    level += noise_db * rng.standard_normal(level.shape)
    step = np.diff(poses, axis=0, prepend=poses[:1])
    way = np.hypot(step[:, 0], step[:, 1]) / np.sinc(step[:, 2] / (2.0 * np.pi))
    shape = (m, 2, antennas)
    first = np.zeros(shape, dtype=bool)
    first[:, 0, 0] = True
    return Log(
        ids=("A", "B"),
        time_s=np.repeat(0.5 * np.arange(m), 2 * antennas),
        poses=np.repeat(poses, 2 * antennas, axis=0),
        sources=np.broadcast_to([[0], [1]], shape).reshape(-1),
        antennas=np.broadcast_to(np.arange(1, antennas + 1), shape).reshape(-1),
        rss_dbm=level.reshape(-1),
        frequency_hz=np.full(level.size, np.nan),
        distance_m=np.where(first, way[:, None, None], 0.0).reshape(-1),
        turn_rad=np.where(first, step[:, None, None, 2], 0.0).reshape(-1),
    )


def replay(study, log, estimator, **options):
    antennas = int(log.antennas.max())
    options = {"azimuths_rad": tuple(np.radians(AZIMUTHS[antennas])), **options}
    ready = prepared(study, log, ReplayOptions(estimator=estimator, **options))
    with TemporaryDirectory() as folder:
        return run_replay(ready, Path(folder), progress=Progress())


def whole(found):
    return summary_of_all(found, Limits())


@pytest.mark.parametrize("antennas", [5, 8])
@pytest.mark.parametrize(
    ("estimator", "median_deg"), [("strongest", 36.0), ("vector_sum", 8.0), ("pattern", 6.0)]
)
def test_bearings_of_antennas_at_any_azimuths_point_at_the_tags(
    study, antennas, estimator, median_deg
):
    patterns = {"patterns": "spin"} if estimator == "pattern" else {}
    found = whole(replay(study, recorded(antennas), estimator, **patterns))
    assert found.bearing_share == 1.0
    assert found.median_deg < median_deg


@pytest.mark.parametrize(("antennas", "place_m"), [(1, 1.2), (5, 0.5), (8, 0.5)])
def test_the_tracker_finds_the_tags_by_its_own_spin_whatever_the_level(study, antennas, place_m):
    found = [
        replay(study, recorded(antennas, level_dbm=level_dbm), "tracker", patterns="spin")
        for level_dbm in ((-20.0, -75.0) if antennas == 1 else (-20.0,))
    ]
    assert whole(found[0]).place_median_m < place_m
    assert whole(found[0]).median_deg < 8.0
    away = found[0][0].place_m - found[-1][0].place_m
    np.testing.assert_allclose(away[~np.isnan(away)], 0.0, atol=1e-6)


def test_a_single_antenna_has_bearings_while_the_robot_turns(study):
    log = recorded(1)
    with pytest.raises(ConfigError, match="needs 3 directions; give --combine-s S"):
        replay(study, log, "vector_sum")
    found = replay(study, log, "vector_sum", combine_s=12.0)
    spin = [one.bearing_error_rad[20:25] for one in found]
    assert np.degrees(np.abs(np.concatenate(spin))).max() < 15.0
    fitted = replay(study, log, "pattern", combine_s=12.0, patterns="spin")
    assert np.degrees(np.abs(fitted[0].bearing_error_rad[20:25])).max() < 15.0


def test_gaps_repeats_and_what_was_not_heard_cost_little(study):
    log = recorded(8)
    rng = np.random.default_rng(0)
    rows = np.flatnonzero((rng.random(len(log)) > 0.1) | (log.distance_m != 0.0))
    rows = np.sort(np.concatenate([rows, rows[::50]]))  # some are noted twice
    sick = taken(log, rows)
    weak = np.quantile(sick.rss_dbm, 0.2)
    level = np.where(sick.rss_dbm < weak, -np.inf, sick.rss_dbm)
    sick = Log(**{**{f: getattr(sick, f) for f in Log.__dataclass_fields__}, "rss_dbm": level})
    for estimator, patterns in (("vector_sum", {}), ("tracker", {"patterns": "spin"})):
        found = whole(replay(study, sick, estimator, **patterns))
        assert found.median_deg < 15.0
        assert np.isfinite(found.p90_deg)


def test_without_truth_there_is_a_result_and_it_says_so(study):
    log = recorded(5)
    nowhere = np.full((len(log), 3), np.nan)
    blind = Log(**{**{f: getattr(log, f) for f in Log.__dataclass_fields__}, "poses": nowhere})
    found = replay(study, blind, "pattern", patterns="spin")
    assert np.isfinite(found[0].bearing_rad).all()
    assert any("no true pose" in line for line in sentences("pattern", found, Limits()))
    # its own bearings agree with those of the robot that knows its pose
    told = replay(study, log, "pattern", patterns="spin")
    away = wrap_angle(found[0].bearing_rad - told[0].bearing_rad)
    assert np.degrees(np.median(np.abs(away))) < 10.0


def test_a_spin_is_seen_by_its_poses_where_odometry_has_lost_some_of_it(study):
    log = recorded(8)
    lost = (np.arange(len(log)) % 3 == 0) & (log.distance_m == 0.0) & (log.turn_rad != 0.0)
    found = replay(study, taken(log, ~lost), "pattern", patterns="spin")
    assert whole(found).median_deg < 6.0


def test_a_robot_that_never_turns_has_no_spin(study):
    log = recorded(5)
    straight = taken(log, log.time_s > 13.0)
    with pytest.raises(ConfigError, match="no turn on the spot of 300 deg"):
        replay(study, straight, "pattern", patterns="spin")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            {"azimuths_rad": (0.0, 1.0)},
            "--azimuths-deg gives 2, but the log has readings of antenna 5",
        ),
        ({"azimuths_rad": (0.0, 0.0, 1.0, 2.0, 3.0)}, "each antenna needs its own direction"),
        ({"estimator": "tracker"}, "give --patterns spin or a file"),
        ({"estimator": "map"}, "give a reader like the log's"),
    ],
)
def test_antennas_that_do_not_fit_are_refused(study, options, said):
    options = {"estimator": "strongest", **options}
    with pytest.raises(ConfigError) as caught:
        replay(study, recorded(5), **options)
    assert said in str(caught.value)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
def test_the_map_follows_the_robot_that_carries_the_studys_reader(tmp_path):
    text = STUDY.replace("free_space = true", 'box_m = [4.0, 3.0, 2.5]\nmaterial = "concrete"')
    text = text.replace("[2.0, 1.0, 1.5]", "[3.0, 1.0, 2.0]").replace(
        "[-1.0, -2.0, 1.5]", "[1.0, 2.0, 2.0]"
    )
    text += "[solver]\nmax_reflections = 1\n"
    (tmp_path / "study.toml").write_text(text)
    log = tmp_path / "log.csv"
    poses = tmp_path / "poses.csv"
    rows = [f"{1.0 + 0.1 * k},1.5,0" for k in range(12)]
    poses.write_text("\n".join(["x_m,y_m,heading_deg", *rows]))
    study = str(tmp_path / "study.toml")
    simulate = ["simulate-log", study, "--out", str(log), "--way", str(poses), "-q"]
    assert cli.run([*simulate, "--noise-db", "1"]) == 0
    whole_study = with_log(parse_study(text, source="study.toml", directory=tmp_path))
    measured = measured_log(whole_study, build_setting(whole_study).scene, file=log, motion=True)
    ready = prepared(whole_study, measured.log, ReplayOptions(estimator="map"))
    found = run_replay(ready, tmp_path, progress=Progress())
    assert whole(found).place_final_m < 0.1
    assert found[0].true_place_m[-1].tolist() == [pytest.approx(2.1), 1.5]


def test_tags_that_the_tracker_has_followed_are_not_followed_again(study, tmp_path, monkeypatch):
    log = recorded(5)
    ready = prepared(
        study, taken(log, log.time_s < 16.0),
        ReplayOptions(
            estimator="tracker", patterns="spin", azimuths_rad=tuple(np.radians(AZIMUTHS[5]))
        ),
    )  # fmt: skip
    whole_run = run_replay(ready, tmp_path / "whole", progress=Progress())
    followed = []

    def until_the_second(rounds, filters, *, seed):
        followed.extend(filters)
        if len(followed) == 2:
            raise KeyboardInterrupt
        return tracker_said(rounds, filters, seed=seed)

    monkeypatch.setattr(replay_kept, "tracker_said", until_the_second)
    with pytest.raises(KeyboardInterrupt):
        run_replay(ready, tmp_path / "cut", progress=Progress())
    again = run_replay(ready, tmp_path / "cut", progress=Progress())
    assert followed == [0, 1, 1]
    for one, other in zip(whole_run, again, strict=True):
        np.testing.assert_array_equal(one.place_m, other.place_m)
        np.testing.assert_array_equal(one.bearing_rad, other.bearing_rad)


def test_the_verb_writes_tables_figures_and_a_page(tmp_path, capsys):
    (tmp_path / "study.toml").write_text(STUDY)
    log = recorded(5)
    write_log(tmp_path / "log.csv", taken(log, log.time_s < 16.0))
    out = tmp_path / "out"
    call = ["replay", str(tmp_path / "study.toml"), "--log", str(tmp_path / "log.csv"), "-q"]
    call += ["--azimuths-deg", ",".join(map(str, AZIMUTHS[5])), "--out", str(out)]
    assert cli.run([*call, "--estimator", "pattern", "--patterns", "spin"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("pattern: 64 rounds of 2 tags, 100 % of them heard")
    header, *rows = (out / "replay.csv").read_text().splitlines()
    assert header.startswith("time_s,id,x_m")
    assert len(rows) == 64
    page = (out / "report.html").read_text()
    assert "--azimuths-deg=0,60,150,-140,-50 --patterns spin" in page
    assert {p.stem for p in (out / "figures").iterdir()} == {"plan", "errors", "percentiles"}
    # the patterns that were found serve as a file
    again = [*call[:-1], str(tmp_path / "again"), "--estimator", "pattern"]
    assert cli.run([*again, "--patterns", str(out / "patterns.csv")]) == 0
    first, second = ((f / "replay_summary.csv").read_text() for f in (out, tmp_path / "again"))
    assert first.splitlines()[-1].split(",")[:3] == second.splitlines()[-1].split(",")[:3]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "no log is named; give --log FILE"),
        (["--log", "none.csv"], "none.csv does not exist"),
        (["--log", "log.csv", "--azimuths-deg", "front"], "--azimuths-deg is 'front'"),
        (
            ["--log", "log.csv", "--patterns", "none.csv", "--estimator", "tracker"],
            "cannot be read",
        ),
        (["--log", "unknown.csv"], "has readings of 'C', but the study has no such [[tag]]"),
        (["--log", "empty.csv"], "empty.csv is empty"),
        (["--log", "mw.csv"], 'set log.rss_unit = "mw"'),
    ],
)
def test_what_cannot_be_replayed_is_one_sentence(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "log.csv").write_text("id,rss_dbm,antenna\nA,-50,1\n")
    (tmp_path / "unknown.csv").write_text("id,rss_dbm\nC,-50\n")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "mw.csv").write_text("id,rss_dbm\nA,1e-6\nA,2e-5\n")
    assert cli.run(["replay", "study.toml", *arguments, "--out", "out", "-q"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_pattern_file_is_read_where_it_is_whole(tmp_path):
    gains = 5.0 * np.cos(np.radians(5.0 * np.arange(72))[:, None] - np.array([0.0, 1.0]))
    write_gains(tmp_path / "patterns.csv", gains)
    np.testing.assert_allclose(read_gains(tmp_path / "patterns.csv", antennas=2), gains, atol=1e-4)
    with pytest.raises(ConfigError, match="has no column 'gain_3_db'"):
        read_gains(tmp_path / "patterns.csv", antennas=3)
    with pytest.raises(ConfigError, match="but the robot has 1 antennas"):
        read_gains(tmp_path / "patterns.csv", antennas=1)
    (tmp_path / "half.csv").write_text("bearing_deg,gain_1_db\n0,1\n60,2\n120,3\n")
    with pytest.raises(ConfigError, match="gap of 240 deg"):
        read_gains(tmp_path / "half.csv", antennas=1)


def test_a_tag_has_converged_once_its_error_stays_small():
    error = np.radians([5.0, 80.0, 5.0, np.nan, 5.0, -5.0])
    one = Replayed(
        tag="A",
        time_s=np.arange(10.0, 16.0),
        poses=np.zeros((6, 3)),
        heard=np.array([1, 1, 0, 1, 1, 1]),
        bearing_rad=error,
        true_bearing_rad=np.zeros(6),
        place_m=np.full((6, 2), np.nan),
        true_place_m=np.zeros((6, 2)),
        spread_m=np.full(6, np.nan),
    )
    found = summary_of(one, Limits())
    assert found.converged_s == 4.0
    assert (found.median_deg, found.heard_share) == (pytest.approx(5.0), 5 / 6)
    assert math.isnan(summary_of(one, Limits(bearing_rad=1e-3)).converged_s)
    place = np.column_stack([[3.0, 0.1, 2.0, 0.3, 0.2, 0.4], np.zeros(6)])
    placed = summary_of(replace(one, place_m=place), Limits(place_m=0.35))
    assert (placed.place_median_m, placed.place_final_m) == (pytest.approx(0.3), 0.4)
    assert math.isnan(placed.converged_s)
    assert summary_of(replace(one, place_m=place), Limits(place_m=0.5)).converged_s == 3.0


def test_a_log_read_again_replays_alike(study, tmp_path):
    log = recorded(5)
    write_log(tmp_path / "log.csv", log)
    back = read_log(tmp_path / "log.csv")
    first, second = (replay(study, one, "vector_sum") for one in (log, back))
    np.testing.assert_allclose(first[0].bearing_rad, second[0].bearing_rad, atol=1e-9)
