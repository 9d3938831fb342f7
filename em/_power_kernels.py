# mypy: allow-untyped-defs
"""Compiled received power: paths found, fields added up, nothing stored beyond one receiver."""

import numpy as np
from numba import njit

from octant.em._antenna_kernels import far_field
from octant.em._field_kernels import fields_in_scene
from octant.em._response_kernels import far_fields
from octant.em._tracing_kernels import next_paths, tracing_scratch, tracing_steps


@njit(cache=True, error_model="numpy", nogil=True)
def antenna_power(
    scene, tree, edges, transmitter, receiver, places, begin, end, coherent, mean, count
):
    """Fill coherent gain, sum of the paths' gains and number of paths, rows begin to end."""
    scratch = tracing_scratch(scene, tree, edges)
    field = np.empty((len(scratch[0][3]), 3), dtype=np.complex128)
    direction = np.empty((len(scratch[0][3]), 3))
    points, facets, orders = scratch[0][1], scratch[0][2], scratch[0][3]
    step, images, everything = tracing_steps(scene, tree, edges)
    for i in range(begin, end):
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        total = complex(0.0)
        power = 0.0
        count[i] = 0
        place = 0
        while place < everything:
            found, place = next_paths(scene, tree, edges, x, y, z, place, step, images, scratch)
            fields_in_scene(scene, transmitter, found, points, facets, orders, field, direction)
            count[i] += found
            for p in range(found):
                dx, dy, dz = direction[p, 0], direction[p, 1], direction[p, 2]
                fx, fy, fz = far_field(receiver, -dx, -dy, -dz)
                gain = field[p, 0] * fx + field[p, 1] * fy + field[p, 2] * fz
                total += gain
                power += gain.real * gain.real + gain.imag * gain.imag
        coherent[i] = total.real * total.real + total.imag * total.imag
        mean[i] = power


@njit(cache=True, error_model="numpy", nogil=True)
def reader_power(
    scene, tree, edges, transmitter, response, places, turns, begin, end, coherent, mean, count
):
    """Fill (m, h, n) gains of every antenna at each place and turn, rows begin to end.

    ``turns`` (m, h) [rad] are the room azimuths of the reader's x' axis at each place.
    """
    scratch = tracing_scratch(scene, tree, edges)
    field = np.empty((len(scratch[0][3]), 3), dtype=np.complex128)
    direction = np.empty((len(scratch[0][3]), 3))
    points, facets, orders = scratch[0][1], scratch[0][2], scratch[0][3]
    step, images, everything = tracing_steps(scene, tree, edges)
    table, centre = response.table, response.centre_rad
    n, headings = table.shape[2], turns.shape[1]
    weight = np.empty((2, 4))
    pattern = np.empty((n, 2), dtype=np.complex128)
    total = np.empty((headings, n), dtype=np.complex128)
    for i in range(begin, end):
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        for h in range(headings):
            for k in range(n):
                total[h, k] = 0.0
                mean[i, h, k] = 0.0
        count[i] = 0
        place = 0
        while place < everything:
            found, place = next_paths(scene, tree, edges, x, y, z, place, step, images, scratch)
            fields_in_scene(scene, transmitter, found, points, facets, orders, field, direction)
            count[i] += found
            for p in range(found):
                # Where the wave comes from: theta, phi and their unit vectors in the room.
                ux, uy, uz = -direction[p, 0], -direction[p, 1], -direction[p, 2]
                across = np.sqrt(ux * ux + uy * uy)
                cp, sp = (ux / across, uy / across) if across > 0.0 else (1.0, 0.0)
                e_theta = uz * (cp * field[p, 0] + sp * field[p, 1]) - across * field[p, 2]
                e_phi = cp * field[p, 1] - sp * field[p, 0]
                theta = np.arctan2(across, uz)
                azimuth = np.arctan2(sp, cp)
                for h in range(headings):
                    far_fields(
                        table,
                        response.step_theta,
                        response.step_phi,
                        centre,
                        theta,
                        azimuth - turns[i, h],
                        weight,
                        pattern,
                    )
                    for k in range(n):
                        voltage = pattern[k, 0] * e_theta + pattern[k, 1] * e_phi
                        total[h, k] += voltage
                        mean[i, h, k] += voltage.real * voltage.real + voltage.imag * voltage.imag
        for h in range(headings):
            for k in range(n):
                v = total[h, k]
                coherent[i, h, k] = v.real * v.real + v.imag * v.imag


@njit(cache=True, error_model="numpy", nogil=True)
def sum_fields(scene, tree, edges, transmitter, places, begin, end, total):
    """Fill (m, 3) the coherent sum of the field vectors that arrive, rows begin to end."""
    scratch = tracing_scratch(scene, tree, edges)
    field = np.empty((len(scratch[0][3]), 3), dtype=np.complex128)
    direction = np.empty((len(scratch[0][3]), 3))
    points, facets, orders = scratch[0][1], scratch[0][2], scratch[0][3]
    step, images, everything = tracing_steps(scene, tree, edges)
    for i in range(begin, end):
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        for a in range(3):
            total[i, a] = 0.0
        place = 0
        while place < everything:
            found, place = next_paths(scene, tree, edges, x, y, z, place, step, images, scratch)
            fields_in_scene(scene, transmitter, found, points, facets, orders, field, direction)
            for p in range(found):
                for a in range(3):
                    total[i, a] += field[p, a]


@njit(cache=True, error_model="numpy", nogil=True)
def sum_magnetic_fields(scene, tree, edges, transmitter, places, begin, end, total):
    """Fill (m, 3) the coherent sum of direction x field, rows begin to end.

    Each path also brings the dipole's induction field: 1 + 1 / (jkL) over its whole length L.
    """
    scratch = tracing_scratch(scene, tree, edges)
    points, facets, orders = scratch[0][1], scratch[0][2], scratch[0][3]
    field = np.empty((len(orders), 3), dtype=np.complex128)
    direction = np.empty((len(orders), 3))
    step, images, everything = tracing_steps(scene, tree, edges)
    wavenumber = 2.0 * np.pi / scene.wavelength
    for i in range(begin, end):
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        for a in range(3):
            total[i, a] = 0.0
        place = 0
        while place < everything:
            found, place = next_paths(scene, tree, edges, x, y, z, place, step, images, scratch)
            fields_in_scene(scene, transmitter, found, points, facets, orders, field, direction)
            for p in range(found):
                length = 0.0
                for leg in range(orders[p] + 1):
                    square = 0.0
                    for a in range(3):
                        square += (points[p, leg, a] - points[p, leg + 1, a]) ** 2
                    length += np.sqrt(square)
                near = complex(1.0, -1.0 / (wavenumber * length))
                dx, dy, dz = direction[p, 0], direction[p, 1], direction[p, 2]
                total[i, 0] += near * (dy * field[p, 2] - dz * field[p, 1])
                total[i, 1] += near * (dz * field[p, 0] - dx * field[p, 2])
                total[i, 2] += near * (dx * field[p, 1] - dy * field[p, 0])
