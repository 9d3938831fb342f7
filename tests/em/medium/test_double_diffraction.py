"""Two edges one after the other: exact limits, moments in two dimensions, continuity."""

import conducting_cylinders as cylinders
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import hankel2, wofz

from octant.em.fields._diffraction_kernels import diffract, diffract_twice
from octant.em.medium._transition_kernels import STEEP_NODES, double_transition, steep_descent
from octant.em.medium.wedges import CONDUCTOR, transition_function

K = 2.0 * np.pi
X, Y, Z = np.eye(3)
CONCRETE = 5.24 - 0.33j


def unit(v):
    return v / np.linalg.norm(v)


class Edges:
    """Edge frames with one material all over, as the kernels take them."""

    def __init__(self, rows, permittivity=CONDUCTOR, k=K):
        self.k = k
        self.frames = np.pad(np.array(rows, dtype=float), ((0, 0), (0, 6)))  # without ends
        self.faces = np.full((len(rows), 2, 4), (0, 1, 1, 0))
        self.permittivity = np.array([permittivity], complex)
        self.thickness = np.array([np.inf])

    def once(self, edge, lengths, directions, field):
        return np.array(
            diffract(
                self.frames,
                self.faces,
                self.permittivity,
                self.thickness,
                edge,
                self.k,
                1e-9,
                0.0,
                *lengths,
                *np.concatenate(directions),
                *np.asarray(field, complex),
            )
        )

    def twice(self, first, second, shared, lengths, directions, field):
        return np.array(
            diffract_twice(
                self.frames,
                self.faces,
                self.permittivity,
                self.thickness,
                first,
                second,
                shared,
                self.k,
                1e-9,
                0.0,
                0.0,
                *lengths,
                *np.concatenate(directions),
                *np.asarray(field, complex),
            )
        )


# The transition function of two edges


def transition_over_both(a, b, w):
    weights = np.empty((2, STEEP_NODES), complex)
    steep_descent(a, weights[0])
    steep_descent(b, weights[1])
    return double_transition(a, b, w, *weights)


def test_double_transition_is_its_double_integral():
    rng = np.random.default_rng(3)
    nodes, weights = np.polynomial.legendre.leggauss(300)
    turn = np.exp(0.25j * np.pi)
    for _ in range(100):
        a, b = 10.0 ** rng.uniform(-3.0, 0.6, 2)
        w = rng.uniform(-0.9, 0.9)
        end = 7.0 / np.sqrt(1.0 - w * w)
        t, dt = 0.5 * end * (nodes + 1.0), 0.5 * end * weights
        inner = wofz(1j * (turn * b - w * t))
        exact = 2j * np.sqrt(np.pi) * np.sum(dt * np.exp(-t * t - 2.0 * turn * a * t) * inner)
        assert transition_over_both(a, b, w) == pytest.approx(exact, rel=1e-9)


def test_uncoupled_edges_have_the_product_of_their_transition_functions():
    for a, b in ((0.3, 4.0), (1.9, 2.1), (1e-3, 50.0)):
        product = transition_function(a * a) * transition_function(b * b)
        assert a * b * transition_over_both(a, b, 0.0) == pytest.approx(product, rel=1e-9)


# Knife edges in line with source and receiver


@given(
    st.floats(0.2, 5.0),
    st.floats(0.2, 5.0),
    st.floats(0.2, 5.0),
    st.floats(-np.pi, np.pi),
    st.floats(0.0, 6.0),
)
def test_two_knife_edges_in_line_pass_their_quadrant(s1, s2, s3, psi, polarisation):
    """Fresnel: 1/4 + arcsin(w) / 2 pi, w the coupling of edges that cross at the angle psi."""
    sheets = [Y, np.cos(psi) * Y + np.sin(psi) * Z]
    edges = Edges([[*t, *-X, 2.0] for t in sheets], k=1e12)
    field = np.cos(polarisation) * Y + np.sin(polarisation) * Z
    total = s1 + s2 + s3
    # Each edge hides the source from the other, so that only the path over both is left.
    d = edges.twice(0, 1, False, (s1, s2, s3), (X, X, X), field)
    passed = d * np.sqrt(total / (s1 * s2 * s3))
    w = np.cos(psi) * np.sqrt(s1 * s3 / ((s1 + s2) * (s2 + s3)))
    quadrant = 0.25 + np.arcsin(w) / (2.0 * np.pi)
    assert passed == pytest.approx(quadrant * field, abs=2e-5)


