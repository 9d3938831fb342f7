"""Meshes of the reader: conforming, fine where it matters, with every rotation the reader has."""

import math
from dataclasses import replace

import numpy as np
import pytest
from slow_rest import slow_after

from octant.em.reader.fullwave.basis import best_sectors
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.single import dipole_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
WAVELENGTH_M = 299792458.0 / FREQUENCY_HZ


def edges_of(mesh, *, antenna=None):
    """Return edges (e, 2), number of triangles on each, and lengths."""
    chosen = slice(None) if antenna is None else mesh.antenna_of_face == antenna
    sides = np.sort(mesh.faces[chosen][:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges, sheets = np.unique(sides, axis=0, return_counts=True)
    ends = mesh.vertices_m[edges]
    return edges, sheets, np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def area_of(mesh, antenna):
    a, b, c = (mesh.vertices_m[mesh.faces[mesh.antenna_of_face == antenna][:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


BODIES = [
    {},
    {"antenna_radius_m": 0.05},
    {"plate_height_m": 0.0},
    {"ground_plane_shape": "octagon", "antenna_radius_m": 0.09},
    {"plate_height_m": 0.03, "plate_height_axis_m": 0.10, "plate_outer_radius_m": 0.07},
    {"plate_height_m": 0.05, "plate_height_axis_m": 0.0},
    {"plate_profile_m": (0.09, 0.06), "plate_height_axis_m": 0.06, "plate_outer_radius_m": 0.09},
    {"antennas": 5, "antenna_radius_m": 0.09},
]


@pytest.mark.parametrize("changes", BODIES, ids=str)
def test_the_mesh_covers_the_sheets_and_meets_along_feet_and_axis(changes):
    body = reader_body(**changes)
    mesh = reader_mesh(body, frequency_hz=FREQUENCY_HZ)
    a, b, c = (body.body.vertices_m[body.body.faces[:, k]] for k in range(3))
    expected = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area_of(mesh, -1) == pytest.approx(expected, rel=1e-9)
    edges, sheets, length = edges_of(mesh, antenna=-1)
    ends = mesh.vertices_m[edges]
    on_axis = (np.abs(ends[..., :2]) < 1e-9).all(axis=(1, 2))
    plates = len(body.plate_azimuths_rad)
    if body.plate_height_axis_m > 0.0:
        assert length[on_axis].sum() == pytest.approx(body.plate_height_axis_m)
        assert (sheets[on_axis] == plates).all()
    flat = (np.abs(ends[..., 2]) < 1e-9).all(axis=1)
    feet = flat & (sheets >= 3)
    on_rim_too = flat & (sheets == 2)
    assert length[feet].sum() == pytest.approx(plates * body.plate_outer_radius_m, rel=1e-9)
    assert on_rim_too.any()
    corner = mesh.vertices_m[mesh.faces]
    ahead, back = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(back, axis=2)
    assert np.degrees(np.arccos((ahead * back).sum(axis=2) / lengths)).min() > 5.0


def test_elements_are_as_long_as_asked_and_fine_under_the_feet():
    for gap_m in (0.005, 0.001):
        mesh = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ, gap_m=gap_m)
        edges, _, length = edges_of(mesh, antenna=-1)
        assert length.max() < 1.5 * WAVELENGTH_M / 10.0
        middle = mesh.vertices_m[edges].mean(axis=1)
        for foot in mesh.feed_bottom_m * (1.0, 1.0, 0.0):
            near = np.linalg.norm(middle - foot, axis=1) < 0.6 * gap_m
            assert near.any()
            assert length[near].mean() <= gap_m
            assert length[near].max() <= 1.1 * gap_m
    fine = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ, cells_per_wavelength=20.0)
    assert edges_of(fine, antenna=-1)[2].mean() < 0.7 * edges_of(mesh, antenna=-1)[2].mean()


def test_strips_stand_across_the_radius_and_are_four_wire_radii_wide():
    mesh = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ, length_m=0.0625)
    for i in range(8):
        points = mesh.vertices_m[np.unique(mesh.faces[mesh.antenna_of_face == i])]
        azimuth = i * math.pi / 4
        radial = points[:, :2] @ (math.cos(azimuth), math.sin(azimuth))
        across = points[:, :2] @ (-math.sin(azimuth), math.cos(azimuth))
        np.testing.assert_allclose(radial, 0.1, atol=1e-12)
        np.testing.assert_allclose(np.abs(across), 0.001, atol=1e-12)
        assert points[:, 2].min() == pytest.approx(0.005)
        assert points[:, 2].max() == pytest.approx(0.0675)
        assert (mesh.antenna_of_face == i).sum() == 2 * (24 + 4)  # graded tips
    np.testing.assert_allclose(mesh.phase_centres_m[0], (0.1, 0.0, 0.03625))
    np.testing.assert_allclose(mesh.feed_top_m - mesh.feed_bottom_m, [(0.0, 0.0, 0.0057)] * 8)


@pytest.mark.parametrize("changes", [{}, {"antenna_radius_m": 0.07}, {"monopole_plane_m": 0.04}])
@pytest.mark.parametrize("shape", ["square", "round"])
@pytest.mark.parametrize("cells", slow_after(2, [8.0, 10.0, 18.0]))
def test_monopoles_stand_on_an_edge_as_wide_as_the_strip(changes, shape, cells):
    body = reader_body(ground_plane_shape=shape, **changes)
    mesh = reader_mesh(
        body, frequency_hz=FREQUENCY_HZ, antenna="monopole", cells_per_wavelength=cells
    )
    every, all_sheets, _ = edges_of(mesh)
    count = {tuple(e): n for e, n in zip(every.tolist(), all_sheets, strict=True)}
    for i in range(8):
        edges, sheets, length = edges_of(mesh, antenna=i)
        level = np.abs(mesh.vertices_m[edges][..., 2] - mesh.feed_bottom_m[i, 2]) < 1e-9
        foot = level.all(axis=1)
        assert foot.sum() == 2
        assert length[foot].sum() == pytest.approx(0.002, rel=1e-3)
        assert (sheets[foot] == 1).all()
        assert all(count[tuple(e)] >= 2 for e in edges[foot].tolist())


@pytest.mark.parametrize(
    ("changes", "sectors"),
    [
        ({}, 4),
        ({"plate_height_m": 0.0}, 4),
        ({"ground_plane_shape": "round"}, 8),
        ({"ground_plane_shape": "octagon"}, 8),
        ({"ground_plane_shape": "round", "antennas": 5}, 5),
        ({"ground_plane_shape": "round", "antennas": 6}, 6),
    ],
    ids=str,
)
@pytest.mark.parametrize("antenna", ["dipole", "monopole"])
def test_the_mesh_has_the_readers_rotations(changes, sectors, antenna):
    mesh = reader_mesh(
        reader_body(antenna_radius_m=0.08, **changes), frequency_hz=FREQUENCY_HZ, antenna=antenna
    )
    assert best_sectors(mesh.vertices_m, mesh.faces, (8, 6, 5, 4, 3, 2)) == sectors


def test_a_robot_below_the_reader_joins_the_mesh_and_ends_its_symmetry():
    robot = box((0.15, 0.10, 0.05), position_m=(-0.05, -0.05, -0.08), material="pec")
    mesh = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ, surroundings=(robot,))
    assert mesh.vertices_m[:, 2].min() == pytest.approx(-0.08)
    assert best_sectors(mesh.vertices_m, mesh.faces, (8, 4, 2)) == 1
    bare = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ)
    assert area_of(mesh, -1) == pytest.approx(area_of(bare, -1))
    assert area_of(mesh, -2) == pytest.approx(2 * (0.015 + 0.0075 + 0.005))


