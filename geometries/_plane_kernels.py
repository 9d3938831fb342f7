# mypy: allow-untyped-defs
"""Compiled kernels that weld vertices and gather triangles into planes."""

import numpy as np

from octant.geometries.kernels import kernel

REACH = 8.0
"""Greatest factor [-] by which rounding may grow where a plane is carried beyond its triangles."""

CLOSE = 3.0
"""The same factor [-] where one piece of a plane is held against another that does not touch it."""

LIKE_DIRECTION = 0.9998
"""Least cosine [-] between the normals of triangles of one plane: 0.02 rad."""

LEVELS = 4
FINEST = 1e-5
COARSER = 10.0
"""Cells of plane space: ``LEVELS`` sizes from ``FINEST`` [rad] up, by factors of ``COARSER``."""

MAX_CANDIDATES = 64
"""Planes [-] that a region is compared with before it is taken as a plane of its own."""


@kernel
def _root(parent, i):
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@kernel
def join(parent, i, j):
    """Join the sets of i and j under the lesser root."""
    a, b = _root(parent, i), _root(parent, j)
    if a < b:
        parent[b] = a
    elif b < a:
        parent[a] = b


@kernel
def roots(parent):
    """Replace every entry by the least member of its set."""
    for i in range(len(parent)):
        parent[i] = _root(parent, i)


@kernel
def weld(points, order, height, tolerance, slack, parent):
    """Join points (n, 3) within ``tolerance`` of one another in ``parent``.

    ``order`` sorts the points by ``height``, their place along one direction, which is known to
    within ``slack``. Of points at the same place each hands its search on to the next.
    """
    n = len(order)
    for i in range(n):
        p = order[i]
        for k in range(i + 1, n):
            q = order[k]
            if height[q] - height[p] > tolerance + slack:
                break
            dx, dy, dz = (
                points[p, 0] - points[q, 0],
                points[p, 1] - points[q, 1],
                points[p, 2] - points[q, 2],
            )
            distance2 = dx * dx + dy * dy + dz * dz
            if distance2 <= tolerance * tolerance:
                join(parent, p, q)
                if distance2 == 0.0:
                    break
    roots(parent)


@kernel
def _spread(x, y, z, sums, plane):
    """Add one corner to the sums of a region: count, first and second moments about its centre."""
    x, y, z = x - plane[0], y - plane[1], z - plane[2]
    sums[0] += 1.0
    sums[1] += x
    sums[2] += y
    sums[3] += z
    sums[4] += x * x
    sums[5] += x * y
    sums[6] += x * z
    sums[7] += y * y
    sums[8] += y * z
    sums[9] += z * z


@kernel
def _fit(sums, plane):
    """Fit a plane to a region's corners: ``plane`` keeps its centre of moments in 0 to 2.

    The rest: 3-5 centre, 6-8 normal, 9-11 and 12-14 axes, 15 and 16 half widths along them.
    """
    n = sums[0]
    mx, my, mz = sums[1] / n, sums[2] / n, sums[3] / n
    moment = np.empty((3, 3))
    moment[0, 0] = sums[4] / n - mx * mx
    moment[0, 1] = moment[1, 0] = sums[5] / n - mx * my
    moment[0, 2] = moment[2, 0] = sums[6] / n - mx * mz
    moment[1, 1] = sums[7] / n - my * my
    moment[1, 2] = moment[2, 1] = sums[8] / n - my * mz
    moment[2, 2] = sums[9] / n - mz * mz
    values, vectors = np.linalg.eigh(moment)
    plane[3], plane[4], plane[5] = plane[0] + mx, plane[1] + my, plane[2] + mz
    for a in range(3):
        plane[6 + a] = vectors[a, 0]
        plane[9 + a] = vectors[a, 2]
        plane[12 + a] = vectors[a, 1]
    plane[15] = np.sqrt(2.0 * max(values[2], 1e-300))
    plane[16] = np.sqrt(2.0 * max(values[1], 1e-300))


@kernel
def _misfit(plane, x, y, z, reach):
    """Return how far a point is off a fitted plane, per what rounding can make of it there.

    Rounding of the corners by one unit moves the plane by one unit among them, and further out in
    proportion to the distance from its centre per its half width; ``reach`` times at most.
    """
    x, y, z = x - plane[3], y - plane[4], z - plane[5]
    off = abs(x * plane[6] + y * plane[7] + z * plane[8])
    along = abs(x * plane[9] + y * plane[10] + z * plane[11]) / plane[15]
    across = abs(x * plane[12] + y * plane[13] + z * plane[14]) / plane[16]
    return off / min(1.0 + along + across, reach)


