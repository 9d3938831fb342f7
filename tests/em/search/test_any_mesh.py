"""Whatever the mesh and wherever the antennas: right, or one sentence, and never NaN.

Scenes are drawn from seeds (see tests/support/broken_meshes.py), with reflections, transmission and
diffraction over one and two edges. One seed is one room with its objects and one pair of antennas.
"""

import warnings
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from broken_meshes import badly_meshed, draw_place, draw_scene, rounded
from slow_rest import slow_after

from octant.em.antennas.kinds import make_antenna
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import material
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.power.received_power import antenna_power
from octant.em.records import DIFFRACTION, PathSet
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError, OctantError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

FREQUENCY_HZ = 2.4e9
PANE = {"pane": material({"name": "glass", "thickness_m": 0.01})}
PER_BATCH = 100
EVERYWHERE_M = [[-1e6] * 3, [1e6] * 3]
NOT_TURNED = np.eye(3)
EDGE_BOUND = 4.0
"""Gain over an edge [-] per gain of free space over the same length: one boundary makes it 1/2."""


class Model(NamedTuple):
    """What is switched on."""

    reflections: int
    diffractions: int
    transmission: bool
    frequency_hz: float = FREQUENCY_HZ


class Answer(NamedTuple):
    """Paths from one place to another, their gains and the received power [W per W]."""

    paths: PathSet
    gain: np.ndarray
    directions: np.ndarray
    coherent_w: float
    mean_w: float


def answer(scene, model, source_m, receiver_m, antenna="isotropic_theta"):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wedges = find_wedges(scene) if model.diffractions else None
        radio = radio_scene(
            scene, model.frequency_hz, PANE, transmission=model.transmission, wedges=wedges
        )
        found = search_candidates(
            radio,
            source_m,
            SolverSettings(
                max_reflections=model.reflections,
                diffraction=True,
                max_diffractions=max(model.diffractions, 1),
            ),
            region_m=EVERYWHERE_M,
        )
        paths = trace_paths(radio, found, [receiver_m])
        ends = dict.fromkeys(("transmitter", "receiver"), make_antenna(antenna, model.frequency_hz))
        gains = path_gains(radio, paths, **ends)
        power = antenna_power(radio, found, [receiver_m], power_w=1.0, **ends)
    return Answer(
        paths=paths,
        gain=gains.gain,
        directions=np.stack((gains.departure, gains.arrival)),
        coherent_w=float(power.coherent_w[0]),
        mean_w=float(power.local_mean_w[0]),
    )


def draw(seed):
    rng = np.random.default_rng(seed)
    room, objects = draw_scene(rng)
    model = Model(int(rng.integers(3)), int(rng.integers(3)), bool(rng.integers(2)))
    places = [draw_place(rng, room + objects) for _ in range(2)]
    return rng, room, objects, model, places


def free_space_gain(paths, frequency_hz=FREQUENCY_HZ):
    return SPEED_OF_LIGHT_M_PER_S / frequency_hz / (4.0 * np.pi * paths.length_m)


def assert_sound(found):
    """Finite everywhere, and no path stronger than free space but over edges, by their bound."""
    paths = found.paths
    numbers = (paths.vertices_m, found.gain, found.directions, found.coherent_w, found.mean_w)
    assert all(np.isfinite(value).all() for value in numbers)
    assert np.allclose(np.linalg.norm(found.directions, axis=2), 1.0, atol=1e-12)
    over_edges = (paths.kind == DIFFRACTION).any(axis=1)
    bound = np.where(over_edges, EDGE_BOUND, 1.0 + 1e-9)
    assert (np.abs(found.gain) <= bound * free_space_gain(paths)).all()


def assert_same(one, other, rtol):
    """The same lengths, and the same powers but for paths that bring nothing."""
    lengths = np.sort(one.paths.length_m), np.sort(other.paths.length_m)
    assert len(lengths[0]) == len(lengths[1])
    assert np.allclose(*lengths, rtol=0.0, atol=1e-6)
    assert np.isclose(one.coherent_w, other.coherent_w, rtol=rtol, atol=1e-16)
    assert np.isclose(one.mean_w, other.mean_w, rtol=rtol, atol=1e-16)


def assert_one_sentence(error):
    text = str(error)
    assert text.endswith(".")
    assert "\n" not in text
    assert "nan" not in text.lower()


