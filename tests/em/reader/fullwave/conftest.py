"""Solutions that several tests of the full-wave solver share, each computed once."""

import functools

import pytest

from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9

BODIES = {
    "dipole_r10_h8": {},
    "dipole_r5_h8": {"antenna_radius_m": 0.05},
    "dipole_r10_h0": {"plate_height_m": 0.0},
    "round100_dipole_r10_h8": {"ground_plane_shape": "round", "antenna_radius_m": 0.099},
    "monopole0_r10_h8": {},
}


@functools.cache
def solution(name, cells=10.0, *, graded_tips=True):
    antenna = "monopole" if name.startswith("monopole") else "dipole"
    mesh = reader_mesh(
        reader_body(**BODIES[name]),
        frequency_hz=FREQUENCY_HZ,
        antenna=antenna,
        length_m=0.0625 if antenna == "dipole" else 0.03125,
        cells_per_wavelength=cells,
        graded_tips=graded_tips,
    )
    return solve_reader(mesh)


@pytest.fixture(scope="session")
def solved():
    """Return the function that solves a design of the reference by name."""
    return solution
