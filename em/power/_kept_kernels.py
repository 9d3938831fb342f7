# mypy: allow-untyped-defs
"""Compiled fields along paths that were kept: no search, no tests of sight, only the waves."""

import numpy as np

from octant.em.fields._field_kernels import field_rows, fields_in_scene
from octant.em.fields._wave_kernels import WIDTH
from octant.em.paths._path_kernels import path_rows
from octant.geometries.kernels import kernel


@kernel(nogil=True)
def kept_fields(scene, transmitter, width, start, points, codes, begin, end, field, direction):
    """Fill the field (k, 3) that each path brings to its receiver, and how it travels there.

    Rows begin to end. ``points`` of path i are rows start[i] to start[i + 1], from the receiver to
    the source; its ``codes`` begin at start[i] - 2 i, in the same sense. ``width`` is the greatest
    number of interactions. The field is times lambda / 4 pi, as in `path_fields`.
    """
    corners, walls = path_rows(np.int64(WIDTH), width)
    orders = np.empty(WIDTH, dtype=np.int64)
    here, going = field_rows(np.int64(WIDTH))
    first = begin
    while first < end:
        count = min(np.int64(WIDTH), end - first)
        for p in range(count):
            i = first + p
            n = start[i + 1] - start[i] - 2
            orders[p] = n
            for v in range(n + 2):
                for a in range(3):
                    corners[p, v, a] = points[start[i] + v, a]
            for v in range(n):
                walls[p, v] = codes[start[i] - 2 * i + v]
        fields_in_scene(scene, transmitter, count, corners, walls, orders, here, going)
        for p in range(count):
            for a in range(3):
                field[first + p, a], direction[first + p, a] = here[p, a], going[p, a]
        first += count
