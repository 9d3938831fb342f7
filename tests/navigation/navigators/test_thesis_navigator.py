from dataclasses import replace

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.control.controllers import FuzzyController
from octant.navigation.navigators.arrival import ArrivalTest
from octant.navigation.navigators.interface import STILL, Odometry
from octant.navigation.navigators.thesis import ThesisMemory, ThesisNavigator
from octant.navigation.robot.drive import DifferentialDrive

EIGHT = np.radians(45.0 * np.arange(8))
ROBOT = DifferentialDrive()
TEST = ArrivalTest(threshold_w=1e-9)
RNG = np.random.default_rng(0)
STEP = Odometry(distance_m=0.09)


def navigator(**options):
    settings = {
        "arrivals": (TEST, TEST),
        "azimuths_rad": EIGHT,
        "controller": FuzzyController(),
        "robot": ROBOT,
        "cruise_speed_m_per_s": 0.09,
        "period_s": 1.0,
    }
    return ThesisNavigator(**(settings | options))


def decide(machine, memory, rss_w, odometry=STILL):
    return machine.decide(memory, rss_w, odometry, RNG)


def reading(antenna, *, strength_w=1e-6):
    rss = np.full(8, 0.1 * strength_w)
    rss[antenna] = strength_w
    return rss


def weak():
    """A reading with a spread below the threshold, ahead."""
    return reading(2, strength_w=1e-10)


def test_rotation_turns_on_the_spot_to_the_strongest_antenna_in_one_period():
    decision = decide(navigator(), ThesisMemory(), reading(0))
    assert ROBOT.twist(decision.rates) == pytest.approx([0.0, -np.pi / 2])
    assert (decision.mode, decision.memory.mode) == ("rotation", "navigation")


def test_rotation_can_use_the_vector_sum():
    rss = 1 + np.cos(np.radians(90 + 25) - EIGHT)
    decision = decide(navigator(rotation="vector_sum"), ThesisMemory(), rss)
    assert ROBOT.twist(decision.rates)[1] == pytest.approx(np.radians(25))


def test_rotation_beyond_the_wheels_takes_several_periods_and_one_bearing():
    slow = replace(ROBOT, max_wheel_speed_m_per_s=0.15)  # 1 rad a period
    machine = navigator(robot=slow)
    memory, turned = ThesisMemory(), []
    while memory.mode == "rotation":
        # Later readings name another antenna, which must not matter.
        decision = decide(machine, memory, reading(7 if not turned else 4))
        memory = decision.memory
        turned.append(slow.twist(decision.rates)[1])
    assert len(turned) == 3
    assert sum(turned) == pytest.approx(np.radians(-135.0))
    assert np.abs(turned).max() <= 1.0 + 1e-12


def test_navigation_hands_over_to_the_controller():
    rss = 1e-6 * np.cos((np.radians(90 + 10) - EIGHT) / 2) ** 4
    decision = decide(navigator(), ThesisMemory(mode="navigation"), rss)
    expected = FuzzyController().wheel_rates(
        rss, azimuths_rad=EIGHT, cruise_speed_m_per_s=0.09, robot=ROBOT
    )
    assert decision.rates == pytest.approx(expected)
    assert decision.memory.mode == "navigation"


def test_commands_stay_within_the_wheels():
    machine = navigator(robot=replace(ROBOT, max_wheel_speed_m_per_s=0.1))
    rss = 1e-6 * np.cos((np.radians(90 + 70) - EIGHT) / 2) ** 16
    decision = decide(machine, ThesisMemory(mode="navigation"), rss)
    assert decision.rates.max() == pytest.approx(0.1 / 0.0825)


def test_a_null_after_a_strong_field_is_the_tag_and_the_robot_stands():
    machine = navigator()
    first = decide(machine, ThesisMemory(mode="navigation"), reading(2, strength_w=2e-8), STEP)
    assert not first.reached
    assert first.memory.arrival.armed
    second = decide(machine, first.memory, weak(), STEP)
    assert second.reached
    assert (second.rates == 0.0).all()


def test_every_leg_begins_in_rotation_with_a_fresh_arrival_test_and_reckoning():
    machine = navigator()
    memory = ThesisMemory(mode="navigation")
    for _ in range(3):
        memory = decide(machine, memory, reading(2), STEP).memory
    assert memory.place == pytest.approx((0.27, 0.0, 0.0))
    assert not decide(machine, memory, weak(), STEP).reached  # 9 cm after a strong field
    assert machine.begin(1, memory, heading_rad=0.0) == ThesisMemory(target=1)
    with pytest.raises(NavigationError, match="2 arrival tests"):
        machine.begin(2, memory, heading_rad=0.0)


def test_dead_reckoning_follows_the_arc_of_the_odometry():
    machine = navigator()
    memory = ThesisMemory(mode="navigation")
    quarter = Odometry(distance_m=0.1 * np.pi / 2, turn_rad=np.pi / 2)
    memory = decide(machine, memory, reading(2), quarter).memory
    assert memory.place == pytest.approx((0.1, 0.1, np.pi / 2))


def test_silence_waits_in_rotation_and_coasts_in_navigation():
    machine, silent = navigator(), np.zeros(8)
    waiting = decide(machine, ThesisMemory(), silent)
    assert (waiting.rates == 0.0).all()
    assert waiting.memory.mode == "rotation"
    coasting = decide(machine, ThesisMemory(mode="navigation"), silent)
    assert ROBOT.twist(coasting.rates) == pytest.approx([0.09, 0.0])


def test_rerotation_happens_while_its_time_lasts_and_never_by_itself():
    behind, memory = reading(6), ThesisMemory(mode="navigation")
    assert decide(navigator(), memory, behind).mode == "navigation"
    patient = navigator(rerotate_for_s=10.0)
    assert decide(patient, memory, behind).mode == "rotation"
    assert decide(patient, memory, reading(1)).mode == "navigation"  # one of the front three
    assert decide(patient, replace(memory, readings=10), behind).mode == "navigation"


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"rotation": "weakest"}, "rotation is 'weakest'"),
        ({"period_s": 0.0}, "period_s is 0 s"),
        ({"rerotate_for_s": -1.0}, "rerotate_for_s is -1 s"),
    ],
)
def test_navigators_that_cannot_be_are_refused(option, words):
    with pytest.raises(NavigationError) as caught:
        navigator(**option)
    assert words in str(caught.value)
