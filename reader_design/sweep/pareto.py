"""The Pareto front: what no other one beats in everything."""

import numpy as np
import numpy.typing as npt


def undominated(merits: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return which rows no other row dominates [-].

    Parameters
    ----------
    merits : (k, m) array_like
        What each of k designs achieves in m respects, larger is better, in any units [-].

    Returns
    -------
    (k,) bool
        True: no other row is at least as good in every respect and better in one. Equal rows do
        not dominate each other.
    """
    rows = np.asarray(merits, dtype=np.float64)
    front = np.ones(len(rows), dtype=np.bool_)
    for i, row in enumerate(rows):
        front[i] = not ((rows >= row).all(axis=1) & (rows > row).any(axis=1)).any()
    return front