def test_an_antenna_close_to_the_plates_is_told():
    assert reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ).warnings == ()
    (doubt,) = reader_mesh(
        reader_body(antenna_radius_m=0.02), frequency_hz=FREQUENCY_HZ, cells_per_wavelength=4.0
    ).warnings
    assert "6.7 mm from the nearest sheet or neighbour" in doubt


@pytest.mark.parametrize(
    ("body", "changes", "message"),
    [
        ({"antenna_radius_m": 0.002, "plate_height_m": 0.0}, {}, "touches antenna 1 at"),
        ({"antenna_radius_m": 0.002}, {}, "antenna 1 touches the plate at 22.5 deg"),
        ({}, {"gap_m": 0.0}, "gap_m is 0 m"),
        ({}, {"feed_gap_m": 0.07}, "feed_gap_m is 0.07 m, but the antenna is only"),
        ({}, {"antenna": "patch"}, "carries 'dipole' or 'monopole'"),
        ({}, {"cells_per_wavelength": 2.0}, "at least 4"),
        ({}, {"length_m": -1.0}, "length_m is -1 m"),
        ({}, {"frequency_hz": 0.0}, "frequency_hz is 0 Hz"),
    ],
)
def test_readers_that_cannot_be_meshed_are_refused(body, changes, message):
    with pytest.raises(GeometryError, match=message):
        reader_mesh(reader_body(**body), **{"frequency_hz": FREQUENCY_HZ, **changes})


def test_antennas_at_unequal_angles_keep_their_places():
    azimuths = np.radians((0.0, 50.0, 130.0, 200.0, 290.0))
    following = np.append(azimuths[1:], azimuths[0] + 2.0 * math.pi)
    body = replace(
        reader_body(antennas=5, antenna_radius_m=0.08),
        element_azimuths_rad=azimuths,
        plate_azimuths_rad=0.5 * (azimuths + following),
    )
    result = solve_reader(reader_mesh(body, frequency_hz=FREQUENCY_HZ, cells_per_wavelength=6.0))
    assert result.basis.sectors == 1
    assert result.balance_error < 1e-3
    toward = np.abs(result.far_field(1.2, azimuths)[..., 0])
    assert (np.argmax(toward, axis=0) == np.arange(5)).all()


def test_the_dipole_alone_has_cells_in_proportion_to_its_length():
    short, long = (dipole_mesh(frequency_hz=FREQUENCY_HZ, length_m=x) for x in (0.0625, 0.125))
    assert len(short.faces) == 2 * (24 + 4)
    assert len(long.faces) == 2 * (48 + 4)
