from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest
from cluttered_scenes import cluttered_scene, holds_sequence
from hypothesis import assume, given
from hypothesis import strategies as st
from rooms import l_shaped_room
from slow_images import paths as slow_paths
from slow_images import sequences as slow_sequences

from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search import budget, images
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene

TX = (3.5, 2.0, 2.9)


def test_an_empty_box_has_each_image_once(box_scene):
    tree = search_images(box_scene, TX, 5)
    assert tree.kept.tolist() == [1, 6, 18, 38, 66, 102]
    assert (tree.considered == tree.pruned + tree.merged + tree.kept).all()
    assert len(np.unique(np.round(tree.image_m, 9), axis=0)) == 231


def test_images_of_a_box_lie_on_the_lattice(box_scene):
    """Images of a shoebox: 2 n L +- x along each axis, order the number of walls passed."""
    tree = search_images(box_scene, TX, 3)
    expected = set()
    for nx, ny, nz in np.ndindex(9, 9, 9):
        index = np.array([nx, ny, nz]) - 4
        if np.abs(index).sum() > 3:
            continue
        size = np.array([5.0, 5.0, 3.0])
        even = index % 2 == 0
        place = np.where(even, index * size + TX, (index + 1) * size - TX)
        expected.add(tuple(np.round(place, 9)))
    assert {tuple(p) for p in np.round(tree.image_m, 9)} == expected


def test_free_space_has_only_the_source():
    assert search_images(free_space_scene(), TX, 4).kept.tolist() == [1, 0, 0, 0, 0]


def test_a_single_sheet_reflects_on_both_sides():
    sheet = Body(
        name="sheet",
        vertices_m=[[0, -1, 0], [0, 1, 0], [0, 1, 2], [0, -1, 2]],
        faces=[[0, 1, 2], [0, 2, 3]],
        material="metal",
    )
    scene = build_scene((), objects=(sheet,))
    for x in (1.0, -1.0):
        tree = search_images(scene, (x, 0.0, 1.0), 2)
        assert tree.kept.tolist() == [1, 1, 0]
        assert tree.image_m[1] == pytest.approx((-x, 0.0, 1.0))


def _random_scene(seed):
    """A room (box, L, or none) with one to three boxes, at odd angles and places."""
    rng = np.random.default_rng(seed)
    room = (
        box_room((4.0, 3.0, 2.5)),
        l_shaped_room((4.0, 3.0, 2.5), (1.7, 1.2)),
        (),
    )[seed % 3]
    objects = [
        box(
            tuple(rng.uniform(0.3, 1.2, 3)),
            material="metal",
            position_m=tuple(rng.uniform(0.2, 1.4, 3)),
            yaw_deg=float(rng.uniform(0, 90)),
            name=f"box{k}",
        )
        for k in range(int(rng.integers(1, 3)))
    ]
    return build_scene(room, objects=objects), rng


@pytest.mark.parametrize("seed", range(12))
def test_no_path_of_the_brute_force_search_is_missed(seed):
    """Every plane sequence of two reflections without pruning finds the same paths."""
    scene, rng = _random_scene(seed)
    radio = radio_scene(scene, 2.4e9)
    source = rng.uniform((0.1, 0.1, 0.1), (2.2, 1.7, 2.4))
    tree = search_images(scene, source, 2)
    for receiver in rng.uniform((0.1, 0.1, 0.1), (2.2, 1.7, 2.4), (6, 3)):
        ours = trace_paths(radio, Candidates(images=tree), [receiver])
        expected = slow_paths(scene, source, receiver, 2)
        assert sorted(ours.order.tolist()) == [p[0] for p in expected]
        lengths = sorted(zip(ours.order.tolist(), ours.length_m.tolist(), strict=True))
        assert [x for _, x in lengths] == pytest.approx([p[1] for p in expected], abs=1e-9)


def test_no_path_is_missed_at_third_order_in_a_furnished_room():
    scene, rng = _random_scene(0)
    radio = radio_scene(scene, 2.4e9)
    source = np.array([3.1, 2.3, 1.9])
    tree = search_images(scene, source, 3)
    for receiver in rng.uniform((0.1, 0.1, 0.1), (3.9, 2.9, 2.4), (2, 3)):
        ours = trace_paths(radio, Candidates(images=tree), [receiver])
        expected = slow_paths(scene, source, receiver, 3)
        assert sorted(ours.length_m.tolist()) == pytest.approx(
            sorted(p[1] for p in expected), abs=1e-9
        )


