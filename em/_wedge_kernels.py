# mypy: allow-untyped-defs
"""Compiled diffraction coefficients of one wedge.

Fields at an edge are written along b, the part of the edge's axis across the ray, and h = axis x
ray: a wave with E along b is soft, with E along h hard. With the azimuth counted from face 0 these
two span the same plane for incident, reflected and diffracted rays, and a perfect conductor turns
(b, h) into (-b, +h). 2 x 2 matrices travel as four scalars, row by row. A face is (begin, end,
front, passes): its layers in the tables of permittivity and thickness, whether the first of them
is the one in the wedge's air, and whether it lets waves through.
"""

import numpy as np
from numba import njit

from octant.em._reflection_kernels import displaced_air, wall
from octant.em._transition_kernels import scaled_transition

_TWO_PI = 2.0 * np.pi
# The least cosine of incidence: exactly at grazing the coefficients of air would be 0 / 0.
_GRAZING = 1e-6
_SAME_ANGLE = 1e-9
# Reach of an obstacle's rim over the tolerance of a facet's: 1e-10 of a side, 1e-9 of a scene.
_RIM = 0.1
# Half-angle below which the second-order part of a term is rounding.
_NEGLIGIBLE = 1e-7


@njit(cache=True, error_model="numpy", inline="always")
def face(faces, edge, which):
    """Return face 0 or n of an edge from (e, 2, 4) integers."""
    return (
        faces[edge, which, 0],
        faces[edge, which, 1],
        faces[edge, which, 2],
        faces[edge, which, 3],
    )


@njit(cache=True, error_model="numpy")
def azimuth(along, above, n):
    """Return the angle from face 0 to the direction (along, above), kept within [0, n pi]."""
    angle = np.arctan2(above, along)
    if angle < 0.0:
        turned = angle + _TWO_PI
        angle = 0.0 if turned - n * np.pi > -angle else turned
    return min(angle, n * np.pi)


@njit(cache=True, error_model="numpy")
def cotangent_transition(x, lit, n, kl, ks):
    """Return the term of one image whose boundary is x = 0, on its lit or its dark side.

    cot(x / 2n) F(X) + P (1 - F(X)) with X the detour over the edge times k. P is the next order in
    1 / kL of Macdonald's integral; for a plane wave on a half-plane the Ps cancel.
    """
    half = np.sin(0.5 * abs(x))
    wedge = np.sin(0.5 * abs(x) / n)
    ratio = half / wedge if wedge > 0.0 else n
    turned = np.cos(0.5 * x / n) * ratio  # cot(|x| / 2n) sin(|x| / 2)
    curved = 2.0 / (1.0 + np.sqrt(max(1.0 - 4.0 * kl / ks * half * half, 0.0)))
    root = np.sqrt(2.0 * kl * curved)
    detour = root * root * half * half
    scaled = scaled_transition(detour)
    value = turned * root * scaled
    if half > _NEGLIGIBLE:
        rest = 1.0 - curved * (ratio * ratio / (n * n) + 0.5 * half * half * (1.0 + kl / ks))
        value += turned / half * rest * (1.0 - root * half * scaled)
    return value if lit else -value


@njit(cache=True, error_model="numpy")
def _faces_of(mirrored, number):
    """Return the nearest, the step to the next, and the count of the faces that make an image.

    Faces stand at multiples m of n pi of the unfolded wedge: even ones are face 0.
    """
    if number > 0:
        return 1, 1, 2 * number - (1 if mirrored else 0)
    return 0, -1, -2 * number + (1 if mirrored else 0)


@njit(cache=True, error_model="numpy")
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
    nearest, step, count = _faces_of(mirrored, number)
    for i in range(count):
        slant = min(slant, abs(np.sin((nearest + step * i) * n * np.pi - phi_out)))
    return x >= -touch * slant


@njit(cache=True, error_model="numpy", inline="always")
def _conducts(permittivity, face, conductor):
    """Return whether the layer that a wave from the wedge's air meets first counts as perfect."""
    return abs(permittivity[face[0] if face[2] else face[1] - 1]) >= conductor


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def _mirror(te, tm, c, q):
    """Return the reflection in (b, h); (c, q) is the TE direction of the wave before."""
    size = c * c + q * q
    if size < 1e-18:  # along the normal te = -tm, and any direction is perpendicular
        return te, 0j, 0j, tm
    cc, qq, cq = c * c / size, q * q / size, c * q / size
    cross = (te + tm) * cq
    return te * cc - tm * qq, cross, -cross, tm * cc - te * qq


@njit(cache=True, error_model="numpy")
def _window(te, tm, c, q):
    """Return the transmission in (b, h); (c, q) is the TE direction."""
    size = c * c + q * q
    if size < 1e-18:
        return te, 0j, 0j, tm
    cc, qq, cq = c * c / size, q * q / size, c * q / size
    cross = (te - tm) * cq
    return te * cc + tm * qq, cross, cross, te * qq + tm * cc


@njit(cache=True, error_model="numpy")
def _times(a, b, c, d, e, f, g, h):
    return a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
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
    nearest, step, count = _faces_of(mirrored, number)
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


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def image_boundary(mirrored, sign, phi_in, phi_out, n):
    """Return the image whose boundary, beta = 2 n pi number - sign pi, is nearest, and x.

    x is the angle to that boundary, positive where the image is lit.
    """
    beta = phi_out + phi_in if mirrored else phi_out - phi_in
    number = int(np.rint((beta + sign * np.pi) / (_TWO_PI * n)))
    return number, np.pi + sign * (beta - _TWO_PI * n * number)


@njit(cache=True, error_model="numpy")
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
        if n > 2.0 - _SAME_ANGLE:
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


@njit(cache=True, error_model="numpy")
def shortened(before, after):
    """Return s s' / (s + s'), also when one of them is infinite."""
    short, long = min(before, after), max(before, after)
    return short / (1.0 + short / long)


@njit(cache=True, error_model="numpy")
def edge_factor(n, sin_beta, wavenumber):
    """Return what multiplies the sum of the four terms [sqrt(m)]."""
    return -np.sqrt(0.5) * (1.0 - 1.0j) / (2.0 * n * np.sqrt(_TWO_PI * wavenumber) * sin_beta)


@njit(cache=True, error_model="numpy")
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
):
    """Return the 2 x 2 diffraction dyad in (b, h) [sqrt(m)]."""
    kl = wavenumber * shortened(before, after) * sin_beta * sin_beta
    ks = wavenumber * (before + after)
    closes = abs(np.rint(1.0 / n) * n - 1.0) < _SAME_ANGLE
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
                term = cotangent_transition(x, lit, n, kl, ks)
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


@njit(cache=True, error_model="numpy")
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
            _SAME_ANGLE,
        )
