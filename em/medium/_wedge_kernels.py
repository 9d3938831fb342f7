# mypy: allow-untyped-defs
"""Compiled diffraction coefficients of one wedge.

Fields at an edge are written along b, the part of the edge's axis across the ray, and h = axis x
ray: a wave with E along b is soft, with E along h hard. With the azimuth counted from face 0 these
two span the same plane for incident, reflected and diffracted rays, and a perfect conductor turns
(b, h) into (-b, +h). 2 x 2 matrices travel as four scalars, row by row.
"""

import numpy as np

from octant.em.medium._transition_kernels import END_SIZE, beyond_ends, scaled_transition
from octant.em.medium._wedge_weight_kernels import SAME_ANGLE, boundary_weight, faces_of
from octant.geometries.kernels import kernel

_TWO_PI = 2.0 * np.pi
# Reach of an obstacle's rim over the tolerance of a facet's: 1e-10 of a side, 1e-9 of a scene.
_RIM = 0.1
# Half-angle below which the second-order part of a term is rounding.
_NEGLIGIBLE = 1e-7
# How fast the second order comes in over kL.
_SECOND_ORDER = 1.8


@kernel(inline="always")
def face(faces, edge, which):
    """Return face 0 or n of an edge from (e, 2, 4) integers."""
    return (
        faces[edge, which, 0],
        faces[edge, which, 1],
        faces[edge, which, 2],
        faces[edge, which, 3],
    )


@kernel
def azimuth(along, above, n):
    """Return the angle from face 0 to the direction (along, above), kept within [0, n pi]."""
    angle = np.arctan2(above, along)
    if angle < 0.0:
        turned = angle + _TWO_PI
        angle = 0.0 if turned - n * np.pi > -angle else turned
    return min(angle, n * np.pi)


@kernel
def second_order_share(kl):
    """Return how much counts of what is next in 1 / kL: nothing as kL goes to 0, all from 20 on.

    Where an end stands near the edge's line, that series has no meaning and would grow without
    bound. The share is the one that lies nearest to the exact field of a point source by conducting
    wedges of 270 to 360 degrees, which asks for 0.1 to 0.4 at kL = 0.1, 0.8 at 1 and 0.93 at 2.
    """
    return -np.expm1(-_SECOND_ORDER * kl)


@kernel
def cotangent_transition(x, lit, n, kl, ks):
    """Return the term of one image whose boundary is x = 0, on its lit or its dark side.

    cot(x / 2n) F(X) + P (1 - F(X)) with X the detour over the edge times k. P is the next order in
    1 / kL of Macdonald's integral; for a plane wave on a half-plane the Ps cancel.
    """
    return cut_transition(x, lit, n, kl, ks, whole_edge())


@kernel
def whole_edge():
    """Return an edge without ends, as what is left of one: see :func:`left_by`."""
    return 1.0, np.empty((0, END_SIZE), np.complex128)


@kernel
def left_by(cut, y):
    """Return what ``cut`` leaves [-] of an edge's term, y as in :func:`beyond_ends`.

    ``cut`` has the weight of the whole edge and, row by row, the ends that matter.
    """
    whole, ends = cut
    if len(ends) == 0:
        return complex(whole)
    return whole + beyond_ends(ends, y) / scaled_transition(y * y)


@kernel
def left_of_rest(cut):
    """Return what ``cut`` leaves [-] of what has no pole, see :func:`left_by`."""
    whole, ends = cut
    left = complex(whole)
    for i in range(len(ends)):
        left += ends[i, 2]
    return left


@kernel
def cut_transition(x, lit, n, kl, ks, cut):
    """Return :func:`cotangent_transition` of what is left of an edge, see :func:`left_by`."""
    half = np.sin(0.5 * abs(x))
    wedge = np.sin(0.5 * abs(x) / n)
    ratio = half / wedge if wedge > 0.0 else n
    turned = np.cos(0.5 * x / n) * ratio  # cot(|x| / 2n) sin(|x| / 2)
    curved = 2.0 / (1.0 + np.sqrt(max(1.0 - 4.0 * kl / ks * half * half, 0.0)))
    root = np.sqrt(2.0 * kl * curved)
    detour = root * root * half * half
    scaled = scaled_transition(detour)
    whole, ends = cut
    value = turned * root * (whole * scaled + beyond_ends(ends, root * half))
    if half > _NEGLIGIBLE:
        rest = 1.0 - curved * (ratio * ratio / (n * n) + 0.5 * half * half * (1.0 + kl / ks))
        rest = turned / half * rest * (1.0 - root * half * scaled) * second_order_share(kl)
        value += rest * left_of_rest(cut)
    return value if lit else -value


