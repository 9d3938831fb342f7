# mypy: allow-untyped-defs
"""Compiled coefficient of two edges one after the other, uniform where both boundaries overlap."""

import numpy as np
from numba import njit

from octant.em.medium._transition_kernels import double_transition, scaled_transition
from octant.em.medium._wedge_kernels import (
    cotangent_transition,
    image_boundary,
    image_is_lit,
    second_order_share,
)
from octant.em.medium._wedge_weight_kernels import boundary_weight

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
# stands alone; then the 2 x 2 weight and its slope.
TERM_SIZE = 17
_WEIGHT, _SLOPE = 9, 13


@njit(cache=True, error_model="numpy")
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
    """Fill (4, 17) terms of one edge; ``leaving`` where the leg between both edges leaves it.

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
            detour = 2.0 * k_between * half * half
            side = term[2] * turned
            term[7] = side * np.sqrt(2.0 * k_between) * scaled_transition(detour)
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


@njit(cache=True, error_model="numpy")
def _add_product(factor, second, second_at, turn, first, first_at, out):
    """Add factor * second . turn . first, all 2 x 2, to ``out``."""
    for i in range(2):
        for j in range(2):
            for p in range(2):
                for q in range(2):
                    out[i, j] += (
                        factor
                        * second[second_at + 2 * i + p]
                        * turn[p, q]
                        * first[first_at + 2 * q + j]
                    )


@njit(cache=True, error_model="numpy")
def _slopes(terms, kl, by_angle, by_wall):
    """Fill the slopes of one edge's field (4,): of its cotangents, and of its walls."""
    by_angle[:] = 0.0
    by_wall[:] = 0.0
    for p in range(4):
        term = terms[p]
        half = term[1].real
        x = 2.0 * kl * half * half
        scaled = scaled_transition(x)
        bent = 4j * kl * (1.0 - np.sqrt(x) * scaled)  # slope transition function over sin^2
        for i in range(4):
            by_angle[i] += term[3] * term[4] * bent * term[_WEIGHT + i]
            # A wall's slope may not jump at the boundary, where no single ray would make up for it.
            by_wall[i] += term[2] * term[0] * half * bent * term[_SLOPE + i]


@njit(cache=True, error_model="numpy")
def double_sum(first, second, turn, k_first, k_second, w, out):
    """Fill the 2 x 2 sum over all pairs of boundaries, times the edges' factors the coefficient.

    ``turn`` takes (b, h) of the first edge to that of the second; k L of both; w couples them.
    """
    out[:] = 0.0
    inverse = 1.0 / np.sqrt(k_first * k_second)
    share = second_order_share(k_first) * second_order_share(k_second)
    for p in range(4):
        a = np.sqrt(2.0 * k_first) * first[p, 1].real
        one = 4j * k_first * (1.0 - a * scaled_transition(a * a))
        for q in range(4):
            b = np.sqrt(2.0 * k_second) * second[q, 1].real
            two = 4j * k_second * (1.0 - b * scaled_transition(b * b))
            coupling = -w * (first[p, 3] * second[q, 3]).real
            side = (first[p, 2] * second[q, 2]).real
            pair = 2.0 * side * first[p, 0] * second[q, 0] / inverse
            pair *= double_transition(a, b, coupling * side)
            # What each edge has beyond its pole, seen past the other.
            pair += first[p, 8] * second[q, 7] + first[p, 7] * second[q, 8]
            # What the slopes of the cotangents have beyond those of their poles.
            bent = first[p, 5] * one * second[q, 6] + first[p, 6] * second[q, 5] * two
            bent += first[p, 6] * second[q, 6]
            pair -= 1j * coupling * inverse * share * bent
            _add_product(pair, second[q], _WEIGHT, turn, first[p], _WEIGHT, out)
    angle_1, wall_1 = np.empty(4, np.complex128), np.empty(4, np.complex128)
    angle_2, wall_2 = np.empty(4, np.complex128), np.empty(4, np.complex128)
    _slopes(first, k_first, angle_1, wall_1)
    _slopes(second, k_second, angle_2, wall_2)
    factor = 1j * w * inverse
    _add_product(factor, angle_2, 0, turn, wall_1, 0, out)
    _add_product(factor, wall_2, 0, turn, angle_1, 0, out)
    _add_product(factor, wall_2, 0, turn, wall_1, 0, out)