@pytest.mark.parametrize("batch", slow_after(2, range(8)))
def test_no_path_is_nan_or_stronger_than_physics_allows_and_ends_may_be_swapped(batch):
    answered = 0
    for seed in range(batch * PER_BATCH, (batch + 1) * PER_BATCH):
        _, room, objects, model, (source, receiver) = draw(seed)
        scene = build_scene(room, objects=objects)
        try:
            there = answer(scene, model, source, receiver)
            assert_sound(there)
            answered += 1
            back = answer(scene, model, receiver, source)
        except OctantError as error:  # an antenna on a surface may receive, but not send
            assert_one_sentence(error)
            continue
        except AssertionError as error:
            raise AssertionError(f"seed {seed}") from error
        assert_sound(back)
        assert_same(there, back, 1e-9)
    assert answered > PER_BATCH // 3


@pytest.mark.parametrize("batch", slow_after(2, range(8)))
def test_a_bad_mesh_of_the_same_surfaces_gives_the_same_paths_and_powers(batch):
    for seed in range(10_000 + batch * PER_BATCH, 10_000 + (batch + 1) * PER_BATCH):
        rng, room, objects, model, (source, receiver) = draw(seed)
        scene = build_scene(room, objects=objects)
        twin = build_scene(badly_meshed(rng, room), objects=badly_meshed(rng, objects))
        try:
            clean = answer(scene, model, source, receiver)
        except OctantError:
            with pytest.raises(OctantError):
                answer(twin, model, source, receiver)
            continue
        other = answer(twin, model, source, receiver)
        try:
            assert_sound(other)
            # Exactly on a sheet or an edge rounding decides on which side a receiver is.
            if not scene.stand_off([receiver], 0.01)[1].any():
                assert_same(clean, other, 1e-6)
        except AssertionError as error:
            raise AssertionError(f"seed {seed}") from error


def moved(bodies, scale=1.0, turn=NOT_TURNED, shift_m=(0.0, 0.0, 0.0)):
    return tuple(
        replace(body, vertices_m=scale * body.vertices_m @ turn.T + shift_m) for body in bodies
    )


def turn_about_z(angle_rad):
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def generic_places(rng):
    return rng.uniform(np.full(3, 0.1), (3.9, 2.9, 2.4), (2, 3))


def conducting(bodies):
    return tuple(replace(body, material="pec") for body in bodies)


def test_rounding_to_float32_changes_no_path():
    for seed in range(20_000, 20_060):
        rng, room, objects, model, _ = draw(seed)
        turn = turn_about_z(0.3)
        exact, stored = (
            [
                tuple(change(rng, body) for body in moved(part, turn=turn))
                for part in (room, objects)
            ]
            for change in (lambda _, body: body, rounded)
        )
        source, receiver = generic_places(rng) @ turn.T
        one, other = (
            answer(build_scene(part[0], objects=part[1]), model, source, receiver)
            for part in (exact, stored)
        )
        assert len(one.gain) == len(other.gain), seed
        lengths = (np.sort(found.paths.length_m) for found in (one, other))
        assert np.allclose(*lengths, rtol=0.0, atol=2e-5), seed
        assert np.isclose(one.mean_w, other.mean_w, rtol=0.02, atol=1e-16), seed


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_power_depends_on_sizes_in_wavelengths_only(scale):
    for seed in range(30_000, 30_030):
        rng, room, objects, model, _ = draw(seed)
        room, objects = conducting(room), conducting(objects)
        source, receiver = generic_places(rng)
        one = answer(build_scene(room, objects=objects), model, source, receiver)
        scaled = build_scene(moved(room, scale), objects=moved(objects, scale))
        other_model = model._replace(frequency_hz=FREQUENCY_HZ / scale)
        other = answer(scaled, other_model, scale * source, scale * receiver)
        assert np.allclose(
            np.sort(one.paths.length_m), np.sort(other.paths.length_m) / scale, rtol=1e-9
        ), seed
        assert np.isclose(one.coherent_w, other.coherent_w, rtol=1e-6, atol=1e-16), seed


@pytest.mark.parametrize("offset_m", [1e3, 1e5])
def test_a_scene_far_from_the_origin_has_the_same_paths(offset_m):
    shift = offset_m * np.array([1.0, -0.7, 0.3])
    for seed in range(40_000, 40_030):
        rng, room, objects, model, _ = draw(seed)
        source, receiver = generic_places(rng)
        one = answer(build_scene(room, objects=objects), model, source, receiver)
        far = build_scene(
            moved(room, shift_m=shift), objects=moved(objects, shift_m=shift), coordinate_bits=45
        )
        other = answer(far, model, source + shift, receiver + shift)
        assert len(one.gain) == len(other.gain), seed
        lengths = (np.sort(found.paths.length_m) for found in (one, other))
        assert np.allclose(*lengths, rtol=0.0, atol=1e-6), seed


