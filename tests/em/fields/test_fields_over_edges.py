"""The whole engine, from scene to gains: no jumps at edges, exact solutions, invariances."""

from dataclasses import replace

import numpy as np
import pytest
from boundaries import (
    SENDER,
    TAKERS,
    WAVELENGTH,
    F,
    find_boundaries,
    incident,
    jumps,
    link,
    only,
    optical_jumps,
    signatures,
    totals,
    trace,
)
from exact_wedges import HARD, SOFT, point_source, two_knife_edges

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import material
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.power.received_power import antenna_power
from octant.em.records import DIFFRACTION
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.bodies import Body
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

K = 2.0 * np.pi / WAVELENGTH
SPACE = [(-9.0, -9.0, -9.0), (9.0, 9.0, 9.0)]
LINED = material(
    {
        "layers": [
            {"name": "plasterboard", "thickness_m": 0.0125},
            {"name": "air", "thickness_m": 0.02},
            {"name": "concrete"},
        ]
    }
)
UNEVEN = material(
    {
        "layers": [
            {"name": "plasterboard", "thickness_m": 0.0125},
            {"name": "air", "thickness_m": 0.02},
            {"name": "wood", "thickness_m": 0.03},
        ]
    }
)
MATERIALS = {"lined": LINED, "uneven": UNEVEN}
GLASS = "name = glass, thickness_m = 0.006"


def plate(corner, u, v, label="pec"):
    a, u, v = (np.asarray(x, float) for x in (corner, u, v))
    return Body(
        name="plate",
        vertices_m=np.array([a, a + u, a + u + v, a + v]),
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        material=label,
    )


def around(wedges, w, radius_m):
    """A circle about an edge, near its middle."""
    middle = wedges.origin_m[w] + (0.5 * wedges.length_m[w] + 0.03) * wedges.axis[w]

    def curve(t):
        t = np.asarray(t)[:, None]
        across = np.cos(t) * wedges.tangent[w] + np.sin(t) * wedges.normal[w]
        return middle + radius_m * across

    return curve


def beside(wedges, w, distance_m, share):
    """A place in a wedge's air, opposite its middle."""
    middle = wedges.origin_m[w] + (0.5 * wedges.length_m[w] - 0.11) * wedges.axis[w]
    angle = share * wedges.exterior_rad[w]
    return middle + distance_m * (
        np.cos(angle) * wedges.tangent[w] + np.sin(angle) * wedges.normal[w]
    )


# Continuity


@pytest.mark.parametrize("label", ["pec", "concrete", "lined"])
def test_nothing_jumps_about_the_twelve_edges_of_a_cabinet(label):
    body = box((1.5, 0.9, 1.1), material=label, position_m=(0.2, 0.1, 0.3), yaw_deg=25.0)
    scene = build_scene((), objects=(body,))
    wedges = find_wedges(scene)
    assert len(wedges) == 12
    for w in range(12):
        found = link(scene, beside(wedges, w, 1.7, 0.29), 1, materials=MATERIALS, region=SPACE)
        curve = around(wedges, w, 0.4)
        sides = find_boundaries(found, curve, np.linspace(0.01, wedges.exterior_rad[w] - 0.01, 61))
        assert len(sides[0]) == 2  # the shadow's, the reflection's
        assert optical_jumps(found, curve, *sides).min() > 0.05
        assert jumps(found, curve, *sides).max() < 1e-3


@pytest.mark.parametrize("label", ["pec", "concrete", GLASS])
def test_along_the_line_of_an_edge_no_ray_over_edges_is_stronger_than_free_space_allows(label):
    """Both ends near the line of a cabinet's upright edge, above and below it: kL goes to 0."""
    body = box((1.5, 0.5, 1.0), material=label, position_m=(0.5, 0.5, 1.0))
    scene = build_scene((), objects=(body,))
    away = np.geomspace(1e-1, 1e-6, 6)[:, None]
    sources = (0.5, 1.0, 2.5) + away * (-0.57, 0.67, 0.0)
    places = (0.5, 1.0, 0.5) + away * (-0.87, 0.27, 0.0)
    for source, place in zip(sources, places, strict=True):
        found = link(scene, source, 0, diffractions=2, materials=MATERIALS, region=SPACE)
        paths = trace(found, [place])
        over = (paths.kind == DIFFRACTION).any(axis=1)
        assert over.sum() > 1
        for taker in TAKERS:
            gain = path_gains(found.radio, paths, transmitter=SENDER, receiver=taker).gain
            assert np.abs(gain[over]).max() < incident(found, [place])[0]


