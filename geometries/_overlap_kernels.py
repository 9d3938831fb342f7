# mypy: allow-untyped-defs
"""Compiled kernel for flat pieces that overlap themselves: where edges cross."""

import numpy as np

from octant.geometries._array_kernels import grown
from octant.geometries.kernels import kernel


@kernel
def crossings(ends, tolerance):
    """Return (c, 2) pairs of plane edges (k, 4) that cross, and (c, 2) where [m] along each."""
    pairs = np.empty((16, 2), dtype=np.int64)
    along = np.empty((16, 2))
    count = 0
    for i in range(len(ends)):
        ax, ay = ends[i, 2] - ends[i, 0], ends[i, 3] - ends[i, 1]
        a = np.sqrt(ax * ax + ay * ay)
        for j in range(i + 1, len(ends)):
            bx, by = ends[j, 2] - ends[j, 0], ends[j, 3] - ends[j, 1]
            b = np.sqrt(bx * bx + by * by)
            det = ax * by - ay * bx
            ox, oy = ends[j, 0] - ends[i, 0], ends[j, 1] - ends[i, 1]
            # Nearly parallel edges meet at corners only, where they are cut already.
            if abs(det) * min(a, b) <= tolerance * a * b:
                continue
            s, t = (ox * by - oy * bx) / det * a, (ox * ay - oy * ax) / det * b
            if not (tolerance < s < a - tolerance and tolerance < t < b - tolerance):
                continue
            pairs, along = grown(pairs, count + 1), grown(along, count + 1)
            pairs[count, 0], pairs[count, 1] = i, j
            along[count, 0], along[count, 1] = s, t
            count += 1
    return pairs[:count].copy(), along[:count].copy()
