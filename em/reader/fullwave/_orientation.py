"""Triangles wound alike, so that what is laid on them depends on the shape and its turns alone."""

import numpy as np

from octant.geometries._plane_geometry import FloatArray, IntArray

FLAT = 1e-9
"""Share of the greatest possible sum [-] below which a sheet has no side by that measure."""


def oriented(points_m: FloatArray, faces: IntArray) -> IntArray:
    """Return triangles (f, 3) wound alike over every edge of two, each sheet by its shape.

    A closed sheet is seen anticlockwise from outside, a flat one from above, an upright one from
    beyond the axis, or from greater azimuth: turned sheets are wound alike.
    """
    side, sheet = _sides(faces)
    flipped = np.where((side < 0)[:, None], faces[:, ::-1], faces)
    a, b, c = (points_m[flipped[:, k]] for k in range(3))
    normal, centre = 0.5 * np.cross(b - a, c - a), (a + b + c) / 3.0
    area = np.linalg.norm(normal, axis=1)
    count = sheet.max() + 1

    def total(values: FloatArray) -> FloatArray:
        sums: FloatArray = np.bincount(sheet, values, count).astype(np.float64)
        return sums

    whole = total(area)
    middle = np.column_stack([total(area * centre[:, k]) / whole for k in range(3)])
    from_middle = centre - middle[sheet]
    radial = centre * np.array((1.0, 1.0, 0.0))
    across = np.column_stack((-centre[:, 1], centre[:, 0], np.zeros(len(centre))))
    turn = np.zeros(count)
    for direction in (from_middle, np.array((0.0, 0.0, 1.0)), radial, across):
        seen = total((normal * direction).sum(axis=1))
        most = total(area * np.linalg.norm(direction + 0.0 * normal, axis=1))
        turn = np.where((turn == 0.0) & (np.abs(seen) > FLAT * most), np.sign(seen), turn)
    result: IntArray = np.where((turn[sheet] < 0.0)[:, None], flipped[:, ::-1], flipped)
    return result


def _sides(faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return, for each triangle, +1 or -1 to wind its sheet alike, and the number of its sheet."""
    directed = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, edge, sheets = np.unique(
        np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    order = np.argsort(edge.reshape(-1), kind="stable")
    first = np.concatenate(([0], np.cumsum(sheets)))[:-1][sheets == 2]
    one, other = order[first], order[first + 1]
    beside: list[list[tuple[int, int]]] = [[] for _ in faces]
    alike = np.where(directed[one, 0] == directed[other, 1], 1, -1)
    for i, j, sign in zip((one // 3).tolist(), (other // 3).tolist(), alike.tolist(), strict=True):
        beside[i].append((j, sign))
        beside[j].append((i, sign))
    side, sheet = np.zeros(len(faces), dtype=np.int64), np.zeros(len(faces), dtype=np.int64)
    number = 0
    for start in range(len(faces)):
        if side[start]:
            continue
        side[start], sheet[start], left = 1, number, [start]
        while left:
            i = left.pop()
            for j, sign in beside[i]:
                if not side[j]:
                    side[j], sheet[j] = sign * side[i], number
                    left.append(j)
        number += 1
    return side, sheet