@pytest.mark.parametrize("share", [0.17, 0.71])
@pytest.mark.parametrize("label", ["pec", GLASS, "uneven"])
def test_nothing_jumps_about_the_rims_of_a_plate(label, share):
    """The sheet of three layers reflects differently from either side."""
    scene = build_scene(
        (), objects=(plate((0.3, 0.2, 0.1), (1.2, 0.3, 0.1), (-0.1, -0.2, 1.4), label),)
    )
    wedges = find_wedges(scene)
    assert len(wedges) == 4
    for w in range(4):
        found = link(
            scene,
            beside(wedges, w, 1.7, share),
            1,
            transmission=True,
            materials=MATERIALS,
            region=SPACE,
        )
        curve = around(wedges, w, 0.4)
        sides = find_boundaries(found, curve, np.linspace(0.01, 2.0 * np.pi - 0.01, 91))
        assert len(sides[0]) == 2
        assert optical_jumps(found, curve, *sides).min() > 0.1
        assert jumps(found, curve, *sides).max() < 1e-3


@pytest.mark.parametrize("label", ["pec", "concrete"])
def test_where_an_edge_hides_another_two_edges_take_over(label):
    """What is left with all edges is third order: where paths over two edges end."""
    body = box((0.8, 2.9, 1.1), material=label, position_m=(0.2, -1.1, 0.3))
    scene = build_scene((), objects=(body,))
    wedges = find_wedges(scene)
    top = [_nearest(wedges, place) for place in ((0.2, 0.35, 1.4), (1.0, 0.35, 1.4))]
    source = (-1.1, 0.31, 1.0)

    def curve(t):
        t = np.asarray(t)[:, None]
        return np.array([0.6, 0.37, 0.85]) + 1.5 * np.hstack((np.cos(t), 0.0 * t, np.sin(t)))

    once = link(scene, source, 1, region=SPACE, edges=top)
    twice = link(scene, source, 1, diffractions=2, region=SPACE, edges=top)
    every = link(scene, source, 1, diffractions=2, region=SPACE)
    # From above the cabinet down to behind its back: there the second edge hides the first.
    sides = find_boundaries(once, curve, np.linspace(1.3, 0.1, 201), "DRT")
    low, high = (signatures(once, curve(side), "DRT") for side in sides)
    hidden = [k for k in range(len(low)) if low[k] ^ high[k] == {("D", 0)}]
    assert len(hidden) == 1
    at = sides[0][hidden], sides[1][hidden]
    # A lossy face shorts what runs along it, so that little is hidden there in the first place.
    assert (jumps(once, curve, *at) > 0.01) == (label != "concrete")
    assert jumps(twice, curve, *at) < 1e-4
    assert jumps(every, curve, *sides).max() < 0.025


@pytest.mark.parametrize("first", ["cabinet", "screen"])
def test_where_a_body_hides_the_edge_of_another_two_edges_take_over(first):
    """Down behind a cabinet that stands behind something higher: what is left is third order."""
    if first == "cabinet":
        higher = box((0.8, 3.0, 1.6), material="concrete", position_m=(0.0, -1.5, 0.0))
    else:
        higher = plate((0.8, -1.5, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 1.6), "metal")
    lower = box((0.7, 3.0, 1.3), material="concrete", position_m=(2.4, -1.4, 0.0))
    scene = build_scene((), objects=(higher, lower))

    def curve(t):
        return np.array([4.4, 0.21, 0.0]) + np.asarray(t)[:, None] * np.array([0.0, 0.0, 1.0])

    found = link(scene, (-2.0, 0.13, 1.9), 3, diffractions=2, region=SPACE)
    heights = np.linspace(0.1, 2.2, 106)
    low, high = find_boundaries(found, curve, heights, "DRT")
    assert len(low) > 5
    assert jumps(found, curve, low - 1e-6, high + 1e-6).max() < 0.035
    dark = np.abs(totals(found, curve(heights[:40]))).max(axis=1)
    assert dark.min() > 1e-3 * incident(found, curve(heights[:40])).max()
    back = link(scene, curve([0.3])[0], 3, diffractions=2, region=SPACE)
    assert len(trace(back, [found.source])) == len(trace(found, curve([0.3])))


