"""``--export`` of navigate, dock and track: what rosbags reads is what the tables say."""

import csv

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from small_study import SMALL

from octant.navigation.tracking.closed_loop import TrackingRecord
from octant.navigation.tracking.trajectories import desired_trajectory
from octant.reader_design.drives.files import write_drive
from octant.reader_design.drives.log import DriveLog
from octant.reader_design.experiments.docking.compute import docking_job, docking_rooms
from octant.reader_design.experiments.docking.logs import docking_log
from octant.reader_design.experiments.tracking.compute import TrackingContent
from octant.reader_design.experiments.tracking.logs import tracking_logs
from octant.reader_design.experiments.tracking.parts import Part, PartRecord
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.settings import settings_of
from octant.reader_design.study_file.loading import load_study

DOCK = """
name = "station"
seed = 3
[room]
free_space = true
[[tag]]
id = "dock"
position_m = [4.0, 2.5, 3.1]
antenna = "dipole"
[reader]
response = "isolated"
[dock]
tag = "dock"
landmark_position_m = [6.0, 2.5, 0.6]
runs = 1
"""
TRACK = """
name = "small"
[room]
free_space = true
[track]
chapters = ["neighbouring"]
runs = 1
"""


def topics(path):
    found = {}
    with AnyReader([path]) as bag:
        for connection, stamp, raw in bag.messages():
            one = bag.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((stamp, one))
    return found


def test_a_mission_reads_back_with_the_numbers_of_its_table(octant, study_file, tmp_path):
    study, out = (
        study_file(SMALL + 'runs = 2\nmax_time_s = 8.0\nnavigator = "thesis"\n'),
        tmp_path / "out",
    )
    words = ("navigate", study, "--out", out, "-q", "--workers", "1", "--export", "mcap")
    call = octant(*words, "--export", "tum")
    assert call.code == 0, call.err
    assert {p.name for p in (out / "drives").iterdir()} == {
        "run_0.mcap", "foxglove_layout.json", "run_0_truth.tum", "run_0_belief.tum",
    }  # fmt: skip
    rows = list(csv.DictReader((out / "trajectory.csv").read_text().splitlines()))
    found = topics(out / "drives" / "run_0.mcap")
    heard = [r for r in rows if float(r["rss_1_w"]) >= 0.0]
    rss_w = np.array([m.data for _, m in found["/rss_w"]])
    np.testing.assert_array_equal(
        rss_w, [[float(r[f"rss_{i}_w"]) for i in range(1, 5)] for r in heard]
    )
    truth = found["/ground_truth/pose"]
    assert [m.pose.position.x for _, m in truth] == [float(r["x_m"]) for r in rows]
    np.testing.assert_allclose(
        [(t - 10**9) / 1e9 for t, _ in truth], [float(r["t_s"]) for r in rows], atol=1e-9
    )
    # wheels without slip: the robot believes to be where it is, but for contact at the end
    belief = np.array([[m.pose.position.x, m.pose.position.y] for _, m in found["/belief/pose"]])
    free = slice(None, -1)
    there = np.array([[float(r["x_m"]), float(r["y_m"])] for r in rows])
    np.testing.assert_allclose(belief[free], there[free], atol=1e-9)
    assert found["/map"][0][1].info.width == 80
    # the commands lead, step by step, to where the wheels say it is
    before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}
    again = octant(*words, "--export", "tum")
    assert again.code == 0
    assert {p: p.read_bytes() for p in out.rglob("*") if p.is_file()} == before


def test_what_cannot_be_exported_is_one_sentence(octant, study_file, tmp_path):
    study = study_file(SMALL + "runs = 2\n")
    for words, said in (
        (("--export", "mcap", "--export-run", "2"), "numbered 0 to 1"),
        (("--export-run", "1"), "add --export mcap"),
        (("--compare", "--export", "csv"), "--compare drives many"),
        (("--export", "bag"), "mcap"),
    ):
        call = octant("navigate", study, "--out", tmp_path / "out", *words)
        assert call.code == 2, words
        assert said in call.err


def test_a_docking_run_has_its_readings_and_believes_only_what_it_sees(study_file):
    study = load_study(study_file(DOCK))
    (room,) = docking_rooms(study)
    result = docking_job(room)(np.random.SeedSequence(1))
    log = docking_log(room, result, run=0)
    assert isinstance(log, DriveLog)
    approach = np.array([state == "approach" for state in log.states])
    heard = np.isfinite(log.rss_w).all(axis=1)
    assert heard[approach].any()
    assert not heard[np.array([state == "dock" for state in log.states])].any()
    assert not np.isfinite(log.belief[approach]).any()
    seen = np.isfinite(log.belief).all(axis=1)
    assert seen.any()
    away = np.linalg.norm(log.belief[seen, :2] - log.poses[seen, :2], axis=1)
    assert np.median(away) < 0.15
    # odometry starts where the robot stands, and its axes are put there
    np.testing.assert_array_equal(log.odometry[0], np.zeros(3))
    np.testing.assert_array_equal(log.corrections[0], result.poses[0])
    moved = np.linalg.norm(np.diff(log.odometry[:, :2], axis=0), axis=1).sum()
    driven = np.linalg.norm(np.diff(log.poses[:, :2], axis=0), axis=1).sum()
    assert moved == pytest.approx(driven, rel=0.2)


def test_a_tracked_trajectory_has_the_estimate_as_belief(study_file, tmp_path):
    settings = settings_of(load_study(study_file(TRACK)))
    desired = desired_trajectory(settings.tasks["lemniscate"].curve, period_s=1.0)
    rng = np.random.default_rng(2)
    runs = TrackingRecord(
        desired=desired,
        poses=desired.poses + rng.normal(0.0, 0.1, (2, *desired.poses.shape)),
        estimates=desired.poses + rng.normal(0.0, 0.1, (2, *desired.poses.shape)),
        wheel_rates=rng.normal(0.0, 1.0, (2, desired.steps, 2)),
    )
    outcome = Outcome(chapter="neighbouring", task="lemniscate", method="EKF", runs=runs)
    (make,) = tracking_logs(
        TrackingContent(
            settings=settings,
            study_toml="",
            parts=((Part(chapter="neighbouring"), PartRecord(outcomes=(outcome,))),),
        ),
        [1, 7],
    ).values()
    mcap, *_ = write_drive(make(), tmp_path / "run", ("mcap",))
    found = topics(mcap)
    belief = np.array([[m.pose.position.x, m.pose.position.y] for _, m in found["/belief/pose"]])
    np.testing.assert_array_equal(belief, runs.estimates[1, :, :2])
    commands = np.array([[m.linear.x, m.angular.z] for _, m in found["/cmd_vel"]])
    np.testing.assert_allclose(commands[:-1], settings.robot.twist(runs.wheel_rates[1]))
    assert not commands[-1].any()
    # the wheels as commanded, in ten thousand straight pieces a period
    x, y, heading = 0.0, 0.0, 0.0
    for (_, message), (speed, rate) in zip(found["/odom"], commands, strict=True):
        place = message.pose.pose.position
        np.testing.assert_allclose((place.x, place.y), (x, y), atol=1e-4)
        angles = heading + rate * (np.arange(10_000) + 0.5) / 10_000
        x, y = x + speed * np.cos(angles).mean(), y + speed * np.sin(angles).mean()
        heading += rate
    assert len(found["/tags"][0][1].markers) == 2 * len(settings.mesh.tags_m)
