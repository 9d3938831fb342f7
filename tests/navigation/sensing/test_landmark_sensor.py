import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor

LANDMARK = Landmark(position_m=np.array([3.0, 0.0, 0.6]), heading_rad=0.0)


def test_the_landmark_in_the_body_frame_is_rotated_and_shifted():
    got = LANDMARK.in_body([1.0, 1.0, np.pi / 2])
    np.testing.assert_allclose(got, [-1.0, -2.0, -np.pi / 2], atol=1e-15)
    np.testing.assert_allclose(LANDMARK.goal(0.5), [2.5, 0.0, 0.0])


def test_the_field_of_view_is_centred_on_the_cameras_axis():
    sensor = LandmarkSensor(position_m=np.array([0.0, 0.0, 0.6]))
    half = 0.5 * sensor.width_rad
    edges = np.array([-sensor.yaw_rad - half, -sensor.yaw_rad + half])
    inside = np.array([[0.5, 0.0, edges[0] + 1e-6], [0.5, 0.0, edges[1] - 1e-6]])
    assert sensor.in_sight(inside, LANDMARK).all()
    outside = np.array([[0.5, 0.0, edges[0] - 1e-6], [0.5, 0.0, edges[1] + 1e-6]])
    assert not sensor.in_sight(outside, LANDMARK).any()


def test_range_obliqueness_and_height_end_the_sight():
    sensor = LandmarkSensor(position_m=np.array([0.0, 0.0, 0.6]), yaw_rad=0.0)
    poses = [[3.0 - r, 0.0, 0.0] for r in (0.399, 0.401, 4.499, 4.501)]
    np.testing.assert_array_equal(sensor.in_sight(poses, LANDMARK), [False, True, True, False])
    for oblique, seen in ((1.21, True), (1.23, False)):  # 70 degrees are 1.2217 rad
        pose = [3.0 - np.cos(oblique), -np.sin(oblique), oblique]
        assert sensor.in_sight([pose], LANDMARK)[0] == seen
    low = LandmarkSensor(position_m=np.array([0.0, 0.0, 0.6 + 2.0]), yaw_rad=0.0)
    # 2 m above it and 3 m away: 33.7 degrees below the axis, beyond half of 43 degrees.
    assert not low.in_sight([[0.0, 0.0, 0.0]], LANDMARK)[0]


def test_the_cameras_place_on_the_robot_counts():
    sensor = LandmarkSensor(yaw_rad=0.0, farthest_m=3.0, position_m=np.array([0.09, 0.0, 0.6]))
    seen = sensor.in_sight([[-0.089, 0, 0], [-0.091, 0, 0]], LANDMARK)
    np.testing.assert_array_equal(seen, [True, False])


def test_an_object_of_the_mesh_hides_the_landmark_and_one_below_the_ray_does_not():
    room = box_room((8.0, 8.0, 3.0), origin_m=(-4.0, -4.0, 0.0))
    for height, seen in ((0.5, True), (1.2, False)):
        cabinet = box((0.3, 1.0, height), position_m=(1.5, -0.5, 0.0), material="metal")
        scene = build_scene(room, objects=[cabinet] if not isinstance(cabinet, tuple) else cabinet)
        sensor = LandmarkSensor(scene=scene)
        assert sensor.in_sight([[0.0, 0.0, 0.0]], LANDMARK)[0] == seen


def test_detections_have_the_stated_errors_and_clutter_stays_in_the_field_of_view():
    poses = np.tile([0.0, 0.0, 0.0], (20_000, 1))
    rng = np.random.default_rng(3)
    got = LandmarkSensor().detect(poses, LANDMARK, rng)
    error = got - LANDMARK.in_body(poses)
    np.testing.assert_allclose(error.mean(axis=0), 0.0, atol=0.003)
    np.testing.assert_allclose(error.std(axis=0), 0.1, rtol=0.02)
    away = LandmarkSensor(false_probability=1.0)
    clutter = away.detect(poses + np.array([0, 0, np.pi]), LANDMARK, rng)
    azimuth = np.arctan2(clutter[:, 1] - 0.03, clutter[:, 0] - 0.09)
    assert np.abs(azimuth - 0.216).max() <= 0.5 * away.width_rad
    missed = LandmarkSensor(detection_probability=0.3).detect(poses, LANDMARK, rng)
    assert np.isfinite(missed[:, 0]).mean() == pytest.approx(0.3, abs=0.02)


def test_a_landmark_inside_a_wall_or_an_object_is_refused():
    room = box_room((4.0, 4.0, 3.0))
    block = box((1.0, 1.0, 1.0), position_m=(1.0, 1.0, 0.0), material="metal")
    scene = build_scene(room, objects=[block] if not isinstance(block, tuple) else block)
    Landmark(position_m=np.array([4.0, 2.0, 0.5]), heading_rad=0.0).check(scene)
    for place, heading, what in (
        ([4.05, 2.0, 0.5], 0.0, "inside a wall"),
        ([4.0, 2.0, 0.5], np.pi, "inside a wall"),
        ([1.5, 1.5, 0.5], 0.0, "inside an object"),
    ):
        with pytest.raises(NavigationError, match=what):
            Landmark(position_m=np.array(place), heading_rad=heading).check(scene)
