"""Laws of the search: the front, the goals, limits, known optima, resuming, bad input."""

import dataclasses
import math

import msgspec
import numpy as np
import pytest

from octant.geometries.errors import ConfigError, SweepStateError
from octant.reader_design.experiments.optimise import evaluation
from octant.reader_design.experiments.optimise.evaluation import (
    LEFT_OUT,
    Evaluation,
    bench,
    evaluate,
    kept_evaluations,
)
from octant.reader_design.experiments.optimise.goals import Targets
from octant.reader_design.experiments.optimise.search import planned_evaluations, search
from octant.reader_design.experiments.optimise.shortlist import front, short_list
from octant.reader_design.experiments.optimise.space import boxes, survey_designs
from octant.reader_design.keeping.keys import case_keys
from octant.reader_design.study_file.loading import parse_study, to_toml
from octant.reader_design.study_file.optimise import Goal

HEAD = """
name = "search"
[room]
free_space = true
[[tag]]
id = "a"
position_m = [0.0, 0.0, 3.0]
antenna = "dipole"
[reader]
response = "isolated"
antenna_length_m = 0.0625
"""
BOX = """
[optimise]
survey = 5
evaluations = 120
parameters = {antenna_radius_m = [0.05, 0.10], gap_m = [0.002, 0.022]}
[[optimise.goal]]
score = "margin_db"
value = 0.0
"""
BEST_R_A, BEST_GAP = 0.083, 0.013


def study(text=BOX, head=HEAD):
    return parse_study(head + text, source="test.toml", directory=None)


def made(design, *, margin_db=0.0, share=1.0, level_w=1e-6, reason="", bearing_deg=0.1):
    """An evaluation with given scores at three distances."""
    rows = np.ones(0 if reason else 3)
    return Evaluation(
        design=design,
        reason=reason,
        footprint_m=design.ground_plane_m,
        height_m=0.08,
        right_share=share * rows,
        margin_db=margin_db * rows,
        bearing_error_deg=bearing_deg * rows,
        front_to_back_db=10.0 * rows,
        level_w=level_w * rows,
    )


def searched(one, evaluate):
    return search(one, one.optimise, evaluate)


def bowl(design):
    """A cheap model whose best design is known."""
    u = (design.antenna_radius_m - BEST_R_A) / 0.05
    v = (design.gap_m - BEST_GAP) / 0.02
    return made(design, margin_db=-20.0 * (u * u + 0.5 * u * v + v * v))


@pytest.mark.parametrize("method", ["nelder-mead", "cobyqa", "differential-evolution"])
def test_refinement_finds_the_known_optimum_within_its_budget(method):
    text = BOX.replace("survey = 5", f'survey = 5\nmethod = "{method}"')
    found = searched(study(text), bowl)
    best = found.winner.evaluation.design
    assert abs(best.antenna_radius_m - BEST_R_A) <= 1.5e-3
    assert abs(best.gap_m - BEST_GAP) <= 1e-3
    assert found.winner.attainment > found.best_of("survey").attainment
    assert sum(t.stage == "refinement" for t in found.trials) <= 120


def test_no_design_is_evaluated_twice_and_the_budget_holds():
    asked = []

    def counting(design):
        asked.append(design)
        return bowl(design)

    text = BOX.replace("evaluations = 120", "evaluations = 7")
    found = searched(study(text), counting)
    assert len(asked) == len(set(asked)) == len(found.trials) <= 1 + 6 + 7
    assert len(found.trials) <= planned_evaluations(study(text), study(text).optimise)


def test_best_combination_of_choices_is_refined():
    text = BOX.replace("survey", 'choices = {ground_plane_shape = ["octagon", "round"]}\nsurvey')

    def model(design):
        bonus = 1.0 if design.ground_plane_shape == "round" else 0.0
        base = bowl(design)
        return made(design, margin_db=float(base.margin_db[0]) + bonus)

    found = searched(study(text), model)
    refined = {t.evaluation.design.ground_plane_shape for t in found.trials if t.number > 13}
    assert refined == {"round"}
    both = searched(study(text.replace("survey = 5", "survey = 5\nstarts = 2")), model)
    shapes = [
        t.evaluation.design.ground_plane_shape for t in both.trials if t.stage == "refinement"
    ]
    assert set(shapes) == {"round", "octagon"}
    assert shapes == sorted(shapes, reverse=True)  # the better combination first


