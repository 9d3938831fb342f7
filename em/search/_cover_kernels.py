# mypy: allow-untyped-defs
"""Compiled tests of what the screens of a cell cover together."""

import numpy as np

from octant.em.search._screen_kernels import clip_to_cone, copy_piece, fill_edges, subtract
from octant.geometries.kernels import kernel

NEAREST = 8
"""Nearest facets [-] of a cell whose screens are asked what they cover together."""


@kernel
def _next_screened(screens, hits, listed, depths, begin, end, last, at):
    """Return the place of the next deeper hit of a list that has screens, -1: there is none."""
    best = -1
    for k in range(begin, end):
        facet = hits[listed[k, 0], 0]
        if screens.facet_start[facet] == screens.facet_start[facet + 1]:
            continue
        later = depths[k, 0] > last or (depths[k, 0] == last and k > at)
        if later and (best < 0 or depths[k, 0] < depths[best, 0]):
            best = k
    return best


@kernel
def _subtract_facet(screens, image, facet, view, count, window, target, room):
    """Take all screens of a facet out of the pieces; return how many are left, and the depth."""
    pieces, sizes, spare, work, edges, _ = room
    depth = 0.0
    if view[3] <= screens.margin:
        return count, depth
    for s in range(screens.facet_start[facet], screens.facet_start[facet + 1]):
        rows = fill_edges(screens, s, image, view, view[3], edges)
        if rows > 0:
            count, here = subtract(
                pieces,
                sizes,
                count,
                edges,
                rows,
                view,
                view[3],
                screens.margin,
                window,
                target,
                spare,
                work,
            )
            depth = max(depth, here)
            if count == 0:
                break
    return count, depth


@kernel
def covered_from(screens, image, begin, end, quad, window, room, lists):
    """Return the depth [m] from which the nearest screens of a cell cover it; infinity: never."""
    hits, views, listed, depths = lists[0], lists[1], lists[3], lists[4]
    pieces, sizes, target = room[0], room[1], room[5]
    copy_piece(quad, 4, pieces[0])
    sizes[0] = 4
    target[:3], target[3] = 0.0, np.inf
    count, depth, last, at = np.int64(1), 0.0, -1.0, -1
    for _ in range(NEAREST):
        at = _next_screened(screens, hits, listed, depths, begin, end, last, at)
        if at < 0:
            break
        last, h = depths[at, 0], listed[at, 0]
        count, here = _subtract_facet(
            screens, image, hits[h, 0], views[h], count, window, target, room
        )
        depth = max(depth, here)
        if count == 0:
            return depth
    return np.inf


@kernel
def _cut_to_facet(screens, corners, first, count, view, piece, work):
    """Cut four directions down to those of a facet, larger by what it may be off; their number."""
    size = 4
    cx, cy, cz = 0.0, 0.0, 0.0
    for i in range(first, first + count):
        cx, cy, cz = cx + corners[i, 0], cy + corners[i, 1], cz + corners[i, 2]
    side, shift = np.empty((1, 3)), screens.give / view[3]
    for i in range(first, first + count):
        j = i + 1 if i + 1 < first + count else first
        ax, ay, az = corners[i, 0], corners[i, 1], corners[i, 2]
        bx, by, bz = corners[j, 0], corners[j, 1], corners[j, 2]
        mx, my, mz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        norm = np.sqrt(mx * mx + my * my + mz * mz)
        if norm * norm <= 1e-24 * (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz):
            continue
        if mx * cx + my * cy + mz * cz < 0.0:
            norm = -norm
        side[0, 0] = mx / norm + shift * view[0]
        side[0, 1] = my / norm + shift * view[1]
        side[0, 2] = mz / norm + shift * view[2]
        size = clip_to_cone(piece, size, side, 1, work)
        if size == 0:
            break
    return size


@kernel
def any_left(
    screens, image, h, hits, views, corners, listed, depths, begin, end, quad, window, room
):
    """Return whether the screens before a facet leave anything of it in a cell."""
    pieces, sizes, work, target = room[0], room[1], room[3], room[5]
    view = views[h]
    if view[3] <= screens.margin:
        return True
    copy_piece(quad, 4, pieces[0])
    sizes[0] = _cut_to_facet(screens, corners, hits[h, 1], hits[h, 2], view, pieces[0], work[0])
    if sizes[0] == 0:
        return False
    for k in range(4):
        target[k] = view[k]
    count, last, at = np.int64(1), -1.0, -1
    while True:
        at = _next_screened(screens, hits, listed, depths, begin, end, last, at)
        if at < 0:
            return True
        last, other = depths[at, 0], listed[at, 0]
        if other == h:
            continue
        count, _ = _subtract_facet(
            screens, image, hits[other, 0], views[other], count, window, target, room
        )
        if count == 0:
            return False
