import math
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from rooms import l_shaped_room

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.blocks import run_blocks
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import material
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.power import _power_kernels
from octant.em.power.radio_map import grid_axis_m, map_antenna, map_reader
from octant.em.power.received_power import antenna_power, reader_link
from octant.em.reader.response import reader_response, sector_response
from octant.em.search.candidates import Candidates, SolverSettings
from octant.em.search.images import search_images
from octant.geometries.errors import AntennaError, GeometryError, PhysicsWarning
from octant.geometries.furniture import box
from octant.geometries.reader_body import reader_body
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene
from octant.geometries.wedges import find_wedges

F = 2.4e9
TAG = (3.5, 2.0, 2.9)


def link_in(scene, response, tag=TAG, order=3, frequency_hz=F, height=0.3):
    return reader_link(
        radio_scene(scene, frequency_hz),
        tag_position_m=tag,
        tag_antenna=make_antenna("dipole", frequency_hz),
        tag_power_w=1.0,
        response=response,
        reader_height_m=height,
        solver=SolverSettings(max_reflections=order),
    )


@pytest.fixture(scope="module")
def isolated():
    body = reader_body(ground_plane_shape="round")
    return reader_response(body, make_antenna("dipole", F), model="isolated", gap_m=0.005)


@pytest.fixture(scope="module")
def rays():
    body = reader_body(ground_plane_shape="round")
    return reader_response(body, make_antenna("dipole", F), model="rays", gap_m=0.005)


def test_antenna_power_equals_the_sum_of_its_recorded_paths(box_scene, dipole, isotropic):
    radio = radio_scene(box_scene, F)
    tree = search_images(box_scene, TAG, 3)
    places = np.random.default_rng(1).uniform((0.2, 0.2, 0.2), (4.8, 4.8, 2.8), (40, 3))
    power = antenna_power(
        radio, Candidates(images=tree), places, transmitter=dipole, receiver=isotropic, power_w=2.0
    )
    paths = trace_paths(radio, Candidates(images=tree), places)
    gain = path_gains(radio, paths, transmitter=dipole, receiver=isotropic).gain
    for i in range(len(places)):
        mine = gain[paths.receiver == i]
        assert power.path_count[i] == len(mine) == 63
        assert power.coherent_w[i] == pytest.approx(2.0 * abs(mine.sum()) ** 2, rel=1e-12)
        assert power.local_mean_w[i] == pytest.approx(2.0 * np.sum(abs(mine) ** 2), rel=1e-12)


def test_blocks_and_threads_change_no_bit(box_scene, dipole, isotropic):
    radio = radio_scene(box_scene, F)
    tree = search_images(box_scene, TAG, 3)
    axis = grid_axis_m(0.0, 5.0, spacing_m=0.1)
    gx, gy = np.meshgrid(axis, axis, indexing="ij")
    places = np.column_stack((gx.ravel(), gy.ravel(), np.full(gx.size, 0.3)))
    whole = antenna_power(
        radio, Candidates(images=tree), places, transmitter=dipole, receiver=isotropic, power_w=1.0
    )
    for row in range(0, len(places), 137):
        one = antenna_power(
            radio,
            Candidates(images=tree),
            places[row : row + 1],
            transmitter=dipole,
            receiver=isotropic,
            power_w=1.0,
        )
        assert one.coherent_w[0] == whole.coherent_w[row]
        assert one.local_mean_w[0] == whole.local_mean_w[row]


@pytest.mark.parametrize("workers", [1, 3])
def test_every_row_is_worked_once(workers):
    done = np.zeros(1000, dtype=int)
    told = []

    def work(begin, end):
        done[begin:end] += 1

    with ThreadPoolExecutor(workers) as pool:
        run_blocks(work, 1000, block_size=64, executor=pool, progress=lambda *x: told.append(x))
    assert (done == 1).all()
    assert told[-1] == (1000, 1000)


