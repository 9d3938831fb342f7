# mypy: allow-untyped-defs
"""Compiled received power: paths found, fields added up, nothing stored beyond one receiver."""

import numpy as np

from octant.em.antennas._antenna_kernels import antenna_at
from octant.em.antennas._phase_kernels import angle_of
from octant.em.antennas._response_kernels import interpolate, turn_phases
from octant.em.fields._field_kernels import field_rows, fields_in_scene, path_fields, receive
from octant.em.fields._wave_kernels import SIZE, TI, TR, WIDTH
from octant.em.paths._tracing_kernels import (
    next_paths,
    traced_at_once,
    tracing_end,
    tracing_scratch,
)
from octant.geometries.kernels import kernel

SUMS = 32768
"""Sums over paths [-], of places, headings, antennas and frequencies, that are kept at a time: they
fit the second-level cache."""

THETA, PHI, CP, SP = 0 * WIDTH, 1 * WIDTH, 2 * WIDTH, 3 * WIDTH
ACROSS, UP = 4 * WIDTH, 5 * WIDTH
"""Rows of WIDTH numbers: angles of arrival [rad], cosine and sine of phi, sine and cosine of theta.
"""


@kernel(nogil=True)
def antenna_power(
    scene, tree, edges, transmitter, receiver, places, begin, end, coherent, mean, count
):
    """Fill coherent gain, sum of the paths' gains and number of paths, rows begin to end."""
    scratch = tracing_scratch(scene, tree, edges)
    field, direction = field_rows(len(scratch[0][3]))
    points, facets, orders, receivers = scratch[0][1], scratch[0][2], scratch[0][3], scratch[4]
    step = traced_at_once(scene, end - begin)
    total, state = np.empty(step, dtype=np.complex128), np.empty(SIZE)
    for first in range(begin, end, step):
        last = min(first + step, end)
        everything = tracing_end(tree, edges, first, last)
        total[:] = 0.0
        mean[first:last] = 0.0
        count[first:last] = 0
        place = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
        while place < everything:
            found, place = next_paths(scene, tree, edges, places, first, last, place, scratch)
            fields_in_scene(scene, transmitter, found, points, facets, orders, field, direction)
            for p in range(found):
                j = p % WIDTH
                if j == 0:
                    receive(receiver, p, min(found - p, np.int64(WIDTH)), field, direction, state)
                i = receivers[p]
                re, im = state[TR + j], state[TI + j]
                total[i - first] += complex(re, im)
                mean[i] += re * re + im * im
                count[i] += 1
        for i in range(first, last):
            v = total[i - first]
            coherent[i] = v.real * v.real + v.imag * v.imag


