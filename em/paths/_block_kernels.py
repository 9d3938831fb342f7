# mypy: allow-untyped-defs
"""Compiled search of the paths of one image to many receivers at once.

The images' search for one receiver, :func:`octant.em.paths._path_kernels.find_paths`, walks from
branch to branch and mostly waits for what it finds there. Here a branch serves a list of receivers:
its plane is pierced by all of their lines side by side, and those that meet one of its facets form
the list of the next branch. Arithmetic and order of trials are those of one receiver, so that the
decisions are the same to the bit. What is not plain, since it touches a rim or something else, is
left to the search for one receiver.

Before that, the box of all receivers is tried: mostly its corners show that all have the path of
one and the same way, or none.
"""

import numpy as np

from octant.em.paths._box_kernels import (
    NEAR,
    NO_PATH,
    UNSURE,
    WAY_FACET,
    WAY_NODE,
    WAY_PLANE,
    box_scratch,
    search_box,
)
from octant.em.paths._facet_kernels import ON_RIM, OUTSIDE, place_on_facet
from octant.em.paths._neighbour_kernels import TOUCHING, comes_first, touched
from octant.em.paths._path_kernels import PLANE as STATE_PLANE
from octant.em.paths._path_kernels import inside_supporting_planes, path_is_free, search_chunk
from octant.geometries._array_kernels import at
from octant.geometries.kernels import kernel

LANES = 128
"""Receivers [-] that an image is searched for at once: what they need fits the first-level caches.
"""

FEW = 8
"""Receivers [-] below which each is searched for by itself."""

ROOM = 128
"""Rows [-] kept free for the paths of one image that touch something, to one receiver."""

# Rows of LANES numbers in the work space: first what is computed of one plane, then lists by depth.
# One array with rows at fixed distances, since only then the compiler sees that they do not overlap
# and computes several receivers at once.
HX, HY, HZ, U, V, CODE = 0 * LANES, 1 * LANES, 2 * LANES, 3 * LANES, 4 * LANES, 5 * LANES
LISTS = 6 * LANES
PX, PY, PZ = 0 * LANES, 1 * LANES, 2 * LANES  # point of each receiver's path
LIST = 3 * LANES

# Rows of the whole numbers: the receivers in the order of the first list, what they differ in; of
# each place in that list whether it has its path; those left to the other search; and by depth:
# place in the first list, in the list before, facet met there, doubts.
LANE, KIND, DONE, ODD = 0, 1, 2, 3
LISTED = 4
SEAT, BEHIND, FACET, DOUBT = 0, 1, 2, 3
ENTRY = 4

NODE, CURSOR, PLANE, ONLY, BEGIN, COUNT, OPEN = 0, 1, 2, 3, 4, 5, 6
"""Columns of the steps, one row per depth: the image, its branches tried; the plane that led there
and its only facet, -1: one of several; where the list begins, how many are on it, and how many of
these still have no path."""

GROUP = 16
"""Lanes [-] that the compiler may compute at once: lists are computed in whole groups."""

_FALLING, _INSIDE, _KINDS = 1, 2, 4
"""Kinds of receivers, added up: who reads branches in falling order; who is in the room. Their
number."""

_HIT, _RIM, _SHORT, _NEAR = 1, 2, 4, 8
"""Codes, added up: met; on a rim; a leg of no length; a leg near what may block or touch it."""


@kernel
def block_scratch(max_order):
    """Return what :func:`search_block` works in."""
    depths = max_order + 2
    return (
        np.zeros(LISTS + depths * LIST + GROUP),
        np.zeros((LISTED + ENTRY * depths, LANES), dtype=np.int64),
        np.zeros((depths, 7), dtype=np.int64),
        np.zeros(2, dtype=np.int64),
        (np.zeros(_KINDS + 1, dtype=np.int64), np.empty((_KINDS, 6)), box_scratch(max_order)),
    )


@kernel(forceinline=True)
def _pierced(px, py, pz, nx, ny, nz, offset, ix, iy, iz, image_height):
    """Return a point's height over a plane, and where its line to an image pierces it."""
    height = nx * px + ny * py + nz * pz - offset
    t = max(height / (height - image_height), 0.0)
    return height, px + t * (ix - px), py + t * (iy - py), pz + t * (iz - pz)


