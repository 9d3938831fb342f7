"""``octant dock``: what it writes, that it repeats itself, and what it refuses."""

import csv
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.navigation.robot.motion import Motion
from octant.reader_design.experiments.docking.compute import (
    compute_docking,
    docking_job,
    docking_jobs,
    docking_rooms,
    docking_space,
    docking_task,
    kept_runs,
)
from octant.reader_design.experiments.docking.page import summary_lines
from octant.reader_design.experiments.missions.compute import mission_job
from octant.reader_design.study_file.loading import load_study
from octant.reader_design.study_file.sensor import Sensor

STUDY = """
name = "station"
seed = 3
[radio]
frequency_hz = 2.44e9
[room]
box_m = [7.0, 7.0, 3.1]
origin_m = [-1.0, -1.0, 0.0]
material = "concrete"
[[tag]]
id = "dock"
position_m = [4.0, 2.5, 3.1]
antenna = "dipole"
[reader]
response = "isolated"
[solver]
max_reflections = 1
[dock]
tag = "dock"
landmark_position_m = [6.0, 2.5, 0.6]
runs = 2
tries = 1
[[layout]]
name = "free"
[layout.room]
free_space = true
"""
MISSION = '[mission]\nnavigator = "thesis"\nstart_m = [1.0, 1.0]\ntags = ["dock"]\n'
FIGURES = {
    "ways",
    "errors",
    "run",
    "stall",
    "filter_path",
    "filter_no_slips",
    "filter_slips",
    "slips",
    "filter_straight",
    "histograms",
    "consistency",
    "law",
    "regulators",
    "gains",
    "odometry",
    "observability",
}


@pytest.mark.slow
def test_a_study_leaves_tables_figures_and_a_report(octant, study_file, tmp_path):
    study, out = study_file(STUDY), tmp_path / "out"
    call = octant("dock", study, "--out", out, "-q")
    assert call.code == 0, call
    assert "of 2 runs docked" in call.out
    rows = list(csv.DictReader((out / "docking.csv").read_text().splitlines()))
    assert [(r["layout"], r["run"]) for r in rows] == [
        ("station", "0"),
        ("station", "1"),
        ("free", "0"),
        ("free", "1"),
    ]
    assert all(r["reason"] for r in rows)
    assert {p.stem for p in (out / "figures").iterdir()} == {f"dock_{name}" for name in FIGURES}
    page = (out / "report.html").read_text()
    assert page.count("<img") == len(FIGURES)
    assert load_study(out / "study.toml") == load_study(study)
    again = octant("dock", study, "--out", out)
    assert again.code == 0
    assert "complete already" in again.err
    assert again.out == call.out
    assert "another study" in octant("dock", study, "--out", out, "--runs", "3").refused()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
def test_runs_are_kept_and_the_same_bits(study_file, tmp_path):
    study = load_study(study_file(STUDY))
    rooms = docking_rooms(study)
    jobs = docking_jobs(rooms)
    content = compute_docking(study, rooms, jobs, tmp_path)
    assert kept_runs(study, jobs, tmp_path) == "8 runs, of which 8 are computed already."
    job, _ = jobs["station"]
    for seed, kept in zip(
        np.random.SeedSequence(3).spawn(2), content.results["station"], strict=True
    ):
        for name in ("poses", "twist", "time_s", "seen"):
            assert np.array_equal(getattr(job(seed), name), getattr(kept, name))


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("[6.0, 2.5, 0.6]", "[6.2, 2.5, 0.6]", "inside a wall"),
        ("runs = 2", "landmark_heading_deg = 180", "inside a wall"),
        ("runs = 2", "sample_time_s = 0", "dock.sample_time_s"),
        ("runs = 2", "reading_time_s = -1", "dock.reading_time_s"),
        ("runs = 2", "gamma_per_s = 0", "dock.gamma_per_s"),
        ("runs = 2", "staging_m = 0.3", "staging_m"),
        ("runs = 2", "stand_off_m = 0.1", "does not fit"),
        ("runs = 2", "landmrk_position_m = [1, 1, 1]", "'landmark_position_m'"),
        ('tag = "dock"', 'tag = "dok"', "'dock'"),
        ("runs = 2", "start_low_m = [0, 0]", "only one is given"),
        ("runs = 2", "start_low_m = [0, 0]\nstart_high_m = [0, 1]", "lower corner"),
    ],
)
def test_bad_docks_are_refused_in_one_sentence(octant, study_file, tmp_path, old, new, part):
    assert old in STUDY
    study = study_file(STUDY.replace(old, new))
    assert part in octant("dock", study, "--out", tmp_path / "out").refused()
    assert not (tmp_path / "out").exists()


