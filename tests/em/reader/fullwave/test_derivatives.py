"""Derivatives of a reader's ports against central differences of whole solutions."""

from dataclasses import replace

import numpy as np
import pytest

from octant.em.reader.fullwave.basis import best_basis
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.derivatives import STEP_M, Move, solve_with_derivatives
from octant.em.reader.fullwave.far_field import current_samples
from octant.em.reader.fullwave.linear_solve import solve_currents
from octant.em.reader.fullwave.mesh import reader_meshes
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.em.reader.fullwave.solve import excitations, solve_reader
from octant.geometries.build_errors import common_errors
from octant.geometries.errors import GeometryError
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
DIRECTIONS = (np.array((0.3, 0.9, 1.4, 2.5)), 2.0 * np.pi / 90 * np.array((3, 27, 47, 86)))
WHOLE_STEP_M = 1e-5
POOR = Conductor(conductivity_s_per_m=1e4, thickness_m=1e-6)


def meshes(names, steps, *, antennas=4, shape="square", **design):
    bodies = [
        reader_body(
            antennas=antennas,
            ground_plane_shape=shape,
            ground_plane_m=0.12,
            antenna_radius_m=0.045,
            plate_height_m=0.03,
            plate_height_axis_m=0.04,
            errors=errors,
        )
        for errors in [
            None,
            *(common_errors(antennas, **{n: s}) for n in names for h in steps for s in (-h, h)),
        ]
    ]
    return reader_meshes(bodies, frequency_hz=FREQUENCY_HZ, cells_per_wavelength=5.0, **design)


def whole_solution(mesh, drawn, sectors):
    """Return admittances and far fields of a moved mesh, integrated by the distances of another."""
    basis = best_basis(drawn.vertices_m, drawn.faces, (sectors,))
    moved = replace(basis, vertices_m=mesh.vertices_m)
    driving = excitations(moved, mesh)
    sheet = drawn.surface_impedance_ohm(FREQUENCY_HZ)[basis.given_face]
    matrix = impedance_matrix(
        moved, frequency_hz=FREQUENCY_HZ, surface_impedance_ohm=sheet, drawn=basis
    )
    currents = solve_currents(moved, matrix, driving)
    samples = current_samples(moved, moved.half_coefficients(currents), frequency_hz=FREQUENCY_HZ)
    return np.einsum("ism,jsm->ij", driving, currents), samples.far_field(*DIRECTIONS)


@pytest.mark.parametrize(
    ("design", "sectors"),
    [
        ({"names": ("radial_m", "gap_m", "length_m", "plate_height_m", "ground_plane_m")}, 4),
        ({"names": ("radial_m", "length_m", "ground_plane_m"), "antenna": "monopole"}, 4),
        ({"names": ("gap_m", "plate_height_m"), "antennas": 3, "feed_gap_m": 0.0}, 1),
        ({"names": ("length_m", "plate_height_m", "ground_plane_m"), "conductor": POOR}, 4),
    ],
    ids=["dipoles", "monopoles", "no symmetry", "lossy metal"],
)
def test_derivatives_are_those_of_whole_solutions(design, sectors):
    names = design["names"]
    drawn, *moved = meshes(steps=(STEP_M, WHOLE_STEP_M), **design)
    moves = [
        Move(before=moved[4 * i], after=moved[4 * i + 1], step=STEP_M) for i in range(len(names))
    ]
    solution, derivatives = solve_with_derivatives(drawn, moves)
    assert solution.admittance_s == pytest.approx(solve_reader(drawn).admittance_s, rel=1e-9)
    theta, phi = DIRECTIONS
    for i, derivative in enumerate(derivatives):
        low, high = (whole_solution(moved[4 * i + 2 + k], drawn, sectors) for k in range(2))
        admittance, field = ((b - a) / (2.0 * WHOLE_STEP_M) for a, b in zip(low, high, strict=True))
        assert np.abs(derivative.admittance_s - admittance).max() < 1e-5 * np.abs(admittance).max()
        step = 1e-3
        ends = [derivative.along(solution, s).shorted_v for s in (-step, step)]
        grids = [np.diagonal(_towards(end, theta, phi), axis1=1, axis2=2) for end in ends]
        tangent = np.moveaxis((grids[1] - grids[0]) / (2.0 * step), -1, 1)
        assert np.abs(tangent - field).max() < 1e-5 * np.abs(field).max()


def _towards(field, theta, phi):
    """Return (k, theta, phi, 2) fields towards any directions, of the series at their columns."""
    fine = 90
    columns = np.rint(phi / (2.0 * np.pi) * fine).astype(int)
    return field.on_grid(theta, fine)[:, :, columns]


def test_a_mesh_of_other_triangles_is_no_move():
    drawn, other = meshes((), ())[0], meshes((), (), shape="octagon", antennas=8)[0]
    with pytest.raises(GeometryError, match="corners was given for a move"):
        solve_with_derivatives(drawn, [Move(before=other, after=other, step=STEP_M)])
