# mypy: allow-untyped-defs
"""Compiled search for the facets that a beam sees, past all that screens cover together.

The beam is cut into cells, each in four, until few facets are left in one. In each cell the nearest
screens, together, cover what lies deeper than the last of them; in the smallest, each facet is
asked for itself whether the screens before it leave anything of it.
"""

import numpy as np

from octant.em.search._beam_kernels import MAX_CORNERS, box_is_outside, clip_to_beam
from octant.em.search._cell_kernels import (
    box_is_off,
    faces,
    fill_cell,
    fill_view,
    first_cells,
    least_depth,
)
from octant.em.search._cover_kernels import any_left, covered_from
from octant.em.search._screen_kernels import MOST_EDGES, PIECE_CORNERS, PIECES
from octant.em.search._window_kernels import tracked_windows
from octant.geometries._array_kernels import grown
from octant.geometries.kernels import kernel

FEW = 8
"""Facets [-] of a cell that are asked one by one."""

DEEPEST = 6
"""Times [-] that a cell is cut into four, at most, once its facets are known."""

GATHERED = 2
"""Times [-] that a cell of a wide beam is cut before its facets are gathered: until then the large
screens alone say how deep to look."""

FACET, FIRST, COUNT, WANTED, SEEN = 0, 1, 2, 3, 4
"""Columns of a hit: a facet in the beam, its corners, whether it is looked for and whether seen."""

_WIDER = 1e-7  # by which cells are wider, so that rounding leaves nothing between them


@kernel
def _add_hit(facets, facet, image, wanted, points, begin, count, lists):
    """Add a facet to the hits, of which ``points`` are the corners [m]; return the lists."""
    hits, views, corners, listed, depths, (n_hits, n_corners) = lists
    hits, views = grown(hits, n_hits + 1), grown(views, n_hits + 1)
    corners = grown(corners, n_corners + count)
    hits[n_hits, FACET], hits[n_hits, FIRST], hits[n_hits, COUNT] = facet, n_corners, count
    hits[n_hits, WANTED], hits[n_hits, SEEN] = wanted, 0
    fill_view(facets, facet, image, views[n_hits])
    for i in range(count):
        for a in range(3):
            corners[n_corners + i, a] = points[begin + i, a] - image[a]
    return hits, views, corners, listed, depths, (n_hits + 1, n_corners + count)


@kernel
def _add_large(facets, screens, image, plane_before, lists):
    """Add all large facets to the hits, to hide others only; return the lists."""
    for k in range(len(screens.large)):
        facet = screens.large[k]
        if facets.plane[facet] != plane_before:
            begin = facets.hull_start[facet]
            size = facets.hull_start[facet + 1] - begin
            lists = _add_hit(facets, facet, image, 0, facets.hulls, begin, size, lists)
    return lists


@kernel
def _list_hit(h, place, axis, quad, sides, slack, most, lists):
    """Write a hit at a place of the list unless it is deeper than ``most``; return place, lists."""
    hits, views, corners, listed, depths, counts = lists
    first, count = hits[h, FIRST], hits[h, COUNT]
    depth = least_depth(corners, first, count, views[h], axis, quad, sides, slack)
    if depth < np.inf and depth <= most:
        listed, depths = grown(listed, place + 1), grown(depths, place + 1)
        listed[place, 0], depths[place, 0] = h, depth
        place += 1
    return place, (hits, views, corners, listed, depths, counts)


@kernel
def _gather(
    facets, image, beam, rows, plane_before, place_of, axis, quad, sides, most, place, cut, lists
):
    """List the facets in a cell, down to a depth [m], from a place on; return its end, and lists.

    ``place_of`` names the hit of a facet that another cell has met, else -1.
    """
    work, clipped = cut
    node = np.int64(0)
    while node < len(facets.links):
        if box_is_off(facets.boxes, node, image, axis, sides, facets.slack, most) or (
            rows > 0 and box_is_outside(facets.boxes, node, image, beam, rows, facets.slack)
        ):
            node = facets.links[node, 0]
            continue
        at = facets.links[node, 1]
        for i in range(at, at + facets.links[node, 2]):
            facet = facets.order[i]
            if place_of[facet] < 0:
                if facets.plane[facet] == plane_before or not faces(facets, facet, image):
                    continue
                begin, end = facets.hull_start[facet], facets.hull_start[facet + 1]
                size = clip_to_beam(
                    facets.hulls, begin, end, image, beam, rows, facets.slack, work, clipped
                )
                if size == 0:
                    continue
                place_of[facet] = lists[5][0]
                lists = _add_hit(facets, facet, image, 1, clipped, 0, size, lists)
            place, lists = _list_hit(
                place_of[facet], place, axis, quad, sides, facets.slack, most, lists
            )
        node += 1
    return place, lists


