# mypy: allow-untyped-defs
"""Compiled coefficients of walls: half-spaces, slabs and stacks of layers, for the path kernels.

TE waves match across an interface by k_z, TM waves (by their magnetic field) by k_z / eps: with
these admittances p, scaled by the wave number of air, both reflect (p - p') / (p + p').
"""

import numpy as np

from octant.geometries.kernels import kernel

_TINY = 1e-300


@kernel(forceinline=True)
def _interface(near, far):
    """Return the reflection where a wave of admittance ``near`` meets one of admittance ``far``."""
    # In real numbers: a compiled complex division guards against overflow at many times the cost.
    up_r, up_i = near.real - far.real, near.imag - far.imag
    down_r, down_i = near.real + far.real, near.imag + far.imag
    # Both vanish where a wave grazes along two layers of air.
    scale = 1.0 / max(down_r * down_r + down_i * down_i, _TINY)
    return complex((up_r * down_r + up_i * down_i) * scale, (up_i * down_r - up_r * down_i) * scale)


@kernel(forceinline=True)
def _normal_wavenumber(eps_r, cosine):
    """Return k_z within a layer, over the wave number of air; it decays into the layer."""
    # eps - sin^2, written so that air is matched to air exactly, however grazing; its principal
    # root by halves, of which the larger is taken first, so that none loses digits.
    re, im = (eps_r.real - 1.0) + cosine * cosine, eps_r.imag
    larger = np.sqrt(0.5 * (np.sqrt(re * re + im * im) + abs(re)))
    smaller = 0.5 * im / max(larger, _TINY)
    decaying = -larger if im <= 0.0 else larger
    return complex(larger if re >= 0.0 else abs(smaller), smaller if re >= 0.0 else decaying)


@kernel(forceinline=True)
def half_space(eps_r, cosine):
    """Return the TE and TM reflection coefficients of a half-space; an infinite |eps_r| is PEC."""
    # Without a branch, so that several are computed at once.
    conducts = abs(eps_r.imag) == np.inf
    root = _normal_wavenumber(eps_r, cosine)
    dense = complex(eps_r.real * cosine, eps_r.imag * cosine)
    te, tm = _interface(complex(cosine), root), _interface(dense, root)
    return (
        complex(-1.0 if conducts else te.real, 0.0 if conducts else te.imag),
        complex(1.0 if conducts else tm.real, 0.0 if conducts else tm.imag),
    )


@kernel
def slab(eps_r, cosine, thickness):
    """Return reflection TE, TM and transmission TE, TM of a slab; thickness in wavelengths."""
    if np.isinf(eps_r.imag):
        return complex(-1.0, 0.0), complex(1.0, 0.0), complex(0.0, 0.0), complex(0.0, 0.0)
    root = _normal_wavenumber(eps_r, cosine)
    te, tm = _interface(complex(cosine), root), _interface(eps_r * cosine, root)
    once = np.exp(-2j * np.pi * thickness * root)
    twice = once * once
    te2, tm2 = te * te, tm * tm
    te_loop, tm_loop = 1.0 - te2 * twice, 1.0 - tm2 * twice
    if te_loop == 0.0 or tm_loop == 0.0:  # without loss, in resonance, and at grazing
        return te, tm, complex(0.0, 0.0), complex(0.0, 0.0)
    te_sum, tm_sum = 1.0 / te_loop, 1.0 / tm_loop
    te_back, tm_back = te * (1.0 - twice) * te_sum, tm * (1.0 - twice) * tm_sum
    return te_back, tm_back, (1.0 - te2) * once * te_sum, (1.0 - tm2) * once * tm_sum