def test_free_space_rss_of_isolated_antennas_is_the_closed_form(isolated):
    """Friis' law, with the plane wave's phase and pattern at the reader's centre."""
    pose = np.array([1.0, 0.5, 0.7])
    rss = link_in(free_space_scene(), isolated).rss_w([pose])[0]
    sight = np.array(TAG) - (pose[0], pose[1], 0.3)
    distance = np.linalg.norm(sight)
    wavelength = 299792458.0 / F
    theta = np.arccos(sight[2] / distance)
    gain = 1.640922376984585 * (np.cos(np.pi / 2 * np.cos(theta)) / np.sin(theta)) ** 2
    expected = (wavelength / (4 * np.pi * distance)) ** 2 * gain**2
    assert rss == pytest.approx(np.full(8, expected), rel=1e-7)


def test_turning_the_reader_by_45_degrees_permutes_its_rss(rays):
    link = link_in(free_space_scene(), rays)
    for heading in (0.0, 0.31, 2.0):
        before = link.rss_w([(0.6, 0.2, heading)])[0]
        after = link.rss_w([(0.6, 0.2, heading + math.pi / 4)])[0]
        assert np.roll(before, -1) == pytest.approx(after, rel=1e-6)
        assert np.ptp(before) > 0.1 * before.max()


def test_front_antenna_3_faces_the_heading():
    response = sector_response(np.arange(8) * np.pi / 4, frequency_hz=F)
    link = link_in(free_space_scene(), response, tag=(0.0, 0.0, 2.9))
    for x, y in ((-2.0, 0.0), (1.0, -1.0), (0.3, 2.0)):
        towards = math.atan2(-y, -x)
        assert int(np.argmax(link.rss_w([(x, y, towards)]))) == 2
        assert int(np.argmax(link.rss_w([(x, y, towards + math.pi / 2)]))) == 0
        assert int(np.argmax(link.rss_w([(x, y, towards - math.pi / 2)]))) == 4


def test_nothing_is_received_right_under_the_tag(isolated):
    link = link_in(free_space_scene(), isolated, tag=(0.0, 0.0, 2.9))
    assert link.rss_w([(0.0, 0.0, 0.0)]).max() == 0.0


def test_reader_in_a_room_equals_isotropic_reference_path_by_path(box_scene, isolated, dipole):
    """The reader's path sum, rebuilt from recorded paths and its far field."""
    link = link_in(box_scene, isolated)
    pose = (1.2, 3.4, 0.4)
    power = link.power([pose])
    radio = radio_scene(box_scene, F)
    paths = trace_paths(
        radio, Candidates(images=search_images(box_scene, TAG, 3)), [(1.2, 3.4, 0.3)]
    )
    vertical = path_gains(
        radio, paths, transmitter=dipole, receiver=make_antenna("isotropic_theta", F)
    )
    u = vertical.arrival
    theta, phi = np.arccos(u[:, 2]), np.arctan2(u[:, 1], u[:, 0]) - (pose[2] - np.pi / 2)
    f = isolated.far_field(theta, phi)
    # An upright element has no phi component, so the theta gain of each path is all it takes.
    assert np.abs(f[..., 1]).max() < 1e-12
    voltages = f[..., 0] * vertical.gain
    expected = np.abs(voltages.sum(axis=1)) ** 2
    assert power.coherent_w[0] == pytest.approx(expected, rel=1e-9)
    assert power.local_mean_w[0] == pytest.approx(np.sum(np.abs(voltages) ** 2, axis=1), rel=1e-9)
    assert power.path_count[0] == 63


def test_channels_are_averaged_in_power(box_scene):
    radios = [radio_scene(box_scene, f) for f in CHANNELS_HZ]
    average, links = channel_links(radios, tag_antennas("dipole"), list(map(sector, CHANNELS_HZ)))
    pose = [(1.0, 1.0, 0.0)]
    mean = np.mean([link.rss_w(pose) for link in links], axis=0)
    assert average.rss_w(pose) == pytest.approx(mean, rel=1e-12)
    assert np.ptp([link.rss_w(pose)[0, 0] for link in links]) > 0.0


