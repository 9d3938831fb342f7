"""Laws of the maps of the bearing error, against one pose at a time."""

import math
from pathlib import Path

import numpy as np
import pytest

from octant.em.reader.response import sector_response
from octant.navigation.angles import wrap_angle
from octant.navigation.sensing.bearing import reader_azimuth, vector_sum_bearing
from octant.reader_design.experiments.study.error_maps import (
    FloorGrid,
    error_maps,
    heading_errors_rad,
    tag_errors,
)
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.showing.map_view import symmetric_turn
from octant.reader_design.study_file.loading import parse_study

READER = sector_response(np.arange(8) * np.pi / 4, frequency_hz=2.4e9, exponent=2.0)
TAGS = (
    '[[tag]]\nid = "A"\nposition_m = [1.0, 1.5, 2.9]\nantenna = "dipole"\n'
    '[[tag]]\nid = "B"\nposition_m = [4.0, 2.0, 2.9]\nantenna = "dipole"\n'
)
ROOM = (
    f"[room]\nbox_m = [5.0, 4.0, 3.0]\nmaterial = 'concrete'\n{TAGS}[solver]\nmax_reflections = 1\n"
)
HEADINGS = np.arange(16) * np.pi / 8


def setting_of(text):
    study = parse_study(text, source="test", directory=Path())
    return build_setting(study).with_responses([READER])


def errors_of(link, places, headings):
    return heading_errors_rad(link, link.rss_by_heading_w(places, headings), places, headings)


def maps_of(setting, places, standing):
    grid = FloorGrid(places_m=places, standing=standing, heading_rad=np.pi / 2)
    errors = [tag_errors(setting, grid, k, lambda _: None) for k in range(len(setting.tags))]
    return error_maps(setting, grid, errors)


def test_error_at_a_place_is_the_rms_over_single_poses():
    setting = setting_of(ROOM)
    tag = setting.tags[0]
    link = setting.link(tag)
    places = np.array([[3.0, 2.5], [1.4, 1.2]])
    vector, strongest = errors_of(link, places, HEADINGS)
    for row, place in enumerate(places):
        errors = []
        for heading in HEADINGS:
            rss = link.rss_w([[*place, heading]])[0]
            towards = math.atan2(*(tag.position_m[:2] - place)[::-1])
            truth = reader_azimuth(heading, towards)
            guesses = (
                vector_sum_bearing(rss, READER.azimuths_rad),
                READER.azimuths_rad[rss.argmax()],
            )
            errors.append([float(wrap_angle(guess - truth)) for guess in guesses])
        wanted = np.sqrt((np.array(errors) ** 2).mean(axis=0))
        np.testing.assert_allclose([vector[row], strongest[row]], wanted, rtol=1e-9)
    assert vector.max() > 0.01  # the walls do mislead


def test_sector_reader_has_no_error_in_free_space_but_that_of_its_sectors():
    setting = setting_of(f"[room]\nfree_space = true\n{TAGS}")
    link = setting.link(setting.tags[0])
    headings = np.arange(720) * np.pi / 360
    vector, strongest = errors_of(link, np.array([[4.0, 3.0]]), headings)
    assert vector[0] < 1e-3
    assert strongest[0] == pytest.approx(np.radians(22.5) / math.sqrt(3.0), rel=1e-2)


def test_maps_hold_each_tag_and_nothing_where_no_robot_stands():
    setting = setting_of(ROOM)
    places = np.stack(np.meshgrid([1.0, 2.0, 3.0], [1.0, 2.0], indexing="ij"), axis=-1)
    standing = np.array([[True, True], [True, False], [True, True]])
    maps = maps_of(setting, places, standing)
    for name in ("vector_error", "strongest_error", "captured_share"):
        values = maps[name].values
        assert values.shape == (2, 3, 2)
        np.testing.assert_array_equal(np.isnan(values), np.broadcast_to(~standing, (2, 3, 2)))
    link = setting.link(setting.tags[1])
    alone = errors_of(link, places[2, 1][None], np.arange(32) * np.pi / 16)
    assert maps["vector_error"].values[1, 2, 1] == pytest.approx(alone[0][0], rel=1e-12)
    assert maps["strongest_error"].values[1, 2, 1] == pytest.approx(alone[1][0], rel=1e-12)


def test_turned_maps_hold_the_powers_and_the_readers_symmetry_gives_all_other_headings():
    setting = setting_of(ROOM)
    places = np.stack(np.meshgrid([1.0, 2.0, 3.0], [1.0, 2.0], indexing="ij"), axis=-1)
    standing = np.array([[True, True], [True, False], [True, True]])
    maps = maps_of(setting, places, standing)
    turn = symmetric_turn(READER)
    assert turn == 1  # eight equal sectors
    held = maps["turned_rss_w"].values
    assert (held[:, :, 1, 1] == 0.0).all()
    link = setting.link(setting.tags[0])
    for heading, power in zip(maps["turned_heading"].values, held[:, 0, 2, 0], strict=True):
        for k in range(8):
            turned = heading + 2.0 * np.pi / 8 * k
            exact = link.rss_w([[*places[2, 0], turned]])[0]
            np.testing.assert_allclose(np.roll(power, -k), exact, rtol=1e-5)


def test_reader_that_is_not_symmetric_is_found_out():
    bent = READER.azimuths_rad + np.radians([0, 0, 3, 0, 0, 0, 0, 0])
    one_off = sector_response(bent, frequency_hz=2.4e9, exponent=2.0)
    assert symmetric_turn(one_off) == 0
    pairs = np.arange(8) * np.pi / 4 + np.radians([0, 5] * 4)
    assert symmetric_turn(sector_response(pairs, frequency_hz=2.4e9, exponent=2.0)) == 2
