"""What depends on the scene alone is computed once for all tags, and is gone with the scene."""

import gc

import numpy as np
from cluttered_scenes import cluttered_scene

from octant.em.search import once as kept
from octant.em.search.facets import search_facets
from octant.em.search.images import search_images
from octant.em.search.screens import find_screens
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

ANYWHERE = np.array([[-np.inf] * 3, [np.inf] * 3])


def _room():
    cabinet = box((1.0, 1.0, 1.0), material="metal", position_m=(1.0, 1.0, 0.0))
    return build_scene(box_room((4.0, 3.0, 2.5)), objects=[cabinet])


def _facets(scene, source, opaque=True):
    every = np.full(len(scene.facets.facet_plane), opaque)
    return search_facets(scene, np.array(source), scene.bounds_m, every), every


def test_tags_in_one_room_share_facets_and_screens():
    scene = _room()
    one, every = _facets(scene, (0.5, 0.5, 2.0))
    other, _ = _facets(scene, (3.5, 2.5, 1.0))
    assert other is one
    assert find_screens(scene, one, every) is find_screens(scene, other, every)
    # One inside the cabinet sees its other sides; through walls of glass all is another matter.
    within, _ = _facets(scene, (1.5, 1.5, 0.5))
    assert not np.array_equal(within.side, one.side)
    assert within.hulls_m is one.hulls_m
    clear, _ = _facets(scene, (0.5, 0.5, 2.0), opaque=False)
    assert not clear.occluder_area_m2.any()


def test_what_is_shared_changes_no_image():
    """The second tag of a room has the images that it has in a room of its own."""
    rng = np.random.default_rng(11)
    for _ in range(4):
        seed = int(rng.integers(1 << 30))
        sources = rng.uniform((0.1, 0.1, 0.1), (2.2, 1.7, 2.4), (3, 3))
        shared = cluttered_scene(np.random.default_rng(seed))
        for source in sources:
            alone = search_images(cluttered_scene(np.random.default_rng(seed)), source, 2)
            again = search_images(shared, source, 2)
            assert np.array_equal(alone.image_m, again.image_m)
            assert np.array_equal(alone.branch_plane, again.branch_plane)
            assert alone.pruned.tolist() == again.pruned.tolist()


def test_a_scene_takes_with_it_what_was_computed_of_it():
    gc.collect()
    before = len(kept._KEPT)
    scene = _room()
    _facets(scene, (0.5, 0.5, 2.0))
    assert len(kept._KEPT) == before + 1
    del scene
    gc.collect()
    assert len(kept._KEPT) == before


def test_only_so_much_is_kept_of_one_scene():
    scene = _room()
    for number in range(3 * kept.MOST_KEPT):
        assert kept.once(scene, number, lambda n=number: n) == number
    assert len(kept._KEPT[id(scene)]) == kept.MOST_KEPT
    assert kept.once(scene, 3 * kept.MOST_KEPT - 1, lambda: "anew") == 3 * kept.MOST_KEPT - 1
    assert kept.once(scene, 0, lambda: "anew") == "anew"
