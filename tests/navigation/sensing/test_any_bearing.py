"""Bearings of antennas anywhere on the robot, and patterns that it measures by turning."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.sensing.bearing import vector_sum_bearing
from octant.navigation.sensing.harmonic_bearing import (
    distinct_azimuths,
    harmonic_bearing,
    strongest_bearing,
)
from octant.navigation.sensing.pattern_match import PatternMatcher
from octant.navigation.sensing.spin_patterns import BEARINGS, gain_table, spin_gains_db

EVEN = 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS


@given(st.integers(3, 9), st.integers(0, 2**32 - 1))
def test_of_even_antennas_the_first_harmonic_is_the_vector_sum(count, seed):
    rss = np.random.default_rng(seed).exponential(1e-6, count)
    azimuths = 2.0 * np.pi * np.arange(count) / count
    expected = vector_sum_bearing(rss, azimuths)
    assert wrap_angle(harmonic_bearing(rss, azimuths) - expected) == pytest.approx(0.0, abs=1e-9)


@given(st.integers(0, 2**32 - 1), st.floats(-3.0, 3.0))
def test_uneven_antennas_pull_the_first_harmonic_nowhere(seed, bearing):
    azimuths = np.random.default_rng(seed).uniform(-np.pi, np.pi, 6)
    rss = 1e-9 * (1.5 + np.cos(azimuths - bearing))
    rss[2] = np.nan  # an antenna that was not read
    found = harmonic_bearing(rss, azimuths)
    if np.isfinite(found):
        assert wrap_angle(found - bearing) == pytest.approx(0.0, abs=1e-6)


def test_directions_that_say_nothing_give_none():
    assert np.isnan(harmonic_bearing([1.0, 2.0], [0.0, 1.0]))
    assert np.isnan(harmonic_bearing([1.0, 2.0, 1.5], [0.0, 0.05, 0.1]))
    assert np.isnan(harmonic_bearing([0.0, 0.0, 0.0], [0.0, 2.0, 4.0]))
    assert np.isnan(strongest_bearing([1.0], [0.0]))
    assert np.isnan(strongest_bearing([0.0, np.nan], [0.0, 2.0]))
    assert strongest_bearing([1.0, 3.0, np.nan], [0.0, 2.0, 1.0]) == 2.0


def test_azimuths_are_one_for_each_antenna():
    assert distinct_azimuths([0.3]).tolist() == [0.3]
    for wrong in ([], [1.0, 1.0 + 2.0 * np.pi]):
        with pytest.raises(NavigationError, match="its own direction"):
            distinct_azimuths(wrong)


def gains(azimuths, bearing):
    away = np.asarray(bearing)[..., None] - azimuths
    return 6.0 * np.cos(away) + 1.5 * np.cos(2.0 * away)


def spun(azimuths, step, levels=(-50.0, -80.0)):
    heading = np.arange(0.0, 2.0 * np.pi, step)
    rows = [(stand, wrap_angle(1.0 - h)) for stand in range(len(levels)) for h in heading]
    stand, bearing = np.array(rows).T
    level = np.array(levels)[stand.astype(int), None] + gains(azimuths, bearing)
    k, n = level.shape
    return (
        np.repeat(bearing, n),
        level.ravel(),
        np.tile(np.arange(n), k),
        np.repeat(stand.astype(int), n),
    )


@pytest.mark.parametrize("count", [1, 5])
def test_a_spin_gives_back_the_patterns_whatever_the_levels(count):
    azimuths = np.array([0.2, 1.3, 2.9, -2.0, -0.9])[:count]
    bearing, level, antennas, stands = spun(azimuths, 0.2)
    found = spin_gains_db(bearing, level, antennas=antennas, stands=stands, count=count)
    expected = gains(azimuths, EVEN)
    np.testing.assert_allclose(found, expected - expected.mean(), atol=1e-9)


def test_a_turn_that_is_not_whole_gives_no_pattern():
    bearing, level, antennas, stands = spun(np.array([0.0]), 0.2)
    front = np.abs(bearing) < 2.0
    with pytest.raises(NavigationError, match="gap of"):
        spin_gains_db(
            bearing[front], level[front], antennas=antennas[front], stands=stands[front], count=1
        )


def test_a_table_of_gains_falls_as_in_free_space():
    table = gain_table(gains(np.array([0.0, 2.0]), EVEN), height_m=2.0, reach_m=8.0)
    level = 10.0 * np.log10(table.power_w[:, :, 0, :])
    distance = 8.0 * (np.arange(61) / 60.0) ** 2
    expected = -10.0 * np.log10((distance**2 + 4.0) / 4.0)
    np.testing.assert_allclose(
        level - level[:1], np.broadcast_to(expected[:, None, None], level.shape), atol=1e-9
    )


def test_readings_of_a_turning_robot_match_like_one_reading_of_more_antennas():
    azimuth = np.array([0.0])
    matcher = PatternMatcher(table=gain_table(gains(azimuth, EVEN), height_m=2.0, reach_m=8.0))
    now = 0.7
    turned = np.array([0.0, 0.8, 2.1, 3.3, 4.6])
    rss = 10.0 ** ((gains(azimuth, now + turned) - 70.0) / 10.0)
    bearing, variance = matcher.bearing_over(rss, turned)
    assert bearing == pytest.approx(now, abs=0.05)
    assert variance < 0.1
    assert matcher.bearing(rss[0])[1] == pytest.approx(np.pi**2 / 3.0)


@given(st.integers(0, 2**32 - 1))
def test_one_reading_matches_as_it_did(seed):
    azimuths = np.array([0.0, 1.5, 3.1, 4.6])
    matcher = PatternMatcher(table=gain_table(gains(azimuths, EVEN), height_m=2.0, reach_m=8.0))
    rss = np.random.default_rng(seed).exponential(1e-6, 4)
    np.testing.assert_allclose(
        matcher.bearing_over(rss[None], np.zeros(1)), matcher.bearing(rss), atol=1e-9
    )
