# mypy: allow-untyped-defs
"""Compiled received power: paths found, fields added up, nothing stored beyond one receiver."""

import numpy as np

from octant.em.antennas._antenna_kernels import antenna_at, far_field
from octant.em.antennas._response_kernels import far_fields
from octant.em.fields._field_kernels import fields_in_scene, path_fields
from octant.em.paths._tracing_kernels import next_paths, tracing_scratch, tracing_steps
from octant.geometries.kernels import kernel


@kernel(nogil=True)
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
        place = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
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
    points, facets, orders = scratch[0][1], scratch[0][2], scratch[0][3]
    step, images, everything = tracing_steps(scene, tree, edges)
    direction = np.empty((len(orders), 3))
    table, centre = response.table, response.centre_rad
    frequencies, n, headings = centre.shape[0], centre.shape[1], turns.shape[1]
    field = np.empty((frequencies, len(orders), 3), dtype=np.complex128)
    parts = np.empty(table.shape[2])
    pattern = np.empty((frequencies, n, 2), dtype=np.complex128)
    total = np.empty((headings, frequencies, n), dtype=np.complex128)
    power = np.empty((headings, frequencies, n))
    for i in range(begin, end):
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        total[:] = 0.0
        power[:] = 0.0
        count[i] = 0
        place = np.int64(0)  # typed: what takes it is not compiled for a literal 0 too
        while place < everything:
            found, place = next_paths(scene, tree, edges, x, y, z, place, step, images, scratch)
            if found == 0:
                continue
            count[i] += found
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
                    field[c],
                    direction,
                )
            for p in range(found):
                # Where the wave comes from: theta, phi and their unit vectors in the room.
                ux, uy, uz = -direction[p, 0], -direction[p, 1], -direction[p, 2]
                across = np.sqrt(ux * ux + uy * uy)
                cp, sp = (ux / across, uy / across) if across > 0.0 else (1.0, 0.0)
                theta = np.arctan2(across, uz)
                azimuth = np.arctan2(sp, cp)
                for h in range(headings):
                    far_fields(
                        table,
                        response.linear,
                        response.step_theta,
                        response.step_phi,
                        centre,
                        theta,
                        azimuth - turns[i, h],
                        parts,
                        pattern,
                    )
                    for c in range(frequencies):
                        ex, ey, ez = field[c, p, 0], field[c, p, 1], field[c, p, 2]
                        e_theta = uz * (cp * ex + sp * ey) - across * ez
                        e_phi = cp * ey - sp * ex
                        for k in range(n):
                            voltage = pattern[c, k, 0] * e_theta + pattern[c, k, 1] * e_phi
                            total[h, c, k] += voltage
                            power[h, c, k] += (
                                voltage.real * voltage.real + voltage.imag * voltage.imag
                            )
        for h in range(headings):
            for k in range(n):
                for c in range(frequencies):
                    v = total[h, c, k]
                    coherent[i, h, k] += v.real * v.real + v.imag * v.imag
                    mean[i, h, k] += power[h, c, k]
