"""Laws of the error distribution and of a receiver's errors, against closed forms."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

from octant.geometries.errors import AntennaError, ConfigError
from octant.navigation.angles import wrap_angle
from octant.navigation.sensing.rss_detector import RssQuantiser
from octant.reader_design.setting.bearing_errors import summarise_errors, vector_errors_rad
from octant.reader_design.setting.measures import right_share
from octant.reader_design.setting.receiver import RssReceiver, receiver_of
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.study_file.choice import Scoring

N = 8
ELEMENTS = np.arange(N) * 2 * np.pi / N
AZIMUTHS = np.arange(N * 18) * 2 * np.pi / (N * 18)
NODES = np.polynomial.hermite_e.hermegauss(101)


def cosine_rss(direction, depth=0.8):
    """Power 1 + depth cos of every antenna towards a direction."""
    return 1.0 + depth * np.cos(direction[..., None] - ELEMENTS)


def one_reflection(share, offset_rad):
    """RSS of a cosine reader that hears the tag and, incoherently, its image at an offset."""
    return 1e-6 * (cosine_rss(AZIMUTHS) + share * cosine_rss(AZIMUTHS + offset_rad))[None]


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 1.5])
@pytest.mark.parametrize("offset_deg", [30.0, 90.0, 150.0, 179.0])
def test_one_known_reflection_turns_the_vector_sum_by_the_angle_of_the_phasor_sum(
    share, offset_deg
):
    # sum_i (1 + a cos(x - d_i)) e^{j d_i} = (n a / 2) e^{j x}, so both waves add up as phasors
    offset = math.radians(offset_deg)
    turned = abs(np.angle(1.0 + share * np.exp(1j * offset)))
    scores = score_rss(one_reflection(share, offset), AZIMUTHS, ELEMENTS)
    for value in (scores.vector_median_rad, scores.vector_rms_rad, scores.vector_p90_rad):
        assert value == pytest.approx(turned, abs=1e-9)
    assert scores.vector_beyond_45_share == float(turned > math.pi / 4)
    assert scores.vector_beyond_90_share == float(turned > math.pi / 2)


def test_scores_of_a_turned_reader_are_the_same():
    rng = np.random.default_rng(1)
    rss = rng.uniform(size=(3, N * 6, N))
    azimuths = np.arange(N * 6) * 2 * np.pi / (N * 6)
    # antenna i takes the place of antenna i + 1: the tag's azimuth moves by six steps of the grid
    turned = np.roll(np.roll(rss, 1, axis=2), 6, axis=1)
    one = score_rss(rss, azimuths, ELEMENTS).as_dict()
    other = score_rss(turned, azimuths, ELEMENTS).as_dict()
    steering = {"monotonic", "slope", "full"}  # speaks of antennas 2 and 4 only
    for name in one:
        if name.split("_")[0] not in steering:
            assert other[name] == pytest.approx(one[name], rel=1e-12), name


def test_percentiles_and_shares_are_those_of_the_sorted_errors():
    errors = np.radians([10.0, -20.0, 30.0, 40.0, 50.0, -60.0, 70.0, 80.0, 90.0, 100.0])
    found = summarise_errors(errors)
    assert math.degrees(found.median_rad) == pytest.approx(50.0)
    assert math.degrees(found.p90_rad) == pytest.approx(90.0)
    assert math.degrees(found.max_rad) == pytest.approx(100.0)
    assert found.mean_rad == pytest.approx(np.abs(errors).mean())
    assert found.rms_rad == pytest.approx(np.sqrt((errors**2).mean()))
    assert found.beyond_45_share == pytest.approx(0.6)
    assert found.beyond_90_share == pytest.approx(0.1)  # 90 degrees is not beyond 90


def test_a_weight_counts_as_repetition():
    rng = np.random.default_rng(2)
    errors, weight = rng.uniform(-3, 3, 40), rng.integers(0, 4, 40)
    weighted = summarise_errors(errors, weight.astype(float))
    repeated = summarise_errors(np.repeat(errors, weight))
    for name in ("mean_rad", "rms_rad", "median_rad", "p90_rad", "max_rad", "beyond_90_share"):
        assert getattr(weighted, name) == pytest.approx(getattr(repeated, name), rel=1e-12), name


def test_no_bearing_counts_as_half_a_turn():
    rss = np.zeros((1, AZIMUTHS.size, N))
    rss[0, : AZIMUTHS.size // 2] = 1.0
    assert (vector_errors_rad(rss, AZIMUTHS, ELEMENTS) == np.pi).all()
    scores = score_rss(rss, AZIMUTHS, ELEMENTS)
    assert scores.vector_beyond_90_share == scores.read_vector_beyond_90_share == 1.0


def probability_of_the_strongest(level_db, noise_db):
    """P(antenna i reads strongest) under independent normal errors in dB, by quadrature."""
    t, weight = NODES
    out = np.empty_like(level_db)
    for i, own in enumerate(level_db):
        z = (own + noise_db * t[:, None] - np.delete(level_db, i)) / noise_db
        out[i] = (weight * ndtr(z).prod(axis=1)).sum() / math.sqrt(2 * math.pi)
    return out


def test_noisy_share_of_right_antennas_is_the_exact_expectation():
    rss = 1e-6 * cosine_rss(AZIMUTHS)
    exact = []
    for azimuth, row in zip(AZIMUTHS, rss, strict=True):
        away = np.abs(wrap_angle(azimuth - ELEMENTS))
        p = probability_of_the_strongest(10 * np.log10(row), 2.0)
        assert p.sum() == pytest.approx(1.0, abs=1e-6)
        exact.append(p[away <= away.min() + 1e-9].sum())
    readings = RssReceiver(noise_db=2.0).readings(rss[None], np.random.default_rng(3), draws=400)
    found = right_share(readings, AZIMUTHS, ELEMENTS)
    spread = 0.5 / math.sqrt(readings.shape[0] * AZIMUTHS.size)
    assert found == pytest.approx(np.mean(exact), abs=4 * spread)
    assert right_share(rss[None], AZIMUTHS, ELEMENTS) == 1.0


def test_small_noise_turns_the_vector_sum_by_the_linearised_angle():
    # d bearing = (2 / n a) sum_i e_i (1 + a cos(d_i - x)) sin(d_i - x), e_i = s N(0, 1):
    # variance (2 s / n a)^2 sum_i (1 + a cos)^2 sin^2 = (2 s / n a)^2 n (1/2 + a^2 / 8)
    noise_db, a = 0.1, 0.8
    s = noise_db * math.log(10.0) / 10.0
    sigma = 2.0 * s / (N * a) * math.sqrt(N * (0.5 + a * a / 8.0))
    rss = 1e-6 * cosine_rss(AZIMUTHS, a)[None]
    readings = RssReceiver(noise_db=noise_db).readings(rss, np.random.default_rng(4), draws=200)
    scores = score_rss(rss, AZIMUTHS, ELEMENTS, readings_w=readings)
    assert scores.read_vector_rms_rad == pytest.approx(sigma, rel=0.02)
    assert scores.read_vector_median_rad == pytest.approx(0.6745 * sigma, rel=0.03)
    assert scores.vector_rms_rad < 1e-12


def test_thermal_noise_far_above_the_signal_leaves_the_bearing_and_takes_the_margin():
    rss = 1e-12 * cosine_rss(AZIMUTHS)[None]
    quiet = RssReceiver(thermal_noise_w=1e-9).read(rss, np.random.default_rng(0))
    scores = score_rss(quiet, AZIMUTHS, ELEMENTS)
    assert scores.vector_max_rad < 1e-9
    assert 0.0 < scores.margin_worst_db < 0.01
    drowned = RssReceiver(thermal_noise_w=1e-9, noise_db=1.0)
    share = right_share(
        drowned.readings(rss, np.random.default_rng(0), draws=50), AZIMUTHS, ELEMENTS
    )
    assert share == pytest.approx((1.0 + 1.0 / 18.0) / N, abs=0.02)  # half-way, two are right


def test_fine_codes_change_nothing_and_one_code_for_all_antennas_takes_the_bearing():
    rss = 1e-6 * cosine_rss(AZIMUTHS)[None]
    rng = np.random.default_rng(0)
    fine = RssReceiver(quantiser=RssQuantiser(bits=16)).read(rss, rng)
    np.testing.assert_allclose(fine, rss, rtol=2e-4)  # half a step of 100 dB / 65535
    coarse = RssReceiver(quantiser=RssQuantiser(bits=1)).read(rss, rng)
    scores = score_rss(coarse, AZIMUTHS, ELEMENTS)
    assert scores.right_share == pytest.approx((1.0 + 1.0 / 18.0) / N)
    assert scores.vector_beyond_90_share == 1.0


def test_eight_bits_err_by_no_more_than_half_a_step_of_the_ratio():
    rss = 1e-6 * cosine_rss(AZIMUTHS)[None]
    step_db = RssQuantiser().step_db
    read = RssReceiver(quantiser=RssQuantiser()).read(rss, np.random.default_rng(0))
    assert np.abs(10 * np.log10(read / rss)).max() <= 0.5 * step_db + 1e-9
    assert step_db == pytest.approx(100.0 / 255.0)


def test_same_generator_same_readings_and_another_seed_others():
    rss = 1e-6 * cosine_rss(AZIMUTHS)[None]
    receiver = receiver_of(Scoring())
    one, same, other = (
        receiver.readings(rss, np.random.default_rng(seed), draws=2) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()
    assert one.shape == (2, AZIMUTHS.size, N)


def test_a_receiver_without_noise_reads_once():
    rss = 1e-6 * cosine_rss(AZIMUTHS)[None]
    exact = receiver_of(Scoring(noise_db=0.0, thermal_noise_dbm=-300.0, bits=0))
    read = exact.readings(rss, np.random.default_rng(0), draws=7)
    np.testing.assert_allclose(read, rss, rtol=1e-12)
    scores = score_rss(rss, AZIMUTHS, ELEMENTS, readings_w=read)
    assert scores.read_vector_rms_rad == pytest.approx(scores.vector_rms_rad, abs=1e-12)
    assert scores.read_right_share == scores.right_share


def test_levels_of_the_study_are_in_dbm():
    receiver = receiver_of(Scoring(thermal_noise_dbm=-90.0))
    assert receiver.thermal_noise_w == pytest.approx(1e-12)
    assert receiver.quantiser == RssQuantiser(bits=8, floor_dbm=-100.0, full_scale_dbm=0.0)


def test_negative_errors_and_readings_are_refused():
    with pytest.raises(ConfigError, match=r"noise_db is -1\.0 dB"):
        RssReceiver(noise_db=-1.0)
    rss = 1e-6 * cosine_rss(AZIMUTHS)[None]
    with pytest.raises(AntennaError, match="readings_w holds -1e-06 W"):
        score_rss(rss, AZIMUTHS, ELEMENTS, readings_w=0 * rss - 1e-6)
