# mypy: allow-untyped-defs
"""Compiled transition function of the uniform theory of diffraction."""

import numpy as np
from numba import njit

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


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def transition(x):
    """Return the transition function F(x) of Kouyoumjian and Pathak for real x >= 0."""
    return np.sqrt(x) * scaled_transition(x)


@njit(cache=True, error_model="numpy")
def fill_transition(x, out):
    """Fill (n,) values of the transition function."""
    for i in range(len(x)):
        out[i] = transition(x[i])


# Gauss rules for the generalised Fresnel integral: Legendre on [0, 1] where the lower limit x is
# below _NEAR, Laguerre along the path of steepest descent beyond.
_NEAR = 2.0
_TINY = 1e-12
_LEGENDRE, _LEGENDRE_WEIGHTS = np.polynomial.legendre.leggauss(14)
_LEGENDRE, _LEGENDRE_WEIGHTS = 0.5 * (_LEGENDRE + 1.0), 0.5 * _LEGENDRE_WEIGHTS
STEEP_NODES = 20
_LAGUERRE, _LAGUERRE_WEIGHTS = np.polynomial.laguerre.laggauss(STEEP_NODES)


@njit(cache=True, error_model="numpy")
def steep_descent(x, weights):
    """Fill (20,) weights of the integral's path of steepest descent from x, where it is taken."""
    if x > _NEAR:
        for i in range(len(_LAGUERRE)):
            weights[i] = _LAGUERRE_WEIGHTS[i] / np.sqrt(complex(x * x, -_LAGUERRE[i]))


@njit(cache=True, error_model="numpy")
def generalized_fresnel(x, y, weights):
    """Return y e^{j x^2} times the integral of e^{-j t^2} / (t^2 + y^2) over t > x, x >= 0.

    ``weights`` are those of :func:`steep_descent` from x.
    """
    if x > _NEAR:
        total = 0j
        square = x * x + y * y
        for i in range(len(_LAGUERRE)):
            # 1 / (square - j t), without a complex division
            over = 1.0 / (square * square + _LAGUERRE[i] * _LAGUERRE[i])
            total += weights[i] * complex(square * over, _LAGUERRE[i] * over)
        return -0.5j * y * total
    if y == 0.0:
        return 0j
    size = abs(y)
    # From 0 to infinity it is the transition function; from 0 to x, (e^{-jz} - 1) / z is entire.
    whole = 0.5 * np.sqrt(np.pi) * np.conj(_TURN) * scaled_transition(y * y)
    part = 0j
    for i in range(len(_LEGENDRE)):
        t = x * _LEGENDRE[i]
        z = t * t + y * y
        half = np.sin(0.5 * z)
        part += _LEGENDRE_WEIGHTS[i] * complex(-2.0 * half * half / z, -np.sin(z) / z)
    part = np.exp(1j * y * y) * (size * x * part + np.arctan2(x, size))
    return np.exp(1j * x * x) * np.copysign(1.0, y) * (whole - part)


@njit(cache=True, error_model="numpy")
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
