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

# Rows of the whole numbers: whether a receiver has its path, those left to the other search, what
# they differ in; and by depth: receiver, place in the list before, facet met there, doubts.
DONE, ODD, KIND = 0, 1, 2
LISTED = 3
LANE, BEHIND, FACET, DOUBT = 0, 1, 2, 3
ENTRY = 4

NODE, CURSOR, PLANE, BEGIN, COUNT, OPEN = 0, 1, 2, 3, 4, 5
"""Columns of the steps, one row per depth: the last three are where its list begins, how many are
on it, and how many of these still have no path."""

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
        np.empty(LISTS + depths * LIST),
        np.zeros((LISTED + ENTRY * depths, LANES), dtype=np.int64),
        np.zeros((depths, 6), dtype=np.int64),
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
def _extend(work, lists, depth, begin, count, one_facet):
    """Make the list behind one from those that met a facet and have no path yet; return its size.

    Without ``one_facet`` (-1) each has its own.
    """
    after = LISTS + (depth + 1) * LIST
    here, row = LISTED + ENTRY * depth, LISTED + ENTRY * (depth + 1)
    size = 0
    for j in range(count):
        code = int(work[CODE + j])
        lane = lists[here + LANE, begin + j]
        work[after + PX + size] = work[HX + j]
        work[after + PY + size] = work[HY + j]
        work[after + PZ + size] = work[HZ + j]
        lists[row + LANE, size] = lane
        lists[row + BEHIND, size] = begin + j
        lists[row + FACET, size] = one_facet if one_facet >= 0 else int(work[U + j])
        lists[row + DOUBT, size] = lists[here + DOUBT, begin + j] | (code & ~_HIT)
        size += (code & _HIT) & (1 - lists[DONE, lane])
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
def _keep(scene, bvh, tree, order, begin, count, block, whole, receiver, rows, first):
    """Write the paths of a list that has come to the source; return how many rows there are then.

    Receivers whose path touches something are left to the other search, in ``pending``.
    """
    work, lists, _, pending, _ = block
    state, points, facets, orders, _, touching = whole
    row = LISTED + ENTRY * order
    for j in range(count):
        place = begin + j
        lane, doubt = lists[row + LANE, place], lists[row + DOUBT, place] | int(work[CODE + j])
        for depth in range(order, -1, -1):
            at = LISTS + depth * LIST
            points[rows, depth, 0] = work[at + PX + place]
            points[rows, depth, 1] = work[at + PY + place]
            points[rows, depth, 2] = work[at + PZ + place]
            if depth > 0:
                facets[rows, depth - 1] = lists[LISTED + ENTRY * depth + FACET, place]
                place = lists[LISTED + ENTRY * depth + BEHIND, place]
        for a in range(3):
            points[rows, order + 1, a] = tree.image[0, a]
        plain = (doubt & (_RIM | _SHORT)) == 0
        if doubt & _NEAR:
            for depth in range(order):
                state[depth, STATE_PLANE] = scene.facet_plane[facets[rows, depth]]
            if not path_is_free(
                bvh.boxes,
                bvh.links,
                bvh.triangles,
                bvh.planes,
                bvh.margin,
                points,
                state,
                rows,
                order,
            ):
                continue
            plain = plain and not _touched(scene, bvh, points, facets, rows, order)
        lists[DONE, lane] = 1
        if plain:
            orders[rows] = order
            touching[rows] = 0
            receiver[rows] = first + lane
            rows += 1
        else:
            lists[ODD, pending[0]] = lane
            pending[0] += 1
    return rows


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
        if depth == order:
            for j in range(count):
                work[HX + j], work[HY + j], work[HZ + j] = image[0, 0], image[0, 1], image[0, 2]
                work[CODE + j] = 0.0
            _doubt(work, at_list, count, reach, near)
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
                lane = lists[LISTED + ENTRY * depth + LANE, first_place + j]
                if lists[DONE, lane] == 0:
                    lists[DONE, lane] = 1
                    lists[ODD, pending[0]] = lane
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
            work, at_list, count, planes, plane, image, here, image_height, box, tolerance
        )
        if hits == 0:
            continue
        if not plain:
            _place_on_facets(work, count, scene, plane)
        _doubt(work, at_list, count, reach, near)
        size = _extend(work, lists, depth, first_place, count, facet if plain else -1)
        if size == 0:
            continue
        depth += 1
        steps[depth, NODE], steps[depth, CURSOR] = tree.branches[branch, 1], 0
        steps[depth, PLANE], steps[depth, COUNT], steps[depth, OPEN] = plane, size, size
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
            lists[LISTED + LANE, size] = i - first
            lists[LISTED + DOUBT, size] = 0
            size += 1
    starts[_KINDS] = size


@kernel(forceinline=True)
def _write_paths(scene, tree, order, begin, count, block, whole, receiver, rows, first):
    """Return the number of rows once a part of the first list has its paths, of one way."""
    work, lists, _, _, (_, _, (_, _, way)) = block
    _, points, facets, orders, _, touching = whole
    planes, image = scene.planes, tree.image
    here = LISTS + begin
    for depth in range(order + 1):
        for a in range(3):
            for j in range(count):
                points[at(rows, j), depth, a] = work[at(here + a * LANES, j)]
        if depth < order:
            plane, node = way[depth, WAY_PLANE], way[depth, WAY_NODE]
            nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
            offset = planes[plane, 3]
            ix, iy, iz = image[node, 0], image[node, 1], image[node, 2]
            height = nx * ix + ny * iy + nz * iz - offset
            there = LISTS + (depth + 1) * LIST
            for j in range(count):
                px, py, pz = work[at(here + PX, j)], work[at(here + PY, j)], work[at(here + PZ, j)]
                _, hx, hy, hz = _pierced(px, py, pz, nx, ny, nz, offset, ix, iy, iz, height)
                work[at(there + PX, j)] = hx
                work[at(there + PY, j)] = hy
                work[at(there + PZ, j)] = hz
            here = there
            facet = way[depth, WAY_FACET]
            for j in range(count):
                facets[at(rows, j), depth] = facet
    for a in range(3):
        source = image[0, a]
        for j in range(count):
            points[at(rows, j), order + 1, a] = source
    for j in range(count):
        row = at(rows, j)
        orders[row], touching[row] = order, 0
        receiver[row] = first + lists[LISTED + LANE, at(begin, j)]
    return rows + count


@kernel
def _free_paths(scene, bvh, order, begin, end, block, whole, receiver, first):
    """Return where rows end of which those that are blocked, or touch something, are left out."""
    _, lists, _, pending, _ = block
    state, points, facets = whole[:3]
    for depth in range(order):
        state[depth, STATE_PLANE] = scene.facet_plane[facets[begin, depth]]
    rows = begin
    for row in range(begin, end):
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
            continue
        if _touched(scene, bvh, points, facets, row, order):
            lists[ODD, pending[0]] = receiver[row] - first
            pending[0] += 1
            continue
        if rows < row:
            receiver[rows] = receiver[row]
            for depth in range(order + 1):
                for a in range(3):
                    points[rows, depth, a] = points[row, depth, a]
        rows += 1
    return rows


@kernel(forceinline=True)
def _search_kind(scene, bvh, tree, leaf, kind, block, whole, receiver, rows, first):
    """Return the number of rows once the paths of an image to receivers of a kind are written."""
    _, _, steps, _, (starts, boxes, box) = block
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
    end = _write_paths(scene, tree, order, begin, count, block, whole, receiver, rows, first)
    if found == NEAR:
        return _free_paths(scene, bvh, order, rows, end, block, whole, receiver, first)
    return end


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
