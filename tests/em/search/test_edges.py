"""What images light of edges, at what cost, and what is said where the cost is too high."""

import numpy as np
import pytest
from lattice_scenes import lattice_scene

from octant.em.search import budget, edges
from octant.em.search.edges import search_edges
from octant.em.search.images import search_images
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

SOURCE = (-5.0, -5.0, 40.0)


def blocks(count, rng):
    """Count x count buildings that stand apart."""
    return [
        box(
            (*rng.uniform(8.0, 14.0, 2), rng.uniform(5.0, 30.0)),
            material="concrete",
            position_m=(20.0 * i, 20.0 * j, 0.0),
            name=f"{i} {j}",
        )
        for i, j in np.ndindex(count, count)
    ]


@pytest.mark.parametrize("seed", [0, 1, 5, 6, 7, 9])
def test_an_image_lights_what_lines_through_its_facets_reach_of_an_edge(seed):
    case = lattice_scene(seed)
    scene = build_scene(case.room, objects=case.objects)
    f, wedges = scene.facets, find_wedges(scene)
    tree = search_images(scene, case.ends[0], 2)
    found = search_edges(scene, wedges, tree)
    plain = np.flatnonzero(np.diff(found.plane_start) == 0)
    lit = {
        (int(found.leaf[n]), int(found.wedge[k])): found.reach_m[n]
        for k in plain
        for n in range(found.node_start[k], found.node_start[k + 1])
    }
    compared = 0
    for image in np.flatnonzero(tree.order == 1):
        plane = tree.branch_plane[tree.branch_start[image] : tree.branch_start[image + 1]]
        for w in range(len(wedges)):
            share = np.linspace(0.01, 0.99, 37)
            places = wedges.origin_m[w] + share[:, None] * wedges.length_m[w] * wedges.axis[w]
            offset = tree.image_m[image] - wedges.origin_m[w]
            up, across = offset @ wedges.normal[w], offset @ wedges.tangent[w]
            angle = np.arctan2(up, across) % (2.0 * np.pi)
            if np.hypot(up, across) < 1e-6:
                continue
            if wedges.exterior_rad[w] + 1e-6 < angle < 2.0 * np.pi - 1e-6:
                assert (image, w) not in lit
                continue
            reached = np.zeros(len(share), dtype=bool)
            for p in plane:
                start = tree.image_m[image] @ f.plane_normal[p] - f.plane_offset_m[p]
                height = places @ f.plane_normal[p] - f.plane_offset_m[p]
                t = start / np.where(start == height, np.inf, start - height)
                hit = tree.image_m[image] + t[:, None] * (places - tree.image_m[image])
                uv = hit @ np.array([f.plane_u[p], f.plane_v[p]]).T
                for facet in range(f.plane_facet_start[p], f.plane_facet_start[p + 1]):
                    low, high = f.facet_bounds_m[facet].reshape(2, 2)
                    within = ((uv > low + 1e-6) & (uv < high - 1e-6)).all(axis=1)
                    reached |= within & (t > 0.0) & (t < 1.0 - 1e-9)
            if reached.any():
                at = share[reached] * wedges.length_m[w]
                low, high = lit[image, w]
                assert low <= at.min() + 1e-9
                assert high >= at.max() - 1e-9
                compared += 1
    assert compared > 0


def test_most_edges_of_a_city_are_lit_by_few_images():
    """A source above a block's corner lights the nine edges that its two near sides have."""
    scene = build_scene((), objects=blocks(10, np.random.default_rng(0)))
    wedges = find_wedges(scene)
    tree = search_images(scene, SOURCE, 1)
    assert len(wedges) == 12 * 100
    assert len(search_edges(scene, wedges, tree).leaf) == 9 * 100


@pytest.mark.slow
def test_forty_thousand_edges_diffract():
    scene = build_scene((), objects=blocks(60, np.random.default_rng(0)))
    wedges = find_wedges(scene)
    assert len(wedges) == 12 * 3600
    tree = search_images(scene, SOURCE, 1)
    assert len(search_edges(scene, wedges, tree).leaf) == 9 * 3600


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("short", ["bound", "memory"])
def test_what_does_not_fit_is_refused_with_edges_images_and_bytes(monkeypatch, short, order):
    scene = build_scene((), objects=blocks(3, np.random.default_rng(0)))
    tree = search_images(scene, SOURCE, order)
    if short == "bound":
        monkeypatch.setattr(edges, "MAX_NODES", 80 if order == 1 else 500)
    else:
        monkeypatch.setattr(budget, "free_memory_bytes", lambda: 10_000.0)
    with pytest.raises(GeometryError, match=r"over 108 edges with \d+ images .* GB; at most"):
        search_edges(scene, find_wedges(scene), tree)


def test_a_fan_of_sheets_pairs_the_edges_of_one_side_of_one_facet_alone():
    """Four rims of a sheet: every ordered pair of them, but none with another sheet's."""
    sheets = [
        Body(
            name=str(x),
            vertices_m=[(x, 0, 0), (x, 1, 0), (x, 1, 2), (x, 0, 2)],
            faces=[[0, 1, 2], [0, 2, 3]],
            material="metal",
        )
        for x in range(3)
    ]
    scene = build_scene((), objects=sheets)
    wedges = find_wedges(scene)
    tree = search_images(scene, (-1.0, 0.4, 1.1), 1)
    found = search_edges(scene, wedges, tree, max_diffractions=2)
    last = np.repeat(found.wedge, np.diff(found.node_start))
    double = found.first >= 0
    pairs = list(zip(found.first[double].tolist(), last[double].tolist(), strict=True))
    sheet = (wedges.origin_m[:, 0] + 0.5).astype(int)
    wanted = [(i, j) for i in range(12) for j in range(12) if i != j and sheet[i] == sheet[j]]
    assert sorted(pairs) == wanted
