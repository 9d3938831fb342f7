import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.rss_detector import RssQuantiser, log_normal_rss
from octant.navigation.sensing import FieldSensor

POSE = np.array([1.0, 0.5, 0.3])


@pytest.fixture
def sensor(free_space_link):
    def make(**options):
        link = free_space_link((0.0, 0.0))
        azimuths = np.array(link.azimuths_rad)
        return FieldSensor(links={"0xFFF9": link}, azimuths_rad=azimuths, **options), link

    return make


def test_without_errors_the_reading_is_the_field(sensor):
    clean, link = sensor()
    reading = clean.read(POSE, "0xFFF9", np.random.default_rng(0))
    assert (reading == link.rss_w(POSE[None])[0]).all()
    assert reading.max() > 1e-8


def test_log_normal_noise_has_the_stated_spread_and_no_median_bias():
    rng = np.random.default_rng(1)
    db = 10 * np.log10(log_normal_rss(np.full(40_000, 3e-7), 1.5, rng) / 3e-7)
    assert db.std() == pytest.approx(1.5, rel=0.02)
    assert np.median(db) == pytest.approx(0.0, abs=0.03)


def test_each_antenna_has_its_own_error(sensor):
    noisy, link = sensor(noise_db=1.0)
    ratio = noisy.read(POSE, "0xFFF9", np.random.default_rng(2)) / link.rss_w(POSE[None])[0]
    assert np.unique(ratio).size == 8


def test_equal_seeds_give_equal_readings(sensor):
    noisy, _ = sensor(noise_db=1.0)
    readings = [noisy.read(POSE, "0xFFF9", np.random.default_rng(s)) for s in (5, 5, 6)]
    assert (readings[0] == readings[1]).all()
    assert (readings[0] != readings[2]).all()


def test_what_is_below_the_sensitivity_is_not_received(sensor):
    clean, _ = sensor()
    full = clean.read(POSE, "0xFFF9", np.random.default_rng(0))
    limit = float(np.median(full))
    deaf, _ = sensor(sensitivity_w=limit)
    reading = deaf.read(POSE, "0xFFF9", np.random.default_rng(0))
    assert (reading == np.where(full < limit, 0.0, full)).all()
    assert 0 < np.count_nonzero(reading) < 8


def test_quantiser_is_within_half_a_step_and_has_256_codes():
    quantiser = RssQuantiser(bits=8, floor_dbm=-100.0, full_scale_dbm=0.0)
    assert quantiser.step_db == pytest.approx(100 / 255)
    dbm = np.linspace(-100, 0, 5001)
    back = 10 * np.log10(quantiser.quantise(10 ** (dbm / 10) / 1e3) * 1e3)
    assert np.abs(back - dbm).max() <= quantiser.step_db / 2 + 1e-9
    assert np.unique(back.round(6)).size == 256


def test_quantiser_clips_at_the_top_and_is_silent_below_the_floor():
    quantiser = RssQuantiser()
    assert quantiser.quantise([10.0, 0.0, 1e-14]) == pytest.approx([1e-3, 0.0, 0.0])
    once = quantiser.quantise(np.geomspace(1e-12, 1e-3, 99))
    assert quantiser.quantise(once) == pytest.approx(once, rel=1e-12)


def test_sensor_applies_its_quantiser(sensor):
    coarse, _ = sensor(quantiser=RssQuantiser(bits=4))
    reading = coarse.read(POSE, "0xFFF9", np.random.default_rng(0))
    code = (10 * np.log10(reading[reading > 0]) + 30 + 100) / (100 / 15)
    assert code == pytest.approx(np.rint(code), abs=1e-9)


def test_unknown_tags_are_refused_with_the_nearest_name(sensor):
    with pytest.raises(NavigationError, match=r"'0xFFF8'.*did you mean '0xFFF9'"):
        sensor()[0].read(POSE, "0xFFF8", np.random.default_rng(0))


def test_sensors_that_cannot_be_are_refused(free_space_link):
    link = free_space_link()
    azimuths = np.array(link.azimuths_rad)
    with pytest.raises(NavigationError, match="no link"):
        FieldSensor(links={}, azimuths_rad=azimuths)
    with pytest.raises(NavigationError, match="noise_db is -1"):
        FieldSensor(links={"a": link}, azimuths_rad=azimuths, noise_db=-1.0)
    with pytest.raises(NavigationError, match="8 RSS values, but the reader has 4"):
        FieldSensor(links={"a": link}, azimuths_rad=azimuths[::2]).read(
            POSE, "a", np.random.default_rng(0)
        )
    with pytest.raises(NavigationError, match="bits is 0"):
        RssQuantiser(bits=0)
    with pytest.raises(NavigationError, match="must rise"):
        RssQuantiser(floor_dbm=0.0, full_scale_dbm=-10.0)
