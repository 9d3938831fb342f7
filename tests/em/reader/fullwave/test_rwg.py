"""Scatterers with known answers: Mie's sphere, walls inside closed metal, the optical theorem."""

import math

import numpy as np
import pytest
import trimesh
from plane_waves import scattered_currents
from scipy.special import spherical_jn, spherical_yn

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.basis import best_sectors, surface_basis
from octant.em.reader.fullwave.far_field import band_limited
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.em.reader.fullwave.surroundings import even_mesh
from octant.geometries.errors import GeometryError

FREQUENCY_HZ = 2.4e9
WAVELENGTH_M = SPEED_OF_LIGHT_M_PER_S / FREQUENCY_HZ
WAVENUMBER = 2.0 * math.pi / WAVELENGTH_M


def mie_amplitudes(ka, theta):
    """Return S1, S2 of a perfectly conducting sphere, by its series in exp(+jwt)."""
    order = np.arange(1, math.ceil(ka) + 12)
    j, dj = spherical_jn(order, ka), spherical_jn(order, ka, derivative=True)
    y, dy = spherical_yn(order, ka), spherical_yn(order, ka, derivative=True)
    a = (j + ka * dj) / (j - 1j * y + ka * (dj - 1j * dy))
    b = j / (j - 1j * y)
    mu = np.cos(theta)
    before, now = np.zeros_like(mu), np.ones_like(mu)
    s1 = s2 = 0.0
    for n, an, bn in zip(order, a, b, strict=True):
        tau = n * mu * now - (n + 1) * before
        factor = (2 * n + 1) / (n * (n + 1))
        s1 = s1 + factor * (an * now + bn * tau)
        s2 = s2 + factor * (an * tau + bn * now)
        before, now = now, ((2 * n + 1) * mu * now - (n + 1) * before) / n
    return s1, s2


def test_bistatic_cross_section_of_a_sphere_follows_the_mie_series():
    ka = 5.93  # between the interior resonances 5.763 and 6.062; elements of 1/7 wavelength
    sphere = trimesh.creation.icosphere(subdivisions=3)
    scale = (4.0 * math.pi / 3.0 / sphere.volume) ** (1.0 / 3.0) * ka / WAVENUMBER
    basis = surface_basis(sphere.vertices * scale, sphere.faces)
    assert WAVELENGTH_M / basis.edge_lengths_m.mean() == pytest.approx(7.0, abs=0.1)
    currents = scattered_currents(
        basis, frequency_hz=FREQUENCY_HZ, travel=[(0, 0, 1)], polarisation=[(1, 0, 0)]
    )
    theta = np.radians(np.arange(0.0, 180.5, 1.0))
    s1, s2 = mie_amplitudes(ka, theta)
    for phi, component, series in ((0.0, 0, s2), (math.pi / 2, 1, s1)):
        found = 4.0 * math.pi * np.abs(currents.far_field(theta, phi)[0, :, component]) ** 2
        expected = 4.0 * math.pi / WAVENUMBER**2 * np.abs(series) ** 2
        off_db = 10.0 * np.log10(found / expected)
        assert np.abs(off_db[expected > expected.max() * 10.0**-1.5]).max() < 0.05


def box_mesh(side_m, cells, *, wall):
    """Return a cube of squares cut in two, with or without a wall across its middle."""
    grid = np.linspace(-0.5 * side_m, 0.5 * side_m, cells + 1)
    u, v = (a.ravel() for a in np.meshgrid(grid, grid, indexing="ij"))
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (
        corner[i : cells + i, j : cells + j].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    )
    sheet = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    levels = [(axis, end) for axis in range(3) for end in (-0.5, 0.5)]
    levels += [(0, 0.0)] if wall else []
    points, faces = [], []
    for axis, level in levels:
        place = np.insert(np.column_stack((u, v)), axis, level * side_m, axis=1)
        faces.append(sheet + sum(len(p) for p in points))
        points.append(place)
    used, inverse = np.unique(np.round(np.concatenate(points), 9), axis=0, return_inverse=True)
    return used, inverse.reshape(-1)[np.concatenate(faces)]


