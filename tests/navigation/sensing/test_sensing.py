import numpy as np
import pytest
from scipy import stats

from octant.geometries.errors import NavigationError
from octant.navigation.robot.motion import AT_REST, Motion
from octant.navigation.sensing.inventory import ReadRates
from octant.navigation.sensing.rss_detector import RssQuantiser, ThermalNoise, log_normal_rss
from octant.navigation.sensing.sensor import FieldSensor

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


def test_antennas_read_one_after_another_at_standstill_are_read_at_once(sensor):
    thermal = ThermalNoise(bandwidth_hz=1e9)
    together, _ = sensor(noise_db=1.0, thermal=thermal)
    in_turn, _ = sensor(noise_db=1.0, thermal=thermal, dwell_s=0.05)
    driving = Motion(speed_m_per_s=0.5, turn_rate_rad_per_s=0.3)
    for one, other in ((in_turn, AT_REST), (together, driving)):
        reading = one.read(POSE, "0xFFF9", np.random.default_rng(3), motion=other)
        assert (reading == together.read(POSE, "0xFFF9", np.random.default_rng(3))).all()


def test_antennas_read_one_after_another_see_the_field_where_the_robot_was(sensor):
    """The last antenna at the pose itself, each one before it a dwell time further back."""
    in_turn, link = sensor(dwell_s=0.05)
    rng = np.random.default_rng(0)
    ahead = in_turn.read(POSE, "0xFFF9", rng, motion=Motion(speed_m_per_s=0.6))
    turning = in_turn.read(POSE, "0xFFF9", rng, motion=Motion(turn_rate_rad_per_s=-0.8))
    for i in range(8):
        late_s = (7 - i) * 0.05
        behind = POSE - 0.6 * late_s * np.array([np.cos(POSE[2]), np.sin(POSE[2]), 0.0])
        turned = POSE + np.array([0.0, 0.0, 0.8 * late_s])
        assert ahead[i] == pytest.approx(link.rss_w(behind[None])[0, i], rel=1e-12)
        assert turning[i] == pytest.approx(link.rss_w(turned[None])[0, i], rel=1e-12)


def test_what_a_slow_robot_reads_in_turn_differs_as_the_field_changes(sensor):
    """To first order by minus speed times delay times the slope along the way."""
    clean, link = sensor()
    step = 1e-6 * np.array([np.cos(POSE[2]), np.sin(POSE[2]), 0.0])
    slope = (link.rss_w((POSE + step)[None]) - link.rss_w((POSE - step)[None]))[0] / 2e-6
    still = clean.read(POSE, "0xFFF9", np.random.default_rng(0))
    rest = []
    for speed in (0.02, 0.01):
        in_turn, _ = sensor(dwell_s=0.05)
        motion = Motion(speed_m_per_s=speed)
        moved = in_turn.read(POSE, "0xFFF9", np.random.default_rng(0), motion=motion)
        first_order = -slope * speed * 0.05 * np.arange(7, -1, -1)
        rest.append(np.abs(moved - still - first_order).max())
        assert np.abs(moved - still).max() > 20.0 * rest[-1]
    assert rest[0] / rest[1] == pytest.approx(4.0, rel=0.05)


def wilson(hits, trials, z=3.3):
    rate, extra = hits / trials, z * z / trials
    middle = (rate + extra / 2.0) / (1.0 + extra)
    half = z / (1.0 + extra) * np.sqrt(rate * (1.0 - rate) / trials + extra / (4.0 * trials))
    return middle - half, middle + half


def lost(device, reads=1500):
    rng = np.random.default_rng(8)
    return np.array([device.read(POSE, "0xFFF9", rng) == 0.0 for _ in range(reads)])


def test_antennas_drop_out_each_by_itself_at_the_stated_rate(sensor):
    gone = lost(sensor(drop_out_probability=0.2)[0])
    low, high = wilson(gone.sum(), gone.size)
    assert low < 0.2 < high
    both = gone[:, 0] & gone[:, 1]
    low, high = wilson(both.sum(), both.size)
    assert low < 0.2**2 < high
    assert not lost(sensor()[0], 50).any()
    assert lost(sensor(drop_out_probability=1.0)[0], 5).all()


def test_a_tag_that_does_not_answer_is_heard_by_no_antenna(sensor):
    gone = lost(sensor(read_probability=0.7)[0])
    assert (gone.all(axis=1) == gone.any(axis=1)).all()
    low, high = wilson(gone.all(axis=1).sum(), len(gone))
    assert low < 0.3 < high


