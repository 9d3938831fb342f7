"""The response that radio maps read is the solution itself, on a grid."""

import numpy as np
import pytest

from octant.em.antennas import make_antenna
from octant.em.fullwave.response import fullwave_response
from octant.geometries.errors import AntennaError
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9


def test_the_table_gives_the_patterns_of_the_solution_in_any_direction():
    rng = np.random.default_rng(1)
    theta, phi = np.arccos(rng.uniform(-1, 1, 50)), rng.uniform(-7.0, 7.0, 50)
    for kind in ("dipole", "monopole"):
        response, result = fullwave_response(
            reader_body(plate_height_m=0.04),
            make_antenna(kind, FREQUENCY_HZ),
            cells_per_wavelength=6.0,
        )
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
            fullwave_response(reader_body(), antenna)