@kernel
def _pierce(work, begin, count, planes, plane, image, node, image_height, box, tolerance):
    """Fill where the lines from a list of points to an image pierce a plane, and whether they do.

    ``box`` is that of the plane's facets. Returned is how many do.
    """
    nx, ny, nz, offset = planes[plane, 0], planes[plane, 1], planes[plane, 2], planes[plane, 3]
    ux, uy, uz = planes[plane, 4], planes[plane, 5], planes[plane, 6]
    vx, vy, vz = planes[plane, 7], planes[plane, 8], planes[plane, 9]
    ix, iy, iz = image[node, 0], image[node, 1], image[node, 2]
    side = 1.0 if image_height > 0.0 else -1.0
    u0, v0, u1, v1 = box
    hits = 0
    for j in range(count):
        px, py, pz = work[at(begin + PX, j)], work[at(begin + PY, j)], work[at(begin + PZ, j)]
        height, hx, hy, hz = _pierced(px, py, pz, nx, ny, nz, offset, ix, iy, iz, image_height)
        u = hx * ux + hy * uy + hz * uz
        v = hx * vx + hy * vy + hz * vz
        work[HX + j], work[HY + j], work[HZ + j], work[U + j], work[V + j] = hx, hy, hz, u, v
        hit = (
            (side * height <= tolerance)
            & (u0 - tolerance <= u)
            & (u <= u1 + tolerance)
            & (v0 - tolerance <= v)
            & (v <= v1 + tolerance)
        )
        rim = (
            (u < u0 + tolerance)
            | (v < v0 + tolerance)
            | (u > u1 - tolerance)
            | (v > v1 - tolerance)
        )
        work[CODE + j] = (float(_HIT) if hit else 0.0) + (float(_RIM) if rim else 0.0)
        hits += 1 if hit else 0
    return hits


@kernel
def _doubt(work, begin, count, reach, near):
    """Add to the codes what the legs from a list of points to those met are doubted for.

    ``near`` is the box of all that may block or touch a leg.
    """
    x0, y0, z0, x1, y1, z1 = near
    for j in range(count):
        px, py, pz = work[at(begin + PX, j)], work[at(begin + PY, j)], work[at(begin + PZ, j)]
        qx, qy, qz = work[HX + j], work[HY + j], work[HZ + j]
        leg = max(abs(qx - px), abs(qy - py), abs(qz - pz))
        apart = (
            (max(px, qx) < x0)
            | (max(py, qy) < y0)
            | (max(pz, qz) < z0)
            | (min(px, qx) > x1)
            | (min(py, qy) > y1)
            | (min(pz, qz) > z1)
        )
        short = 0.0 if leg > reach else float(_SHORT)
        work[CODE + j] += short + (0.0 if apart else float(_NEAR))


@kernel
def _place_on_facets(work, count, scene, plane):
    """Set the codes of points within the box of a plane's facets, of any outline."""
    for j in range(count):
        if int(work[CODE + j]) & _HIT == 0:
            continue
        work[CODE + j] = 0.0
        for facet in range(scene.plane_facet_start[plane], scene.plane_facet_start[plane + 1]):
            where = place_on_facet(
                scene.facet_box,
                scene.facet_outline,
                scene.outline,
                facet,
                work[U + j],
                work[V + j],
                scene.tolerance,
            )
            if where != OUTSIDE:
                work[CODE + j] = float(_HIT + (_RIM if where == ON_RIM else 0))
                work[U + j] = float(facet)
                break


@kernel(forceinline=True)
def _extend(work, lists, depth, begin, count, plain):
    """Make the list behind one from those that met a facet and have no path yet; return its size.

    Unless the plane is ``plain``, of one facet, each has its own.
    """
    after = LISTS + (depth + 1) * LIST
    here, row = LISTED + ENTRY * depth, LISTED + ENTRY * (depth + 1)
    size = 0
    for j in range(count):
        code = int(work[CODE + j])
        seat = lists[here + SEAT, begin + j]
        work[after + PX + size] = work[HX + j]
        work[after + PY + size] = work[HY + j]
        work[after + PZ + size] = work[HZ + j]
        lists[row + SEAT, size] = seat
        lists[row + BEHIND, size] = begin + j
        if not plain:
            lists[row + FACET, size] = int(work[U + j])
        lists[row + DOUBT, size] = lists[here + DOUBT, begin + j] | (code & ~_HIT)
        size += (code & _HIT) & (1 - lists[DONE, seat])
    return size