@kernel(inline="always")
def wall(permittivity, thickness, begin, end, cosine, from_front):
    """Return reflection TE, TM and transmission TE, TM of layers ``begin`` to ``end`` of a table.

    Thicknesses are in wavelengths; a last layer of infinite thickness is all that lies behind, and
    such a wall is seen from its front whichever side is hit. ``from_front`` says whether the wave
    comes from the side of the first layer.
    """
    # Inlined, so that a wall of one layer, the usual case, costs no count for the two arrays.
    if end - begin == 1:
        if np.isinf(thickness[begin]):
            te, tm = half_space(permittivity[begin], cosine)
            return te, tm, complex(0.0, 0.0), complex(0.0, 0.0)
        return slab(permittivity[begin], cosine, thickness[begin])
    return _stack(permittivity, thickness, begin, end, cosine, from_front)


@kernel(inline="always")
def displaced_air(thickness, begin, end, cosine):
    """Return what turns a transmission into one relative to the air that the wall displaces.

    It does so along the wall's normal, since the lengths of paths are those of straight rays.
    """
    depth = 0.0
    for layer in range(begin, end):
        depth += thickness[layer]
    turn = 2.0 * np.pi * depth * cosine
    return complex(np.cos(turn), np.sin(turn))


@kernel
def _stack(permittivity, thickness, begin, end, cosine, from_front):
    """Return what ``wall`` does, for any number of layers.

    Layer by layer from the far side, ``back`` and ``out`` are what a wave meets that stands just
    inside the nearest layer done so far, whose admittances are ``p``. Only decaying exponentials
    appear, so no thickness and no loss overflows.
    """
    p_te, p_tm = complex(cosine), complex(cosine)
    back_te, back_tm = complex(0.0, 0.0), complex(0.0, 0.0)
    out_te, out_tm = complex(1.0, 0.0), complex(1.0, 0.0)
    closed = np.isinf(thickness[end - 1])
    for i in range(end - begin):
        layer = end - 1 - i if from_front or closed else begin + i
        eps_r = permittivity[layer]
        if np.isinf(eps_r.imag):  # whatever p_te > 0 and p_tm = 0 stand for, all is sent back
            p_te, p_tm = complex(1.0, 0.0), complex(0.0, 0.0)
            back_te, back_tm = complex(-1.0, 0.0), complex(1.0, 0.0)
            out_te, out_tm = complex(0.0, 0.0), complex(0.0, 0.0)
            continue
        root = _normal_wavenumber(eps_r, cosine)
        if np.isinf(thickness[layer]):
            p_te, p_tm = root, root / eps_r
            out_te, out_tm = complex(0.0, 0.0), complex(0.0, 0.0)
            continue
        once = np.exp(-2j * np.pi * thickness[layer] * root)
        back_te, out_te = _before(root, p_te, back_te, out_te, once)
        back_tm, out_tm = _before(root / eps_r, p_tm, back_tm, out_tm, once)
        p_te, p_tm = root, root / eps_r
    one = complex(1.0, 0.0)
    back_te, out_te = _before(complex(cosine), p_te, back_te, out_te, one)
    back_tm, out_tm = _before(complex(cosine), p_tm, back_tm, out_tm, one)
    return back_te, back_tm, out_te, out_tm


@kernel
def _before(near, far, back, out, once):
    """Return ``back`` and ``out`` with one more interface and the way through a layer before it."""
    face = _interface(near, far)
    loop = 1.0 + face * back
    if loop == 0.0:  # without loss, in resonance, and at grazing
        return face, complex(0.0, 0.0)
    total = once / loop
    return (face + back) * total * once, (1.0 + face) * out * total


@kernel
def fill_half_space(eps_r, cosine, te, tm):
    """Fill (n,) coefficients of a half-space."""
    for i in range(len(cosine)):
        te[i], tm[i] = half_space(eps_r, cosine[i])


@kernel
def fill_wall(permittivity, thickness, cosine, from_front, out):
    """Fill (4, n) coefficients of a wall."""
    for i in range(len(cosine)):
        out[0, i], out[1, i], out[2, i], out[3, i] = wall(
            permittivity, thickness, 0, len(thickness), cosine[i], from_front
        )
