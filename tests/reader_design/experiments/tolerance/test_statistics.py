"""Intervals and shares of variance against published values and closed forms."""

import numpy as np
import pytest
from scipy.stats import binom

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.tolerance.statistics import (
    explained_variance,
    quantiles,
    wilson,
)

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


def test_wilsons_interval_is_symmetric_under_exchange_of_good_and_bad():
    good, bad = wilson(7, 31), wilson(24, 31)
    assert good.low == pytest.approx(1.0 - bad.high, abs=1e-15)
    assert wilson(31, 31).high == 1.0
    assert wilson(31, 31).low == pytest.approx(31 / (31 + 1.959963984540054**2), rel=1e-12)


@pytest.mark.parametrize(("successes", "trials"), [(0, 0), (3, 2), (-1, 5)])
def test_a_share_of_nothing_is_refused(successes, trials):
    with pytest.raises(ConfigError, match="is no share"):
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
    for _ in range(300):
        median, high = quantiles(
            random.standard_normal(60), (0.5, 0.8), random=random, resamples=400
        )
        inside += median.low <= 0.0 <= median.high
        inside += high.low <= 0.8416 <= high.high
    assert inside / 600 == pytest.approx(0.95, abs=0.03)


def test_quantiles_of_a_constant_are_the_constant():
    for one in quantiles([2.5] * 7, (0.05, 0.5, 0.95), random=np.random.default_rng(1)):
        assert (one.value, one.low, one.high) == (2.5, 2.5, 2.5)


def test_a_linear_model_has_the_variance_shares_of_its_coefficients():
    random = np.random.default_rng(5)
    columns = random.uniform(-1.0, 1.0, (20000, 3)) * [1.0, 10.0, 0.1]
    values = 7.0 + columns @ [3.0, -0.2, 10.0] + random.normal(0.0, 1.0, 20000)
    found = explained_variance(("a: mean", "b: mean", "a: scatter"), columns, values)
    variance = np.array([9.0, 4.0, 1.0]) / 3.0
    total = variance.sum() + 1.0
    assert np.allclose(found.shares, variance / total, rtol=0.0, atol=0.01)
    assert np.allclose(
        found.coefficients, np.sqrt(variance / total) * [1, -1, 1], rtol=0.0, atol=0.01
    )
    assert found.r_squared == pytest.approx(variance.sum() / total, abs=0.01)
    assert found.shares.sum() == pytest.approx(found.r_squared, abs=1e-12)
    kinds = found.by_kind()
    assert kinds["a"] == pytest.approx(found.shares[0] + found.shares[2])


def test_the_r_squared_for_new_readers_is_that_of_fits_without_them():
    random = np.random.default_rng(6)
    x = random.standard_normal((15, 3))
    y = x @ [1.0, 0.5, 0.0] + random.standard_normal(15)
    lost = spread = 0.0
    for i in range(15):
        kept = np.arange(15) != i
        design = np.column_stack((np.ones(14), x[kept]))
        fit = np.linalg.lstsq(design, y[kept], rcond=None)[0]
        lost += (y[i] - fit[0] - x[i] @ fit[1:]) ** 2
        spread += (y[i] - y[kept].mean()) ** 2
    found = explained_variance(("a", "b", "c"), x, y)
    assert found.r_squared_new == pytest.approx(1.0 - lost / spread, rel=1e-10)


def test_noise_explains_nothing_for_new_readers():
    random = np.random.default_rng(7)
    found = explained_variance(
        tuple("abcdefgh"), random.standard_normal((24, 8)), random.standard_normal(24)
    )
    assert found.r_squared > 0.1
    assert found.r_squared_new < 0.0


def test_too_few_samples_or_no_variance_explain_nothing():
    x = np.random.default_rng(8).standard_normal((6, 5))
    assert explained_variance(tuple("abcde"), x, x[:, 0]) is None
    assert explained_variance(("a",), x[:, :1], np.full(6, 0.3)) is None
    assert explained_variance((), x[:, :0], x[:, 0]) is None
