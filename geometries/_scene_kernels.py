# mypy: allow-untyped-defs
"""Compiled queries of a scene: supporting planes, sides of closed parts, facets near a point."""

import numpy as np

from octant.geometries.kernels import kernel

MAX_STACK = 130
"""Nodes waiting in a nearest-first walk: two per level of the deepest hierarchy, and some."""

PARALLEL = 1e-9
"""Sine [-] of the angle to a triangle below which a ray is not trusted to cross it or not."""

NEAR_RIM = 1e-9
"""Barycentric distance [-] from a triangle's rim below which a crossing is not trusted."""


@kernel(nogil=True)
def supporting_sides(points, normals, offsets, tolerance, sides):
    """Fill (p,) ``sides``: +1 or -1 where all points lie on that side of a plane, else 0."""
    for i in range(len(normals)):
        above, below = True, True
        for k in range(len(points)):
            height = (
                points[k, 0] * normals[i, 0]
                + points[k, 1] * normals[i, 1]
                + points[k, 2] * normals[i, 2]
                - offsets[i]
            )
            if height < -tolerance:
                above = False
            elif height > tolerance:
                below = False
            if not above and not below:
                break
        sides[i] = 1 if above else (-1 if below else 0)


@kernel(nogil=True)
def _crossings(boxes, links, triangles, parts, own, dx, dy, dz):
    """Return how often a ray from a triangle's middle crosses its own part, -1 when in doubt."""
    part = parts[own]
    px = triangles[own, 0] + (triangles[own, 3] + triangles[own, 6]) / 3.0
    py = triangles[own, 1] + (triangles[own, 4] + triangles[own, 7]) / 3.0
    pz = triangles[own, 2] + (triangles[own, 5] + triangles[own, 8]) / 3.0
    ix, iy, iz = 1.0 / dx, 1.0 / dy, 1.0 / dz
    count = 0
    node = 0
    while node < len(links):
        t0, t1 = (boxes[node, 0] - px) * ix, (boxes[node, 3] - px) * ix
        enter, leave = min(t0, t1), max(t0, t1)
        t0, t1 = (boxes[node, 1] - py) * iy, (boxes[node, 4] - py) * iy
        enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        t0, t1 = (boxes[node, 2] - pz) * iz, (boxes[node, 5] - pz) * iz
        enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        if enter > leave or leave < 0.0:
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            if parts[i] != part or i == own:
                continue
            ax, ay, az = triangles[i, 3], triangles[i, 4], triangles[i, 5]
            bx, by, bz = triangles[i, 6], triangles[i, 7], triangles[i, 8]
            hx, hy, hz = dy * bz - dz * by, dz * bx - dx * bz, dx * by - dy * bx
            det = ax * hx + ay * hy + az * hz
            nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            size = np.sqrt(nx * nx + ny * ny + nz * nz)
            if abs(det) <= PARALLEL * size:
                return -1
            sx, sy, sz = px - triangles[i, 0], py - triangles[i, 1], pz - triangles[i, 2]
            u = (sx * hx + sy * hy + sz * hz) / det
            cx, cy, cz = sy * az - sz * ay, sz * ax - sx * az, sx * ay - sy * ax
            v = (dx * cx + dy * cy + dz * cz) / det
            inner = min(u, v, 1.0 - u - v)
            if inner < -NEAR_RIM:
                continue
            t = (bx * cx + by * cy + bz * cz) / det
            if inner < NEAR_RIM or abs(t) < NEAR_RIM * np.sqrt(size):
                return -1
            if t > 0.0:
                count += 1
        node += 1
    return count


@kernel(nogil=True)
def outer_sides(boxes, links, triangles, parts, directions, sides):
    """Fill (t,) ``sides``: +1 when a triangle's own normal points out of its closed part, else -1.

    A point is outside when a ray from it crosses the part an even number of times, which holds for
    parts that are inside out or cross themselves. 0: no direction gave a clear answer.
    """
    for i in range(len(triangles)):
        ax, ay, az = triangles[i, 3], triangles[i, 4], triangles[i, 5]
        bx, by, bz = triangles[i, 6], triangles[i, 7], triangles[i, 8]
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        sides[i] = 0
        for k in range(len(directions)):
            dx, dy, dz = directions[k, 0], directions[k, 1], directions[k, 2]
            facing = nx * dx + ny * dy + nz * dz
            if abs(facing) <= PARALLEL * np.sqrt(nx * nx + ny * ny + nz * nz):
                continue
            count = _crossings(boxes, links, triangles, parts, i, dx, dy, dz)
            if count >= 0:
                sides[i] = 1 if (count % 2 == 0) == (facing > 0.0) else -1
                break


