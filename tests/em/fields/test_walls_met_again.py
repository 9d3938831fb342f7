"""Coefficients of walls that are parallel to one met before are taken over, and of no others."""

import numpy as np
import pytest

from octant.em.fields import _wave_kernels as waves

COUNT = 50
COEFFICIENTS = (waves.TR, waves.TI, waves.UR, waves.UI)


def met(state, direction, normal, eps, known):
    """Meet a wall; return its coefficients and how many walls are known then."""
    for k, row in enumerate((waves.DX, waves.DY, waves.DZ)):
        state[row : row + COUNT] = direction[k]
    for k, row in enumerate((waves.NX, waves.NY, waves.NZ)):
        state[row : row + COUNT] = normal[k]
    state[waves.ER : waves.ER + COUNT] = eps.real
    state[waves.EI : waves.EI + COUNT] = eps.imag
    known = waves.reflect_half_spaces(state, COUNT, known)
    return np.array([state[row : row + COUNT] for row in COEFFICIENTS]), known


@pytest.mark.parametrize(
    ("normal", "eps", "again"),
    [
        ((0.0, 0.0, -1.0), 5.2 - 0.3j, True),  # floor and ceiling
        ((0.0, 0.0, 1.0), 5.2 - 0.4j, False),
        ((0.0, 0.0, 1.0), 5.1 - 0.3j, False),
        ((0.0, 1.0, 0.0), 5.2 - 0.3j, False),
    ],
)
def test_a_wall_met_again_has_the_coefficients_that_it_has_at_first(normal, eps, again):
    direction = np.random.default_rng(7).normal(size=(3, COUNT))
    direction /= np.linalg.norm(direction, axis=0)
    state = np.zeros(waves.SIZE)
    _, known = met(state, direction, (0.0, 0.0, 1.0), 5.2 - 0.3j, 0)
    assert known == 1
    after, known = met(state, direction, normal, eps, known)
    assert known == (1 if again else 2)
    alone, _ = met(np.zeros(waves.SIZE), direction, normal, eps, 0)
    assert np.array_equal(after, alone)


def test_more_walls_than_are_kept_are_computed_each_time():
    direction = np.full((3, COUNT), 1.0 / np.sqrt(3.0))
    state, known = np.zeros(waves.SIZE), 0
    for k in range(2 * waves.WALLS):
        eps = 3.0 + k % (waves.WALLS + 1) - 0.1j
        found, known = met(state, direction, (1.0, 0.0, 0.0), eps, known)
        alone, _ = met(np.zeros(waves.SIZE), direction, (1.0, 0.0, 0.0), eps, 0)
        assert np.array_equal(found, alone)
    assert known == waves.WALLS
