import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.sensing.bearing import (
    checked_azimuths,
    doct,
    reader_azimuth,
    room_azimuth,
    steering_pair,
    turn_towards,
    vector_sum_bearing,
    wrap_angle,
)

EIGHT = np.radians(45.0 * np.arange(8))


def even(antennas):
    return 2 * np.pi * np.arange(antennas) / antennas


def algorithm_1_as_printed(heading_deg, gamma_deg):
    """The thesis' Algorithm 1, line by line; returns the turns it executes and its θ_new."""
    turns = []
    delta = gamma_deg - 90
    if delta > 180:
        delta = -(360 - delta)
        turns.append(delta)
        new = heading_deg + delta
    if delta < 0:
        turns.append(delta)
        new = heading_deg + (360 - abs(delta))
    else:
        turns.append(delta)
        new = heading_deg + delta
    return turns, new - 360 if new >= 360 else new


def test_wrapping_keeps_the_direction_and_takes_the_upper_end():
    angles = np.radians([-540.0, -180.0, -179.0, 0.0, 180.0, 181.0, 725.0])
    expected = np.radians([180.0, 180.0, -179.0, 0.0, 180.0, -179.0, 5.0])
    assert wrap_angle(angles) == pytest.approx(expected, abs=1e-12)


def test_robot_heading_90_carries_antenna_1_at_room_azimuth_0():
    assert room_azimuth(np.pi / 2, EIGHT[0]) == pytest.approx(0.0)
    assert room_azimuth(0.3, EIGHT[2]) == pytest.approx(0.3)  # antenna 3 is the front


def test_reader_azimuth_inverts_room_azimuth():
    headings = np.linspace(-3, 3, 13)
    back = reader_azimuth(headings[:, None], room_azimuth(headings[:, None], EIGHT))
    assert wrap_angle(back - EIGHT) == pytest.approx(np.zeros((13, 8)), abs=1e-12)


@pytest.mark.parametrize("antenna", range(8))
@pytest.mark.parametrize("heading_deg", [-170.0, 0.0, 90.0, 175.0])
def test_rotation_brings_the_front_to_where_the_strongest_antenna_looked(antenna, heading_deg):
    rss = np.ones(8)
    rss[antenna] = 2.0
    heading = np.radians(heading_deg)
    gamma = doct(rss, EIGHT)
    wanted = room_azimuth(heading, EIGHT[antenna])
    assert np.cos(heading + turn_towards(gamma) - wanted) == pytest.approx(1.0)
    assert abs(turn_towards(gamma)) <= np.pi


def test_first_leg_of_the_thesis_rotates_from_90_to_0_degrees():
    rss = np.cos((np.radians(14.0) - EIGHT) / 2) ** 4
    assert doct(rss, EIGHT) == 0.0
    assert 90.0 + np.degrees(turn_towards(doct(rss, EIGHT))) == pytest.approx(0.0)
    finer = turn_towards(vector_sum_bearing(rss, EIGHT))
    assert 90.0 + np.degrees(finer) == pytest.approx(14.0)


def test_algorithm_1_as_printed_turns_twice_for_antenna_8_and_once_for_the_others():
    for antenna, gamma_deg in enumerate(np.degrees(EIGHT)):
        turns, stored = algorithm_1_as_printed(90.0, gamma_deg)
        right = np.degrees(turn_towards(np.radians(gamma_deg)))
        assert sum(turns) == pytest.approx(2 * right if antenna == 7 else right)
        assert np.cos(np.radians(stored - 90.0 - right)) == pytest.approx(1.0)


@pytest.mark.parametrize("antennas", [3, 4, 5, 6, 8, 12, 16])
def test_vector_sum_is_exact_for_cardioid_antennas(antennas):
    # 1 + cos has harmonics 0 and 1 only, so its weighted sum points exactly at the source.
    bearing = np.linspace(-3.1, 3.1, 41)
    rss = 1 + np.cos(bearing[:, None] - even(antennas))
    found = vector_sum_bearing(rss, even(antennas))
    assert wrap_angle(found - bearing) == pytest.approx(np.zeros(41), abs=1e-12)


def test_nothing_received_has_no_bearing():
    assert np.isnan(doct(np.zeros(8), EIGHT))
    assert np.isnan(vector_sum_bearing(np.zeros(8), EIGHT))
    both = vector_sum_bearing(np.array([np.zeros(8), np.eye(8)[2]]), EIGHT)
    assert np.isnan(both[0])
    assert both[1] == pytest.approx(np.pi / 2)


def test_the_thesis_reader_steers_by_antennas_2_and_4():
    assert steering_pair(EIGHT) == (1, 3)


@pytest.mark.parametrize("antennas", range(3, 17))
def test_steering_pair_stands_on_both_sides_and_is_symmetric_for_even_numbers(antennas):
    azimuths = even(antennas)
    right, left = steering_pair(azimuths)
    away = np.degrees(wrap_angle(azimuths[[right, left]] - np.pi / 2))
    assert away[0] < 0 < away[1]
    offset = 0.0 if antennas % 2 == 0 else 90.0 / antennas
    assert abs(away.sum() / 2) == pytest.approx(offset, abs=1e-9)


def test_the_steering_pair_follows_the_azimuths_and_not_the_numbers():
    shuffled = EIGHT[[2, 5, 0, 7, 1, 4, 3, 6]]
    assert steering_pair(shuffled) == (4, 6)


def test_readers_without_a_bearing_are_refused():
    with pytest.raises(NavigationError, match="at least 3"):
        checked_azimuths([0.0, 1.0])
    with pytest.raises(NavigationError, match="same azimuth"):
        checked_azimuths([0.0, 1.0, 2 * np.pi])
    with pytest.raises(NavigationError, match="one side"):
        steering_pair(np.radians([95.0, 100.0, 105.0]))
