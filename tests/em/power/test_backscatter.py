"""Backscatter: Friis' equation both ways, who sends, when tags answer, through a room and back."""

import math
from dataclasses import replace

import numpy as np
import pytest

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.backscatter import BackscatterBudget, BackscatterLink, FixedGain, answers
from octant.em.power.radio_map import map_backscatter
from octant.em.power.received_power import ReceivedPower, antenna_power, reader_link
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.errors import AntennaError
from octant.geometries.scene import free_space_scene

TAG = np.array([1.0, 2.0, 2.5])
UP = 1.9
BUDGET = BackscatterBudget(sent_w=2.0, forward=0.8, backward=0.2, wakes_w=1e-5, decodes_w=1e-11)


def isotropic_reader(frequency_hz):
    pattern = np.zeros((1, 2, 13, 24), dtype=np.complex128)
    pattern[:, 0] = 1.0
    return ReaderResponse(
        model="isotropic",
        frequency_hz=frequency_hz,
        azimuths_rad=np.zeros(1),
        phase_centres_m=np.zeros((1, 3)),
        pattern=pattern,
    )


def way(scene, frequency_hz, order=0):
    return reader_link(
        radio_scene(scene, frequency_hz),
        tag_position_m=TAG,
        tag_antenna=make_antenna("dipole", frequency_hz),
        tag_power_w=1.0,
        response=isotropic_reader(frequency_hz),
        reader_height_m=TAG[2] - UP,
        solver=SolverSettings(max_reflections=order),
    )


def friis(distance_m, frequency_hz):
    """Gain between an isotropic antenna and an upright half-wave dipole UP metres above it."""
    slant = np.hypot(distance_m, UP)
    cosine = UP / slant
    # the dipole's directivity 2 / (2/2 integral), by quadrature of its own
    t = np.linspace(0.0, math.pi, 200_001)[1:-1]
    power = (np.cos(0.5 * math.pi * np.cos(t)) / np.sin(t)) ** 2
    peak = 2.0 / np.trapezoid(power * np.sin(t), t)
    shape = (np.cos(0.5 * math.pi * cosine)) ** 2 / (1.0 - cosine**2)
    wavelength = 299_792_458.0 / frequency_hz
    return peak * shape * (wavelength / (4.0 * math.pi * slant)) ** 2


@pytest.mark.parametrize("frequency_hz", [868e6, 915e6, 2.45e9])
def test_free_space_is_friis_equation_both_ways(frequency_hz):
    link = BackscatterLink(ways=(way(free_space_scene(), frequency_hz),), budget=BUDGET)
    distance = np.array([0.5, 1.0, 3.0, 8.0, 20.0, 60.0])
    poses = np.column_stack((TAG[0] + distance, np.full(6, TAG[1]), np.linspace(0.0, 5.0, 6)))
    found = link.answers(poses)
    gain = friis(distance, frequency_hz)
    np.testing.assert_allclose(found.chip_w[:, 0], 2.0 * 0.8 * gain, rtol=1e-9)
    returned = 2.0 * 0.2 * gain**2
    reads = (1.6 * gain >= 1e-5) & (returned >= 1e-11)
    assert 0 < reads.sum() < 6
    np.testing.assert_array_equal(found.read[:, 0], reads)
    np.testing.assert_allclose(found.rss.coherent_w[:, 0], np.where(reads, returned, 0), rtol=1e-9)
    np.testing.assert_allclose(found.margin[:, 0], 1.6 * gain / 1e-5, rtol=1e-9)
    awake = link.always_awake().rss_w(poses)[:, 0]
    np.testing.assert_allclose(awake, returned, rtol=1e-9)
    assert (gain >= BUDGET.least_gain()).tolist() == reads.tolist()


@pytest.mark.filterwarnings("ignore:material 'concrete' is extrapolated")
def test_in_a_room_the_wave_comes_back_the_way_it_went(box_scene):
    link = BackscatterLink(ways=(way(box_scene, 868e6, order=2),), budget=BUDGET).always_awake()
    place = np.array([3.2, 4.1, TAG[2] - UP])
    radio = radio_scene(box_scene, 868e6)
    forth = antenna_power(
        radio,
        search_candidates(radio, place, SolverSettings(max_reflections=2)),
        TAG[None],
        transmitter=make_antenna("isotropic_theta", 868e6),
        receiver=make_antenna("dipole", 868e6),
        power_w=2.0,
    ).coherent_w[0]
    found = link.answers([[*place[:2], 0.7]])
    assert found.chip_w[0, 0] == pytest.approx(0.8 * forth, rel=1e-9)
    assert found.rss.coherent_w[0, 0] == pytest.approx(0.2 * forth**2 / 2.0, rel=1e-9)
    assert found.rss.path_count[0] > 5
    by_heading = link.power_by_heading(place[None, :2], [0.7]).coherent_w
    assert by_heading[0, 0, 0] == found.rss.coherent_w[0, 0]
    power, maps = map_backscatter(link, x_m=[3.2], y_m=[4.1, 1.0], heading_rad=0.7)
    assert power.coherent_w.shape == maps.chip_w.shape == (1, 2, 1)
    assert maps.chip_w[0, 0, 0] == found.chip_w[0, 0]


