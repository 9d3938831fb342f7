"""Coordinates of a log come onto the room by what reference points say, and by nothing else."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.logs.frames import UNMOVED, Frame, axis_frames, fitted_frame, in_room
from octant.navigation.logs.log_csv import read_log

POINTS = np.array([[0.0, 0.0], [3.0, 0.5], [1.0, 4.0], [-2.0, 1.0]])


@given(st.floats(-10.0, 10.0), st.floats(-99.0, 99.0), st.floats(-99.0, 99.0), st.booleans())
def test_reference_points_give_back_turn_shift_and_mirror(turn, x, y, mirrored):
    frame = Frame(turn_rad=turn, shift_m=np.array([x, y]), mirrored=mirrored)
    found = fitted_frame(POINTS, frame.places_m(POINTS))
    assert found.frame.mirrored == mirrored
    assert found.rms_m < 1e-12
    np.testing.assert_allclose(found.frame.shift_m, [x, y], atol=1e-12)
    assert abs(wrap_angle(found.frame.turn_rad - turn)) < 1e-12


def test_errors_of_reference_points_are_shared_as_least_squares_do():
    rng = np.random.default_rng(1)
    frame = Frame(turn_rad=0.7, shift_m=np.array([1.0, -2.0]), mirrored=True)
    room = frame.places_m(POINTS) + 0.05 * rng.standard_normal(POINTS.shape)
    found = fitted_frame(POINTS, room)
    assert found.frame.mirrored

    def squares(turn, x, y):
        other = Frame(turn_rad=turn, shift_m=np.array([x, y]), mirrored=True)
        return np.sum((other.places_m(POINTS) - room) ** 2)

    best = [found.frame.turn_rad, *found.frame.shift_m]
    assert squares(*best) == pytest.approx(len(POINTS) * found.rms_m**2)
    for step in 1e-4 * np.vstack([np.eye(3), -np.eye(3)]):
        assert squares(*(best + step)) > squares(*best)


def test_a_heading_points_the_way_that_its_places_move():
    for frame in axis_frames([0.0, 0.0], [4.0, 3.0]).values():
        ahead = np.array([np.cos(0.4), np.sin(0.4)])
        moved = frame.places_m(POINTS + ahead) - frame.places_m(POINTS)
        angle = frame.headings_rad(0.4)
        np.testing.assert_allclose(
            moved, np.tile([np.cos(angle), np.sin(angle)], (4, 1)), atol=1e-12
        )


def test_mixed_up_axes_keep_the_room_about_its_middle():
    frames = axis_frames([1.0, 2.0], [4.0, 8.0])
    np.testing.assert_allclose(
        frames["x and y exchanged"].places_m([1.0, 2.0]), [2.0, 1.0], atol=1e-12
    )
    np.testing.assert_allclose(frames["x mirrored"].places_m([1.0, 2.0]), [4.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(frames["y mirrored"].places_m([1.0, 2.0]), [1.0, 8.0], atol=1e-12)
    np.testing.assert_allclose(
        frames["turned by 180 deg"].places_m([1.0, 2.0]), [4.0, 8.0], atol=1e-12
    )
    for name, frame in frames.items():
        if name != "x and y exchanged":
            np.testing.assert_allclose(frame.places_m([2.5, 5.0]), [2.5, 5.0], atol=1e-12)


@pytest.mark.parametrize(
    ("log_m", "room_m", "said"),
    [
        ([[0, 0]], [[1, 1]], "at least two"),
        ([[0, 0], [0, 0], [0, 0]], [[1, 1], [2, 2], [3, 0]], "coincide"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 0], [100, 0], [0, 100]], "100 times as far apart"),
        ([[0, 0], [1, 0], [2, 0]], [[0, 0], [1, 0], [2, 0]], "on one line"),
    ],
)
def test_points_that_give_no_frame_are_refused(log_m, room_m, said):
    with pytest.raises(NavigationError, match=said):
        fitted_frame(log_m, room_m)


def test_a_mirrored_log_turns_the_other_way(tmp_path):
    (tmp_path / "log.csv").write_text(
        "id,rss_dbm,x_m,y_m,heading_deg,turn_deg\nA,-50,1,2,30,5\nA,-51,,,,\n"
    )
    log = read_log(tmp_path / "log.csv")
    assert in_room(log, UNMOVED) is log
    moved = in_room(log, axis_frames([0, 0], [4, 4])["x and y exchanged"])
    np.testing.assert_allclose(moved.poses[0], [2.0, 1.0, np.radians(60.0)])
    assert moved.turn_rad[0] == -log.turn_rad[0]
    assert np.isnan(moved.poses[1]).all()