@kernel
def image_is_lit(mirrored, number, x, phi_out, n, touch):
    """Return whether an image counts as lit at the angle x from its boundary.

    As in the search for paths: the source itself is hidden by an edge that its ray touches, and a
    reflection on the rim of a face is there. ``touch`` is the angle of the facets' tolerance where
    a ray meets a face squarely; a slanting ray moves on the face by more than off the edge.
    """
    if abs(x) > touch:
        return x > 0.0
    if number == 0 and not mirrored:
        return x > _RIM * touch
    slant = 1.0
    nearest, step, count = faces_of(mirrored, number)
    for i in range(count):
        slant = min(slant, abs(np.sin((nearest + step * i) * n * np.pi - phi_out)))
    return x >= -touch * slant


@kernel
def image_boundary(mirrored, sign, phi_in, phi_out, n):
    """Return the image whose boundary, beta = 2 n pi number - sign pi, is nearest, and x.

    x is the angle to that boundary, positive where the image is lit.
    """
    beta = phi_out + phi_in if mirrored else phi_out - phi_in
    # Half-way between two images, as square to a face, rounding would choose.
    turns = (beta + sign * np.pi) / (_TWO_PI * n)
    number = int(np.rint(turns - np.copysign(SAME_ANGLE, turns)))
    return number, np.pi + sign * (beta - _TWO_PI * n * number)


@kernel
def shortened(before, after):
    """Return s s' / (s + s'), also when one of them is infinite."""
    short, long = min(before, after), max(before, after)
    return short / (1.0 + short / long)


@kernel
def edge_factor(n, sin_beta, wavenumber):
    """Return what multiplies the sum of the four terms [sqrt(m)]."""
    return -np.sqrt(0.5) * (1.0 - 1.0j) / (2.0 * n * np.sqrt(_TWO_PI * wavenumber) * sin_beta)


@kernel
def wedge_dyad(
    phi_in,
    phi_out,
    n,
    cos_beta,
    sin_beta,
    permittivity,
    thickness,
    face_0,
    face_n,
    wavenumber,
    before,
    after,
    touch,
    cut,
):
    """Return the 2 x 2 diffraction dyad in (b, h) [sqrt(m)] of what ``cut`` leaves of an edge."""
    kl = wavenumber * shortened(before, after) * sin_beta * sin_beta
    ks = wavenumber * (before + after)
    closes = abs(np.rint(1.0 / n) * n - 1.0) < SAME_ANGLE
    term = 0j
    d00, d01, d10, d11 = 0j, 0j, 0j, 0j
    for mirrored in (False, True):
        for sign in (1.0, -1.0):
            number, x = image_boundary(mirrored, sign, phi_in, phi_out, n)
            # Of a wedge pi/m two images a full turn apart are one: what one loses the other wins.
            again = closes and sign < 0.0
            if again:
                term = -term
            else:
                lit = image_is_lit(mirrored, number, x, phi_out, n, touch)
                # On that boundary the search keeps one of both, and which is not known here.
                both = closes and abs(x) <= touch
                term = 0j if both else cut_transition(x, lit, n, kl, ks, cut)
            w00, w01, w10, w11 = boundary_weight(
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
                np.inf,
            )
            d00 += term * w00
            d01 += term * w01
            d10 += term * w10
            d11 += term * w11
    scale = edge_factor(n, sin_beta, wavenumber)
    return scale * d00, scale * d01, scale * d10, scale * d11


@kernel
def fill_wedge_dyads(
    phi_in,
    phi_out,
    before,
    after,
    n,
    skew,
    faces,
    permittivity,
    thickness,
    wavenumber,
    out,
):
    """Fill (m, 2, 2) dyads of one wedge."""
    for i in range(len(phi_in)):
        out[i, 0, 0], out[i, 0, 1], out[i, 1, 0], out[i, 1, 1] = wedge_dyad(
            phi_in[i],
            phi_out[i],
            n,
            np.cos(skew),
            np.sin(skew),
            permittivity,
            thickness,
            face(faces, 0, 0),
            face(faces, 0, 1),
            wavenumber,
            before[i],
            after[i],
            SAME_ANGLE,
            whole_edge(),
        )
