# mypy: allow-untyped-defs
"""Compiled fields behind one edge and behind two."""

import numpy as np

from octant.em.medium._double_edge_kernels import TERM_SIZE, double_sum, fill_terms
from octant.em.medium._transition_kernels import AT_END, END_SIZE, end_counts, fill_end
from octant.em.medium._wedge_kernels import (
    azimuth,
    edge_factor,
    face,
    shortened,
    wedge_dyad,
    whole_edge,
)
from octant.em.paths._edge_point_kernels import two_points
from octant.geometries.kernels import kernel

_TWO_PI = 2.0 * np.pi
# Columns of an edge's frame: where it starts along its axis and its length [m], and whether its two
# ends are in the open.
_START, _LENGTH, _TIPS = 9, 10, 11
_ALONG_THE_EDGE = 1e-9  # sin beta below which a ray runs along the edge
# Distance [wavelengths] nearer than which two edges count as this far apart: at a corner, where
# they meet, the terms grow without bound and only their sum is finite.
_APART = 0.05
# Detour over a corner times k [rad] below which it is rounding.
_SAME_WAY = 1e-10
# Change of a ray's slope along an edge [-] from which on it is bent off its point of diffraction.
_BENT = 1e-7
# Distance [tolerances of the scene] up to which ends of two edges are one corner.
_SAME_END = 10.0


@kernel
def _dot(ax, ay, az, bx, by, bz):
    return ax * bx + ay * by + az * bz


@kernel
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@kernel
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


@kernel
def to_edge(frames, edge, dx, dy, dz, ex, ey, ez):
    """Return the components of E along b and h of a ray d at an edge."""
    ax, ay, az = _axis(frames, edge)
    hx, hy, hz = _cross(ax, ay, az, dx, dy, dz)
    sine = np.sqrt(hx * hx + hy * hy + hz * hz)
    along = (
        ex * ax + ey * ay + ez * az - (ex * dx + ey * dy + ez * dz) * _dot(ax, ay, az, dx, dy, dz)
    )
    return along / sine, (ex * hx + ey * hy + ez * hz) / sine


@kernel
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


@kernel
def _axis(frames, edge):
    return _cross(
        frames[edge, 0],
        frames[edge, 1],
        frames[edge, 2],
        frames[edge, 3],
        frames[edge, 4],
        frames[edge, 5],
    )


@kernel
def along_edge(frames, edge, point):
    """Return the place [m] of a point along the axis of an edge."""
    return _dot(*_axis(frames, edge), point[0], point[1], point[2])


@kernel
def _past_end(h, wavenumber, before, after, cosine, sine):
    """Return the root of the detour times k over a point ``h`` [m] off the middle of an edge.

    And the weight [-] of an end there: by how much less the edge sends from there than from its
    middle, over a detour times k. Both without the difference of two lengths.
    """
    half, slope, far = 0.0, 0.0, 1.0
    for length, rise in ((before, before * cosine), (after, -after * cosine)):
        there = np.sqrt(max(length * length + h * (2.0 * rise + h), 0.0))
        bent = length - rise * (2.0 * rise + h) / (length + there)
        half += bent / (length * (length + there))
        slope += bent / (length * there)
        far *= length / there
    root = max(abs(h) * np.sqrt(wavenumber * half), AT_END)
    curvature = sine * sine * (1.0 / before + 1.0 / after)
    return root, end_counts(root * root) * far * np.sqrt(2.0 * curvature * half) / slope


@kernel
def _cut(frames, edge, middle, wavenumber, before, after, cosine, sine, corner):
    """Return what the ends of an edge leave of the field of its line, see ``left_by``.

    ``middle`` [m along the axis] is where the line diffracts; ``corner`` an end that is left out.
    """
    whole, count = 1.0, 0
    ends = np.empty((2, END_SIZE), np.complex128)
    for end in range(2):
        if frames[edge, _TIPS + end] == 0.0 or corner == end:
            continue
        h = frames[edge, _START] + end * frames[edge, _LENGTH] - middle
        root, weight = _past_end(h, wavenumber, before, after, cosine, sine)
        inside = root == AT_END or (h < 0.0) == (end == 0)
        whole = whole if inside else 0.0
        if weight > 0.0:
            fill_end(root, -weight if inside else weight, ends[count])
            count += 1
    return whole, ends[:count]


