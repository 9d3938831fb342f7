# mypy: allow-untyped-defs
"""Compiled power of a ring's antennas from a tag that hangs a little beside its place.

Poses close to one another share all that changes little between them: the paths' fields, and the
directions from tag and reader, along which phases are followed. What is left for each pose, path
and place of the tag is one product of complex numbers, in long rows.
"""

import math

import numpy as np

from octant.em.power._node_kernels import NO_PATH, find_corners, next_path, towards_image
from octant.geometries.kernels import kernel

_POSES = 32


@kernel
def _gather(x, y, z, at, last, weight, image, field, images, moves, ray, wave):
    """Fill what a group's paths are at its middle, and return how many.

    ray (p, 9): length [m], unit vector to the image, unit vector whose product with the tag's
    offset makes the way longer, azimuth, polar angle; wave (p, 4): real and imaginary parts of the
    field along theta and along phi. A path that reaches some corners of a cell only counts if they
    have half of the weight.
    """
    count = 0
    while True:
        p, ex, ey, ez, known = next_path(at, last, weight, image, field)
        if p == NO_PATH:
            return count
        if known < 0.5:
            continue
        dx, dy, dz, rx, ry, rz = towards_image(images[p], x, y, z)
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        ux, uy, uz = dx / length, dy / length, dz / length
        move, wide = moves[p], -(rx * ux + ry * uy + rz * uz)
        one = ray[count]
        one[0], one[1], one[2], one[3] = length, ux, uy, uz
        for c in range(3):
            one[4 + c] = move[0, c] * ux + move[1, c] * uy + move[2, c] * uz + move[3, c] * wide
        across = math.sqrt(ux * ux + uy * uy)
        cp, sp = (ux / across, uy / across) if across > 0.0 else (1.0, 0.0)
        one[7], one[8] = math.atan2(sp, cp), math.atan2(across, uz)
        e_theta = (uz * (cp * ex + sp * ey) - across * ez) / known
        e_phi = (cp * ey - sp * ex) / known
        wave[count, 0], wave[count, 1] = e_theta.real, e_theta.imag
        wave[count, 2], wave[count, 3] = e_phi.real, e_phi.imag
        count += 1


@kernel
def _write_turns(ray, count, offsets, per_metre, phasor, turns):
    """Write e^{-jk} of the ways that each place of the tag adds to each path, (k, p, 2)."""
    size = phasor.shape[0]
    for q in range(offsets.shape[0]):
        a, b, c = offsets[q, 0], offsets[q, 1], offsets[q, 2]
        square = a * a + b * b + c * c
        for p in range(count):
            along = ray[p, 4] * a + ray[p, 5] * b + ray[p, 6] * c
            way = along + 0.5 / ray[p, 0] * (square - along * along)
            g = math.floor(way * per_metre + 0.5) & (size - 1)
            turns[q, p, 0], turns[q, p, 1] = phasor[g, 0], phasor[g, 1]


@kernel
def _write_voltages(
    dx, dy, heading, ray, wave, count, per_metre, phasor, table, blend, at, real, imag
):
    """Write the antennas' voltages by all paths, (p, n) from column ``at`` on, phase included.

    dx, dy lead from the group's middle to the pose [m]; table (T, P + 1, 4 n): real and imaginary
    parts of F_theta, and of F_phi, of all antennas, in the robot's frame, whose front is at azimuth
    90 degrees; blend (4 n,) is scratch.
    """
    size, n = phasor.shape[0], blend.size // 4
    rows, columns = table.shape[0], table.shape[1] - 1
    square = dx * dx + dy * dy
    for p in range(count):
        along = ray[p, 1] * dx + ray[p, 2] * dy
        way = ray[p, 0] - along + 0.5 / ray[p, 0] * (square - along * along)
        g = int(way * per_metre + 0.5) & (size - 1)
        c, e = phasor[g, 0], phasor[g, 1]
        tr, ti = wave[p, 0] * c - wave[p, 1] * e, wave[p, 0] * e + wave[p, 1] * c
        pr, pi = wave[p, 2] * c - wave[p, 3] * e, wave[p, 2] * e + wave[p, 3] * c
        down = ray[p, 8] / math.pi * (rows - 1)
        i = min(int(down), rows - 2)
        w = down - i
        turn = (ray[p, 7] - heading) / (2.0 * math.pi) + 0.25
        around = (turn - math.floor(turn)) * columns
        j = min(int(around), columns - 1)
        v = around - j
        w00, w01 = np.float32((1.0 - w) * (1.0 - v)), np.float32((1.0 - w) * v)
        w10, w11 = np.float32(w * (1.0 - v)), np.float32(w * v)
        for q in range(blend.size):
            blend[q] = (
                w00 * table[i, j, q] + w01 * table[i, j + 1, q]
                + w10 * table[i + 1, j, q] + w11 * table[i + 1, j + 1, q]
            )  # fmt: skip
        for q in range(n):
            a, b, c, d = blend[q], blend[n + q], blend[2 * n + q], blend[3 * n + q]
            real[p, at + q] = a * tr - b * ti + c * pr - d * pi
            imag[p, at + q] = a * ti + b * tr + c * pi + d * pr


