# mypy: allow-untyped-defs
"""Compiled windows: what a beam sees of a large facet, as few polygons that hold little else."""

import numpy as np

from octant.em.search._beam_kernels import MAX_CORNERS, clip_to_beam, copy_rows
from octant.em.search._cell_kernels import along_axes, fill_cell
from octant.geometries._array_kernels import fill_order, grown
from octant.geometries.kernels import kernel

FILLED = 0.6
"""Least share [-] of a window of a large facet that is seen; of less, there are two windows."""


@kernel
def _clipped_to_cell(image, slack, corners, first, count, axes, cell, rows, cut, out):
    """Return the corner count of the part of a facet within a cell, written to ``out`` [m]."""
    quad, sides = np.empty((4, 3)), np.empty((4, 3))
    fill_cell(axes, cell, quad, sides)
    for k in range(4):
        rows[k, 3] = 0.0
        for a in range(3):
            rows[k, a] = sides[k, a]
            rows[k, 3] += sides[k, a] * image[a]
        rows[k, 4] = np.inf
    return clip_to_beam(corners, first, first + count, image, rows, 4, slack, cut, out)


@kernel
def _area(polygon, count, image, axes):
    """Return the area of a polygon as it looks from the apex, at distance 1 along the axis."""
    area = 0.0
    u0, v0, u1, v1 = 0.0, 0.0, 0.0, 0.0
    for i in range(count + 1):
        deep, u, v = along_axes(polygon[i % count], image, axes)
        deep = max(deep, 1e-12)
        u, v = u / deep, v / deep
        if i == 0:
            u0, v0 = u, v
        else:
            area += 0.5 * ((u1 - u0) * (v - v0) - (u - u0) * (v1 - v0))
        u1, v1 = u, v
    return abs(area)


@kernel
def tracked_windows(image, slack, hits, axes, cells, found, n_found, corners, n_corners):
    """Add what is seen of large facets, as few windows that hold little else, to those found."""
    cell_of, cell_bounds, n_cells = cells
    keys, order = np.empty(n_cells), np.empty(n_cells, dtype=np.int64)
    for k in range(n_cells):
        keys[k] = 6 * cell_of[k, 0] + cell_of[k, 1]
    fill_order(keys, order)
    cut, out = np.empty((MAX_CORNERS + 8, 3)), np.empty((MAX_CORNERS + 8, 3))
    rows = np.empty((4, 5))
    work = np.empty((64, 2), dtype=np.int64)
    whole = np.empty(4)
    begin = 0
    while begin < n_cells:
        h, root = cell_of[order[begin], 0], cell_of[order[begin], 1]
        end = begin
        while end < n_cells and keys[order[end]] == keys[order[begin]]:
            end += 1
        first, count = hits[h, 1], hits[h, 2]
        work[0, 0], work[0, 1] = begin, end
        top = 1
        while top > 0:
            top -= 1
            low, high = work[top, 0], work[top, 1]
            for k in range(4):
                whole[k] = cell_bounds[order[low], k]
            area = 0.0
            for k in range(low, high):
                cell = cell_bounds[order[k]]
                whole[0], whole[1] = min(whole[0], cell[0]), max(whole[1], cell[1])
                whole[2], whole[3] = min(whole[2], cell[2]), max(whole[3], cell[3])
            if high - low > 1:
                for k in range(low, high):
                    size = _clipped_to_cell(
                        image, slack, corners, first, count, axes[root], cell_bounds[order[k]],
                        rows, cut, out,
                    )  # fmt: skip
                    if size > 0:
                        area += _area(out, size, image, axes[root])
            size = _clipped_to_cell(
                image, slack, corners, first, count, axes[root], whole, rows, cut, out
            )
            if size == 0:
                continue
            if high - low > 1 and top < 60 and area < FILLED * _area(out, size, image, axes[root]):
                along = 0 if whole[1] - whole[0] > whole[3] - whole[2] else 2
                middle = 0.5 * (whole[along] + whole[along + 1])
                split = low
                for k in range(low, high):
                    cell = cell_bounds[order[k]]
                    if 0.5 * (cell[along] + cell[along + 1]) < middle:
                        order[k], order[split] = order[split], order[k]
                        split += 1
                if low < split < high:
                    work[top, 0], work[top, 1] = low, split
                    work[top + 1, 0], work[top + 1, 1] = split, high
                    top += 2
                    continue
            found = grown(found, n_found + 1)
            corners = grown(corners, n_corners + size)
            found[n_found, 0], found[n_found, 1], found[n_found, 2] = hits[h, 0], n_corners, size
            copy_rows(out, 0, size, corners, n_corners)
            n_found += 1
            n_corners += size
        begin = end
    return found[:n_found], corners
