"""Laws of capture, against single paths worked out one by one."""

import math
from pathlib import Path

import numpy as np
import pytest

from octant.em.antennas.kinds import Antenna
from octant.em.fields.gains import path_gains
from octant.em.paths.tracing import trace_paths
from octant.em.reader.response import sector_response
from octant.reader_design.setting.capture import (
    arriving_paths,
    captured,
    captured_by_tag,
    captured_share,
)
from octant.reader_design.setting.samples import room_places_m
from octant.reader_design.setting.setting import Sampling, build_setting
from octant.reader_design.study_file.loading import parse_study

F = 2.4e9
ELEMENTS = np.arange(8) * np.pi / 4
READER = sector_response(ELEMENTS, frequency_hz=F)
CHANNELS = (2.40e9, 2.48e9)
READERS = tuple(sector_response(ELEMENTS, frequency_hz=f) for f in CHANNELS)
TAG = '[[tag]]\nid = "A"\nposition_m = [2.0, 1.5, 2.9]\nantenna = "dipole"\n'
ROOM = "[room]\nbox_m = [5.0, 4.0, 3.0]\nmaterial = 'concrete'\n" + TAG
METAL = ROOM.replace("concrete", "metal")
HIDDEN = (
    "[room]\nbox_m = [5.0, 4.0, 3.0]\n[[room.object]]\nkind = 'box'\nmaterial = 'metal'\n"
    "size_m = [1.0, 1.0, 2.0]\nposition_m = [1.5, 1.0, 0.5]\n" + TAG
)
SAMPLING = Sampling(nearest_m=0.5, farthest_m=3.0, room_spacing_m=0.5)


def setting_of(text, order=2, readers=(READER,)):
    study = parse_study(
        f"{text}[solver]\nmax_reflections = {order}\n", source="test", directory=Path()
    )
    return build_setting(study, sampling=SAMPLING).with_responses(readers)


def turned(response, antenna, turn_rad):
    """One antenna of the reader as an antenna of the room, turned with the robot."""
    return Antenna(
        kind="pattern",
        length_m=0.0,
        frequency_hz=response.frequency_hz,
        axis=np.array([0.0, 0.0, 1.0]),
        azimuth_rad=turn_rad,
        pattern=response.pattern[antenna],
    )


def by_single_paths(setting, place, antenna):
    """Whether the strongest bent path beats the direct one at an antenna that faces the tag."""
    tag, radio = setting.tags[0], setting.radios[0]
    towards = math.atan2(*(tag.position_m[:2] - place)[::-1])
    found = setting.candidates(tag.position_m)
    paths = trace_paths(radio, found, [[*place, setting.reader_z_m]])
    receiver = turned(READER, antenna, towards - ELEMENTS[antenna])
    gains = path_gains(radio, paths, transmitter=tag.antennas[0], receiver=receiver).gain
    power = np.abs(gains) ** 2
    return max(power[paths.order > 0], default=0.0) > max(power[paths.order == 0], default=0.0)


@pytest.mark.parametrize("text", [ROOM, METAL, HIDDEN])
def test_capture_is_what_single_paths_say(text):
    setting = setting_of(text)
    found = captured_by_tag(setting)["A"]
    places = room_places_m(setting)[0][1]
    rows = np.random.default_rng(1).permutation(len(places))[:8]
    for row in rows:
        for antenna in (0, 3):
            wanted = by_single_paths(setting, places[row], antenna)
            assert found[row, antenna] == wanted, (places[row], antenna)


def test_paths_add_up_to_the_rss_of_the_link():
    setting = setting_of(
        ROOM.replace("[room]", f"[radio]\nchannels_hz = {list(CHANNELS)}\n[room]"), readers=READERS
    )
    tag, place, heading = setting.tags[0], np.array([[3.3, 2.8]]), 0.7
    paths = arriving_paths(setting, tag, place)
    azimuth = (paths.phi_rad - (heading - math.pi / 2)) % (2 * math.pi)
    power = 0.0
    for response, field in zip(READERS, paths.field, strict=True):
        voltage = (response.far_field(paths.theta_rad, azimuth) * field).sum(axis=(-1, -2))
        power = power + np.abs(voltage) ** 2 / len(READERS)
    rss = setting.link(tag).rss_w([[3.3, 2.8, heading]])[0]
    np.testing.assert_allclose(power, rss, rtol=1e-9)


def test_nothing_is_captured_without_reflections():
    setting = setting_of(ROOM, order=0)
    assert captured_share(setting) == 0.0


def test_a_hidden_tag_is_captured_wherever_a_reflection_arrives():
    setting = setting_of(HIDDEN)
    tag = setting.tags[0]
    under = np.array([[1.2, 1.5]])  # behind the box, seen from the tag
    paths = arriving_paths(setting, tag, under)
    assert (paths.bends > 0).all()
    assert paths.bends.size > 0
    assert captured(paths, np.zeros(1), (READER,)).all()


def test_near_a_vertical_dipole_a_metal_wall_is_stronger_than_the_tag():
    # under the tag the direct ray leaves in the dipole's null, the image's does not
    setting = setting_of(METAL, order=1)
    near, far = np.array([[2.1, 1.5]]), np.array([[4.5, 3.0]])
    towards = np.array([math.pi]), np.array([math.atan2(-1.5, -2.5)])
    for place, azimuth, expected in ((near, towards[0], True), (far, towards[1], False)):
        paths = arriving_paths(setting, setting.tags[0], place)
        assert captured(paths, azimuth, (READER,)).all() == expected


def test_capture_does_not_depend_on_where_the_room_lies_or_how_it_is_turned():
    setting = setting_of(ROOM)
    share = captured_share(setting)
    assert 0.0 < share < 1.0
    moved = (
        "[room]\nbox_m = [4.0, 5.0, 3.0]\norigin_m = [-4.0, 0.0, 7.0]\nmaterial = 'concrete'\n"
        # turned by 90 degrees, lifted
        '[[tag]]\nid = "A"\nposition_m = [-1.5, 2.0, 9.9]\nantenna = "dipole"\n'
    )
    assert captured_share(setting_of(moved)) == pytest.approx(share, abs=1e-12)


def test_capture_without_power_is_none():
    setting = setting_of(ROOM, order=1)
    paths = arriving_paths(setting, setting.tags[0], np.array([[3.0, 3.0]]))
    deaf = sector_response(ELEMENTS, frequency_hz=F, exponent=4.0)
    silent = type(deaf)(
        model="deaf",
        frequency_hz=F,
        azimuths_rad=deaf.azimuths_rad,
        phase_centres_m=deaf.phase_centres_m,
        pattern=0.0 * deaf.pattern,
    )
    assert not captured(paths, np.zeros(1), (silent,)).any()
