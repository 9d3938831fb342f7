"""Tags in patterns, tags in range, and RSS that the tags themselves measure (thesis 4.6.2)."""

import math

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.sensing.rss_models import tag_grid
from octant.navigation.sensing.tag_frames import Hearing, Polling, RssCodes
from octant.navigation.sensing.tag_layouts import PATTERNS, patterned_tags, tags_heard


def tags(pattern, count, field_m=12.0, seed=1):
    rng = np.random.default_rng(seed)
    return patterned_tags(pattern, count, field_m=field_m, height_m=3.0, rng=rng)


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("count", [1, 4, 25])
def test_every_pattern_stays_in_its_field(pattern, count):
    found = tags(pattern, count)
    assert found.shape == (count, 3)
    assert (np.abs(found[:, :2]) <= 6.0 + 1e-12).all()
    assert (found[:, 2] == 3.0).all()


def test_a_mesh_is_the_grid_a_circle_is_round_and_a_line_is_even():
    assert (tags("mesh", 25) == tag_grid(5, spacing_m=3.0, height_m=3.0)).all()
    assert np.hypot(*tags("circle", 7)[:, :2].T) == pytest.approx(np.full(7, 6.0))
    assert np.diff(tags("line", 5)[:, 0]) == pytest.approx(np.full(4, 3.0))
    assert (tags("random", 5) == tags("random", 5)).all()
    assert not (tags("random", 5)[:, :2] == tags("random", 5, seed=2)[:, :2]).any()


@pytest.mark.parametrize(
    ("pattern", "count", "match"),
    [("mesh", 5, "give 4 or 9"), ("ring", 4, "one of"), ("line", 0, "at least one")],
)
def test_tags_that_cannot_hang_so_are_refused(pattern, count, match):
    with pytest.raises(NavigationError, match=match):
        tags(pattern, count)


def test_the_thesis_mesh_does_not_ensure_nine_tags_within_the_calibration():
    mesh = tag_grid(3, spacing_m=3.0, height_m=3.0)
    starts = [(-3.5, -4.0), (0.0, 0.0)]
    by_hand = [sum(math.dist((*p, 0.0), tag) <= 6.18 for tag in mesh.tolist()) for p in starts]
    assert tags_heard(starts, mesh, range_m=6.18).tolist() == by_hand == [4, 9]


def test_a_code_is_a_whole_decibel_below_a_milliwatt_as_the_xbee_sends_it():
    codes = RssCodes()
    assert codes.step_db == 1.0
    assert codes.coded(np.array([-47.0, -62.4, -62.6, -300.0, 9.0, np.nan])) == pytest.approx(
        np.array([-47.0, -62.0, -63.0, -255.0, 0.0, np.nan]), nan_ok=True
    )


def test_a_frame_of_24_bits_holds_identity_and_code():
    codes = RssCodes()
    frame = codes.frame(0x5003, int(codes.codes(-47.0)))
    assert frame == 0x5003 * 256 + 208
    assert frame < 2**24
    assert codes.parts(frame) == (0x5003, 208)
    with pytest.raises(NavigationError, match="16 and 8 bits"):
        codes.frame(0xFFFF9, 0)  # as thesis 6.2 prints it


def test_a_round_is_the_question_and_a_frame_of_each_tag():
    polling = Polling(tags=9, bit_rate_hz=9600.0, turnaround_s=0.002)
    assert polling.round_s == pytest.approx((16 + 9 * 24) / 9600.0 + 9 * 0.002)
    counts = np.zeros(9, int)
    for k in range(1000):
        counts += polling.heard(0.04 * k, 0.04 * (k + 1))
    replies = polling.replies(40.0)
    assert replies[-1] == math.floor(40.0 / polling.round_s)
    assert (counts == replies).all()  # a round is longer than a period: none is lost
    slow = Polling(tags=4, bit_rate_hz=480.0)  # 1/30 s for the question, 1/20 s for each frame
    order = [np.flatnonzero(slow.heard(0.05 * k, 0.05 * (k + 1))).tolist() for k in range(6)]
    assert order == [[], [0], [1], [2], [3], []]


def test_what_is_out_of_range_is_not_heard():
    mesh = tag_grid(3, spacing_m=3.0, height_m=3.0)
    hearing = Hearing(tags_m=mesh, range_m=4.0, codes=RssCodes())
    heard = hearing.heard(np.zeros((1, 3)), np.full((1, 9), -50.3))[0]
    near = np.linalg.norm(mesh, axis=1) <= 4.0
    assert (~np.isnan(heard) == near).all()
    assert (heard[near] == -50.0).all()
