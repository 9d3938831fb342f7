# mypy: allow-untyped-defs
"""Compiled geometry of what is covered: polygons of directions, and screens cut out of them.

A direction is a vector from the apex of a beam that is 1 long along the axis of the cell it is in.
A screen is a convex opaque polygon. Whatever of a polygon of directions lies within the cone of a
screen is covered from the screen's depth on; what is left over falls into convex pieces.
"""

from typing import NamedTuple

import numpy as np

from octant.geometries.kernels import kernel

PIECES, PIECE_CORNERS = 24, 20
"""Greatest number of pieces, and of corners of each; where more are needed nothing is covered."""

MOST_EDGES = 12
"""Greatest number of corners of a screen [-]."""

_SLIVER = 1e-11  # what is narrower [rad] is rounding of one and the same edge


class Screens(NamedTuple):
    """The convex opaque polygons of a scene."""

    facet_start: np.ndarray  # (f + 1,) int64: where the screens of each facet start
    corner_start: np.ndarray  # (s + 1,) int64
    corners: np.ndarray  # (v, 3) [m]
    beyond: np.ndarray  # (v, 3) [m]: corner of the opaque triangle that goes on across the edge
    # from this corner to the next; NaN where none is known
    large: np.ndarray  # (l,) int64: the facets with the largest screens
    is_large: np.ndarray  # (f,) bool
    margin: float  # [m] by which screens are smaller at their rims and lie deeper
    give: float  # [m] by which they are larger where another one goes on


@kernel
def fill_edges(screens, screen, image, normal, height, edges):
    """Fill the inner sides of a screen's cone, seen from an apex; return how many, 0: unusable.

    ``normal`` points away from the apex, which is at ``height`` before the screen's plane. A side
    is a vector whose product with each direction inside is at least 0.
    """
    corners, beyond = screens.corners, screens.beyond
    begin, end = screens.corner_start[screen], screens.corner_start[screen + 1]
    if end - begin > len(edges):
        return 0
    cx, cy, cz = 0.0, 0.0, 0.0
    for i in range(begin, end):
        cx += corners[i, 0] - image[0]
        cy += corners[i, 1] - image[1]
        cz += corners[i, 2] - image[2]
    for i in range(begin, end):
        j = i + 1 if i + 1 < end else begin
        ax, ay, az = corners[i, 0] - image[0], corners[i, 1] - image[1], corners[i, 2] - image[2]
        bx, by, bz = corners[j, 0] - image[0], corners[j, 1] - image[1], corners[j, 2] - image[2]
        mx, my, mz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        norm = np.sqrt(mx * mx + my * my + mz * mz)
        if norm * norm <= 1e-24 * (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz):
            return 0
        if mx * cx + my * cy + mz * cz < 0.0:
            norm = -norm
        mx, my, mz = mx / norm, my / norm, mz / norm
        side = (
            mx * (beyond[i, 0] - image[0])
            + my * (beyond[i, 1] - image[1])
            + mz * (beyond[i, 2] - image[2])
        )
        shift = (screens.give if side < 0.0 else -screens.margin) / height
        row = i - begin
        edges[row, 0] = mx + shift * normal[0]
        edges[row, 1] = my + shift * normal[1]
        edges[row, 2] = mz + shift * normal[2]
    return end - begin


@kernel
def _misses(piece, size, edges, count):
    """Return whether a piece lies wholly outside one side of a cone."""
    for e in range(count):
        outside = True
        for i in range(size):
            if (
                edges[e, 0] * piece[i, 0] + edges[e, 1] * piece[i, 1] + edges[e, 2] * piece[i, 2]
                > _SLIVER
            ):
                outside = False
                break
        if outside:
            return True
    return False


