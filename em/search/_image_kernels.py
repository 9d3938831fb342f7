# mypy: allow-untyped-defs
"""Compiled kernel of the image search: which planes can follow which image."""

import numpy as np

from octant.em.search._beam_kernels import (
    MAX_CORNERS,
    MAX_OCCLUDERS,
    box_is_outside,
    clip_to_beam,
    copy_rows,
    hides,
    make_beam,
)
from octant.geometries._array_kernels import fill_order, grown
from octant.geometries.kernels import kernel


@kernel
def _faces(image, facet, facet_plane, facet_side, plane_normal, plane_offset, slack):
    """Return whether an image lies off a facet's plane, on a side on which the facet reflects."""
    plane = facet_plane[facet]
    height = (
        plane_normal[plane, 0] * image[0]
        + plane_normal[plane, 1] * image[1]
        + plane_normal[plane, 2] * image[2]
        - plane_offset[plane]
    )
    return abs(height) > slack and height * facet_side[facet] >= 0.0


@kernel
def _widest(image, hits, begin, end, occluder_area, hulls, hull_start, weight, chosen):
    """Fill ``chosen`` with the occluders among hits that look widest; return how many.

    The first of equals is taken, so that the choice depends on nothing but the beam.
    """
    for h in range(begin, end):
        facet = hits[h, 0]
        weight[h] = 0.0
        if occluder_area[facet] > 0.0:
            distance2 = 0.0
            for a in range(3):
                distance2 += (hulls[hull_start[facet], a] - image[a]) ** 2
            weight[h] = occluder_area[facet] / max(distance2, 1e-300)
    count = 0
    while count < MAX_OCCLUDERS:
        best = -1
        for h in range(begin, end):
            if weight[h] > 0.0 and (best < 0 or weight[h] > weight[best]):
                best = h
        if best < 0:
            break
        chosen[count] = hits[best, 0]
        weight[best] = 0.0
        count += 1
    return count


@kernel
def add_children(
    n,
    hits,
    n_hits,
    reached,
    facet_plane,
    hull_start,
    hulls,
    most_windows,
    children,
    windows,
    corners,
    counts,
):
    """Add the children of image ``n`` that reach its hits (facet, first corner, corners).

    A facet that more than ``most_windows`` hits light counts whole; with 0 no window is kept.
    Returns the arrays, larger where they have to be, and how many rows of each are used.
    """
    n_children, n_windows, n_corners = counts
    keys, order = np.empty(n_hits), np.empty(n_hits, dtype=np.int64)
    for h in range(n_hits):
        keys[h] = hits[h, 0]
    fill_order(keys, order)
    plane_done = -1
    h = 0
    while h < n_hits:
        hit = order[h]
        facet = hits[hit, 0]
        plane = facet_plane[facet]
        times = 1
        while h + times < n_hits and hits[order[h + times], 0] == facet:
            times += 1
        h += times
        if plane != plane_done:
            children = grown(children, n_children + 1)
            children[n_children, 0] = n
            children[n_children, 1] = plane
            n_children += 1
            plane_done = plane
        if most_windows == 0:
            continue
        whole = times > most_windows
        for w in range(1 if whole else times):
            hit = order[h - times + w]
            size = hits[hit, 2]
            if whole:
                size = hull_start[facet + 1] - hull_start[facet]
            windows = grown(windows, n_windows + 1)
            corners = grown(corners, n_corners + size)
            windows[n_windows, 0] = n_children - 1
            windows[n_windows, 1] = plane
            windows[n_windows, 2] = size
            if whole:
                copy_rows(hulls, hull_start[facet], size, corners, n_corners)
            else:
                copy_rows(reached, hits[hit, 1], size, corners, n_corners)
            n_windows += 1
            n_corners += size
    return children, windows, corners, (n_children, n_windows, n_corners)


