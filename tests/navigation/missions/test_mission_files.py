import csv

import numpy as np
import pytest
from thesis_robot import thesis_robot

from octant.geometries.errors import NavigationError
from octant.navigation.missions.files import write_missions_csv, write_trajectory_csv
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.run import run_missions
from octant.navigation.robot.drive import DifferentialDrive


@pytest.fixture
def results(thesis_setup):
    def make(*, antennas=8, runs=3):
        mission, sensor = thesis_setup(noise_db=1.0, antennas=antennas)
        return run_missions(
            mission, sensor, thesis_robot(mission, sensor), DifferentialDrive(), runs=runs, seed=3
        )

    return make


def rows_of(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_missions_file_has_the_fixed_columns_and_one_row_a_run(results, tmp_path):
    runs = results()
    path = tmp_path / "missions.csv"
    write_missions_csv(path, runs)
    assert path.read_text(encoding="utf-8").splitlines()[0] == (
        "run,success,time_s,path_m,rmse_m,p90_position_m,p90_heading_deg,arrivals_m,"
        "captured,collided,outcome,contacts,near_miss,start_x_m,start_y_m,start_heading_deg"
    )
    rows = rows_of(path)
    assert [row["run"] for row in rows] == ["0", "1", "2"]
    for row, run in zip(rows, runs, strict=True):
        metrics = measure(run)
        assert float(row["rmse_m"]) == metrics.rmse_m
        assert float(row["p90_heading_deg"]) == pytest.approx(np.degrees(metrics.p90_heading_rad))
        arrivals = [float(value) for value in row["arrivals_m"].split(";")]
        assert arrivals == metrics.arrival_errors_m.tolist()
        assert (row["success"], row["captured"], row["collided"]) == ("1", "0", "0")


def test_tags_not_reached_are_nan_in_the_missions_file(thesis_setup, tmp_path):
    mission, sensor = thesis_setup()
    (run,) = run_missions(
        mission,
        sensor,
        thesis_robot(mission, sensor),
        DifferentialDrive(),
        runs=1,
        seed=0,
        blocked=lambda points: points[:, 1] > 1.0,
    )
    path = tmp_path / "missions.csv"
    write_missions_csv(path, [run])
    (row,) = rows_of(path)
    assert row["arrivals_m"].split(";")[1:] == [""] * 3
    assert (row["success"], row["collided"]) == ("0", "1")


@pytest.mark.parametrize("antennas", [8, 5])
def test_trajectory_file_reads_back_to_the_same_bits(results, tmp_path, antennas):
    (run,) = results(antennas=antennas, runs=1)
    path = tmp_path / "trajectory.csv"
    write_trajectory_csv(path, run)
    rows = rows_of(path)
    assert list(rows[0]) == [
        "t_s",
        "x_m",
        "y_m",
        "heading_deg",
        "mode",
        "target",
        *(f"rss_{i}_w" for i in range(1, antennas + 1)),
    ]
    back = np.array([[float(row[name]) for name in ("t_s", "x_m", "y_m")] for row in rows])
    assert (back == np.column_stack([run.time_s, run.poses[:, :2]])).all()
    rss = np.array([[float(row[f"rss_{i + 1}_w"]) for i in range(antennas)] for row in rows])
    assert (rss == run.rss_w).all()
    heading = np.array([float(row["heading_deg"]) for row in rows])
    assert np.radians(heading) == pytest.approx(run.poses[:, 2])
    assert [row["mode"] for row in rows] == list(run.modes)
    assert rows[0]["target"] == "0xFFF9"
    assert rows[-1]["target"] == "0xFFF4"


def test_a_failed_write_leaves_the_old_file_and_no_remains(results, tmp_path, monkeypatch):
    path = tmp_path / "trajectory.csv"
    path.write_text("old")
    (run,) = results(runs=1)

    def fail(_self, _target):
        raise OSError("disk full")

    monkeypatch.setattr("pathlib.Path.replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_trajectory_csv(path, run)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["trajectory.csv"]


def test_an_empty_campaign_is_refused(tmp_path):
    with pytest.raises(NavigationError, match="no runs"):
        write_missions_csv(tmp_path / "missions.csv", [])
    assert not list(tmp_path.iterdir())
