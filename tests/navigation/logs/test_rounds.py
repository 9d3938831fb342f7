"""A log becomes rounds of antennas with the motion between them, whatever is missing or doubled."""

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.logs.log_csv import read_log
from octant.navigation.logs.rounds import one_arc, rounds_of
from octant.navigation.robot.motion import move


def rounds(tmp_path, rows, header="time_s,id,antenna,rss_dbm", **options):
    (tmp_path / "log.csv").write_text("\n".join([header, *rows, ""]))
    return rounds_of(read_log(tmp_path / "log.csv"), **{"antennas": 2, **options})


def test_a_round_is_one_source_at_one_time(tmp_path):
    found = rounds(tmp_path, ["1,A,1,-1", "1,A,2,-2", "1,B,1,-3", "2,A,2,-inf", "2,B,-,-4"])
    assert found.sources.tolist() == [0, 1, 0, 1]
    nan, inf = np.nan, np.inf
    np.testing.assert_array_equal(found.rss_dbm, [[-1, -2], [-3, nan], [nan, -inf], [-4, nan]])
    assert found.time_s.tolist() == [1, 1, 2, 2]


def test_an_antenna_that_comes_again_opens_a_round_and_a_doubled_row_does_not(tmp_path):
    found = rounds(tmp_path, ["1,A,1,-1", "1,A,1,-1", "1,A,1,-5", "1,A,2,-2"])
    np.testing.assert_array_equal(found.rss_dbm, [[-1, np.nan], [-5, -2]])
    assert found.notes[0] == "1 rows that repeat a reading to the bit are left out."


def test_antennas_read_in_turn_are_one_round_within_a_window(tmp_path):
    rows = ["1.0,A,1,-1", "1.1,A,2,-2", "1.3,A,1,-3", "1.4,A,2,-4"]
    assert len(rounds(tmp_path, rows)) == 4
    assert rounds(tmp_path, rows, window_s=0.15).rss_dbm.tolist() == [[-1, -2], [-3, -4]]


def test_motion_between_rounds_is_the_arc_of_all_rows_between(tmp_path):
    header = "time_s,distance_m,turn_deg,id,antenna,rss_dbm"
    rows = ["0,0,0,A,1,-1", "1,1,90,-,-,", "2,1,90,-,-,", "3,0,0,A,1,-1", "3,0,0,A,2,-1"]
    found = rounds(tmp_path, rows, header)
    # two quarter circles are a half circle of their length
    np.testing.assert_allclose([found.distance_m[1], found.turn_rad[1]], [2.0, np.pi])
    assert len(found) == 2


def test_arcs_of_one_circle_add_up_to_its_arc():
    way, turn = one_arc(np.array([0.3, 0.5, 0.2]), np.array([0.3, 0.5, 0.2]))
    assert (way, turn) == pytest.approx((1.0, 1.0))
    steps, turns = np.array([0.2, -0.1, 0.4]), np.array([0.2, 0.3, -0.1])
    pose = np.zeros(3)
    for step, angle in zip(steps, turns, strict=True):
        pose = move(pose, distance_m=step, turn_rad=angle)
    way, turn = one_arc(steps, turns)
    along = move(np.zeros(3), distance_m=way, turn_rad=turn)
    assert along[2] == pytest.approx(pose[2])
    middle = np.array([np.cos(turn / 2), np.sin(turn / 2)])
    assert along[:2] @ middle == pytest.approx(pose[:2] @ middle)


def test_without_odometry_the_true_poses_move_the_robot(tmp_path):
    header = "time_s,x_m,y_m,heading_deg,id,antenna,rss_dbm"
    found = rounds(tmp_path, ["0,0,0,0,A,1,-1", "1,1,0,0,A,1,-1", "2,1,0,90,A,1,-1"], header)
    np.testing.assert_allclose(found.distance_m, [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.turn_rad, [0.0, 0.0, np.pi / 2])
    assert "that of the true poses" in found.notes[0]


def test_gaps_of_odometry_are_bridged_by_poses_and_said(tmp_path):
    header = "time_s,x_m,y_m,heading_deg,distance_m,turn_deg,id,antenna,rss_dbm"
    rows = ["0,0,0,0,0,0,A,1,-1", "1,1,0,0,,,A,1,-1", "2,2,0,0,0.9,0,A,1,-1"]
    found = rounds(tmp_path, rows, header)
    np.testing.assert_allclose(found.distance_m, [0.0, 1.0, 0.9])
    assert found.notes == (
        "Odometry is unknown in 1 rows: the true poses stand for it, or no motion.",
    )


def test_a_log_without_times_counts_its_rounds(tmp_path):
    found = rounds(tmp_path, ["A,1,-1", "A,2,-2", "A,1,-3"], "id,antenna,rss_dbm")
    assert found.time_s.tolist() == [0.0, 1.0]
    assert any("no times" in note for note in found.notes)


def test_more_antennas_than_the_robot_has_are_refused(tmp_path):
    with pytest.raises(NavigationError, match="readings of antenna 3, but the robot has 2"):
        rounds(tmp_path, ["1,A,3,-1"])
    with pytest.raises(NavigationError, match="holds no reading"):
        rounds(tmp_path, ["1,-,-,"])
