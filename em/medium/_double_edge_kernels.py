# mypy: allow-untyped-defs
"""Compiled coefficient of two edges one after the other, uniform where both boundaries overlap."""

import numpy as np

from octant.em.medium._transition_kernels import (
    STEEP_NODES,
    beyond_ends,
    double_transition,
    scaled_transition,
    steep_descent,
)
from octant.em.medium._wedge_kernels import (
    cotangent_transition,
    image_boundary,
    image_is_lit,
    left_by,
    left_of_rest,
    second_order_share,
)
from octant.em.medium._wedge_weight_kernels import boundary_weight
from octant.geometries.kernels import kernel

_STEP = 1e-4  # [rad], of the one-sided slope of a wall's coefficients
_NEAR_BOUNDARY = 1e-4
# Permittivity from which on a face is a perfect conductor: its coefficients turn from their values
# at grazing to those of a conductor within an angle far narrower than any edge's transition.
_CONDUCTOR = 2500.0
# Greatest change of a wall's coefficients within one width of an edge's transition.
_STEEPEST = 4.0
# Columns of a term: |cot(x / 2n) sin(x / 2)|, |sin(x / 2)|, lit side +-1, dx / dphi of the leg
# between the edges, sin^2(x / 2) times the cotangent's slope and its pole's, and their difference
# without sin^2; the term between the edges, and what it has beyond the pole's where this edge
# stands alone; the detour's root and the slope transition function over sin^2; then the 2 x 2
# weight and its slope.
TERM_SIZE = 19
_DETOUR, _BENT = 9, 10
_WEIGHT, _SLOPE = 11, 15
# Difference of two halves [-], sin |x| / 2, that is rounding.
_SAME_HALF = 1e-15
# Sum of two detours times k [rad] that is rounding: neither edge is nearer to its boundary.
_ON_BOTH = 1e-20


@kernel
def fill_terms(
    leaving,
    along_face,
    phi_in,
    phi_out,
    n,
    cos_beta,
    sin_beta,
    permittivity,
    thickness,
    face_0,
    face_n,
    touch,
    k_between,
    k_alone,
    k_total,
    terms,
):
    """Fill (4, 19) terms of one edge; ``leaving`` where the leg between both edges leaves it.

    Where that leg runs along a face, source and image are hidden together by an edge touched.

    k L with the other edge as source or receiver; k L and k (s + s') without the other edge.
    """
    middle = phi_out if leaving else phi_in
    step = _STEP if middle < 0.5 * n * np.pi else -_STEP
    row = 0
    for mirrored in (False, True):
        for sign in (1.0, -1.0):
            number, x = image_boundary(mirrored, sign, phi_in, phi_out, n)
            half = np.sin(0.5 * abs(x))
            wedge = np.sin(0.5 * abs(x) / n)
            ratio = half / wedge if wedge > 0.0 else n
            turned = np.cos(0.5 * x / n) * ratio
            term = terms[row]
            term[0] = turned
            term[1] = half
            if along_face:
                lit = image_is_lit(False, 0, x, phi_out, n, touch)
            else:
                lit = image_is_lit(mirrored, number, x, phi_out, n, touch)
            term[2] = 1.0 if lit else -1.0
            term[3] = sign if leaving or mirrored else -sign
            term[4] = -0.5 * ratio * ratio / n
            term[5] = -0.5 * turned
            if half > _NEAR_BOUNDARY:
                term[6] = (term[4] - term[5]) / (half * half)
            else:
                term[6] = n / 12.0 - 1.0 / (3.0 * n)
            root = np.sqrt(2.0 * k_between)
            detour = root * half
            scaled = scaled_transition(detour * detour)
            side = term[2] * turned
            term[7] = side * root * scaled
            term[_DETOUR] = detour
            term[_BENT] = 4j * k_between * (1.0 - detour * scaled)
            detour = 2.0 * k_alone * half * half
            pole = side * np.sqrt(2.0 * k_alone) * scaled_transition(detour)
            term[8] = cotangent_transition(x, lit, n, k_alone, k_total) - pole
            weights = boundary_weight(
                mirrored,
                sign,
                number,
                phi_in,
                phi_out,
                n,
                cos_beta,
                sin_beta,
                permittivity,
                thickness,
                face_0,
                face_n,
                _CONDUCTOR,
            )
            moved = boundary_weight(
                mirrored,
                sign,
                number,
                phi_in if leaving else phi_in + step,
                phi_out + step if leaving else phi_out,
                n,
                cos_beta,
                sin_beta,
                permittivity,
                thickness,
                face_0,
                face_n,
                _CONDUCTOR,
            )
            size = 0.0
            for i in range(4):
                term[_WEIGHT + i] = weights[i]
                term[_SLOPE + i] = (moved[i] - weights[i]) / step
                size += abs(term[_SLOPE + i]) ** 2
            steepest = _STEEPEST * np.sqrt(2.0 * k_between)
            if size > steepest * steepest:
                for i in range(4):
                    term[_SLOPE + i] *= steepest / np.sqrt(size)
            row += 1


@kernel
def _add_product(left, left_at, right, out):
    """Add left . right to ``out``; left starts at a place of its row."""
    for i in range(2):
        for j in range(2):
            for p in range(2):
                out[2 * i + j] += left[left_at + 2 * i + p] * right[2 * p + j]


