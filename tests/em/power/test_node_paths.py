"""Where paths over walls and edges seem to come from: seen from other places, and of other tags."""

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.paths.tracing import trace_paths
from octant.em.power._node_kernels import towards_image
from octant.em.power.node_paths import trace_node_paths
from octant.em.search.candidates import SolverSettings, radio_scenes, search_candidates
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

CARRIER_HZ = 2.4e9
TAG_M = np.array([1.3, 2.6, 2.4])
HEIGHT_M = 0.35
SOLVER = SolverSettings(max_reflections=2, diffraction=True)
X_M, Y_M = np.array([2.9, 3.0]), np.array([0.8, 1.0, 1.3])


@pytest.fixture(scope="module")
def radios():
    """A metal cabinet in a room, turned out of the walls' directions."""
    room = box_room((4.0, 4.5, 2.7), material="concrete")
    cabinet = box((0.8, 0.5, 1.4), material="metal", position_m=(2.0, 2.0, 0.0), yaw_deg=25.0)
    return radio_scenes(build_scene([*room, cabinet]), [CARRIER_HZ], SOLVER)


@pytest.fixture(scope="module")
def found(radios):
    return trace_node_paths(
        radios,
        X_M,
        Y_M,
        tag_position_m=TAG_M,
        tag_antennas=[make_antenna("dipole", CARRIER_HZ)],
        reader_z_m=HEIGHT_M,
        solver=SOLVER,
    )


def nodes():
    return [(x, y) for x in X_M for y in Y_M]


def lengths_m(radios, place, tag_m=TAG_M):
    """Return the lengths of the solver's paths to one place."""
    candidates = search_candidates(radios[0], tag_m, SOLVER)
    return trace_paths(radios[0], candidates, [[*place, HEIGHT_M]]).length_m


def seen(found, node):
    """Return images, vectors to them and from their edges, of the paths to a node."""
    rows = found.image[found.start[node] : found.start[node + 1]]
    ways = np.array([towards_image(found.images[row], *nodes()[node], HEIGHT_M) for row in rows])
    return rows, ways[:, :3], ways[:, 3:]


def test_an_image_that_turns_about_an_edge_is_a_paths_length_away_from_every_place(radios, found):
    over = 0
    for node, place in enumerate(nodes()):
        rows, away, _ = seen(found, node)
        off = np.abs(np.linalg.norm(away, axis=1)[:, None] - lengths_m(radios, place))
        assert off.min(axis=1).max() < 1e-9
        over += np.count_nonzero(found.images[rows, 6])
    # Most images are seen from several nodes, but come from the path to the first.
    edges = np.count_nonzero(found.images[:, 6])
    assert edges > 10
    assert over > 3 * edges


def test_where_the_tag_moves_images_move(radios, found):
    move = np.array([6e-5, -5e-5, 4e-5])
    for node in (0, 4):
        rows, away, aside = seen(found, node)
        length = np.linalg.norm(away, axis=1)
        towards = away / length[:, None]
        moved = np.einsum("kij,j->ki", found.moves[rows], move)
        wide = -np.sum(aside * towards, axis=1)
        longer = np.sum(moved[:, :3] * towards, axis=1) + moved[:, 3] * wide
        assert np.abs(longer).max() > 3e-5
        off = np.abs((length + longer)[:, None] - lengths_m(radios, nodes()[node], TAG_M + move))
        assert off.min(axis=1).max() < 2e-8  # of second order


def test_the_strongest_carry_nearly_all_power(found):
    few = found.strongest()
    power = [float(np.sum(np.abs(one.fields[0]) ** 2)) for one in (found, few)]
    assert power[1] > 0.99 * power[0]
    assert len(few.image) < 0.8 * len(found.image)
    assert few.start[-1] == len(few.image)


def test_without_bends_only_the_tag_itself_is_seen(radios):
    found = trace_node_paths(
        radios,
        X_M,
        Y_M,
        tag_position_m=TAG_M,
        tag_antennas=[make_antenna("dipole", CARRIER_HZ)],
        reader_z_m=HEIGHT_M,
        solver=SolverSettings(max_reflections=0, diffraction=True),
    )
    np.testing.assert_allclose(found.images, [[*TAG_M, 0.0, 0.0, 0.0, 0.0]], rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(found.moves[0, :3], np.eye(3))