@kernel(nogil=True)
def expand(
    images,
    window_start,
    window_plane,
    window_corner_start,
    window_corners,
    plane_normal,
    plane_offset,
    facet_plane,
    facet_side,
    occluder_area,
    hull_start,
    hulls,
    boxes,
    links,
    facet_order,
    slack,
    margin,
    keep_windows,
):
    """Return the children of every image: which planes its beam can be reflected by next.

    Parameters: (n, 3) images; the windows of image i from ``window_start[i]``, each with its plane
    and its corners; the planes; per facet its plane, +1 or -1 when it reflects on that side only,
    else 0, its area when it is convex and opaque, else 0, and its hull; the hierarchy over the
    hulls; the slack [m] of cuts and the margin [m] of hiding.

    Returns: (c, 2) parent image and plane of each child; (w, 3) child, plane and corner count of
    each window; (v, 3) corners of the windows.
    """
    children = np.empty((64, 2), dtype=np.int64)
    windows = np.empty((64, 3), dtype=np.int64)
    corners = np.empty((256, 3))
    counts = np.int64(0), np.int64(0), np.int64(0)
    work = np.empty((MAX_CORNERS + 4, 3))
    clipped = np.empty((MAX_CORNERS + 4, 3))
    beam = np.empty((MAX_CORNERS + 4, 5))
    hits = np.empty((256, 3), dtype=np.int64)  # facet, first corner, corners
    reached = np.empty((1024, 3))
    weight = np.empty(256)
    chosen = np.empty(MAX_OCCLUDERS, dtype=np.int64)
    for n in range(len(images)):
        image = images[n]
        # Typed, so that what takes them is not compiled for literal zeros too.
        n_hits, n_reached = np.int64(0), np.int64(0)
        first_window, last_window = window_start[n], window_start[n + 1]
        at_source = first_window == last_window
        for w in range(first_window, last_window + 1 if at_source else last_window):
            rows, plane_before = 0, -1
            if not at_source:
                plane_before = window_plane[w]
                rows = make_beam(
                    image,
                    window_corners,
                    window_corner_start[w],
                    window_corner_start[w + 1],
                    slack,
                    beam,
                )
            before = n_hits
            node = np.int64(0)
            while node < len(links):
                if rows > 0 and box_is_outside(boxes, node, image, beam, rows, slack):
                    node = links[node, 0]
                    continue
                for i in range(links[node, 1], links[node, 1] + links[node, 2]):
                    facet = facet_order[i]
                    if facet_plane[facet] == plane_before or not _faces(
                        image, facet, facet_plane, facet_side, plane_normal, plane_offset, slack
                    ):
                        continue
                    count = clip_to_beam(
                        hulls,
                        hull_start[facet],
                        hull_start[facet + 1],
                        image,
                        beam,
                        rows,
                        slack,
                        work,
                        clipped,
                    )
                    if count == 0:
                        continue
                    hits = grown(hits, n_hits + 1)
                    reached = grown(reached, n_reached + count)
                    copy_rows(clipped, 0, count, reached, n_reached)
                    hits[n_hits, 0] = facet
                    hits[n_hits, 1] = n_reached
                    hits[n_hits, 2] = count
                    n_hits += 1
                    n_reached += count
                node += 1
            if len(weight) < len(hits):
                weight = np.empty(len(hits))
            occluders = 0
            if at_source or rows > 0:
                occluders = _widest(
                    image, hits, before, n_hits, occluder_area, hulls, hull_start, weight, chosen
                )
            seen = before
            for h in range(before, n_hits):
                facet, hidden = hits[h, 0], False
                for c in range(occluders):
                    other = chosen[c]
                    plane = facet_plane[other]
                    if plane == facet_plane[facet] or plane == plane_before:
                        continue
                    if hides(
                        plane_normal,
                        plane_offset,
                        plane,
                        hulls,
                        hull_start[other],
                        hull_start[other + 1],
                        image,
                        beam,
                        rows,
                        margin,
                        reached,
                        hits[h, 1],
                        hits[h, 2],
                    ):
                        hidden = True
                        break
                if not hidden:
                    for k in range(3):
                        hits[seen, k] = hits[h, k]
                    seen += 1
            n_hits = seen
        children, windows, corners, counts = add_children(
            n,
            hits,
            n_hits,
            reached,
            facet_plane,
            hull_start,
            hulls,
            1 if keep_windows else 0,
            children,
            windows,
            corners,
            counts,
        )
    n_children, n_windows, n_corners = counts
    return children[:n_children].copy(), windows[:n_windows].copy(), corners[:n_corners].copy()
