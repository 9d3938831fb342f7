"""Shares of variance against closed forms."""

import numpy as np
import pytest

from octant.reader_design.experiments.tolerance.statistics import explained_variance


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