@kernel
def _drop_covered(screens, most, begin, end, lists):
    """Keep what is not deeper than ``most``; return the list's end and whether it matters more."""
    hits, listed, depths = lists[0], lists[3], lists[4]
    kept, matters = begin, False
    nearest = begin
    for k in range(begin, end):
        if depths[k, 0] < depths[nearest, 0]:
            nearest = k
    # Nothing stands before the nearest.
    if nearest < end and not screens.is_large[hits[listed[nearest, 0], FACET]]:
        hits[listed[nearest, 0], SEEN] = 1
    for k in range(begin, end):
        if depths[k, 0] <= most:
            h = listed[k, 0]
            listed[kept, 0], depths[kept, 0] = h, depths[k, 0]
            kept += 1
            asked = hits[h, SEEN] == 0 or screens.is_large[hits[h, FACET]]
            matters = matters or (hits[h, WANTED] > 0 and asked)
    return kept, matters


@kernel
def _ask_each(screens, image, begin, end, quad, window, room, root, bounds, lists, cells):
    """Mark what is seen in a small cell; return the cells of large facets, with this one."""
    hits, views, corners, listed, depths, _ = lists
    cell_of, cell_bounds, n_cells = cells
    for k in range(begin, end):
        h = listed[k, 0]
        large = screens.is_large[hits[h, FACET]]
        if hits[h, WANTED] == 0 or (hits[h, SEEN] > 0 and not large):
            continue
        if any_left(
            screens, image, h, hits, views, corners, listed, depths, begin, end, quad, window, room
        ):
            hits[h, SEEN] = 1
            if large:
                cell_of = grown(cell_of, n_cells + 1)
                cell_bounds = grown(cell_bounds, n_cells + 1)
                cell_of[n_cells, 0], cell_of[n_cells, 1] = h, root
                cell_bounds[n_cells] = bounds
                n_cells += 1
    return cell_of, cell_bounds, n_cells


@kernel
def _push_quarters(stack, stack_bounds, top, level, begin, end, bounds):
    """Put the four quarters of a cell on the stack; return its new top."""
    middle_u, middle_v = 0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[2] + bounds[3])
    for part in range(4):
        stack[top, 0], stack[top, 1], stack[top, 2] = level + 1, begin, end
        stack_bounds[top, 0] = middle_u if part in (1, 2) else bounds[0]
        stack_bounds[top, 1] = bounds[1] if part in (1, 2) else middle_u
        stack_bounds[top, 2] = middle_v if part > 1 else bounds[2]
        stack_bounds[top, 3] = bounds[3] if part > 1 else middle_v
        top += 1
    return top


@kernel
def _fill_exit(image, beam, rows, plane_before, window):
    """Fill the plane that a beam leaves through: its normal, and the distance of the apex [m].

    A source's beam has none, so that all hides; one through a window too thin for sides has it
    nowhere known, so that nothing does.
    """
    window[:3], window[3] = 0.0, -np.inf if plane_before < 0 else np.inf
    if rows > 0:
        window[3] = beam[0, 3]
        for a in range(3):
            window[a] = beam[0, a]
            window[3] -= beam[0, a] * image[a]


@kernel
def _windows_seen(screens, image, large, axes, cells, place_of, facets, lists):
    """Return (k, 3) facet, first corner and corners of what is seen, and the corners [m]."""
    hits, corners, (n_hits, n_corners) = lists[0], lists[2], lists[5]
    for i in range(n_corners):
        for a in range(3):
            corners[i, a] += image[a]
    found, n_found = np.empty((max(n_hits - large, 1), 3), dtype=np.int64), np.int64(0)
    for h in range(large, n_hits):
        facet = hits[h, FACET]
        place_of[facet] = -1
        if hits[h, SEEN] > 0 and not screens.is_large[facet]:
            for k in range(3):
                found[n_found, k] = hits[h, k]
            n_found += 1
    return tracked_windows(
        image, facets.slack, hits, axes, cells, found, n_found, corners, n_corners
    )