def test_the_built_in_study_has_the_papers_station_in_a_room_and_in_free_space():
    study = load_study(built_in="dock_study")
    assert [room.name for room in docking_rooms(study)] == ["docking-station", "free-space"]
    task = docking_task(study)
    law, limits = task.fine.law, task.fine.limits
    assert (law.gamma_per_s, law.h, law.k_per_s) == (0.125, 20.0, 1.0)
    assert limits.max_speed_m_per_s == pytest.approx(limits.max_turn_rate_rad_per_s) == 0.2
    assert task.goal == pytest.approx([5.5, 2.5, 0.0])


def test_the_example_in_the_furnished_office_fits_its_room():
    example = Path(__file__).parents[2] / "examples" / "docking_office.toml"
    (room,) = docking_rooms(load_study(example))
    assert room.scene.has_room


@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
@pytest.mark.parametrize(
    "table", ["sensitivity_dbm = 60.0", "read_probability = 0.0", "drop_out_probability = 1.0"]
)
def test_a_reader_that_receives_nothing_never_docks(study_file, table):
    study = load_study(study_file(STUDY.replace("[dock]", f"[sensor]\n{table}\n[dock]")))
    job = docking_job(docking_rooms(study)[0])
    result = job(np.random.SeedSequence(3))
    assert not result.success
    assert result.outcome == "tag not found"


def test_tolerances_decide_what_is_docked_and_are_stated(study_file):
    """A robot in the dock that faces away turns on the spot; half a millimetre is asked in vain."""
    start = "start_low_m = [5.49, 2.49]\nstart_high_m = [5.51, 2.51]\n"
    study = load_study(study_file(STUDY.replace("runs = 2", f"runs = 2\n{start}")))
    job = docking_job(docking_rooms(study)[0])
    results = [job(seed) for seed in np.random.SeedSequence(3).spawn(4)]
    assert all(r.success and r.path_m < 0.2 and r.time_s[-1] < 8.0 for r in results)
    assert "within 0.08 m and 11.5 degrees" in summary_lines({"a": results})[-1]
    tight = "tolerance_m = 0.0005\ntolerance_deg = 0.2\n"
    study = load_study(study_file(STUDY.replace("runs = 2", f"runs = 2\n{start}{tight}")))
    missed = docking_job(docking_rooms(study)[0])(np.random.SeedSequence(3))
    assert missed.task.tolerance_rad == pytest.approx(np.radians(0.2))
    assert not missed.success
    lines = summary_lines({"a": [missed]})
    assert "within 0.0005 m and 0.2 degrees" in lines[-1]
    assert lines[-2].startswith("1 x ")


SENSOR = {
    "dwell_s": 0.05,
    "bandwidth_hz": 1e12,
    "noise_figure_db": 60.0,
    "samples": 100,
    "required_snr_db": 80.0,
    "sensitivity_dbm": 0.0,
    "bits": 4,
    "floor_dbm": -50.0,
    "full_scale_dbm": -70.0,
    "drop_out_probability": 0.5,
    "read_probability": 0.0,
}
NEEDS = {
    "noise_figure_db": {"bandwidth_hz": 1e12},
    "samples": {"bandwidth_hz": 1e12},
    "required_snr_db": {"bandwidth_hz": 1e6},
    "floor_dbm": {"bits": 4},
    "full_scale_dbm": {"bits": 4},
}