def test_edges_of_metal_are_those_of_a_perfect_conductor():
    """But where a path grazes a face to 1e-4 rad, where the coefficients of metal turn."""
    places = np.random.default_rng(1).uniform(-3.0, 3.0, (100, 3))
    fields = []
    for label in ("pec", "metal"):
        body = box((0.8, 2.9, 1.1), material=label, position_m=(0.2, -1.1, 0.3))
        scene = build_scene((), objects=(body,))
        places = places[~scene.inside_solid(places)]
        found = link(scene, (-1.3, 0.4, 0.9), 1, diffractions=2, region=SPACE)
        fields.append(totals(found, places) / incident(found, places)[:, None])
    assert np.quantile(np.abs(fields[0] - fields[1]).max(axis=1), 0.95) < 2e-3


def _nearest(wedges, place):
    return int(np.argmin(np.linalg.norm(_middles(wedges) - place, axis=1)))


def _into(wedges):
    half = 0.5 * wedges.exterior_rad[:, None]
    return 1e-3 * (np.cos(half) * wedges.tangent + np.sin(half) * wedges.normal)


def _middles(wedges):
    return wedges.origin_m + 0.5 * wedges.length_m[:, None] * wedges.axis


def test_exactly_on_a_shadow_boundary_the_field_is_that_beside_it():
    """A half-plane at x = 0, source and receiver opposite each other about its rim."""
    scene = build_scene((), objects=(plate((0.0, -3.0, -6.0), (0.0, 6.0, 0.0), (0.0, 0.0, 6.0)),))
    found = link(scene, (-2.0, 0.1, 0.5), 1, region=SPACE)
    offsets = np.array([0.0, 1e-7, -1e-7])
    places = np.column_stack((np.full(3, 2.0), np.full(3, -0.2), offsets - 0.5))
    exactly, above, below = totals(found, places)
    size = incident(found, places[:1])
    assert np.abs(exactly - above).max() < 1e-5 * size
    assert np.abs(exactly - below).max() < 1e-5 * size
    paths = trace(found, places[:1])
    assert not any(paths.letters_of(k) == () for k in range(len(paths)))


def test_exactly_on_a_reflection_boundary_the_field_is_that_beside_it():
    scene = build_scene((), objects=(plate((0.0, -3.0, -6.0), (0.0, 6.0, 0.0), (0.0, 0.0, 6.0)),))
    found = link(scene, (-2.0, 0.1, 1.0), 1, region=SPACE)
    offsets = np.array([0.0, 1e-7, -1e-7])
    places = np.column_stack((np.full(3, -2.0), np.full(3, -0.2), -1.0 + offsets))
    exactly, above, below = totals(found, places)
    size = incident(found, places[:1])
    assert np.abs(exactly - above).max() < 1e-5 * size
    assert np.abs(exactly - below).max() < 1e-5 * size


def test_level_with_the_top_of_a_cabinet_the_field_is_that_beside_it():
    """The direct ray grazes the top and touches both of its edges."""
    body = box((0.8, 2.9, 1.0), material="pec", position_m=(-0.4, -1.3, 0.0))
    scene = build_scene((), objects=(body,))
    wedges = find_wedges(scene)
    # Without the upright edges, whose paths would end exactly at their tips.
    top = [_nearest(wedges, place) for place in ((-0.4, 0.15, 1.0), (0.4, 0.15, 1.0))]
    found = link(scene, (-2.0, 0.1, 1.0), 1, diffractions=2, region=SPACE, edges=top)
    places = np.array([(1.9, -0.1, 1.0 + h) for h in (0.0, 1e-6, -1e-6)])
    exactly, above, below = totals(found, places)
    size = incident(found, places[:1])
    assert np.abs(exactly - below).max() < 2e-3 * size
    assert np.abs(above - below).max() < 2e-3 * size


# Exact solutions