@kernel
def _touched(scene, bvh, points, facets, row, order):
    """Return whether a triangle touches a reflection of a path: what `touches` asks besides."""
    reach = TOUCHING * bvh.margin
    for i in range(order):
        plane = scene.facet_plane[facets[row, i]]
        if touched(
            bvh.boxes,
            bvh.links,
            bvh.triangles,
            bvh.planes,
            False,
            scene.facet_plane,
            plane,
            plane,
            points[row, i + 1, 0],
            points[row, i + 1, 1],
            points[row, i + 1, 2],
            reach,
        ):
            return True
    return False


@kernel
def _write_paths(scene, tree, order, count, block, whole, rows):
    """Write paths of one way, from the receivers in the list behind the last, which is free."""
    work, _, _, _, (_, _, (_, _, way)) = block
    _, points, facets, orders, _, touching = whole
    planes, image = scene.planes, tree.image
    here = LISTS + (order + 1) * LIST
    for k in range(order + 1):
        for a in range(3):
            for j in range(count):
                points[at(rows, j), k, a] = work[at(here + a * LANES, j)]
        if k < order:
            plane, node = way[k, WAY_PLANE], way[k, WAY_NODE]
            nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
            offset = planes[plane, 3]
            ix, iy, iz = image[node, 0], image[node, 1], image[node, 2]
            height = nx * ix + ny * iy + nz * iz - offset
            for j in range(count):
                px, py, pz = work[at(here + PX, j)], work[at(here + PY, j)], work[at(here + PZ, j)]
                _, hx, hy, hz = _pierced(px, py, pz, nx, ny, nz, offset, ix, iy, iz, height)
                work[at(here + PX, j)] = hx
                work[at(here + PY, j)] = hy
                work[at(here + PZ, j)] = hz
            facet = way[k, WAY_FACET]
            for j in range(count):
                facets[at(rows, j), k] = facet
    for a in range(3):
        source = image[0, a]
        for j in range(count):
            points[at(rows, j), order + 1, a] = source
    for j in range(count):
        row = at(rows, j)
        orders[row], touching[row] = order, 0


@kernel
def _free_paths(scene, bvh, order, depth, begin, count, doubt, block, whole, receiver, rows):
    """Return where rows end of which those that are blocked, or touch something, are left out.

    They are of one way and of a part of a list, all doubted for ``doubt`` at least. Receivers whose
    path touches something are left to the other search, in ``pending``.
    """
    _, lists, _, pending, (_, _, (_, _, way)) = block
    state, points, facets = whole[:3]
    listed, end = LISTED + ENTRY * depth, rows
    for k in range(order):
        state[k, STATE_PLANE] = way[k, WAY_PLANE]
    for j in range(count):
        row, seat = rows + j, lists[listed + SEAT, begin + j]
        why = doubt | lists[listed + DOUBT, begin + j]
        odd = why & (_RIM | _SHORT) != 0
        if why & _NEAR:
            if not path_is_free(
                bvh.boxes,
                bvh.links,
                bvh.triangles,
                bvh.planes,
                bvh.margin,
                points,
                state,
                row,
                order,
            ):
                lists[DONE, seat] = 0
                continue
            odd = odd or _touched(scene, bvh, points, facets, row, order)
        if odd:
            lists[ODD, pending[0]] = lists[LANE, seat]
            pending[0] += 1
            continue
        if end < row:
            receiver[end] = receiver[row]
            for k in range(order + 1):
                for a in range(3):
                    points[end, k, a] = points[row, k, a]
            for k in range(order):
                facets[end, k] = facets[row, k]
        end += 1
    return end


@kernel
def _keep(scene, bvh, tree, order, begin, count, block, whole, receiver, rows, first):
    """Write the paths of a list that has come to the source; return where rows end then."""
    work, lists, steps, _, (_, _, (_, _, way)) = block
    facets = whole[2]
    several = False
    for k in range(order):
        way[k, WAY_NODE], way[k, WAY_PLANE] = steps[k, NODE], steps[k + 1, PLANE]
        way[k, WAY_FACET] = steps[k + 1, ONLY]
        several = several or steps[k + 1, ONLY] < 0
    seats, spare = LISTED + ENTRY * order + SEAT, LISTS + (order + 1) * LIST
    for j in range(count):
        seat = lists[seats, begin + j]
        for a in range(3):
            work[at(spare + a * LANES, j)] = work[at(LISTS + a * LANES, seat)]
        receiver[rows + j] = first + lists[LANE, seat]
        lists[DONE, seat] = 1
    _write_paths(scene, tree, order, count, block, whole, rows)
    if several:
        for j in range(count):
            place = begin + j
            for k in range(order, 0, -1):
                if steps[k, ONLY] < 0:
                    facets[rows + j, k - 1] = lists[LISTED + ENTRY * k + FACET, place]
                place = lists[LISTED + ENTRY * k + BEHIND, place]
    row, doubt = LISTED + ENTRY * order + DOUBT, 0
    for j in range(count):
        lists[row, begin + j] |= int(work[CODE + j])
        doubt |= lists[row, begin + j]
    if doubt == 0:
        return rows + count
    return _free_paths(scene, bvh, order, order, begin, count, 0, block, whole, receiver, rows)


