"""Framed slotted Aloha as in EPC Gen2: throughput, times of slots, how soon tags are read."""

import math

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.sensing.inventory import (
    POWER_UP_S,
    Gen2,
    ReadRates,
    aloha_throughput,
    read_probability,
    read_rates,
    round_s,
)

FAST = Gen2(tari_s=6.25e-6, blf_hz=640e3, miller=1)


@pytest.mark.parametrize("tags", [1, 2, 5, 30, 1000])
def test_throughput_is_greatest_for_as_many_slots_as_tags(tags):
    slots = np.arange(1, 4 * tags + 3)
    throughput = aloha_throughput(tags, slots)
    assert throughput.max() == pytest.approx(throughput[tags - 1])
    assert throughput.max() >= 1.0 / math.e
    assert aloha_throughput(10**7, 10**7) == pytest.approx(1.0 / math.e, rel=1e-6)


def test_throughput_is_the_share_of_slots_with_one_tag():
    rng = np.random.default_rng(1)
    for tags, slots in ((8, 8), (20, 8), (3, 16)):
        drawn = rng.integers(slots, size=(40_000, tags))
        alone = sum((drawn == slot).sum(axis=1) == 1 for slot in range(slots)).mean() / slots
        assert alone == pytest.approx(float(aloha_throughput(tags, slots)), rel=0.02)


def test_slots_take_what_the_protocol_says():
    # Tari 25 us, ones of 50 us, BLF 160 kHz, FM0: RTcal 75 us, TRcal 64/3/160 kHz = 133.33 us;
    # T1 = 75 us (10/BLF = 62.5), T2 = T3 = 62.5 us; a tag's bit 6.25 us.
    slow = Gen2(tari_s=25e-6, one_per_zero=2.0, blf_hz=160e3, miller=1)
    query = 12.5 + 25 + 75 + 133.3333 + 22 * 37.5
    assert slow.command_s(22, first=True) == pytest.approx(query * 1e-6, rel=1e-6)
    assert slow.command_s(4) == pytest.approx((12.5 + 25 + 75 + 4 * 37.5) * 1e-6)
    assert slow.slot_s(0) == pytest.approx((75 + 62.5) * 1e-6)
    collided = 75 + (6 + 16 + 1) * 6.25 + 62.5
    assert slow.slot_s(2) == slow.slot_s(7) == pytest.approx(collided * 1e-6)
    ack = 12.5 + 25 + 75 + 18 * 37.5
    read = collided + ack + 75 + (6 + 128 + 1) * 6.25 + 62.5
    assert slow.slot_s(1) == pytest.approx(read * 1e-6)
    # a lone tag in a frame of one slot is read in the first slot
    alone = Gen2(tari_s=25e-6, blf_hz=160e3, miller=1, q=0)
    assert round_s(alone, 1) == pytest.approx(POWER_UP_S + (query + read) * 1e-6, rel=1e-6)
    subcarrier = Gen2(miller=4, pilot=True)  # 22 bits of preamble, 4 cycles a bit
    assert subcarrier.answer_s(16) == pytest.approx((22 + 16 + 1) * 4 / 250e3)


def test_two_tags_in_two_slots_are_both_read_in_the_first_frame_half_the_time():
    protocol = Gen2(q=1, q_step=0.1)
    frame = POWER_UP_S + protocol.command_s(22, first=True) + protocol.command_s(4)
    frame += 2.0 * protocol.slot_s(1)
    rng = np.random.default_rng(2)
    last = np.array([protocol.read_times_s(2, rng)[-1] for _ in range(4000)])
    share = np.isclose(last, frame, rtol=1e-9).mean()
    assert share == pytest.approx(0.5, abs=0.03)


def test_the_q_algorithm_is_about_as_fast_as_frames_of_the_best_size():
    # with as many slots as tags, each read tag costs 1 empty slot and e - 2 collisions
    repeat = FAST.command_s(4)
    best = FAST.slot_s(1) + repeat
    best += (FAST.slot_s(0) + repeat) + (math.e - 2.0) * (FAST.slot_s(2) + repeat)
    assert 0.95 * best < round_s(FAST, 200) / 200 < 1.2 * best
    assert 900 < 200 / round_s(FAST, 200) < 1400  # readers' fastest modes: about 1000 tags a second


def test_more_tags_are_read_later_and_more_time_reads_more():
    protocol = Gen2()
    shares = [[read_probability(protocol, n, t) for t in (0.005, 0.02, 0.1)] for n in (1, 5, 40)]
    assert (np.diff(shares, axis=1) >= 0.0).all()
    assert (np.diff(shares, axis=0) <= 0.0).all()
    assert read_probability(protocol, 40, 10.0) == 1.0
    assert read_probability(protocol, 1, POWER_UP_S) == 0.0
    rates = read_rates(protocol, 3, 0.02, others=2)
    assert rates.of([0, 1, 3]).tolist() == [
        0.0,
        read_probability(protocol, 3, 0.02),
        read_probability(protocol, 5, 0.02),
    ]


def test_equal_arguments_give_equal_times():
    first, second = (FAST.read_times_s(9, np.random.default_rng(4)) for _ in range(2))
    assert (first == second).all()
    assert (np.diff(first) > 0.0).all()
    assert first.size == 9


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"tari_s": 6.25e-6, "blf_hz": 40e3}, "must last 20.63 to 56.25"),
        ({"tari_s": 25e-6, "blf_hz": 640e3}, "640 kHz"),
        ({"q_step": 0.0}, "0.1 to 0.5"),
        ({"q": 16}, "0 to 15"),
    ],
)
def test_what_the_protocol_does_not_allow_is_refused(wrong, words):
    with pytest.raises(NavigationError, match=words):
        Gen2(**wrong)


def test_rates_do_not_change():
    rates = ReadRates(probability=np.array([0.9, 0.5]))
    with pytest.raises(ValueError, match="read-only"):
        rates.probability[0] = 1.0