@kernel
def _box_distance(boxes, node, x, y, z):
    dx = max(boxes[node, 0] - x, 0.0, x - boxes[node, 3])
    dy = max(boxes[node, 1] - y, 0.0, y - boxes[node, 4])
    dz = max(boxes[node, 2] - z, 0.0, z - boxes[node, 5])
    return np.sqrt(dx * dx + dy * dy + dz * dz)


@kernel
def _covers(triangles, i, x, y, z, tolerance):
    """Return whether a point of a triangle's plane lies in the triangle, rim included."""
    ax, ay, az = triangles[i, 3], triangles[i, 4], triangles[i, 5]
    bx, by, bz = triangles[i, 6], triangles[i, 7], triangles[i, 8]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    px, py, pz = x - triangles[i, 0], y - triangles[i, 1], z - triangles[i, 2]
    for side in range(3):
        if side == 0:
            ex, ey, ez, qx, qy, qz = ax, ay, az, px, py, pz
        elif side == 1:
            ex, ey, ez = bx - ax, by - ay, bz - az
            qx, qy, qz = px - ax, py - ay, pz - az
        else:
            ex, ey, ez = -bx, -by, -bz
            qx, qy, qz = px - bx, py - by, pz - bz
        inward = (
            nx * (ey * qz - ez * qy) + ny * (ez * qx - ex * qz) + nz * (ex * qy - ey * qx)
        ) / size
        if inward < -tolerance * np.sqrt(ex * ex + ey * ey + ez * ez):
            return False
    return True


@kernel(nogil=True)
def nearest_facets(
    points, boxes, links, triangles, planes, normals, offsets, tolerance, nearest, plane_of
):
    """Fill (n,) distance and plane of the nearest facet that lies perpendicularly below a point.

    Only facets nearer than what ``nearest`` holds already are looked at.
    """
    stack = np.empty(MAX_STACK, dtype=np.int64)
    away = np.empty(MAX_STACK)
    for k in range(len(points)):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        best, best_plane = nearest[k], -1
        top = 0
        if len(links) > 0:
            stack[0], away[0] = 0, _box_distance(boxes, 0, x, y, z)
            top = 1
        while top > 0:
            top -= 1
            node = stack[top]
            if away[top] > best:
                continue
            if links[node, 2] == 0:
                near, far = node + 1, links[node + 1, 0]
                to_near = _box_distance(boxes, near, x, y, z)
                to_far = _box_distance(boxes, far, x, y, z)
                if to_near > to_far:
                    near, far, to_near, to_far = far, near, to_far, to_near
                stack[top], away[top] = far, to_far
                stack[top + 1], away[top + 1] = near, to_near
                top += 2
                continue
            for i in range(links[node, 1], links[node, 1] + links[node, 2]):
                p = planes[i]
                height = normals[p, 0] * x + normals[p, 1] * y + normals[p, 2] * z - offsets[p]
                distance = abs(height)
                if distance > best or (distance == best and 0 <= best_plane <= p):
                    continue
                if _covers(
                    triangles,
                    i,
                    x - height * normals[p, 0],
                    y - height * normals[p, 1],
                    z - height * normals[p, 2],
                    tolerance,
                ):
                    best, best_plane = distance, p
        nearest[k] = best if best_plane >= 0 else np.inf
        plane_of[k] = best_plane


@kernel(nogil=True)
def planes_at(point, boxes, links, triangles, planes, normals, offsets, slack, found):
    """Mark in (p,) ``found`` the planes of all facets that a point lies on."""
    x, y, z = point[0], point[1], point[2]
    node = 0
    while node < len(links):
        if _box_distance(boxes, node, x, y, z) > 2.0 * slack:
            node = links[node, 0]
            continue
        for i in range(links[node, 1], links[node, 1] + links[node, 2]):
            p = planes[i]
            height = normals[p, 0] * x + normals[p, 1] * y + normals[p, 2] * z - offsets[p]
            if abs(height) <= slack and _covers(triangles, i, x, y, z, slack):
                found[p] = True
        node += 1
