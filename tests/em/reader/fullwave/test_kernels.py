"""Compiled kernels against plain NumPy twins that integrate the singularity by brute force."""

import math

import numpy as np
import pytest

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave import _far_kernels, _phase_kernels
from octant.em.reader.fullwave.basis import (
    CLOSE_POINTS,
    CLOSE_WEIGHTS,
    SEVEN_POINTS,
    SEVEN_WEIGHTS,
    THREE_POINTS,
    surface_basis,
)
from octant.em.reader.fullwave.rwg import CLOSE, MID, NEAR, VACUUM_IMPEDANCE_OHM, impedance_matrix

FREQUENCY_HZ = 2.4e9
WAVENUMBER = 2.0 * math.pi * FREQUENCY_HZ / SPEED_OF_LIGHT_M_PER_S
GAUSS = np.polynomial.legendre.leggauss(40)


def tent_mesh():
    """Return two folded sheets and a third on their common edge, plus a piece far away."""
    h = 0.01
    x = np.array(
        (
            (0, 0, 0), (h, 0, 0), (0, h, 0), (h, 1.1 * h, 0), (0.3 * h, 0.2 * h, h),
            (0.9 * h, -0.8 * h, 0.4 * h), (5 * h, 0, 0), (6 * h, 0.2 * h, 0), (5 * h, h, 0.3 * h),
            (6.2 * h, 1.3 * h, 0), (2.9 * h, 0, h), (3.6 * h, 0.2 * h, h), (3.1 * h, 0.8 * h, h),
            (3.9 * h, 0.8 * h, 1.4 * h),
        )
    )  # fmt: skip
    faces = [(0, 1, 2), (1, 3, 2), (0, 1, 4), (0, 5, 1), (6, 7, 8), (7, 9, 8)]
    return x, [*faces, (10, 11, 12), (11, 13, 12)]


def inverse_distance(corner, point):
    """Return the integrals of 1/R and r'/R over a triangle: three wedges, each in polar form."""
    normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    normal /= np.linalg.norm(normal)
    foot = point - normal * ((point - corner[0]) @ normal)
    total, vector = 0.0, np.zeros(3)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        u, v = corner[a] - foot, corner[b] - foot
        area = np.cross(u, v) @ normal
        if abs(area) < 1e-18:
            continue
        # Rays from the foot; along the edge s = d sinh(x), which keeps the integrand smooth in x.
        edge = (v - u) / np.linalg.norm(v - u)
        near = u - edge * (u @ edge)
        d = np.linalg.norm(near)
        low, high = np.arcsinh((u @ edge) / d), np.arcsinh((v @ edge) / d)
        x = 0.5 * (high - low) * GAUSS[0] + 0.5 * (high + low)
        reach = d * np.cosh(x)
        direction = (near / d + np.sinh(x)[:, None] * edge) / np.cosh(x)[:, None]
        height = abs((point - foot) @ normal)
        inner = np.hypot(reach, height) - height  # of r / R over the ray
        far = np.hypot(reach, height)
        if height > 0.0:
            square = 0.5 * (reach * far - height**2 * np.arcsinh(reach / height))
        else:
            square = 0.5 * reach**2
        weight = 0.5 * (high - low) * GAUSS[1] * np.sign(area) / np.cosh(x)  # of the angle
        total += weight @ inner
        vector += (weight * square) @ direction
    return total, vector + foot * total


def rest(r):
    return np.where(
        r > 0.0, (np.exp(-1j * WAVENUMBER * r) - 1.0) / np.where(r > 0.0, r, 1.0), -1j * WAVENUMBER
    )


def pair_moments(p, q):
    """Return means over both triangles of g, r g, r' g, r.r' g."""
    cp, cq = p.mean(axis=0), q.mean(axis=0)
    reach = sum(np.linalg.norm(t - t.mean(axis=0), axis=1).max() for t in (p, q))
    apart = np.linalg.norm(cp - cq)
    if apart >= NEAR * reach:
        rule = (SEVEN_POINTS, SEVEN_WEIGHTS)
        if apart >= MID * reach:
            rule = (THREE_POINTS, np.full(3, 1.0 / 3.0))
        u, v = rule[0] @ p, rule[0] @ q
        r = np.linalg.norm(u[:, None] - v[None], axis=2)
        g = np.exp(-1j * WAVENUMBER * r) / r * np.outer(rule[1], rule[1])
        return g.sum(), u.T @ g.sum(1), v.T @ g.sum(0), np.einsum("ab,ac,bc->", g, u, v)
    seven, close = (SEVEN_POINTS, SEVEN_WEIGHTS), (CLOSE_POINTS, CLOSE_WEIGHTS)
    first = close if apart == 0.0 else seven
    u, v = first[0] @ p, SEVEN_POINTS @ q
    r = np.linalg.norm(u[:, None] - v[None], axis=2)
    g = rest(r) * np.outer(first[1], SEVEN_WEIGHTS)
    parts = [g.sum(), u.T @ g.sum(1), v.T @ g.sum(0), np.einsum("ab,ac,bc->", g, u, v)]
    for outer, inner, swap in ((p, q, False), (q, p, True)):
        area = 0.5 * np.linalg.norm(np.cross(inner[1] - inner[0], inner[2] - inner[0]))
        rule = close if apart < CLOSE * reach else seven
        for point, weight in zip(rule[0] @ outer, rule[1], strict=True):
            scalar, vector = inverse_distance(inner, point)
            w = 0.5 * weight / area
            parts[0] += w * scalar
            parts[2 if swap else 1] = parts[2 if swap else 1] + w * scalar * point
            parts[1 if swap else 2] = parts[1 if swap else 2] + w * vector
            parts[3] += w * (point @ vector)
    return parts