@pytest.mark.slow
@pytest.mark.parametrize("kind", [SOFT, HARD])
@pytest.mark.parametrize("n", [2.0, 1.5])
def test_half_plane_and_corner_are_exact_beyond_a_wavelength(n, kind):
    size = 60.0
    if n == 2.0:
        body = plate((0.0, -30.0, 0.0), (0.0, 60.0, 0.0), (size, 0.0, 0.0)[::-1])
        body = replace(body, vertices_m=body.vertices_m * (1, 1, -1))
    else:
        body = box((size, 60.0, size), material="pec", position_m=(0.0, -30.0, -size))
    scene = build_scene((), objects=(body,))
    wedges = find_wedges(scene)
    row = [_nearest(wedges, (0.0, 0.0, 0.0))]
    radio = radio_scene(scene, F, wedges=only(wedges, row))
    one = radio.wedges
    sign = float(np.sign(one.axis[0] @ np.cross(one.tangent[0], one.normal[0])))
    worst = 0.0
    for near, share in ((0.37, 0.21), (0.9, 0.43)):
        phi_in = share * n * np.pi
        source = near * (np.cos(phi_in) * one.tangent[0] + np.sin(phi_in) * one.normal[0])
        phi = np.linspace(0.03, n * np.pi - 0.03, 60)
        places = 1.3 * (
            np.cos(phi)[:, None] * one.tangent[0] + np.sin(phi)[:, None] * one.normal[0]
        )
        found = search_candidates(
            radio,
            source,
            SolverSettings(max_reflections=1, diffraction=True),
            region_m=[(-70,) * 3, (70,) * 3],
        )
        paths = trace_paths(radio, found, places)
        axis = one.axis[0] * sign
        ours = _scalar(radio, paths, axis, kind, len(places))
        exact = np.array(
            [point_source(K, n, (near, phi_in, 0.0), (1.3, p, 0.0), kind) for p in phi]
        )
        free = 1.0 / np.linalg.norm(places - source, axis=1)
        worst = max(worst, np.abs(ours - exact).max() / free.max())
        strong = np.abs(exact) > 0.3 * free
        decibels = 20.0 * np.log10(np.abs(ours[strong] / exact[strong]))
        assert np.abs(decibels).max() < 0.1
    assert worst < 0.01


def _scalar(radio, paths, axis, kind, count):
    """Return the field along the edge (soft), or the magnetic one (hard), over that at 1 m."""
    ring = _ring(axis)
    if kind == SOFT:
        gains = path_gains(radio, paths, transmitter=ring, receiver=ring).gain
    else:
        gains = _hard(radio, paths, axis)
    out = np.zeros(count, complex)
    np.add.at(out, paths.receiver, gains)
    return out * 4.0 * np.pi / WAVELENGTH


def _ring(axis):
    """Isotropic across its axis and polarised along it."""
    return make_antenna("isotropic_theta", F, axis=tuple(axis))


def _hard(radio, paths, axis):
    """A loop: polarised across its axis, the same all round."""
    theta = np.linspace(0.0, np.pi, 61)[:, None]
    phi = np.arange(120) * (np.pi / 60.0)
    pattern = np.stack((0.0 * theta + 0.0 * phi, 1.0 + 0.0 * theta + 0.0 * phi)).astype(complex)
    loop = Antenna(kind="pattern", length_m=0.0, frequency_hz=F, axis=tuple(axis), pattern=pattern)
    # Both look along the ray away from themselves, so that their fields are opposite.
    return -path_gains(radio, paths, transmitter=loop, receiver=loop).gain


