# mypy: allow-untyped-defs
"""Compiled fields behind one edge and behind two."""

import numpy as np
from numba import njit

from octant.em.medium._double_edge_kernels import TERM_SIZE, double_sum, fill_terms
from octant.em.medium._wedge_kernels import azimuth, edge_factor, face, shortened, wedge_dyad

_TWO_PI = 2.0 * np.pi
_ALONG_THE_EDGE = 1e-9  # sin beta below which a ray runs along the edge
# Distance [wavelengths] nearer than which two edges count as this far apart: at a corner, where
# they meet, the terms grow without bound and only their sum is finite.
_APART = 0.05


@njit(cache=True, error_model="numpy")
def _dot(ax, ay, az, bx, by, bz):
    return ax * bx + ay * by + az * bz


@njit(cache=True, error_model="numpy")
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True, error_model="numpy")
def edge_angles(frames, edge, ix, iy, iz, ox, oy, oz):
    """Return phi_in, phi_out, cos beta and sin beta of a ray in (i) and out (o) at an edge."""
    tx, ty, tz = frames[edge, 0], frames[edge, 1], frames[edge, 2]
    nx, ny, nz = frames[edge, 3], frames[edge, 4], frames[edge, 5]
    ax, ay, az = _axis(frames, edge)
    n = frames[edge, 6]
    phi_in = azimuth(-_dot(ix, iy, iz, tx, ty, tz), -_dot(ix, iy, iz, nx, ny, nz), n)
    phi_out = azimuth(_dot(ox, oy, oz, tx, ty, tz), _dot(ox, oy, oz, nx, ny, nz), n)
    cx, cy, cz = _cross(ax, ay, az, ix, iy, iz)
    return phi_in, phi_out, _dot(ax, ay, az, ix, iy, iz), np.sqrt(cx * cx + cy * cy + cz * cz)


@njit(cache=True, error_model="numpy")
def to_edge(frames, edge, dx, dy, dz, ex, ey, ez):
    """Return the components of E along b and h of a ray d at an edge."""
    ax, ay, az = _axis(frames, edge)
    hx, hy, hz = _cross(ax, ay, az, dx, dy, dz)
    sine = np.sqrt(hx * hx + hy * hy + hz * hz)
    along = (
        ex * ax + ey * ay + ez * az - (ex * dx + ey * dy + ez * dz) * _dot(ax, ay, az, dx, dy, dz)
    )
    return along / sine, (ex * hx + ey * hy + ez * hz) / sine


@njit(cache=True, error_model="numpy")
def from_edge(frames, edge, dx, dy, dz, soft, hard):
    """Return the field whose components along b and h of a ray d at an edge are given."""
    ax, ay, az = _axis(frames, edge)
    hx, hy, hz = _cross(ax, ay, az, dx, dy, dz)
    sine = np.sqrt(hx * hx + hy * hy + hz * hz)
    if sine < _ALONG_THE_EDGE:
        return 0j, 0j, 0j
    cosine = _dot(ax, ay, az, dx, dy, dz)
    bx, by, bz = ax - cosine * dx, ay - cosine * dy, az - cosine * dz
    soft, hard = soft / sine, hard / sine
    return soft * bx + hard * hx, soft * by + hard * hy, soft * bz + hard * hz


@njit(cache=True, error_model="numpy")
def _axis(frames, edge):
    return _cross(
        frames[edge, 0],
        frames[edge, 1],
        frames[edge, 2],
        frames[edge, 3],
        frames[edge, 4],
        frames[edge, 5],
    )


@njit(cache=True, error_model="numpy")
def diffract(
    frames,
    faces,
    permittivity,
    thickness,
    edge,
    wavenumber,
    tolerance,
    before,
    after,
    ix,
    iy,
    iz,
    ox,
    oy,
    oz,
    ex,
    ey,
    ez,
):
    """Return D . E [sqrt(m) times E's unit] behind one edge.

    A row of ``frames`` holds t0 (from the edge into face 0), n0 (its normal into the air) and n
    (the air's angle over pi); one of ``faces`` what face 0 and face n are made of. A reflection
    within the tolerance [m] of a face's rim counts as there. The caller multiplies by
    e^{-jk(s'+s)} / sqrt(s' s (s' + s)) where E stands for a wave E e^{-jks'} / s' at the edge.
    """
    phi_in, phi_out, cosine, sine = edge_angles(frames, edge, ix, iy, iz, ox, oy, oz)
    if sine < _ALONG_THE_EDGE:
        return 0j, 0j, 0j
    d00, d01, d10, d11 = wedge_dyad(
        phi_in,
        phi_out,
        frames[edge, 6],
        cosine,
        sine,
        permittivity,
        thickness,
        face(faces, edge, 0),
        face(faces, edge, 1),
        wavenumber,
        before,
        after,
        tolerance / (shortened(before, after) * sine),
    )
    soft, hard = to_edge(frames, edge, ix, iy, iz, ex, ey, ez)
    return from_edge(frames, edge, ox, oy, oz, d00 * soft + d01 * hard, d10 * soft + d11 * hard)


@njit(cache=True, error_model="numpy")
def _side(frames, edge, phi):
    """Return the normal into the air of the face of an edge that is nearest to the azimuth phi."""
    turn = frames[edge, 6] * np.pi
    if phi < 0.5 * turn:
        return frames[edge, 3], frames[edge, 4], frames[edge, 5]
    along, above = np.sin(turn), -np.cos(turn)
    return (
        along * frames[edge, 0] + above * frames[edge, 3],
        along * frames[edge, 1] + above * frames[edge, 4],
        along * frames[edge, 2] + above * frames[edge, 5],
    )


