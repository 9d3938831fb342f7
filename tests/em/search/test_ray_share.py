"""What rays say is missing, against the complete search at random receivers."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.materials import Material
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.received_power import antenna_power
from octant.em.search import rays
from octant.em.search.candidates import Candidates, SolverSettings, search_candidates
from octant.em.search.images import search_images
from octant.em.search.ray_share import RayShare, estimated_share, wall_powers
from octant.em.search.rays import ray_search
from octant.geometries.bodies import Body
from octant.geometries.errors import PhysicsWarning
from octant.geometries.furniture import box, cylinder
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

F = 2.4e9
SIZE = (5.0, 4.0, 2.5)


def furnished(rng):
    """A concrete room with cabinets, columns of many sides, and thin sheets; and a source in it."""
    things = []
    for k in range(4):
        place = (*rng.uniform((0.1, 0.1), (3.5, 2.5)), 0.0)
        if k % 2:
            radius, sides = float(rng.uniform(0.15, 0.4)), int(rng.integers(8, 40))
            place = (place[0] + 0.5, place[1] + 0.5, 0.0)
            thing = cylinder(
                radius, 1.5, material="metal", sides=sides, position_m=place, name=f"column {k}"
            )
        else:
            size = tuple(rng.uniform(0.3, 1.2, 3))
            material = str(rng.choice(["metal", "wood", "glass"]))
            turned = float(rng.uniform(0, 90))
            thing = box(size, material=material, position_m=place, yaw_deg=turned, name=f"box {k}")
        things.append(thing)
    for k in range(12):  # tiles
        corner = rng.uniform((0.3, 0.3, 0.3), (4.5, 3.5, 2.0))
        sides = rng.uniform(-0.3, 0.3, (2, 3))
        corners = corner + np.vstack((np.zeros(3), sides))
        things.append(
            Body(name=f"tile {k}", vertices_m=corners, faces=[[0, 1, 2]], material="metal")
        )
    scene = build_scene(box_room(SIZE, material="concrete"), objects=things)
    free = rng.uniform((0.2, 0.2, 1.6), (4.8, 3.8, 2.4), (50, 3))
    return scene, free[~scene.inside_solid(free)][0]


def mean_power(radio, tree, places):
    """The mean power sum over paths between isotropic antennas, nothing polarised [W]."""
    upright = make_antenna("isotropic_theta", F)
    return antenna_power(
        radio,
        Candidates(images=tree),
        places,
        transmitter=upright,
        receiver=upright,
        power_w=1.0,
    ).local_mean_w.mean()


def missing_in_fact(scene, radio, source, tree, order, rng, receivers=6000):
    """The share of the power that images lack, at random places in the air."""
    places = rng.uniform((0.01, 0.01, 0.01), np.array(SIZE) - 0.01, (receivers, 3))
    places = places[~scene.inside_solid(places)]
    complete = mean_power(radio, search_images(scene, source, order), places)
    return 1.0 - mean_power(radio, tree, places) / complete


def said_and_true(seed, receivers):
    """What is said of a few rays in a room, and the share that is missing in fact."""
    rng = np.random.default_rng(seed)
    scene, source = furnished(rng)
    radio = radio_scene(scene, F)
    few, powers = int(rng.choice([400, 1600, 6400])), wall_powers(radio)
    found = ray_search(scene, source, 2, rays=few, wall_powers=powers)
    true = missing_in_fact(scene, radio, source, found.tree, 2, rng, receivers)
    return found.tree.rays, true


def check_what_is_said(seeds, receivers):
    """Assert that the bound holds nineteen times of twenty, and that the estimate is about true."""
    said, true = zip(*(said_and_true(seed, receivers) for seed in seeds), strict=True)
    held = [share.at_most >= missing for share, missing in zip(said, true, strict=True)]
    assert sum(held) >= 0.9 * len(held)
    assert 0.8 < sum(share.missing for share in said) / sum(true) < 1.25


def test_what_is_missing_is_known_from_the_rays_alone():
    """Against fields of all paths, at receivers that the rays know nothing of."""
    check_what_is_said(range(5), 1500)


@pytest.mark.slow
def test_no_more_is_missing_than_is_said_nineteen_times_of_twenty():
    check_what_is_said(range(100, 140), 6000)


def test_rays_are_launched_until_little_enough_is_missing():
    rng = np.random.default_rng(3)
    scene, source = furnished(rng)
    radio = radio_scene(scene, F)
    solver = SolverSettings(max_reflections=2, search="rays", rays=400, ray_tolerance_db=0.03)
    tree = search_candidates(radio, source, solver).images
    assert tree.rays.suffices
    assert tree.rays.rays in {800, 1600, 3200, 6400, 12800}
    assert tree.rays.at_most_db <= 0.03
    assert missing_in_fact(scene, radio, source, tree, 2, rng, 1500) < tree.rays.at_most
    results = []
    for workers in (1, 3):
        with ThreadPoolExecutor(workers) as pool:
            results.append(search_candidates(radio, source, solver, executor=pool).images)
    assert results[0].rays == results[1].rays == tree.rays
    assert np.array_equal(results[0].image_m, results[1].image_m)


def test_too_few_rays_are_said_to_be_too_few(monkeypatch):
    monkeypatch.setattr(rays, "MOST_RAYS", 1000)
    scene, source = furnished(np.random.default_rng(3))
    solver = SolverSettings(max_reflections=2, search="rays", rays=400, ray_tolerance_db=0.001)
    with pytest.warns(PhysicsWarning, match=r"800 rays found all but .*ray_tolerance_db"):
        tree = search_candidates(radio_scene(scene, F), source, solver).images
    assert not tree.rays.suffices


def test_what_one_set_alone_has_met_is_missing_elsewhere():
    """Four sequences: two that both sets met, one of each set alone; powers add up."""
    share = estimated_share(
        np.array([3.0, 1.0, 0.5, 0.3]),
        np.array([[0, 1], [0, 1], [0, 0], [1, 1]]),
        np.array([2.0, 3.0]),
        rays=3000,
        tolerance_db=None,
    )
    assert share.missing == pytest.approx(0.5 * (0.5 / 2.0 + 0.3 / 3.0))
    spread = abs(0.25 - 0.1) / 2.0  # of a mean of two: half their difference
    assert share.at_most == pytest.approx(share.missing + 6.313752 * spread + 0.001)
    assert share.missing_db == pytest.approx(-10.0 * np.log10(1.0 - share.missing))


def test_all_may_be_missing_and_none():
    lost = RayShare(rays=8, sets=8, missing=1.0, at_most=1.0, tolerance_db=0.1)
    assert lost.at_most_db == np.inf
    assert not lost.suffices
    alone = ray_search(build_scene(()), (0.0, 0.0, 0.0), 2, rays=80).tree.rays
    assert alone.missing == 0.0


def test_walls_share_power_as_their_coefficients_do():
    """Of glass of n = 2 a ninth is reflected head on; a lossless sheet loses nothing."""
    walls = {
        "dense": Material(name="dense", eps_r_a=4.0),
        "sheet": Material(name="sheet", eps_r_a=4.0, thickness_m=0.01),
        "mirror": Material(name="mirror", is_pec=True),
        "lined": Material(
            name="lined",
            layers=(
                Material(name="lining", eps_r_a=2.0, sigma_c_s_per_m=0.5, thickness_m=0.01),
                Material(name="back", eps_r_a=9.0, thickness_m=0.01),
            ),
        ),
    }
    sheets = [
        Body(name=n, vertices_m=[(k, 0, 0), (k, 1, 0), (k, 0, 1)], faces=[[0, 1, 2]], material=n)
        for k, n in enumerate(walls)
    ]
    scene = build_scene((), objects=sheets)
    found = wall_powers(radio_scene(scene, F, walls, transmission=True))
    dense, sheet, mirror, lined = (found[scene.material_names.index(name)] for name in walls)
    assert dense[:, 0, -1] == pytest.approx(1.0 / 9.0, rel=1e-3)
    assert not dense[:, 1].any()
    assert sheet.sum(axis=1) == pytest.approx(1.0, abs=1e-12)
    assert mirror[:, 0] == pytest.approx(1.0)
    assert not mirror[:, 1].any()
    assert lined[0, 0, -1] > 1.2 * lined[1, 0, -1]  # seen from its lining, and from its back
    assert lined[0, 1] == pytest.approx(lined[1, 1], rel=1e-9)  # reciprocity