@kernel
def _belongs(plane, vertices, faces, normals, trusted, tolerance, triangle):
    """Return whether all that keeps a triangle off a plane is rounding."""
    if trusted[triangle]:
        like = 0.0
        for a in range(3):
            like += plane[6 + a] * normals[triangle, a]
        if abs(like) < LIKE_DIRECTION:
            return False
    for k in range(3):
        v = faces[triangle, k]
        if _misfit(plane, vertices[v, 0], vertices[v, 1], vertices[v, 2], REACH) > tolerance[v]:
            return False
    return True


@kernel
def _seed_plane(plane, sums, vertices, faces, normals, seed):
    """Start a region: what ``_fit`` makes of one triangle, from the triangle's own normal."""
    i, j, k = faces[seed, 0], faces[seed, 1], faces[seed, 2]
    nx, ny, nz = normals[seed, 0], normals[seed, 1], normals[seed, 2]
    for a in range(3):
        plane[a] = (vertices[i, a] + vertices[j, a] + vertices[k, a]) / 3.0
        plane[3 + a] = plane[a]
        plane[6 + a] = normals[seed, a]
        plane[9 + a] = vertices[j, a] - vertices[i, a]
    size = np.sqrt(plane[9] * plane[9] + plane[10] * plane[10] + plane[11] * plane[11])
    ux, uy, uz = plane[9] / size, plane[10] / size, plane[11] / size
    vx, vy, vz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
    sums[:] = 0.0
    uu, uv, vv = 0.0, 0.0, 0.0
    for corner in range(3):
        c = faces[seed, corner]
        x, y, z = vertices[c, 0], vertices[c, 1], vertices[c, 2]
        _spread(x, y, z, sums, plane)
        u = (x - plane[0]) * ux + (y - plane[1]) * uy + (z - plane[2]) * uz
        v = (x - plane[0]) * vx + (y - plane[1]) * vy + (z - plane[2]) * vz
        uu, uv, vv = uu + u * u / 3.0, uv + u * v / 3.0, vv + v * v / 3.0
    root = np.sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv)
    most, least = 0.5 * (uu + vv) + root, 0.5 * (uu + vv) - root
    turn = 0.5 * np.arctan2(2.0 * uv, uu - vv)
    c, s = np.cos(turn), np.sin(turn)
    plane[9], plane[10], plane[11] = c * ux + s * vx, c * uy + s * vy, c * uz + s * vz
    plane[12], plane[13], plane[14] = c * vx - s * ux, c * vy - s * uy, c * vz - s * uz
    plane[15] = np.sqrt(2.0 * max(most, 1e-300))
    plane[16] = np.sqrt(2.0 * max(least, 1e-300))


@kernel
def grow_regions(
    seeds, vertices, faces, normals, trusted, tolerance, edge_of, edge_start, edge_triangle
):
    """Return the region (t,) of each triangle, -1 for none, and the fitted plane of each region.

    A region starts at the largest triangle left and takes in, over shared edges, whatever lies in
    its plane as far as rounding tells; the plane is fitted anew whenever the region has doubled.
    """
    region = np.full(len(faces), -1, dtype=np.int64)
    planes = np.empty((len(seeds), 17))
    waiting = np.empty(len(faces), dtype=np.int64)
    usable = np.zeros(len(faces), dtype=np.bool_)
    usable[seeds] = True
    sums = np.empty(10)
    count = 0
    for seed in seeds:
        if region[seed] >= 0:
            continue
        plane = planes[count]
        _seed_plane(plane, sums, vertices, faces, normals, seed)
        region[seed] = count
        waiting[0] = seed
        head, tail, fitted = 0, 1, 1
        while head < tail:
            here = waiting[head]
            head += 1
            for side in range(3):
                edge = edge_of[here, side]
                for i in range(edge_start[edge], edge_start[edge + 1]):
                    other = edge_triangle[i]
                    if region[other] >= 0 or not usable[other]:
                        continue
                    if not _belongs(plane, vertices, faces, normals, trusted, tolerance, other):
                        continue
                    region[other] = count
                    waiting[tail] = other
                    tail += 1
                    for k in range(3):
                        v = faces[other, k]
                        _spread(vertices[v, 0], vertices[v, 1], vertices[v, 2], sums, plane)
                    if tail >= 2 * fitted:
                        _fit(sums, plane)
                        fitted = tail
        if tail > fitted:
            _fit(sums, plane)
        if tail > 1:  # what the growing plane has turned away from starts anew, later
            for i in range(1, tail):
                other = waiting[i]
                if not _belongs(plane, vertices, faces, normals, trusted, tolerance, other):
                    region[other] = -1
        count += 1
    return region, planes[:count].copy()


