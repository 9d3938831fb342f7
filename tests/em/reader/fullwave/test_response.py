"""The response that radio maps read is the solution itself, on a grid."""

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.reader.fullwave.response import response_of, solved_reader
from octant.geometries.bodies import Body
from octant.geometries.errors import AntennaError, GeometryError
from octant.geometries.furniture import box
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9


@pytest.mark.slow
def test_the_table_gives_the_patterns_of_the_solution_in_any_direction():
    rng = np.random.default_rng(1)
    theta, phi = np.arccos(rng.uniform(-1, 1, 50)), rng.uniform(-7.0, 7.0, 50)
    for kind in ("dipole", "monopole"):
        body = reader_body(plate_height_m=0.04)
        result = solved_reader(body, make_antenna(kind, FREQUENCY_HZ), cells_per_wavelength=6.0)
        response = response_of(result, body)
        assert response.model == "fullwave"
        expected = result.far_field(theta, phi)
        scale = float(np.abs(expected).max())
        np.testing.assert_allclose(
            response.far_field(theta, phi), expected, rtol=0.0, atol=1e-4 * scale
        )


def test_antennas_without_a_mesh_are_refused():
    for antenna in (
        make_antenna("isotropic_theta", FREQUENCY_HZ),
        make_antenna("dipole", FREQUENCY_HZ, axis=(1.0, 0.0, 0.0)),
    ):
        with pytest.raises(AntennaError, match="no full-wave mesh"):
            solved_reader(reader_body(), antenna)


@pytest.mark.slow
def test_a_floor_plate_below_the_reader_shades_what_goes_down():
    """A plate of 0.3 m, 5 cm below a reader of 0.2 m, and the balance holds."""
    a = 0.15
    plate = Body(
        name="plate",
        vertices_m=[(x, y, -0.05) for x, y in ((-a, -a), (a, -a), (a, a), (-a, a))],
        faces=[[0, 1, 2], [0, 2, 3]],
        material="pec",
    )
    body = reader_body(plate_height_m=0.0)
    dipole = make_antenna("dipole", FREQUENCY_HZ)
    free = solved_reader(body, dipole, cells_per_wavelength=6.0)
    near = solved_reader(body, dipole, cells_per_wavelength=6.0, surroundings=(plate,))
    phi = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    below = [np.sum(np.abs(r.far_field(np.radians(150.0), phi)) ** 2) for r in (free, near)]
    assert below[1] < 0.7 * below[0]
    assert near.balance_error < 1e-3


def test_surroundings_that_cross_the_reader_are_refused():
    post = box((0.02, 0.02, 0.1), material="pec", position_m=(0.0, 0.0, -0.05))
    with pytest.raises(GeometryError, match="cross the reader"):
        solved_reader(
            reader_body(plate_height_m=0.0),
            make_antenna("dipole", FREQUENCY_HZ),
            cells_per_wavelength=5.0,
            surroundings=(post,),
        )
