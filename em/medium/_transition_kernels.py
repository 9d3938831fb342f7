# mypy: allow-untyped-defs
"""Compiled transition function of the uniform theory of diffraction."""

import numpy as np

from octant.geometries.kernels import kernel

# Midpoint rule of step sqrt(pi / (N + 1/2)) on the integral of the Faddeeva function, as Al Azah,
# Chandler-Wilde and La Porte (2014) choose it: 12 points give 16 digits everywhere.
_POINTS = 12
_STEP = np.sqrt(np.pi / (_POINTS + 0.5))
_NODES_SQUARED = (_STEP * (np.arange(_POINTS) + 0.5)) ** 2
_NODES_FOURTH = _NODES_SQUARED**2
_WEIGHTS = 2.0 * _STEP / np.pi * np.exp(-_NODES_SQUARED)
_ASYMPTOTIC_FROM = 100.0
_ASYMPTOTIC_TERMS = 12
_TURN = np.sqrt(0.5) * (1.0 + 1.0j)  # e^{j pi/4}


@kernel
def scaled_transition(x):
    """Return F(x) / sqrt(x), finite down to x = 0, for real x >= 0."""
    if x > _ASYMPTOTIC_FROM:
        # F(x) ~ sum of (2m - 1)!! (j / 2x)^m
        u = 1j / (2.0 * x)
        series = complex(1.0, 0.0)
        for m in range(_ASYMPTOTIC_TERMS, 0, -1):
            series = 1.0 + (2 * m - 1) * u * series
        return series / np.sqrt(x)
    root = np.sqrt(x)
    # erfcx(e^{j pi/4} root) = w(z), z = j e^{j pi/4} root: the sum, then the pole's share.
    re, im = 0.0, 0.0
    for i in range(_POINTS):
        weight = _WEIGHTS[i] / (_NODES_FOURTH[i] + x * x)
        re += weight * _NODES_SQUARED[i]
        im -= weight * x
    y = np.sqrt(2.0) * np.pi * root / _STEP
    pole = 2.0 * np.exp(1j * x) / (1.0 + np.exp(complex(y, y)))
    faddeeva = root * _TURN * complex(re, im) + pole
    return np.sqrt(np.pi) * _TURN * faddeeva


@kernel
def transition(x):
    """Return the transition function F(x) of Kouyoumjian and Pathak for real x >= 0."""
    return np.sqrt(x) * scaled_transition(x)


@kernel
def fill_transition(x, out):
    """Fill (n,) values of the transition function."""
    for i in range(len(x)):
        out[i] = transition(x[i])


# Gauss rules for the generalised Fresnel integral: Legendre on [0, 1] where the lower limit x is
# below _NEAR, Laguerre along the path of steepest descent beyond.
_NEAR = 2.0
_TINY = 1e-12
# Detours over an edge's end times the wavenumber [rad], from and up to which the end is faded out.
END_FADES, END_REACH = 2.0, 6.0
_LEGENDRE, _LEGENDRE_WEIGHTS = np.polynomial.legendre.leggauss(14)
_LEGENDRE, _LEGENDRE_WEIGHTS = 0.5 * (_LEGENDRE + 1.0), 0.5 * _LEGENDRE_WEIGHTS
STEEP_NODES = 20
_LAGUERRE, _LAGUERRE_WEIGHTS = np.polynomial.laguerre.laggauss(STEEP_NODES)


@kernel
def steep_descent(x, weights):
    """Fill (20,) numbers that a generalised Fresnel integral takes from its lower limit alone.

    Weights of the path of steepest descent from x, or where x is small e^{-j t^2} between 0 and x.
    """
    if x > _NEAR:
        for i in range(len(_LAGUERRE)):
            weights[i] = _LAGUERRE_WEIGHTS[i] / np.sqrt(complex(x * x, -_LAGUERRE[i]))
    else:
        for i in range(len(_LEGENDRE)):
            weights[i] = np.exp(-1j * (x * _LEGENDRE[i]) ** 2)


