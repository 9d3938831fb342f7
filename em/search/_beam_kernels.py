# mypy: allow-untyped-defs
"""Compiled geometry of beams: hulls of facets, what a beam reaches of them, what hides them."""

import numpy as np

from octant.geometries._array_kernels import fill_order
from octant.geometries.kernels import kernel

MAX_CORNERS = 24
"""Greatest number of corners of a window; a window that would have more is left uncut there."""

MAX_OCCLUDERS = 16
"""Facets [-] of a beam, the widest seen from its image, asked whether they hide others."""


@kernel
def _turn(points, a, b, c):
    return (points[b, 0] - points[a, 0]) * (points[c, 1] - points[a, 1]) - (
        points[b, 1] - points[a, 1]
    ) * (points[c, 0] - points[a, 0])


@kernel
def _convex_hull(points, hull):
    """Fill ``hull`` with the rows of the hull's corners, counter-clockwise; return how many.

    Andrew's monotone chain (1979).
    """
    keys, by_second = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    order = np.empty(len(points), dtype=np.int64)
    for i in range(len(points)):
        keys[i] = points[i, 1]
    fill_order(keys, by_second)
    for i in range(len(points)):
        keys[i] = points[by_second[i], 0]
    fill_order(keys, order)
    for i in range(len(points)):
        order[i] = by_second[order[i]]
    size = 0
    for sweep in range(2):
        floor = size
        for k in range(len(order)):
            row = order[k] if sweep == 0 else order[len(order) - 1 - k]
            if size > floor:
                last = hull[size - 1]
                if points[last, 0] == points[row, 0] and points[last, 1] == points[row, 1]:
                    continue
            while size > floor + 1 and _turn(points, hull[size - 2], hull[size - 1], row) <= 0.0:
                size -= 1
            hull[size] = row
            size += 1
        size -= 1  # the last corner of one sweep is the first of the other
    return size


@kernel
def facet_hulls(outline_start, outline, fills):
    """Return the convex hull of each facet in its plane: start per facet, (v, 2) corners.

    A hull of many corners (a disc) is replaced by its bounding rectangle: a hull may be too large,
    never too small. ``fills`` tells whether the facet fills its hull.
    """
    facets = len(outline_start) - 1
    start = np.zeros(facets + 1, dtype=np.int64)
    corners = np.empty((2 * len(outline) + 4 * facets, 2))
    count = 0
    for f in range(facets):
        begin, end = outline_start[f], outline_start[f + 1]
        points = np.empty((2 * (end - begin), 2))
        for i in range(begin, end):
            for a in range(2):
                points[2 * (i - begin), a] = outline[i, a]
                points[2 * (i - begin) + 1, a] = outline[i, 2 + a]
        hull = np.empty(2 * len(points) + 2, dtype=np.int64)
        size = _convex_hull(points, hull)
        area, own = 0.0, 0.0
        for i in range(size):
            a, b = hull[i], hull[(i + 1) % size]
            area += 0.5 * (points[a, 0] * points[b, 1] - points[b, 0] * points[a, 1])
        for i in range(begin, end):
            own += 0.5 * (outline[i, 0] * outline[i, 3] - outline[i, 2] * outline[i, 1])
        fills[f] = size <= MAX_CORNERS // 2 and abs(area - own) <= 1e-9 * area
        if size > MAX_CORNERS // 2:
            u0, v0, u1, v1 = np.inf, np.inf, -np.inf, -np.inf
            for i in range(len(points)):
                u0, v0 = min(u0, points[i, 0]), min(v0, points[i, 1])
                u1, v1 = max(u1, points[i, 0]), max(v1, points[i, 1])
            for i in range(4):
                corners[count + i, 0] = u1 if i in (1, 2) else u0
                corners[count + i, 1] = v1 if i > 1 else v0
            size = 4
        else:
            for i in range(size):
                for a in range(2):
                    corners[count + i, a] = points[hull[i], a]
        count += size
        start[f + 1] = count
    return start, corners[:count].copy()


@kernel
def make_beam(image, window, begin, end, slack, beam):
    """Fill ``beam`` with the half-spaces of a beam and return how many there are.

    The beam leaves ``image`` through the convex polygon ``window[begin:end]`` and counts beyond it.
    Each row holds a normal, an offset and how near the image is to that side; the first row is the
    window's own plane. None without a reliable normal: then nothing is cut.
    """
    count = end - begin
    mx, my, mz = 0.0, 0.0, 0.0
    nx, ny, nz = 0.0, 0.0, 0.0
    for i in range(begin, end):
        j = i + 1 if i + 1 < end else begin
        mx += window[i, 0] / count
        my += window[i, 1] / count
        mz += window[i, 2] / count
        # Newell's sum, about the first corner to keep the digits.
        ax, ay, az = (
            window[i, 0] - window[begin, 0],
            window[i, 1] - window[begin, 1],
            window[i, 2] - window[begin, 2],
        )
        bx, by, bz = (
            window[j, 0] - window[begin, 0],
            window[j, 1] - window[begin, 1],
            window[j, 2] - window[begin, 2],
        )
        nx += ay * bz - az * by
        ny += az * bx - ax * bz
        nz += ax * by - ay * bx
    norm = np.sqrt(nx * nx + ny * ny + nz * nz)
    # A window thinner than the slack has no reliable normal.
    if norm < slack * slack:
        return 0
    nx, ny, nz = nx / norm, ny / norm, nz / norm
    if nx * (mx - image[0]) + ny * (my - image[1]) + nz * (mz - image[2]) < 0.0:
        nx, ny, nz = -nx, -ny, -nz
    beam[0, 0], beam[0, 1], beam[0, 2] = nx, ny, nz
    beam[0, 3] = nx * mx + ny * my + nz * mz
    beam[0, 4] = np.inf
    rows = 1
    for i in range(begin, end):
        j = i + 1 if i + 1 < end else begin
        ax, ay, az = window[i, 0] - image[0], window[i, 1] - image[1], window[i, 2] - image[2]
        bx, by, bz = window[j, 0] - image[0], window[j, 1] - image[1], window[j, 2] - image[2]
        sx, sy, sz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        norm = np.sqrt(sx * sx + sy * sy + sz * sz)
        if norm < slack * np.sqrt(ax * ax + ay * ay + az * az):
            continue
        sx, sy, sz = sx / norm, sy / norm, sz / norm
        if sx * (mx - image[0]) + sy * (my - image[1]) + sz * (mz - image[2]) < 0.0:
            sx, sy, sz = -sx, -sy, -sz
        beam[rows, 0], beam[rows, 1], beam[rows, 2] = sx, sy, sz
        beam[rows, 3] = sx * image[0] + sy * image[1] + sz * image[2]
        near = np.sqrt(min(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz))
        beam[rows, 4] = max(near, slack)
        rows += 1
    return rows


