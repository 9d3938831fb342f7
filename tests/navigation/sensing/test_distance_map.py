"""Laws of the distance-RSS map and of the orientation error that it propagates back."""

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.sensing.distance_map import (
    DistanceMap,
    distance_map,
    propagated_error_rad,
)

HEIGHT_M = 2.7


class TwoDipoles:
    """Short vertical dipoles: RSS goes with ρ⁴ / (ρ² + h²)³, greatest at ρ = √2 h."""

    def rss_w(self, poses):
        floor2 = (poses[:, :2] ** 2).sum(axis=1)
        lobes = 1.0 + 0.3 * np.cos(8.0 * poses[:, 2])  # headings differ, their mean does not
        power = floor2**2 / (floor2 + HEIGHT_M**2) ** 3
        return (power * lobes)[:, None] * np.array([0.5, 0.3, 0.2])


def test_the_map_ends_at_the_maximum_and_inverts_the_law_up_to_it():
    found = distance_map(TwoDipoles(), reach_m=9.0)
    assert found.distances_m[-1] == pytest.approx(np.sqrt(2.0) * HEIGHT_M, abs=0.02)
    away = np.linspace(0.1, 3.5, 30)
    rss = TwoDipoles().rss_w(np.column_stack([away, 0.0 * away, 0.0 * away + np.pi / 16.0]))
    np.testing.assert_allclose(found.distance_m(rss), away, atol=2e-3)
    assert np.isnan(found.distance_m([1.0, 1.0, 1.0]))
    assert np.isnan(found.distance_m([0.0, 0.0, 0.0]))


class Downwards:
    """A tag that sends most straight down."""

    def rss_w(self, poses):
        return 1.0 / (1.0 + (poses[:, :2] ** 2).sum(axis=1))[:, None]


def test_a_tag_that_is_strongest_right_under_it_has_no_map():
    with pytest.raises(NavigationError, match="such as dipoles"):
        distance_map(Downwards(), reach_m=5.0)


@pytest.mark.parametrize("rss_w", [[1.0, 1.0, 2.0], [1.0, 0.5, 2.0]])
def test_a_map_that_does_not_grow_is_refused(rss_w):
    with pytest.raises(NavigationError, match="must grow"):
        DistanceMap(distances_m=[0.0, 1.0, 2.0], rss_w=rss_w)


def test_the_error_propagated_back_is_that_of_the_move():
    rng = np.random.default_rng(5)
    old = rng.uniform(-3.0, 3.0, (500, 2))
    error = rng.uniform(-1.4, 1.4, 500)
    way = np.arctan2(-old[:, 1], -old[:, 0]) - error
    new = old + rng.uniform(0.0, 2.0, 500)[:, None] * np.column_stack([np.cos(way), np.sin(way)])
    seen = wrap_angle(np.arctan2(-new[:, 1], -new[:, 0]) - way)
    found = propagated_error_rad(*(np.hypot(*p.T) for p in (old, new)), seen)
    np.testing.assert_allclose(found, error, atol=1e-7)


def test_where_there_is_no_triangle_there_is_no_error():
    assert np.isnan(propagated_error_rad(1.0, 2.0, 1.5)).all()
    assert np.isnan(propagated_error_rad(np.nan, 2.0, 0.1)).all()
    assert propagated_error_rad(2.0, 1.0, np.pi / 2) == pytest.approx(np.pi / 6)