def test_every_heading_of_a_place_has_the_bits_of_its_pose(box_scene, rays):
    link = link_in(box_scene, rays)
    places = np.random.default_rng(3).uniform((0.2, 0.2), (4.8, 3.8), (150, 2))
    headings = np.array([-9.0, -0.3, 0.0, 1.1, math.pi, 40.0])
    grid = link.power_by_heading(places, headings)
    assert grid.coherent_w.shape == grid.local_mean_w.shape == (150, 6, 8)
    for j, heading in enumerate(headings):
        one = link.power(np.column_stack((places, np.full(150, heading))))
        assert (grid.coherent_w[:, j] == one.coherent_w).all()
        assert (grid.local_mean_w[:, j] == one.local_mean_w).all()
        assert (grid.path_count == one.path_count).all()
    assert (link.rss_by_heading_w(places, headings) == grid.coherent_w).all()
    turning = np.repeat(np.column_stack((places, np.zeros(150))), 6, axis=0)
    turning[:, 2] = np.tile(headings, 150)
    for poses in (turning, turning[:-2], np.vstack((turning[:6], turning))):
        one = link.power(poses)
        apart = [link.power(pose[None]) for pose in poses[:40]]
        assert (one.coherent_w[:40] == np.vstack([each.coherent_w for each in apart])).all()
        assert (one.path_count[:40] == np.concatenate([e.path_count for e in apart])).all()
        assert len(one.coherent_w) == len(one.path_count) == len(poses)
    assert (np.ptp(grid.coherent_w, axis=1) > 0.0).all()


@pytest.mark.parametrize("passes", [False, True])
def test_one_place_at_a_time_has_the_bits_of_all_together(isolated, passes):
    objects = [
        box((0.6, 0.1, 1.8), material="wood", position_m=(2.0, 2.0, 0.01), yaw_deg=20.0),
        box((0.5, 0.5, 1.0), material="metal", position_m=(0.5, 3.0, 0.0)),
        box((0.5, 1.0, 0.8), material="metal", position_m=(3.5, 0.5, 0.0)),
    ]
    scene = build_scene(l_shaped_room((5.0, 5.0, 3.0), (2.0, 1.5)), objects=objects)
    link = reader_link(
        radio_scene(scene, F, transmission=passes),
        tag_position_m=TAG,
        tag_antenna=make_antenna("dipole", F),
        tag_power_w=1.0,
        response=isolated,
        reader_height_m=0.3,
        solver=SolverSettings(max_reflections=3),
    )
    poses = np.random.default_rng(5).uniform((0.1, 0.1, -3.0), (4.9, 4.9, 3.0), (120, 3))
    poses[::3, :2] = np.round(2.0 * poses[::3, :2]) / 2.0  # corners of cells, level with things
    together = link.power(poses)
    alone = [link.power(pose[None]) for pose in poses]
    for one, name in zip(together, together._fields, strict=True):
        assert np.array_equal(one, np.concatenate([getattr(found, name) for found in alone]))
    images = link.bands[0].images
    tried = [len(images.at(np.array([x, y, 0.3])).leaves) for x, y in poses[:, :2]]
    assert np.mean(tried) < 0.4 * len(images.tree.leaves)
    assert max(together.path_count) > 20


def test_no_place_and_no_heading_are_empty_results(box_scene, isolated):
    link = link_in(box_scene, isolated, order=1)
    assert link.rss_by_heading_w(np.zeros((0, 2)), [0.0]).shape == (0, 1, 8)
    assert link.rss_by_heading_w([(1.0, 1.0)], []).shape == (1, 0, 8)
    with pytest.raises(GeometryError, match="outside the region"):
        link.rss_by_heading_w([(7.0, 1.0)], [0.0])


CHANNELS_HZ = (2.402e9, 2.441e9, 2.480e9)


def sector(frequency_hz, antennas=8):
    return sector_response(
        np.arange(antennas) * (2.0 * np.pi / antennas), frequency_hz=frequency_hz
    )


def tag_antennas(kind):
    if kind != "table":
        return [make_antenna(kind, f, azimuth_rad=0.4) for f in CHANNELS_HZ]
    # The pattern of a dipole whose length does not follow the frequency, as a table.
    theta, phi = np.linspace(0.0, np.pi, 61), np.arange(60) * (np.pi / 30)
    dipoles = [make_antenna("dipole", f, length_m=0.05) for f in CHANNELS_HZ]
    return [
        Antenna(
            kind="pattern",
            length_m=0.0,
            frequency_hz=d.frequency_hz,
            axis=np.array([0.2, 0.1, -1.0]),
            azimuth_rad=0.4,
            pattern=np.moveaxis(d.far_field(theta[:, None], phi), -1, 0),
        )
        for d in dipoles
    ]