def test_a_conducting_inner_corner_is_its_images():
    room = box_room((9.0, 9.0, 9.0), material="pec")
    scene = build_scene(room)
    radio = radio_scene(scene, F, wedges=find_wedges(scene))
    assert not scene.inside_room(_middles(radio.wedges) + _into(radio.wedges)).any()
    source, near = (0.7, 0.4, 4.5), (np.hypot(0.7, 0.4), np.arctan2(0.4, 0.7), 0.0)
    found = search_candidates(radio, source, SolverSettings(max_reflections=2, diffraction=True))
    phi = np.linspace(0.1, 1.4, 9)
    places = np.column_stack((1.9 * np.cos(phi), 1.9 * np.sin(phi), np.full(9, 4.5)))
    paths = trace_paths(radio, found, places)
    planes = radio.scene.facets
    place = planes.plane_offset_m[planes.facet_plane]
    side = np.abs(planes.plane_normal[planes.facet_plane][:, 2]) < 0.5
    corner = np.append(side & (np.abs(place) < 1e-9), True)  # -1: no interaction
    kept = corner[paths.element].all(axis=1)
    gain = path_gains(radio, paths, transmitter=_ring((0, 0, 1)), receiver=_ring((0, 0, 1))).gain
    ours = np.zeros(9, complex)
    np.add.at(ours, paths.receiver[kept], gain[kept])
    exact = [point_source(K, 0.5, near, (1.9, p, 0.0), SOFT) for p in phi]
    assert ours * 4.0 * np.pi / WAVELENGTH == pytest.approx(np.array(exact), abs=1e-9)


# Invariances


def room_with_cabinet(turn=None, split=False, beside=False):
    bodies = [
        *box_room((4.0, 3.0, 2.5), material="concrete"),
        box((0.9, 0.5, 1.1), material="metal", position_m=(1.9, 1.1, 0.4), yaw_deg=20.0),
    ]
    if beside:
        bodies += [box((0.5, 0.6, 0.8), material="wood", position_m=(1.0, 1.4, 0.0), yaw_deg=8.0)]
    if split:
        bodies = [_split(body) for body in bodies]
    if turn is not None:
        bodies = [replace(body, vertices_m=body.vertices_m @ turn.T) for body in bodies]
    return build_scene(bodies[:6], objects=bodies[6:])


def _split(body):
    """Each triangle in four, by the middles of its sides."""
    corners = body.vertices_m[body.faces]
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    parts = [np.stack((corners[:, i], middles[:, i], middles[:, i - 1]), axis=1) for i in range(3)]
    triangles = np.concatenate([*parts, middles])
    return replace(
        body,
        vertices_m=triangles.reshape(-1, 3),
        faces=np.arange(3 * len(triangles)).reshape(-1, 3),
    )


PLACES = np.array([(0.6, 0.7, 0.9), (3.1, 2.4, 1.7), (3.3, 0.5, 0.6), (0.5, 2.5, 2.1)])


def powers(scene, source, places, *, axes, order=2, diffractions=2):
    radio = radio_scene(scene, F, wedges=find_wedges(scene))
    found = search_candidates(
        radio,
        source,
        SolverSettings(max_reflections=order, diffraction=True, max_diffractions=diffractions),
    )
    return antenna_power(
        radio,
        found,
        places,
        transmitter=make_antenna("dipole", F, axis=axes[0]),
        receiver=make_antenna("dipole", F, axis=axes[1]),
        power_w=1.0,
    )


AXES = ((0.2, 0.3, 1.0), (1.0, -0.4, 0.5))


@pytest.mark.parametrize(("diffractions", "beside"), [(1, False), (2, False), (2, True)])
def test_power_is_the_same_both_ways(diffractions, beside):
    """With a second body beside the cabinet too, whose edges see its own."""
    scene = room_with_cabinet(beside=beside)
    for other in PLACES[1:3]:
        there = powers(scene, PLACES[0], [other], axes=AXES, order=3, diffractions=diffractions)
        back = powers(scene, other, PLACES[:1], axes=AXES[::-1], order=3, diffractions=diffractions)
        assert there.path_count == back.path_count
        assert there.coherent_w == pytest.approx(back.coherent_w, rel=1e-9)
        assert there.local_mean_w == pytest.approx(back.local_mean_w, rel=1e-9)


def test_a_turned_room_has_the_same_powers():
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    upright = powers(room_with_cabinet(), PLACES[0], PLACES[1:], axes=AXES)
    turned = powers(
        room_with_cabinet(turn), turn @ PLACES[0], PLACES[1:] @ turn.T, axes=np.array(AXES) @ turn.T
    )
    assert np.array_equal(upright.path_count, turned.path_count)
    assert turned.coherent_w == pytest.approx(upright.coherent_w, rel=1e-9)
    assert turned.local_mean_w == pytest.approx(upright.local_mean_w, rel=1e-9)


