# mypy: allow-untyped-defs
"""Compiled weights of a wedge's images: the reflections and transmissions that each carries.

2 x 2 matrices over (b, h), see `_wedge_kernels`, travel as four scalars, row by row.
A face is (begin, end, front, passes): its layers in the tables of permittivity and thickness,
whether the first of them is the one in the wedge's air, and whether it lets waves through.
"""

import numpy as np

from octant.em.medium._reflection_kernels import displaced_air, wall
from octant.geometries.kernels import kernel

_TWO_PI = 2.0 * np.pi
# The least cosine of incidence: exactly at grazing the coefficients of air would be 0 / 0.
_GRAZING = 1e-6
SAME_ANGLE = 1e-9


@kernel
def faces_of(mirrored, number):
    """Return the nearest, the step to the next, and the count of the faces that make an image.

    Faces stand at multiples m of n pi of the unfolded wedge: even ones are face 0.
    """
    if number > 0:
        return 1, 1, 2 * number - (1 if mirrored else 0)
    return 0, -1, -2 * number + (1 if mirrored else 0)


@kernel(inline="always")
def _conducts(permittivity, face, conductor):
    """Return whether the layer that a wave from the wedge's air meets first counts as perfect."""
    return abs(permittivity[face[0] if face[2] else face[1] - 1]) >= conductor


@kernel
def _wall(permittivity, thickness, face, conductor, cosine):
    """Return reflection and transmission (te, tm each) at the cosine of incidence.

    The transmission is relative to the air that the sheet displaces. Layers of a permittivity from
    ``conductor`` on are perfect conductors.
    """
    if _conducts(permittivity, face, conductor):
        return complex(-1.0), complex(1.0), 0j, 0j
    cosine = max(cosine, _GRAZING)
    begin, end = face[0], face[1]
    te, tm, te_out, tm_out = wall(permittivity, thickness, begin, end, cosine, face[2] != 0)
    if te_out == 0.0 and tm_out == 0.0:
        return te, tm, te_out, tm_out
    air = displaced_air(thickness, begin, end, cosine)
    return te, tm, te_out * air, tm_out * air


@kernel
def _mirror(te, tm, c, q):
    """Return the reflection in (b, h); (c, q) is the TE direction of the wave before."""
    size = c * c + q * q
    if size < 1e-18:  # along the normal te = -tm, and any direction is perpendicular
        return te, 0j, 0j, tm
    cc, qq, cq = c * c / size, q * q / size, c * q / size
    cross = (te + tm) * cq
    return te * cc - tm * qq, cross, -cross, tm * cc - te * qq


@kernel
def _window(te, tm, c, q):
    """Return the transmission in (b, h); (c, q) is the TE direction."""
    size = c * c + q * q
    if size < 1e-18:
        return te, 0j, 0j, tm
    cc, qq, cq = c * c / size, q * q / size, c * q / size
    cross = (te - tm) * cq
    return te * cc + tm * qq, cross, cross, te * qq + tm * cc


@kernel
def _times(a, b, c, d, e, f, g, h):
    return a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h


@kernel
def _crossing(source_side, receiver_side, sharp):
    """Return the grazing angle at which a face is met, and that of its plane of incidence.

    On the boundary of the image both sides add up to pi, and either is the law of reflection. Off
    it both answers are the same seen from either end. ``sharp`` = 1 takes the nearer side, so that
    a ray along the face meets it at grazing, and shares the half-turn in proportion; 0 takes the
    half-angle, with which the two images that coincide on a flat or square wall agree.
    """
    total = source_side + receiver_side
    half = 0.5 * (np.pi + source_side - receiver_side)
    nearer = min(source_side, receiver_side, 0.5 * np.pi)
    shared = np.pi * min(max(source_side / total, 0.0), 1.0) if total > 0.0 else 0.0
    # Where source and receiver are both at grazing, so is the wave, however they share it.
    steep = np.sin(0.5 * min(total, np.pi))
    shared = np.arctan2(steep * np.sin(shared), np.cos(shared))
    grazing = sharp * nearer + (1.0 - sharp) * np.arcsin(abs(np.sin(half)))
    return grazing, sharp * shared + (1.0 - sharp) * half


