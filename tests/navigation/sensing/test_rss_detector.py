import numpy as np
import pytest
from scipy import stats

from octant.geometries.errors import NavigationError
from octant.navigation.sensing.rss_detector import RssQuantiser, ThermalNoise, log_normal_rss

DRAWS = 100_000


@pytest.mark.parametrize("samples", [1, 7])
@pytest.mark.parametrize("snr", [0.0, 0.5, 40.0])
def test_readings_of_signal_and_thermal_noise_are_noncentral_chi_square(snr, samples):
    thermal = ThermalNoise(bandwidth_hz=1e6, noise_figure_db=6.0, samples=samples)
    noise_w = thermal.power_w
    signal_w = snr * noise_w
    readings = thermal.reading_w(np.full(DRAWS, signal_w), np.random.default_rng(3)) / noise_w
    law = stats.ncx2(df=2 * samples, nc=2 * samples * snr, scale=0.5 / samples)
    variance = (2.0 * snr + 1.0) / samples
    assert law.stats("mv") == pytest.approx((snr + 1.0, variance), rel=1e-12)
    assert abs(readings.mean() - snr - 1.0) < 4.0 * np.sqrt(variance / DRAWS)
    spread = (np.var((readings - readings.mean()) ** 2) / DRAWS) ** 0.5
    assert abs(readings.var() - variance) < 4.0 * spread
    assert stats.kstest(readings, law.cdf).pvalue > 0.01


def test_noise_power_is_minus_174_dbm_per_hertz_plus_bandwidth_and_figure():
    thermal = ThermalNoise(bandwidth_hz=1.0)
    assert 10.0 * np.log10(thermal.power_w) + 30.0 == pytest.approx(-173.9752, abs=1e-4)
    wide = ThermalNoise(bandwidth_hz=2e6, noise_figure_db=7.0)
    assert wide.power_w == pytest.approx(thermal.power_w * 2e6 * 10.0**0.7, rel=1e-12)


def test_each_reading_has_its_own_thermal_noise():
    thermal = ThermalNoise(bandwidth_hz=1e6)
    readings = thermal.reading_w(np.full((DRAWS, 2), thermal.power_w), np.random.default_rng(4))
    assert abs(np.corrcoef(readings.T)[0, 1]) < 4.0 / np.sqrt(DRAWS)


def test_log_normal_errors_are_common_to_all_sizes():
    rngs = [np.random.default_rng(5) for _ in range(3)]
    exact, one, two = (
        log_normal_rss(np.full(8, 2e-9), s, rng) for s, rng in zip((0, 1, 2), rngs, strict=True)
    )
    assert (exact == 2e-9).all()
    assert np.log(two / 2e-9) == pytest.approx(2.0 * np.log(one / 2e-9), rel=1e-12)
    assert len({rng.random() for rng in rngs}) == 1


def test_quantisation_errors_are_uniform_within_half_a_step():
    quantiser = RssQuantiser(bits=8, floor_dbm=-90.0, full_scale_dbm=-20.0)
    dbm = np.random.default_rng(6).uniform(-89.0, -21.0, DRAWS)
    back = 10.0 * np.log10(quantiser.quantise(1e-3 * 10.0 ** (dbm / 10.0))) + 30.0
    error = (back - dbm) / quantiser.step_db
    assert quantiser.step_db == pytest.approx(70.0 / 255.0)
    assert stats.kstest(error, stats.uniform(-0.5, 1.0).cdf).pvalue > 0.01
    assert error.std() == pytest.approx(1.0 / np.sqrt(12.0), rel=0.01)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"bandwidth_hz": 0.0}, "bandwidth_hz is 0"),
        ({"bandwidth_hz": np.inf}, "bandwidth_hz is inf"),
        ({"bandwidth_hz": 1e6, "noise_figure_db": -1.0}, "better than 0 dB"),
        ({"bandwidth_hz": 1e6, "noise_figure_db": np.nan}, "noise_figure_db is nan"),
        ({"bandwidth_hz": 1e6, "samples": 0}, "samples is 0"),
    ],
)
def test_receivers_that_cannot_be_are_refused(options, said):
    with pytest.raises(NavigationError, match=said):
        ThermalNoise(**options)
