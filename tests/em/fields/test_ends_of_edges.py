"""Past the ends of edges: the corners of plates."""

import math

import numpy as np
import pytest
from scipy.special import fresnel

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.bodies import Body
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

F = 2.4e9
WAVELENGTH = 299792458.0 / F
SPAN = [[-20.0] * 3, [20.0] * 3]


def plate(corners):
    faces = [[0, 1, 2], [0, 2, 3]]
    return Body(name="plate", vertices_m=corners, faces=faces, material="metal")


def over_free_space(body, source, places, *, diffractions=1, axis=(0.0, 0.0, 1.0)):
    """Return the sum of all paths' gains between half-wave dipoles, over that of free space."""
    scene = build_scene((), objects=[body])
    radio = radio_scene(scene, F, wedges=find_wedges(scene))
    solver = SolverSettings(max_reflections=2, diffraction=True, max_diffractions=diffractions)
    dipole = make_antenna("dipole", F, axis=axis)
    found = search_candidates(radio, source, solver, region_m=SPAN)
    paths = trace_paths(radio, found, places)
    gains = path_gains(radio, paths, transmitter=dipole, receiver=dipole)
    total = np.zeros(len(places), complex)
    np.add.at(total, paths.receiver, gains.gain)
    distance = np.linalg.norm(np.asarray(places) - source, axis=1)
    return total / (1.64 * WAVELENGTH / (4.0 * math.pi * distance))


def kirchhoff_share(begin, end, before, after):
    """Return the share of a wave that crosses a plane between two lines, by Fresnel integrals."""
    place = np.array([begin, end])
    detour = np.hypot(before, place) - before + np.hypot(after, place) - after
    sine, cosine = fresnel(np.sign(place) * 2.0 * np.sqrt(detour / WAVELENGTH))
    return np.sqrt(0.5j) * (np.diff(cosine) - 1j * np.diff(sine))[0]


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (1.0, 1.0, 0.0)])
def test_behind_the_corner_of_a_plate_the_field_is_that_of_kirchhoff(axis):
    """A wave loses what crosses the plate: 1 - G(x) G(y), without any ray in it."""
    before, after, side = 6.0, 9.0, 3.0
    body = plate([(0, 0, 0), (side, 0, 0), (side, side, 0), (0, side, 0)])
    steps = (-0.6, -0.31, -0.12, -0.03, 0.0, 0.02, 0.07, 0.23, 0.5)
    worst = 0.0
    for x in steps:
        for y in steps:
            field = over_free_space(body, (x, y, before), [(x, y, -after)], axis=axis)
            shares = (kirchhoff_share(-c, side - c, before, after) for c in (x, y))
            wanted = 1.0 - math.prod(shares)
            worst = max(worst, abs(abs(field[0]) - abs(wanted)))
    assert worst < 0.04


def turned_plate(turn):
    u, v = np.array((-math.sin(turn), math.cos(turn), 0.0)), np.array((0.0, 0.0, 1.0))
    middle = np.array((0.0, 0.0, 1.5))
    square = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return plate([middle + 0.5 * (s * u + q * v) for s, q in square])


@pytest.mark.parametrize("diffractions", [1, 2])
@pytest.mark.parametrize(
    ("degrees", "source", "place"),
    [
        (48.95, (3.0, 0.0, 1.5), (-2.0, 0.5, 1.3)),
        (117.95, (3.0, 0.0, 1.5), (-2.0, 0.5, 1.3)),
        (125.65, (3.0, 0.0, 1.5), (-2.0, 0.5, 1.3)),
        (10.15, (3.0, -1.0, 1.5), (3.0, 1.2, 1.4)),
        (173.15, (3.0, -1.0, 1.5), (3.0, 1.2, 1.4)),
    ],
)
def test_a_plate_turned_by_a_tenth_of_a_degree_changes_the_level_by_no_step(
    degrees, source, place, diffractions
):
    """Where rays over its edges once ended: 3.8, 2.4, 0.8, 0.5 and 0.4 dB."""
    here, there = (
        over_free_space(turned_plate(math.radians(t)), source, [place], diffractions=diffractions)
        for t in (degrees - 0.05, degrees + 0.05)
    )
    step_db = 20.0 * abs(math.log10(abs(here[0]) / abs(there[0])))
    assert step_db < 0.15