def test_smaller_triangles_change_neither_edges_nor_powers():
    coarse, fine = room_with_cabinet(), room_with_cabinet(split=True)
    assert len(find_wedges(fine)) == len(find_wedges(coarse)) == 24
    before = powers(coarse, PLACES[0], PLACES[1:], axes=AXES)
    after = powers(fine, PLACES[0], PLACES[1:], axes=AXES)
    assert np.array_equal(before.path_count, after.path_count)
    assert after.coherent_w == pytest.approx(before.coherent_w, rel=1e-9)


def over_screens(objects, ends, axis):
    """Return the field from one end to the other over screens, over that without them."""
    dipole = make_antenna("dipole", F, axis=axis)

    def field(scene, solver):
        radio = radio_scene(scene, F, wedges=find_wedges(scene))
        found = antenna_power(
            radio,
            search_candidates(radio, ends[0], solver),
            ends[1:],
            transmitter=dipole,
            receiver=dipole,
            power_w=1.0,
        )
        return np.sqrt(found.coherent_w[0])

    behind = SolverSettings(max_reflections=2, diffraction=True, max_diffractions=2)
    aside = plate((0.0, 99.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    free = field(build_scene((), objects=[aside]), SolverSettings(max_reflections=0))
    return field(build_scene((), objects=objects), behind) / free


def screens(spaces, heights, size):
    """Two screens so deep and wide that only their upper rims count."""
    places = (spaces[0], spaces[0] + spaces[1])
    return [
        plate((x, -size, h - size), (0.0, 2.0 * size, 0.0), (0.0, 0.0, size))
        for x, h in zip(places, heights, strict=True)
    ]


@pytest.mark.parametrize(
    ("spaces", "heights"),
    [
        ((20.0, 10.0, 30.0), (0.5, 0.3)),
        ((20.0, 10.0, 30.0), (1.0, 1.0)),
        ((20.0, 1.0, 30.0), (0.3, 0.3)),
        ((40.0, 5.0, 40.0), (0.6, 0.6)),
        ((15.0, 25.0, 10.0), (0.05, 0.6)),
        ((20.0, 10.0, 30.0), (-0.2, 0.5)),
        ((20.0, 10.0, 30.0), (0.01, 0.01)),
    ],
)
def test_two_screens_are_two_knife_edges(spaces, heights):
    """The closed form lies midway between both polarisations, apart by what it leaves out."""
    scene = screens(spaces, heights, 900.0)
    ends = np.array([(0.0, 0.0, 0.0), (sum(spaces), 0.0, 0.0)])
    hard, soft = (over_screens(scene, ends, axis) for axis in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
    exact = abs(two_knife_edges(K, spaces, heights))
    assert 0.5 * (hard + soft) == pytest.approx(exact, abs=1e-3)
    assert abs(hard - soft) < 0.02
    back = over_screens(scene, ends[::-1], (0.0, 1.0, 0.0))
    assert back == pytest.approx(soft, rel=1e-9)


def test_two_screens_cast_the_shadow_of_one_thin_or_thick_wall():
    """A wall of a millimetre drawn by both faces is one screen; one of metres, nearly a block."""
    ends = np.array([(0.0, 0.0, -5.0), (25.0, 0.3, -6.0)])
    upright = (0.0, 0.0, 1.0)
    one, near, far = (
        over_screens(screens((10.0, gap), (0.0, 0.0), 90.0)[:count], ends, upright)
        for gap, count in ((5.0, 1), (1e-3, 2), (5.0, 2))
    )
    assert 0.8 * one < near < one
    assert 0.0 < far < 0.7 * one


@pytest.mark.parametrize("boundary", [(60.0, -0.3), (25.0, 0.2)])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)])
def test_nothing_jumps_where_a_screen_hides_or_mirrors_the_rim_of_another(boundary, axis):
    """Behind the second screen its rim hides the first's, before it its mirror image ends."""
    objects = screens((20.0, 10.0), (0.5, 0.3), 90.0)
    below, above = (
        over_screens(objects, np.array([(0.0, 0.0, 0.0), (boundary[0], 0.0, z)]), axis)
        for z in (boundary[1] - 1e-6, boundary[1] + 1e-6)
    )
    assert below > 0.0
    assert above == pytest.approx(below, abs=1e-4)
