"""Laws of single fixes: exact readings give the exact place, errors the least squares of them."""

import numpy as np
import pytest

from octant.navigation.estimators.place_fix import place_by_bearings, place_by_distances

TAGS_M = np.array([[2.0, 0.5], [3.5, 2.0], [2.0, 3.5], [4.0, 3.5]])
PLACE_M = np.array([1.2, -0.4])


def test_exact_readings_give_the_place():
    away = TAGS_M - PLACE_M
    reach, seen = np.hypot(*away.T), np.arctan2(away[:, 1], away[:, 0])
    np.testing.assert_allclose(place_by_distances(reach, TAGS_M), PLACE_M, atol=1e-8)
    np.testing.assert_allclose(place_by_bearings(seen, TAGS_M), PLACE_M, atol=1e-12)
    reach[1] = seen[0] = np.nan
    np.testing.assert_allclose(place_by_distances(reach, TAGS_M), PLACE_M, atol=1e-8)
    np.testing.assert_allclose(place_by_bearings(seen, TAGS_M), PLACE_M, atol=1e-12)


@pytest.mark.parametrize(
    ("fix", "tags", "known"), [(place_by_distances, 4, 2), (place_by_bearings, 4, 1)]
)
def test_too_few_readings_give_no_place(fix, tags, known):
    readings = np.full(tags, np.nan)
    readings[:known] = 1.0
    assert np.isnan(fix(readings, TAGS_M)).all()


def test_distances_with_errors_give_a_stationary_place_of_their_squares():
    reach = np.hypot(*(TAGS_M - PLACE_M).T) + np.array([0.2, -0.1, 0.15, -0.05])
    found = place_by_distances(reach, TAGS_M)
    away = found - TAGS_M
    length = np.hypot(*away.T)
    slope = ((length - reach) / length) @ away
    np.testing.assert_allclose(slope, 0.0, atol=1e-5)
    assert ((length - reach) ** 2).sum() < ((np.hypot(*(PLACE_M - TAGS_M).T) - reach) ** 2).sum()