@kernel
def _give(beam, row, reach, slack):
    """Return by how much [m] a cut is widened, so that what is dropped cannot carry a path.

    The beam widens with distance: a corner of the window that is off by the slack moves the side of
    the beam further out there.
    """
    return slack * (1.0 + reach / beam[row, 4])


@kernel
def box_is_outside(boxes, node, image, beam, rows, slack):
    """Return whether a box lies wholly outside one side of a beam."""
    reach = 0.0
    for a in range(3):
        reach += max(abs(boxes[node, a] - image[a]), abs(boxes[node, 3 + a] - image[a]))
    for row in range(rows):
        most = -beam[row, 3] + _give(beam, row, reach, slack)
        for a in range(3):
            n = beam[row, a]
            most += n * (boxes[node, 3 + a] if n > 0.0 else boxes[node, a])
        if most < 0.0:
            return True
    return False


@kernel
def _cut(corners, count, nx, ny, nz, offset, slack, out):
    """Keep the part of a convex polygon where n . x >= offset - slack; return its corner count."""
    kept = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        a = nx * corners[i, 0] + ny * corners[i, 1] + nz * corners[i, 2] - offset + slack
        b = nx * corners[j, 0] + ny * corners[j, 1] + nz * corners[j, 2] - offset + slack
        if a >= 0.0:
            for k in range(3):
                out[kept, k] = corners[i, k]
            kept += 1
        if (a >= 0.0) != (b >= 0.0):
            t = a / (a - b)
            for k in range(3):
                out[kept, k] = corners[i, k] + t * (corners[j, k] - corners[i, k])
            kept += 1
    return kept


@kernel
def copy_rows(source, begin, count, target, place):
    """Copy ``count`` points from one array to another."""
    for i in range(count):
        for k in range(3):
            target[place + i, k] = source[begin + i, k]


@kernel
def clip_to_beam(hulls, begin, end, image, beam, rows, slack, work, out):
    """Return the corner count of the part of a hull that a beam can reach, written to ``out``."""
    count = end - begin
    copy_rows(hulls, begin, count, out, 0)
    for row in range(rows):
        if count < 3:
            return 0
        if count >= MAX_CORNERS:
            return count
        reach = 0.0
        for k in range(count):
            reach = max(
                reach,
                abs(out[k, 0] - image[0]) + abs(out[k, 1] - image[1]) + abs(out[k, 2] - image[2]),
            )
        kept = _cut(
            out,
            count,
            beam[row, 0],
            beam[row, 1],
            beam[row, 2],
            beam[row, 3],
            _give(beam, row, reach, slack),
            work,
        )
        copy_rows(work, 0, kept, out, 0)
        count = kept
    return count if count >= 3 else 0


@kernel
def hides(
    normal,
    offset,
    plane,
    hulls,
    begin,
    end,
    image,
    beam,
    rows,
    margin,
    target,
    target_begin,
    target_size,
):
    """Return whether a convex facet of ``plane`` stands before the whole of a target in a beam.

    Seen from the image, the target's outline is thrown onto the facet's plane. When every corner
    falls inside the facet, beyond the window and short of the target, all by the margin [m], then
    so does every ray between.
    """
    nx, ny, nz = normal[plane, 0], normal[plane, 1], normal[plane, 2]
    own = nx * image[0] + ny * image[1] + nz * image[2] - offset[plane]
    if abs(own) <= margin:
        return False
    turn = 1.0 if own > 0.0 else -1.0
    for k in range(target_begin, target_begin + target_size):
        x, y, z = target[k, 0], target[k, 1], target[k, 2]
        height = nx * x + ny * y + nz * z - offset[plane]
        if turn * height > -margin:
            return False
        t = own / (own - height)
        x, y, z = (
            image[0] + t * (x - image[0]),
            image[1] + t * (y - image[1]),
            image[2] + t * (z - image[2]),
        )
        if rows > 0 and beam[0, 0] * x + beam[0, 1] * y + beam[0, 2] * z - beam[0, 3] < margin:
            return False
        for i in range(begin, end):
            j = i + 1 if i + 1 < end else begin
            ex, ey, ez = (
                hulls[j, 0] - hulls[i, 0],
                hulls[j, 1] - hulls[i, 1],
                hulls[j, 2] - hulls[i, 2],
            )
            px, py, pz = x - hulls[i, 0], y - hulls[i, 1], z - hulls[i, 2]
            # Hulls run counter-clockwise about the plane's normal.
            inward = nx * (ey * pz - ez * py) + ny * (ez * px - ex * pz) + nz * (ex * py - ey * px)
            if inward < margin * np.sqrt(ex * ex + ey * ey + ez * ez):
                return False
    return True
