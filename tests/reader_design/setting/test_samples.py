"""Laws of the places and poses at which designs are probed."""

from pathlib import Path

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.received_power import reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings
from octant.geometries.errors import ConfigError
from octant.geometries.furniture import box
from octant.geometries.rooms import Doorway, box_room, prism_room
from octant.geometries.scene import build_scene, free_space_scene
from octant.navigation.angles import wrap_angle
from octant.navigation.sensing.bearing import reader_azimuth
from octant.reader_design.setting.samples import (
    facing_poses,
    floor_points_m,
    free_points_m,
    grid_azimuths_rad,
    room_places_m,
    sample_rss_w,
    standing_room,
)
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.setting.setting import Sampling, build_setting
from octant.reader_design.study_file.loading import parse_study

F = 2.4e9
ROOM = build_scene(
    box_room((4.0, 3.0, 3.0), origin_m=(-1.0, -1.0, 0.0)),
    objects=(box((1.0, 0.5, 1.0), position_m=(0.0, 0.0, 0.0), material="metal"),),
)


class CountingLink:
    """RSS that names the pose it was asked for."""

    def rss_w(self, poses):
        return np.column_stack([poses, poses.sum(axis=1)])


def test_tag_appears_at_the_wanted_azimuth_from_every_pose():
    rng = np.random.default_rng(4)
    points, tag = rng.uniform(-3, 3, (7, 2)), np.array([0.3, -0.2])
    azimuths = grid_azimuths_rad(8, 4)
    poses = facing_poses(points, tag, azimuths)
    towards = np.arctan2(tag[1] - poses[..., 1], tag[0] - poses[..., 0])
    seen = reader_azimuth(poses[..., 2], towards)
    np.testing.assert_allclose(wrap_angle(seen - azimuths), 0.0, atol=1e-12)


@pytest.mark.parametrize("antennas", [3, 5, 8])
def test_grid_holds_every_antenna_and_every_half_way_direction(antennas):
    grid = grid_azimuths_rad(antennas, 4)
    for wanted in (np.arange(antennas), np.arange(antennas) + 0.5):
        angle = wanted * 2 * np.pi / antennas
        assert np.abs(wrap_angle(grid - angle[:, None])).min(axis=1).max() < 1e-12


def test_distances_span_the_range_with_both_ends():
    distances = Sampling().distances_m()
    assert (distances[0], distances[-1]) == (0.5, 5.0)
    assert np.diff(distances) == pytest.approx(0.5)
    assert Sampling().travel_m()[0] == 0.0


def test_quick_sampling_keeps_the_range_and_has_fewer_points():
    fine, quick = Sampling(), Sampling().coarser()
    assert quick.distances_m()[[0, -1]].tolist() == fine.distances_m()[[0, -1]].tolist()
    assert quick.room_spacing_m == 2 * fine.room_spacing_m
    assert quick.free_azimuths < fine.free_azimuths
    assert quick.free_azimuths % 2 == quick.room_azimuths % 2 == 0


def test_samples_are_ordered_by_place_azimuth_antenna():
    azimuths = np.array([0.0, 1.0])
    points = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    rss = sample_rss_w(CountingLink(), points, [0.0, 0.0], azimuths)
    assert rss.shape == (3, 2, 4)
    np.testing.assert_array_equal(rss[:, 0, :2], points)
    np.testing.assert_array_equal(rss[:, 1, :2], points)


def test_floor_points_lie_in_the_room_outside_objects_and_clear_of_walls():
    points = floor_points_m(ROOM, spacing_m=0.25, reader_z_m=0.3, clearance_m=0.2)
    x, y = points.T
    assert ((x >= -0.8) & (x <= 2.8) & (y >= -0.8) & (y <= 1.8)).all()
    in_box = (x > 0.0) & (x < 1.0) & (y > 0.0) & (y < 0.5)
    assert not in_box.any()
    beside = (x > -0.2) & (x < 1.2) & (y > 0.0) & (y < 0.5)
    assert not beside.any()
    assert len(points) > 100


def test_robot_does_not_fit_below_the_reader_where_a_low_object_stands():
    low = build_scene(
        box_room((4.0, 4.0, 3.0)),
        objects=(box((1.0, 1.0, 0.1), position_m=(1.0, 1.0, 0.0), material="wood"),),
    )
    fits = standing_room(low, np.array([[1.5, 1.5], [3.0, 3.0]]), reader_z_m=0.3, clearance_m=0.1)
    assert fits.tolist() == [False, True]


