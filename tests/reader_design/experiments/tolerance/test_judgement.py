"""Yields, slopes and rankings from made-up scores whose answers are known."""

from dataclasses import replace

import numpy as np
import pytest

from octant.geometries.errors import SweepStateError
from octant.navigation.statistics import Interval, wilson
from octant.reader_design.experiments.tolerance.cases import CaseScores
from octant.reader_design.experiments.tolerance.ranking import (
    RoomRss,
    confidence_sentence,
    wins,
    wins_over_places,
)
from octant.reader_design.experiments.tolerance.sensitivity import Parameter, slopes
from octant.reader_design.experiments.tolerance.views import (
    View,
    limit_texts,
    meets,
    values_of,
    views,
)
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.study_file.tolerance import Limits

ELEMENTS = np.arange(8) * np.pi / 4
AZIMUTHS = np.arange(32) * np.pi / 16
PERFECT = score_rss(
    1e-6 * np.exp(2.0 * np.cos(AZIMUTHS[:, None] - ELEMENTS))[None], AZIMUTHS, ELEMENTS
)
FAILED = CaseScores(reason="gap_m of antenna 1 would be 0 m")


def case(level=(-30.0, -31.0), **changes):
    return CaseScores(free=replace(PERFECT, **changes), levels_dbm=level)


def test_a_reader_is_good_when_every_limit_is_met():
    good = case(margin_worst_db=2.0, vector_rms_rad=np.radians(1.0), front_to_back_mean_db=12.0)
    limits = {
        "least_right_share": (0.99, 1.01),
        "least_margin_db": (1.9, 2.1),
        "most_vector_rms_deg": (1.1, 0.9),
        "least_front_to_back_db": (11.0, 13.0),
        "least_level_dbm": (-31.5, -30.5),
    }
    assert meets(Limits(), good)
    for name, (met, missed) in limits.items():
        assert meets(Limits(**{name: met}), good)
        assert not meets(Limits(**{name: missed}), good)
    assert not meets(Limits(least_right_share=None), FAILED)
    assert limit_texts(Limits(least_margin_db=2.0))[1] == "worst margin at least 2 dB"


def test_the_yield_of_uniform_margins_is_their_share_above_the_limit():
    margins = np.random.default_rng(1).uniform(0.0, 4.0, 4000)
    good = sum(meets(Limits(least_margin_db=1.0), case(margin_worst_db=m)) for m in margins)
    interval = wilson(good, margins.size)
    assert interval.low < 0.75 < interval.high
    assert interval.high - interval.low < 0.03


def test_values_are_read_in_the_units_of_their_views():
    shown = views((1.0, 2.0), room=False)
    row = values_of(shown, (case(vector_rms_rad=0.02), FAILED))
    named = dict(zip((v.name for v in shown), row[0], strict=True))
    assert named["vector_rms_deg"] == pytest.approx(np.degrees(0.02))
    assert named["level_2m_dbm"] == -31.0
    assert np.isnan(row[1]).all()


PARAMETER = Parameter(name="p", field="gap_m", unit="mm", per_unit=1e-3, step=0.2)
MARGIN = View(
    name="margin_worst_db", title="margin", unit="dB", where="free", field="margin_worst_db"
)


def slope_of(law):
    amounts = (0.0, -0.2, 0.2, -0.1, 0.1)
    return slopes((PARAMETER,), (MARGIN,), tuple(case(margin_worst_db=law(x)) for x in amounts))[0]


def test_slopes_of_a_parabola_are_its_derivative():
    slope = slope_of(lambda x: 1.0 + 3.0 * x - 0.5 * x**2)
    assert slope.central == pytest.approx(3.0, abs=1e-12)
    assert slope.up == pytest.approx(3.0 - 0.05, abs=1e-12)
    assert slope.down == pytest.approx(3.0 + 0.05, abs=1e-12)
    assert slope.doubt < 1e-12
    assert not slope.bends
    assert slope.unit == "dB/mm"


def test_the_doubt_of_a_cubic_is_its_third_order():
    slope = slope_of(lambda x: 2.0 * x + 5.0 * x**3)
    assert slope.doubt == pytest.approx(5.0 * (0.2**2 - 0.1**2), rel=1e-12)


def test_the_worst_of_two_directions_bends():
    slope = slope_of(lambda x: 1.0 + min(2.0 * x, -1.0 * x))
    assert slope.bends
    assert (slope.up, slope.down) == (pytest.approx(-1.0), pytest.approx(2.0))
    assert not slope_of(lambda x: 1.0 + x**2).bends