def gains(*rows):
    coherent = np.array(rows)
    return ReceivedPower(coherent, 0.5 * coherent, np.ones(len(rows), dtype=np.int64))


G = [4e-6, 1e-6, 2e-6]


@pytest.mark.parametrize(
    ("sender", "there"),
    [("each", G), ("strongest", [4e-6] * 3), ("separate", [3e-6] * 3)],
)
def test_who_sends_decides_what_the_chip_gets(sender, there):
    budget = replace(BUDGET, wakes_w=0.0, decodes_w=0.0)
    found = answers([gains(G)], budget, sender=sender, separate=[gains([3e-6])])
    np.testing.assert_allclose(found.chip_w[0], 1.6 * np.array(there))
    np.testing.assert_allclose(found.rss.coherent_w[0], 0.4 * np.array(there) * G)
    np.testing.assert_allclose(found.chip_mean_w, 0.5 * found.chip_w)
    np.testing.assert_allclose(found.rss.local_mean_w, 0.25 * found.rss.coherent_w)


def test_a_tag_answers_from_its_threshold_on_and_not_below():
    chip_w, back_w = 2.0 * 0.8 * 1e-6, 2.0 * 0.2 * 1e-6 * 1e-6
    for wakes_w, read in ((chip_w, True), (chip_w * (1 + 1e-12), False)):
        found = answers([gains([1e-6])], replace(BUDGET, wakes_w=wakes_w, decodes_w=0.0))
        assert found.read.all() == read
        assert (found.rss.coherent_w > 0.0).all() == read
    for decodes_w, read in ((back_w, True), (back_w * (1 + 1e-12), False)):
        found = answers([gains([1e-6])], replace(BUDGET, wakes_w=0.0, decodes_w=decodes_w))
        assert found.read.all() == read
    nothing = answers([gains([0.0])], replace(BUDGET, wakes_w=0.0, decodes_w=0.0))
    assert not nothing.read.any()


def test_rss_is_the_mean_over_the_channels_on_which_the_tag_answers():
    budget = replace(BUDGET, wakes_w=1.6e-6, decodes_w=0.0)
    found = answers([gains([4e-6, 0.5e-6]), gains([2e-6, 0.1e-6]), gains([0.9e-6, 0.2e-6])], budget)
    assert found.rss.coherent_w[0, 0] == pytest.approx(0.4 * (16e-12 + 4e-12) / 2)
    assert found.rss.coherent_w[0, 1] == 0.0
    np.testing.assert_allclose(found.chip_w[0], 1.6 * np.array([6.9e-6, 0.8e-6]) / 3)
    np.testing.assert_allclose(found.margin[0], [4.0, 0.5])


def test_an_antenna_in_the_room_sends_alike_for_every_pose():
    fixed = FixedGain(coherent=1e-6, local_mean=2e-6)
    link = BackscatterLink(
        ways=(way(free_space_scene(), 868e6),),
        budget=replace(BUDGET, wakes_w=1e-9, decodes_w=0.0),
        sender="separate",
        separate=(fixed,),
    )
    found = link.answers([[2.0, 2.0, 0.0], [5.0, 2.0, 1.0]])
    np.testing.assert_allclose(found.chip_w, 1.6e-6)
    ratio = found.rss.coherent_w[0, 0] / found.rss.coherent_w[1, 0]
    assert ratio == pytest.approx(friis(1.0, 868e6) / friis(4.0, 868e6), rel=1e-9)
    assert link.answers_by_heading([[2.0, 2.0]], [0.0, 1.0]).chip_w.shape == (1, 2, 1)


@pytest.mark.parametrize("wrong", [{"sent_w": 0.0}, {"forward": 0.0}, {"backward": 1.1}])
def test_a_budget_that_no_passive_tag_has_is_refused(wrong):
    with pytest.raises(AntennaError, match="shares between 0 and 1"):
        replace(BUDGET, **wrong)
    with pytest.raises(AntennaError, match="separate"):
        answers([gains(G)], BUDGET, sender="separate")
