# mypy: allow-untyped-defs
"""Compiled Fresnel coefficients, inlined into the path kernels."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def half_space(eps_r, cos_incidence):
    """Return the TE and TM reflection coefficients of a half-space; an infinite |eps_r| is PEC."""
    if np.isinf(eps_r.imag):
        return complex(-1.0, 0.0), complex(1.0, 0.0)
    root = np.sqrt(eps_r - (1.0 - cos_incidence * cos_incidence))
    te = (cos_incidence - root) / (cos_incidence + root)
    tm = (eps_r * cos_incidence - root) / (eps_r * cos_incidence + root)
    return te, tm


@njit(cache=True, error_model="numpy")
def slab(eps_r, cos_incidence, thickness_wavelengths):
    """Return reflection TE, TM and transmission TE, TM of a slab of finite thickness."""
    te, tm = half_space(eps_r, cos_incidence)
    if np.isinf(eps_r.imag):
        return te, tm, complex(0.0, 0.0), complex(0.0, 0.0)
    sin2 = 1.0 - cos_incidence * cos_incidence
    q = 2.0 * np.pi * thickness_wavelengths * np.sqrt(eps_r - sin2)
    once = np.exp(-1j * q)
    twice = once * once
    te_out = (1.0 - te * te) * once / (1.0 - te * te * twice)
    tm_out = (1.0 - tm * tm) * once / (1.0 - tm * tm * twice)
    te_back = te * (1.0 - twice) / (1.0 - te * te * twice)
    tm_back = tm * (1.0 - twice) / (1.0 - tm * tm * twice)
    return te_back, tm_back, te_out, tm_out


@njit(cache=True, error_model="numpy")
def fill_half_space(eps_r, cos_incidence, te, tm):
    """Fill (n,) coefficients of a half-space."""
    for i in range(len(cos_incidence)):
        te[i], tm[i] = half_space(eps_r, cos_incidence[i])


@njit(cache=True, error_model="numpy")
def fill_slab(eps_r, cos_incidence, thickness_wavelengths, out):
    """Fill (4, n) coefficients of a slab."""
    for i in range(len(cos_incidence)):
        out[0, i], out[1, i], out[2, i], out[3, i] = slab(
            eps_r, cos_incidence[i], thickness_wavelengths
        )
