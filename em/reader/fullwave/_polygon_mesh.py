"""Graded triangle meshes of convex polygons whose boundary points depend on the boundary alone."""

import math
from collections.abc import Callable

import numpy as np

from octant.geometries._plane_geometry import FloatArray, IntArray

SizeFunction = Callable[[FloatArray], FloatArray]
"""Wanted edge length [m] at (n, 2) points [m]."""

SMOOTHING_ROUNDS = 25
"""Rounds of moving points to the weighted centroid of their triangles [-]."""

LEAST_SPACING = 0.72
"""Least distance [wanted edge length] between two first interior points."""

LEAST_CLEARANCE = 0.55
"""Least distance [wanted edge length] of a first interior point from the boundary."""

CLEARED = 0.75
"""Radius kept clear about the middle of a line that must become an edge [its length]; above 0.5."""

FLAT = 1e-7
"""Area over longest edge squared [-] below which a triangle is a fold of the boundary line."""


def divide_segment(start_m: FloatArray, end_m: FloatArray, size: SizeFunction) -> FloatArray:
    """Return (k, 2) points from start to, not including, end, as far apart as wanted [m].

    The points depend on the segment and the wanted size only, whichever end comes first, so two
    polygons that share an edge share its points.
    """
    length = float(np.linalg.norm(end_m - start_m))
    least = float(size(np.linspace(start_m, end_m, 33)).min())
    samples = 2 * max(64, math.ceil(8.0 * length / least)) + 1
    along = np.linspace(0.0, 1.0, samples)
    density = 1.0 / size(start_m + along[:, None] * (end_m - start_m))
    steps = 0.5 * (density[1:] + density[:-1]) * (length / (samples - 1))
    count = np.concatenate(([0.0], np.cumsum(steps)))
    pieces = max(1, math.ceil(float(count[-1]) - 1e-6))
    at = np.interp(np.arange(pieces) * (count[-1] / pieces), count, along)
    points: FloatArray = start_m + at[:, None] * (end_m - start_m)
    return points


def _edge_distance(points_m: FloatArray, corners_m: FloatArray) -> FloatArray:
    """Return the distance of each point inside a counter-clockwise polygon from its edges [m]."""
    along = np.roll(corners_m, -1, axis=0) - corners_m
    along = along / np.linalg.norm(along, axis=1)[:, None]
    inward = np.column_stack((-along[:, 1], along[:, 0]))
    offset = (inward * corners_m).sum(axis=1)
    nearest: FloatArray = (points_m @ inward.T - offset).min(axis=1)
    return nearest


def _first_points(
    corners_m: FloatArray, taken_m: FloatArray, fixed_m: FloatArray, size: SizeFunction
) -> FloatArray:
    """Return the interior points to start from: a fine lattice, thinned from the finest size up."""
    low, high = corners_m.min(axis=0), corners_m.max(axis=0)
    coarse = np.stack(
        np.meshgrid(np.linspace(low[0], high[0], 24), np.linspace(low[1], high[1], 24)), axis=-1
    ).reshape(-1, 2)
    finest = float(min(size(coarse).min(), size(taken_m).min()))
    if len(fixed_m):
        finest = min(finest, float(size(fixed_m).min()))
    span = float((high - low).max())
    lattices, spacing = [], float(size(coarse).max())
    while True:
        lattices.append(_lattice(low, high, spacing))
        if spacing <= 1.2 * finest or spacing < span / 400.0:
            break
        spacing *= 0.7
    kept = [*taken_m, *fixed_m]
    chosen: list[FloatArray] = []
    # Finer lattices serve where the wanted size is near their spacing; the finest goes first.
    for lattice in reversed(lattices):
        wanted = size(lattice)
        usable = _edge_distance(lattice, corners_m) > LEAST_CLEARANCE * wanted
        step = float(np.linalg.norm(lattice[1] - lattice[0])) if len(lattice) > 1 else span
        usable &= wanted >= 0.85 * step
        for point, h in zip(lattice[usable], wanted[usable], strict=True):
            there = np.asarray(kept)
            if ((there - point) ** 2).sum(axis=1).min() > (LEAST_SPACING * h) ** 2:
                kept.append(point)
                chosen.append(point)
    return np.array(chosen).reshape(-1, 2)


