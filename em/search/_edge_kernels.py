# mypy: allow-untyped-defs
"""Compiled search over edges: what of them an image lights, and which planes reflect them next."""

import numpy as np

from octant.geometries._array_kernels import grown
from octant.geometries.kernels import kernel


@kernel
def _keep_above(lo, hi, value, slope, slack):
    """Return the part of lo..hi where value + slope t >= -slack."""
    if slope == 0.0:
        return (lo, hi) if value >= -slack else (1.0, 0.0)
    edge = (-slack - value) / slope
    if slope > 0.0:
        return max(lo, edge), hi
    return lo, min(hi, edge)


@kernel
def _beam_sides(image, hull, begin, end, slack, sides):
    """Fill the sides of a beam that leaves an image through a convex polygon; return how many.

    Each row holds a normal inwards and the least distance of the image from that side's corners.
    """
    mx, my, mz = 0.0, 0.0, 0.0
    for i in range(begin, end):
        mx, my, mz = mx + hull[i, 0], my + hull[i, 1], mz + hull[i, 2]
    n = end - begin
    mx, my, mz = mx / n - image[0], my / n - image[1], mz / n - image[2]
    rows = 0
    for i in range(begin, end):
        j = i + 1 if i + 1 < end else begin
        px, py, pz = hull[i, 0] - image[0], hull[i, 1] - image[1], hull[i, 2] - image[2]
        qx, qy, qz = hull[j, 0] - image[0], hull[j, 1] - image[1], hull[j, 2] - image[2]
        sx, sy, sz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        norm = np.sqrt(sx * sx + sy * sy + sz * sz)
        near = np.sqrt(min(px * px + py * py + pz * pz, qx * qx + qy * qy + qz * qz))
        if norm <= slack * near or near <= slack:
            continue
        sx, sy, sz = sx / norm, sy / norm, sz / norm
        if sx * mx + sy * my + sz * mz < 0.0:
            sx, sy, sz = -sx, -sy, -sz
        sides[rows, 0], sides[rows, 1], sides[rows, 2], sides[rows, 3] = sx, sy, sz, near
        rows += 1
    return rows


@kernel
def _box_is_dark(box, image, plane, side, sides, rows, slack):
    """Return whether a box lies before the plane of a beam, or outside one of its sides."""
    reach, ahead = 0.0, -side * plane[3]
    for a in range(3):
        reach += max(abs(box[a] - image[a]), abs(box[3 + a] - image[a]))
        n = side * plane[a]
        ahead += n * (box[3 + a] if n > 0.0 else box[a])
    # What is dropped here must be dark for any point within the box, rounding included.
    slack += 1e-12 * reach
    if ahead < -2.0 * slack:
        return True
    for row in range(rows):
        most = 0.0
        for a in range(3):
            n = sides[row, a]
            most += n * ((box[3 + a] if n > 0.0 else box[a]) - image[a])
        if most < -2.0 * slack * (1.0 + reach / sides[row, 3]):
            return True
    return False


@kernel
def _lit_through(image, plane, side, sides, rows, wedge, slack):
    """Return the part of an edge that a beam reaches behind the polygon that it leaves through.

    ``plane`` is the polygon's normal and offset; an empty part has its end before its start. The
    part may be too large by the slack, never too small.
    """
    ox, oy, oz = wedge[0], wedge[1], wedge[2]
    ax, ay, az = wedge[3], wedge[4], wedge[5]
    length = wedge[13]
    lo, hi = 0.0, length
    value = side * (plane[0] * ox + plane[1] * oy + plane[2] * oz - plane[3])
    slope = side * (plane[0] * ax + plane[1] * ay + plane[2] * az)
    lo, hi = _keep_above(lo, hi, value, slope, slack)
    reach = max(
        abs(ox - image[0]) + abs(oy - image[1]) + abs(oz - image[2]),
        abs(ox + length * ax - image[0])
        + abs(oy + length * ay - image[1])
        + abs(oz + length * az - image[2]),
    )
    for row in range(rows):
        if lo > hi:
            break
        sx, sy, sz, near = sides[row, 0], sides[row, 1], sides[row, 2], sides[row, 3]
        value = sx * (ox - image[0]) + sy * (oy - image[1]) + sz * (oz - image[2])
        slope = sx * ax + sy * ay + sz * az
        # A corner that is off by the slack moves the side of the beam further out behind it.
        lo, hi = _keep_above(lo, hi, value, slope, slack * (1.0 + reach / near))
    return lo, hi