def test_search_depends_on_the_seed_only():
    first, again = searched(study(), bowl), searched(study(), bowl)
    assert [t.evaluation.design for t in first.trials] == [
        t.evaluation.design for t in again.trials
    ]
    other = searched(study(head=HEAD.replace('name = "search"', 'name = "s"\nseed = 2')), bowl)
    assert other.trials[3].evaluation.design != first.trials[3].evaluation.design


def test_every_design_tried_lies_within_the_bounds():
    for trial in searched(study(), bowl).trials[1:]:
        design = trial.evaluation.design
        assert 0.05 <= design.antenna_radius_m <= 0.10
        assert 0.002 <= design.gap_m <= 0.022


def test_infeasible_designs_keep_their_reason_and_never_win():
    def model(design):
        if design.gap_m > 0.01:
            return made(design, reason="its gap is too wide.")
        return bowl(design)

    found = searched(study(), model)
    barred = [t for t in found.trials if not t.evaluation.feasible]
    assert barred
    assert all(t.attainment == -math.inf for t in barred)
    assert all(t.evaluation.reason == "its gap is too wide." for t in barred)
    assert found.winner.evaluation.design.gap_m <= 0.01
    assert abs(found.winner.evaluation.design.gap_m - 0.01) < 1e-3  # the optimum on the limit
    assert not {t.number for t in front(found)} & {t.number for t in barred}


def test_a_survey_without_a_feasible_design_says_why():
    def model(design):
        own = design == study().reader
        return bowl(design) if own else made(design, reason="it is too large.")

    text = BOX.replace("gap_m = [0.002", "gap_m = [0.006")
    with pytest.raises(SweepStateError, match=r"none of the .* feasible.*it is too large\."):
        searched(study(text), model)


def test_gain_needs_a_reader_with_scores():
    text = BOX.replace("margin_db", "gain_db")
    with pytest.raises(ConfigError, match="the reader has no scores"):
        searched(study(text), lambda design: made(design, reason="no."))


def reader_targets(*goals, level_w=1e-6):
    design = study().reader
    reference = made(design, level_w=level_w)
    return Targets(goals=goals, distances_m=(1.0, 2.0, 4.0), reference=reference), design


def test_attainment_is_zero_where_a_goal_is_just_met():
    targets, design = reader_targets(Goal(score="margin_db", value=2.6))
    assert targets.attainment(made(design, margin_db=2.6)) == pytest.approx(0.0, abs=1e-12)
    assert targets.attainment(made(design, margin_db=1.6)) == pytest.approx(-1.05)
    assert targets.met(made(design, margin_db=2.5)) == (False,)


def test_less_is_better_for_errors_and_sizes():
    targets, design = reader_targets(
        Goal(score="bearing_error_deg", value=0.3), Goal(score="footprint_m", value=0.2)
    )
    small = targets.slacks(made(design, bearing_deg=0.1))
    assert small[0] == pytest.approx(0.2)
    assert small[1] == pytest.approx(0.0)
    assert targets.slacks(made(design, bearing_deg=0.4))[0] == pytest.approx(-0.1)


def test_gain_is_counted_from_the_reader_at_the_same_distance():
    targets, design = reader_targets(Goal(score="gain_db", value=3.0, at_m=(1.0, 2.0)))
    evaluation = dataclasses.replace(made(design), level_w=np.array([2e-6, 4e-6, 1e-9]))
    assert targets.scores(evaluation)[0] == pytest.approx(10 * math.log10(2.0))


