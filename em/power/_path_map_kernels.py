# mypy: allow-untyped-defs
"""Compiled power of a ring's antennas from a tag that hangs a little beside its place."""

import math

import numpy as np

from octant.em.power._node_kernels import NO_PATH, find_corners, next_path
from octant.geometries.kernels import kernel


@kernel
def write_voltages(real, imag, blend, table, ux, uy, uz, heading, ex, ey, ez):
    """Write the real and imaginary parts (n,) of the antennas' voltages by a path of field e.

    table (T, P + 1, 4 n): real and imaginary parts of F_theta, and of F_phi, of all antennas, in
    the robot's frame, whose front is at azimuth 90 degrees; blend (4 n,) is scratch.
    """
    across = math.sqrt(ux * ux + uy * uy)
    cp, sp = (ux / across, uy / across) if across > 0.0 else (1.0, 0.0)
    e_theta = uz * (cp * ex + sp * ey) - across * ez
    e_phi = cp * ey - sp * ex
    rows, columns = table.shape[0], table.shape[1] - 1
    at = math.atan2(across, uz) / math.pi * (rows - 1)
    i = min(int(at), rows - 2)
    w = at - i
    turn = (math.atan2(sp, cp) - heading) / (2.0 * math.pi) + 0.25
    around = (turn - math.floor(turn)) * columns
    j = min(int(around), columns - 1)
    v = around - j
    w00, w01 = np.float32((1.0 - w) * (1.0 - v)), np.float32((1.0 - w) * v)
    w10, w11 = np.float32(w * (1.0 - v)), np.float32(w * v)
    a, b, c, d = table[i, j], table[i, j + 1], table[i + 1, j], table[i + 1, j + 1]
    for q in range(blend.size):
        blend[q] = w00 * a[q] + w01 * b[q] + w10 * c[q] + w11 * d[q]
    tr, ti = np.float32(e_theta.real), np.float32(e_theta.imag)
    pr, pi = np.float32(e_phi.real), np.float32(e_phi.imag)
    n = real.size
    for q in range(n):
        real[q] = blend[q] * tr - blend[n + q] * ti + blend[2 * n + q] * pr - blend[3 * n + q] * pi
        imag[q] = blend[q] * ti + blend[n + q] * tr + blend[2 * n + q] * pi + blend[3 * n + q] * pr


@kernel(nogil=True)
def add_shifted_power(
    poses, offsets, low, cell, nodes, z, start, image, field, images, mirrors, turn, table, phasor,
    scale, power,
):  # fmt: skip
    """Add (m, k, n) powers at poses (m, 3) of a tag that hangs at each of offsets (k, 3).

    Paths of node (i, j) of the coarse grid stand at start[i * nodes[1] + j], in the order of their
    images; field (paths, 3) is without its phase, as everything single precision. A path that
    reaches some corners of a cell only counts if they have half of the weight. A path's length by
    the tag's offset is the series to second order; phasor is e^{-j 2 pi q / size}, size a
    power of two.
    """
    antennas, size = power.shape[2], phasor.shape[0]
    real, imag = np.empty(antennas, dtype=np.float32), np.empty(antennas, dtype=np.float32)
    blend = np.empty(4 * antennas, dtype=np.float32)
    sums_real = np.empty((offsets.shape[0], antennas), dtype=np.float32)
    sums_imag = np.empty((offsets.shape[0], antennas), dtype=np.float32)
    square = np.empty(offsets.shape[0])
    for q in range(offsets.shape[0]):
        square[q] = offsets[q, 0] ** 2 + offsets[q, 1] ** 2 + offsets[q, 2] ** 2
    at = np.empty(4, dtype=np.int64)
    last = np.empty(4, dtype=np.int64)
    weight = np.empty(4)
    per_metre = turn * size / (2.0 * math.pi)
    for k in range(poses.shape[0]):
        find_corners(poses[k, 0], poses[k, 1], low, cell, nodes, start, at, last, weight)
        sums_real[:] = 0.0
        sums_imag[:] = 0.0
        while True:
            p, ex, ey, ez, known = next_path(at, last, weight, image, field)
            if p == NO_PATH:
                break
            if known < 0.5:
                continue
            dx, dy = images[p, 0] - poses[k, 0], images[p, 1] - poses[k, 1]
            dz = images[p, 2] - z
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            ux, uy, uz = dx / length, dy / length, dz / length
            write_voltages(
                real, imag, blend, table, ux, uy, uz, poses[k, 2], ex / known, ey / known,
                ez / known,
            )  # fmt: skip
            mirror = mirrors[p]
            sx = mirror[0, 0] * ux + mirror[1, 0] * uy + mirror[2, 0] * uz
            sy = mirror[0, 1] * ux + mirror[1, 1] * uy + mirror[2, 1] * uz
            sz = mirror[0, 2] * ux + mirror[1, 2] * uy + mirror[2, 2] * uz
            half = 0.5 / length
            for q in range(offsets.shape[0]):
                along = sx * offsets[q, 0] + sy * offsets[q, 1] + sz * offsets[q, 2]
                way = length + along + half * (square[q] - along * along)
                g = int(way * per_metre + 0.5) & (size - 1)
                c, e = phasor[g, 0], phasor[g, 1]
                row_real, row_imag = sums_real[q], sums_imag[q]
                for n in range(antennas):
                    row_real[n] += c * real[n] - e * imag[n]
                    row_imag[n] += c * imag[n] + e * real[n]
        for q in range(offsets.shape[0]):
            for n in range(antennas):
                power[k, q, n] += scale * (sums_real[q, n] ** 2 + sums_imag[q, n] ** 2)