@kernel
def _lies_in(plane, wedge, slack):
    """Return whether an edge lies in a plane, which then cannot show its image."""
    start = plane[0] * wedge[0] + plane[1] * wedge[1] + plane[2] * wedge[2] - plane[3]
    rise = (plane[0] * wedge[3] + plane[1] * wedge[4] + plane[2] * wedge[5]) * wedge[13]
    return abs(start) <= slack and abs(start + rise) <= slack


@kernel(nogil=True)
def light_edges(
    image,
    order,
    branch_start,
    branches,
    planes,
    plane_facet_start,
    hull_start,
    hulls,
    wedge_frame,
    boxes,
    links,
    wedge_order,
    begin,
    end,
    slack,
):
    """Return which part of which wedge's edge each image can light, and where the image stands.

    For images ``begin`` to ``end``: (k, 2) image and wedge; (k, 4) part from and to [m], the
    image's distance from the edge's line and its place along it [m]. The hierarchy is over the
    edges.
    """
    pairs = np.empty((256, 2), dtype=np.int64)
    found = np.empty((256, 4))
    count = 0
    wedges = len(wedge_frame)
    low, high = np.full(wedges, np.inf), np.full(wedges, -np.inf)
    met = np.arange(wedges)
    sides = np.empty((32, 4))
    for i in range(begin, end):
        n = wedges if order[i] == 0 else 0
        for b in range(branch_start[i], branch_start[i + 1]):
            plane = branches[b, 0]
            height = planes[plane, 0] * image[i, 0] + planes[plane, 1] * image[i, 1]
            height = height + planes[plane, 2] * image[i, 2] - planes[plane, 3]
            side = 1.0 if height < 0.0 else -1.0
            for facet in range(plane_facet_start[plane], plane_facet_start[plane + 1]):
                if hull_start[facet + 1] - hull_start[facet] > len(sides):
                    sides = np.empty((hull_start[facet + 1] - hull_start[facet], 4))
                rows = _beam_sides(
                    image[i], hulls, hull_start[facet], hull_start[facet + 1], slack, sides
                )
                node = np.int64(0)
                while node < len(links):
                    if _box_is_dark(boxes[node], image[i], planes[plane], side, sides, rows, slack):
                        node = links[node, 0]
                        continue
                    for k in range(links[node, 1], links[node, 1] + links[node, 2]):
                        w = wedge_order[k]
                        if _lies_in(planes[plane], wedge_frame[w], slack):
                            continue
                        lo, hi = _lit_through(
                            image[i], planes[plane], side, sides, rows, wedge_frame[w], slack
                        )
                        if lo <= hi:
                            if low[w] > high[w]:
                                met[n] = w
                                n += 1
                            low[w], high[w] = min(low[w], lo), max(high[w], hi)
                    node += 1
        for k in range(n):
            w = k if order[i] == 0 else met[k]
            lo, hi = (0.0, wedge_frame[w, 13]) if order[i] == 0 else (low[w], high[w])
            low[w], high[w] = np.inf, -np.inf
            sx, sy, sz = (
                image[i, 0] - wedge_frame[w, 0],
                image[i, 1] - wedge_frame[w, 1],
                image[i, 2] - wedge_frame[w, 2],
            )
            across = sx * wedge_frame[w, 6] + sy * wedge_frame[w, 7] + sz * wedge_frame[w, 8]
            up = sx * wedge_frame[w, 9] + sy * wedge_frame[w, 10] + sz * wedge_frame[w, 11]
            beside = np.sqrt(across * across + up * up)
            place = sx * wedge_frame[w, 3] + sy * wedge_frame[w, 4] + sz * wedge_frame[w, 5]
            if beside <= slack:
                if -slack <= place <= wedge_frame[w, 13] + slack:
                    continue  # the image stands on the edge itself
            else:
                # An image stands in one direction of an edge, wherever along it the ray arrives.
                angle = np.arctan2(up, across)
                if angle < 0.0:
                    angle += 2.0 * np.pi
                tolerance = 1e-7 + slack / beside
                if wedge_frame[w, 12] + tolerance < angle < 2.0 * np.pi - tolerance:
                    continue
            pairs, found = grown(pairs, count + 1), grown(found, count + 1)
            pairs[count, 0], pairs[count, 1] = i, w
            found[count, 0], found[count, 1] = lo, hi
            found[count, 2], found[count, 3] = beside, place
            count += 1
    return pairs[:count].copy(), found[:count].copy()


