"""Solutions of the moment equations do not depend on the precision of the factors."""

import numpy as np
import pytest

from octant.em.reader.fullwave import linear_solve
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.errors import GeometryError
from octant.geometries.reader_body import reader_body


@pytest.mark.parametrize(("shape", "symmetry"), [("square", True), ("round", False)])
def test_single_precision_factors_give_the_currents_of_double_ones(monkeypatch, shape, symmetry):
    body = reader_body(ground_plane_shape=shape, antenna_radius_m=0.08, plate_height_m=0.05)
    mesh = reader_mesh(body, frequency_hz=2.4e9, cells_per_wavelength=4.0)
    exact = solve_reader(mesh, symmetry=symmetry)
    monkeypatch.setattr(linear_solve, "SINGLE_FROM", 0)
    refined = solve_reader(mesh, symmetry=symmetry)
    np.testing.assert_allclose(
        refined.halves_a_per_m,
        exact.halves_a_per_m,
        rtol=0.0,
        atol=1e-12 * np.abs(exact.halves_a_per_m).max(),
    )
    assert not np.array_equal(refined.halves_a_per_m, exact.halves_a_per_m)


def of_condition(condition, size=60):
    """A complex matrix, and a right-hand side."""
    rng = np.random.default_rng(3)
    left, one = np.linalg.qr(rng.normal(size=(size, size)) + 1j * rng.normal(size=(size, size)))
    side, _ = np.linalg.qr(one + one.T)
    matrix = (left * np.geomspace(1.0, 1.0 / condition, size)) @ side
    return np.asfortranarray(matrix), rng.normal(size=(size, 2)) + 0j


@pytest.mark.parametrize("transposed", [False, True])
@pytest.mark.parametrize("condition", [1e2, 1e5, 1e11])
def test_residuals_vanish_even_where_single_precision_cannot_follow(
    monkeypatch, condition, transposed
):
    monkeypatch.setattr(linear_solve, "SINGLE_FROM", 0)
    matrix, right = of_condition(condition)
    right[:, 1] = 0.0
    found = linear_solve._factors(matrix.copy(order="F")).solve(right, transposed=transposed)
    rest = (matrix.T if transposed else matrix) @ found - right
    scale = np.abs(matrix).max() * np.abs(found).max()
    assert np.abs(rest).max() < 1e-12 * scale
    assert not found[:, 1].any()


def test_a_singular_matrix_is_refused_in_single_precision_too(monkeypatch):
    monkeypatch.setattr(linear_solve, "SINGLE_FROM", 0)
    matrix, right = of_condition(1e2)
    matrix[:, 5] = matrix[:, 7]
    with pytest.raises(GeometryError, match="singular"):
        linear_solve._factors(matrix).solve(right)