def test_weak_signals_are_decoded_as_often_as_their_noisy_power_passes_the_threshold(sensor):
    """One sample: exceeding the threshold has the probability of Marcum's Q."""
    clean, link = sensor()
    power = link.rss_w(POSE[None])[0]
    thermal = ThermalNoise(bandwidth_hz=float(np.median(power)) / 4.0035e-21)
    limit = 2.0 * thermal.power_w
    heard = ~lost(sensor(thermal=thermal, sensitivity_w=limit)[0], 3000)
    noise = 0.5 * thermal.power_w
    for i in range(8):
        low, high = wilson(heard[:, i].sum(), len(heard))
        assert low < stats.ncx2.sf(limit / noise, df=2, nc=power[i] / noise) < high
    assert clean.antennas == 8


def test_sensors_with_equal_generators_err_alike_in_all_that_they_share(sensor):
    thermal = ThermalNoise(bandwidth_hz=1e12)
    options = {"thermal": thermal, "noise_db": 2.0}
    generators = [np.random.default_rng(9) for _ in range(4)]
    devices = [
        sensor(**options)[0],
        sensor(**options, drop_out_probability=0.5)[0],
        sensor(noise_db=2.0)[0],
        sensor(noise_db=0.0, drop_out_probability=0.5, read_probability=0.9)[0],
    ]
    for _ in range(20):
        full, thinned, log_normal, bare = (
            device.read(POSE, "0xFFF9", rng)
            for device, rng in zip(devices, generators, strict=True)
        )
        kept = thinned > 0.0
        assert (thinned[kept] == full[kept]).all()
        assert (bare[~kept] == 0.0).all()
        assert (bare[kept] > 0.0).all() or (bare == 0.0).all()
        assert (full != log_normal).all()
    assert len({rng.random() for rng in generators}) == 1


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
    for name, value in (("dwell_s", -0.1), ("dwell_s", np.nan), ("sensitivity_w", np.inf)):
        with pytest.raises(NavigationError, match=f"{name} is"):
            FieldSensor(links={"a": link}, azimuths_rad=azimuths, **{name: value})
    for name, value in (("drop_out_probability", 1.1), ("read_probability", -0.1)):
        with pytest.raises(NavigationError, match=f"{name} is .* between 0 and 1"):
            FieldSensor(links={"a": link}, azimuths_rad=azimuths, **{name: value})
    with pytest.raises(NavigationError, match="nan m/s"):
        Motion(speed_m_per_s=np.nan)
    with pytest.raises(NavigationError, match="bits is 0"):
        RssQuantiser(bits=0)
    with pytest.raises(NavigationError, match="must rise"):
        RssQuantiser(floor_dbm=0.0, full_scale_dbm=-10.0)


class Answering:
    """A tag that answers the first antennas, as many as the whole part of the robot's x."""

    def __init__(self, rss_w):
        self.rss = np.array(rss_w)

    def reads(self, poses):
        return np.arange(self.rss.size) < np.floor(poses[:, :1])

    def rss_w(self, poses):
        return np.where(self.reads(poses), self.rss, 0.0)


def crowded(**options):
    links = {name: Answering(np.arange(1.0, 9.0)) for name in ("a", "b")}
    return FieldSensor(links=links, azimuths_rad=np.arange(8) * np.pi / 4, crowd=links, **options)


def test_tags_that_wake_together_are_read_as_rarely_as_their_number_says():
    rates = ReadRates(probability=np.array([0.8, 0.3]))
    links = {"a": Answering(np.arange(1.0, 9.0)), "b": Answering(np.ones(8))}
    links["b"].reads = lambda poses: np.ones((len(poses), 8), bool) & (np.arange(8) >= 2)
    sensor = FieldSensor(
        links=links, azimuths_rad=np.arange(8) * np.pi / 4, crowd=links, rates=rates
    )
    rng = np.random.default_rng(3)
    pose = np.array([4.5, 0.0, 0.0])  # tag a wakes at antennas 1 to 4, tag b at 3 to 8
    heard = np.mean([sensor.read(pose, "a", rng) > 0.0 for _ in range(4000)], axis=0)
    np.testing.assert_allclose(heard, [0.8, 0.8, 0.3, 0.3, 0, 0, 0, 0], atol=0.03)


def test_a_tag_that_does_not_wake_gives_no_reading():
    sure = crowded(rates=ReadRates(probability=np.ones(2)))
    reading = sure.read(np.array([3.2, 0.0, 0.0]), "a", np.random.default_rng(0))
    assert reading.tolist() == [1, 2, 3, 0, 0, 0, 0, 0]
    # the robot drives on between the antennas: the later ones see the tag wake
    motion = Motion(speed_m_per_s=1.0, turn_rate_rad_per_s=0.0)
    slow = crowded(rates=ReadRates(probability=np.ones(2)), dwell_s=0.5)
    reading = slow.read(np.array([8.0, 0.0, 0.0]), "a", np.random.default_rng(0), motion=motion)
    assert reading.tolist() == [1, 2, 3, 4, 5, 6, 7, 8]
    reading = slow.read(np.array([6.4, 0.0, 0.0]), "a", np.random.default_rng(0), motion=motion)
    assert reading.tolist() == [1, 2, 3, 4, 0, 0, 0, 0]
