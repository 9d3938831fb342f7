# mypy: allow-untyped-defs
"""Compiled fields behind one edge and behind two."""

import numpy as np
from numba import njit

from octant.em._wedge_kernels import azimuth, wedge_dyad

_ALONG_THE_EDGE = 1e-9  # sin beta below which a ray runs along the edge


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
    permittivity,
    thickness,
    edge,
    transparent,
    wavenumber,
    touch,
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
    (the air's angle over pi). The caller multiplies by e^{-jk(s'+s)} / sqrt(s' s (s' + s)) where E
    stands for a wave E e^{-jks'} / s' at the edge.
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
        permittivity[edge, 0],
        thickness[edge, 0],
        permittivity[edge, 1],
        thickness[edge, 1],
        transparent,
        wavenumber,
        before,
        after,
        touch,
    )
    soft, hard = to_edge(frames, edge, ix, iy, iz, ex, ey, ez)
    return from_edge(frames, edge, ox, oy, oz, d00 * soft + d01 * hard, d10 * soft + d11 * hard)
