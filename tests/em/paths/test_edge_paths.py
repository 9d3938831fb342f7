import itertools

import numpy as np
import pytest
import slow_edges
from slow_rest import slow_after

from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.records import DIFFRACTION
from octant.em.search.candidates import Candidates
from octant.em.search.edges import search_edges
from octant.em.search.images import search_images
from octant.geometries.bodies import Body
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

F = 2.4e9
ROOM = (4.0, 3.0, 2.5)


def plate(corner, u, v, name="plate"):
    a, u, v = (np.asarray(x, float) for x in (corner, u, v))
    return Body(
        name=name,
        vertices_m=np.array([a, a + u, a + u + v, a + v]),
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        material="metal",
    )


def traced(scene, source, receivers, order, diffractions=1):
    wedges = find_wedges(scene)
    tree = search_images(scene, source, order)
    edges = search_edges(scene, wedges, tree, max_diffractions=diffractions)
    return trace_paths(
        radio_scene(scene, F, wedges=wedges), Candidates(images=tree, edges=edges), receivers
    )


def over_an_end(paths, k, wedges):
    """Return whether a path meets an edge at its very end."""
    for w, place, kind in zip(
        paths.element[k], paths.vertices_m[k, 1:], paths.kind[k], strict=False
    ):
        if kind == DIFFRACTION:
            along = (place - wedges.origin_m[w]) @ wedges.axis[w]
            if not 1e-9 < along < wedges.length_m[w] - 1e-9:
                return True
    return False


def over_edges(paths, wedges, letters="D"):
    chosen = [
        k
        for k in range(len(paths))
        if paths.letters_of(k).count("D") == len(letters) and not over_an_end(paths, k, wedges)
    ]
    return sorted(
        (int(paths.order[k]), float(paths.length_m[k]), "".join(paths.letters_of(k)))
        for k in chosen
    )


def two_places(rng):
    return rng.uniform(0.15, np.array(ROOM) - 0.15, (2, 3))


@pytest.mark.parametrize("seed", slow_after(8, range(24)))
def test_paths_over_one_edge_are_those_of_a_brute_force_search(seed):
    rng = np.random.default_rng(seed)
    cabinet = box(
        size_m=(0.9, 0.5, 1.1),
        position_m=(1.9, 1.1, 0.4 if seed % 2 else 0.0),
        yaw_deg=rng.uniform(0.0, 80.0),
        material="metal",
    )
    scene = build_scene(box_room(ROOM), objects=(cabinet,))
    source, receiver = two_places(rng)
    while scene.inside_solid([source, receiver]).any():
        source, receiver = two_places(rng)
    assert_same(
        over_edges(traced(scene, source, [receiver], 2), find_wedges(scene)),
        scene,
        source,
        receiver,
        2,
    )


@pytest.mark.parametrize("seed", slow_after(4, range(12)))
def test_paths_over_the_rims_of_a_plate_are_those_of_a_brute_force_search(seed):
    rng = np.random.default_rng(seed)
    lean = rng.uniform(-0.4, 0.4)
    sheet = plate((1.5, 1.2, 0.5), (1.1, 0.2, 0.0), (0.1, lean, 1.3))
    scene = build_scene(box_room(ROOM), objects=(sheet,))
    source, receiver = two_places(rng)
    assert_same(
        over_edges(traced(scene, source, [receiver], 3), find_wedges(scene)),
        scene,
        source,
        receiver,
        3,
    )


