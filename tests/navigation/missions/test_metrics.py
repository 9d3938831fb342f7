from dataclasses import replace

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.missions.metrics import (
    local_pose_error,
    measure,
    nearest_on_segment,
    percentile_curve,
    pose_errors,
    root_mean_square,
)
from octant.navigation.missions.records import Mission, MissionResult
from octant.navigation.navigators.arrival import ArrivalTest

MISSION = Mission(
    start_m=np.array([0.0, 0.0]),
    heading_rad=0.0,
    tag_ids=("a", "b"),
    tag_points_m=np.array([[1.0, 0.0], [1.0, 2.0]]),
    arrivals=(ArrivalTest(threshold_w=1e-9), ArrivalTest(threshold_w=1e-9)),
)


def record(poses, targets, *, outcome="completed", arrivals=((np.nan, np.nan),) * 2):
    rows = len(poses)
    arrivals = np.array(arrivals)
    return MissionResult(
        mission=MISSION,
        outcome=outcome,
        reason="made by hand",
        time_s=np.arange(rows),
        poses=np.array(poses),
        modes=("navigation",) * rows,
        targets=np.array(targets),
        rss_w=np.ones((rows, 8)),
        arrival_times_s=np.where(np.isnan(arrivals[:, 0]), np.nan, 1.0),
        arrival_points_m=arrivals,
    )


def test_error_in_the_robots_frame_is_along_and_to_the_left():
    # Facing +y at the origin; the goal lies 2 ahead and 1 to the right, turned by -90 degrees.
    error = local_pose_error([0.0, 0.0, np.pi / 2], [1.0, 2.0, 0.0])
    assert error == pytest.approx([2.0, -1.0, -np.pi / 2])


def test_length_of_the_error_is_the_same_in_both_frames_and_its_turn_is_wrapped():
    rng = np.random.default_rng(0)
    pose, wanted = rng.uniform(-4, 4, (2, 30, 3))
    error = local_pose_error(pose, wanted)
    assert np.hypot(error[:, 0], error[:, 1]) == pytest.approx(np.hypot(*(wanted - pose)[:, :2].T))
    assert (np.abs(error[:, 2]) <= np.pi).all()


def test_nearest_point_stays_on_the_segment():
    points = [[0.3, 1.0], [-1.0, 1.0], [5.0, -1.0]]
    nearest = nearest_on_segment(points, [0.0, 0.0], [2.0, 0.0])
    assert nearest.tolist() == [[0.3, 0.0], [0.0, 0.0], [2.0, 0.0]]


def test_rms_and_percentiles_of_known_numbers():
    assert root_mean_square([3.0, 4.0]) == pytest.approx(np.sqrt(12.5))
    shares, values = percentile_curve(np.arange(101.0))
    assert values == pytest.approx(shares, abs=1e-12)
    assert percentile_curve([0.0, 1.0], [25.0, 90.0])[1] == pytest.approx([0.25, 0.9])


def test_errors_are_to_the_current_leg_and_not_to_the_nearest_one():
    # The second sample lies on leg 1, but the robot is already on leg 2.
    result = record([[0.5, 0.1, 0.2], [0.5, 0.0, np.pi / 2], [1.3, 1.0, np.pi]], [0, 1, 1])
    metrics = measure(result)
    assert metrics.position_errors_m == pytest.approx([0.1, 0.5, 0.3])
    assert metrics.heading_errors_rad == pytest.approx([0.2, 0.0, np.pi / 2])
    assert metrics.rmse_m == pytest.approx(np.sqrt((0.01 + 0.25 + 0.09) / 3))
    assert pose_errors(result)[0] == pytest.approx([-0.1 * np.sin(0.2), -0.1 * np.cos(0.2), -0.2])
    assert metrics.p90_position_m == pytest.approx(np.percentile([0.1, 0.5, 0.3], 90))
    assert metrics.path_m == pytest.approx(0.1 + np.hypot(0.8, 1.0))
    assert metrics.time_s == 2.0


def test_success_needs_every_arrival_near_its_tag():
    poses, targets = [[0.9, 0.0, 0.0], [1.0, 1.8, 0.0]], [0, 1]
    near = record(poses, targets, arrivals=[(0.85, 0.0), (1.0, 1.7)])
    assert measure(near).success
    assert measure(near).arrival_errors_m == pytest.approx([0.15, 0.3])
    assert not measure(near, success_radius_m=0.2).success
    # The arrival itself counts as an approach, though its row belongs to the next tag.
    assert measure(near).closest_m == pytest.approx([0.1, 0.2])
    sooner = record(poses[1:], [1], arrivals=[(0.85, 0.0), (1.0, 1.7)])
    assert measure(sooner).closest_m == pytest.approx([0.15, 0.2])
    missing = record(poses, targets, outcome="time-out", arrivals=[(0.85, 0.0), (np.nan, np.nan)])
    assert not measure(missing).success
    assert not measure(missing).captured


def test_an_arrival_far_from_its_tag_is_a_capture():
    result = record([[0.5, 0.0, 0.0]], [1], arrivals=[(0.5, 0.0), (1.0, 2.0)])
    metrics = measure(result)
    assert metrics.captured
    assert not metrics.success


def circle(middle, radius_m, samples=40):
    phase = np.arange(samples) * 0.4
    xy = np.array(middle) + radius_m * np.column_stack([np.cos(phase), np.sin(phase)])
    return np.column_stack([xy, phase]).tolist()


def test_circling_away_from_the_tag_until_time_runs_out_is_a_capture():
    held = record(circle((0.2, 0.5), 0.2), [0] * 40, outcome="time-out")
    assert measure(held).captured
    assert not measure(replace(held, outcome="no signal")).captured


def test_circling_the_tag_itself_is_a_near_miss_and_not_a_capture():
    metrics = measure(record(circle((1.0, 0.0), 0.25), [0] * 40, outcome="time-out"))
    assert not metrics.captured
    assert metrics.closest_m[0] == pytest.approx(0.25)
    assert np.isnan(metrics.closest_m[1])


def test_travelling_until_time_runs_out_is_not_a_capture():
    line = np.column_stack([np.linspace(-4, 0.5, 40), np.zeros(40), np.zeros(40)])
    assert not measure(record(line, [0] * 40, outcome="time-out")).captured


def test_collisions_are_flagged():
    assert measure(record([[0.5, 0.0, 0.0]], [0], outcome="collision")).collided


def test_a_success_radius_must_be_positive():
    with pytest.raises(NavigationError, match="success_radius_m is 0"):
        measure(record([[0.5, 0.0, 0.0]], [0]), success_radius_m=0.0)
