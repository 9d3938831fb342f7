"""Laws of the choice: constraint first, criteria in their order, ties, honest reasons."""

import dataclasses

import numpy as np
import pytest

from octant.geometries.errors import SweepStateError
from octant.reader_design.sweep.choice import (
    Candidate,
    Criteria,
    choose,
    merit,
    pareto_front,
)
from octant.reader_design.sweep.scores import score_rss

ELEMENTS = np.arange(8) * np.pi / 4
AZIMUTHS = np.arange(48) * np.pi / 24
ANGLE = AZIMUTHS[:, None] - ELEMENTS
BASE = score_rss((1e-6 * (1 + 0.8 * np.cos(ANGLE)))[None], AZIMUTHS, ELEMENTS)


def candidate(label, *, room=True, **free):
    scores = dataclasses.replace(BASE, **free)
    return Candidate(label=label, key=label, free=scores, room=scores if room else None)


def test_unusable_design_ranks_last_however_good_its_bearing():
    out = choose(
        [candidate("deaf", usable_share=0.5, right_share=1.0), candidate("b", right_share=0.3)],
        model="fullwave",
    )
    assert out.ranking == (1, 0)
    assert out.decided_by == "usable signal"


def test_usable_signal_is_needed_in_the_room_too():
    deaf_in_room = Candidate(
        label="a", key="a", free=BASE, room=dataclasses.replace(BASE, usable_share=0.1)
    )
    assert merit(deaf_in_room).usable_share == 0.1
    assert choose([deaf_in_room, candidate("b")], model="fullwave").chosen == 1


@pytest.mark.parametrize(
    ("better", "decided"),
    [
        ({"right_share": 1.0, "vector_rms_rad": 3.0}, "share of right antennas"),
        ({"vector_rms_rad": 0.05, "margin_worst_db": -9.0}, "bearing error of the vector sum"),
        ({"margin_worst_db": 9.0, "level_median_dbm": -80.0}, "margin over the neighbours"),
        ({"level_median_dbm": -10.0}, "level"),
    ],
)
def test_criteria_act_in_their_order(better, decided):
    common = {
        "right_share": 0.9,
        "vector_rms_rad": 0.1,
        "margin_worst_db": 1.0,
        "level_median_dbm": -50.0,
    }
    out = choose(
        [candidate("a", **common), candidate("b", **{**common, **better})], model="fullwave"
    )
    assert out.chosen == 1
    assert out.decided_by == decided
    assert decided in " ".join(out.reason)


def test_difference_within_the_tolerance_does_not_decide():
    out = choose(
        [
            candidate("a", right_share=0.90, vector_rms_rad=0.2),
            candidate("b", right_share=0.89, vector_rms_rad=0.1),
        ],
        model="fullwave",
    )
    assert out.chosen == 1
    strict = Criteria(share_tolerance=0.0)
    assert (
        choose(
            [
                candidate("a", right_share=0.90, vector_rms_rad=0.2),
                candidate("b", right_share=0.89, vector_rms_rad=0.1),
            ],
            model="fullwave",
            criteria=strict,
        ).chosen
        == 0
    )


def test_equal_designs_keep_the_order_of_the_sweep():
    out = choose([candidate("a"), candidate("b"), candidate("c")], model="fullwave")
    assert out.ranking == (0, 1, 2)
    assert out.decided_by == "order of the sweep"


def test_ranking_names_every_design_once_and_is_independent_of_the_input_order():
    rng = np.random.default_rng(3)
    pool = [
        candidate(
            str(k),
            right_share=float(rng.uniform(0.2, 1.0)),
            vector_rms_rad=float(rng.uniform(0.02, 1.0)),
            margin_worst_db=float(rng.uniform(-3, 3)),
            level_median_dbm=float(rng.uniform(-80, -40)),
        )
        for k in range(12)
    ]
    out = choose(pool, model="fullwave")
    assert sorted(out.ranking) == list(range(12))
    order = rng.permutation(12)
    shuffled = choose([pool[k] for k in order], model="fullwave")
    assert [pool[k].label for k in out.ranking] == [pool[order[k]].label for k in shuffled.ranking]


def test_room_and_free_space_weigh_the_same():
    better = dataclasses.replace(BASE, right_share=0.6)
    worse = dataclasses.replace(BASE, right_share=0.2)
    assert merit(Candidate(label="", key="", free=better, room=worse)).right_share == 0.4
    assert merit(Candidate(label="", key="", free=better, room=None)).right_share == 0.6


def test_pareto_front_keeps_designs_that_nothing_dominates():
    merits = [
        merit(candidate("best share", right_share=0.9, margin_worst_db=0.0)),
        merit(candidate("best margin", right_share=0.8, margin_worst_db=3.0)),
        merit(candidate("dominated", right_share=0.8, margin_worst_db=0.0)),
    ]
    assert pareto_front(merits) == (True, True, False)


def test_equal_designs_do_not_dominate_each_other():
    assert pareto_front([merit(candidate("a")), merit(candidate("b"))]) == (True, True)


@pytest.mark.parametrize(("model", "word"), [("rays", "coupling"), ("isolated", "alone")])
def test_reason_says_when_the_reader_model_cannot_be_trusted(model, word):
    reason = " ".join(choose([candidate("a"), candidate("b")], model=model).reason)
    assert word in reason
    assert "care" in reason
    assert "care" not in " ".join(choose([candidate("a")], model="fullwave").reason)


def test_reason_gives_the_numbers_of_the_chosen_design():
    out = choose([candidate("my reader", right_share=0.875)], model="fullwave")
    assert out.reason[0].startswith("Chosen: my reader")
    assert "88%" in out.reason[0]
    assert out.decided_by == "only one design"


def test_reason_admits_when_no_design_is_usable():
    out = choose(
        [candidate("a", usable_share=0.2), candidate("b", usable_share=0.4)], model="fullwave"
    )
    assert out.chosen == 1
    assert any("No design" in sentence for sentence in out.reason)


def test_no_candidate_is_an_error():
    with pytest.raises(SweepStateError, match="0 scored designs"):
        choose([], model="rays")


def test_rules_are_said_in_words_with_their_tolerances():
    text = " ".join(Criteria(share_tolerance=0.03, margin_tolerance_db=0.7).sentences())
    assert "3 percentage points" in text
    assert "0.7 dB" in text