@kernel
def _image_weight(
    mirrored,
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
    conductor,
):
    """Return the product of the reflections of the image at +-phi_in + 2 n pi number."""
    image = _TWO_PI * n * number + (-phi_in if mirrored else phi_in)
    nearest, step, count = faces_of(mirrored, number)
    if _conducts(permittivity, face_0, conductor) and _conducts(permittivity, face_n, conductor):
        return complex(1.0 - 2.0 * (count % 2)), 0j, 0j, complex(1.0)
    sharp = min(max(2.0 * (n - 1.0), 0.0), 1.0)
    nearly_flat = max(1.0 - 2.0 * abs(n - 1.0), 0.0)
    spare = abs(image - phi_out) - n * np.pi
    share = max(1.0 - n, 0.0) * np.pi / spare if spare > 0.0 else 0.0
    w00, w01, w10, w11 = complex(1.0), 0j, 0j, complex(1.0)
    for i in range(count - 1, -1, -1):  # from the source's side
        m = nearest + step * i
        face = m * n * np.pi
        source_side, receiver_side = step * (image - face), step * (face - phi_out)
        grazing, turn = _crossing(source_side, receiver_side, sharp)
        if count == 2:
            # On a nearly flat wall a wave bounces twice at grazing only: there both faces share
            # what n leaves of the half-turn, and on a flat one this image is the source.
            flat = share * source_side if i == 1 else np.pi - share * receiver_side
            grazing += nearly_flat * (np.arcsin(abs(np.sin(flat))) - grazing)
            turn += nearly_flat * (flat - turn)
        cosine = sin_beta * np.sin(grazing)
        if m % 2 == 0:
            te, tm, _, _ = _wall(permittivity, thickness, face_0, conductor, cosine)
            q = np.sin(turn) * cos_beta
        else:
            te, tm, _, _ = _wall(permittivity, thickness, face_n, conductor, cosine)
            q = -np.sin(turn) * cos_beta
        r00, r01, r10, r11 = _mirror(te, tm, np.cos(turn), q)
        w00, w01, w10, w11 = _times(r00, r01, r10, r11, w00, w01, w10, w11)
    return w00, w01, w10, w11


@kernel
def _blocked(
    upper,
    phi_in,
    phi_out,
    n,
    cos_beta,
    sin_beta,
    permittivity,
    thickness,
    face_0,
    face_n,
    conductor,
):
    """Return 1 - T, T being what the wedge's two sheets let through past the edge.

    ``upper`` is the shadow of a source on face 0's side.
    """
    inside = (2.0 - n) * np.pi
    total_turn = _TWO_PI - (phi_out - phi_in if upper else phi_in - phi_out)
    side = 1.0 if upper else -1.0
    first = phi_in if upper else n * np.pi - phi_in
    w00, w01, w10, w11 = complex(1.0), 0j, 0j, complex(1.0)
    for i in range(2):
        source_side = first + inside * i
        grazing, turn = _crossing(source_side, total_turn - source_side, 1.0)
        cosine = sin_beta * np.sin(grazing)
        if (i == 0) == upper:
            _, _, te, tm = _wall(permittivity, thickness, face_0, conductor, cosine)
        else:
            _, _, te, tm = _wall(permittivity, thickness, face_n, conductor, cosine)
        t00, t01, t10, t11 = _window(te, tm, np.cos(turn), side * np.sin(turn) * cos_beta)
        w00, w01, w10, w11 = _times(t00, t01, t10, t11, w00, w01, w10, w11)
    return 1.0 - w00, -w01, -w10, 1.0 - w11


@kernel
def _free_edge(
    mirrored, phi_in, phi_out, cos_beta, sin_beta, permittivity, thickness, face, conductor
):
    """Return 1 - T, or R where mirrored, of the one sheet that ends at the edge.

    Both its sides are one wall, so all terms take the coefficients at the one nearest angle.
    """
    grazing = min(phi_in, phi_out, _TWO_PI - phi_in, _TWO_PI - phi_out, 0.5 * np.pi)
    r_te, r_tm, t_te, t_tm = _wall(
        permittivity, thickness, face, conductor, sin_beta * np.sin(grazing)
    )
    receiver = phi_out if mirrored else _TWO_PI - phi_out
    if (phi_in + phi_out <= _TWO_PI) if mirrored else (phi_in <= phi_out):
        side = 1.0
        _, turn = _crossing(phi_in, receiver, 1.0)
    else:
        side = -1.0
        _, turn = _crossing(_TWO_PI - phi_in, _TWO_PI - receiver, 1.0)
    q = side * np.sin(turn) * cos_beta
    if mirrored:
        return _mirror(r_te, r_tm, np.cos(turn), q)
    t00, t01, t10, t11 = _window(t_te, t_tm, np.cos(turn), q)
    return 1.0 - t00, -t01, -t10, 1.0 - t11


@kernel
def boundary_weight(
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
    conductor,
):
    """Return the 2 x 2 weight of one term: what the field loses at its image's boundary."""
    if face_0[3] and face_n[3]:
        if n > 2.0 - SAME_ANGLE:
            # Of a sheet that is not the same from both sides each image has its own.
            face = face_n if mirrored and number > 0 else face_0
            return _free_edge(
                mirrored,
                phi_in,
                phi_out,
                cos_beta,
                sin_beta,
                permittivity,
                thickness,
                face,
                conductor,
            )
        if number == 0 and not mirrored and n > 1.0:
            return _blocked(
                sign < 0.0,
                phi_in,
                phi_out,
                n,
                cos_beta,
                sin_beta,
                permittivity,
                thickness,
                face_0,
                face_n,
                conductor,
            )
    return _image_weight(
        mirrored,
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
        conductor,
    )