def slow_matrix(basis, sheet_ohm):
    """Return the matrix by loops over half-functions, without symmetry."""
    corners, length, area = basis.corners_m, basis.edge_lengths_m, basis.areas_m2
    halves = np.zeros((basis.functions, len(corners), 3))
    owner = np.repeat(np.arange(len(corners)), np.diff(basis.start))
    halves[basis.function, owner, basis.local] = basis.sign
    local = np.zeros((len(corners), 3, len(corners), 3), dtype=complex)
    vector = 1j * WAVENUMBER * VACUUM_IMPEDANCE_OHM / (16.0 * math.pi)
    scalar = VACUUM_IMPEDANCE_OHM / (4j * math.pi * WAVENUMBER)
    for p, a in enumerate(corners):
        for q, b in enumerate(corners):
            g, ug, vg, uvg = pair_moments(a, b)
            for i in range(3):
                for j in range(3):
                    dot = uvg - a[i] @ vg - b[j] @ ug + (a[i] @ b[j]) * g
                    local[p, i, q, j] = length[p, i] * length[q, j] * (vector * dot + scalar * g)
        points = SEVEN_POINTS @ a
        for i in range(3):
            for j in range(3):
                product = ((points - a[i]) * (points - a[j])).sum(axis=1) @ SEVEN_WEIGHTS
                local[p, i, p, j] += (
                    sheet_ohm[p] * length[p, i] * length[p, j] * product / (4.0 * area[p])
                )
    matrix = np.einsum("mpi,piqj,nqj->mn", halves, local, halves, optimize=True)
    return 0.5 * (matrix + matrix.T)


def own_inverse_distance(corner):
    """Return the integral of 1/R over a triangle twice, in closed form (Eibert and Hansen 1995)."""
    length = np.linalg.norm(corner - np.roll(corner, 1, axis=0), axis=1)
    area = 0.5 * np.linalg.norm(np.cross(corner[1] - corner[0], corner[2] - corner[0]))
    return -4.0 / 3.0 * area**2 * (np.log(1.0 - 2.0 * length / length.sum()) / length).sum()


def by_rule(outer, inner, points, weights):
    area = 0.5 * np.linalg.norm(np.cross(outer[1] - outer[0], outer[2] - outer[0]))
    return area * sum(
        w * inverse_distance(inner, x)[0] for x, w in zip(points @ outer, weights, strict=True)
    )


@pytest.mark.parametrize("apex", [(0.5, 0.87), (0.9, 0.35), (0.2, 0.25), (0.6, 2.0)])
def test_triangles_that_touch_are_integrated_to_1e_4_and_not_to_1e_2(apex):
    """A triangle cut in two has the interaction of its parts from three closed forms."""
    whole = np.array(((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (*apex, 0.0)))
    middle = 0.5 * (whole[0] + whole[1])
    one, other = np.array((whole[0], middle, whole[2])), np.array((middle, whole[1], whole[2]))
    own = own_inverse_distance(one)
    both = 0.5 * (own_inverse_distance(whole) - own - own_inverse_distance(other))
    off = {}
    for name, rule in (
        ("close", (CLOSE_POINTS, CLOSE_WEIGHTS)),
        ("seven", (SEVEN_POINTS, SEVEN_WEIGHTS)),
    ):
        pair = 0.5 * (by_rule(one, other, *rule) + by_rule(other, one, *rule))
        off[name] = abs(by_rule(one, one, *rule) / own - 1.0), abs(pair / both - 1.0)
    assert max(off["close"]) < 2e-4
    assert max(off["seven"]) > 4e-3


def test_the_impedance_matrix_equals_its_slow_twin():
    vertices, faces = tent_mesh()
    basis = surface_basis(vertices, faces)
    assert basis.unknowns == 5
    sheet = np.linspace(0.0, 3.0, len(faces)) * (1.0 + 0.5j)
    expected = slow_matrix(basis, sheet)
    found = impedance_matrix(basis, frequency_hz=FREQUENCY_HZ, surface_impedance_ohm=sheet)[:, 0, :]
    scale = np.sqrt(np.outer(np.abs(np.diagonal(expected)), np.abs(np.diagonal(expected))))
    assert np.abs((found - expected) / scale).max() < 1e-9


@pytest.mark.parametrize("span", [1.0, 30.0, 500.0])
def test_the_phases_equal_the_exponential(span):
    rng = np.random.default_rng(3)
    direction = rng.standard_normal((40, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    point = rng.uniform(-span, span, (3, 50))
    out = np.empty((30, 50), dtype=complex)
    _far_kernels.fill_phases(direction, point, 5, 35, out)
    np.testing.assert_allclose(out, np.exp(1j * (direction[5:35] @ point)), atol=1e-12)


def test_logarithms_in_lanes_are_those_of_numpy():
    rng = np.random.default_rng(3)
    given = np.concatenate((1.0 + 10.0 ** rng.uniform(-15.0, 15.0, 1000), [1.0, 2.0, 2.0**0.5]))
    values = given.copy()
    _phase_kernels.logarithms(values, values.view(np.int64), np.empty(len(values)), len(values))
    assert values == pytest.approx(np.log(given), rel=1e-15, abs=0.0)
