"""Systematic resampling of weighed particles."""

import numpy as np
import numpy.typing as npt


def systematic(
    weights: npt.NDArray[np.float64], count: int, rng: np.random.Generator
) -> npt.NDArray[np.int64]:
    """Return which particles are drawn, (count,), each as often as its weight says, in order.

    Parameters
    ----------
    weights : (m,) float64 — Of the particles, not negative; their sum does not matter [-].
    count : How many are drawn.
    rng : Source of the one random number that it takes.
    """
    edges = np.cumsum(weights)
    steps = (rng.random() + np.arange(count)) / count * edges[-1]
    chosen: npt.NDArray[np.int64] = np.minimum(np.searchsorted(edges, steps), len(edges) - 1)
    return chosen
