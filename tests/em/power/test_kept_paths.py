"""Fields along kept paths are those of the full solver, whatever the materials and antennas."""

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.materials import Material, material
from octant.em.power.kept_paths import arriving_fields, keep_paths, with_materials
from octant.em.power.received_power import antenna_power, reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings, radio_scenes, search_candidates
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError, MaterialRangeError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

F = 2.4e9
TAG = (0.7, 1.1, 2.1)
SOLVER = SolverSettings(max_reflections=2, diffraction=True, transmission=True)
BOARD = {"name": "board", "eps_r_a": 2.73, "sigma_c_s_per_m": 0.02}
FIRST = Material(**BOARD, thickness_m=0.06)
OTHER = Material(name="board", eps_r_a=4.4, sigma_c_s_per_m=0.3, thickness_m=0.11)


@pytest.fixture(scope="module")
def divided():
    """A room of 4 m by 3 m with a thin wall that ends in the open."""
    corners = np.array([(2.0, 0.0, 0.0), (2.0, 1.9, 0.0), (2.0, 1.9, 2.5), (2.0, 0.0, 2.5)])
    wall = Body(
        name="wall", vertices_m=corners, faces=np.array([(0, 1, 2), (0, 2, 3)]), material="w"
    )
    scene = build_scene(box_room((4.0, 3.0, 2.5), material="c"), objects=[wall])
    materials = {"w": FIRST, "c": material("concrete")}
    return radio_scenes(scene, [F], SOLVER, materials)[0]


@pytest.fixture(scope="module")
def candidates(divided):
    return search_candidates(divided, TAG, SOLVER)


@pytest.fixture(scope="module")
def places():
    return np.random.default_rng(3).uniform((0.2, 0.2, 0.3), (3.8, 2.8, 1.6), (12, 3))


@pytest.fixture(scope="module")
def kept(divided, candidates, places):
    return keep_paths(divided, candidates, places)


def resolved(divided, wall, floor="concrete"):
    """The same scene solved from the start with other materials."""
    return radio_scenes(divided.scene, [F], SOLVER, {"w": wall, "c": material(floor)})[0]


@pytest.mark.parametrize("antenna", ["dipole", "patch"])
def test_other_materials_and_tilts_along_kept_paths_are_those_of_the_full_solver(
    divided, kept, places, antenna
):
    tilted = make_antenna(antenna, F, axis=(0.3, -0.2, 1.0))
    receiver = make_antenna("isotropic_theta", F, axis=(0.1, 0.0, 1.0))
    radio = resolved(divided, OTHER, "brick")
    want = antenna_power(
        radio,
        search_candidates(radio, TAG, SOLVER),
        places,
        transmitter=tilted,
        receiver=receiver,
        power_w=0.1,
    )
    changed = with_materials(divided, {"w": OTHER, "c": material("brick")})
    got = arriving_fields(changed, kept, transmitter=tilted).at_antenna(receiver, 0.1)
    assert np.array_equal(got.path_count, want.path_count)
    assert got.path_count.min() > 20
    np.testing.assert_allclose(got.coherent_w, want.coherent_w, rtol=1e-10)  # a fade cancels digits
    np.testing.assert_allclose(got.local_mean_w, want.local_mean_w, rtol=1e-12)


def test_a_readers_antennas_weigh_kept_paths_as_the_link_does(divided, places):
    height_m = 0.9
    level = np.column_stack((places[:, :2], np.full(len(places), height_m)))
    headings = np.linspace(0.0, 6.0, len(places))
    response = sector_response(2.0 * np.pi * np.arange(5) / 5.0, frequency_hz=F)
    tag = make_antenna("dipole", F, axis=(0.2, 0.0, 1.0))
    link = reader_link(
        divided,
        tag_position_m=TAG,
        tag_antenna=tag,
        tag_power_w=2.0,
        response=response,
        reader_height_m=height_m,
        solver=SOLVER,
    )
    want = link.power(np.column_stack((level[:, :2], headings)))
    kept = keep_paths(divided, search_candidates(divided, TAG, SOLVER), level)
    got = arriving_fields(divided, kept, transmitter=tag).at_reader(response, headings, 2.0)
    np.testing.assert_allclose(got.coherent_w, want.coherent_w, rtol=1e-10)
    np.testing.assert_allclose(got.local_mean_w, want.local_mean_w, rtol=1e-12)


def test_what_is_left_out_is_bounded_by_what_is_said(divided, candidates, places, kept):
    thin = keep_paths(divided, candidates, places, least_share=1e-3)
    source = make_antenna("isotropic_theta", F)
    power = [
        np.add.reduceat(np.sum(np.abs(one.field) ** 2, axis=1), one.first[:-1])
        for one in (arriving_fields(divided, k, transmitter=source) for k in (kept, thin))
    ]
    assert 0.0 < thin.left_out < 0.2
    assert len(thin) < 0.8 * len(kept)
    assert kept.left_out == 0.0
    assert np.all(power[1] <= power[0])
    # The share counts two polarisations of the source; one of them alone loses at most this.
    assert np.all(power[0] - power[1] <= 0.2 * power[0])


def test_places_without_a_path_receive_nothing():
    direct = SolverSettings(max_reflections=0)
    cabinet = box((1.0, 1.0, 1.0), position_m=(1.0, 1.0, 0.0), material="metal")
    scene = build_scene(box_room((3.0, 3.0, 3.0), material="metal"), objects=[cabinet])
    radio = radio_scenes(scene, [F], direct)[0]
    places = np.array([(0.4, 0.3, 0.5), (2.9, 1.5, 0.5), (2.9, 2.9, 2.9)])
    kept = keep_paths(radio, search_candidates(radio, (0.1, 1.5, 0.5), direct), places)
    dipole = make_antenna("dipole", F)
    got = arriving_fields(radio, kept, transmitter=dipole).at_antenna(dipole, 1.0)
    assert got.path_count.tolist() == [1, 0, 1]
    assert (got.local_mean_w > 0.0).tolist() == [True, False, True]
    none = keep_paths(radio, search_candidates(radio, (0.1, 1.5, 0.5), direct), places[:0])
    assert len(none) == 0
    nothing = arriving_fields(radio, none, transmitter=dipole).at_antenna(dipole, 1.0)
    assert nothing.coherent_w.shape == (0,)


def test_a_change_that_makes_other_paths_is_refused(divided):
    with pytest.raises(GeometryError, match=r"from a slab to a half-space.*trace them anew"):
        with_materials(divided, {"w": Material(**BOARD)})
    with pytest.raises(GeometryError, match="to a perfect conductor"):
        with_materials(divided, {"c": material("pec")})
    with pytest.raises(MaterialRangeError, match="has no material 'roof'; its materials are"):
        with_materials(divided, {"roof": FIRST})
