"""Plane polygons: area, simplicity, ear clipping; triangle soup to an indexed mesh.

A polygon is (k, 2), or (k, 3) in space: its corners in order, the first not repeated [m]. Its
``name`` is for messages.
"""

import itertools

import numpy as np

from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.errors import GeometryError

# Cross products below this fraction of the polygon's squared extent count as collinear: far above
# the rounding of float64, far below any corner that a person draws.
_FLAT = 1e-12


def signed_area_m2(points_m: FloatArray) -> float:
    """Return the area enclosed by a polygon, positive when it runs counter-clockwise [m²]."""
    p = points_m - points_m[0]  # keeps the digits of a polygon far from the origin
    q = np.roll(p, -1, axis=0)
    return float(0.5 * np.sum(p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]))


def _cross(o: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the z component of (a - o) x (b - o) [m²]."""
    left = a - o
    right = b - o
    cross: FloatArray = left[..., 0] * right[..., 1] - left[..., 1] * right[..., 0]
    return cross


def check_simple(points_m: FloatArray, *, name: str) -> None:
    """Raise when a polygon is not simple: too few corners, no area, or a side meeting another."""
    k = len(points_m)
    if k < 3:
        msg = f"{name} has {k} corners, but an outline needs at least 3."
        raise GeometryError(msg)
    following = np.roll(points_m, -1, axis=0)
    short = np.flatnonzero((points_m == following).all(axis=1))
    if short.size:
        msg = (
            f"{name} repeats corner {short[0]} at {points_m[short[0]].tolist()} m; give each "
            "corner once, and do not close the outline by repeating the first."
        )
        raise GeometryError(msg)
    flat_m2 = _FLAT * float(np.ptp(points_m, axis=0).max()) ** 2
    offset = points_m - points_m[0]
    farthest = offset[int((offset**2).sum(axis=1).argmax())]
    if (np.abs(offset[:, 0] * farthest[1] - offset[:, 1] * farthest[0]) <= flat_m2).all():
        msg = f"{name} encloses no area; give corners that do not all lie on one line."
        raise GeometryError(msg)
    meeting = _first_meeting_sides(points_m, following, flat_m2)
    if meeting is not None:
        msg = (
            f"side {meeting[0]} of {name} meets side {meeting[1]}; an outline must not touch or "
            "cross itself."
        )
        raise GeometryError(msg)


def _first_meeting_sides(
    start: FloatArray, end: FloatArray, flat_m2: float
) -> tuple[int, int] | None:
    """Return the first two sides that meet elsewhere than in a common corner, or None."""
    k = len(start)
    # Neighbours share a corner; they only meet elsewhere when the outline folds back on itself.
    back = np.flatnonzero(
        (np.abs(_cross(start, end, np.roll(end, -1, axis=0))) <= flat_m2)
        & (np.sum((end - start) * (np.roll(end, -1, axis=0) - end), axis=1) < 0.0)
    )
    if back.size:
        return int(back[0]), int((back[0] + 1) % k)
    i, j = np.triu_indices(k, 2)
    keep = ~((i == 0) & (j == k - 1))
    i, j = i[keep], j[keep]

    def side(o: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
        cross = _cross(o, a, b)
        return np.where(np.abs(cross) <= flat_m2, 0.0, np.sign(cross))

    apart = (side(start[i], end[i], start[j]) * side(start[i], end[i], end[j]) > 0) | (
        side(start[j], end[j], start[i]) * side(start[j], end[j], end[i]) > 0
    )
    low_i, high_i = np.minimum(start[i], end[i]), np.maximum(start[i], end[i])
    low_j, high_j = np.minimum(start[j], end[j]), np.maximum(start[j], end[j])
    boxes_apart = ((low_i > high_j) | (low_j > high_i)).any(axis=1)
    hit = np.flatnonzero(~apart & ~boxes_apart)
    return (int(i[hit[0]]), int(j[hit[0]])) if hit.size else None


def triangulate_polygon(points_m: FloatArray, *, name: str = "the polygon") -> IntArray:
    """Return the (k - 2, 3) counter-clockwise triangles that fill a polygon, no corner added.

    A repeated corner, or a polygon without area, gives triangles without area. Ear clipping (G. H.
    Meisters, "Polygons have ears", Amer. Math. Monthly 82, 1975, pp. 648-651: a simple polygon
    always has one), in time that grows with k cubed: for outlines, not for meshes.
    """
    ring = list(range(len(points_m)))
    if signed_area_m2(points_m) < 0.0:
        ring.reverse()
    flat_m2 = _FLAT * float(np.ptp(points_m, axis=0).max()) ** 2
    triangles: list[tuple[int, int, int]] = []
    while len(ring) >= 3:
        ear = _find_ear(points_m, ring, flat_m2)
        if ear is None and abs(signed_area_m2(points_m[ring])) <= flat_m2:
            triangles += [(ring[0], b, c) for b, c in itertools.pairwise(ring[1:])]
            break
        if ear is None:
            msg = f"{name} cannot be cut into triangles, because it crosses or touches itself."
            raise GeometryError(msg)
        triangles.append((ring[ear - 1], ring[ear], ring[(ear + 1) % len(ring)]))
        ring.pop(ear)
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _find_ear(points_m: FloatArray, ring: list[int], flat_m2: float) -> int | None:
    """Return the place in the ring of the first corner that can be cut off, or None."""
    corners = points_m[ring]
    before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
    convex = np.flatnonzero(_cross(before, corners, after) > flat_m2)
    for place in convex:
        a, b, c = before[place], corners[place], after[place]
        # Corners on the border count as inside: cutting along them would leave a degenerate rest.
        inside = (
            (_cross(a, b, corners) >= -flat_m2)
            & (_cross(b, c, corners) >= -flat_m2)
            & (_cross(c, a, corners) >= -flat_m2)
        )
        same = (corners == a).all(axis=1) | (corners == b).all(axis=1) | (corners == c).all(axis=1)
        if not (inside & ~same).any():
            return int(place)
    return None


def triangulate_polygon_3d(points_m: FloatArray, *, name: str) -> IntArray:
    """Return (k - 2, 3) triangles of a nearly plane polygon, wound as it is; normal: Newell's."""
    if len(points_m) == 3:
        return np.array([[0, 1, 2]], dtype=np.int64)
    p = points_m - points_m[0]
    normal = np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)
    drop = int(np.abs(normal).argmax())
    # Dropping the largest component keeps the projection one-to-one; the remaining axes in cyclic
    # order keep the winding when that component is positive.
    axes = [(drop + 1) % 3, (drop + 2) % 3]
    triangles = triangulate_polygon(p[:, axes], name=name)
    return triangles if normal[drop] >= 0.0 else triangles[:, ::-1]


def mesh_of_triangles(triangles_m: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return vertices [m] and faces; corners at exactly one place are one vertex, by first use."""
    corners = triangles_m.reshape(-1, 3) + 0.0  # turns -0.0 into 0.0
    _, first, inverse = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return corners[first[order]], rank[inverse.reshape(-1)].reshape(-1, 3).astype(np.int64)
