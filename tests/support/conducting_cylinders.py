"""Exact-as-meshed fields of a line source near a conducting cylinder: moments in two dimensions.

Time e^{+jwt}; the source's free field is H0(2)(k R). It shares nothing with the package. Soft: the
single-layer equation for the normal derivative; hard: the double-layer equation for the field.
Segments shrink towards the corners, where the unknowns are singular.
"""

import numpy as np
from scipy.special import hankel2

SOFT, HARD = -1.0, 1.0
NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


def outline(corners, per_side):
    """Ends (n, 2, 2) of the segments of counterclockwise polygons (.., m, 2), graded to corners."""
    s = np.linspace(0.0, 1.0, per_side + 1)
    s = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    ends = []
    following = np.roll(corners, -1, axis=-2)
    for a, b in zip(corners.reshape(-1, 2), following.reshape(-1, 2), strict=True):
        points = a + s[:, None] * (b - a)
        ends.extend(np.stack([points[:-1], points[1:]], axis=1))
    return np.array(ends)


def quadrature(ends):
    a, b = ends[:, 0], ends[:, 1]
    points = 0.5 * (a + b)[:, None] + 0.5 * NODES[:, None] * (b - a)[:, None]
    length = np.linalg.norm(b - a, axis=1)
    tangent = (b - a) / length[:, None]
    return (
        points,
        0.5 * WEIGHTS * length[:, None],
        np.stack([tangent[:, 1], -tangent[:, 0]], axis=1),
    )


def single_layer(k, ends, at):
    points, weights, _ = quadrature(ends)
    r = np.linalg.norm(at[:, None, None] - points, axis=-1)
    return np.sum(hankel2(0, k * r) * weights, axis=-1) / 4j


def double_layer(k, ends, at):
    points, weights, normals = quadrature(ends)
    d = at[:, None, None] - points
    r = np.linalg.norm(d, axis=-1)
    cosine = np.einsum("masx,ax->mas", d, normals) / r
    return np.sum(k * hankel2(1, k * r) * cosine * weights, axis=-1) / 4j


def total_field(k, corners, source, receivers, kind, per_side=120):
    """Total field at receivers (m, 2)."""
    ends = outline(np.asarray(corners, float), per_side)
    middle = 0.5 * (ends[:, 0] + ends[:, 1])
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    on_it = hankel2(0, k * np.linalg.norm(middle - source, axis=1))
    free = hankel2(0, k * np.linalg.norm(receivers - source, axis=1))
    own = np.arange(len(ends))
    if kind == SOFT:
        matrix = single_layer(k, ends, middle)
        # Small-argument integral of H0(2) over a segment, seen from its middle.
        log = np.log(k * length / 4.0) + np.euler_gamma - 1.0
        matrix[own, own] = length * (1.0 - 2j / np.pi * log) / 4j
        return free - single_layer(k, ends, receivers) @ np.linalg.solve(matrix, on_it)
    matrix = -double_layer(k, ends, middle)
    matrix[own, own] = 0.5
    return free + double_layer(k, ends, receivers) @ np.linalg.solve(matrix, on_it)