@kernel(returns="UniTuple(complex128, 3)")
def diffract(
    frames,
    faces,
    permittivity,
    thickness,
    edge,
    wavenumber,
    tolerance,
    along,
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
    """Return D . E [sqrt(m) times E's unit] behind one edge, which the path meets at ``along``.

    A row of ``frames`` holds t0 (from the edge into face 0), n0 (its normal into the air), n (the
    air's angle over pi), and where the edge ends; one of ``faces`` what face 0 and face n are made
    of. ``along`` [m along the axis] is the point of diffraction, or an end off which that point
    lies. A reflection within the tolerance [m] of a face's rim counts as there. The caller
    multiplies by e^{-jk(s'+s)} / sqrt(s' s (s' + s)) where E stands for a wave E e^{-jks'} / s' at
    the edge.
    """
    phi_in, phi_out, cosine, sine = edge_angles(frames, edge, ix, iy, iz, ox, oy, oz)
    ax, ay, az = _axis(frames, edge)
    cos_out = _dot(ax, ay, az, ox, oy, oz)
    sin_out = np.sqrt(max(1.0 - cos_out * cos_out, 0.0))
    if min(sine, sin_out) < _ALONG_THE_EDGE:
        return 0j, 0j, 0j
    scale = complex(1.0)
    cut = whole_edge()
    if frames[edge, _TIPS] + frames[edge, _TIPS + 1] > 0.0:
        middle = along
        if abs(cosine - cos_out) > _BENT:
            # Over an end: the coefficient is that of the shortest way over the edge's line.
            near, far, total = before * sine, after * sin_out, before + after
            rise = before * cosine + after * cos_out
            spread = before * after * total
            shortest = np.sqrt((near + far) ** 2 + rise * rise)
            middle += rise * near / (near + far) - before * cosine
            cosine, sine = rise / shortest, (near + far) / shortest
            before, after = shortest * near / (near + far), shortest * far / (near + far)
            scale = np.exp(1j * wavenumber * (total - shortest))
            scale *= np.sqrt(spread / (before * after * shortest))
        cut = _cut(frames, edge, middle, wavenumber, before, after, cosine, sine, -1)
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
        cut,
    )
    soft, hard = to_edge(frames, edge, ix, iy, iz, ex, ey, ez)
    soft, hard = scale * (d00 * soft + d01 * hard), scale * (d10 * soft + d11 * hard)
    return from_edge(frames, edge, ox, oy, oz, soft, hard)


@kernel
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


@kernel
def _on_face(frames, edge, phi, nx, ny, nz):
    """Return the azimuth of the edge's face to which phi is nearest; of a sheet, the side n."""
    n = frames[edge, 6]
    if n < 2.0:
        return 0.0 if phi < 0.5 * n * np.pi else n * np.pi
    same = _dot(frames[edge, 3], frames[edge, 4], frames[edge, 5], nx, ny, nz)
    return 0.0 if same > 0.0 else n * np.pi


@kernel
def _one_corner(frames, first, second, tolerance, along_1, along_2, between, mx, my, mz):
    """Return which ends of two edges are one corner, -1 each where none is."""
    ax, ay, az = _axis(frames, first)
    bx, by, bz = _axis(frames, second)
    for i in range(2):
        h = frames[first, _START] + i * frames[first, _LENGTH] - along_1
        for j in range(2):
            g = frames[second, _START] + j * frames[second, _LENGTH] - along_2
            gap = abs(h * ax - between * mx - g * bx)
            gap = max(gap, abs(h * ay - between * my - g * by))
            gap = max(gap, abs(h * az - between * mz - g * bz))
            tips = frames[first, _TIPS + i] > 0.0 and frames[second, _TIPS + j] > 0.0
            if tips and gap <= _SAME_END * tolerance:
                return i, j
    return -1, -1


@kernel
def _leg(x, y, z):
    """Return the direction and the length of a leg."""
    size = np.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    return x / size, y / size, z / size, size


@kernel
def _over_lines(ax, ay, az, bx, by, bz, before, between, after, ix, iy, iz, mx, my, mz, ox, oy, oz):
    """Return the three legs of the shortest way over the lines of two edges of axes a and b.

    A path over points of them is given. First how far its points move along their axes [m], and
    whether the way was found; each leg is a direction and a length.
    """
    sx, sy, sz = -before * ix, -before * iy, -before * iz
    px, py, pz = between * mx, between * my, between * mz
    along_s, along_r = _dot(sx, sy, sz, ax, ay, az), after * _dot(ox, oy, oz, bx, by, bz)
    lines = np.zeros((2, 6))
    lines[0, 3], lines[0, 4], lines[0, 5] = ax, ay, az
    lines[1, 0], lines[1, 1], lines[1, 2] = px, py, pz
    lines[1, 3], lines[1, 4], lines[1, 5] = bx, by, bz
    aside_s = np.sqrt(max(before * before - along_s * along_s, 0.0))
    aside_r = np.sqrt(max(after * after - along_r * along_r, 0.0))
    s, t, found = two_points(lines, 0, 1, aside_s, along_s, aside_r, along_r)
    qx, qy, qz = s * ax, s * ay, s * az
    rx, ry, rz = px + after * ox, py + after * oy, pz + after * oz
    px, py, pz = px + t * bx, py + t * by, pz + t * bz
    one, two = _leg(qx - sx, qy - sy, qz - sz), _leg(px - qx, py - qy, pz - qz)
    return s, t, found, one, two, _leg(rx - px, ry - py, rz - pz)