def test_a_wall_inside_a_closed_cube_is_not_seen_from_outside():
    gains = []
    for wall in (False, True):
        vertices, faces = box_mesh(0.55 * WAVELENGTH_M, 6, wall=wall)
        basis = surface_basis(vertices, faces)
        edges = np.sort(basis.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        sheets = np.unique(edges, axis=0, return_counts=True)[1]
        assert basis.unknowns == (sheets - 1).sum()
        assert (sheets.max() == 3) == wall
        currents = scattered_currents(
            basis,
            frequency_hz=FREQUENCY_HZ,
            travel=[(0.0, 0.6, -0.8)],
            polarisation=[(0.6, 0.64, 0.48)],
        )
        theta, phi = np.radians(np.arange(0.0, 181.0, 10.0))[:, None], np.linspace(0.0, 6.0, 13)
        gains.append(10.0 * np.log10((np.abs(currents.far_field(theta, phi)[0]) ** 2).sum(-1)))
    strong = gains[0] > gains[0].max() - 20.0
    assert np.abs((gains[1] - gains[0])[strong]).max() < 0.01


def square_plate(side_m, edge_m):
    h = 0.5 * side_m
    corners = np.array(((-h, -h, 0.0), (h, -h, 0.0), (h, h, 0.0), (-h, h, 0.0), (0.0, 0.0, 0.0)))
    faces = np.array(((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)))
    return even_mesh(corners, faces, edge_m=edge_m, turns=8)


@pytest.mark.slow
def test_a_square_plate_keeps_the_optical_theorem_and_tends_to_physical_optics():
    side_m = 2.0 * WAVELENGTH_M
    basis = surface_basis(*square_plate(side_m, 0.13 * WAVELENGTH_M))
    currents = scattered_currents(
        basis, frequency_hz=FREQUENCY_HZ, travel=[(0, 0, -1)], polarisation=[(1, 0, 0)]
    )
    scattered_m2 = 4.0 * math.pi * float(band_limited(currents).power_matrix()[0, 0].real)
    ahead = currents.far_field(math.pi, 0.0)[0, 0]  # at theta = 180 deg, theta-hat is -x
    extinction_m2 = 4.0 * math.pi / WAVENUMBER * float(ahead.imag)  # exp(+jwt)
    assert extinction_m2 == pytest.approx(scattered_m2, rel=1e-3)
    back_m2 = 4.0 * math.pi * float((np.abs(currents.far_field(0.0, 0.0)[0]) ** 2).sum())
    physical_optics_m2 = 4.0 * math.pi * side_m**4 / WAVELENGTH_M**2
    assert 10.0 * math.log10(back_m2 / physical_optics_m2) == pytest.approx(0.0, abs=0.5)


def test_the_plate_has_fourfold_symmetry_and_the_modes_see_the_same_matrix():
    vertices, faces = square_plate(WAVELENGTH_M, 0.3 * WAVELENGTH_M)
    assert best_sectors(vertices, faces, (8, 4, 2)) == 4
    plain, turned = (surface_basis(vertices, faces, sectors=s) for s in (1, 4))
    assert plain.unknowns == turned.unknowns
    traces = [
        basis.sectors * np.trace(impedance_matrix(basis, frequency_hz=FREQUENCY_HZ)[:, 0, :])
        for basis in (plain, turned)
    ]
    np.testing.assert_allclose(traces[0], traces[1], rtol=1e-9)


def test_meshes_that_cannot_be_solved_are_refused():
    corners = np.array(((0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0)), dtype=float)
    with pytest.raises(GeometryError, match="no edge that two triangles share"):
        surface_basis(corners, [(0, 1, 2)])
    with pytest.raises(GeometryError, match="triangle 1 has no area"):
        surface_basis(corners, [(0, 1, 2), (0, 1, 3)])
    with pytest.raises(GeometryError, match="does not map the mesh onto itself"):
        surface_basis(corners, [(0, 1, 2), (1, 3, 2)], sectors=4)
    twice = [(0, 1, 2), (0, 1, 2), (1, 3, 2)]
    with pytest.raises(GeometryError, match="triangles 0 and 1 lie on each other"):
        surface_basis(corners * 0.02, twice)