def test_scores_take_the_worst_distance_where_the_goal_says_so():
    design = study().reader
    evaluation = dataclasses.replace(
        made(design),
        margin_db=np.array([3.0, 1.0, 2.0]),
        bearing_error_deg=np.array([0.1, 0.2, 0.9]),
        right_share=np.array([1.0, 0.5, 0.75]),
    )
    goals = [Goal(score=s, value=0.0) for s in ("margin_db", "bearing_error_deg", "right_share")]
    targets, _ = reader_targets(*goals)
    assert targets.scores(evaluation) == pytest.approx((1.0, 0.9, 0.75))


def test_a_full_share_no_longer_holds_the_attainment_back():
    goals = (Goal(score="right_share", value=1.0, weight=100.0), Goal(score="margin_db", value=1.0))
    targets, design = reader_targets(*goals)
    assert targets.attainment(made(design, margin_db=3.0)) > 1.9
    assert targets.attainment(made(design, margin_db=3.0, share=0.99)) < -0.9


def test_short_list_leaves_near_twins_out_and_says_why():
    text = BOX.replace('score = "margin_db"\nvalue = 0.0', 'score = "margin_db"\nvalue = -1.0')
    text += '[[optimise.goal]]\nscore = "gain_db"\nvalue = 1.0\n'

    def model(design):
        base = bowl(design)
        return made(design, margin_db=float(base.margin_db[0]), level_w=1e-4 * design.gap_m)

    found = searched(study(text), model)
    listed = short_list(found, 4)
    assert listed[0].trial.number == found.winner.number
    assert listed[0].reason.startswith("Chosen")
    assert "worst margin over the neighbours" in listed[0].reason
    designs = [entry.trial.evaluation.design for entry in listed]
    for i, a in enumerate(designs):
        for b in designs[:i]:
            assert (
                abs(a.antenna_radius_m / b.antenna_radius_m - 1) > 0.12
                or abs(a.gap_m / b.gap_m - 1) > 0.12
            )
    numbers = {t.number for t in front(found)}
    assert all(entry.trial.number in numbers for entry in listed)


def test_front_takes_less_error_for_better():
    goals = '[[optimise.goal]]\nscore = "bearing_error_deg"\nvalue = 0.3\n'
    text = BOX.replace("evaluations = 120", "evaluations = 0") + goals

    def model(design):  # a larger gap costs margin and raises the error
        return made(design, margin_db=-100.0 * design.gap_m, bearing_deg=100.0 * design.gap_m)

    found = searched(study(text), model)
    (best,) = {t.evaluation.design.gap_m for t in front(found)}
    assert best == min(t.evaluation.design.gap_m for t in found.trials)


def test_survey_starts_with_the_readers_own_values():
    table = study().optimise
    (box,) = boxes(study(), table)
    designs = survey_designs(box, 4, frequency_hz=2.4e9, generator=np.random.default_rng(1))
    assert designs[0] == study().reader
    assert len(designs) == 5


@pytest.mark.parametrize(
    ("change", "height_m"),
    [
        ({}, 0.08),
        ({"gap_m": 0.02}, 0.0825),
        ({"plate_height_axis_m": 0.095}, 0.095),
        ({"antenna": "monopole", "antenna_length_m": 0.085}, 0.09),
        ({"antenna": "monopole", "antenna_length_m": 0.085, "monopole_plane_m": 0.0}, 0.085),
    ],
)
def test_height_counts_plates_and_antennas(change, height_m):
    design = msgspec.structs.replace(study().reader, **change)
    assert design.size_m(2.4e9)[1] == pytest.approx(height_m)


def test_too_large_a_design_is_refused_without_a_solution(monkeypatch):
    place = bench(study())
    design = study().reader

    def solve(*_, **__):
        raise AssertionError("solved")

    monkeypatch.setattr(evaluation, "reader_responses", solve)
    wide = evaluate(place, msgspec.structs.replace(design, ground_plane_m=0.25))
    assert wide.reason == "its footprint is 250.0 mm, but at most 200 mm is free."
    high = evaluate(place, msgspec.structs.replace(design, plate_height_m=0.101))
    assert high.reason.startswith("its height with plates and antennas is 101.0 mm")
    assert high.level_w.size == 0