@kernel
def _holds(plane, other, tolerance, reach):
    """Return whether the corners of another region's bounds lie in a fitted plane."""
    for side in range(4):
        along = other[15] if side % 2 == 0 else -other[15]
        across = other[16] if side < 2 else -other[16]
        x = other[3] + along * other[9] + across * other[12]
        y = other[4] + along * other[10] + across * other[13]
        z = other[5] + along * other[11] + across * other[14]
        if _misfit(plane, x, y, z, reach) > tolerance:
            return False
    return True


@kernel
def _same_plane(a, b, tolerance):
    """Return whether two regions lie in one plane but for rounding.

    The wider one, whose plane is the better known, must hold the other closely. The other's own
    plane may be off as far out as the wider one reaches, but not by more than its rounding tells.
    """
    if abs(a[6] * b[6] + a[7] * b[7] + a[8] * b[8]) < LIKE_DIRECTION:
        return False
    if a[16] >= b[16]:
        return _holds(a, b, tolerance, CLOSE) and _holds(b, a, tolerance, np.inf)
    return _holds(b, a, tolerance, CLOSE) and _holds(a, b, tolerance, np.inf)


@kernel
def _slot(level, i, j, k, m, mask):
    """Return a cell's place in the table."""
    h = np.uint64(level + 1) * np.uint64(0x9E3779B97F4A7C15)
    for value in (i, j, k, m):
        h ^= np.uint64(value + 0x40000000)
        h *= np.uint64(0xBF58476D1CE4E5B9)
        h ^= h >> np.uint64(29)
    return np.int64(h & np.uint64(mask))


@kernel
def merge_regions(planes, tolerance, middle, radius):
    """Return the least region (r,) that each region shares its plane with.

    Planes are points (normal, offset / radius) of a space that is divided into cells of several
    sizes; a region looks for its plane where its own uncertainty of direction may have put it.
    """
    count = len(planes)
    leader = np.arange(count)
    bits = 4
    while (1 << bits) < 2 * LEVELS * count:
        bits += 1
    mask = (1 << bits) - 1
    first = np.full(mask + 1, -1, dtype=np.int64)
    last = np.full(mask + 1, -1, dtype=np.int64)
    entry_plane = np.empty(LEVELS * count, dtype=np.int64)
    entry_next = np.full(LEVELS * count, -1, dtype=np.int64)
    entries = 0
    point = np.empty(4)
    for b in range(count):
        offset = 0.0
        for a in range(3):
            point[a] = planes[b, 6 + a]
            offset += planes[b, 6 + a] * (planes[b, 3 + a] - middle[a])
        point[3] = offset / radius
        doubt = 2.0 * CLOSE * tolerance[b] / planes[b, 16]
        level = 0
        size = FINEST
        while level < LEVELS and size < doubt:
            level += 1
            size *= COARSER
        own_level, own_size = level, size
        tested = 0
        while level < LEVELS and leader[b] == b and tested < MAX_CANDIDATES:
            for corner in range(32):
                sign = 1.0 if corner < 16 else -1.0
                cell_0 = int(np.floor(sign * point[0] / size - 0.5)) + (corner & 1)
                cell_1 = int(np.floor(sign * point[1] / size - 0.5)) + ((corner >> 1) & 1)
                cell_2 = int(np.floor(sign * point[2] / size - 0.5)) + ((corner >> 2) & 1)
                cell_3 = int(np.floor(sign * point[3] / size - 0.5)) + ((corner >> 3) & 1)
                entry = first[_slot(level, cell_0, cell_1, cell_2, cell_3, mask)]
                while entry >= 0 and tested < MAX_CANDIDATES:
                    tested += 1
                    a = entry_plane[entry]
                    if _same_plane(planes[a], planes[b], max(tolerance[a], tolerance[b])):
                        leader[b] = a
                        break
                    entry = entry_next[entry]
                if leader[b] != b:
                    break
            level += 1
            size *= COARSER
        if leader[b] != b:
            continue
        level, size = own_level, own_size
        while level < LEVELS:
            slot = _slot(
                level,
                int(np.floor(point[0] / size)),
                int(np.floor(point[1] / size)),
                int(np.floor(point[2] / size)),
                int(np.floor(point[3] / size)),
                mask,
            )
            entry_plane[entries] = b
            if first[slot] < 0:
                first[slot] = entries
            else:
                entry_next[last[slot]] = entries
            last[slot] = entries
            entries += 1
            level += 1
            size *= COARSER
    return leader