@kernel
def _search_image(scene, bvh, tree, leaf, falling, block, whole, receiver, rows, first):
    """Return the number of rows once the paths of one image to a list of receivers are written."""
    work, lists, steps, pending, _ = block
    planes, image, tolerance = scene.planes, tree.image, scene.tolerance
    reach = TOUCHING * bvh.margin
    near = (np.inf, np.inf, np.inf, -np.inf, -np.inf, -np.inf)
    if len(bvh.links) > 0:
        box = bvh.boxes[0]
        near = (
            box[0] - reach,
            box[1] - reach,
            box[2] - reach,
            box[3] + reach,
            box[4] + reach,
            box[5] + reach,
        )
    order = tree.order[leaf]
    depth = 0
    steps[0, NODE], steps[0, CURSOR], steps[0, PLANE] = leaf, 0, -1
    while depth >= 0:
        here, count = steps[depth, NODE], steps[depth, COUNT]
        first_place = steps[depth, BEGIN]
        at_list = LISTS + depth * LIST + first_place
        lanes = (count + GROUP - 1) // GROUP * GROUP
        if depth == order:
            for j in range(lanes):
                work[HX + j], work[HY + j], work[HZ + j] = image[0, 0], image[0, 1], image[0, 2]
                work[CODE + j] = 0.0
            _doubt(work, at_list, lanes, reach, near)
            before = rows + pending[0]
            rows = _keep(
                scene, bvh, tree, order, first_place, count, block, whole, receiver, rows, first
            )
            for k in range(depth + 1):
                steps[k, OPEN] -= rows + pending[0] - before
            depth -= 1
            continue
        tried = steps[depth, CURSOR]
        begin, end = tree.branch_start[here], tree.branch_start[here + 1]
        if tried == end - begin or steps[depth, OPEN] == 0:
            depth -= 1
            continue
        steps[depth, CURSOR] = tried + 1
        branch = end - 1 - tried if falling else begin + tried
        plane = tree.branches[branch, 0]
        # Merged images join branches of which some repeat the plane just used.
        if plane == steps[depth, PLANE]:
            continue
        image_height = (
            planes[plane, 0] * image[here, 0]
            + planes[plane, 1] * image[here, 1]
            + planes[plane, 2] * image[here, 2]
            - planes[plane, 3]
        )
        if abs(image_height) <= tolerance:
            for j in range(count):
                seat = lists[LISTED + ENTRY * depth + SEAT, first_place + j]
                if lists[DONE, seat] == 0:
                    lists[DONE, seat] = 1
                    lists[ODD, pending[0]] = lists[LANE, seat]
                    pending[0] += 1
            for k in range(depth):
                steps[k, OPEN] -= steps[depth, OPEN]
            depth -= 1
            continue
        facet, last = scene.plane_facet_start[plane], scene.plane_facet_start[plane + 1]
        plain = last == facet + 1 and scene.facet_outline[facet, 0] == scene.facet_outline[facet, 1]
        box = (np.inf, np.inf, -np.inf, -np.inf)
        for each in range(facet, last):
            box = (
                min(box[0], scene.facet_box[each, 0]),
                min(box[1], scene.facet_box[each, 1]),
                max(box[2], scene.facet_box[each, 2]),
                max(box[3], scene.facet_box[each, 3]),
            )
        hits = _pierce(
            work, at_list, lanes, planes, plane, image, here, image_height, box, tolerance
        )
        if hits == 0:
            continue
        if not plain:
            _place_on_facets(work, count, scene, plane)
        _doubt(work, at_list, lanes, reach, near)
        size = _extend(work, lists, depth, first_place, count, plain)
        if size == 0:
            continue
        depth += 1
        steps[depth, NODE], steps[depth, CURSOR] = tree.branches[branch, 1], 0
        steps[depth, PLANE], steps[depth, ONLY] = plane, facet if plain else -1
        steps[depth, COUNT], steps[depth, OPEN] = size, size
    return rows