@kernel(returns="UniTuple(complex128, 3)")
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
    along_1,
    along_2,
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
    a twentieth of a wavelength count as that far apart. The path meets the edges at ``along_1`` and
    ``along_2`` [m along their axes], as in :func:`diffract`; into a corner of both the pair fades.
    """
    ax, ay, az = _axis(frames, first)
    bx, by, bz = _axis(frames, second)
    _, _, _, sine_1 = edge_angles(frames, first, ix, iy, iz, mx, my, mz)
    _, _, _, sine_2 = edge_angles(frames, second, ox, oy, oz, ox, oy, oz)
    if min(sine_1, sine_2) < _ALONG_THE_EDGE:
        return 0j, 0j, 0j
    soft, hard = to_edge(frames, first, ix, iy, iz, ex, ey, ez)
    vx, vy, vz = ox, oy, oz
    total = before + between + after
    scale = complex(1.0)
    at_1, at_2 = _one_corner(
        frames, first, second, tolerance, along_1, along_2, between, mx, my, mz
    )
    bent_1 = _dot(ax, ay, az, mx - ix, my - iy, mz - iz)
    bent_2 = _dot(bx, by, bz, ox - mx, oy - my, oz - mz)
    if max(abs(bent_1), abs(bent_2)) > _BENT:
        s, t, found, one, two, three = _over_lines(
            ax, ay, az, bx, by, bz, before, between, after, ix, iy, iz, mx, my, mz, ox, oy, oz
        )
        if not found:
            return 0j, 0j, 0j
        along_1, along_2 = along_1 + s, along_2 + t
        spread = before * between * after * total
        ix, iy, iz, before = one
        mx, my, mz, between = two
        ox, oy, oz, after = three
        shortest = before + between + after
        scale = np.exp(1j * wavenumber * (total - shortest))
        scale *= np.sqrt(spread / (before * between * after * shortest))
        total = shortest
    in_1, out_1, cosine_1, sine_1 = edge_angles(frames, first, ix, iy, iz, mx, my, mz)
    in_2, out_2, cosine_2, sine_2 = edge_angles(frames, second, mx, my, mz, ox, oy, oz)
    if sine_1 < _ALONG_THE_EDGE or sine_2 < _ALONG_THE_EDGE:
        return 0j, 0j, 0j
    end = between + after
    cut_1 = _cut(frames, first, along_1, wavenumber, before, end, cosine_1, sine_1, at_1)
    end = before + between
    cos_out = _dot(bx, by, bz, ox, oy, oz)
    cut_2 = _cut(frames, second, along_2, wavenumber, end, after, cos_out, sine_2, at_2)
    tips, weight_1, weight_2 = 0, 0.0, 0.0
    tip = np.empty((1, END_SIZE), np.complex128)
    if at_1 >= 0:
        h = frames[first, _START] + at_1 * frames[first, _LENGTH] - along_1
        cx, cy, cz = h * ax, h * ay, h * az
        _, _, _, over = _leg(cx + before * ix, cy + before * iy, cz + before * iz)
        cx, cy, cz = cx - between * mx, cy - between * my, cz - between * mz
        _, _, _, beyond = _leg(after * ox - cx, after * oy - cy, after * oz - cz)
        detour = wavenumber * (over + beyond - total)
        root = np.sqrt(detour) if detour > _SAME_WAY else 0.0
        _, weight_1 = _past_end(h, wavenumber, before, between + after, cosine_1, sine_1)
        h = frames[second, _START] + at_2 * frames[second, _LENGTH] - along_2
        _, weight_2 = _past_end(h, wavenumber, before + between, after, cos_out, sine_2)
        if weight_1 + weight_2 > 0.0:
            fill_end(root, 1.0, tip[0])
            tips = 1
    corner = tip[:tips], weight_1, weight_2
    # How (b, h) of the first edge lie in those of the second, both across the middle leg.
    turn = np.empty(4)
    hx, hy, hz = _cross(ax, ay, az, mx, my, mz)
    gx, gy, gz = _cross(bx, by, bz, mx, my, mz)
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
        double_sum(terms_1, terms_2, turn, k_first, k_second, w, cut_1, cut_2, corner, part)
        d00, d01, d10, d11 = d00 + part[0], d01 + part[1], d10 + part[2], d11 + part[3]
    factor = edge_factor(frames[first, 6], sine_1, wavenumber)
    factor *= edge_factor(frames[second, 6], sine_2, wavenumber)
    factor *= np.sqrt(between * (before + between + after) / spread) * (0.5 if shared else 1.0)
    factor = scale * factor
    soft, hard = factor * (d00 * soft + d01 * hard), factor * (d10 * soft + d11 * hard)
    return from_edge(frames, second, vx, vy, vz, soft, hard)
