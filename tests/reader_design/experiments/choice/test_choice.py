"""Laws of the choice: constraint first, criteria in their order, ties, honest reasons."""

import dataclasses

import numpy as np
import pytest

from octant.geometries.errors import SweepStateError
from octant.reader_design.setting.ranking import Candidate, choose, criterion_value, merit
from octant.reader_design.setting.reasons import (
    rule_sentences,
    score_phrase,
    score_text,
)
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.study_file.choice import CRITERIA, Choice, Criterion
from octant.reader_design.study_file.scores import (
    SCORE_NAMES,
    higher_is_better,
)

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
    strict = Choice(criteria=(Criterion(free="right_share"), *CRITERIA[1:]))
    assert (
        choose(
            [
                candidate("a", right_share=0.90, vector_rms_rad=0.2),
                candidate("b", right_share=0.89, vector_rms_rad=0.1),
            ],
            model="fullwave",
            rules=strict,
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


def test_room_and_free_space_weigh_the_same_and_errors_by_their_squares():
    better = dataclasses.replace(BASE, right_share=0.6, vector_rms_rad=0.3)
    worse = dataclasses.replace(BASE, right_share=0.2, vector_rms_rad=0.1)
    share, error = CRITERIA[:2]
    assert criterion_value(share, better, worse) == 0.4
    assert criterion_value(share, better, None) == 0.6
    assert criterion_value(error, better, worse) == pytest.approx(np.sqrt(0.05))
    assert criterion_value(error, better, None) == 0.3


def test_a_criterion_may_look_at_one_surrounding_only():
    free = dataclasses.replace(BASE, captured_share=0.0, level_median_dbm=-50.0)
    room = dataclasses.replace(BASE, captured_share=0.3, level_median_dbm=-40.0)
    assert criterion_value(Criterion(room="captured_share"), free, room) == 0.3
    assert criterion_value(Criterion(free="level_median_dbm"), free, room) == -50.0
    assert criterion_value(Criterion(room="captured_share"), free, None) == 0.0


def test_criteria_of_the_study_decide_in_their_order_and_direction():
    rules = Choice(criteria=(Criterion(room="captured_share", tolerance=0.05), CRITERIA[3]))
    pool = [
        candidate("a", captured_share=0.30, level_median_dbm=-40.0),
        candidate("b", captured_share=0.10, level_median_dbm=-60.0),
        candidate("c", captured_share=0.14, level_median_dbm=-50.0),
    ]
    out = choose(pool, model="fullwave", rules=rules)
    assert out.ranking == (2, 1, 0)
    assert out.decided == ("level", "share of captured floor", "only one design")
    assert "10.0 % against 30.0 %" in out.comparisons[1]
    assert out.pareto == (True, True, True)


def test_a_reader_that_is_too_large_ranks_below_all_that_fit():
    rules = Choice(greatest_width_m=0.2, greatest_height_m=0.10)
    pool = [
        dataclasses.replace(candidate("high", right_share=1.0), width_m=0.2, height_m=0.15),
        dataclasses.replace(candidate("fits", right_share=0.5), width_m=0.2, height_m=0.10),
        dataclasses.replace(candidate("wide", right_share=1.0), width_m=0.3, height_m=0.05),
    ]
    out = choose(pool, model="fullwave", rules=rules)
    assert [pool[i].label for i in out.ranking] == ["fits", "high", "wide"]
    assert out.decided[:2] == ("size", "size")
    assert "0 cm against 5 cm too large" in out.comparisons[0]
    assert choose(pool, model="fullwave").chosen == 0
    alone = choose(pool[2:], model="fullwave", rules=rules)
    assert "exceeds it least, by 10 cm" in " ".join(alone.reason)


def test_short_list_is_the_head_of_the_ranking():
    out = choose([candidate(str(k)) for k in range(9)], model="rays", rules=Choice(shortlist=3))
    assert out.shortlist == out.ranking[:3]
    assert len(out.comparisons) == 9


def test_pareto_front_keeps_designs_that_nothing_dominates():
    pool = [
        candidate("best share", right_share=0.9, margin_worst_db=0.0),
        candidate("best margin", right_share=0.8, margin_worst_db=3.0),
        candidate("dominated", right_share=0.8, margin_worst_db=0.0),
    ]
    assert choose(pool, model="fullwave").pareto == (True, True, False)


def test_equal_designs_do_not_dominate_each_other():
    assert choose([candidate("a"), candidate("b")], model="fullwave").pareto == (True, True)


def test_every_score_has_a_phrase_a_text_and_a_direction():
    for name in SCORE_NAMES:
        assert score_phrase(name)
        assert score_text(name, 0.5)
    assert score_text("vector_rms_rad", np.radians(2.0)) == "2.0°"
    assert score_text("full_scale_w", 3e-9) == "3 nW"
    worse = {n for n in SCORE_NAMES if not higher_is_better(n)}
    assert {"vector_p90_rad", "captured_share", "read_vector_beyond_90_share"} <= worse
    assert not {"right_share", "read_right_share", "level_median_dbm", "margin_worst_db"} & worse


@pytest.mark.parametrize(("model", "word"), [("rays", "coupling"), ("isolated", "alone")])
def test_reason_says_when_the_reader_model_cannot_be_trusted(model, word):
    reason = " ".join(choose([candidate("a"), candidate("b")], model=model).reason)
    assert word in reason
    assert "care" in reason
    assert "care" not in " ".join(choose([candidate("a")], model="fullwave").reason)


def test_reason_gives_the_numbers_of_the_chosen_design():
    out = choose([candidate("my reader", right_share=0.875)], model="fullwave")
    assert out.reason[0].startswith("Chosen: my reader")
    assert "88 %" in out.reason[0]
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
    rules = Choice(
        greatest_height_m=0.1,
        criteria=(
            Criterion(free="right_share", room="right_share", tolerance=0.03),
            Criterion(room="margin_mean_db", tolerance=0.7),
            Criterion(free="vector_rms_rad", tolerance=0.05, relative=True),
        ),
    )
    text = " ".join(rule_sentences(rules))
    assert "3 percentage points" in text
    assert "0.7 dB" in text
    assert "within 5 % of the best" in text
    assert "at most 10 cm high" in text
    assert "in the room); more is better" in text
    assert "in free space); less is better" in text