def test_a_design_that_cannot_be_built_is_infeasible_with_its_reason():
    place = bench(study())
    beyond = msgspec.structs.replace(study().reader, antenna_radius_m=0.095, ground_plane_m=0.18)
    result = evaluate(place, beyond)
    assert not result.feasible
    assert "antenna_radius_m is 0.095 m" in result.reason


def test_evaluation_reads_back_bit_by_bit(tmp_path):
    place = bench(study())
    design = study().reader
    wide = msgspec.structs.replace(design, ground_plane_m=0.25)
    first, refused = kept_evaluations(place, (design, wide), tmp_path)
    assert first.feasible
    assert first.level_w.shape == (3,)
    again, still = kept_evaluations(place, (design, wide), tmp_path)
    for name in ("right_share", "margin_db", "bearing_error_deg", "front_to_back_db", "level_w"):
        assert getattr(again, name).tobytes() == getattr(first, name).tobytes()
    assert (again.notes, still.reason) == (first.notes, refused.reason)


def test_key_follows_what_the_numbers_depend_on():
    design = study().reader

    def key(text=BOX, head=HEAD):
        place = bench(study(text, head))
        return case_keys(evaluate, [design], context=place, leave_out=LEFT_OUT)

    changes = (
        (BOX.replace("survey = 5", "survey = 5\ndistances_m = [1.0, 3.0]"), HEAD),
        (BOX.replace("survey = 5", "survey = 5\nheight_m = 0.09"), HEAD),
        (BOX, HEAD.replace('"isolated"', '"rays"')),
        (BOX, HEAD.replace("[0.0, 0.0, 3.0]", "[0.0, 0.0, 2.9]")),
    )
    assert len({key(), *(key(*change) for change in changes)}) == 1 + len(changes)
    assert key(BOX.replace("evaluations = 120", "evaluations = 3")) == key()


def test_table_survives_writing_and_reading():
    text = BOX.replace("survey", 'choices = {ground_plane_shape = ["octagon"]}\nsurvey')
    first = study(text)
    again = parse_study(to_toml(first), source="again.toml", directory=None)
    assert again == first


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("gap_m = [", "gap_mm = [", "did you mean 'gap_m'?"),
        ("[0.002, 0.022]", "[0.022, 0.002]", "first bound must lie below the second"),
        ("[0.002, 0.022]", "[-0.002, 0.022]", "from 0 to 100 m"),
        ("margin_db", "margin", "did you mean 'margin_db'"),
        ("survey = 5", "survey = -1", "from 0 to 1000000"),
        ("value = 0.0", "value = 0.0\nat_m = [3.0]", "designs are scored at 1, 2, 4 m"),
        (
            "survey = 5",
            "survey = 5\nchoices = {gap_m = [0.005]}",
            "both a parameter and a choice",
        ),
        (
            "survey = 5",
            'survey = 5\nchoices = {ground_plane_shape = ["round", "round"]}',
            "names a value twice",
        ),
        (
            "survey = 5",
            'survey = 5\nchoices = {ground_plane_shape = ["oktagon"]}',
            "did you mean 'octagon'",
        ),
    ],
)
def test_bad_tables_are_refused_with_the_reason(old, new, told):
    with pytest.raises(ConfigError) as refusal:
        study(BOX.replace(old, new, 1))
    assert told in str(refusal.value)


def test_a_table_with_nothing_to_vary_is_refused():
    with pytest.raises(ConfigError, match="nothing to search"):
        study("[optimise]\n")
    with pytest.raises(ConfigError, match="no parameter varies"):
        study('[optimise]\nchoices = {antenna = ["dipole", "monopole"]}\n')
    with pytest.raises(ConfigError, match=r"no table \[optimise\]"):
        bench(study(""))
