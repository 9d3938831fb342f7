"""Field maps against the reader link that traces every pose: in a room, by heading, and errors."""

from dataclasses import replace

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.field_maps import (
    FieldMap,
    antennas_alike,
    joined,
    make_field_map,
    map_error,
    plan_map,
)
from octant.em.power.node_paths import trace_node_paths
from octant.em.power.path_maps import make_path_map
from octant.em.power.received_power import reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings, radio_scenes
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

CARRIER_HZ = 2.4e9
TAG = (1.0, 0.5, 2.9)
READER_Z_M = 0.3
LOW, HIGH = (-1.0, -1.0), (0.0, 0.0)
SOLVER = SolverSettings(max_reflections=2)
RING = 2.0 * np.pi / 8.0 * np.arange(8)


def response_at(frequency_hz, azimuths=RING):
    return sector_response(azimuths, frequency_hz=frequency_hz)


@pytest.fixture(scope="module")
def scene():
    return build_scene(box_room((7.0, 6.0, 3.0), origin_m=(-3.5, -3.0, 0.0), material="concrete"))


def at_channels(scene, channels_hz, azimuths=RING):
    """Radio scenes, responses and tag antennas of channels."""
    return (
        [radio_scene(scene, f) for f in channels_hz],
        [response_at(f, azimuths) for f in channels_hz],
        [make_antenna("dipole", f) for f in channels_hz],
    )


def paths_of(scene, channels_hz=(CARRIER_HZ,), *, plan, solver=SOLVER):
    radios = radio_scenes(scene, channels_hz, solver)
    return trace_node_paths(
        radios,
        plan.node_x_m,
        plan.node_y_m,
        tag_position_m=np.array(TAG),
        tag_antennas=[make_antenna("dipole", f) for f in channels_hz],
        reader_z_m=READER_Z_M,
        solver=solver,
    )


def map_of(scene, channels_hz=(CARRIER_HZ,), *, azimuths=RING, spacing_m=0.0125, solver=SOLVER):
    radios, responses, _ = at_channels(scene, channels_hz, azimuths)
    plan = plan_map(LOW, HIGH, wavelength_m=radios[-1].wavelength_m, spacing_m=spacing_m)
    paths = paths_of(scene, channels_hz, plan=plan, solver=solver)
    return make_field_map(paths, radios, responses, plan, tag_power_w=0.5, reader_z_m=READER_Z_M)


def link_of(scene, channels_hz=(CARRIER_HZ,), azimuths=RING, tag=TAG, solver=SOLVER):
    _, responses, tags = at_channels(scene, channels_hz, azimuths)
    return reader_link(
        radio_scenes(scene, channels_hz, solver),
        tag_position_m=tag,
        tag_antenna=tags,
        tag_power_w=0.5,
        response=responses,
        reader_height_m=READER_Z_M,
        solver=solver,
    )


@pytest.fixture(scope="module")
def poses():
    rng = np.random.default_rng(2)
    places = rng.uniform(LOW, HIGH, (200, 2))
    return np.column_stack([places, rng.uniform(-4.0, 4.0, 200)])


@pytest.mark.parametrize("channels_hz", [(CARRIER_HZ,), (2.40e9, 2.42e9, 2.44e9)])
def test_between_places_and_headings_the_map_is_the_solvers_field(scene, poses, channels_hz):
    """At 1/10 of a wavelength the error field is 20 dB below the local mean."""
    found, link = map_of(scene, channels_hz), link_of(scene, channels_hz)
    error = map_error(found, link.rss_w(poses), poses)
    assert error.share < 0.01
    assert error.rms_db < 1.5
    mean = link.power(poses).local_mean_w
    assert found.local_mean_w(poses) == pytest.approx(mean, rel=0.1)


def test_where_furniture_stands_edges_make_maps_exact(scene):
    """The error field behind a cabinet is 15 dB below the local mean, without its edges 9 dB."""
    cabinet = box((0.7, 0.4, 1.5), material="metal", position_m=(0.1, -0.5, 0.0), yaw_deg=20.0)
    furnished = build_scene([*scene.bodies, cabinet])
    edges = SolverSettings(max_reflections=2, diffraction=True)
    rng = np.random.default_rng(4)
    poses = np.column_stack([rng.uniform(LOW, HIGH, (150, 2)), rng.uniform(-4.0, 4.0, 150)])
    true = link_of(furnished, solver=edges).rss_w(poses)
    with_edges, without = (
        map_error(map_of(furnished, solver=solver), true, poses) for solver in (edges, SOLVER)
    )
    assert with_edges.under_db > 15.0
    assert without.under_db < 10.0


