import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.estimators.tag_place import TagPlaceFilter

TAG = np.array([2.3, -1.1])


def bearing(pose):
    return np.arctan2(TAG[1] - pose[1], TAG[0] - pose[0]) - pose[2]


def drive(filter_, rng, *, outliers, steps=25):
    belief = filter_.start()
    for k in range(steps):
        pose = [0.12 * k, 0.05 * k, 0.1 * k]
        seen = rng.uniform(-np.pi, np.pi) if rng.random() < outliers else bearing(pose)
        belief = filter_.observe(belief, pose, bearing_rad=seen + rng.normal(0.0, 0.1))
    return belief


def test_one_bearing_gives_the_posterior_of_bayes():
    filter_ = TagPlaceFilter(trust=1.0)
    belief = filter_.observe(filter_.start(), [0.5, -0.5, 0.4], bearing_rad=0.7)
    weight = belief.weight
    i, j = 50, 20
    densities = []
    for row, column in ((i, j), (j, i)):
        dx, dy = belief.axis_m[column] - 0.5, belief.axis_m[row] + 0.5
        off = np.angle(np.exp(1j * (np.arctan2(dy, dx) - 1.1)))
        variance = min(0.35**2 + 0.3**2 / (dx**2 + dy**2), np.pi**2 / 3)
        gauss = np.exp(-(off**2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)
        densities.append(0.7 * gauss + 0.3 / (2 * np.pi))
    assert weight[i, j] / weight[j, i] == pytest.approx(densities[0] / densities[1], rel=1e-12)


def test_bearings_from_several_places_meet_at_the_tag():
    place, spread = drive(TagPlaceFilter(), np.random.default_rng(1), outliers=0.0).place()
    assert np.linalg.norm(place - TAG) < 0.4
    assert spread < 3.0


def test_a_third_of_wild_bearings_does_no_harm():
    errors = []
    for seed in range(20):
        belief = drive(TagPlaceFilter(), np.random.default_rng(seed), outliers=0.33)
        errors.append(np.linalg.norm(belief.place()[0] - TAG))
    assert np.median(errors) < 0.6
    assert np.quantile(errors, 0.9) < 1.0


def test_the_spread_falls_with_the_evidence_and_silence_changes_nothing():
    filter_, rng = TagPlaceFilter(), np.random.default_rng(2)
    spreads = [drive(filter_, rng, outliers=0.0, steps=n).place()[1] for n in (1, 8, 25)]
    assert spreads[0] > spreads[1] > spreads[2]
    start = filter_.start()
    assert filter_.observe(start, [0, 0, 0], bearing_rad=np.nan) is start


def test_values_out_of_range_are_refused():
    with pytest.raises(NavigationError, match="outlier_share"):
        TagPlaceFilter(outlier_share=1.0)
    with pytest.raises(NavigationError, match="spacing_m"):
        TagPlaceFilter(spacing_m=0.0)