@kernel
def _part(piece, size, edge, turn, out):
    """Keep the part of a piece on one side, ``turn`` 1 or -1, of a plane; return its corners."""
    kept = 0
    for i in range(size):
        j = i + 1 if i + 1 < size else 0
        a = turn * (edge[0] * piece[i, 0] + edge[1] * piece[i, 1] + edge[2] * piece[i, 2])
        b = turn * (edge[0] * piece[j, 0] + edge[1] * piece[j, 1] + edge[2] * piece[j, 2])
        if a >= 0.0:
            for k in range(3):
                out[kept, k] = piece[i, k]
            kept += 1
        if (a >= 0.0) != (b >= 0.0):
            t = a / (a - b)
            for k in range(3):
                out[kept, k] = piece[i, k] + t * (piece[j, k] - piece[i, k])
            kept += 1
    return kept


@kernel
def _reaches(piece, size, edge, turn):
    """Return whether a piece has more than a sliver on one side of a plane."""
    for i in range(size):
        if turn * (edge[0] * piece[i, 0] + edge[1] * piece[i, 1] + edge[2] * piece[i, 2]) > _SLIVER:
            return True
    return False


@kernel
def clip_to_cone(piece, size, edges, count, work):
    """Cut a piece down to a cone in place; return its corners, 0: nothing is left."""
    for e in range(count):
        if size + 1 > PIECE_CORNERS:
            return size
        size = _part(piece, size, edges[e], 1.0, work)
        if size < 3:
            return 0
        copy_piece(work, size, piece)
    return size


@kernel
def copy_piece(source, size, target):
    for i in range(size):
        for k in range(3):
            target[i, k] = source[i, k]


@kernel
def _covering_depth(piece, size, normal, height, margin, window, target):
    """Return the greatest depth [m] of a screen's plane over a piece; infinity: it covers nothing.

    It has to stand beyond the ``window`` (normal, distance) and before the ``target`` (the same).
    Depths count along the axis; their inverse is linear over a piece, so that corners suffice.
    """
    most = 0.0
    for i in range(size):
        x, y, z = piece[i, 0], piece[i, 1], piece[i, 2]
        q = normal[0] * x + normal[1] * y + normal[2] * z
        if q <= 1e-9 * height:
            return np.inf
        if (window[0] * x + window[1] * y + window[2] * z) * height < (window[3] + margin) * q:
            return np.inf
        g = target[0] * x + target[1] * y + target[2] * z
        if (height + margin) * g >= target[3] * q:
            return np.inf
        most = max(most, (height + margin) / q)
    return most


@kernel
def subtract(
    pieces, sizes, count, edges, n_edges, normal, height, margin, window, target, spare, work
):
    """Take a screen's cone out of pieces, in place; return how many are left, and the depth [m].

    The depth is the greatest at which the screen covers what it took. ``spare`` is room for as many
    pieces. Where there is no room the pieces stay as they are.
    """
    fresh, depth = 0, 0.0
    spare_pieces, spare_sizes = spare
    inside, other = work
    changed = False
    for p in range(count):
        piece, size = pieces[p], sizes[p]
        if fresh >= PIECES:
            return count, 0.0
        if size + n_edges > PIECE_CORNERS or _misses(piece, size, edges, n_edges):
            copy_piece(piece, size, spare_pieces[fresh])
            spare_sizes[fresh] = size
            fresh += 1
            continue
        first = fresh
        copy_piece(piece, size, inside)
        left = size
        for e in range(n_edges):
            if _reaches(inside, left, edges[e], -1.0):
                if fresh >= PIECES:
                    return count, 0.0
                spare_sizes[fresh] = _part(inside, left, edges[e], -1.0, spare_pieces[fresh])
                fresh += 1
            left = _part(inside, left, edges[e], 1.0, other)
            inside, other = other, inside
            if left < 3:
                break
        here = np.inf
        if left >= 3:
            here = _covering_depth(inside, left, normal, height, margin, window, target)
        if here == np.inf:
            fresh = first
            copy_piece(piece, size, spare_pieces[fresh])
            spare_sizes[fresh] = size
            fresh += 1
            continue
        changed = True
        depth = max(depth, here)
    if not changed:
        return count, 0.0
    for p in range(fresh):
        copy_piece(spare_pieces[p], spare_sizes[p], pieces[p])
        sizes[p] = spare_sizes[p]
    return fresh, depth
