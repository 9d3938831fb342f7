"""Laws of the scores, on patterns whose scores are known in closed form."""

import dataclasses

import numpy as np
import pytest

from octant.em.decibels import power_dbm
from octant.geometries.errors import AntennaError
from octant.navigation.angles import wrap_angle
from octant.reader_design.setting.measures import (
    facing_ratios_db,
    leaders,
    right_share,
    steering_signal,
    vector_sum_bearing_rad,
)
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.study_file.scores import (
    SCORE_NAMES,
    Scores,
    score_unit,
)

N = 8
ELEMENTS = np.arange(N) * 2 * np.pi / N
AZIMUTHS = np.arange(N * 18) * 2 * np.pi / (N * 18)


def pattern_rss(law, azimuths=AZIMUTHS, elements=ELEMENTS, distances=(1.0, 2.0, 4.0)):
    """RSS of a reader whose every antenna has the power pattern `law` around its azimuth."""
    one = law(wrap_angle(azimuths[:, None] - elements))
    return np.array([one / d**2 for d in distances])


def raised_cosine(angle):
    return 1e-6 * (1.0 + 0.8 * np.cos(angle))


def test_raised_cosine_is_right_everywhere_and_its_vector_sum_is_exact():
    # sum_i (1 + a cos(x - d_i)) e^{j d_i} = (n a / 2) e^{j x} for n >= 3
    scores = score_rss(pattern_rss(raised_cosine), AZIMUTHS, ELEMENTS)
    assert scores.right_share == 1.0
    assert scores.vector_max_rad < 1e-12
    assert scores.monotonic_share == 1.0
    assert scores.monotonic_normalised_share == 1.0


def test_strongest_antenna_error_is_the_quantisation_error_of_the_sector():
    # uniform in +-22.5 deg: mean 11.25 deg, rms 22.5/sqrt(3), 90 % 20.25, max 22.5 deg
    azimuths = np.arange(N * 1000) * 2 * np.pi / (N * 1000)
    rss = pattern_rss(raised_cosine, azimuths, distances=(1.0,))
    scores = score_rss(rss, azimuths, ELEMENTS)
    sector = np.deg2rad(22.5)
    assert scores.strongest_mean_rad == pytest.approx(sector / 2, abs=1e-4)
    assert scores.strongest_rms_rad == pytest.approx(sector / np.sqrt(3), abs=1e-4)
    assert scores.strongest_p90_rad == pytest.approx(0.9 * sector, abs=1e-3)
    assert scores.strongest_max_rad == pytest.approx(sector, abs=1e-9)


def test_ratios_of_the_raised_cosine_in_closed_form():
    scores = score_rss(pattern_rss(raised_cosine), AZIMUTHS, ELEMENTS)
    assert scores.front_to_back_mean_db == pytest.approx(10 * np.log10(1.8 / 0.2), abs=1e-9)
    assert scores.front_to_back_worst_db == pytest.approx(10 * np.log10(9.0), abs=1e-9)
    margin = 10 * np.log10(1.8 / (1 + 0.8 * np.cos(np.pi / 4)))
    assert scores.margin_mean_db == pytest.approx(margin, abs=1e-9)
    assert scores.margin_worst_db == pytest.approx(margin, abs=1e-9)


def test_steering_signal_of_the_raised_cosine_in_closed_form():
    # z2 - z4 = 2 P a sin(45 deg) sin(e), z2 + z4 = 2 P (1 + a cos(45 deg) cos(e))
    signal = steering_signal(pattern_rss(raised_cosine, distances=(1.0,)), AZIMUTHS, ELEMENTS)
    e = signal.deviation_rad
    assert e[0] == pytest.approx(-np.pi / 4)
    assert e[-1] == pytest.approx(np.pi / 4)
    root = np.sqrt(0.5)
    np.testing.assert_allclose(signal.difference_w[0], 1.6e-6 * root * np.sin(e), atol=1e-18)
    np.testing.assert_allclose(
        signal.normalised[0], 0.8 * root * np.sin(e) / (1 + 0.8 * root * np.cos(e)), atol=1e-12
    )
    scores = score_rss(pattern_rss(raised_cosine, distances=(1.0,)), AZIMUTHS, ELEMENTS)
    assert scores.slope_w_per_rad == pytest.approx(1.6e-6 * root, rel=1e-3)
    assert scores.slope_normalised_per_rad == pytest.approx(0.8 * root / (1 + 0.8 * root), rel=2e-3)
    assert scores.full_scale_w == pytest.approx(0.8e-6)


def test_levels_and_usable_share_follow_the_threshold():
    rss = pattern_rss(raised_cosine, ELEMENTS, distances=(1.0, 10.0))
    level = power_dbm(1.8e-6)
    scores = score_rss(rss, ELEMENTS, ELEMENTS, usable_dbm=float(level) - 10.0)
    assert scores.usable_share == 0.5
    assert scores.level_median_dbm == pytest.approx(float(level) - 10.0)


def test_reader_without_discrimination_scores_one_in_n_and_has_no_bearing():
    rss = np.full((2, AZIMUTHS.size, N), 1e-9)
    # half-way directions have two right antennas: 8 of 144 azimuths count double
    expected = (AZIMUTHS.size + N) / AZIMUTHS.size / N
    assert right_share(rss, AZIMUTHS, ELEMENTS) == pytest.approx(expected)
    scores = score_rss(rss, AZIMUTHS, ELEMENTS)
    assert scores.vector_rms_rad == pytest.approx(np.pi)
    assert scores.margin_mean_db == 0.0
    assert scores.monotonic_share == 0.0