@given(
    place=st.tuples(st.floats(0.05, 4.95), st.floats(0.05, 4.95), st.floats(0.05, 2.95)),
    source=st.tuples(st.floats(0.05, 4.95), st.floats(0.05, 4.95), st.floats(0.05, 2.95)),
)
def test_every_interior_pair_of_a_box_has_63_paths(box_scene, place, source):
    """Also where paths run exactly through edges and corners: shared hits count once."""
    assume(place != source)  # a receiver at the source is refused
    tree = search_images(box_scene, source, 3)
    paths = trace_paths(radio_scene(box_scene, 2.4e9), Candidates(images=tree), [place])
    assert len(paths) == 63


@pytest.mark.parametrize(
    ("source", "receiver"),
    [
        ((1.0, 1.0, 1.0), (1.0, 1.0, 2.0)),
        ((2.5, 2.5, 1.5), (1.25, 1.25, 0.75)),
        ((1.0, 2.0, 1.0), (2.0, 4.0, 2.0)),
        ((2.5, 2.5, 1.5), (2.5, 2.5, 0.5)),
    ],
)
def test_paths_through_edges_and_corners_count_once(box_scene, source, receiver):
    radio = radio_scene(box_scene, 2.4e9)
    for order, count in ((3, 63), (5, 231)):
        tree = search_images(box_scene, source, order)
        assert len(trace_paths(radio, Candidates(images=tree), [receiver])) == count


def test_bad_searches_are_refused(box_scene):
    with pytest.raises(GeometryError, match="negative"):
        search_images(box_scene, TX, -1)
    with pytest.raises(GeometryError, match="NaN"):
        search_images(box_scene, (np.nan, 0, 0), 1)
    tree = search_images(box_scene, TX, 1)
    with pytest.raises(GeometryError, match="outside the region"):
        trace_paths(radio_scene(box_scene, 2.4e9), Candidates(images=tree), [(6.0, 1.0, 1.0)])


@pytest.mark.parametrize("opaque", ["all", "none", "some"])
@given(seed=st.integers(0, 10_000))
def test_nothing_that_can_carry_a_path_is_pruned(opaque, seed):
    """Every sequence of the unpruned search is in the tree, whatever the walls let through."""
    rng = np.random.default_rng(seed)
    scene = cluttered_scene(rng)
    count = len(scene.facets.facet_plane)
    mask = {"all": np.ones(count), "none": np.zeros(count), "some": rng.random(count) < 0.7}
    source = rng.uniform((0.1, 0.1, 0.1), (2.2, 1.7, 2.4))
    tree = search_images(scene, source, 2, opaque_facets=mask[opaque])
    for receiver in rng.uniform((0.1, 0.1, 0.1), (2.2, 1.7, 2.4), (3, 3)):
        for planes, place, _ in slow_sequences(scene, source, receiver, 2, mask[opaque]):
            at = np.flatnonzero(np.abs(tree.image_m - place).max(axis=1) < 1e-7)
            assert any(holds_sequence(tree, image, planes) for image in at)


@pytest.mark.parametrize("seed", range(6))
def test_a_facet_lit_through_several_windows_counts_whole(seed):
    """Patches of one plane: the next facet is reached through each of them, to third order."""
    rng = np.random.default_rng(seed)
    patches = []
    for axis, level in ((2, 0.0), (2, 2.0), (0, -3.0), (0, 3.0)):
        for start in (-2.5, 0.3):
            low, high = np.full(3, level), np.full(3, level)
            across, along = (axis + 1) % 3, (axis + 2) % 3
            low[across], high[across] = start, start + rng.uniform(0.5, 2.0)
            low[along], high[along] = (-2.0, 2.0) if axis == 2 else (0.2, 1.8)
            a, c = low, high
            b, d = low.copy(), low.copy()
            b[across], d[along] = high[across], high[along]
            patches.append(
                Body(
                    name=f"patch{len(patches)}",
                    vertices_m=[a, b, c, d],
                    faces=[[0, 1, 2], [0, 2, 3]],
                    material="metal",
                )
            )
    scene = build_scene((), objects=patches)
    assert len(scene.facets.plane_normal) == 4
    assert len(scene.facets.facet_plane) == 8
    source = rng.uniform((-2.0, -1.5, 0.3), (2.0, 1.5, 1.7))
    tree = search_images(scene, source, 3)
    found = 0
    for receiver in rng.uniform((-2.5, -2.0, 0.2), (2.5, 2.0, 1.8), (20, 3)):
        for planes, place, _ in slow_sequences(scene, source, receiver, 3):
            at = np.flatnonzero(np.abs(tree.image_m - place).max(axis=1) < 1e-7)
            assert any(holds_sequence(tree, image, planes) for image in at)
            found += len(planes) == 3
    assert found > 0