@pytest.mark.parametrize("walls", [1, 2, 3])
def test_a_receiver_on_walls_hears_what_one_just_before_them_does(walls):
    scene = build_scene(box_room((4.0, 3.0, 2.5), material="concrete"))
    on = np.array([1.3, 1.1, 0.9])
    on[:walls] = 0.0
    before = on + 1e-7 * (on == 0.0)
    found = [answer(scene, Model(2, 0, False), (2.9, 1.7, 1.6), place) for place in (on, before)]
    assert_sound(found[0])
    assert len(found[0].gain) == len(found[1].gain)
    assert np.isclose(found[0].coherent_w, found[1].coherent_w, rtol=1e-4)


@pytest.mark.parametrize(
    "place", [(0.0, 1.0, 1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (1.0, 1.5, 1.0), (1.5, 1.5, 1.0)]
)
def test_a_source_on_a_surface_is_refused_and_one_off_it_is_not(place):
    crate = box((1.0, 1.0, 1.0), position_m=(1.0, 1.0, 0.0), material="metal")
    scene = build_scene(box_room((4.0, 3.0, 2.5), material="concrete"), objects=(crate,))
    with pytest.raises(GeometryError, match="on a surface") as refusal:
        answer(scene, Model(1, 1, False), place, (3.0, 2.0, 1.2))
    assert_one_sentence(refusal.value)
    off, _ = scene.stand_off([place], 0.05)
    assert_sound(answer(scene, Model(1, 1, False), off[0], (3.0, 2.0, 1.2)))


def test_a_receiver_at_the_source_is_refused():
    scene = build_scene(box_room((4.0, 3.0, 2.5)))
    with pytest.raises(GeometryError, match="place of the source") as refusal:
        answer(scene, Model(1, 0, False), (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    assert_one_sentence(refusal.value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_vertex_or_antenna_without_a_place_is_refused(value):
    crate = box((1.0, 1.0, 1.0), material="metal")
    vertices = crate.vertices_m.copy()
    vertices[3, 1] = value
    with pytest.raises(GeometryError, match="finite") as refusal:
        Body(name="crate", vertices_m=vertices, faces=crate.faces, material="metal")
    assert str(refusal.value).endswith(".")
    for places in (((value, 1, 1), (2, 2, 2)), ((2, 2, 2), (1, value, 1))):
        with pytest.raises(GeometryError, match="finite"):
            answer(build_scene((), objects=(crate,)), Model(1, 1, False), *places)


def test_bodies_without_any_area_are_refused():
    line = Body(
        name="line",
        vertices_m=np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]),
        faces=np.array([[0, 1, 2], [1, 1, 2]]),
        material="metal",
    )
    with pytest.raises(GeometryError, match="none of the 2 triangles") as refusal:
        build_scene((line,))
    assert_one_sentence(refusal.value)


def test_the_two_meshings_of_a_box_squashed_flat_make_one_sheet_of_four_edges():
    crate = box((1.0, 0.5, 1.0), material="metal")
    vertices = crate.vertices_m.copy()
    vertices[:, 1] = 0.0
    faces = crate.faces[[0, 1, 2, 3, 4, 5, 6, 7, 9, 8, 10, 11]]
    scene = build_scene((), objects=(replace(crate, vertices_m=vertices, faces=faces),))
    assert len(scene.facets.facet_plane) == 1
    assert np.isclose(scene.facets.area_m2(0), 1.0)
    assert np.allclose(find_wedges(scene).exterior_rad, 2.0 * np.pi)
    assert len(find_wedges(scene)) == 4


def test_overlapping_panels_of_one_body_are_their_union():
    low = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    tall = np.array([[0.0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]])
    quad = np.array([[0, 1, 2], [0, 2, 3]])
    panels = Body(
        name="panels",
        vertices_m=np.concatenate((low, tall)),
        faces=np.concatenate((quad, quad + 4)),
        material="metal",
    )
    scene = build_scene((), objects=(panels,))
    assert len(scene.facets.facet_plane) == 1
    assert np.isclose(scene.facets.area_m2(0), 3.0)
    assert len(find_wedges(scene)) == 6  # of an L