@kernel
def _reaches_above(corners, begin, end, plane, offset, turn, slack):
    """Return whether any corner lies over a plane, or under it when ``turn`` is -1."""
    for c in range(begin, end):
        height = plane[0] * corners[c, 0] + plane[1] * corners[c, 1] + plane[2] * corners[c, 2]
        if turn * (height - offset) > slack:
            return True
    return False


@kernel(nogil=True)
def planes_after(
    frame,
    wedge,
    last_plane,
    begin,
    end,
    wedge_frame,
    face_normals,
    planes,
    inner_side,
    corner_start,
    corners,
    slack,
):
    """Return (k, 2) edge image, of ``begin`` to ``end``, and plane that can reflect its rays next.

    ``last_plane`` is -1 where the ray comes from the edge itself. The corners of a plane's facets
    are ``corners[corner_start[p] : corner_start[p + 1]]``.
    """
    pairs = np.empty((1024, 2), dtype=np.int64)
    count = 0
    for i in range(begin, end):
        w, last = wedge[i], last_plane[i]
        length = wedge_frame[w, 13]
        wide = wedge_frame[w, 12] > np.pi
        start = frame[i, :3]
        first, second = 0.0, 0.0
        before, behind = np.inf, -np.inf
        if last < 0:
            for a in range(3):
                first += face_normals[w, 0, a] * start[a]
                second += face_normals[w, 1, a] * start[a]
        else:
            for e in range(2):
                height = -planes[last, 3]
                for a in range(3):
                    height += planes[last, a] * (start[a] + e * length * frame[i, 3 + a])
                before, behind = min(before, height), max(behind, height)
        for p in range(len(planes)):
            h, g = -planes[p, 3], 0.0
            for a in range(3):
                h += planes[p, a] * start[a]
                g += planes[p, a] * frame[i, 3 + a]
            g = h + length * g
            if p == last or max(abs(h), abs(g)) <= slack:
                continue
            side = inner_side[p]
            if side != 0 and max(side * h, side * g) <= slack:
                continue
            c, d = corner_start[p], corner_start[p + 1]
            if last < 0:
                over = _reaches_above(corners, c, d, face_normals[w, 0], first, 1.0, slack)
                if over == wide:
                    seen = over
                else:
                    seen = _reaches_above(corners, c, d, face_normals[w, 1], second, 1.0, slack)
            else:
                # The mirrored edge is behind the plane; what it reflects goes to the other side.
                own, offset = planes[last], planes[last, 3]
                seen = before < slack and _reaches_above(corners, c, d, own, offset, 1.0, slack)
                if not seen and behind > -slack:
                    seen = _reaches_above(corners, c, d, own, offset, -1.0, slack)
            if seen:
                pairs = grown(pairs, count + 1)
                pairs[count, 0], pairs[count, 1] = i, p
                count += 1
    return pairs[:count].copy()
