# mypy: allow-untyped-defs
"""Compiled geometry of the cells that a beam is cut into to find what it sees.

A cell is a cone over a rectangle of a plane at distance 1 before the apex. Depths count along the
axis of that plane.
"""

from typing import NamedTuple

import numpy as np

from octant.geometries.kernels import kernel

_FRONT = 0.4  # least cosine between the axis and a window's corner; wider: six sides of a cube


class SightFacets(NamedTuple):
    """Facets as beams look for them."""

    plane_normal: np.ndarray  # (p, 3)
    plane_offset: np.ndarray  # (p,) [m]
    plane: np.ndarray  # (f,) int64
    side: np.ndarray  # (f,) int64: +1, -1: the only side on which it reflects; 0: both
    hull_start: np.ndarray  # (f + 1,) int64
    hulls: np.ndarray  # (v, 3) [m]
    boxes: np.ndarray  # hierarchy over the hulls of usable facets
    links: np.ndarray
    order: np.ndarray
    slack: float  # [m]


@kernel
def fill_view(facets, facet, image, view):
    """Fill a facet's normal, away from the apex, and the apex' height before its plane [m]."""
    plane = facets.plane[facet]
    normal = facets.plane_normal
    height = (
        normal[plane, 0] * image[0]
        + normal[plane, 1] * image[1]
        + normal[plane, 2] * image[2]
        - facets.plane_offset[plane]
    )
    turn = -1.0 if height > 0.0 else 1.0
    for a in range(3):
        view[a] = turn * normal[plane, a]
    view[3] = abs(height)


@kernel
def faces(facets, facet, image):
    """Return whether an apex lies off a facet's plane, on a side on which the facet reflects."""
    plane = facets.plane[facet]
    height = (
        facets.plane_normal[plane, 0] * image[0]
        + facets.plane_normal[plane, 1] * image[1]
        + facets.plane_normal[plane, 2] * image[2]
        - facets.plane_offset[plane]
    )
    return abs(height) > facets.slack and height * facets.side[facet] >= 0.0


@kernel
def _make_unit(vector):
    """Make a vector 1 long."""
    square = 0.0
    for a in range(3):
        square += vector[a] * vector[a]
    for a in range(3):
        vector[a] /= np.sqrt(square)


@kernel
def along_axes(point, apex, axes):
    """Return the products of the way from an apex to a point with three axes."""
    deep, u, v = 0.0, 0.0, 0.0
    for a in range(3):
        x = point[a] - apex[a]
        deep += x * axes[0, a]
        u += x * axes[1, a]
        v += x * axes[2, a]
    return deep, u, v


@kernel
def first_cells(image, window, begin, end, axes, bounds):
    """Fill axis and two vectors across for each cell to begin with, and its bounds on them."""
    if end > begin:
        axis = np.zeros(3)
        for i in range(begin, end):
            norm = 0.0
            for a in range(3):
                norm += (window[i, a] - image[a]) ** 2
            for a in range(3):
                axis[a] += (window[i, a] - image[a]) / np.sqrt(norm)
        _make_unit(axis)
        least = 0
        for a in range(1, 3):
            if abs(axis[a]) < abs(axis[least]):
                least = a
        across = np.empty(3)
        for a in range(3):
            across[a] = -axis[least] * axis[a]
        across[least] += 1.0
        _make_unit(across)
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            axes[0, 0, a], axes[0, 1, a] = axis[a], across[a]
            axes[0, 2, a] = axis[b] * across[c] - axis[c] * across[b]
        bounds[0, 0], bounds[0, 2], bounds[0, 1], bounds[0, 3] = np.inf, np.inf, -np.inf, -np.inf
        front = 1.0
        for i in range(begin, end):
            deep, u, v = along_axes(window[i], image, axes[0])
            far = 0.0
            for a in range(3):
                far += (window[i, a] - image[a]) ** 2
            front = min(front, deep / np.sqrt(far))
            if front < _FRONT:
                break
            u, v = u / deep, v / deep
            bounds[0, 0], bounds[0, 1] = min(bounds[0, 0], u), max(bounds[0, 1], u)
            bounds[0, 2], bounds[0, 3] = min(bounds[0, 2], v), max(bounds[0, 3], v)
        if front >= _FRONT:
            return 1
    for side in range(6):
        a, turn = side // 2, 1.0 - 2.0 * (side % 2)
        axes[side] = 0.0
        axes[side, 0, a] = turn
        axes[side, 1, (a + 1) % 3] = 1.0
        axes[side, 2, (a + 2) % 3] = turn
        bounds[side, 0], bounds[side, 1], bounds[side, 2], bounds[side, 3] = -1.0, 1.0, -1.0, 1.0
    return 6


@kernel
def fill_cell(axes, bounds, quad, sides):
    """Fill the four directions of a cell, counter-clockwise, and its sides, normals inwards."""
    for i in range(4):
        u = bounds[1] if i in (1, 2) else bounds[0]
        v = bounds[3] if i > 1 else bounds[2]
        for a in range(3):
            quad[i, a] = axes[0, a] + u * axes[1, a] + v * axes[2, a]
    for i in range(4):
        j = (i + 1) % 4
        x = quad[i, 1] * quad[j, 2] - quad[i, 2] * quad[j, 1]
        y = quad[i, 2] * quad[j, 0] - quad[i, 0] * quad[j, 2]
        z = quad[i, 0] * quad[j, 1] - quad[i, 1] * quad[j, 0]
        norm = np.sqrt(x * x + y * y + z * z)
        sides[i, 0], sides[i, 1], sides[i, 2] = x / norm, y / norm, z / norm


@kernel
def least_depth(corners, first, count, view, axis, quad, sides, slack):
    """Return the least depth [m] at which a facet may be met in a cell; infinity: it is not."""
    for k in range(4):
        outside = True
        for i in range(first, first + count):
            x, y, z = corners[i, 0], corners[i, 1], corners[i, 2]
            give = 2.0 * slack + 1e-12 * (abs(x) + abs(y) + abs(z))
            if sides[k, 0] * x + sides[k, 1] * y + sides[k, 2] * z > -give:
                outside = False
                break
        if outside:
            return np.inf
    depth = np.inf
    for i in range(first, first + count):
        here = axis[0] * corners[i, 0] + axis[1] * corners[i, 1] + axis[2] * corners[i, 2]
        depth = min(depth, here)
    steepest = 0.0
    for i in range(4):
        q = view[0] * quad[i, 0] + view[1] * quad[i, 1] + view[2] * quad[i, 2]
        steepest = max(steepest, q)
    if steepest > 0.0:
        depth = max(depth, view[3] / steepest)
    return max(depth, 0.0)


@kernel
def box_is_off(boxes, node, image, axis, sides, slack, depth):
    """Return whether a box lies outside a cell or deeper than a depth [m]."""
    reach = 0.0
    least = 0.0
    for a in range(3):
        low, high = boxes[node, a] - image[a], boxes[node, 3 + a] - image[a]
        reach += max(abs(low), abs(high))
        least += axis[a] * (low if axis[a] > 0.0 else high)
    if least > depth:
        return True
    for k in range(4):
        most = 2.0 * slack + 1e-12 * reach
        for a in range(3):
            n = sides[k, a]
            most += n * ((boxes[node, 3 + a] if n > 0.0 else boxes[node, a]) - image[a])
        if most < 0.0:
            return True
    return False
