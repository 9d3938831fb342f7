# mypy: allow-untyped-defs
"""Compiled field maps: power of a ring's antennas by heading, from paths of few image points."""

import math

import numpy as np

from octant.em.power._node_kernels import NO_PATH, find_corners, next_path, towards_image
from octant.geometries.kernels import kernel


@kernel
def add_path(harmonic, table, rows, ex, ey, ez, dx, dy, dz, turn, lowest):
    """Add a path's voltages to (r, m) coefficients of e^{-j m heading}, phase included.

    ``dx, dy, dz`` [m] lead from the place to the image; the field's phase is ``turn`` [rad]; table
    (T, r, m, 2) are the patterns' coefficients of e^{j m phi}, from m = ``lowest`` on.
    """
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    ux, uy, uz = dx / length, dy / length, dz / length
    across = math.sqrt(ux * ux + uy * uy)
    cp, sp = (ux / across, uy / across) if across > 0.0 else (1.0, 0.0)
    phase = complex(math.cos(turn * length), -math.sin(turn * length))
    e_theta = (uz * (cp * ex + sp * ey) - across * ez) * phase
    e_phi = (cp * ey - sp * ex) * phase
    at = math.atan2(across, uz) / math.pi * (rows - 1)
    i = min(int(at), rows - 2)
    w = at - i
    azimuth = math.atan2(sp, cp)
    step = complex(math.cos(azimuth), math.sin(azimuth))
    first = complex(math.cos(lowest * azimuth), math.sin(lowest * azimuth))
    for r in range(harmonic.shape[0]):
        spin = first
        for m in range(harmonic.shape[1]):
            theta = (1.0 - w) * table[i, r, m, 0] + w * table[i + 1, r, m, 0]
            phi = (1.0 - w) * table[i, r, m, 1] + w * table[i + 1, r, m, 1]
            harmonic[r, m] += (theta * e_theta + phi * e_phi) * spin
            spin *= step


@kernel(nogil=True)
def add_coherent(
    places, begin, end, low, cell, nodes, z, start, image, field, images, turn, table, lowest, wave,
    scale, power,
):  # fmt: skip
    """Add (k, r, h) powers at places begin to end, which fill rows from 0 on.

    Paths of node (i, j) of the coarse grid stand at start[i * nodes[1] + j], in the order of their
    images; field (paths, 3) is without its phase. Where a path reaches some corners of a cell only,
    those count if they have half of the weight. wave (m, h) is e^{-j m turn} of each heading.
    """
    rings, count = table.shape[1], table.shape[2]
    harmonic = np.empty((rings, count), dtype=np.complex128)
    at = np.empty(4, dtype=np.int64)
    last = np.empty(4, dtype=np.int64)
    weight = np.empty(4)
    for k in range(begin, end):
        find_corners(places[k, 0], places[k, 1], low, cell, nodes, start, at, last, weight)
        harmonic[:] = 0.0
        while True:
            p, ex, ey, ez, known = next_path(at, last, weight, image, field)
            if p == NO_PATH:
                break
            if known >= 0.5:
                dx, dy, dz, _, _, _ = towards_image(images[p], places[k, 0], places[k, 1], z)
                add_path(
                    harmonic, table, table.shape[0], ex / known, ey / known, ez / known,
                    dx, dy, dz, turn, lowest,
                )  # fmt: skip
        for r in range(rings):
            for h in range(wave.shape[1]):
                total = complex(0.0)
                for m in range(count):
                    total += harmonic[r, m] * wave[m, h]
                power[k - begin, r, h] += scale * (total.real**2 + total.imag**2)


@kernel(nogil=True)
def add_local_mean(
    places, begin, end, z, start, image, field, images, turn, table, lowest, wave, scale, power
):
    """Add (nodes, r, h) sums of the paths' powers at the nodes begin to end."""
    harmonic = np.empty((table.shape[1], table.shape[2]), dtype=np.complex128)
    for k in range(begin, end):
        for at in range(start[k], start[k + 1]):
            p = image[at]
            harmonic[:] = 0.0
            dx, dy, dz, _, _, _ = towards_image(images[p], places[k, 0], places[k, 1], z)
            add_path(
                harmonic, table, table.shape[0], field[at, 0], field[at, 1], field[at, 2],
                dx, dy, dz, turn, lowest,
            )  # fmt: skip
            for r in range(table.shape[1]):
                for h in range(wave.shape[1]):
                    total = complex(0.0)
                    for m in range(table.shape[2]):
                        total += harmonic[r, m] * wave[m, h]
                    power[k, r, h] += scale * (total.real**2 + total.imag**2)


@kernel(nogil=True)
def read_power(poses, begin, end, low, cell, levels, powers, ring, shift, out):
    """Fill (k, n) powers at poses from codes (nx, ny, r, h), linear between places and headings.

    powers (256,) says what codes mean; antenna i has the ring's row ring[i], turned by shift[i]
    [headings].
    """
    nx, ny, _, headings = levels.shape
    per_rad = headings / (2.0 * math.pi)
    for k in range(begin, end):
        u, v = (poses[k, 0] - low[0]) / cell[0], (poses[k, 1] - low[1]) / cell[1]
        i, j = min(max(int(u), 0), nx - 2), min(max(int(v), 0), ny - 2)
        u, v = min(max(u - i, 0.0), 1.0), min(max(v - j, 0.0), 1.0)
        for a in range(ring.size):
            h = poses[k, 2] * per_rad + shift[a]
            g = math.floor(h)
            w = h - g
            g = int(g) % headings
            f = (g + 1) % headings
            r = ring[a]
            out[k, a] = (1.0 - u) * (
                (1.0 - v)
                * ((1.0 - w) * powers[levels[i, j, r, g]] + w * powers[levels[i, j, r, f]])
                + v
                * ((1.0 - w) * powers[levels[i, j + 1, r, g]] + w * powers[levels[i, j + 1, r, f]])
            ) + u * (
                (1.0 - v)
                * ((1.0 - w) * powers[levels[i + 1, j, r, g]] + w * powers[levels[i + 1, j, r, f]])
                + v
                * (
                    (1.0 - w) * powers[levels[i + 1, j + 1, r, g]]
                    + w * powers[levels[i + 1, j + 1, r, f]]
                )
            )