@njit(cache=True, error_model="numpy")
def _on_face(frames, edge, phi, nx, ny, nz):
    """Return the azimuth of the edge's face to which phi is nearest; of a sheet, the side n."""
    n = frames[edge, 6]
    if n < 2.0:
        return 0.0 if phi < 0.5 * n * np.pi else n * np.pi
    same = _dot(frames[edge, 3], frames[edge, 4], frames[edge, 5], nx, ny, nz)
    return 0.0 if same > 0.0 else n * np.pi


@njit(cache=True, error_model="numpy")
def diffract_twice(
    frames,
    faces,
    permittivity,
    thickness,
    first,
    second,
    shared,
    wavenumber,
    tolerance,
    before,
    between,
    after,
    ix,
    iy,
    iz,
    mx,
    my,
    mz,
    ox,
    oy,
    oz,
    ex,
    ey,
    ez,
):
    """Return D . E [m times E's unit] behind two edges, the leg between them travelling along m.

    The caller multiplies by e^{-jkS} / sqrt(before between after S), S the sum of all three, for
    any two edges: what skew edges spread differently is in D. ``shared`` says that both bound one
    face and m runs in it; of two free edges of one sheet both sides are counted. Edges nearer than
    a twentieth of a wavelength count as that far apart.
    """
    in_1, out_1, cosine_1, sine_1 = edge_angles(frames, first, ix, iy, iz, mx, my, mz)
    in_2, out_2, cosine_2, sine_2 = edge_angles(frames, second, mx, my, mz, ox, oy, oz)
    if sine_1 < _ALONG_THE_EDGE or sine_2 < _ALONG_THE_EDGE:
        return 0j, 0j, 0j
    # How (b, h) of the first edge lie in those of the second, both across the middle leg.
    turn = np.empty(4)
    hx, hy, hz = _cross(*_axis(frames, first), mx, my, mz)
    gx, gy, gz = _cross(*_axis(frames, second), mx, my, mz)
    along = _dot(gx, gy, gz, hx, hy, hz)
    # b = m x h, so that b2 . h1 = m . (h2 x h1).
    aside = _dot(mx, my, mz, *_cross(gx, gy, gz, hx, hy, hz))
    size = np.sqrt(along * along + aside * aside)
    turn[0], turn[3] = along / size, along / size
    turn[1], turn[2] = aside / size, -aside / size
    apart = max(between, _APART * _TWO_PI / wavenumber)
    total = before + apart + after
    spread = apart * total + turn[1] ** 2 * before * after
    start, end = before + apart, apart + after
    k_first = wavenumber * sine_1**2 * before * spread / (start * total)
    k_second = wavenumber * sine_2**2 * after * spread / (end * total)
    w = turn[0] * np.sqrt(before * after / (start * end))
    both_free = shared and frames[first, 6] == 2.0 and frames[second, 6] == 2.0
    terms_1 = np.empty((4, TERM_SIZE), np.complex128)
    terms_2 = np.empty((4, TERM_SIZE), np.complex128)
    part = np.empty(4, np.complex128)
    d00, d01, d10, d11 = 0j, 0j, 0j, 0j
    for side in range(2 if both_free else 1):
        if shared:
            if frames[first, 6] < 2.0:
                nx, ny, nz = _side(frames, first, out_1)
            elif frames[second, 6] < 2.0:
                nx, ny, nz = _side(frames, second, in_2)
            else:
                nx, ny, nz = _side(frames, first, side * 2.0 * np.pi)
            out_1 = _on_face(frames, first, out_1, nx, ny, nz)
            in_2 = _on_face(frames, second, in_2, nx, ny, nz)
        fill_terms(
            True,
            shared,
            in_1,
            out_1,
            frames[first, 6],
            cosine_1,
            sine_1,
            permittivity,
            thickness,
            face(faces, first, 0),
            face(faces, first, 1),
            tolerance / (shortened(before, apart) * sine_1),
            k_first,
            wavenumber * shortened(before, end) * sine_1**2,
            wavenumber * total,
            terms_1,
        )
        fill_terms(
            False,
            shared,
            in_2,
            out_2,
            frames[second, 6],
            cosine_2,
            sine_2,
            permittivity,
            thickness,
            face(faces, second, 0),
            face(faces, second, 1),
            tolerance / (shortened(apart, after) * sine_2),
            k_second,
            wavenumber * shortened(start, after) * sine_2**2,
            wavenumber * total,
            terms_2,
        )
        double_sum(terms_1, terms_2, turn, k_first, k_second, w, part)
        d00, d01, d10, d11 = d00 + part[0], d01 + part[1], d10 + part[2], d11 + part[3]
    factor = edge_factor(frames[first, 6], sine_1, wavenumber)
    factor *= edge_factor(frames[second, 6], sine_2, wavenumber)
    factor *= np.sqrt(between * (before + between + after) / spread) * (0.5 if shared else 1.0)
    soft, hard = to_edge(frames, first, ix, iy, iz, ex, ey, ez)
    soft, hard = factor * (d00 * soft + d01 * hard), factor * (d10 * soft + d11 * hard)
    return from_edge(frames, second, ox, oy, oz, soft, hard)
