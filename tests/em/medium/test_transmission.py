"""Waves through sheets: the product of slabs, every path of a brute-force search, passivity."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from slow_images import paths as slow_paths
from slow_images import through_sheets

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.explain import explain_path
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import Material, material
from octant.em.medium.radio_scene import radio_scene
from octant.em.medium.reflection import wall_coefficients
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import Candidates, SolverSettings, search_candidates
from octant.geometries.bodies import Body
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

F = 2.45e9
WAVELENGTH = 299_792_458.0 / F
SPACE = [(-9.0, -9.0, -9.0), (9.0, 9.0, 9.0)]
PLASTERBOARD = "name = plasterboard, thickness_m = 0.0125"
LAYERED = material(
    {
        "layers": [
            {"name": "plasterboard", "thickness_m": 0.0125},
            {"name": "air", "thickness_m": 0.07},
            {"eps_r": 4.0, "sigma_s_per_m": 0.02, "thickness_m": 0.02},
        ]
    }
)
BRICK = material({"name": "brick", "thickness_m": 0.1})
MATERIALS = {"layered": LAYERED, "brick_wall": BRICK}


def sheet(normal, offset, label, name):
    """A square of 12 m across a direction, its normal that way."""
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    u = np.cross(normal, (0.0, 0.0, 1.0) if abs(normal[2]) < 0.9 else (1.0, 0.0, 0.0))
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    corners = [
        offset * normal + 6.0 * (a * u + b * v) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return Body(
        name=name,
        vertices_m=np.array(corners),
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        material=label,
    )


def direct(sheets, source, receiver, taker, *, sender=None):
    """Return the radio scene, its one path without reflections, and the gain."""
    radio = radio_scene(build_scene((), objects=sheets), F, MATERIALS, transmission=True)
    images = search_candidates(
        radio, source, SolverSettings(max_reflections=0, diffraction=True), region_m=SPACE
    ).images
    paths = trace_paths(radio, Candidates(images=images), [receiver])
    assert len(paths) == 1
    ends = {"transmitter": sender or make_antenna("dipole", F, axis=(1, 2, 3)), "receiver": taker}
    return radio, paths, path_gains(radio, paths, **ends).gain[0], ends


def slab_matrix(wall, normal, direction, from_front):
    """Return the 3 x 3 transmission of a field along a direction, in place of the air."""
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    cosine = abs(direction @ normal)
    c = wall_coefficients(wall, F, [np.arccos(min(cosine, 1.0))], from_front=from_front)
    depth = wall.layer_stack(F)[1].sum()
    air = np.exp(2j * np.pi * depth * cosine / WAVELENGTH)
    across = np.cross(direction, normal)
    across /= np.linalg.norm(across)
    along = np.cross(across, direction)
    return air * (
        c.transmission_te[0] * np.outer(across, across)
        + c.transmission_tm[0] * np.outer(along, along)
    )


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, -2, 0.3), (0.2, 1, 1)])
@pytest.mark.parametrize("second", [(1, 0, 0), (0, 1, 0), (1, 1, 0.5)])
@pytest.mark.parametrize("back", [False, True])
def test_two_walls_are_the_product_of_their_slabs(axis, second, back):
    source, receiver = np.array([-2.0, -1.6, 0.1]), np.array([2.3, 1.9, 1.3])
    if back:
        source, receiver = receiver, source
    walls = (sheet((1, 0, 0), -1.0, "layered", "a"), sheet(second, 1.1, "brick_wall", "b"))
    direction = (receiver - source) / np.linalg.norm(receiver - source)
    sender, taker = make_antenna("dipole", F, axis=(1, 2, 3)), make_antenna("dipole", F, axis=axis)
    _, paths, gain, _ = direct(walls, source, receiver, taker, sender=sender)
    assert paths.letters_of(0) == ("T", "T")
    assert paths.order[0] == 0
    front = direction[0] < 0.0  # against the normal: the first layer first
    first = slab_matrix(LAYERED, (1, 0, 0), direction, front)
    last = slab_matrix(BRICK, second, direction, True)
    through = first @ last if back else last @ first
    length = np.linalg.norm(receiver - source)
    field = through @ _field(sender, direction)
    free = WAVELENGTH / (4.0 * np.pi * length) * np.exp(-2j * np.pi * length / WAVELENGTH)
    assert gain == pytest.approx(free * (field @ _field(taker, -direction)), rel=1e-11)


def _field(antenna, direction):
    theta, phi = np.arccos(direction[2]), np.arctan2(direction[1], direction[0])
    f_theta, f_phi = antenna.far_field(theta, phi)
    unit_theta = np.array(
        [np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)]
    )
    return f_theta * unit_theta + f_phi * np.array([-np.sin(phi), np.cos(phi), 0.0])


SLABS = {  # dB at 0 deg, 60 deg TE, 60 deg TM, of the analytic table
    "name = concrete, thickness_m = 0.20": (-14.80, -18.42, -14.43),
    "name = brick, thickness_m = 0.10": (-3.26, -4.44, -2.53),
    PLASTERBOARD: (-1.09, -3.20, -0.29),
    "name = glass, thickness_m = 0.006": (-1.96, -5.16, -0.22),
    "name = wood, thickness_m = 0.030": (-0.74, -2.89, -0.59),
}


@pytest.mark.parametrize("label", SLABS)
def test_budgets_have_the_slab_losses_of_p2040(label):
    for angle, axis, loss in zip((0.0, 60.0, 60.0), (0, 0, 1), SLABS[label], strict=True):
        a = np.radians(angle)
        source, receiver = (-2 * np.cos(a), -2 * np.sin(a), 0), (2 * np.cos(a), 2 * np.sin(a), 0)
        vertical = (0, 0, 1)  # across the plane of incidence
        level = (-np.sin(a), np.cos(a), 0)
        antenna = make_antenna("dipole", F, axis=level if axis else vertical)
        radio, paths, _, _ = direct((sheet((1, 0, 0), 0.0, label, "s"),), source, receiver, antenna)
        budget = explain_path(radio, paths, 0, transmitter=antenna, receiver=antenna)
        (line,) = [line for line in budget.lines if line.step == "transmission"]
        assert line.change_db == pytest.approx(loss, abs=0.01)


slabs = st.lists(
    st.tuples(st.floats(1.0, 12.0), st.floats(0.0, 0.3), st.floats(1e-3, 0.2)),
    min_size=1,
    max_size=4,
)


@given(slabs, st.floats(-1.2, 1.2), st.booleans())
def test_no_path_through_walls_is_stronger_than_free_space(layers, angle, back):
    parts = tuple(
        Material(name="x", eps_r_a=e, sigma_c_s_per_m=s, thickness_m=d) for e, s, d in layers
    )
    wall = parts[0] if len(parts) == 1 else Material(name="wall", layers=parts)
    scene = build_scene(
        (), objects=(sheet((1, 0, 0), 0.0, "w", "a"), sheet((1, 0, 0), 0.5, "w", "b"))
    )
    radio = radio_scene(scene, F, {"w": wall}, transmission=True)
    source, receiver = (-1.0, 0.0, 0.0), (1.5, 2.5 * np.tan(angle) / 3.0, 0.3)
    if back:
        source, receiver = receiver, source
    images = search_candidates(
        radio, source, SolverSettings(max_reflections=1, diffraction=True), region_m=SPACE
    ).images
    paths = trace_paths(radio, Candidates(images=images), [receiver])
    antenna = make_antenna("isotropic_theta", F)
    gain = np.abs(path_gains(radio, paths, transmitter=antenna, receiver=antenna).gain)
    assert (gain <= WAVELENGTH / (4.0 * np.pi * paths.length_m) * (1.0 + 1e-9)).all()


# Which paths there are


def rooms(seed):
    """A room of concrete with a hollow box of plasterboard and a sheet across, at odd angles."""
    rng = np.random.default_rng(seed)
    hollow = box(
        (0.8, 0.6, 0.9),
        material=PLASTERBOARD,
        position_m=(1.5, 1.0, 0.6),
        yaw_deg=rng.uniform(5, 40),
    )
    across = Body(
        name="sheet",
        vertices_m=np.array([(0.9, 0.1, 0.2), (1.1, 2.7, 0.3), (1.0, 2.6, 2.2), (0.8, 0.2, 2.1)]),
        faces=np.array([[0, 1, 2]]),
        material="name = wood, thickness_m = 0.03",
    )
    scene = build_scene(box_room((4.0, 3.0, 2.5), material="concrete"), objects=(hollow, across))
    places = rng.uniform(0.15, (3.85, 2.85, 2.35), (2, 3))
    if seed % 2:
        places[1] = (1.6, 1.4, 1.1)  # inside the box
    return scene, places


@pytest.mark.parametrize("seed", range(6))
def test_paths_through_sheets_are_those_of_a_brute_force_search(seed):
    scene, (source, receiver) = rooms(seed)
    radio = radio_scene(scene, F, transmission=True)
    images = search_candidates(
        radio, source, SolverSettings(max_reflections=2, diffraction=True)
    ).images
    paths = trace_paths(radio, Candidates(images=images), [receiver])
    planes = scene.facets.facet_plane
    ours = sorted(
        (
            float(paths.length_m[k]),
            tuple(zip(word, planes[paths.element[k, : len(word)]].tolist(), strict=True)),
        )
        for k, word in enumerate("".join(paths.letters_of(k)) for k in range(len(paths)))
    )
    theirs = through_sheets(scene, source, receiver, 2, radio.facet_transmits)
    assert any("T" in {letter for letter, _ in word} for _, word in theirs)
    assert [word for _, word in ours] == [word for _, word in theirs]
    assert np.allclose([x[0] for x in ours], [x[0] for x in theirs], atol=1e-9)
    assert len({word for _, word in ours}) == len(ours)  # each once
    bends = [sum(letter == "R" for letter, _ in word) for _, word in ours]
    assert sorted(paths.order) == sorted(bends)


def test_several_paths_of_one_image_are_there_once_each():
    """Two doors of one plane, one after the other: parallel sheets give equal images."""
    a, b = sheet((1, 0, 0), 0.0, PLASTERBOARD, "a"), sheet((0, 1, 0), 0.0, PLASTERBOARD, "b")
    radio = radio_scene(build_scene((), objects=(a, b)), F, transmission=True)
    images = search_candidates(
        radio, (1.0, 0.6, 0.0), SolverSettings(max_reflections=2, diffraction=True), region_m=SPACE
    ).images
    paths = trace_paths(radio, Candidates(images=images), [(0.7, 1.3, 0.4)])
    words = ["".join(paths.letters_of(k)) for k in range(len(paths))]
    theirs = through_sheets(
        radio.scene, np.array([1.0, 0.6, 0.0]), np.array([0.7, 1.3, 0.4]), 2, radio.facet_transmits
    )
    assert sorted(words) == sorted("".join(x for x, _ in word) for _, word in theirs)


@pytest.mark.parametrize("seed", range(3))
def test_without_transmission_sheets_block_as_before(seed):
    scene, (source, receiver) = rooms(2 * seed)
    antenna = make_antenna("dipole", F)
    found = []
    for options in ({}, {"transmission": False}):
        radio = radio_scene(scene, F, **options)
        images = search_candidates(
            radio, source, SolverSettings(max_reflections=2, diffraction=True)
        ).images
        paths = trace_paths(radio, Candidates(images=images), [receiver])
        found.append(path_gains(radio, paths, transmitter=antenna, receiver=antenna).gain)
    assert np.array_equal(*found)
    assert not any("T" in paths.letters_of(k) for k in range(len(paths)))
    slow = slow_paths(scene, source, receiver, 2)
    assert np.allclose(np.sort(paths.length_m), np.sort([x[1] for x in slow]), atol=1e-9)
