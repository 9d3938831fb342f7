from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rooms import l_shaped_room

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import material
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images
from octant.geometries.bodies import Body, place
from octant.geometries.furniture import cabinet
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene

F = 2.4e9
TX = (3.5, 2.0, 2.9)


def subdivided(body, times, seed):
    """The same surface, each triangle cut at a random inner place into three, again and again."""
    rng = np.random.default_rng(seed)
    vertices, faces = [*body.vertices_m], [tuple(f) for f in body.faces]
    for _ in range(times):
        new = []
        for a, b, c in faces:
            w = rng.dirichlet((4.0, 4.0, 4.0))
            vertices.append(w @ np.array([vertices[a], vertices[b], vertices[c]]))
            m = len(vertices) - 1
            new += [(a, b, m), (b, c, m), (c, a, m)]
        faces = new
    return Body(name=body.name, vertices_m=vertices, faces=faces, material=body.material)


def gains(scene, source, receivers, order, antenna, materials=None):
    radio = radio_scene(scene, F, materials)
    tree = search_images(scene, source, order)
    paths = trace_paths(radio, Candidates(images=tree), receivers)
    return paths, path_gains(radio, paths, transmitter=antenna, receiver=antenna)


def test_lengths_in_a_box_are_the_image_distances(box_scene):
    """The closed form of the lattice of images, order by order."""
    receiver = np.array([1.3, 4.1, 0.4])
    tree = search_images(box_scene, TX, 5)
    paths = trace_paths(radio_scene(box_scene, F), Candidates(images=tree), [receiver])
    size, expected = np.array([5.0, 5.0, 3.0]), []
    for index in np.ndindex(11, 11, 11):
        n = np.array(index) - 5
        if np.abs(n).sum() <= 5:
            image = np.where(n % 2 == 0, n * size + TX, (n + 1) * size - TX)
            expected.append((np.abs(n).sum(), np.linalg.norm(image - receiver)))
    found = sorted(zip(paths.order.tolist(), paths.length_m.tolist(), strict=True))
    assert len(found) == 231
    for (n, length), (m, distance) in zip(found, sorted(expected), strict=True):
        assert n == m
        assert length == pytest.approx(distance, abs=1e-9)


@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_remeshing_changes_neither_paths_nor_powers(yaw, dipole):
    coarse = [place(b, yaw_rad=yaw) for b in box_room((5.0, 5.0, 3.0))]
    fine = [subdivided(b, 5, seed) for seed, b in enumerate(coarse)]
    assert sum(len(b.faces) for b in fine) > 2000
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    source, receivers = turn @ TX, [turn @ (1.3, 4.1, 0.4), turn @ (2.5, 0.3, 1.1)]
    a, ga = gains(build_scene(coarse), source, receivers, 3, dipole)
    b, gb = gains(build_scene(fine), source, receivers, 3, dipole)
    assert len(a) == len(b) == 126
    order_a, order_b = np.lexsort((a.length_m, a.receiver)), np.lexsort((b.length_m, b.receiver))
    assert a.length_m[order_a] == pytest.approx(b.length_m[order_b], abs=1e-9)
    for k in range(2):
        mine = np.abs(ga.gain[a.receiver == k].sum()) ** 2
        other = np.abs(gb.gain[b.receiver == k].sum()) ** 2
        assert mine == pytest.approx(other, rel=1e-9)


@given(
    a=st.tuples(st.floats(0.1, 4.9), st.floats(0.1, 2.1), st.floats(0.1, 2.9)),
    b=st.tuples(st.floats(0.1, 4.9), st.floats(2.6, 4.9), st.floats(0.1, 2.9)),
)
def test_swapping_the_ends_changes_nothing(a, b):
    """Reciprocity, with different antennas, lossy walls and a metal cabinet in the way."""
    scene = build_scene(
        box_room((5.0, 5.0, 3.0)),
        objects=(cabinet(size_m=(1.5, 0.35, 1.0), position_m=(1.75, 2.2, 0.0)),),
    )
    radio = radio_scene(scene, F)
    tilted = make_antenna("dipole", F, axis=(0.3, -0.2, 1.0))
    upright = make_antenna("monopole", F)
    total = []
    for source, receiver, sender, taker in ((a, b, tilted, upright), (b, a, upright, tilted)):
        paths = trace_paths(radio, Candidates(images=search_images(scene, source, 3)), [receiver])
        g = path_gains(radio, paths, transmitter=sender, receiver=taker)
        total.append((len(paths), g.gain.sum(), np.abs(g.gain).max(initial=0.0)))
    assert total[0][0] == total[1][0]
    assert abs(total[0][1] - total[1][1]) <= 1e-10 * total[0][2] * total[0][0]


