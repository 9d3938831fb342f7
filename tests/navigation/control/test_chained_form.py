import numpy as np
import pytest

from octant.navigation.control.chained_form import (
    chained_inputs,
    chained_rate,
    chained_step,
    of_chained,
    to_chained,
)
from octant.navigation.robot.motion import move

RNG = np.random.default_rng(4)
POSES = RNG.uniform(-3.0, 3.0, (50, 3))
TWISTS = RNG.uniform(-1.0, 1.0, (50, 2))


def test_the_coordinates_are_those_of_11_23_and_go_back():
    x, y, heading = POSES.T
    chained = to_chained(POSES)
    assert chained[:, 1] == pytest.approx(x * np.cos(heading) + y * np.sin(heading))
    assert chained[:, 2] == pytest.approx(x * np.sin(heading) - y * np.cos(heading))
    assert of_chained(chained) == pytest.approx(POSES)


def test_the_unicycle_in_chained_form_moves_as_11_25_says():
    """Independent: differences along the unicycle's own motion."""
    step = 1e-5
    ahead, back = (
        move(POSES, distance_m=sign * step * TWISTS[:, 0], turn_rad=sign * step * TWISTS[:, 1])
        for sign in (1.0, -1.0)
    )
    rate = (to_chained(ahead) - to_chained(back)) / (2.0 * step)
    chained = to_chained(POSES)
    inputs = chained_inputs(chained, TWISTS)
    assert chained_rate(chained, inputs) == pytest.approx(rate, abs=1e-8)
    # (11.24): v = v₂ + z₃ v₁, ω = v₁.
    assert inputs[:, 1] + chained[:, 2] * inputs[:, 0] == pytest.approx(TWISTS[:, 0])


@pytest.mark.parametrize("turn_rate", [0.7, -2.0, 1e-9, 0.0])
def test_the_chained_form_leads_to_the_exact_step_of_11_85(turn_rate):
    twists = np.column_stack([TWISTS[:, 0], np.full(50, turn_rate)])
    stepped = of_chained(chained_step(to_chained(POSES), twists, period_s=1.5))
    if abs(turn_rate) > 1e-3:
        x, y, heading = POSES.T
        radius, after = twists[:, 0] / turn_rate, heading + 1.5 * turn_rate
        want = np.column_stack(
            [
                x + radius * (np.sin(after) - np.sin(heading)),
                y - radius * (np.cos(after) - np.cos(heading)),
                after,
            ]
        )
    else:
        want = move(POSES, distance_m=1.5 * twists[:, 0], turn_rad=1.5 * twists[:, 1])
    assert stepped == pytest.approx(want, abs=1e-12)
