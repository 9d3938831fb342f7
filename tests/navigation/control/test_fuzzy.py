import numpy as np
import pytest
import skfuzzy
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries.errors import NavigationError
from octant.navigation.control.fuzzy import (
    INPUT_TERMS,
    SPEED_TERMS,
    THESIS_RULES,
    FuzzyVariable,
    Rule,
    RuleBase,
    Term,
    thesis_rule_base,
    variable_from_table,
)

BASE = thesis_rule_base()
SPEED = variable_from_table("speed", (0.0, 1.0), SPEED_TERMS)
INPUT = variable_from_table("input", (-1.0, 1.0), INPUT_TERMS)


def by_scikit_fuzzy(base, value, output, points=4001):
    """One output by scikit-fuzzy on a dense grid: min implication, max aggregation, centroid."""
    x = base.input_variable
    fine = np.union1d(np.linspace(x.low, x.high, points), [value])
    variable = base.outputs[output]
    corners = np.concatenate([term.corners for term in variable.terms])
    universe = np.union1d(np.linspace(variable.low, variable.high, points), corners)
    aggregated = np.zeros_like(universe)
    for rule in base.rules:
        condition = next(term for term in x.terms if term.name == rule.when)
        conclusion = next(term for term in variable.terms if term.name == rule.then[output])
        weight = skfuzzy.interp_membership(fine, skfuzzy.trapmf(fine, condition.corners), value)
        clipped = np.fmin(weight, skfuzzy.trapmf(universe, conclusion.corners))
        aggregated = np.fmax(aggregated, clipped)
    return skfuzzy.defuzz(universe, aggregated, "centroid")


def test_thesis_controller_equals_scikit_fuzzy_on_a_dense_grid():
    values = np.linspace(-1, 1, 161)
    ours = BASE.infer(values)
    theirs = np.array([[by_scikit_fuzzy(BASE, x, k) for k in (0, 1)] for x in values])
    assert np.abs(ours - theirs).max() < 1e-3


@st.composite
def rule_bases(draw):
    """Three trapezoids over a random partition, each widened at random, random conclusions."""

    def variable(name):
        cuts = np.sort(draw(st.lists(st.integers(1, 99), min_size=5, max_size=5, unique=True)))
        a, b, c, d, e = (float(cut) / 100 for cut in cuts)
        rows = [("low", (0, 0, a, c)), ("middle", (a, b, d, e)), ("high", (c, e, 1, 1))]
        return variable_from_table(name, (0.0, 1.0), rows)

    names = ("low", "middle", "high")
    rules = tuple(Rule(when=name, then=(draw(st.sampled_from(names)),)) for name in names)
    return RuleBase(input_variable=variable("in"), outputs=(variable("out"),), rules=rules)


@given(base=rule_bases(), value=st.floats(0, 1))
def test_any_rule_base_equals_scikit_fuzzy(base, value):
    assert base.infer(value)[0] == pytest.approx(by_scikit_fuzzy(base, value, 0), abs=1e-3)


def test_several_crossings_between_two_corners_are_taken_in_order():
    # All three fire fully at 1/2; between 0 and 0.9 the conclusions are 1 - u, u and u / 0.9, whose
    # crossings come up in the order 0.5, 0.47.
    names = ("falling", "late", "later")
    base = RuleBase(
        input_variable=variable_from_table(
            "in", (0, 1), [(name, (0.1 * k, 0.1 * k, 1, 1)) for k, name in enumerate(names)]
        ),
        outputs=(
            variable_from_table(
                "out", (0, 1), [("falling", (0, 0, 1)), ("late", (0, 0.9, 1)), ("later", (0, 1, 1))]
            ),
        ),
        rules=tuple(Rule(when=name, then=(name,)) for name in ("falling", "later", "late")),
    )
    assert base.infer(0.5)[0] == pytest.approx(by_scikit_fuzzy(base, 0.5, 0), abs=1e-6)


def test_centroid_carries_no_grid_error():
    # At -0.75 two terms fire at 1/2: H clipped over [0.5, 1], VH clipped over [0.75, 1]. Their
    # union rises 0.5..0.625, stays at 1/2 up to 1, H's fall being covered: integrate by hand.
    area = 0.125 * 0.5 / 2 + 0.375 * 0.5
    moment = 0.125 * 0.5 / 2 * (0.5 + 0.125 * 2 / 3) + 0.375 * 0.5 * 0.8125
    assert BASE.infer(-0.75)[0] == pytest.approx(moment / area, abs=1e-14)
    assert BASE.infer([-1.0, 0.0, 1.0])[:, 0] == pytest.approx(
        [1 - 0.25 / 3, 0.5, 0.25 / 3], abs=1e-14
    )