def test_every_bounce_obeys_the_law_of_reflection(box_scene):
    tree = search_images(box_scene, TX, 4)
    paths = trace_paths(radio_scene(box_scene, F), Candidates(images=tree), [(0.9, 3.3, 0.7)])
    f = box_scene.facets
    for k in range(len(paths)):
        v = paths.vertices_of(k)
        for j in range(paths.order[k]):
            normal = f.plane_normal[f.facet_plane[paths.element[k, j]]]
            before, after = v[j + 1] - v[j], v[j + 2] - v[j + 1]
            before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
            assert after == pytest.approx(before - 2.0 * (before @ normal) * normal, abs=1e-12)


def test_a_cabinet_takes_away_exactly_the_blocked_paths(dipole):
    """Behind a metal cabinet, first order: the paths left are those of the empty room that miss it,
    and those that its own faces reflect."""
    room = box_room((5.0, 5.0, 3.0))
    low, high = np.array([1.75, 2.2, 0.0]), np.array([3.25, 2.55, 1.0])
    block = cabinet(size_m=tuple(high - low), position_m=tuple(low))
    source, receiver = np.array([2.5, 0.4, 0.5]), np.array([2.4, 4.2, 0.4])
    empty, _ = gains(build_scene(room), source, [receiver], 1, dipole)
    full, _ = gains(build_scene(room, objects=(block,)), source, [receiver], 1, dipole)

    def crosses(p, q):
        """Whether a segment enters the cabinet's box: slabs, written out."""
        t0, t1 = 0.0, 1.0
        for axis in range(3):
            d = q[axis] - p[axis]
            if d == 0.0:
                if not low[axis] < p[axis] < high[axis]:
                    return False
                continue
            near, far = sorted(((low[axis] - p[axis]) / d, (high[axis] - p[axis]) / d))
            t0, t1 = max(t0, near), min(t1, far)
        return t0 < t1

    free = [
        k
        for k in range(len(empty))
        if not any(crosses(p, q) for p, q in pairwise(empty.vertices_of(k)))
    ]
    assert len(free) < len(empty) == 7
    left = [k for k in range(len(full)) if full.order[k] == 0 or 0 <= full.element[k, 0] < 10**9]
    assert len(left) == len(full)
    missing = {round(x, 9) for x in empty.length_m[free]}
    assert missing <= {round(x, 9) for x in full.length_m}
    assert 0 not in full.order  # the line of sight is blocked
    assert {round(x, 9) for x in full.length_m} == missing


def test_two_ray_model_over_a_perfect_floor_equals_the_closed_form():
    """Vertical half-wave dipoles and isotropic antennas 1 m high, 2.45 GHz."""
    f = 2.45e9
    floor = Body(
        name="floor",
        vertices_m=[[-50, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]],
        faces=[[0, 1, 2], [0, 2, 3]],
        material="pec",
    )
    scene = build_scene((), objects=(floor,))
    radio = radio_scene(scene, f)
    tree = search_images(scene, (0.0, 0.0, 1.0), 1)
    expected = {
        "dipole": (-41.3497, -45.9953, -58.9827),
        "isotropic_theta": (-44.0018, -49.4753, -63.0810),
    }
    for kind, values in expected.items():
        antenna = make_antenna(kind, f)
        for distance, value in zip((2.0, 5.0, 10.0), values, strict=True):
            paths = trace_paths(radio, Candidates(images=tree), [(distance, 0.0, 1.0)])
            g = path_gains(radio, paths, transmitter=antenna, receiver=antenna)
            assert len(paths) == 2
            assert 20.0 * np.log10(abs(g.gain.sum())) == pytest.approx(value, abs=5e-5)


@pytest.mark.parametrize(
    ("spacing", "ahead", "at_30_deg"),
    [(0.25, 2.0, 0.99642), (0.5, 4.0, 1.82545), (0.75, 2.0, 0.23376), (1.0, 0.0, 3.33226)],
)
def test_perfect_corner_reflector_equals_its_array_factor(spacing, ahead, at_30_deg, isotropic):
    """90 degree corner, source on the bisector; far field over that of the source alone."""
    sheets = [
        Body(
            name=name,
            vertices_m=[[0, 0, -20], [*end, -20], [*end, 20], [0, 0, 20]],
            faces=[[0, 1, 2], [0, 2, 3]],
            material="pec",
        )
        for name, end in (("a", (30, 30)), ("b", (30, -30)))
    ]
    scene = build_scene((), objects=sheets)
    wavelength = isotropic.wavelength_m
    source = np.array([spacing * wavelength, 0.0, 0.0])
    far = 1e6
    for angle, value in ((0.0, ahead), (30.0, at_30_deg)):
        target = source + far * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0])
        _, g = gains(scene, source, [target], 3, isotropic)
        _, alone = gains(free_space_scene(), source, [target], 0, isotropic)
        assert abs(g.gain.sum() / alone.gain[0]) == pytest.approx(value, abs=2e-5)


