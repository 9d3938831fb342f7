"""Laws of the Pareto front, against a comparison of every pair."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from octant.geometries.errors import SweepStateError
from octant.reader_design.setting.pareto import pareto_front


def by_brute_force(values, maximise):
    """Compare every pair of rows, as the definition says."""
    gain = np.where(maximise, values, -values)
    return [
        not any((other >= row).all() and (other > row).any() for other in gain)
        and not np.isnan(row).any()
        for row in gain
    ]


@given(
    arrays(
        np.float64,
        st.tuples(st.integers(0, 12), st.integers(1, 4)),
        elements=st.sampled_from([0.0, 1.0, 2.0, 2.0 + 1e-15, -np.inf, np.nan]),
    ),
    st.lists(st.booleans(), min_size=4, max_size=4),
)
def test_front_is_what_comparing_every_pair_leaves(values, maximise):
    wanted = maximise[: values.shape[1]]
    assert pareto_front(values, wanted).tolist() == by_brute_force(values, wanted)


def test_front_of_many_random_rows_equals_brute_force():
    values = np.random.default_rng(1).normal(size=(400, 3))
    wanted = [True, False, True]
    assert pareto_front(values, wanted).tolist() == by_brute_force(values, wanted)


def test_one_score_leaves_its_best_and_all_that_equal_it():
    values = np.array([[1.0], [3.0], [2.0], [3.0]])
    assert pareto_front(values, maximise=True).tolist() == [False, True, False, True]
    assert pareto_front(values, maximise=False).tolist() == [True, False, False, False]


def test_front_does_not_depend_on_the_order_of_rows_or_on_growing_functions_of_scores():
    rng = np.random.default_rng(2)
    values = rng.integers(0, 6, size=(80, 3)).astype(float)
    front = pareto_front(values, maximise=True)
    order = rng.permutation(80)
    assert (pareto_front(values[order], maximise=True) == front[order]).all()
    assert (pareto_front(np.exp(values), maximise=True) == front).all()


def test_designs_on_a_circle_are_all_on_the_front():
    angle = np.linspace(0.0, np.pi / 2, 500)
    values = np.column_stack([np.cos(angle), np.sin(angle)])
    assert pareto_front(values, maximise=True).all()
    assert pareto_front(values, maximise=[True, False]).sum() == 1


def test_unknown_scores_keep_a_design_off_the_front():
    values = np.array([[np.nan, 9.0], [1.0, 1.0]])
    assert pareto_front(values, maximise=True).tolist() == [False, True]


def test_wrong_shapes_are_refused():
    with pytest.raises(SweepStateError, match="2 entries, but there are 3 scores"):
        pareto_front(np.zeros((4, 3)), [True, False])
    with pytest.raises(SweepStateError):
        pareto_front(np.zeros(3), maximise=True)
