import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.sensing.gaussianity import gaussianity


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
