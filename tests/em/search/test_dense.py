"""The image search of dense scenes: what screens hide together, and that nothing else is lost."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from cluttered_scenes import cluttered_scene, holds_sequence
from scipy.spatial import cKDTree
from slow_images import sequences as slow_sequences

from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search import images
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images
from octant.em.search.rays import ray_search
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.scene import build_scene

BUILDINGS = Path(__file__).resolve().parents[3] / "benchmarks" / "buildings.py"


@pytest.fixture
def dense(monkeypatch):
    """Every scene counts as dense."""
    monkeypatch.setattr(images, "DENSE_FACETS", -1)


def _sheet(name, y, z, x=1.0, material="metal"):
    """Return a rectangle across the x axis."""
    corners = [(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])]
    return Body(name=name, vertices_m=corners, faces=[[0, 1, 2], [0, 2, 3]], material=material)


def _kept(*sheets):
    return search_images(build_scene((), objects=sheets), (0.0, 0.0, 0.0), 1).kept[1]


@pytest.mark.usefixtures("dense")
@pytest.mark.parametrize("seed", range(24))
def test_nothing_that_can_carry_a_path_is_pruned(seed):
    """Every sequence of the unpruned search is in the tree, whatever the walls let through."""
    rng = np.random.default_rng(seed)
    scene = cluttered_scene(rng)
    count = len(scene.facets.facet_plane)
    mask = (np.ones(count), rng.random(count) < 0.7, np.zeros(count))[seed % 3]
    source = rng.uniform((0.1, 0.1, 0.1), (2.2, 1.7, 2.4))
    tree = search_images(scene, source, 2, opaque_facets=mask)
    for receiver in rng.uniform((0.1, 0.1, 0.1), (2.2, 1.7, 2.4), (2, 3)):
        for planes, place, _ in slow_sequences(scene, source, receiver, 2, mask):
            at = np.flatnonzero(np.abs(tree.image_m - place).max(axis=1) < 1e-7)
            assert any(holds_sequence(tree, image, planes) for image in at)


@pytest.mark.usefixtures("dense")
def test_two_sheets_that_meet_hide_what_neither_hides_alone():
    behind = _sheet("behind", (-1, 1), (-0.5, 0.5), x=2.0, material="wood")
    left, right = _sheet("left", (-2, 0.2), (-2, 2)), _sheet("right", (0.2, 2), (-2, 2))
    plain = _sheet("wood", (0.2, 2), (-2, 2), material="wood")
    assert _kept(left, behind) == 2
    assert _kept(right, behind) == 2
    assert _kept(left, right, behind) == 1
    assert _kept(left, plain, behind) == 1
    # A slit of 1 mm shows it, and so does a gap at a rim.
    assert _kept(left, _sheet("right", (0.201, 2), (-2, 2)), behind) == 2
    assert _kept(left, _sheet("right", (0.2, 2), (-2, 0.2)), behind) == 2


@pytest.mark.usefixtures("dense")
def test_a_fold_hides_as_far_as_it_reaches():
    """Two faces that meet in an edge, towards the source and away from it."""
    behind = _sheet("behind", (-0.5, 0.5), (-0.5, 0.5), x=3.0)
    for tip in (0.5, 1.5):
        corners = [(1, -1, -1), (tip, 0, -1), (1, 1, -1), (1, -1, 1), (tip, 0, 1), (1, 1, 1)]
        faces = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]
        fold = Body(name="fold", vertices_m=corners, faces=faces, material="metal")
        assert _kept(fold, behind) == 2
        # Seen from aside only one face is before it, and it looks past the edge.
        scene = build_scene((), objects=(fold, behind))
        assert search_images(scene, (0.0, 4.0, 0.0), 1).kept[1] >= 2


@pytest.mark.usefixtures("dense")
def test_a_wall_with_a_door_hides_all_but_what_is_seen_through_it():
    outline = [(0, -3), (0, -0.4), (2, -0.4), (2, 0.4), (0, 0.4), (0, 3), (3, 3), (3, -3)]
    corners = [(1.0, y, z - 1.0) for z, y in outline]
    faces = [[0, 1, 2], [0, 2, 7], [2, 3, 6], [2, 6, 7], [3, 4, 5], [3, 5, 6]]
    wall = Body(name="wall", vertices_m=corners, faces=faces, material="metal")
    for y, seen in ((0.0, 2), (0.7, 2), (1.5, 1), (-1.5, 1)):
        assert _kept(wall, _sheet("behind", (y - 0.2, y + 0.2), (-0.5, 0.5), x=2.0)) == seen


@pytest.fixture(scope="module")
def building():
    spec = importlib.util.spec_from_file_location("buildings", BUILDINGS)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    scene = module.building(4_400)
    return scene, module.building_places(scene, 1)[0]


@pytest.mark.usefixtures("dense")
def test_all_that_rays_find_in_a_building_is_kept_and_little_else(building):
    scene, source = building
    tree = search_images(scene, source, 2)
    found = ray_search(scene, source, 2, rays=400_000).tree
    for order in (1, 2):
        kept, met = (t.image_m[t.order == order] for t in (tree, found))
        apart, _ = cKDTree(kept).query(met)
        assert apart.max() < 1e-7
        assert len(kept) < 8 * len(met)


def test_the_cells_of_a_beam_prune_what_single_facets_leave(building, monkeypatch):
    scene, source = building
    plain = search_images(scene, source, 2).kept
    monkeypatch.setattr(images, "DENSE_FACETS", -1)
    kept = search_images(scene, source, 2).kept
    assert kept[1] <= plain[1]
    assert kept[2] < 0.7 * plain[2]


@pytest.mark.usefixtures("dense")
def test_images_that_reach_no_receiver_are_left_out_and_no_path_with_them(building):
    scene, source = building
    radio = radio_scene(scene, 2.4e9)
    receivers = source + np.random.default_rng(3).uniform(-2.0, 2.0, (40, 3)) * (1, 1, 0.1)
    receivers = np.clip(receivers, scene.bounds_m[0] + 0.05, scene.bounds_m[1] - 0.05)
    whole = search_images(scene, source, 2)
    tree = search_images(scene, source, 2, receivers_m=receivers)
    assert tree.kept[2] < 0.5 * whole.kept[2]
    ours, expected = (trace_paths(radio, Candidates(images=t), receivers) for t in (tree, whole))
    assert len(expected) > 400
    ours, expected = (p.vertices_m[np.lexsort((p.length_m, p.receiver))] for p in (ours, expected))
    assert ours == pytest.approx(expected, abs=1e-12)
    with pytest.raises(GeometryError, match="none of the 40"):
        trace_paths(radio, Candidates(images=tree), receivers + 0.01)


@pytest.mark.usefixtures("dense")
def test_what_stands_behind_a_mirror_hides_nothing_before_it():
    mirror, back = (_sheet(name, (-3, 3), (-3, 3), x=x) for name, x in (("m", 1.0), ("b", 1.4)))
    scene = build_scene((), objects=(mirror, back, _sheet("far", (-1, 1), (-1, 1), x=-1.0)))
    assert search_images(scene, (0.0, 0.0, 0.0), 2).kept.tolist() == [1, 2, 2]
