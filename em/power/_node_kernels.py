# mypy: allow-untyped-defs
"""Compiled paths between the nodes of a coarse grid: those of a cell's corners, image by image."""

import numpy as np

from octant.geometries.kernels import kernel

NO_PATH = np.int64(2**62)
"""Stands for an image [-] where no corner has another path."""


@kernel
def find_corners(x, y, low, cell, nodes, start, at, last, weight):
    """Fill where the paths of the corners of a place's cell begin and end, and their weights (4,).

    Paths of node (i, j) stand at start[i * nodes[1] + j], in the order of their images.
    """
    u, v = (x - low[0]) / cell[0], (y - low[1]) / cell[1]
    i, j = min(max(int(u), 0), nodes[0] - 2), min(max(int(v), 0), nodes[1] - 2)
    u, v = u - i, v - j
    for corner in range(4):
        a, b = corner // 2, corner % 2
        weight[corner] = (u if a else 1.0 - u) * (v if b else 1.0 - v)
        node = (i + a) * nodes[1] + j + b
        at[corner], last[corner] = start[node], start[node + 1]


@kernel
def next_path(at, last, weight, image, field):
    """Return the next image, `NO_PATH` behind the last, the sum of its fields, and of its weights.

    A path that reaches some corners only counts if they have half of the weight.
    """
    p = NO_PATH
    for corner in range(4):
        if at[corner] < last[corner]:
            p = min(p, image[at[corner]])
    ex, ey, ez, known = complex(0.0), complex(0.0), complex(0.0), 0.0
    for corner in range(4):
        if at[corner] < last[corner] and image[at[corner]] == p:
            e, w = field[at[corner]], weight[corner]
            ex, ey, ez, known = ex + w * e[0], ey + w * e[1], ez + w * e[2], known + w
            at[corner] += 1
    return p, ex, ey, ez, known