# Rectangular cylinders against the method of moments


def blocked(p, q, lower, upper):
    with np.errstate(divide="ignore"):
        near, far = (lower + 1e-9 - p) / (q - p), (upper - 1e-9 - p) / (q - p)
    entry, leave = np.minimum(near, far).max(), np.maximum(near, far).min()
    return max(entry, 0.0) < min(leave, 1.0)


def to_3d(v):
    return np.array([v[0], v[1], 0.0])


def bent(edges, points, corners, kind, shared):
    """Field of a line source along a path over one or two corners, which share a face or not."""
    legs = np.diff(points, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    directions = [to_3d(leg / length) for leg, length in zip(legs, lengths, strict=True)]
    soft = kind == cylinders.SOFT
    field = Z if soft else np.cross(Z, directions[0])
    if len(corners) == 1:
        d = edges.once(*corners, lengths, directions, field)
    else:
        d = edges.twice(*corners, shared, lengths, directions, field)
    out = d @ (Z if soft else np.cross(Z, directions[-1]))
    far = np.sqrt(2j / (np.pi * K))
    return far * out * np.exp(-1j * K * lengths.sum()) / np.sqrt(np.prod(lengths))


class Cylinder:
    """UTD up to two edges about a conducting rectangle; a line source of field H0(2)(kR)."""

    def __init__(self, width, height, kind):
        self.corners = np.array([[0.0, -height], [width, -height], [width, 0.0], [0.0, 0.0]])
        self.kind = kind
        rows = []
        for a, b in zip(self.corners, np.roll(self.corners, -1, axis=0), strict=True):
            t = unit(b - a)
            rows.append([*to_3d(t), t[1], -t[0], 0.0, 1.5])
        self.edges = Edges(rows)

    def free(self, p, q):
        return not blocked(p, q, self.corners[0], self.corners[2])

    def geometrical(self, source, receiver):
        total = 0j
        if self.free(source, receiver):
            total += hankel2(0, K * np.linalg.norm(source - receiver))
        for i, corner in enumerate(self.corners):
            normal = self.edges.frames[i, 3:5]
            height, other = (source - corner) @ normal, (receiver - corner) @ normal
            if height <= 0.0 or other <= 0.0:
                continue
            image = source - 2.0 * height * normal
            hit = receiver + (image - receiver) * other / (height + other)
            side = self.corners[(i + 1) % 4] - corner
            if 0.0 <= (hit - corner) @ side <= side @ side:
                total += self.kind * hankel2(0, K * np.linalg.norm(image - receiver))
        return total

    def along(self, points, corners):
        return bent(self.edges, points, corners, self.kind, True)

    def total(self, source, receiver, order=2):
        total = self.geometrical(source, receiver)
        for i, corner in enumerate(self.corners):
            if not self.free(source, corner):
                continue
            if self.free(corner, receiver):
                total += self.along([source, corner, receiver], (i,))
            for j in ((i + 1) % 4, (i - 1) % 4) if order == 2 else ():
                other = self.corners[j]
                if self.free(other, receiver):
                    total += self.along([source, corner, other, receiver], (i, j))
        return total


ERRORS = [
    (cylinders.SOFT, 0.5, 3e-3),
    (cylinders.SOFT, 1.05, 2e-3),
    (cylinders.SOFT, 2.1, 2e-3),
    (cylinders.HARD, 0.5, 0.028),
    (cylinders.HARD, 1.05, 0.018),
    (cylinders.HARD, 2.1, 0.016),
]


@pytest.mark.parametrize(("kind", "width", "tolerance"), ERRORS)
def test_rectangular_cylinders_agree_with_the_method_of_moments(kind, width, tolerance):
    """Error over the free field all round the far side; without double diffraction 6 to 35 %."""
    cylinder = Cylinder(width, 3.03, kind)
    source = np.array([-3.0, -1.2])
    angle = np.radians(np.arange(-78.0, 80.0, 6.1))
    receivers = np.array([width, 0.0]) + 4.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    exact = cylinders.total_field(K, cylinder.corners, source, receivers, kind, per_side=90)
    free = np.abs(hankel2(0, K * np.linalg.norm(receivers - source, axis=1)))
    model = np.array([cylinder.total(source, r) for r in receivers])
    once = np.array([cylinder.total(source, r, order=1) for r in receivers])
    assert np.max(np.abs(model - exact) / free) < tolerance
    assert np.max(np.abs(once - exact) / free) > 10.0 * tolerance


@pytest.mark.parametrize(("kind", "tolerance"), [(cylinders.SOFT, 1.5e-3), (cylinders.HARD, 0.028)])
def test_two_ridges_in_line_agree_with_the_method_of_moments(kind, tolerance):
    """Over the tops of two bodies, where neither shares a face with the other."""
    one = np.array([(0.0, 0.0), (-3.0, -5.0), (3.0, -5.0)])
    bodies = one + np.array([(0.0, 0.0), (8.0, -0.3)])[:, None]
    tops = bodies[:, 0]
    down = to_3d(unit(one[2]))
    edges = Edges([[*down, -down[1], down[0], 0.0, 2.0 - 2.0 * np.arctan(0.6) / np.pi]] * 2)
    source = np.array([-6.0, -0.3])
    angle = np.radians(np.arange(-30.0, -3.0, 2.3))
    receivers = tops[1] + 5.0 * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    exact = cylinders.total_field(K, bodies, source, receivers, kind, per_side=70)
    free = np.abs(hankel2(0, K * np.linalg.norm(receivers - source, axis=1)))

    def over(points, corners):
        return bent(edges, points, corners, kind, False)

    both = np.array([over([source, *tops, r], (0, 1)) for r in receivers])
    assert np.max(np.abs(both - exact) / free) < tolerance
    assert np.max(np.abs(exact) / free) > 5.0 * tolerance


# Continuity: what an edge diffracts, cut off by the next edge


@pytest.mark.parametrize("permittivity", [CONDUCTOR, CONCRETE])
@pytest.mark.parametrize("slope", [0.0, 0.7])
@pytest.mark.parametrize("height_m", [-3.0, -0.3, -0.01])
@pytest.mark.parametrize("width_m", [0.1, 1.0, 5.0])
def test_the_field_of_one_edge_goes_over_into_that_of_two(width_m, height_m, slope, permittivity):
    """Past a thick screen, across the plane of its top: both polarisations, also obliquely."""
    edges = Edges([[*X, *Y, 1.5], [*-X, *Y, 1.5]], permittivity)
    lengths = np.array([np.hypot(2.0, height_m), width_m, 3.0])

    def leg(x, y):
        return unit(np.array([x, y, slope * np.hypot(x, y)]))

    into, along = leg(2.0, -height_m), leg(1.0, 0.0)
    s1, s2, s3 = lengths * np.hypot(1.0, slope)
    total = s1 + s2 + s3
    for field in (np.cross(into, Z), np.cross(into, np.cross(into, Z))):
        above, below = leg(1.0, 1e-8), leg(1.0, -1e-8)
        once = edges.once(0, (s1, s2 + s3), (into, above), field) / np.sqrt(s1 * (s2 + s3) * total)
        spread = np.sqrt(s1 * s2 * s3 * total)
        upper = edges.twice(0, 1, True, (s1, s2, s3), (into, along, above), field) / spread
        lower = edges.twice(0, 1, True, (s1, s2, s3), (into, along, below), field) / spread
        assert np.linalg.norm(once + upper - lower) * total < 1e-5 * np.linalg.norm(field)


def test_edges_far_apart_diffract_by_the_product_of_their_dyads():
    edges = Edges([[*X, *Y, 1.5], [*-Y, *-X, 1.3]])
    lengths = (200.0, 4e4, 300.0)
    directions = [unit(v) for v in (X + Y, 2.0 * X - 0.8 * Y, X - Y)]
    field = 0.3 * Z + 1j * np.cross(Z, directions[0])
    first = edges.once(0, lengths[:2], directions[:2], field)
    product = edges.once(1, lengths[1:], directions[1:], first)
    both = edges.twice(0, 1, False, lengths, directions, field)
    assert both == pytest.approx(product, rel=5e-3)


@given(
    st.floats(0.6, 2.0),
    st.floats(0.6, 2.0),
    st.floats(0.1, 2.0),
    st.sampled_from([CONDUCTOR, CONCRETE]),
    st.randoms(),
)
def test_double_diffraction_is_reciprocal(n_1, n_2, between, permittivity, random):
    """Skew edges of any wedge, with no common face."""
    rng = np.random.default_rng(random.randrange(2**32))
    rows, directions, middle = [], [], unit(rng.normal(size=3))
    for n, outward in ((n_1, False), (n_2, True)):
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        t0, n0 = q[0], q[1]
        turn = rng.uniform(0.1, 0.9) * n * np.pi
        # Turn the frame about its axis until the middle leg lies in the air.
        axis = np.cross(t0, n0)
        across = unit((middle - (middle @ axis) * axis) * (-1.0 if outward else 1.0))
        t0 = np.cos(turn) * across - np.sin(turn) * np.cross(axis, across)
        n0 = np.cross(axis, t0)
        rows.append([*t0, *n0, n])
        other = rng.uniform(0.1, 0.9) * n * np.pi
        side = np.cos(other) * t0 + np.sin(other) * n0
        sine = np.linalg.norm(np.cross(axis, middle))
        directions.append((middle @ axis) * axis + sine * side * (1.0 if outward else -1.0))
    edges = Edges(rows, permittivity)
    into, out = directions
    p, q = np.cross(into, rng.normal(size=3)), np.cross(out, rng.normal(size=3))
    there = q @ edges.twice(0, 1, False, (2.0, between, 3.0), (into, middle, out), p)
    back = p @ edges.twice(1, 0, False, (3.0, between, 2.0), (-out, -middle, -into), q)
    assert there == pytest.approx(back, abs=1e-9, rel=1e-6)


def test_both_sides_of_a_strip_carry_the_wave_between_its_edges():
    """Over one free edge and another; the sides are alike where source and receiver see both."""
    edges = Edges([[*X, *Y, 2.0], [*-X, *Y, 2.0]])
    corner = Edges([[*X, *Y, 2.0], [*-X, *Y, 1.9999999]])
    lengths, directions = (2.0, 1.5, 3.0), (X, X, X)
    both = edges.twice(0, 1, True, lengths, directions, Y)
    one = corner.twice(0, 1, True, lengths, directions, Y)
    assert both == pytest.approx(2.0 * one, rel=1e-5)


@given(st.floats(1e-3, 100.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.booleans())
def test_two_edges_at_any_distance_are_finite(width_m, rise, fall, lossy):
    edges = Edges([[*X, *Y, 1.5], [*-X, *Y, 1.5]], CONCRETE if lossy else CONDUCTOR)
    directions = (unit(X + rise * Y), X, unit(X - fall * Y))
    for lengths in ((1.0, width_m, 1.0), (1e-4, width_m, 1e-4), (1e5, width_m, 1e5)):
        assert np.isfinite(edges.twice(0, 1, True, lengths, directions, Y + Z)).all()
