# mypy: allow-untyped-defs
"""Compiled growth of arrays whose final length is not known before."""

import numpy as np

from octant.geometries.kernels import kernel


@kernel
def grown(array, needed):
    """Return the array with room for ``needed`` rows."""
    if needed <= len(array):
        return array
    larger = np.empty((max(needed, 2 * len(array)), array.shape[1]), dtype=array.dtype)
    larger[: len(array)] = array
    return larger
