# mypy: allow-untyped-defs
"""Compiled kernels of the image search in scenes of very many facets."""

import numpy as np

from octant.em.search._beam_kernels import MAX_CORNERS, box_is_outside, copy_rows, make_beam
from octant.em.search._image_kernels import add_children
from octant.em.search._seen_kernels import seen_facets, seen_scratch
from octant.geometries._array_kernels import grown
from octant.geometries.kernels import kernel

MOST_WINDOWS = 32
"""Windows [-] of one facet that an image may have; one that would have more counts whole."""


@kernel(nogil=True)
def expand_seen(
    images,
    window_start,
    window_plane,
    window_corner_start,
    window_corners,
    facets,
    screens,
    keep_windows,
):
    """Return the children of every image, as `_image_kernels.expand` does, by what beams see."""
    children = np.empty((64, 2), dtype=np.int64)
    windows = np.empty((64, 3), dtype=np.int64)
    corners = np.empty((256, 3))
    counts = np.int64(0), np.int64(0), np.int64(0)
    beam = np.empty((MAX_CORNERS + 4, 5))
    place_of = np.full(len(facets.plane), -1, dtype=np.int64)
    scratch = seen_scratch()
    hits, reached = np.empty((256, 3), dtype=np.int64), np.empty((1024, 3))
    for n in range(len(images)):
        image = images[n]
        n_hits, n_reached = np.int64(0), np.int64(0)
        first, last = window_start[n], window_start[n + 1]
        at_source = first == last
        for w in range(first, last + 1 if at_source else last):
            rows, begin, end, plane_before = np.int64(0), np.int64(0), np.int64(0), np.int64(-1)
            if not at_source:
                plane_before = window_plane[w]
                begin, end = window_corner_start[w], window_corner_start[w + 1]
                rows = make_beam(image, window_corners, begin, end, facets.slack, beam)
            found, places = seen_facets(
                facets,
                screens,
                image,
                beam,
                rows,
                window_corners,
                begin,
                end,
                plane_before,
                place_of,
                scratch,
            )
            for h in range(len(found)):
                hits = grown(hits, n_hits + 1)
                reached = grown(reached, n_reached + found[h, 2])
                hits[n_hits, 0], hits[n_hits, 1], hits[n_hits, 2] = (
                    found[h, 0],
                    n_reached,
                    found[h, 2],
                )
                copy_rows(places, found[h, 1], found[h, 2], reached, n_reached)
                n_hits += 1
                n_reached += found[h, 2]
        children, windows, corners, counts = add_children(
            n,
            hits,
            n_hits,
            reached,
            facets.plane,
            facets.hull_start,
            facets.hulls,
            MOST_WINDOWS if keep_windows else 0,
            children,
            windows,
            corners,
            counts,
        )
    n_children, n_windows, n_corners = counts
    return children[:n_children].copy(), windows[:n_windows].copy(), corners[:n_corners].copy()


@kernel
def _holds_point(image, beam, rows, boxes, links, points, slack):
    """Return whether any point of a hierarchy lies in a beam, or within a few slacks of it."""
    node = np.int64(0)
    while node < len(links):
        if box_is_outside(boxes, node, image, beam, rows, slack):
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            if not box_is_outside(points, i, image, beam, rows, slack):
                return True
        node += 1
    return False


@kernel(nogil=True)
def hold_receivers(images, children, windows, corners, facets, boxes, links, points, slack):
    """Return (c,) bool, whether the beam of each child, through any window, holds a receiver.

    Children, windows and corners are those of `expand_seen` for these images. The receivers are
    boxes of no size, (m, 6), in the order of their hierarchy.
    """
    held = np.zeros(len(children), dtype=np.bool_)
    beam = np.empty((MAX_CORNERS + 4, 5))
    image = np.empty(3)
    begin = np.int64(0)
    for w in range(len(windows)):
        child, plane, end = windows[w, 0], windows[w, 1], begin + windows[w, 2]
        if not held[child]:
            height = -facets.plane_offset[plane]
            for a in range(3):
                image[a] = images[children[child, 0], a]
                height += facets.plane_normal[plane, a] * image[a]
            for a in range(3):
                image[a] -= 2.0 * height * facets.plane_normal[plane, a]
            rows = make_beam(image, corners, begin, end, facets.slack, beam)
            held[child] = _holds_point(image, beam, rows, boxes, links, points, slack)
        begin = end
    return held