@kernel(nogil=True)
def reader_power(
    scene,
    channels,
    tree,
    edges,
    transmitters,
    response,
    places,
    turns,
    begin,
    end,
    coherent,
    mean,
    count,
):
    """Add (m, h, n) gains of every antenna at each place and turn, rows begin to end.

    ``turns`` (m, h) [rad] are the room azimuths of the reader's x' axis at each place. Paths are
    found once, being the same at every frequency, and the gains of all channels added.
    """
    scratch = tracing_scratch(scene, tree, edges)
    points, facets, orders, receivers = scratch[0][1], scratch[0][2], scratch[0][3], scratch[4]
    direction = field_rows(len(orders))[1]
    frequencies, headings = len(channels.wavelength), turns.shape[1]
    ports = response.centre_rad.shape[1]
    n = ports // frequencies
    step = traced_at_once(scene, min(end - begin, SUMS // (headings * ports)))
    field = np.empty((frequencies, 3, len(orders)), dtype=np.complex128)
    angles = np.empty(6 * WIDTH)
    parts, phases = np.empty(4 * ports), np.empty((2, ports))
    sums = np.empty((step, headings, 3, ports))
    spins = np.empty((step, headings, 2))
    for first in range(begin, end, step):
        last = min(first + step, end)
        everything = tracing_end(tree, edges, first, last)
        sums[:] = 0.0
        count[first:last] = 0
        for i in range(first, last):
            for h in range(headings):
                spins[i - first, h, 0] = np.cos(turns[i, h])
                spins[i - first, h, 1] = np.sin(turns[i, h])
        place = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
        while place < everything:
            found, place = next_paths(scene, tree, edges, places, first, last, place, scratch)
            for c in range(frequencies):
                path_fields(
                    antenna_at(transmitters, c),
                    scene.planes,
                    scene.facet_plane,
                    scene.facet_layers,
                    scene.facet_front,
                    channels.layer_permittivity[c],
                    channels.layer_thickness[c],
                    scene.wedge_utd,
                    scene.wedge_faces,
                    scene.tolerance,
                    channels.wavelength[c],
                    found,
                    points,
                    facets,
                    orders,
                    field[c].T,
                    direction,
                )
            for p in range(found):
                if p % WIDTH == 0:
                    _fill_angles(direction, p, min(found - p, np.int64(WIDTH)), angles)
                i = receivers[p]
                count[i] += 1
                for h in range(headings):
                    _add_voltages(
                        response,
                        field,
                        p,
                        angles,
                        turns[i, h],
                        spins[i - first, h, 0],
                        spins[i - first, h, 1],
                        parts,
                        phases,
                        sums,
                        i - first,
                        h,
                    )
        for i in range(first, last):
            for h in range(headings):
                total = sums[i - first, h]
                for m in range(ports):
                    coherent[i, h, m % n] += total[0, m] ** 2 + total[1, m] ** 2
                    mean[i, h, m % n] += total[2, m]


@kernel
def _fill_angles(direction, begin, count, angles):
    """Fill where waves come from: theta, phi [rad], what theta-hat and phi-hat are made of."""
    for j in range(count):
        x, y = -direction[begin + j, 0], -direction[begin + j, 1]
        z = -direction[begin + j, 2]
        across = np.sqrt(x * x + y * y)
        scale = 1.0 / (across if across > 0.0 else 1.0)
        cp, sp = (scale * x if across > 0.0 else 1.0), scale * y
        angles[THETA + j], angles[PHI + j] = angle_of(across, z), angle_of(sp, cp)
        angles[ACROSS + j], angles[UP + j] = across, z
        angles[CP + j], angles[SP + j] = cp, sp


@kernel
def _add_voltages(response, field, p, angles, turn, ct, st, parts, phases, sums, place, heading):
    """Add a path's voltages at all antennas and frequencies, and their squares, to the sums."""
    j = p % WIDTH
    cp, sp, across, up = angles[CP + j], angles[SP + j], angles[ACROSS + j], angles[UP + j]
    interpolate(response, angles[THETA + j], angles[PHI + j] - turn, parts)
    x, y = across * (cp * ct + sp * st), across * (sp * ct - cp * st)
    turn_phases(response.centre_rad, x, y, up, phases)
    ports = len(parts) // 4
    n = ports // len(field)
    for c in range(len(field)):
        ex, ey, ez = field[c, 0, p], field[c, 1, p], field[c, 2, p]
        e_theta = up * (cp * ex + sp * ey) - across * ez
        e_phi = cp * ey - sp * ex
        tr, ti, pr, pi = e_theta.real, e_theta.imag, e_phi.real, e_phi.imag
        for m in range(c * n, c * n + n):
            ar, ai = parts[m], parts[ports + m]
            br, bi = parts[2 * ports + m], parts[3 * ports + m]
            re = ar * tr - ai * ti + (br * pr - bi * pi)
            im = ar * ti + ai * tr + (br * pi + bi * pr)
            vr = re * phases[0, m] - im * phases[1, m]
            vi = re * phases[1, m] + im * phases[0, m]
            sums[place, heading, 0, m] += vr
            sums[place, heading, 1, m] += vi
            sums[place, heading, 2, m] += vr * vr + vi * vi