@kernel
def seen_facets(
    facets, screens, image, beam, rows, window, begin, end, plane_before, place_of, scratch
):
    """Return the facets that a beam sees: (k, 3) windows, and the corners that it reaches of them.

    The beam leaves ``image`` through the polygon ``window[begin:end]`` of ``plane_before``; with no
    rows it goes into all directions. A window holds facet, first corner and number of corners;
    where little of a large facet is seen, it has several. ``place_of`` holds -1 per facet.
    """
    axes, bounds, quad, sides, exit_, stack, stack_bounds, cut, room = scratch
    lists = (
        np.empty((256, 5), dtype=np.int64),
        np.empty((256, 4)),
        np.empty((1024, 3)),
        np.empty((1024, 1), dtype=np.int64),
        np.empty((1024, 1)),
        (np.int64(0), np.int64(0)),
    )
    cells = np.empty((64, 2), dtype=np.int64), np.empty((64, 4)), np.int64(0)
    _fill_exit(image, beam, rows, plane_before, exit_)
    roots = first_cells(image, window, begin, end if rows > 0 else begin, axes, bounds)
    gathered_at = 0 if roots == 1 else GATHERED
    if gathered_at > 0:
        lists = _add_large(facets, screens, image, plane_before, lists)
    large = lists[5][0]
    own = np.empty(4)
    for root in range(roots):
        for a in range(4):
            wide = bounds[root, 1 + a - a % 2] - bounds[root, a - a % 2]
            stack_bounds[0, a] = bounds[root, a] + (2 * (a % 2) - 1) * _WIDER * (1.0 + wide)
        # At first the list holds the large facets, all of them.
        stack[0, 0], stack[0, 1], stack[0, 2] = 0, -large, 0
        top = 1
        while top > 0:
            top -= 1
            level, from_, to = stack[top, 0], stack[top, 1], stack[top, 2]
            for a in range(4):
                own[a] = stack_bounds[top, a]
            axis = axes[root, 0]
            fill_cell(axes[root], own, quad, sides)
            last = to
            for k in range(from_, to):
                h = k - from_ if k < 0 else lists[3][k, 0]
                last, lists = _list_hit(h, last, axis, quad, sides, facets.slack, np.inf, lists)
            cover = covered_from(screens, image, to, last, quad, exit_, room, lists)
            if level == gathered_at:
                last, lists = _gather(
                    facets,
                    image,
                    beam,
                    rows,
                    plane_before,
                    place_of,
                    axis,
                    quad,
                    sides,
                    cover,
                    to,
                    cut,
                    lists,
                )
                cover = min(cover, covered_from(screens, image, to, last, quad, exit_, room, lists))
            last, matters = _drop_covered(screens, cover, to, last, lists)
            if level < gathered_at or (
                matters and last - to > FEW and level - gathered_at < DEEPEST
            ):
                top = _push_quarters(stack, stack_bounds, top, level, to, last, own)
            elif matters:
                cells = _ask_each(
                    screens, image, to, last, quad, exit_, room, root, own, lists, cells
                )
    return _windows_seen(screens, image, large, axes, cells, place_of, facets, lists)


@kernel
def seen_scratch():
    """Return what :func:`seen_facets` works in, whatever the beam."""
    rows = 4 * (DEEPEST + GATHERED) + 8
    cut = np.empty((MAX_CORNERS + 4, 3)), np.empty((MAX_CORNERS + 4, 3))
    room = (
        np.empty((PIECES, PIECE_CORNERS, 3)),
        np.empty(PIECES, dtype=np.int64),
        (np.empty((PIECES, PIECE_CORNERS, 3)), np.empty(PIECES, dtype=np.int64)),
        (np.empty((PIECE_CORNERS + 4, 3)), np.empty((PIECE_CORNERS + 4, 3))),
        np.empty((MOST_EDGES, 3)),
        np.empty(4),
    )
    return (
        np.empty((6, 3, 3)),
        np.empty((6, 4)),
        np.empty((4, 3)),
        np.empty((4, 3)),
        np.empty(4),
        np.empty((rows, 3), dtype=np.int64),
        np.empty((rows, 4)),
        cut,
        room,
    )