@kernel
def _sort_receivers(scene, source, places, first, last, block):
    """Make the first list, of all receivers by kind; fill where kinds begin, and their boxes."""
    work, lists, _, _, (starts, boxes, _) = block
    within = inside_supporting_planes(scene.supporting, source[0], source[1], source[2])
    for i in range(first, last):
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        kind = _FALLING if comes_first(x, y, z, source[0], source[1], source[2]) else 0
        if within and inside_supporting_planes(scene.supporting, x, y, z):
            kind += _INSIDE
        lists[KIND, i - first] = kind
    size = 0
    for kind in range(_KINDS):
        starts[kind] = size
        for a in range(3):
            boxes[kind, a], boxes[kind, 3 + a] = np.inf, -np.inf
        for i in range(first, last):
            if lists[KIND, i - first] != kind:
                continue
            for a in range(3):
                work[LISTS + a * LANES + size] = places[i, a]
                boxes[kind, a] = min(boxes[kind, a], places[i, a])
                boxes[kind, 3 + a] = max(boxes[kind, 3 + a], places[i, a])
            lists[LANE, size] = i - first
            lists[LISTED + SEAT, size], lists[LISTED + DOUBT, size] = size, 0
            size += 1
    starts[_KINDS] = size


@kernel(forceinline=True)
def _search_kind(scene, bvh, tree, leaf, kind, block, whole, receiver, rows, first):
    """Return the number of rows once the paths of an image to receivers of a kind are written."""
    work, lists, steps, _, (starts, boxes, box) = block
    begin, count = starts[kind], starts[kind + 1] - starts[kind]
    found = search_box(
        scene,
        bvh.boxes,
        bvh.links,
        bvh.triangles,
        bvh.planes,
        bvh.margin,
        tree,
        leaf,
        kind & _FALLING,
        boxes,
        kind,
        box,
    )
    if found == UNSURE:
        steps[0, BEGIN], steps[0, COUNT], steps[0, OPEN] = begin, count, count
        return _search_image(
            scene, bvh, tree, leaf, kind & _FALLING, block, whole, receiver, rows, first
        )
    if found == NO_PATH:
        return rows
    order = tree.order[leaf]
    spare = LISTS + (order + 1) * LIST
    for a in range(3):
        for j in range(count):
            work[at(spare + a * LANES, j)] = work[at(LISTS + a * LANES + begin, j)]
    for j in range(count):
        receiver[at(rows, j)] = first + lists[LANE, at(begin, j)]
    _write_paths(scene, tree, order, count, block, whole, rows)
    if found == NEAR:
        return _free_paths(scene, bvh, order, 0, begin, count, _NEAR, block, whole, receiver, rows)
    return rows + count


@kernel(returns="UniTuple(int64, 2)")
def search_block(scene, tree, places, first, last, image, block, whole, receiver):
    """Return the number of paths to the receivers first to last from a leaf on, and the next one.

    Row by row, as `search_chunk` has them for one receiver, with the number of each in
    ``receiver``. A receiver's paths come in the order of images.
    """
    _, lists, _, pending, (starts, _, _) = block
    state, orders = whole[0], whole[3]
    state[len(state) - 1, :] = -1
    if image == 0 and pending[0] == 0:
        _sort_receivers(scene, tree.image[0], places, first, last, block)
    rows = np.int64(0)
    while image < len(tree.leaves):
        while pending[1] < pending[0]:
            if len(orders) - rows < ROOM:
                return rows, image
            i = first + lists[ODD, pending[1]]
            pending[1] += 1
            end = search_chunk(
                scene, tree, places[i, 0], places[i, 1], places[i, 2], image, image + 1, rows, whole
            )
            receiver[rows:end] = i
            rows = end
        if pending[0] > 0:
            pending[:] = 0
            image += 1
            continue
        if len(orders) - rows < ROOM + LANES:
            return rows, image
        lists[DONE, : last - first] = 0
        leaf = tree.leaves[image]
        for kind in range(_INSIDE):
            if starts[kind] < starts[kind + 1]:
                rows = _search_kind(
                    scene, scene.bvh, tree, leaf, kind, block, whole, receiver, rows, first
                )
        for kind in range(_INSIDE, _KINDS):
            if starts[kind] < starts[kind + 1]:
                rows = _search_kind(
                    scene, scene.inner_bvh, tree, leaf, kind, block, whole, receiver, rows, first
                )
        if pending[0] == 0:
            image += 1
    return rows, image
