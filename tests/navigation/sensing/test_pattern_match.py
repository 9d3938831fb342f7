import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.sensing.bearing import (
    ANY_DIRECTION_RAD2,
    vector_sum_bearing,
    vector_sum_variance,
    wrap_angle,
)
from octant.navigation.sensing.pattern_match import PatternMatcher, PowerTable, power_table

EIGHT = np.radians(45.0 * np.arange(8))


@pytest.fixture
def table(free_space_link):
    return power_table(free_space_link(), (0.0, 0.0), sides=2)


def test_the_table_holds_the_link_at_every_distance_and_bearing(free_space_link, table):
    link = free_space_link()
    for row, column in ((10, 0), (30, 7), (60, 40)):
        rho = table.reach_m * (row / 60.0) ** 2
        # The robot stands at +x of the tag, side 0, and looks so that the tag has this bearing.
        heading = np.pi - table.bearings_rad[column]
        (rss,) = link.rss_w(np.array([[rho, 0.0, heading]]))
        assert table.power_w[row, column, 0] == pytest.approx(rss, rel=1e-9)


def test_under_the_tag_the_table_has_a_floor_in_place_of_zero(table):
    assert table.power_w[0].max() == pytest.approx(1e-15 * table.power_w.max())


@pytest.mark.parametrize("bearing_deg", [-170.0, -60.0, 0.0, 33.0, 120.0])
def test_the_matched_bearing_of_a_clean_reading_is_exact_to_the_grid(
    free_space_link, table, bearing_deg
):
    bearing = np.radians(bearing_deg)
    (rss,) = free_space_link().rss_w(np.array([[2.0, 0.0, np.pi - bearing]]))
    found, variance = PatternMatcher(table=table, error_db=1.0).bearing(rss)
    assert abs(wrap_angle(found - bearing)) < np.radians(2.5)  # a third of the grid
    assert variance < np.radians(8.0) ** 2


def test_the_matched_bearings_variance_is_that_of_noisy_readings(free_space_link, table):
    rng = np.random.default_rng(0)
    matcher = PatternMatcher(table=table, error_db=2.0)
    (clean,) = free_space_link().rss_w(np.array([[2.0, 0.0, np.pi - 0.4]]))
    noisy = clean * 10.0 ** (rng.normal(0.0, 2.0, (300, 8)) / 10.0)
    found, variance = np.array([matcher.bearing(rss) for rss in noisy]).T
    spread = np.mean(wrap_angle(found - 0.4) ** 2)
    assert 0.5 < spread / variance.mean() < 2.0


def test_silent_antennas_are_left_out_and_no_signal_is_no_bearing(free_space_link, table):
    matcher = PatternMatcher(table=table)
    (rss,) = free_space_link().rss_w(np.array([[2.0, 0.0, np.pi - 0.5]]))
    rss[[4, 5]] = 0.0
    assert matcher.bearing(rss)[0] == pytest.approx(0.5, abs=0.05)
    assert matcher.bearing(np.zeros(8)) == (0.0, ANY_DIRECTION_RAD2)


def test_tables_that_cannot_be_are_refused():
    with pytest.raises(NavigationError, match="reach_m is 0 m"):
        PowerTable(reach_m=0.0, power_w=np.ones((3, 8, 1, 8)))
    with pytest.raises(NavigationError, match="above 0 W"):
        PowerTable(reach_m=1.0, power_w=np.zeros((3, 8, 1, 8)))

    class Silent:
        def rss_w(self, poses):
            return np.zeros((len(poses), 8))

    with pytest.raises(NavigationError, match="receives nothing"):
        power_table(Silent(), (0.0, 0.0))


def test_the_vector_sums_variance_is_that_of_noisy_readings():
    rng = np.random.default_rng(1)
    clean = 1e-7 * np.cos((EIGHT - 2.0) / 2) ** 4
    noisy = clean * 10.0 ** (rng.normal(0.0, 0.5, (4000, 8)) / 10.0)
    errors = wrap_angle(vector_sum_bearing(noisy, EIGHT) - vector_sum_bearing(clean, EIGHT))
    assert vector_sum_variance(clean, EIGHT, noise_db=0.5) == pytest.approx(
        np.var(errors), rel=0.08
    )
    assert vector_sum_variance(clean, EIGHT, noise_db=0.0) == 0.0
    assert vector_sum_variance(np.zeros(8), EIGHT, noise_db=1.0) == ANY_DIRECTION_RAD2
    assert vector_sum_variance(np.ones(8), EIGHT, noise_db=1.0) == ANY_DIRECTION_RAD2