def _lattice(low: FloatArray, high: FloatArray, spacing: float) -> FloatArray:
    """Return a lattice of equilateral triangles over a box, row by row [m]."""
    rows = math.ceil((high[1] - low[1]) / (spacing * math.sqrt(0.75))) + 1
    columns = math.ceil((high[0] - low[0]) / spacing) + 2
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    x = low[0] + spacing * (i - 0.5 * (j % 2))
    y = low[1] + spacing * math.sqrt(0.75) * (j + 0.5)
    return np.stack((x, y), axis=-1).reshape(-1, 2)


def _triangles(points_m: FloatArray) -> IntArray:
    """Return the Delaunay triangles, counter-clockwise, without folds of the boundary line."""
    from scipy.spatial import Delaunay

    faces = Delaunay(points_m).simplices.astype(np.int64)
    a, b, c = (points_m[faces[:, k]] for k in range(3))
    u, v, w = b - a, c - a, c - b
    area = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    longest = np.maximum.reduce([(u**2).sum(axis=1), (v**2).sum(axis=1), (w**2).sum(axis=1)])
    faces[area < 0.0] = faces[area < 0.0][:, [0, 2, 1]]
    kept: IntArray = faces[np.abs(area) > FLAT * longest]
    return kept


def mesh_polygon(
    corners_m: FloatArray, size: SizeFunction, fixed_m: FloatArray | None = None
) -> tuple[FloatArray, IntArray]:
    """Return points (n, 2) [m] and triangles (m, 3) [-] of a convex polygon.

    ``corners_m`` runs counter-clockwise and may hold points on straight edges, which become
    vertices; ``fixed_m`` are interior points that become vertices and are joined by an edge with
    the nearest of the corners. Deterministic.
    """
    fixed = np.zeros((0, 2)) if fixed_m is None else np.asarray(fixed_m, dtype=np.float64)
    following = np.roll(corners_m, -1, axis=0)
    rim = [divide_segment(a, b, size) for a, b in zip(corners_m, following, strict=True)]
    boundary = np.concatenate(rim)
    points = np.concatenate((boundary, fixed, _first_points(corners_m, boundary, fixed, size)))
    still = len(boundary) + len(fixed)
    if len(points) > still:
        for _ in range(SMOOTHING_ROUNDS):
            faces = _triangles(points)
            centre = points[faces].mean(axis=1)
            u, v = (
                points[faces[:, 1]] - points[faces[:, 0]],
                points[faces[:, 2]] - points[faces[:, 0]],
            )
            weight = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / size(centre) ** 3
            total = np.bincount(faces.ravel(), np.repeat(weight, 3), len(points))
            moved = np.column_stack(
                [
                    np.bincount(faces.ravel(), np.repeat(weight * centre[:, k], 3), len(points))
                    for k in range(2)
                ]
            )
            points[still:] = moved[still:] / total[still:, None]
            _clear(points[still:], corners_m, fixed)
    return points, _triangles(points)


def _clear(free_m: FloatArray, corners_m: FloatArray, fixed_m: FloatArray) -> None:
    """Move points, in place, away from the lines between fixed points and their next corners.

    With the circle on such a line empty, the line is an edge of the Delaunay triangles.
    """
    for point in fixed_m:
        corner = corners_m[np.argmin(((corners_m - point) ** 2).sum(axis=1))]
        middle = 0.5 * (corner + point)
        least = CLEARED * float(np.linalg.norm(corner - point))
        away = free_m - middle
        distance = np.linalg.norm(away, axis=1)
        close = distance < least
        free_m[close] = middle + away[close] * (least / distance[close])[:, None]