def test_controller_is_antisymmetric_and_swaps_the_wheels():
    x = np.linspace(-1, 1, 401)
    right, left = BASE.infer(x).T
    assert right == pytest.approx(left[::-1], abs=1e-14)
    assert right + left == pytest.approx(np.ones(401), abs=1e-14)


def test_right_wheel_slows_and_left_wheel_speeds_up_as_the_tag_moves_to_the_right():
    right, left = BASE.infer(np.linspace(-1, 1, 2001)).T
    assert (np.diff(right) <= 1e-14).all()
    assert (np.diff(left) >= -1e-14).all()
    assert right[0] - right[-1] > 0.8


def test_inputs_beyond_the_universe_count_as_its_end():
    assert BASE.infer([-7.0, 9.0]) == pytest.approx(BASE.infer([-1.0, 1.0]))
    assert np.isnan(BASE.infer(np.nan)).all()
    assert BASE.infer(np.zeros((3, 4))).shape == (3, 4, 2)


def test_memberships_add_up_to_one_and_match_the_corners():
    x = np.linspace(-1, 1, 81)
    assert INPUT.memberships(x).sum(axis=-1) == pytest.approx(np.ones(81))
    trapezoid = Term(name="t", corners=np.array([0.0, 1.0, 2.0, 4.0]))
    assert trapezoid.membership([-1, 0, 0.5, 1, 1.5, 2, 3, 4, 5]) == pytest.approx(
        [0, 0, 0.5, 1, 1, 1, 0.5, 0, 0]
    )


@pytest.mark.parametrize("missing", range(5))
def test_incomplete_rule_bases_are_refused_when_built(missing):
    rules = THESIS_RULES[:missing] + THESIS_RULES[missing + 1 :]
    with pytest.raises(NavigationError, match=f"'{THESIS_RULES[missing].when}'.*0 rules"):
        RuleBase(input_variable=INPUT, outputs=(SPEED, SPEED), rules=rules)


def test_ambiguous_and_misspelt_rules_are_refused():
    with pytest.raises(NavigationError, match="2 rules"):
        RuleBase(
            input_variable=INPUT,
            outputs=(SPEED, SPEED),
            rules=(*THESIS_RULES, Rule(when="Z", then=("M", "L"))),
        )
    with pytest.raises(NavigationError, match=r"'VHH'.*did you mean 'VH'"):
        RuleBase(
            input_variable=INPUT,
            outputs=(SPEED, SPEED),
            rules=(Rule(when="NH", then=("VHH", "VL")), *THESIS_RULES[1:]),
        )
    with pytest.raises(NavigationError, match="sets 2 outputs, but there are 1"):
        RuleBase(input_variable=INPUT, outputs=(SPEED,), rules=THESIS_RULES)


@pytest.mark.parametrize("corners", [(0.5, 0.2, 0.8, 1.0), (0.3, 0.3, 0.3, 0.3), (0, 0, 0, np.nan)])
def test_terms_that_are_not_ordered_or_empty_are_refused(corners):
    with pytest.raises(NavigationError, match="'x'"):
        Term(name="x", corners=np.array(corners))


def test_variables_must_cover_their_universe_in_order():
    with pytest.raises(NavigationError, match=r"no term of 'v' covers 0\.4"):
        variable_from_table("v", (0, 1), [("a", (0, 0, 0.4)), ("b", (0.4, 1, 1))])
    with pytest.raises(NavigationError, match="from left to right"):
        variable_from_table("v", (0, 1), [("a", (0, 1, 1)), ("b", (0, 0, 1))])
    with pytest.raises(NavigationError, match="leave the universe"):
        variable_from_table("v", (0, 1), [("a", (0, 0.5, 1.5))])
    with pytest.raises(NavigationError, match="each name once"):
        variable_from_table("v", (0, 1), [("a", (0, 0, 1)), ("a", (0, 1, 1))])
    with pytest.raises(NavigationError, match="lower end"):
        FuzzyVariable(name="v", low=1.0, high=0.0, terms=SPEED.terms)


def test_table_5_1_gives_right_and_left_wheel():
    table = {rule.when: rule.then for rule in THESIS_RULES}
    assert table == {
        "NH": ("VH", "VL"),
        "NL": ("H", "L"),
        "Z": ("M", "M"),
        "PL": ("L", "H"),
        "PH": ("VL", "VH"),
    }