def test_open_room_is_where_its_floor_is():
    # an L-shaped room with a doorway is not closed: its notch lies within the bounds, but outside
    outline = ((0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0))
    door = Doorway(wall=0, offset_m=1.0, width_m=0.9, height_m=2.0)
    scene = build_scene(prism_room(outline, 2.5, doorways=(door,)))
    places = np.array([[3.0, 3.0], [1.0, 3.0], [3.0, 1.0]])
    fits = standing_room(scene, places, reader_z_m=0.3, clearance_m=0.1)
    assert fits.tolist() == [False, True, True]


def test_robot_fits_everywhere_in_free_space():
    fits = standing_room(
        free_space_scene(), np.array([[100.0, -3.0]]), reader_z_m=0.3, clearance_m=0.1
    )
    assert fits.all()


STUDY = """
[room]
box_m = [6.0, 4.0, 3.0]
[[tag]]
id = "A"
position_m = [1.0, 1.0, 2.9]
antenna = "dipole"
[[tag]]
id = "B"
position_m = [5.0, 3.0, 2.9]
antenna = "dipole"
"""


def test_room_samples_take_only_places_within_range_of_each_tag():
    study = parse_study(STUDY, source="test", directory=Path())
    sampling = Sampling(nearest_m=0.5, farthest_m=2.0)
    setting = build_setting(study, sampling=sampling)
    found = {tag.id: places for tag, places in room_places_m(setting)}
    assert set(found) == {"A", "B"}
    for name, point in (("A", (1.0, 1.0)), ("B", (5.0, 3.0))):
        distance = np.hypot(*(found[name] - point).T)
        assert distance.size > 10
        assert distance.min() >= 0.5
        assert distance.max() <= 2.0


def test_room_without_a_place_in_range_is_refused():
    study = parse_study(STUDY, source="test", directory=Path())
    sampling = Sampling(nearest_m=20.0, farthest_m=30.0)
    with pytest.raises(ConfigError, match=r"none of the \d+ places on the floor lies 20 to 30 m"):
        room_places_m(build_setting(study, sampling=sampling))


def test_a_link_and_a_stand_in_give_the_same_samples():
    link = reader_link(
        radio_scene(ROOM, F),
        tag_position_m=(1.0, 1.0, 2.5),
        tag_antenna=make_antenna("dipole", F),
        tag_power_w=1.0,
        response=sector_response(np.arange(8) * np.pi / 4, frequency_hz=F),
        reader_height_m=0.3,
        solver=SolverSettings(max_reflections=1),
    )

    class StandIn:
        def rss_w(self, poses):
            return link.rss_w(poses)

    points, azimuths = np.array([[2.0, 0.0], [-0.5, 1.5]]), grid_azimuths_rad(8, 2)
    one = sample_rss_w(link, points, [1.0, 1.0], azimuths)
    other = sample_rss_w(StandIn(), points, [1.0, 1.0], azimuths)
    np.testing.assert_array_equal(one, other)


def test_ideal_sector_reader_is_right_in_every_direction_of_free_space():
    # cos^4 half-angle power windows: sum_i cos^4((x - d_i)/2) e^{j d_i} = (n / 4) e^{j x}
    elements = np.arange(8) * np.pi / 4
    link = reader_link(
        radio_scene(free_space_scene(), F),
        tag_position_m=(0.0, 0.0, 3.0),
        tag_antenna=make_antenna("dipole", F),
        tag_power_w=1.0,
        response=sector_response(elements, frequency_hz=F, exponent=2.0),
        reader_height_m=0.3,
        solver=SolverSettings(max_reflections=0),
    )
    azimuths = grid_azimuths_rad(8, 6)
    points = free_points_m(Sampling().distances_m())
    scores = score_rss(sample_rss_w(link, points, [0.0, 0.0], azimuths), azimuths, elements)
    assert scores.right_share == 1.0
    assert scores.vector_max_rad < 1e-3
    assert scores.monotonic_normalised_share == 1.0
    assert scores.slope_normalised_per_rad > 0.0
    # the window of a neighbour, 45 degrees off: 20 log10 cos^2(22.5 deg)
    assert scores.margin_worst_db == pytest.approx(-40 * np.log10(np.cos(np.pi / 8)), abs=0.01)
