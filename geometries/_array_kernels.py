# mypy: allow-untyped-defs
"""Compiled growth of arrays whose final length is not known before, and sorting."""

import numpy as np

from octant.geometries.kernels import kernel


@kernel
def grown(array, needed):
    """Return the array with room for ``needed`` rows."""
    if needed <= len(array):
        return array
    larger = np.empty((max(needed, 2 * len(array)), array.shape[1]), dtype=array.dtype)
    for i in range(len(array)):
        for k in range(array.shape[1]):
            larger[i, k] = array[i, k]
    return larger


@kernel(returns="none")
def fill_order(keys, order):
    """Fill ``order`` with the places of rising keys; equal keys stay as they stand (merge sort)."""
    n = len(keys)
    source, target = order, np.empty(n, dtype=np.int64)
    for i in range(n):
        source[i] = i
    width = 1
    while width < n:
        for begin in range(0, n, 2 * width):
            middle, end = min(begin + width, n), min(begin + 2 * width, n)
            left, right = begin, middle
            for place in range(begin, end):
                if left < middle and (right >= end or keys[source[left]] <= keys[source[right]]):
                    target[place] = source[left]
                    left += 1
                else:
                    target[place] = source[right]
                    right += 1
        source, target = target, source
        width *= 2
    for i in range(n):  # onto itself when the last pass ended there
        order[i] = source[i]


@kernel
def first_not_below(keys, value):
    """Return the place of the first of rising keys that is at least a value, or their number."""
    low, high = 0, len(keys)
    while low < high:
        middle = (low + high) // 2
        if keys[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@kernel(forceinline=True)
def at(first, i):
    """Return first + i as an index that is not counted from the end where it is below zero.

    Only of such indices the compiler sees that neighbours stand together, and takes several at
    once; a slice would do, but counts its references with every use.
    """
    return np.uint64(first) + np.uint64(i)
