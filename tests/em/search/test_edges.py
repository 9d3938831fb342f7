"""What images light of edges, at what cost, and what is said where the cost is too high."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace

import numpy as np
import pytest
from lattice_scenes import lattice_scene

from octant.em.search import budget, edges
from octant.em.search.edges import search_edges
from octant.em.search.images import search_images
from octant.geometries._bvh_kernels import two_planes
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box
from octant.geometries.occlusion import segments_blocked
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


def test_a_fan_of_sheets_pairs_the_edges_in_sight_of_each_other():
    """Four rims of a sheet: every ordered pair, and all with the next sheet's, none past it."""
    sheets = [
        Body(
            name=str(x),
            vertices_m=[(x, 0, 0), (x, 1, 0), (x, 1, 2), (x, 0, 2)],
            faces=[[0, 1, 2], [0, 2, 3]],
            material="metal",
        )
        for x in range(3)
    ]
    wider = np.array([(1.0, 1.0, 1.0), (1.0, 3.0, 2.0), (1.0, 1.0, 1.0)])
    middle = np.array([(0.0, 0.5, 1.0)])
    sheets = [
        replace(s, vertices_m=(s.vertices_m - middle) * wider[x] + middle)
        for x, s in enumerate(sheets)
    ]
    scene = build_scene((), objects=sheets)
    wedges = find_wedges(scene)
    tree = search_images(scene, (-1.0, 0.4, 1.1), 1)
    found = search_edges(scene, wedges, tree, max_diffractions=2)
    last = np.repeat(found.wedge, np.diff(found.node_start))
    double = found.first >= 0
    pairs = list(zip(found.first[double].tolist(), last[double].tolist(), strict=True))
    sheet = (wedges.origin_m[:, 0] + 0.5).astype(int)
    near = [(i, j) for i in range(12) for j in range(12) if i != j and abs(sheet[i] - sheet[j]) < 2]
    assert sorted(pairs) == near


def random_sheet(rng, name):
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]) * rng.uniform(1.0, 3.0)
    return Body(
        name=str(name),
        vertices_m=corners @ turn.T + rng.uniform(0.0, 3.0, 3),
        faces=[[0, 1, 2], [0, 2, 3]],
        material="metal",
    )


def test_pairs_in_sight_depend_neither_on_threads_nor_on_blocks(monkeypatch):
    rng = np.random.default_rng(2)
    scene = build_scene((), objects=[random_sheet(rng, name) for name in range(7)])
    wedges, tree = find_wedges(scene), search_images(scene, (-1.0, 0.4, 9.0), 2)
    found = []
    for block, threads in ((64, 1), (3, 3)):
        monkeypatch.setattr(edges, "IMAGES_PER_BLOCK", block)
        with ThreadPoolExecutor(threads) as executor:
            found.append(search_edges(scene, wedges, tree, max_diffractions=2, executor=executor))
    assert (found[0].first >= 0).sum() > 300
    for field in fields(found[0]):
        assert np.array_equal(*(getattr(one, field.name) for one in found))


def in_air(wedges, w, directions):
    """Whether directions (n, k, 3) away from edges point into their wedges' air, faces left out."""
    x = np.einsum("nkc,nc->nk", directions, wedges.tangent[w])
    y = np.einsum("nkc,nc->nk", directions, wedges.normal[w])
    angle = np.arctan2(y, x) % (2.0 * np.pi)
    return (angle > 1e-6) & (angle < wedges.exterior_rad[w, None] - 1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_edges_are_pairs_where_any_place_of_one_sees_any_of_the_other(seed):
    """Nothing that sees the other is lost; what one facet or their own solids hide is left out."""
    rng = np.random.default_rng(seed)
    bodies = [random_sheet(rng, name) for name in range(5)]
    bodies += [
        box((2.0, 1.0, 1.0), material="metal", name="a"),
        box((0.5, 1.0, 0.7), material="metal", name="b", position_m=(3.2, 0.2, 0.0), yaw_deg=20.0),
    ]
    scene = build_scene((), objects=bodies)
    wedges = find_wedges(scene)
    tree = search_images(scene, (-1.0, 0.4, 9.0), 1)
    found = search_edges(scene, wedges, tree, max_diffractions=2)
    last = np.repeat(found.wedge, np.diff(found.node_start))
    pairs = set(zip(found.first.tolist(), last.tolist(), strict=True))
    planes = two_planes(*scene.facets.facet_plane[wedges.facets].T)
    dark = np.isin(np.arange(len(wedges)), last[found.first < 0], invert=True)
    blind, unseen = 0, 0
    for one in np.flatnonzero(~dark):
        shared = (wedges.facets[:, :, None] == wedges.facets[one]).any(axis=(1, 2))
        others = np.flatnonzero(~shared & ~dark)
        share = rng.uniform(0.0, 1.0, (2, len(others), 300, 1))
        here, there = (
            wedges.origin_m[w, None] + t * (wedges.length_m[w, None] * wedges.axis[w])[:, None]
            for w, t in ((np.full(len(others), one), share[0]), (others, share[1]))
        )
        blocked = segments_blocked(
            scene.bvh,
            here.reshape(-1, 3),
            there.reshape(-1, 3),
            start_planes=planes[one],
            end_planes=np.repeat(planes[others], 300),
        ).reshape(-1, 300)
        sees = in_air(wedges, np.full(len(others), one), there - here) & ~blocked
        sees &= in_air(wedges, others, here - there)
        for other, seen in zip(others.tolist(), sees.any(axis=1), strict=True):
            pair = (int(one), other) in pairs
            assert pair or not seen
            blind, unseen = blind + (pair and not seen), unseen + (not seen)
    assert blind < 0.5 * unseen