def test_a_reader_that_cannot_be_built_has_no_slope():
    results = (case(), FAILED, case(), case(), case())
    slope = slopes((PARAMETER,), (MARGIN,), results)[0]
    assert np.isnan(slope.doubt)
    assert not slope.bends


def test_wins_are_counted_pair_by_pair():
    base = [1.0, 2.0, 3.0, 4.0]
    first = [case(margin_worst_db=m + 1.0) for m in base]
    second = [case(margin_worst_db=m) for m in base]
    assert wins(first, second) == wilson(4, 4)
    assert wins(second, first) == wilson(0, 4)
    assert wins(first, first) == wilson(2.0, 4)
    assert wins([*first[:3], FAILED], second) == wilson(3, 4)
    assert wins([*first[:3], FAILED], [*second[:3], FAILED]) == wilson(3.5, 4)


def test_wins_follow_the_order_of_the_criteria():
    better_share = [case(right_share=1.0, margin_worst_db=0.0)]
    better_margin = [case(right_share=0.9, margin_worst_db=9.0)]
    assert wins(better_share, better_margin).value == 1.0


def test_the_chance_of_the_better_of_two_normal_scores_is_found():
    random = np.random.default_rng(2)
    # Differences of margins beyond the choice's tolerance of 0.5 dB decide; then the level does.
    a = [
        case(margin_worst_db=20.0 + 10.0 * x, level_median_dbm=0.0) for x in random.normal(size=900)
    ]
    b = [
        case(margin_worst_db=10.0 + 10.0 * x, level_median_dbm=0.0) for x in random.normal(size=900)
    ]
    interval = wins(a, b)
    assert interval.low < 0.7602 < interval.high  # Phi(1 / sqrt 2)


def test_unpaired_samples_are_refused():
    with pytest.raises(SweepStateError, match="2 and 1 samples cannot be compared"):
        wins([case(), case()], [case()])
    with pytest.raises(SweepStateError, match="0 and 0"):
        wins([], [])


def room(power, places=12):
    pattern = np.exp(power * np.cos(AZIMUTHS[:, None] - ELEMENTS))
    rss = 1e-6 * np.broadcast_to(pattern, (places, *pattern.shape))
    return RoomRss(rss_w=rss, azimuths_rad=AZIMUTHS, element_azimuths_rad=ELEMENTS)


def test_a_design_that_is_better_at_every_place_wins_every_draw_of_places():
    random = np.random.default_rng(3)
    right = (case(), room(2.0))
    wrong = (case(), replace(room(2.0), rss_w=np.roll(room(2.0).rss_w, 1, axis=2)))
    assert wins_over_places(right, wrong, random=random, resamples=20).value == 1.0
    assert wins_over_places(wrong, right, random=random, resamples=20).value == 0.0
    assert wins_over_places(right, right, random=random, resamples=20).value == 0.5
    with pytest.raises(SweepStateError, match="probed at 12 and 5 places"):
        wins_over_places(right, (case(), room(2.0, places=5)), random=random)


def test_a_design_that_one_place_decides_wins_as_often_as_that_place_is_drawn():
    good, bad = room(2.0, 10).rss_w, room(2.0, 10).rss_w
    mixed = RoomRss(
        rss_w=np.concatenate((good[:1], np.full_like(bad[1:], 1e-9))),
        azimuths_rad=AZIMUTHS,
        element_azimuths_rad=ELEMENTS,
    )
    flat = RoomRss(
        rss_w=np.full_like(bad, 1e-9), azimuths_rad=AZIMUTHS, element_azimuths_rad=ELEMENTS
    )
    random = np.random.default_rng(4)
    share = wins_over_places((case(), mixed), (case(), flat), random=random, resamples=300).value
    drawn = 1.0 - 0.9**10  # else both receive the same everywhere: one half
    assert share == pytest.approx(drawn + 0.5 * (1.0 - drawn), abs=0.05)


def test_the_sentence_says_what_the_interval_says():
    sure = confidence_sentence(
        Interval(value=0.93, low=0.86, high=0.97), better="A", worse="B", samples=100
    )
    assert sure == "With 93 % (86 to 97) confidence A is better than B (100 built readers)."
    unsure = Interval(value=0.55, low=0.45, high=0.64)
    text = confidence_sentence(unsure, better="A", worse="B", samples=9)
    assert text.endswith("That does not tell them apart.")
    wrong = Interval(value=0.1, low=0.05, high=0.2)
    text = confidence_sentence(wrong, better="A", worse="B", samples=9)
    assert text.endswith("As built, B is the better one.")