def test_no_path_is_a_result(isotropic):
    """A receiver inside a closed cabinet receives nothing."""
    scene = build_scene(
        box_room((5.0, 5.0, 3.0)),
        objects=(cabinet(size_m=(1.5, 0.35, 1.0), position_m=(1.75, 2.2, 0.0)),),
    )
    paths, g = gains(scene, TX, [(2.5, 2.4, 0.5)], 3, isotropic)
    assert len(paths) == 0
    assert g.gain.sum() == 0.0


def test_slabs_and_half_spaces_reflect_differently(box_scene, isotropic):
    receiver = [(1.0, 1.0, 1.0)]
    slab = {"concrete": material({"name": "concrete", "thickness_m": 0.1})}
    _, thin = gains(box_scene, TX, receiver, 1, isotropic, slab)
    _, thick = gains(box_scene, TX, receiver, 1, isotropic)
    assert thin.gain[0] == thick.gain[0]
    assert abs(abs(thin.gain[1] / thick.gain[1]) - 1.0) > 0.01


def test_delays_and_directions_belong_to_the_vertices(box_scene, dipole):
    paths, g = gains(box_scene, TX, [(1.0, 1.5, 0.5)], 2, dipole)
    assert g.delay_s == pytest.approx(paths.length_m / 299792458.0, rel=1e-15)
    for k in range(len(paths)):
        v = paths.vertices_of(k)
        out, back = v[1] - v[0], v[-2] - v[-1]
        assert g.departure[k] == pytest.approx(out / np.linalg.norm(out), abs=1e-12)
        assert g.arrival[k] == pytest.approx(back / np.linalg.norm(back), abs=1e-12)


def test_no_path_enters_a_solid_through_its_edge(isotropic):
    """This pair has a third-order path that touches the cabinet exactly in a vertical edge."""
    scene = build_scene(
        box_room((5.0, 5.0, 3.0)),
        objects=(cabinet(size_m=(1.5, 0.35, 1.0), position_m=(1.75, 2.2, 0.0)),),
    )
    paths, _ = gains(scene, TX, [(2.0, 2.3, 0.5)], 3, isotropic)
    assert len(paths) == 0


@pytest.mark.parametrize("tilt", [0.0, 1e-10, 1e-4])
def test_normal_incidence_turns_the_horizontal_field_over(tilt):
    """Horizontal dipoles above one another over a perfect floor: direct minus mirrored wave."""
    floor = Body(
        name="floor",
        vertices_m=[[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]],
        faces=[[0, 1, 2], [0, 2, 3]],
        material="pec",
    )
    lying = make_antenna("dipole", F, axis=(1, 0, 0))
    _, g = gains(build_scene((), objects=(floor,)), (0.0, 0.0, 1.0), [(0.0, tilt, 2.0)], 1, lying)
    wavelength = lying.wavelength_m
    k = 2 * np.pi / wavelength

    def wave(distance):
        return wavelength / (4 * np.pi * distance) * np.exp(-1j * k * distance)

    expected = 1.640922376984585 * (wave(1.0) - wave(3.0))
    assert g.gain.sum() == pytest.approx(expected, rel=1e-6)


def awkward_places(count):
    """Return receivers at random, level with things, in planes of the source, under and outside."""
    rng = np.random.default_rng(3)
    places = rng.uniform((0.1, 0.1, 0.1), (4.9, 3.9, 2.9), (count, 3))
    places[::3] = np.round(places[::3] * 2.0) / 2.0 + 0.0  # on a lattice: rims, edges, walls
    places[1::7, 0] = 1.25
    places[5::11] += (6.0, 0.0, 0.0)
    return places


@pytest.mark.parametrize("source", [(1.25, 1.0, 1.5), (3.0, 2.0, 1.0)])
def test_many_receivers_have_to_the_bit_the_paths_that_each_has_by_itself(source):
    room = l_shaped_room((5.0, 4.0, 3.0), (2.0, 1.5)) if source[0] < 2.0 else box_room((5, 4, 3))
    block = cabinet((0.5, 1.0, 1.0), position_m=(2.0, 1.5, 0.0))
    high = cabinet((0.5, 0.5, 0.5), position_m=(0.5, 2.5, 1.5))
    built = build_scene(room, objects=[block, high])
    radio = radio_scene(built, F)
    everywhere = [[-np.inf] * 3, [np.inf] * 3]
    candidates = Candidates(images=search_images(built, source, 3, region_m=everywhere))
    places = awkward_places(300)
    places = places[np.linalg.norm(places - source, axis=1) > 1e-3]
    found = trace_paths(radio, candidates, places)
    assert len(found.receiver) > 1000
    for i, one in enumerate(places):
        alone = trace_paths(radio, candidates, one[None])
        mine = found.receiver == i
        assert np.array_equal(found.kind[mine][:, : alone.kind.shape[1]], alone.kind)
        assert np.array_equal(found.element[mine][:, : alone.kind.shape[1]], alone.element)
        width = alone.vertices_m.shape[1]
        assert np.array_equal(found.vertices_m[mine][:, :width], alone.vertices_m)
