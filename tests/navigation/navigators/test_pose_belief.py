"""What a belief makes of evidence for and against it."""

from dataclasses import replace

import numpy as np
import pytest

from octant.navigation.navigators.pose_belief import MOST_PROOF, PoseBelief


@pytest.fixture
def belief():
    return PoseBelief(
        poses=np.zeros((3, 4)),
        weights=np.full(4, 0.25),
        trusted=np.array([[0.4, 0.3, 0.2, 0.1], [0.1, 0.1, 0.5, 0.3]]),
        level_db=np.zeros(2),
        level_variance=np.ones(2),
        gain_db=np.zeros(8),
        gain_variance=np.ones(8),
    )


def test_doubt_and_proof_add_up_evidence_and_neither_falls_below_zero(belief):
    assert belief.proven
    doubted = belief.judged(8.0).judged(6.0)
    assert (doubted.doubt, doubted.proof) == (14.0, MOST_PROOF - 14.0)
    nothing = doubted.judged(100.0)
    assert nothing.proof == 0.0
    assert not nothing.proven
    again = nothing.judged(-200.0)
    assert (again.doubt, again.proof) == (0.0, MOST_PROOF)


def test_what_is_learned_in_doubt_is_forgotten_back_to_when_there_was_none(belief):
    gain_db, wrong_db = np.arange(8.0), np.full(8, 9.0)
    known = replace(belief, gain_db=gain_db).judged(-1.0)
    # At a wrong pose it goes on learning.
    doubted = replace(known.judged(12.0), gain_db=wrong_db).judged(12.0)
    assert np.array_equal(doubted.gain_db, wrong_db)
    assert np.array_equal(doubted.unlearned().gain_db, gain_db)
    assert doubted.unlearned().doubt == doubted.doubt
    # A pose that is not proven teaches nothing: there is nothing to go back to.
    open_one = replace(belief, proof=0.0).judged(-1.0)
    assert open_one.sure is None
    assert open_one.unlearned() is open_one


def test_faded_is_the_share_of_readings_that_only_the_local_mean_or_an_outlier_explains(belief):
    assert belief.faded == pytest.approx((0.3 + 0.8) / 2.0)


def test_readings_are_strange_while_they_speak_for_the_local_mean(belief):
    assert not belief.compared(-100.0).estranged
    strange = belief.compared(3.0).compared(4.0)
    assert strange.strange == pytest.approx(0.9 * 3.0 + 4.0)
    assert strange.estranged
    # A shadow that the map does not know does not count for ever.
    assert strange.compared(1000.0).compared(-20.0).strange == 0.0
    left = strange
    for _ in range(10):
        left = left.compared(0.0)
    assert not left.estranged
