"""Metal beside the reader: laid evenly, as its shape and not its drawing asks, with its turns."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave import solve
from octant.em.reader.fullwave._orientation import oriented
from octant.em.reader.fullwave.basis import best_sectors
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.surroundings import even_mesh, surroundings_size
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box, cylinder
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
WAVELENGTH_M = SPEED_OF_LIGHT_M_PER_S / FREQUENCY_HZ


def area_m2(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def edges(vertices, faces):
    """Return length of each edge and the number of triangles on it."""
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    pairs, sheets = np.unique(sides, axis=0, return_counts=True)
    return np.linalg.norm(vertices[pairs[:, 0]] - vertices[pairs[:, 1]], axis=1), sheets


def centred_box(size, z_m=-0.25):
    return box(size, material="pec", position_m=(-0.5 * size[0], -0.5 * size[1], z_m))


def cut_finer(body, rng, rounds):
    """Return the same body drawn otherwise: triangles cut at random places, faces shuffled."""
    vertices, faces = body.vertices_m.tolist(), body.faces.tolist()
    for _ in range(rounds):
        a, b, _ = faces[rng.integers(len(faces))]
        edge, share = (a, b), rng.uniform(0.2, 0.8)
        vertices.append(np.add(vertices[a], share * np.subtract(vertices[b], vertices[a])).tolist())
        new, kept = len(vertices) - 1, []
        for face in faces:
            if set(edge) <= set(face):
                kept += [[new if v == gone else v for v in face] for gone in edge]
            else:
                kept.append(face)
        faces = kept
    order = rng.permutation(len(faces))
    return np.array(vertices), np.array(faces)[order]


@pytest.mark.parametrize("cells", [6.0, 10.0, 14.0])
@pytest.mark.parametrize(
    "body",
    [
        centred_box((0.15, 0.15, 0.1)),
        box((0.15, 0.15, 0.1), material="pec", position_m=(-0.1, -0.05, -0.25)),
        cylinder(0.15, 0.2, material="pec", position_m=(0.0, 0.0, -0.25)),
    ],
    ids=["middle", "beside", "cylinder"],
)
def test_a_body_has_as_many_functions_as_equal_triangles_of_that_edge(body, cells):
    edge = WAVELENGTH_M / cells
    vertices, faces = even_mesh(body.vertices_m, body.faces, edge_m=edge, turns=8)
    length, sheets = edges(vertices, faces)
    assert (sheets == 2).all()
    assert area_m2(vertices, faces) == pytest.approx(body.area_m2, rel=1e-9)
    ideal = 1.5 * body.area_m2 / (0.25 * math.sqrt(3.0) * edge**2)
    assert 0.75 * ideal < len(length) < 1.1 * ideal
    assert 0.6 * edge < length.min() < length.mean() < 1.2 * edge
    assert surroundings_size((body,), edge_m=edge, antennas=8)[0] == len(length)


@pytest.mark.parametrize(
    ("body", "antennas", "sectors"),
    [
        (centred_box((0.3, 0.3, 0.2)), 8, 4),
        (centred_box((0.3, 0.3, 0.2)), 6, 2),
        (centred_box((0.3, 0.24, 0.2)), 8, 2),
        (box((0.3, 0.3, 0.2), material="pec", position_m=(-0.2, -0.15, -0.25)), 8, 1),
        (
            box((0.2, 0.2, 0.1), material="pec", position_m=(0, -(0.02**0.5), -0.3), yaw_deg=45),
            8,
            4,
        ),
        (cylinder(0.15, 0.2, material="pec", position_m=(0.0, 0.0, -0.25)), 8, 8),
        (cylinder(0.15, 0.2, material="pec", sides=6, position_m=(0.0, 0.0, -0.25)), 6, 6),
    ],
)
def test_a_body_keeps_the_turns_of_its_shape_however_it_is_wound(body, antennas, sectors):
    assert surroundings_size((body,), edge_m=0.02, antennas=antennas)[1] == sectors
    rng = np.random.default_rng(7)
    faces = [face[:: rng.choice((1, -1))] for face in body.faces]
    wound = replace(body, faces=np.array(faces))
    assert surroundings_size((wound,), edge_m=0.02, antennas=antennas)[1] == sectors


@pytest.mark.parametrize("axes", [(0, 1), (0, 2), (1, 2)], ids=["flat", "radial", "across"])
def test_turned_sheets_are_wound_alike(axes):
    grid = np.zeros((6, 3))
    grid[:, list(axes)] = [(i, j) for i in range(3) for j in range(2)]
    faces = np.array(((0, 1, 2), (1, 2, 3), (2, 3, 4), (5, 3, 4)))
    normals = []
    for k in range(4):
        turn = np.linalg.matrix_power(np.array(((0, 1, 0), (-1, 0, 0), (0, 0, 1))), k)
        wound = [face[:: 1 if (k + i) % 3 else -1] for i, face in enumerate(faces)]
        found = oriented((grid + np.array((1.0, 0.2, 0.0))) @ turn, np.array(wound))
        a, b, c = np.moveaxis(grid[found], 1, 0)
        normals.append(np.cross(b - a, c - a))
    assert np.abs(np.array(normals) - normals[0][0]).max() < 1e-12


@given(
    st.tuples(*[st.floats(0.03, 0.1)] * 3),
    st.floats(-180.0, 180.0),
    st.integers(0, 12),
    st.integers(0, 2**32 - 1),
)
def test_the_mesh_follows_the_shape_however_it_was_drawn(size, yaw_deg, rounds, seed):
    body = box(size, material="pec", position_m=(0.01, -0.02, -0.3), yaw_deg=yaw_deg)
    vertices, faces = cut_finer(body, np.random.default_rng(seed), rounds)
    laid, triangles = even_mesh(vertices, faces, edge_m=0.02, turns=8)
    length, sheets = edges(laid, triangles)
    assert (sheets == 2).all()  # closed, so every edge is shared: currents pass everywhere
    assert area_m2(laid, triangles) == pytest.approx(body.area_m2, rel=1e-9)
    plain = len(edges(*even_mesh(body.vertices_m, body.faces, edge_m=0.02, turns=8))[0])
    assert len(length) < 1.5 * plain + 12 * rounds


def test_sheets_that_meet_at_an_edge_stay_joined_there():
    plan = np.array(((0, 0), (0.1, 0), (0.1, 0.1), (0.05, 0.1), (0.05, 0.05), (0, 0.05)))
    top = np.column_stack((plan, np.zeros(6)))
    fin = np.array(((0.0, 0.05, 0.04), (0.05, 0.05, 0.04)))
    faces = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (0, 4, 5), (5, 4, 7), (5, 7, 6)]
    vertices, triangles = even_mesh(np.concatenate((top, fin)), faces, edge_m=0.012)
    length, sheets = edges(vertices, triangles)
    outline = 0.1 + 0.1 + 0.05 + 0.05 + 0.05 + 0.04 + 0.05 + 0.04
    assert length[sheets == 1].sum() == pytest.approx(outline)
    assert area_m2(vertices, triangles) == pytest.approx(0.0075 + 0.002)


@pytest.mark.parametrize(
    ("body", "advice", "silent"),
    [
        (box((0.1, 0.1, 0.1), material="pec", position_m=(-0.06, -0.05, -0.2)), "axis", "antennas"),
        (centred_box((0.1, 0.1, 0.1), -0.2), "less of that metal", "axis"),
        (None, "antennas farther", "metal"),
    ],
)
def test_a_mesh_that_is_too_large_says_what_makes_it_large(monkeypatch, body, advice, silent):
    monkeypatch.setattr(solve, "MOST_GIB", 1e-3)
    around = () if body is None else (body,)
    mesh = reader_mesh(
        reader_body(), frequency_hz=FREQUENCY_HZ, cells_per_wavelength=6.0, surroundings=around
    )
    with pytest.raises(GeometryError, match=advice) as refusal:
        solve.solve_reader(mesh)
    assert silent not in str(refusal.value)
    assert "fewer cells_per_wavelength than 6" in str(refusal.value)
    if body is not None:
        count, _ = surroundings_size(around, edge_m=mesh.coarse_m, antennas=8)
        assert f"about {count} of them on the metal beside the reader" in str(refusal.value)


def test_the_turns_left_are_those_of_all_bodies_together():
    one = box((0.05, 0.05, 0.05), material="pec", position_m=(0.1, -0.025, -0.2))
    other = box((0.05, 0.05, 0.05), material="pec", position_m=(-0.15, -0.025, -0.2))
    assert surroundings_size((one, other), edge_m=0.02, antennas=8)[1] == 2
    assert surroundings_size((one,), edge_m=0.02, antennas=8)[1] == 1
    assert surroundings_size((), edge_m=0.02, antennas=8) == (0, 8)
    mesh = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ, surroundings=(one, other))
    assert best_sectors(mesh.vertices_m, mesh.faces, (8, 4, 2)) == 2


def test_a_body_without_area_adds_nothing():
    flat = Body(
        name="flat",
        vertices_m=[(0, 0, -0.1), (0.1, 0, -0.1), (0.05, 0, -0.1), (0, 0.1, -0.1)],
        faces=[(0, 1, 2), (0, 1, 3)],
        material="pec",
    )
    _, faces = even_mesh(flat.vertices_m, flat.faces, edge_m=1.0)
    assert len(faces) == 1