def test_silence_is_never_right_and_never_usable():
    scores = score_rss(np.zeros((1, AZIMUTHS.size, N)), AZIMUTHS, ELEMENTS)
    assert scores.right_share == 0.0
    assert scores.strongest_mean_rad == pytest.approx(np.pi)
    assert scores.usable_share == 0.0


def test_reader_that_hears_only_its_back_is_wrong_everywhere():
    rss = pattern_rss(lambda angle: 1e-6 * (1.0 - 0.8 * np.cos(angle)))
    scores = score_rss(rss, AZIMUTHS, ELEMENTS)
    assert scores.right_share == 0.0
    assert scores.vector_mean_rad == pytest.approx(np.pi)
    assert scores.front_to_back_mean_db == pytest.approx(-10 * np.log10(9.0))
    assert scores.slope_w_per_rad < 0.0


def test_either_neighbour_is_right_half_way_between_two_antennas():
    half_way = ELEMENTS + np.pi / N
    for shift in (0, 1):
        rss = np.zeros((1, N, N))
        rss[0, np.arange(N), (np.arange(N) + shift) % N] = 1.0
        assert right_share(rss, half_way, ELEMENTS) == 1.0
    rss = np.roll(rss, 1, axis=2)
    rss = np.roll(rss, 1, axis=2)
    assert right_share(rss, half_way, ELEMENTS) == 0.0


@pytest.mark.parametrize("shift", [1, 3, 5])
def test_turning_reader_and_antenna_numbers_together_changes_no_bearing_score(shift):
    rng = np.random.default_rng(1)
    rss = rng.uniform(0.1, 1.0, (3, AZIMUTHS.size, N))
    turned = np.roll(np.roll(rss, 18 * shift, axis=1), shift, axis=2)
    before = score_rss(rss, AZIMUTHS, ELEMENTS).as_dict()
    after = score_rss(turned, AZIMUTHS, ELEMENTS).as_dict()
    steering = {n for n in before if n.startswith(("monotonic", "slope", "full_scale"))}
    for name in before.keys() - steering:
        assert after[name] == pytest.approx(before[name], rel=1e-12), name


def test_scaling_the_power_changes_only_powers_and_levels():
    rng = np.random.default_rng(2)
    rss = rng.uniform(0.1, 1.0, (2, AZIMUTHS.size, N))
    before = score_rss(rss, AZIMUTHS, ELEMENTS).as_dict()
    after = score_rss(1e-6 * rss, AZIMUTHS, ELEMENTS).as_dict()
    for name, value in before.items():
        unit = score_unit(name)
        factor, offset = {"W": (1e-6, 0), "W/rad": (1e-6, 0), "dBm": (1, -60)}.get(unit, (1, 0))
        if name == "usable_share":
            continue
        assert after[name] == pytest.approx(factor * value + offset, rel=1e-9), name


def test_vector_sum_of_one_antenna_is_its_azimuth():
    np.testing.assert_allclose(
        wrap_angle(vector_sum_bearing_rad(np.eye(N), ELEMENTS) - ELEMENTS), 0.0, atol=1e-12
    )


def test_odd_reader_takes_the_mean_of_the_two_opposite_antennas():
    n = 5
    elements = np.arange(n) * 2 * np.pi / n
    rss = np.array([[[10.0, 4.0, 1.0, 3.0, 5.0]]])
    front_to_back, margin = facing_ratios_db(rss, elements[:1], elements)
    assert front_to_back[0, 0] == pytest.approx(10 * np.log10(10.0 / 2.0))
    assert margin[0, 0] == pytest.approx(10 * np.log10(2.0))


def test_a_null_gives_a_capped_ratio_not_an_infinity():
    rss = np.zeros((1, N, N))
    rss[0, np.arange(N), np.arange(N)] = 1.0
    front_to_back, margin = facing_ratios_db(rss, ELEMENTS, ELEMENTS)
    np.testing.assert_allclose(front_to_back, 200.0)
    np.testing.assert_allclose(margin, 200.0)


def test_equally_strong_antennas_share_the_lead():
    np.testing.assert_allclose(leaders(np.array([1.0, 1.0 - 1e-12, 0.5])), [0.5, 0.5, 0.0])
    np.testing.assert_allclose(leaders(np.zeros(3)), 0.0)


@pytest.mark.parametrize(
    ("rss", "message"),
    [
        (np.ones((2, 3, N)), "shape"),
        (-np.ones((1, AZIMUTHS.size, N)), "zero or more"),
        (np.full((1, AZIMUTHS.size, N), np.nan), "NaN"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(rss, message):
    with pytest.raises(AntennaError, match=message):
        score_rss(rss, AZIMUTHS, ELEMENTS)


def test_too_few_azimuths_beside_the_front_are_refused():
    with pytest.raises(AntennaError, match="at least 3"):
        steering_signal(np.ones((1, 2, N)), ELEMENTS[[0, 4]], ELEMENTS)


def test_azimuths_that_meet_no_antenna_are_refused():
    with pytest.raises(AntennaError, match="meets an antenna"):
        score_rss(np.ones((1, AZIMUTHS.size, N)), AZIMUTHS + 0.01, ELEMENTS)


def test_every_score_has_a_unit_and_is_a_number():
    scores = score_rss(pattern_rss(raised_cosine), AZIMUTHS, ELEMENTS)
    assert set(scores.as_dict()) == set(SCORE_NAMES)
    assert {f.name for f in dataclasses.fields(Scores)} == set(SCORE_NAMES)
    assert {score_unit(n) for n in SCORE_NAMES} == {
        "rad",
        "dB",
        "dBm",
        "W",
        "W/rad",
        "1/rad",
        "1",
    }
    assert all(np.isfinite(v) for v in scores.as_dict().values())