@kernel
def generalized_fresnel(x, y, weights):
    """Return y e^{j x^2} times the integral of e^{-j t^2} / (t^2 + y^2) over t > x, x >= 0.

    ``weights`` are those of :func:`steep_descent` from x.
    """
    total = 0j
    if x > _NEAR:
        square = x * x + y * y
        for i in range(len(_LAGUERRE)):
            # 1 / (square - j t), without a complex division
            over = 1.0 / (square * square + _LAGUERRE[i] * _LAGUERRE[i])
            total += weights[i] * complex(square * over, _LAGUERRE[i] * over)
        return -0.5j * y * total
    if y == 0.0:
        return 0j
    size = abs(y)
    # From 0 to infinity it is the transition function; from 0 to x the pole's share is taken out.
    turn = np.exp(1j * y * y)
    for i in range(len(_LEGENDRE)):
        t = x * _LEGENDRE[i]
        total += _LEGENDRE_WEIGHTS[i] / (t * t + y * y) * (weights[i] - turn)
    total = size * x * total + turn * np.arctan2(x, size)
    total = 0.5 * np.sqrt(np.pi) * np.conj(_TURN) * scaled_transition(y * y) - total
    return np.exp(1j * x * x) * np.copysign(1.0, y) * total


@kernel
def double_transition(a, b, w, weights_a, weights_b):
    """Return T(a, b, w) / (a b) of two edges, a and b >= 0 and |w| < 1.

    T is 1 far from both boundaries, and F(a^2) F(b^2) where w = 0. The weights are those of
    :func:`steep_descent` from a and from b.
    """
    # On both boundaries at once the two halves are directions: any will do, but not 0 / 0.
    a, b = max(a, _TINY), max(b, _TINY)
    root = np.sqrt(1.0 - w * w)
    first = generalized_fresnel(a, (b + w * a) / root, weights_a)
    second = generalized_fresnel(b, (a + w * b) / root, weights_b)
    return 2j / root * (first + second)


AT_END = 1e-6
"""Root of a detour times k that counts for any below it: on an image's boundary and at an end, the
ratio of both roots would be one of rounding; so it is that of a corner's bisector."""

_END_WEIGHTS = 3
END_SIZE = _END_WEIGHTS + STEEP_NODES
"""Numbers of an edge's end: root of the detour over it times k; factors with and without a pole;
:func:`steep_descent` from that root."""


@kernel
def fill_end(root, weight, end):
    """Fill the numbers of an edge's end whose part beyond counts with a weight [-]."""
    end[0] = root
    turn = weight / np.sqrt(np.pi) * np.exp(-1j * root * root)
    end[1] = turn * _TURN
    # Far from any pole: 1/2 where root is 0, the middle at the end; 0 far off.
    end[2] = 0.5 * turn * np.conj(_TURN) * scaled_transition(root * root)
    steep_descent(root, end[_END_WEIGHTS:])


@kernel
def beyond_ends(ends, y):
    """Return the part of an edge beyond its ends, times the scaled transition function of y^2.

    y^2 is the detour over the edge against an image's way, times the wavenumber. The image's field
    has a pole along the edge: of that field half lies beyond an end that is the middle.
    """
    part = 0j
    y = max(y, AT_END)
    for i in range(len(ends)):
        part += ends[i, 1] * generalized_fresnel(ends[i, 0].real, y, ends[i, _END_WEIGHTS:])
    return part


@kernel
def end_counts(detour):
    """Return how much of an edge's end counts [-] at a detour over it times the wavenumber."""
    share = (detour - END_FADES) / (END_REACH - END_FADES)
    if share <= 0.0:
        return 1.0
    return 0.0 if share >= 1.0 else (1.0 - share) ** 2 * (1.0 + 2.0 * share)