def channel_links(radios, tags, responses):
    """Return the link of all channels at once, and the links of each alone."""

    def link(radio, tag, response):
        return reader_link(
            radio,
            tag_position_m=TAG,
            tag_antenna=tag,
            tag_power_w=0.7,
            response=response,
            reader_height_m=0.3,
            solver=SolverSettings(max_reflections=2, diffraction=True),
        )

    together = link(radios, tags, responses)
    return together, [link(*one) for one in zip(radios, tags, responses, strict=True)]


@pytest.mark.parametrize("kind", ["dipole", "patch", "table"])
@pytest.mark.parametrize("walls", ["opaque", "let waves through", "diffract"])
def test_channels_traced_together_have_the_bits_of_channels_traced_alone(kind, walls):
    obstacle = box((0.6, 0.1, 1.8), material="wood", position_m=(2.0, 2.0, 0.01), yaw_deg=20.0)
    scene = build_scene(box_room((5.0, 4.0, 3.0)), objects=[obstacle])
    wedges = find_wedges(scene) if walls == "diffract" else None
    radios = [
        radio_scene(scene, f, transmission=walls == "let waves through", wedges=wedges)
        for f in CHANNELS_HZ
    ]
    responses = [sector(f) for f in CHANNELS_HZ]
    together, alone = channel_links(radios, tag_antennas(kind), responses)
    poses = np.random.default_rng(5).uniform((0.2, 0.2, -4.0), (4.8, 3.8, 4.0), (40, 3))
    apart = replace(alone[0], bands=tuple(band for link in alone for band in link.bands))
    expected, found = apart.power(poses), together.power(poses)
    assert len(together.bands) == 1
    for wanted, given in zip(expected, found, strict=True):
        assert (wanted == given).all()
    each = np.array([link.rss_w(poses) for link in alone])
    assert found.coherent_w == pytest.approx(each.mean(axis=0), rel=1e-12)
    assert (np.ptp(each, axis=0) > 1e-3 * each.max(axis=0)).mean() > 0.9


def test_channels_whose_paths_differ_are_traced_apart(box_scene):
    """A wall that lets through at one frequency only; a reader's table on another grid."""
    obstacle = box((0.6, 0.1, 1.8), material="odd", position_m=(2.0, 2.0, 0.01))
    scene = build_scene(box_room((5.0, 4.0, 3.0)), objects=[obstacle])
    radios = [
        radio_scene(
            scene,
            f,
            {"odd": material({"name": "metal" if odd else "wood", "thickness_m": 0.01})},
            transmission=True,
        )
        for f, odd in zip(CHANNELS_HZ, (True, False, True), strict=True)
    ]
    responses = [sector(f) for f in CHANNELS_HZ]
    poses = np.random.default_rng(6).uniform((0.2, 0.2, -4.0), (4.8, 3.8, 4.0), (20, 3))
    together, alone = channel_links(radios, tag_antennas("dipole"), responses)
    assert [band.channels for band in together.bands] == [2, 1]
    mean = np.mean([link.rss_w(poses) for link in alone], axis=0)
    assert together.rss_w(poses) == pytest.approx(mean, rel=1e-12)
    assert (together.power(poses).path_count == alone[0].power(poses).path_count).all()
    coarse = replace(responses[1], pattern=np.ascontiguousarray(responses[1].pattern[:, :, ::2]))
    responses[1] = coarse
    plain = [radio_scene(box_scene, f) for f in CHANNELS_HZ]
    together, alone = channel_links(plain, tag_antennas("dipole"), responses)
    assert [band.channels for band in together.bands] == [2, 1]
    mean = np.mean([link.rss_w(poses) for link in alone], axis=0)
    assert together.rss_w(poses) == pytest.approx(mean, rel=1e-12)


