"""Images found by launched rays, against the complete search."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace

import numpy as np
import pytest

from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import Candidates, SolverSettings, search_candidates
from octant.em.search.images import search_images
from octant.em.search.rays import launch_directions, ray_search
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import cabinet, cylinder
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene

TX = (3.5, 2.0, 2.9)


@pytest.fixture(scope="module")
def furnished():
    objects = (
        cabinet(position_m=(1.75, 2.2, 0.0)),
        cylinder(0.4, 1.5, material="metal", sides=40, position_m=(3.8, 3.9, 0.0)),
    )
    return build_scene(box_room((5.0, 5.0, 3.0)), objects=objects)


def sequences(tree):
    """Every sequence of planes of a tree."""
    of_image = [{()}]
    for image in range(1, len(tree.image_m)):
        branches = range(tree.branch_start[image], tree.branch_start[image + 1])
        of_image.append(
            {
                (*before, int(tree.branch_plane[b]))
                for b in branches
                for before in of_image[tree.branch_parent[b]]
                if not before or before[-1] != tree.branch_plane[b]
            }
        )
    return set().union(*of_image)


def test_directions_cover_the_sphere_evenly():
    d = launch_directions(0, 5000, 5000)
    assert np.linalg.norm(d, axis=1) == pytest.approx(1.0, abs=1e-12)
    assert np.abs(d.mean(axis=0)).max() < 1e-3
    assert d.T @ d / 5000 == pytest.approx(np.eye(3) / 3.0, abs=1e-3)
    assert np.array_equal(launch_directions(700, 900, 5000), d[700:900])
    nearest = np.sort(d @ d.T, axis=1)[:, -2]
    assert np.arccos(nearest).min() > 0.8 * np.sqrt(4.0 * np.pi / 5000)


def test_rays_find_every_image_of_an_empty_box(box_scene):
    found = ray_search(box_scene, TX, 3, rays=20_000)
    complete = search_images(box_scene, TX, 3)
    assert found.tree.kept.tolist() == [1, 6, 18, 38]
    assert np.array_equal(
        np.unique(np.round(found.tree.image_m, 9), axis=0),
        np.unique(np.round(complete.image_m, 9), axis=0),
    )
    paths = trace_paths(
        radio_scene(box_scene, 2.4e9), Candidates(images=found.tree), [(1.2, 3.4, 0.3)]
    )
    assert len(paths) == 63


def test_what_rays_find_is_part_of_the_complete_search(furnished):
    complete = sequences(search_images(furnished, TX, 3))
    found = ray_search(furnished, TX, 3, rays=20_000)
    mine = sequences(found.tree)
    assert mine <= complete
    assert len(mine) > 200
    assert found.tree.considered.sum() == found.found.sum()


def test_more_rays_miss_fewer_paths_and_none_in_the_end(furnished):
    radio = radio_scene(furnished, 2.4e9)
    receivers = np.random.default_rng(4).uniform((0.1, 0.1, 0.1), (4.9, 2.1, 2.9), (40, 3))
    full = len(trace_paths(radio, Candidates(images=search_images(furnished, TX, 2)), receivers))
    counts = [
        len(
            trace_paths(
                radio, Candidates(images=ray_search(furnished, TX, 2, rays=n).tree), receivers
            )
        )
        for n in (300, 3_000, 300_000)
    ]
    assert counts[0] < counts[1] < counts[2] == full


def test_density_counts_the_rays_in_a_solid_angle(furnished):
    found = ray_search(furnished, TX, 1, rays=40_000)
    assert found.rays_per_sr == pytest.approx(40_000 / (4 * np.pi))


def test_rays_pass_what_is_not_opaque_and_are_reflected_by_it():
    corners = [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]]
    sheets = [
        Body(
            name=n,
            vertices_m=np.array(corners) * (k, 1, 1),
            faces=[[0, 1, 2], [0, 2, 3]],
            material=n,
        )
        for k, n in enumerate(("front", "back"), start=1)
    ]
    scene = build_scene((), objects=sheets)
    front = scene.facets.facet_material == scene.material_names.index("front")
    shut = ray_search(scene, (0.9, 0.1, 0.2), 2, rays=300)
    assert shut.tree.kept.tolist() == [1, 1, 0]
    clear = ray_search(scene, (0.9, 0.1, 0.2), 2, rays=300, opaque_facets=~front)
    assert clear.tree.kept.tolist() == [1, 2, 1]
    assert np.array_equal(clear.tree.opaque_facets, ~front)


def test_the_images_do_not_depend_on_the_number_of_threads(furnished):
    results = []
    for workers in (1, 3):
        with ThreadPoolExecutor(workers) as pool:
            results.append(ray_search(furnished, TX, 3, rays=100_000, executor=pool))
    for field in fields(results[0].tree):
        mine, other = (getattr(r.tree, field.name) for r in results)
        assert np.array_equal(mine, other)


def test_the_caller_chooses_the_search(furnished):
    steps = []
    radio, solver = radio_scene(furnished, 2.4e9), SolverSettings(max_reflections=1, rays=500)
    complete = search_candidates(radio, TX, solver).images
    solver = replace(solver, search="rays")
    rays = search_candidates(radio, TX, solver, progress=lambda *t: steps.append(t)).images
    assert complete.kept[1] >= rays.kept[1] > 0
    assert steps[-1] == (496, 496)
    with pytest.raises(GeometryError, match="'luck' is unknown"):
        search_candidates(radio, TX, replace(solver, search="luck"))


def test_little_is_no_error():
    assert ray_search(free_space_scene(), TX, 3, rays=10).found.tolist() == [1, 0, 0, 0]
    none = ray_search(free_space_scene(), TX, 0, rays=10)
    assert none.tree.kept.tolist() == none.found.tolist() == [1]
    assert none.tree.rays.missing == 0.0
    with pytest.raises(GeometryError, match="too few"):
        ray_search(free_space_scene(), TX, 1, rays=7)
    with pytest.raises(GeometryError, match="negative"):
        ray_search(free_space_scene(), TX, -1)