@pytest.mark.parametrize("verb", ["dock", "navigate"])
@pytest.mark.parametrize("key", Sensor.__struct_fields__)
def test_every_key_of_the_sensor_changes_readings_in_every_verb_that_reads(study_file, key, verb):
    """An exhaustive walk: a key that a verb leaves out reads as if it were not given."""

    def reading(keys):
        table = "".join(f"{k} = {v}\n" for k, v in keys.items())
        mission = (
            '[mission]\nnavigator = "thesis"\nstart_m = [1.0, 1.0]\ntags = ["dock"]\n'
            if verb == "navigate"
            else ""
        )
        text = STUDY.replace("[dock]", f"[sensor]\n{table}{mission}[dock]")
        rooms = docking_rooms(load_study(study_file(text)))
        if verb == "dock":
            sensor = docking_job(rooms[0]).setting.reader
        else:
            sensor = mission_job(rooms[0]).sensor
        driven = Motion(speed_m_per_s=0.2, turn_rate_rad_per_s=1.0)
        pose = np.array([2.0, 1.0, 0.4])
        return sensor.read(pose, "dock", np.random.default_rng(5), motion=driven)

    needs = NEEDS.get(key, {})
    assert not np.array_equal(reading({**needs, key: SENSOR[key]}), reading(needs))


def test_a_round_of_antennas_longer_than_the_time_between_readings_is_refused(study_file):
    text = STUDY.replace("[dock]", "[sensor]\ndwell_s = 0.2\n[dock]")
    with pytest.raises(ConfigError, match=r"dock\.reading_time_s is 1 s"):
        load_study(study_file(text))


@pytest.mark.parametrize(("plane_m", "passes"), [(0.2, True), (0.6, False)])
def test_the_readers_ground_plane_counts_in_a_narrow_gap(study_file, plane_m, passes):
    """Two posts 0.5 m apart: the robot of radius 0.2 m passes, a plate of 0.6 m does not."""
    post = (
        '[[room.object]]\nkind = "box"\nsize_m = [0.2, 0.2, 1.0]\nmaterial = "metal"\n'
        "position_m = [2.0, {}, 0.0]\n"
    )
    text = STUDY.replace("[[tag]]", post.format(0.05) + post.format(0.75) + "[[tag]]", 1)
    text = text.replace("[reader]", f"[reader]\nground_plane_m = {plane_m}")
    room, _ = docking_rooms(load_study(study_file(text)))
    assert docking_space(room)(np.array([[2.1, 0.5]]))[0] == passes


def test_a_study_without_a_dock_is_refused(octant, study_file, tmp_path):
    assert "[dock]" in octant("dock", study_file(), "--out", tmp_path / "out").refused()


def test_gains_outside_the_region_are_warned_of(octant, study_file, tmp_path):
    text = STUDY.replace("runs = 2", "k_per_s = 9\nstand_off_m = 0.1")
    call = octant("dock", study_file(text), "--out", tmp_path / "out")
    assert "warning: k_per_s is 9 1/s, outside the region" in call.err


@pytest.mark.parametrize("verb", ["dock", "navigate"])
def test_runs_and_seed_are_options_that_the_plan_knows(octant, study_file, tmp_path, verb):
    keys = STUDY if verb == "dock" else STUDY[: STUDY.index("[dock]")] + MISSION
    study, out = study_file(keys), tmp_path / "out"
    call = octant(verb, study, "--out", out, "--runs", "3", "--seed", "7", "--dry-run")
    assert call.code == 0, call
    assert "runs, of which 0" in call.out
    assert "--seed" in octant(verb, study, "--out", out, "--seed", "-1").refused()
