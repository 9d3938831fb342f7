# mypy: allow-untyped-defs
"""Compiled bound of what images reach: those that can have a path to a level square."""

import numpy as np

from octant.geometries.kernels import kernel

CORNERS = 4

SLACK = 100.0
"""Allowance [tolerances of the scene] of every test: rounding, and what merged images are off."""

FLAT = 1e6
"""Height of an image over a plane [tolerances] below which nothing is concluded."""

NODE, CURSOR, PLANE = 0, 1, 2
"""Columns of the steps, one row per reflection counted from the receivers."""


@kernel
def _may_meet(scene, plane, image, node, corners, slack):
    """Return whether a line from a square to an image may meet a facet of a plane on its way.

    Of a square that lies wholly before the plane, the lines pierce it within the hull of where
    those of the corners do.
    """
    n = scene.planes[plane]
    ix, iy, iz = image[node, 0], image[node, 1], image[node, 2]
    image_height = n[0] * ix + n[1] * iy + n[2] * iz - n[3]
    if abs(image_height) <= FLAT * scene.tolerance:
        return True
    side = 1.0 if image_height > 0.0 else -1.0
    nearest, farthest = np.inf, -np.inf
    u0, v0, u1, v1 = np.inf, np.inf, -np.inf, -np.inf
    for c in range(CORNERS):
        px, py, pz = corners[c, 0], corners[c, 1], corners[c, 2]
        height = n[0] * px + n[1] * py + n[2] * pz - n[3]
        nearest, farthest = min(nearest, side * height), max(farthest, side * height)
        t = height / (height - image_height)
        hx, hy, hz = px + t * (ix - px), py + t * (iy - py), pz + t * (iz - pz)
        u = hx * n[4] + hy * n[5] + hz * n[6]
        v = hx * n[7] + hy * n[8] + hz * n[9]
        u0, v0, u1, v1 = min(u0, u), min(v0, v), max(u1, u), max(v1, v)
    if nearest > slack:
        return False
    if farthest >= -slack:
        return True
    for facet in range(scene.plane_facet_start[plane], scene.plane_facet_start[plane + 1]):
        box = scene.facet_box[facet]
        if (
            u0 <= box[2] + slack
            and v0 <= box[3] + slack
            and u1 >= box[0] - slack
            and v1 >= box[1] - slack
        ):
            return True
    return False


@kernel(nogil=True)
def leaves_of_square(scene, tree, x, y, z, side):
    """Return the tree's leaves (k,) that can have a path to the square from x, y on, at z [m].

    A path's points are where the line from the receiver, mirrored in the planes that it has met,
    to the next image meets the next plane: so a square that is mirrored along bounds them all.
    """
    slack = SLACK * scene.tolerance
    corners = np.empty((tree.max_order + 2, CORNERS, 3))
    steps = np.empty((tree.max_order + 2, 3), dtype=np.int64)
    found = np.empty(len(tree.leaves), dtype=np.int64)
    count = 0
    for c in range(CORNERS):
        corners[0, c, 0] = x + (side if c & 1 else 0.0)
        corners[0, c, 1] = y + (side if c & 2 else 0.0)
        corners[0, c, 2] = z
    for leaf in tree.leaves:
        order = tree.order[leaf]
        depth = 0
        steps[0, NODE], steps[0, CURSOR], steps[0, PLANE] = leaf, tree.branch_start[leaf], -1
        while depth >= 0:
            if depth == order:
                found[count] = leaf
                count += 1
                break
            node, branch = steps[depth, NODE], steps[depth, CURSOR]
            if branch == tree.branch_start[node + 1]:
                depth -= 1
                continue
            steps[depth, CURSOR] = branch + 1
            plane = tree.branches[branch, 0]
            if plane == steps[depth, PLANE] or not _may_meet(
                scene, plane, tree.image, node, corners[depth], slack
            ):
                continue
            n = scene.planes[plane]
            for c in range(CORNERS):
                height = -n[3]
                for a in range(3):
                    height += n[a] * corners[depth, c, a]
                for a in range(3):
                    corners[depth + 1, c, a] = corners[depth, c, a] - 2.0 * height * n[a]
            depth += 1
            node = tree.branches[branch, 1]
            steps[depth, NODE], steps[depth, CURSOR] = node, tree.branch_start[node]
            steps[depth, PLANE] = plane
    return found[:count].copy()