@kernel
def _add_powers(turns, count, real, imag, used, sums, scale, antennas, member, first, power):
    """Add the powers of up to _POSES poses, of which ``used`` columns are filled, at all places."""
    for q in range(turns.shape[0]):
        for i in range(used):
            sums[0, i] = 0.0
        for i in range(used):
            sums[1, i] = 0.0
        for p in range(count):
            c, e = turns[q, p, 0], turns[q, p, 1]
            for i in range(used):
                sums[0, i] += c * real[p, i] - e * imag[p, i]
            for i in range(used):
                sums[1, i] += c * imag[p, i] + e * real[p, i]
        for b in range(used // antennas):
            k = member[first + b]
            for n in range(antennas):
                i = b * antennas + n
                power[k, q, n] += scale * (sums[0, i] ** 2 + sums[1, i] ** 2)


@kernel(nogil=True)
def add_shifted_power(
    poses, member, group, offsets, low, cell, nodes, z, start, image, field, images, moves, turn,
    table, phasor, scale, power,
):  # fmt: skip
    """Add (m, k, n) powers at poses (m, 3) of a tag that hangs at each of offsets (k, 3).

    Group g of poses are those of numbers member[group[g]] to member[group[g + 1]]. Paths of node
    (i, j) of the coarse grid stand at start[i * nodes[1] + j], in the order of their images; field
    (paths, 3) is without its phase, as everything single precision. Lengths of paths by the offsets
    of pose and tag are series to second order; phasor is
    e^{-j 2 pi q / size}, size a power of two.
    """
    antennas, size = power.shape[2], phasor.shape[0]
    per_metre = turn * size / (2.0 * math.pi)
    most = 0
    for node in range(start.size - 1):
        most = max(most, start[node + 1] - start[node])
    ray, wave = np.empty((4 * most, 9)), np.empty((4 * most, 4), dtype=np.float32)
    real = np.empty((4 * most, _POSES * antennas), dtype=np.float32)
    imag = np.empty((4 * most, _POSES * antennas), dtype=np.float32)
    turns = np.empty((offsets.shape[0], 4 * most, 2), dtype=np.float32)
    sums = np.empty((2, _POSES * antennas), dtype=np.float32)
    blend = np.empty(4 * antennas, dtype=np.float32)
    at = np.empty(4, dtype=np.int64)
    last = np.empty(4, dtype=np.int64)
    weight = np.empty(4)
    for g in range(group.size - 1):
        x, y = 0.0, 0.0
        for b in range(group[g], group[g + 1]):
            x, y = x + poses[member[b], 0], y + poses[member[b], 1]
        x, y = x / (group[g + 1] - group[g]), y / (group[g + 1] - group[g])
        find_corners(x, y, low, cell, nodes, start, at, last, weight)
        count = _gather(x, y, z, at, last, weight, image, field, images, moves, ray, wave)
        _write_turns(ray, count, offsets, per_metre, phasor, turns)
        for first in range(group[g], group[g + 1], _POSES):
            used = 0
            for b in range(first, min(first + _POSES, group[g + 1])):
                k = member[b]
                _write_voltages(
                    poses[k, 0] - x, poses[k, 1] - y, poses[k, 2], ray, wave, count, per_metre,
                    phasor, table, blend, used, real, imag,
                )  # fmt: skip
                used += antennas
            _add_powers(turns, count, real, imag, used, sums, scale, antennas, member, first, power)
