"""The design that the search found keeps its figures, beside the thesis' choice."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from octant.reader_design.config.loading import load_study
from octant.reader_design.config.optimise import DEFAULT_GOALS, Goal
from octant.reader_design.optimise.evaluation import bench, evaluate
from octant.reader_design.optimise.goals import Targets
from octant.reader_design.sweep.design import design_of

EXAMPLES = Path(__file__).parents[2] / "examples"
GOALS = (
    Goal(score="right_share", value=1.0),
    Goal(score="margin_db", value=2.6),
    Goal(score="bearing_error_deg", value=0.3),
    Goal(score="gain_db", value=3.01, at_m=(1.0, 2.0)),
)


@pytest.fixture(scope="module")
def scores():
    """Scores of thesis and winner at 10 cells per wavelength."""
    study = load_study(EXAMPLES / "compact_reader.toml")
    place = bench(study)
    thesis = evaluate(place, design_of(study.reader))
    found = evaluate(place, design_of(load_study(EXAMPLES / "best_reader.toml").reader))
    assert thesis.feasible
    assert found.feasible
    assert found.footprint_m <= 0.2
    assert found.height_m <= 0.1
    targets = Targets(goals=GOALS, distances_m=study.optimise.distances_m, reference=thesis)
    return targets.scores(thesis), targets.scores(found), found


def test_thesis_choice_has_its_known_weakness(scores):
    thesis, _, _ = scores
    assert thesis[0] == pytest.approx(0.87, abs=0.01)
    assert thesis[1] == pytest.approx(1.0, abs=0.1)


def test_winner_meets_every_goal(scores):
    _, found, evaluation = scores
    assert found[0] == 1.0
    assert found[1] >= 2.6
    assert found[2] <= 0.3
    assert found[3] >= 3.01
    assert np.isfinite(evaluation.level_w).all()


def test_the_built_in_room_and_missions_stand_in_the_example():
    built_in, example = load_study(None), load_study(EXAMPLES / "best_reader.toml")
    for name in ("room", "tags", "mission", "layouts", "radio", "solver", "map"):
        assert getattr(built_in, name) == getattr(example, name)


def test_goals_of_the_example_are_the_default_ones_near_and_far():
    goals = load_study(EXAMPLES / "compact_reader.toml").optimise.goals
    assert [g.score for g in goals] == [g.score for g in DEFAULT_GOALS]
    assert [msgspec.structs.replace(g, at_m=()) for g in goals] == list(DEFAULT_GOALS)