def assert_same(ours, scene, source, receiver, order):
    theirs = slow_edges.paths(scene, source, receiver, order)
    assert len(theirs) > 0
    assert [(o, w) for o, _, w in ours] == [(o, w) for o, _, w in theirs]
    assert np.allclose([path[1] for path in ours], [path[1] for path in theirs], atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_paths_over_two_edges_are_those_of_a_brute_force_search(seed):
    rng = np.random.default_rng(seed)
    cabinet = box(
        size_m=(0.9, 0.5, 1.1),
        position_m=(1.9, 1.1, 0.4),
        yaw_deg=rng.uniform(0.0, 80.0),
        material="metal",
    )
    scene = build_scene((), objects=(cabinet,))
    source, receiver = two_places(rng)
    while scene.inside_solid([source, receiver]).any():
        source, receiver = two_places(rng)
    paths = traced(scene, source, [receiver], 2, 2)
    ours = [length for _, length, _ in over_edges(paths, find_wedges(scene), "DD")]
    theirs = slow_edges.over_two_edges(scene, source, receiver)
    assert np.allclose(ours, theirs, atol=1e-7)


def test_two_edges_are_passed_on_one_side_of_their_facet():
    """A sheet folded to a Z of 120 degrees: each fold has a wedge on either side.

    Rims of its three parts, which share no facet, are pairs too.
    """
    turn = np.radians(60.0)
    up = np.array([np.cos(turn), 0.0, np.sin(turn)])
    ends = [-up, np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]) + up]
    strips = [plate(a, b - a, (0.0, 2.0, 0.0)) for a, b in itertools.pairwise(ends)]
    body = Body(
        name="z",
        vertices_m=np.concatenate([s.vertices_m for s in strips]),
        faces=np.concatenate([s.faces + 4 * i for i, s in enumerate(strips)]),
        material="metal",
    )
    scene = build_scene((), objects=(body,))
    wedges = find_wedges(scene)
    places = [(x, 1.0, z) for x in (-1.5, 0.4, 2.5) for z in (-1.3, 1.1)]
    found = 0
    for source in places:
        paths = traced(scene, source, [place for place in places if place != source], 2, 2)
        for k in range(len(paths)):
            if paths.letters_of(k) == ("D", "D"):
                first, last = wedges.face_normals[paths.element[k, :2]]
                same = wedges.facets[paths.element[k, 0]][:, None]
                shared = same == wedges.facets[paths.element[k, 1]]
                assert ((first @ last.T > 0.0) & shared).any() or not shared.any()
                found += 1
    assert found > 0


def test_the_same_ways_lead_back():
    cabinet = box(size_m=(0.9, 0.5, 1.1), position_m=(1.9, 1.1, 0.0), material="metal")
    scene = build_scene(box_room(ROOM), objects=(cabinet,))
    a, b = (0.6, 0.7, 0.9), (3.1, 2.4, 1.7)
    there, back = traced(scene, a, [b], 3, 2), traced(scene, b, [a], 3, 2)
    assert np.allclose(np.sort(there.length_m), np.sort(back.length_m), atol=1e-12)
    words = sorted("".join(there.letters_of(k)) for k in range(len(there)))
    assert words == sorted("".join(back.letters_of(k))[::-1] for k in range(len(back)))


def test_a_source_or_receiver_on_the_extension_of_an_edge_has_finite_paths():
    cabinet = box(size_m=(1.0, 0.5, 1.0), position_m=(1.5, 1.0, 0.5), material="metal")
    scene = build_scene(box_room(ROOM), objects=(cabinet,))
    places = [(1.0, 1.0, 0.5), (1.5, 1.0, 2.0), (1.5, 0.5, 1.5), (3.0, 1.5, 1.5), (2.0, 1.0, 1.5)]
    paths = traced(scene, (0.5, 1.0, 1.5), places, 2, 2)
    assert np.isfinite(paths.vertices_m).all()


def test_two_plates_that_cross_have_no_more_edges_than_their_rims():
    first = plate((1.0, 1.0, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), "a")
    second = plate((1.5, 0.5, 0.5), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), "b")
    wedges = find_wedges(build_scene((), objects=(first, second)))
    assert len(wedges) == 8
    assert np.allclose(wedges.exterior_rad, 2.0 * np.pi)


@pytest.mark.parametrize(("floating", "count"), [(False, 8), (True, 12)])
def test_a_box_has_twelve_wedges_and_eight_on_the_floor(floating, count):
    cabinet = box(
        size_m=(0.9, 0.5, 1.1), position_m=(1.9, 1.1, 0.3 if floating else 0.0), material="metal"
    )
    scene = build_scene(box_room(ROOM), objects=(cabinet,))
    wedges = find_wedges(scene)
    middle = wedges.origin_m + 0.5 * wedges.length_m[:, None] * wedges.axis
    half = 0.5 * wedges.exterior_rad[:, None]
    air = middle + 1e-3 * (np.cos(half) * wedges.tangent + np.sin(half) * wedges.normal)
    assert scene.inside_room(air).sum() == count
    assert np.allclose(wedges.exterior_rad[scene.inside_room(air)], 1.5 * np.pi)
