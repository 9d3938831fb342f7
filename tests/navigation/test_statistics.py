"""Confidence intervals against published values, closed forms and SciPy."""

import numpy as np
import pytest
from scipy.stats import binom, binomtest

from octant.geometries.errors import NavigationError
from octant.navigation.statistics import bootstrap, gaussianity, quantiles, wilson

# R. G. Newcombe, Stat. Med. 17 (1998), table I, method 3 (score, no continuity correction).
PUBLISHED = [
    (81, 263, 0.2553, 0.3662),
    (15, 148, 0.0624, 0.1605),
    (0, 20, 0.0000, 0.1611),
    (1, 29, 0.0061, 0.1718),
]


@pytest.mark.parametrize(("successes", "trials", "low", "high"), PUBLISHED)
def test_wilsons_interval_is_the_published_one(successes, trials, low, high):
    interval = wilson(successes, trials)
    assert interval.value == successes / trials
    assert interval.low == pytest.approx(low, abs=5.1e-5)
    assert interval.high == pytest.approx(high, abs=5.1e-5)
    theirs = binomtest(successes, trials).proportion_ci(0.95, method="wilson")
    assert (interval.low, interval.high) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


def test_wilsons_interval_is_symmetric_under_exchange_of_good_and_bad():
    good, bad = wilson(7, 31), wilson(24, 31)
    assert good.low == pytest.approx(1.0 - bad.high, abs=1e-15)
    assert wilson(31, 31).high == 1.0
    assert wilson(31, 31).low == pytest.approx(31 / (31 + 1.959963984540054**2), rel=1e-12)


@pytest.mark.parametrize(("successes", "trials"), [(0, 0), (3, 2), (-1, 5)])
def test_a_share_of_nothing_is_refused(successes, trials):
    with pytest.raises(NavigationError, match="is no share"):
        wilson(successes, trials)


def test_wilsons_interval_covers_the_truth_as_often_as_it_says():
    k = np.arange(41)
    low, high = np.array([(wilson(int(i), 40).low, wilson(int(i), 40).high) for i in k]).T
    truth = np.linspace(0.05, 0.95, 901)[:, None]
    inside = (binom.pmf(k, 40, truth) * ((low <= truth) & (truth <= high))).sum(axis=1)
    assert inside.mean() == pytest.approx(0.953, abs=0.002)  # Newcombe 1998, section 4


def test_quantiles_cover_the_truth_as_often_as_they_say():
    random = np.random.default_rng(4)
    inside = 0
    for _ in range(150):
        median, high = quantiles(random.standard_normal(60), (0.5, 0.8), random)
        inside += median.low <= 0.0 <= median.high
        inside += high.low <= 0.8416 <= high.high
    assert inside / 300 == pytest.approx(0.95, abs=0.03)


def test_without_values_there_is_no_interval():
    with pytest.raises(NavigationError, match="needs values"):
        bootstrap([], np.median, np.random.default_rng(0))


def test_quantiles_of_a_constant_are_the_constant():
    for one in quantiles([2.5] * 7, (0.05, 0.5, 0.95), np.random.default_rng(1)):
        assert (one.value, one.low, one.high) == (2.5, 2.5, 2.5)


def test_gaussian_samples_pass_at_the_tests_own_rate():
    rng = np.random.default_rng(1)
    p = [gaussianity(rng.normal(1.0, 2.0, 200)).p_value for _ in range(500)]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.03)


def test_moments_are_those_of_the_sample_and_other_shapes_fail():
    rng = np.random.default_rng(2)
    test = gaussianity(rng.exponential(1.0, 4000))
    assert test.mean == pytest.approx(1.0, abs=0.05)
    assert test.skewness == pytest.approx(2.0, abs=0.4)
    assert test.excess_kurtosis == pytest.approx(6.0, abs=2.5)
    assert test.p_value < 1e-6
    assert gaussianity(rng.uniform(-1.0, 1.0, 400)).p_value < 1e-6


@pytest.mark.parametrize("sample", [np.zeros(30), np.arange(5.0), [np.nan] * 30])
def test_samples_that_tell_nothing_are_refused(sample):
    with pytest.raises(NavigationError, match="at least 20"):
        gaussianity(sample)
