# mypy: allow-untyped-defs
"""Compiled paths between the nodes of a coarse grid: those of a cell's corners, image by image."""

import math

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


@kernel
def towards_image(image, x, y, z):
    """Return the vector from a place to a path's image [m], and the unit vector from an edge to it.

    image (7,): the image point, or the point of an edge about which it turns, opposite to the
    place; the edge's axis, and the radius, 0 of an image that stands still.
    """
    rx, ry, rz = x - image[0], y - image[1], z - image[2]
    along = rx * image[3] + ry * image[4] + rz * image[5]
    rx, ry, rz = rx - along * image[3], ry - along * image[4], rz - along * image[5]
    across = math.sqrt(rx * rx + ry * ry + rz * rz)
    part = 1.0 / across if across > 0.0 else 0.0
    rx, ry, rz = part * rx, part * ry, part * rz
    radius = image[6]
    return (
        image[0] - radius * rx - x, image[1] - radius * ry - y, image[2] - radius * rz - z,
        rx, ry, rz,
    )  # fmt: skip
