# mypy: allow-untyped-defs
"""Compiled tracing: all paths from a source to receivers, chunk by chunk, over walls and edges."""

import numpy as np

from octant.em.paths._block_kernels import FEW, LANES, block_scratch, search_block
from octant.em.paths._edge_path_kernels import search_edges
from octant.em.paths._path_kernels import make_scratch, path_rows, search_chunk
from octant.em.paths._transmission_kernels import insert_crossings
from octant.em.records import CHUNK
from octant.geometries.kernels import kernel

MET = 4096
"""Paths of one receiver [-] that touch something at an edge and are kept to find copies of them: of
more, the latest. Both ends level with furniture meet hundreds in three reflections."""


@kernel
def tracing_scratch(scene, tree, edges):
    """Return what :func:`next_paths` works in.

    A set for whole paths, one for their first parts, those paths of one receiver that touch
    something at an edge, the lists of many receivers, and the receiver of each whole path.
    """
    whole = make_scratch(
        max(tree.max_order, edges.max_order), tree.ways, scene.transmits, edges.rows
    )
    # The way before an edge comes from one image, so from few paths; that behind it is one chain
    # of images, each the parent of the next.
    rows, longest = edges.ways + 1, max(tree.max_order, edges.max_order)
    # Image i of the chain has i reflections, and its only branch has the number i.
    chain_branches = np.empty((longest + 2, 2), dtype=np.int64)
    chain_order = np.empty(longest + 3, dtype=np.int64)
    for i in range(longest + 3):
        chain_order[i] = i
    for i in range(longest + 2):
        chain_branches[i, 1] = i - 1
    before_points, before_facets = path_rows(rows, longest)
    before = (
        np.empty((longest + 3, 4), dtype=np.int64),
        np.empty((longest + 2, 3)),
        chain_order,
        chain_branches,
        before_points,
        before_facets,
        np.empty(rows, dtype=np.int64),
    )
    met = (
        np.empty((MET, longest + 2, 3)),
        np.empty((MET, longest + 1), dtype=np.int64),
        np.empty(MET, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
    )
    receiver = np.empty(len(whole[3]), dtype=np.int64)
    return whole, before, met, block_scratch(tree.max_order), receiver


@kernel
def traced_at_once(scene, count):
    """Return how many of so many receivers :func:`next_paths` takes at a time."""
    return 1 if scene.transmits or count < FEW else min(count, np.int64(LANES))


@kernel
def tracing_end(tree, edges, first, last):
    """Return the place at which all paths to the receivers first to last are found."""
    return len(tree.leaves) + (last - first) * len(edges.wedge)


@kernel(returns="UniTuple(int64, 2)")
def next_paths(scene, tree, edges, places, first, last, place, scratch):
    """Return the number of paths of one more chunk from ``place`` on, and the place after it.

    Images of the source come first, those of the edges behind them, for one receiver after the
    other. A receiver's paths come in one order, however many receivers there are.
    """
    whole, before, met, block, receiver = scratch
    points, facets, orders, near, touching = whole[1:]
    images, wedges = len(tree.leaves), len(edges.wedge)
    if place < images and last - first > 1:
        return search_block(scene, tree, places, first, last, place, block, whole, receiver)
    i = first if place < images else first + (place - images) // wedges
    x, y, z = places[i, 0], places[i, 1], places[i, 2]
    if place < images:
        step = max(1, CHUNK // tree.ways) if scene.transmits else CHUNK
        end = min(place + step, images)
        found = search_chunk(scene, tree, x, y, z, place, end, np.int64(0), whole)
        place = end
    else:
        begin = (place - images) % wedges
        found, reached = search_edges(scene, tree, edges, x, y, z, begin, before, met, whole)
        place += reached - begin
    if scene.transmits:
        found = insert_crossings(scene, found, points, facets, orders, near, touching)
    receiver[:found] = i
    return found, place


@kernel(nogil=True)
def record_paths(scene, tree, edges, receivers, start, order, vertices, codes, counts):
    """Return the greatest number of interactions; count each receiver's paths, record what fits.

    The paths of receiver i fit between start[i] and start[i + 1]. Vertices run from source to
    receiver. Those that a short path does not need repeat the receiver; its codes end in -1s, which
    ``order`` tells from a diffraction at wedge 0.
    """
    scratch = tracing_scratch(scene, tree, edges)
    points, facets, orders, receiver = scratch[0][1], scratch[0][2], scratch[0][3], scratch[4]
    longest = 0
    counts[:] = 0
    step = traced_at_once(scene, len(receivers))
    for first in range(0, len(receivers), step):
        last = min(first + step, len(receivers))
        everything = tracing_end(tree, edges, first, last)
        place = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
        while place < everything:
            found, place = next_paths(scene, tree, edges, receivers, first, last, place, scratch)
            for p in range(found):
                i = receiver[p]
                row = start[i] + counts[i]
                counts[i] += 1
                n = orders[p]
                longest = max(longest, n)
                if row >= start[i + 1]:
                    continue
                order[row] = n
                for k in range(vertices.shape[1]):
                    for a in range(3):
                        vertices[row, k, a] = points[p, max(n + 1 - k, 0), a]
                for k in range(codes.shape[1]):
                    codes[row, k] = facets[p, n - 1 - k] if k < n else -1
    return longest