def test_solids_reflect_on_their_outer_side_only_where_nothing_passes_them():
    scene = build_scene((), objects=(box((1.0, 1.0, 1.0), material="metal"),))
    assert search_images(scene, (3.0, 3.0, 3.0), 1).kept.tolist() == [1, 3]
    assert search_images(scene, (0.5, 0.4, 0.3), 1).kept.tolist() == [1, 6]
    clear = search_images(scene, (3.0, 3.0, 3.0), 1, opaque_facets=np.zeros(6))
    assert clear.kept.tolist() == [1, 6]
    assert not clear.opaque_facets.any()


def test_a_facet_hidden_by_one_opaque_facet_is_left_out():
    wide = [[1, -2, -2], [1, 2, -2], [1, 2, 2], [1, -2, 2]]
    far = [[2, -1, -1], [2, 1, -1], [2, 1, 1], [2, -1, 1]]
    sheets = [
        Body(name=name, vertices_m=corners, faces=[[0, 1, 2], [0, 2, 3]], material=name)
        for name, corners in (("front", wide), ("back", far))
    ]
    scene = build_scene((), objects=sheets)
    mask = scene.facets.facet_material == scene.material_names.index("back")
    assert search_images(scene, (0.0, 0.0, 0.0), 1).kept.tolist() == [1, 1]
    clear = search_images(scene, (0.0, 0.0, 0.0), 1, opaque_facets=mask)
    assert clear.kept.tolist() == [1, 2]
    # A corner that looks past the front sheet is enough to be kept.
    assert search_images(scene, (0.0, 1.6, 0.0), 1).kept.tolist() == [1, 1]
    assert search_images(scene, (0.0, 3.1, 0.0), 1).kept.tolist() == [1, 2]


def test_a_facet_seen_through_a_hole_is_kept():
    corners = [(1.0, y, z) for r in (2.0, 1.0) for y, z in ((-r, -r), (r, -r), (r, r), (-r, r))]
    faces = [
        t
        for k in range(4)
        for t in ((k, (k + 1) % 4, 4 + k), ((k + 1) % 4, 4 + (k + 1) % 4, 4 + k))
    ]
    frame = Body(name="frame", vertices_m=corners, faces=faces, material="metal")
    behind = [(2.0, 0.1 * y, 0.1 * z) for _, y, z in corners[:4]]
    sheet = Body(name="sheet", vertices_m=behind, faces=[[0, 1, 2], [0, 2, 3]], material="metal")
    scene = build_scene((), objects=(frame, sheet))
    assert len(scene.facets.facet_plane) == 2
    assert search_images(scene, (0.0, 0.0, 0.0), 1).kept.tolist() == [1, 2]


def test_the_images_depend_neither_on_threads_nor_on_blocks(monkeypatch):
    scene, _ = _random_scene(0)
    trees = []
    for workers, block in ((1, 64), (3, 64), (2, 7), (1, 10_000)):
        monkeypatch.setattr(images, "IMAGES_PER_BLOCK", block)
        with ThreadPoolExecutor(workers) as pool:
            trees.append(search_images(scene, (3.1, 2.3, 1.9), 4, executor=pool))
    assert trees[0].kept[-1] > 256
    for other in trees[1:]:
        for field in fields(other):
            assert np.array_equal(getattr(trees[0], field.name), getattr(other, field.name))


@pytest.mark.parametrize("short", ["bound", "memory"])
def test_an_order_that_does_not_fit_is_refused_before_it_is_expanded(monkeypatch, short):
    posts = [
        box((0.1, 0.1, 1.0), material="metal", position_m=(0.4 * i, 0.4 * j, 0.0), name=f"{i} {j}")
        for i in range(1, 9)
        for j in range(1, 6)
    ]
    scene = build_scene(box_room((4.0, 3.0, 2.5)), objects=posts)
    level = int(search_images(scene, (2.1, 1.3, 2.3), 2).kept[2])
    monkeypatch.setattr(images, "IMAGES_PER_BLOCK", 4)
    if short == "bound":
        monkeypatch.setattr(images, "MAX_IMAGES", 2 * level)
    else:
        monkeypatch.setattr(budget, "free_memory_bytes", lambda: 2e3 * level)
    done = {}
    with pytest.raises(GeometryError, match=r"images of the source at order 3, .* GB.*rays"):
        search_images(
            scene,
            (2.1, 1.3, 2.3),
            3,
            executor=ThreadPoolExecutor(1),
            progress=lambda now, whole: done.update({whole: now}),
        )
    assert 0 < done[level] < 0.5 * level
