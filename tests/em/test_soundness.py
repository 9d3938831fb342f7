"""What cannot be true does not leave the radio model; the sentence names the place."""

import numpy as np
import pytest

from octant.em.soundness import check_power
from octant.geometries.errors import ResultError

PLACES = np.array([[0.0, 0.0, 1.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, -1e-30])
@pytest.mark.parametrize("shape", [(3,), (3, 2), (3, 4, 2)])
def test_powers_that_are_no_powers_are_refused_with_their_place(shape, wrong):
    power = np.full(shape, 1e-6)
    power[1:].flat[-1] = wrong
    with pytest.raises(ResultError, match=r"1 of 3 places, first at \(4, 5, 6\) m"):
        check_power(power, 1.0, PLACES)


def test_no_more_than_what_was_sent_arrives():
    check_power(np.array([0.0, 2.0, 2.0 * (1.0 + 1e-12)]), 2.0, PLACES)
    with pytest.raises(ResultError, match=r"3 W would be received of 2 W sent at 1 of 3 places"):
        check_power(np.array([0.0, 3.0, 2.0]), 2.0, PLACES)
