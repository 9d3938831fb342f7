# mypy: allow-untyped-defs
"""Compiled magnetic fields on the reader's metal: the sum over all rays."""

import numpy as np

from octant.em.fields._field_kernels import field_rows, fields_in_scene
from octant.em.paths._tracing_kernels import (
    next_paths,
    traced_at_once,
    tracing_end,
    tracing_scratch,
)
from octant.geometries.kernels import kernel


@kernel(nogil=True)
def sum_magnetic_fields(scene, tree, edges, transmitter, places, begin, end, total):
    """Fill (m, 3) the coherent sum of direction x field, rows begin to end.

    Each path also carries the dipole's induction field: 1 + 1 / (jkL) over its whole length L.
    """
    scratch = tracing_scratch(scene, tree, edges)
    points, facets, orders, receiver = scratch[0][1], scratch[0][2], scratch[0][3], scratch[4]
    field, direction = field_rows(len(orders))
    step = traced_at_once(scene, end - begin)
    wavenumber = 2.0 * np.pi / scene.wavelength
    total[begin:end] = 0.0
    for first in range(begin, end, step):
        last = min(first + step, end)
        everything = tracing_end(tree, edges, first, last)
        place = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
        while place < everything:
            found, place = next_paths(scene, tree, edges, places, first, last, place, scratch)
            fields_in_scene(scene, transmitter, found, points, facets, orders, field, direction)
            for p in range(found):
                i = receiver[p]
                length = 0.0
                for leg in range(orders[p] + 1):
                    square = 0.0
                    for a in range(3):
                        square += (points[p, leg, a] - points[p, leg + 1, a]) ** 2
                    length += np.sqrt(square)
                near = complex(1.0, -1.0 / (wavenumber * length))
                dx, dy, dz = direction[p, 0], direction[p, 1], direction[p, 2]
                total[i, 0] += near * (dy * field[p, 2] - dz * field[p, 1])
                total[i, 1] += near * (dz * field[p, 0] - dx * field[p, 2])
                total[i, 2] += near * (dx * field[p, 1] - dy * field[p, 0])
