"""Receivers that are decided on together, by the corners of their box, and each by itself."""

import os

import numpy as np
import pytest
from lattice_scenes import MATERIALS, lattice_scene
from rooms import l_shaped_room

from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images
from octant.geometries.bodies import Body
from octant.geometries.furniture import cabinet
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

SCENES = int(os.environ.get("OCTANT_LATTICE_SCENES", "12"))
F = 2.4e9
APART = 7  # so few receivers are searched for one by one
EVERYWHERE = [[-np.inf] * 3, [np.inf] * 3]


def rows(found):
    """Yield receiver, elements and vertices of each path, as bytes."""
    for k in range(len(found)):
        n = int(found.interactions[k])
        vertices = found.vertices_m[k, : n + 2]
        yield int(found.receiver[k]), found.element[k, :n].tobytes(), vertices.tobytes()


def differences(built, source, order, places):
    """Return the paths that receivers have only together, or only by themselves, and how many."""
    radio = radio_scene(built, F, MATERIALS)
    candidates = Candidates(images=search_images(built, source, order, region_m=EVERYWHERE))
    together = list(rows(trace_paths(radio, candidates, places)))
    alone = [
        (first + receiver, *rest)
        for first in range(0, len(places), APART)
        for receiver, *rest in rows(trace_paths(radio, candidates, places[first : first + APART]))
    ]
    return set(together) ^ set(alone), together == alone, len(alone)


def patch(centre, side, count, *, flat):
    """Return a square or cube of receivers about a place, the place itself among them."""
    steps = side * (np.arange(count) - count // 2) / count
    axes = np.meshgrid(steps, steps, [0.0] if flat else steps, indexing="ij")
    return np.asarray(centre) + np.column_stack([axis.ravel() for axis in axes])


def free(built, source, places):
    away = np.linalg.norm(places - source, axis=1) > 1e-3
    return places[away & ~built.inside_solid(places)]


@pytest.mark.parametrize("seed", range(SCENES))
def test_boxes_about_lattice_places_have_the_paths_of_each_receiver(seed):
    case = lattice_scene(seed)
    built = build_scene(case.room, objects=case.objects)
    source, centre = case.ends
    side = (2e-6, 1e-3, 0.1, 0.6)[seed % 4]
    places = free(built, source, patch(centre, side, 5 if seed % 3 else 12, flat=seed % 3 == 0))
    if len(places) > APART:
        order = min(case.solver.max_reflections, 2 if seed % 5 else 3)
        assert differences(built, source, order, places)[:2] == (set(), True)


def tilted_plate():
    """A pentagon with a notch, oblique to all axes."""
    u, v = np.array([0.8, 0.36, -0.48]), np.array([0.0, 0.8, 0.6])
    at = np.array([(0.0, 0.0), (1.5, 0.0), (0.8, 0.6), (1.5, 1.2), (0.0, 1.2)])
    corners = np.array([1.0, 1.2, 1.1]) + at[:, :1] * u + at[:, 1:] * v
    return Body(
        name="plate", vertices_m=corners, faces=[[0, 1, 2], [0, 2, 4], [2, 3, 4]], material="metal"
    )


@pytest.mark.parametrize("side", [0.05, 0.3, 1.2])
@pytest.mark.parametrize("room", ["box", "l-shaped", "none"])
def test_boxes_about_random_places_have_the_paths_of_each_receiver(room, side):
    walls = {
        "box": box_room((5.0, 4.0, 3.0)),
        "l-shaped": l_shaped_room((5.0, 4.0, 3.0), (2.0, 1.5)),
        "none": (),
    }[room]
    block = cabinet((0.5, 1.0, 1.0), position_m=(2.4, 2.4, 0.0))
    built = build_scene(walls, objects=[block, tilted_plate()])
    rng = np.random.default_rng(5)
    source = np.array([0.7, 0.9, 2.1])
    paths = 0
    for centre in rng.uniform((0.7, 0.7, 0.7), (2.3, 3.3, 2.3), (4, 3)):
        places = free(built, source, patch(centre, side, 11, flat=True))
        different, ordered, count = differences(built, source, 3, places)
        assert (different, ordered) == (set(), True)
        paths += count
    assert paths > 500
