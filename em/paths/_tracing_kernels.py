# mypy: allow-untyped-defs
"""Compiled tracing: all paths from a source to a receiver, chunk by chunk, over walls and edges."""

import numpy as np

from octant.em.paths._edge_path_kernels import search_edges
from octant.em.paths._path_kernels import make_scratch, search_chunk
from octant.em.paths._transmission_kernels import insert_crossings
from octant.em.records import CHUNK
from octant.geometries.kernels import kernel


@kernel
def tracing_scratch(scene, tree, edges):
    """Return what :func:`next_paths` works in: a set for whole paths, one for their first parts.

    The third holds those paths of one receiver that touch something at an edge.
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
    before = (
        np.empty((longest + 3, 4), dtype=np.int64),
        np.empty((longest + 2, 3)),
        chain_order,
        chain_branches,
        np.empty((rows, longest + 2, 3)),
        np.empty((rows, longest + 1), dtype=np.int64),
        np.empty(rows, dtype=np.int64),
    )
    met = (
        np.empty((CHUNK, longest + 2, 3)),
        np.empty((CHUNK, longest + 1), dtype=np.int64),
        np.empty(CHUNK, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
    )
    return whole, before, met


@kernel
def tracing_steps(scene, tree, edges):
    """Return images per chunk, images, and the place at which a receiver's paths are all found."""
    step = max(1, CHUNK // tree.ways) if scene.transmits else CHUNK
    return step, len(tree.order), len(tree.order) + len(edges.wedge)


@kernel(forceinline=True)
def next_paths(scene, tree, edges, x, y, z, place, step, images, scratch):
    """Return the number of paths of one more chunk from ``place`` on, and the place after it.

    Images of the source come first, ``step`` at a time, those of the edges behind them.
    """
    whole, before, met = scratch
    points, facets, orders, near, touching = whole[1:]
    if place < images:
        last = min(place + step, images)
        found = search_chunk(scene, tree, x, y, z, place, last, whole)
        place = last
    else:
        found, reached = search_edges(
            scene, tree, edges, x, y, z, place - images, before, met, whole
        )
        place = images + reached
    if scene.transmits:
        found = insert_crossings(scene, found, points, facets, orders, near, touching)
    return found, place


@kernel(nogil=True)
def record_paths(scene, tree, edges, receivers, start, order, vertices, codes, counts):
    """Return the greatest number of interactions; count each receiver's paths, record what fits.

    The paths of receiver i fit between start[i] and start[i + 1]. Vertices run from source to
    receiver. Those that a short path does not need repeat the receiver; its codes end in -1s, which
    ``order`` tells from a diffraction at wedge 0.
    """
    scratch = tracing_scratch(scene, tree, edges)
    points, facets, orders = scratch[0][1], scratch[0][2], scratch[0][3]
    step, images, everything = tracing_steps(scene, tree, edges)
    longest = 0
    for i in range(len(receivers)):
        x, y, z = receivers[i, 0], receivers[i, 1], receivers[i, 2]
        counts[i] = 0
        place = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
        while place < everything:
            found, place = next_paths(scene, tree, edges, x, y, z, place, step, images, scratch)
            for p in range(found):
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
