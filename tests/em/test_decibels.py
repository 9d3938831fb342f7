"""The logarithm that kernels take many of at once."""

import numpy as np

from octant.em._decibel_kernels import natural_log


def test_natural_log_is_exact_to_rounding_over_all_powers():
    near_one = 1.0 + np.linspace(-0.3, 0.5, 4001)
    powers = np.concatenate([np.logspace(-300.0, 300.0, 6001), near_one, [1.0, 2.0, 0.5]])
    logs = np.array([natural_log(power) for power in powers])
    exact = np.log(powers.astype(np.longdouble))
    assert (np.abs(logs - exact) <= 2.5e-16 * np.maximum(np.abs(exact), 1.0)).all()
    small = np.abs(exact) < 0.5
    assert np.abs(logs[small] - exact[small]).max() < 2e-16
