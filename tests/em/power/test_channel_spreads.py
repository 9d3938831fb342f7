"""Spreads of channels that can be written down: one path, two paths, and a ring of them."""

import math

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.gains import PathGains, path_gains
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.power.channel_spreads import _spreads, channel_spreads
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images
from octant.geometries.bodies import Body
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

F = 2.4e9
C = 299_792_458.0


def gains(power, delay_s, arrival):
    arrival = np.array(arrival, dtype=float)
    return PathGains(
        gain=np.sqrt(np.array(power, dtype=complex)),
        length_m=np.array(delay_s) * C,
        departure=arrival,
        arrival=arrival / np.linalg.norm(arrival, axis=1)[:, None],
    )


def spreads(power, delay_s, arrival):
    rows = np.zeros(len(power), dtype=np.int64)
    return [float(v[0]) for v in _spreads(rows, gains(power, delay_s, arrival), 1)]


def test_one_path_has_no_spread():
    assert spreads([0.3], [5e-8], [(1, 2, 3)]) == pytest.approx([0.0, 0.0, 0.0], abs=1e-8)


def test_two_equal_paths_spread_by_half_their_delay_and_the_sine_of_half_their_angle():
    angle = 0.7
    ends = [(math.cos(angle), math.sin(angle), 0), (math.cos(angle), -math.sin(angle), 0)]
    delay, azimuth, direction = spreads([1.0, 1.0], [10e-9, 30e-9], ends)
    assert delay == pytest.approx(10e-9, rel=1e-12)
    assert azimuth == pytest.approx(math.sqrt(-2.0 * math.log(math.cos(angle))), rel=1e-12)
    assert direction == pytest.approx(math.sin(angle), rel=1e-12)


def test_powers_weigh_the_paths():
    delay, _, direction = spreads([9.0, 1.0], [0.0, 10e-9], [(1, 0, 0), (0, 0, 1)])
    assert delay == pytest.approx(10e-9 * math.sqrt(0.9 * 0.1), rel=1e-12)
    assert direction == pytest.approx(math.sqrt(1 - 0.81 - 0.01), rel=1e-12)


def test_small_spreads_are_the_standard_deviation_of_the_angle():
    rng = np.random.default_rng(3)
    turn = 1e-6 * rng.standard_normal(50)
    power = rng.uniform(0.5, 1.0, 50)
    share = power / power.sum()
    deviation = math.sqrt(share @ (turn - share @ turn) ** 2)
    across = np.column_stack((np.cos(turn), np.sin(turn), np.zeros(50)))
    _, _, direction = spreads(power, np.zeros(50), across)
    assert direction == pytest.approx(deviation, rel=1e-6)
    turn = turn * 1e5
    deviation = math.sqrt(share @ (turn - share @ turn) ** 2)
    across = np.column_stack((np.cos(turn), np.sin(turn), np.zeros(50)))
    assert spreads(power, np.zeros(50), across)[1] == pytest.approx(deviation, rel=0.02)


def test_a_full_ring_has_the_greatest_spreads():
    phi = np.arange(8) * math.pi / 4
    ring = np.column_stack((np.cos(phi), np.sin(phi), np.zeros(8)))
    _, azimuth, direction = spreads(np.ones(8), np.zeros(8), ring)
    assert azimuth > 8.0
    assert direction == pytest.approx(1.0, rel=1e-12)


def test_delay_spread_over_a_mirror_is_that_of_its_two_rays():
    floor = Body(
        name="floor",
        vertices_m=[(-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)],
        faces=[(0, 1, 2), (0, 2, 3)],
        material="pec",
    )
    radio = radio_scene(build_scene((floor,)), F)
    region = [(-50, -50, -1), (50, 50, 9)]
    tree = search_images(radio.scene, (0.0, 0.0, 2.0), 1, region_m=region)
    ends = {name: make_antenna("isotropic_theta", F) for name in ("transmitter", "receiver")}
    found = channel_spreads(radio, Candidates(images=tree), [(6.0, 0.0, 1.5)], **ends)
    lengths = np.array([math.hypot(6.0, 0.5), math.hypot(6.0, 3.5)])
    share = lengths**-2 / (lengths**-2).sum()
    expected = math.sqrt(share[0] * share[1]) * (lengths[1] - lengths[0]) / C
    assert found.delay_spread_s[0] == pytest.approx(expected, rel=1e-9)
    assert found.azimuth_spread_rad[0] == pytest.approx(0.0, abs=1e-7)


def test_blocks_and_threads_do_not_change_a_bit_and_silence_is_not_a_number():
    radio = radio_scene(build_scene(box_room((5.0, 5.0, 3.0))), F)
    tree = search_images(radio.scene, (3.5, 2.0, 2.9), 2)
    rng = np.random.default_rng(2)
    places = rng.uniform((0.1, 0.1, 0.1), (4.9, 4.9, 2.0), (600, 3))
    ends = {"transmitter": make_antenna("dipole", F), "receiver": make_antenna("dipole", F)}
    every = channel_spreads(radio, Candidates(images=tree), places, **ends)
    for i in (0, 255, 256, 599):
        one = channel_spreads(radio, Candidates(images=tree), places[i : i + 1], **ends)
        assert one.delay_spread_s[0] == every.delay_spread_s[i]
        assert one.direction_spread_rad[0] == every.direction_spread_rad[i]
        paths = trace_paths(radio, Candidates(images=tree), places[i : i + 1])
        gain = path_gains(radio, paths, **ends)
        power = np.abs(gain.gain) ** 2
        mean = np.average(gain.delay_s, weights=power)
        rms = math.sqrt(np.average((gain.delay_s - mean) ** 2, weights=power))
        assert one.delay_spread_s[0] == pytest.approx(rms, rel=1e-12)
    patch = make_antenna("patch", F, axis=(0, 0, -1))
    beside = channel_spreads(
        radio, Candidates(images=tree), [(3.5, 2.0, 1.0)], **(ends | {"receiver": patch})
    )
    assert np.isfinite(beside.delay_spread_s[0])
    none = search_images(radio.scene, (3.5, 2.0, 2.9), 0)
    silent = channel_spreads(
        radio, Candidates(images=none), [(3.5, 2.0, 1.0)], **ends
    )  # below a dipole
    assert np.isnan(silent.delay_spread_s[0])
    assert np.isnan(silent.azimuth_spread_rad[0])
    assert np.isnan(silent.direction_spread_rad[0])