def test_at_a_place_of_the_map_only_codes_round(scene):
    found = map_of(scene)
    heading = 2.0 * np.pi / found.levels.shape[-1] * 5
    poses = np.array([[found.x_m[i], found.y_m[j], heading] for i, j in ((3, 7), (40, 21))])
    exact = link_of(scene).rss_w(poses)
    strong = exact > 1e-3 * exact.max()
    error_db = 10.0 * np.log10(found.rss_w(poses) / exact)[strong]
    # Amplitudes are interpolated between traced places.
    assert np.abs(error_db).max() < 0.125 + 0.25


def test_antennas_of_a_symmetric_ring_share_a_row_and_others_do_not(scene, poses):
    odd = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    assert antennas_alike(response_at(CARRIER_HZ)) == 1
    assert antennas_alike(response_at(CARRIER_HZ, odd)) == 5
    found = map_of(scene, azimuths=odd)
    assert found.levels.shape[3] == 5
    error = map_error(found, link_of(scene, azimuths=odd).rss_w(poses), poses)
    assert error.share < 0.01


def test_the_error_field_is_found_in_size():
    """Readings with an independent field of known power over a uniform map give that power back."""
    rng = np.random.default_rng(1)
    flat = {"levels": np.full((1, 2, 2, 1, 8), 200), "means": np.full((1, 2, 2, 1, 8), 200)}
    edge = np.array([0.0, 1.0])
    grid = {"x_m": edge, "y_m": edge, "node_x_m": edge, "node_y_m": edge}
    one = FieldMap(**grid, **flat, ring=np.zeros(8, int), shift_rad=RING, top_dbm=np.array([0.0]))
    poses = np.zeros((3000, 3))
    here = one.rss_w(poses)
    for share in (0.01, 0.1):
        noise = rng.standard_normal((2, *here.shape)) * np.sqrt(0.5 * share)
        true = here * ((1.0 + noise[0]) ** 2 + noise[1] ** 2)
        error = map_error(one, true, poses)
        # On a uniform map share and floor are the same; f(2 - f) is 1.6 times too much for small f.
        found = error.share + error.floor_w / one.local_mean_w(poses[:1])[0, 0]
        assert found == pytest.approx(share, rel=0.45)
    double = joined([one, one])
    assert double.rss_w(poses[:1], tag=1) == pytest.approx(one.rss_w(poses[:1]))
    with pytest.raises(GeometryError, match="one grid"):
        joined([one, replace(one, x_m=2.0 * edge)])


def test_a_plan_says_what_it_takes():
    plan = plan_map((0.0, 0.0), (7.0, 7.0), wavelength_m=0.125, spacing_m=0.03)
    assert np.diff(plan.x_m).max() <= 0.03
    assert plan.nbytes(2) < 10e6
    assert plan.nbytes(8) < 60e6


@pytest.mark.parametrize("channels_hz", [(CARRIER_HZ,), (2.40e9, 2.42e9, 2.44e9)])
def test_a_tag_that_hangs_elsewhere_is_heard_as_the_solver_says(scene, poses, channels_hz):
    """The error field of tags up to 9 cm beside their place is 20 dB below the local mean."""
    radios, responses, _ = at_channels(scene, channels_hz)
    plan = plan_map(LOW, HIGH, wavelength_m=radios[-1].wavelength_m)
    paths = paths_of(scene, channels_hz, plan=plan).strongest()
    sent = {"tag_power_w": 0.5, "reader_z_m": READER_Z_M}
    found = make_path_map(paths, radios, responses, plan, **sent)
    offsets = np.array([[0.0, 0.0, 0.0], [0.05, -0.06, 0.04], [-0.03, 0.02, -0.08]])
    power = found.shifted_w(poses, offsets)
    for k, offset in enumerate(offsets):
        link = link_of(scene, channels_hz, tag=tuple(np.array(TAG) + offset))
        error = power[:, k] - link.rss_w(poses)
        mean = link.power(poses).local_mean_w
        # Of two fields whose difference has the share s, powers differ by sqrt(2 s) of the mean.
        assert np.sqrt(np.mean((error / mean) ** 2)) < 0.2


def test_poses_close_to_one_another_read_as_each_does_alone(scene):
    """What poses within 5 cm share changes their power by 2 % of its mean."""
    radios, responses, _ = at_channels(scene, (CARRIER_HZ,))
    plan = plan_map(LOW, HIGH, wavelength_m=radios[0].wavelength_m)
    paths = paths_of(scene, plan=plan).strongest()
    sent = {"tag_power_w": 0.5, "reader_z_m": READER_Z_M}
    found = make_path_map(paths, radios, responses, plan, **sent)
    rng = np.random.default_rng(5)
    near = np.array([-0.4, -0.6, 0.3]) + rng.uniform(-1.0, 1.0, (40, 3)) * [0.02, 0.02, 0.5]
    offsets = 0.05 * rng.standard_normal((20, 3))
    together = found.shifted_w(near, offsets)
    alone = np.concatenate([found.shifted_w(pose[None], offsets) for pose in near])
    assert np.sqrt(np.mean((together - alone) ** 2)) < 0.025 * np.mean(alone)