@kernel
def _slopes(terms, by_angle, by_wall):
    """Fill the slopes of one edge's field (4,): of its cotangents, and of its walls."""
    by_angle[:] = 0.0
    by_wall[:] = 0.0
    for p in range(4):
        term = terms[p]
        for i in range(4):
            by_angle[i] += term[3] * term[4] * term[_BENT] * term[_WEIGHT + i]
            # A wall's slope may not jump at the boundary, where no single ray would make up for it.
            by_wall[i] += term[2] * term[0] * term[1] * term[_BENT] * term[_SLOPE + i]


@kernel
def _fill_transitions(first, second, w, values):
    """Fill (4, 4) values of T(a, b, w) / (a b) of all pairs of boundaries."""
    weights_1 = np.empty((4, STEEP_NODES), np.complex128)
    weights_2 = np.empty((4, STEEP_NODES), np.complex128)
    for p in range(4):
        steep_descent(first[p, _DETOUR].real, weights_1[p])
        steep_descent(second[p, _DETOUR].real, weights_2[p])
    for p in range(4):
        for q in range(4):
            # At a free edge both boundaries of an image lie equally far: two pairs are equal.
            if (
                p % 2 == 1
                and abs(first[p, 1] - first[p - 1, 1]) <= _SAME_HALF
                and abs(second[q, 1] - second[q ^ 1, 1]) <= _SAME_HALF
                and first[p, 2] == first[p - 1, 2]
                and second[q, 2] == second[q ^ 1, 2]
            ):
                values[p, q] = values[p - 1, q ^ 1]
                continue
            turns = (first[p, 3] * second[q, 3] * first[p, 2] * second[q, 2]).real
            values[p, q] = double_transition(
                first[p, _DETOUR].real,
                second[q, _DETOUR].real,
                -w * turns,
                weights_1[p],
                weights_2[q],
            )


@kernel
def double_sum(first, second, turn, k_first, k_second, w, cut_first, cut_second, corner, out):
    """Fill the 2 x 2 sum over all pairs of boundaries, times the edges' factors the coefficient.

    ``turn`` takes (b, h) of the first edge to that of the second; k L of both; w couples them. All
    2 x 2 matrices here are rows of four. What is left of either edge as in :func:`left_by`;
    ``corner`` has no end, or that where both edges meet, into which the pair fades, and its weights
    as an end of either edge.
    """
    inverse = 1.0 / np.sqrt(k_first * k_second)
    share = second_order_share(k_first) * second_order_share(k_second)
    transitions = np.empty((4, 4), np.complex128)
    _fill_transitions(first, second, w, transitions)
    behind, part = np.empty(4, np.complex128), np.zeros(4, np.complex128)
    left_1, left_2 = np.empty(4, np.complex128), np.empty(4, np.complex128)
    stretched = 1.0 / np.sqrt(1.0 - w * w)
    for p in range(4):
        left_1[p] = left_by(cut_first, stretched * first[p, _DETOUR].real)
        left_2[p] = left_by(cut_second, stretched * second[p, _DETOUR].real)
    tip, weight_1, weight_2 = corner
    out[:] = 0.0
    for q in range(4):
        behind[:] = 0.0
        for p in range(4):
            coupling = -w * (first[p, 3] * second[q, 3]).real
            side = (first[p, 2] * second[q, 2]).real
            pair = 2.0 * side * first[p, 0] * second[q, 0] / inverse * transitions[p, q]
            # What each edge has beyond its pole, seen past the other.
            pair += first[p, 8] * second[q, 7] + first[p, 7] * second[q, 8]
            # What the slopes of the cotangents have beyond those of their poles.
            bent = first[p, 5] * first[p, _BENT] * second[q, 6]
            bent += first[p, 6] * second[q, 5] * second[q, _BENT]
            bent += first[p, 6] * second[q, 6]
            pair -= 1j * coupling * inverse * share * bent
            pair *= left_1[p] * left_2[q]
            if len(tip) > 0:
                y_1, y_2 = first[p, _DETOUR].real ** 2, second[q, _DETOUR].real ** 2
                weight = 0.5 * (weight_1 + weight_2)
                if y_1 + y_2 > _ON_BOTH:
                    weight = (weight_1 * y_1 + weight_2 * y_2) / (y_1 + y_2)
                y = stretched * np.sqrt(y_1 + y_2)
                pair *= 1.0 - 2.0 * weight * beyond_ends(tip, y) / scaled_transition(y * y)
            for i in range(4):
                behind[i] += pair * first[p, _WEIGHT + i]
        part[:] = 0.0
        _add_product(turn, 0, behind, part)
        _add_product(second[q], _WEIGHT, part, out)
    angle_1, wall_1 = np.empty(4, np.complex128), np.empty(4, np.complex128)
    angle_2, wall_2 = np.empty(4, np.complex128), np.empty(4, np.complex128)
    _slopes(first, angle_1, wall_1)
    _slopes(second, angle_2, wall_2)
    factor = 1j * w * inverse * left_of_rest(cut_first) * left_of_rest(cut_second)
    for i in range(len(tip)):
        factor *= 1.0 - (weight_1 + weight_2) * tip[i, 2]
    for i in range(4):
        behind[i] = factor * wall_1[i]
        wall_1[i] = factor * (angle_1[i] + wall_1[i])
    part[:] = 0.0
    _add_product(turn, 0, behind, part)
    _add_product(angle_2, 0, part, out)
    part[:] = 0.0
    _add_product(turn, 0, wall_1, part)
    _add_product(wall_2, 0, part, out)
