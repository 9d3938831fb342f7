"""Ends in the planes of facets, level with edges, above corners: what random places never meet."""

import os

import numpy as np
import pytest
from lattice_scenes import LatticeScene, Solved, faults_of_case, lattice_scene
from slow_rest import slow_after

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.explain import explain_path
from octant.em.fields.gains import path_gains
from octant.em.search.candidates import SolverSettings
from octant.geometries.bodies import Body
from octant.geometries.furniture import cabinet
from octant.geometries.rooms import box_room

SCENES = int(os.environ.get("OCTANT_LATTICE_SCENES", "12"))
ONCE_WRONG = (
    *(171, 294, 391, 431, 515, 559, 560, 3727, 3790, 4588, 6287, 7134, 7995, 8494),
    *(574, 2434, 4676, 6029, 6935),  # in line with a rim, two edges of one corner, a foot
    *(6069, 7811, 9892, 4553),  # a leg along an edge, from a tip along a face
    *(9277, 3544, 30111),  # beside a rim that is passed, on both boundaries of two edges
    40196,  # more paths that touch edges than a chunk of images
    *(30279, 1216),  # along a pane between two edges, where the material of an edge changes
)
F = 2.4e9


def scene(size, objects, ends, order, **solver):
    return LatticeScene(
        room=tuple(box_room(size)),
        objects=tuple(objects),
        ends=np.array(ends, dtype=float),
        solver=SolverSettings(max_reflections=order, **solver),
    )


def solved(size, objects, source, receivers, order, **solver):
    case = scene(size, objects, (), order, **solver)
    return Solved(case, source, np.atleast_2d(receivers), axis=(0.0, 0.0, 1.0))


def counts(found):
    return np.bincount(found.paths.receiver, minlength=found.count).tolist()


def partition(material, x=2.5):
    corners = [(x, 0, 0), (x, 4, 0), (x, 4, 3), (x, 0, 3)]
    return Body(name="sheet", vertices_m=corners, faces=[[0, 1, 2], [0, 2, 3]], material=material)


@pytest.mark.parametrize("order", [2, 3])
def test_ends_level_with_a_cabinet_have_the_field_of_a_micrometre_above_or_below(order):
    block = cabinet((1.0, 1.0, 1.0), position_m=(2.0, 1.5, 0.0))
    size, source = (5.0, 4.0, 3.0), (1.0, 1.0, 1.0)
    places = [(4.0, 2.3, 1.0 + step) for step in (0.0, 1e-6, -1e-6)]
    found = solved(size, [block], source, places, order, diffraction=True)
    here, above, below = (abs(found.total(i)) for i in range(3))
    assert min(above, below) * 0.999 <= here <= max(above, below) * 1.001
    assert faults_of_case(scene(size, [block], (source, places[0]), order, diffraction=True)) == []


def test_a_convex_edge_reflects_nothing_back_that_comes_along_its_bisector():
    """Straight below a tag: both faces of the cabinet's edge are equally far."""
    block = cabinet((1.0, 1.0, 2.0), position_m=(3.0, 3.0, 0.0))
    places = [(2.0, 2.0, 0.3), (2.0 + 1e-6, 2.0, 0.3), (2.0, 2.0 + 1e-6, 0.3)]
    found = solved((6.0, 6.0, 3.0), [block], (2.0, 2.0, 2.9), places, 2)
    assert counts(found) == [24, 24, 24]


@pytest.mark.parametrize("z", [0.7, 1.0, 1.2, 1.75, 2.5, 3.3, 3.5])
def test_an_edge_and_its_image_in_the_floor_are_one_edge(z):
    """Equally far from a vertical edge and equally high: the ray bends at its foot, or its head."""
    block = cabinet((1.0, 1.0, 2.0), position_m=(4.0, 4.0, 0.0))
    ends = ((3.0, 5.0, z), (3.0, 3.0, z))
    assert faults_of_case(scene((6.0, 6.0, 4.0), [block], ends, 2, diffraction=True)) == []


def test_nothing_passes_under_a_closed_partition():
    ends = [(4.0, 2.0, 1.5), (4.0 + 1e-6, 2.0, 1.5), (4.0, 1.2, 0.9)]
    found = solved((5.0, 4.0, 3.0), [partition("metal")], (1.0, 2.0, 1.5), ends, 3)
    assert counts(found) == [0, 0, 0]


def test_a_pane_is_passed_where_its_foot_reflects():
    """The reflection falls on the foot of the pane; the wave passes it before or behind."""
    found = solved(
        (5.0, 4.0, 3.0),
        [partition("pane")],
        (1.0, 2.0, 1.5),
        [(4.0, 2.0, 1.5), (4.0 + 1e-6, 2.0, 1.5)],
        1,
        transmission=True,
    )
    here, aside = counts(found)
    assert here == aside
    assert all("T" in found.paths.letters_of(k) for k in range(here))
    assert found.total(0) == pytest.approx(found.total(1), rel=1e-3)


def test_budgets_add_up_to_the_gain_where_legs_have_no_length():
    block = cabinet((1.0, 1.0, 2.0), position_m=(4.0, 4.0, 0.0))
    found = solved((6.0, 6.0, 4.0), [block], (3.0, 5.0, 1.0), (3.0, 3.0, 1.0), 2, diffraction=True)
    legs = np.linalg.norm(np.diff(found.paths.vertices_m, axis=1), axis=2)
    used = np.arange(legs.shape[1]) <= found.paths.interactions[:, None]
    short = np.flatnonzero((used & (legs < 1e-9)).any(axis=1))
    antenna = make_antenna("dipole", F)
    gains = path_gains(found.radio, found.paths, transmitter=antenna, receiver=antenna).gain
    assert len(short) > 0
    for k in short:
        budget = explain_path(
            found.radio, found.paths, int(k), transmitter=antenna, receiver=antenna
        )
        assert budget.gain == pytest.approx(gains[k], rel=1e-9)


@pytest.mark.parametrize("seed", slow_after(10, [*ONCE_WRONG[:6], *range(SCENES), *ONCE_WRONG[6:]]))
def test_scenes_on_a_lattice_have_what_their_neighbours_have(seed):
    """Finite, reciprocal, passive, the paths of places 1e-6 m away, the same when all is turned."""
    assert faults_of_case(lattice_scene(seed)) == []