@pytest.mark.parametrize("diffract", [False, True])
def test_a_link_in_another_process_uses_the_same_compiled_kernels(isolated, diffract):
    """Numba compiles apart for read-only arrays, and unpickled ones can be written to."""
    obstacle = box((0.6, 0.1, 1.8), material="wood", position_m=(2.0, 2.0, 0.01))
    scene = build_scene(box_room((5.0, 4.0, 3.0)), objects=[obstacle])
    radio = radio_scene(scene, F, wedges=find_wedges(scene) if diffract else None)
    link = reader_link(
        radio,
        tag_position_m=TAG,
        tag_antenna=make_antenna("dipole", F),
        tag_power_w=1.0,
        response=isolated,
        reader_height_m=0.3,
        solver=SolverSettings(max_reflections=1, diffraction=diffract),
    )
    there = pickle.loads(pickle.dumps(link))  # noqa: S301  our own
    pose = np.array([[1.0, 1.5, 0.3]])
    rss_w = link.rss_w(pose)
    compiled = set(_power_kernels.reader_power.signatures)
    np.testing.assert_array_equal(there.rss_w(pose), rss_w)
    assert set(_power_kernels.reader_power.signatures) == compiled


def test_channels_that_do_not_fit_are_refused(box_scene):
    radios = [radio_scene(box_scene, f) for f in CHANNELS_HZ]
    tags, responses = tag_antennas("dipole"), [sector(f) for f in CHANNELS_HZ]
    with pytest.raises(AntennaError, match="3 scenes, 2 tag antennas and 3 readers"):
        channel_links(radios, tags[:2], responses)
    with pytest.raises(AntennaError, match="0 scenes"):
        channel_links([], [], [])
    with pytest.raises(AntennaError, match="one frequency for all three"):
        channel_links(radios, tags[::-1], responses)
    with pytest.raises(AntennaError, match="different antennas"):
        channel_links(radios, tags, [*responses[:2], sector(CHANNELS_HZ[2], antennas=6)])
    elsewhere = radio_scene(build_scene(box_room((5.0, 5.0, 3.0))), CHANNELS_HZ[2])
    with pytest.raises(GeometryError, match="different rooms"):
        channel_links([*radios[:2], elsewhere], tags, responses)


def test_maps_are_the_powers_at_their_cells(box_scene, isolated, dipole, isotropic):
    x = grid_axis_m(0.0, 5.0, spacing_m=1.0)
    y = grid_axis_m(0.0, 4.0, spacing_m=1.0)
    assert x.tolist() == [0.5, 1.5, 2.5, 3.5, 4.5]
    radio, tree = radio_scene(box_scene, F), search_images(box_scene, TAG, 2)
    field = map_antenna(
        radio,
        Candidates(images=tree),
        x_m=x,
        y_m=y,
        z_m=0.3,
        transmitter=dipole,
        receiver=isotropic,
        power_w=1.0,
    )
    assert field.coherent_w.shape == (5, 4)
    one = antenna_power(
        radio,
        Candidates(images=tree),
        [(x[3], y[1], 0.3)],
        transmitter=dipole,
        receiver=isotropic,
        power_w=1.0,
    )
    assert field.coherent_w[3, 1] == one.coherent_w[0]
    link = link_in(box_scene, isolated, order=2)
    reader = map_reader(link, x_m=x, y_m=y, heading_rad=0.4)
    assert reader.coherent_w.shape == (5, 4, 8)
    assert (reader.coherent_w[3, 1] == link.rss_w([(x[3], y[1], 0.4)])[0]).all()


def test_reader_height_counts_from_the_floor(isolated):
    scene = build_scene(box_room((5.0, 5.0, 3.0), origin_m=(-1.0, -1.0, 0.7)))
    assert link_in(scene, isolated).reader_z_m == pytest.approx(1.0)


def test_bad_links_are_refused(box_scene, isolated):
    with pytest.raises(AntennaError, match="one frequency for all three"):
        link_in(box_scene, isolated, frequency_hz=2.45e9)
    with pytest.raises(GeometryError, match="level with the reader"):
        link_in(box_scene, isolated, tag=(1.0, 1.0, 0.3))
    with pytest.raises(GeometryError, match="outside the region"):
        link_in(box_scene, isolated).rss_w([(7.0, 1.0, 0.0)])
    with pytest.warns(PhysicsWarning, match="plane across"):
        link_in(box_scene, isolated, tag=(1.0, 1.0, 0.6))
