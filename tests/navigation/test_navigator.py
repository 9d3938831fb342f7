from dataclasses import replace

import numpy as np
import pytest

from octant.navigation.arrival import ArrivalTest
from octant.navigation.controllers import FuzzyController
from octant.navigation.navigator import Navigator, NavigatorState
from octant.navigation.robot import DifferentialDrive

EIGHT = np.radians(45.0 * np.arange(8))
ROBOT = DifferentialDrive()
TEST = ArrivalTest(threshold_w=1e-9)


def navigator(**options):
    settings = {
        "arrivals": (TEST, TEST),
        "azimuths_rad": EIGHT,
        "controller": FuzzyController(),
        "robot": ROBOT,
        "cruise_speed_m_per_s": 0.09,
        "period_s": 1.0,
    }
    return Navigator(**(settings | options))


def reading(antenna, *, strength_w=1e-6):
    rss = np.full(8, 0.1 * strength_w)
    rss[antenna] = strength_w
    return rss


def weak():
    """A reading with a spread below the threshold, ahead."""
    return reading(2, strength_w=1e-10)


def test_rotation_turns_on_the_spot_to_the_strongest_antenna_in_one_period():
    rates, state = navigator().decide(NavigatorState(), reading(0))
    assert ROBOT.twist(rates) == pytest.approx([0.0, -np.pi / 2])
    assert state.mode == "navigation"
    assert state.driven_m == 0.0


def test_rotation_can_use_the_vector_sum():
    rss = 1 + np.cos(np.radians(90 + 25) - EIGHT)
    rates, _ = navigator(rotation="vector_sum").decide(NavigatorState(), rss)
    assert ROBOT.twist(rates)[1] == pytest.approx(np.radians(25))


def test_rotation_beyond_the_wheels_takes_several_periods_and_one_bearing():
    slow = replace(ROBOT, max_wheel_speed_m_per_s=0.15)  # 1 rad a period
    machine = navigator(robot=slow)
    state, turned = NavigatorState(), []
    while state.mode == "rotation":
        # Later readings name another antenna, which must not matter.
        rates, state = machine.decide(state, reading(7 if not turned else 4))
        turned.append(slow.twist(rates)[1])
    assert len(turned) == 3
    assert sum(turned) == pytest.approx(np.radians(-135.0))
    assert np.abs(turned).max() <= 1.0 + 1e-12


def test_navigation_hands_over_to_the_controller():
    state = NavigatorState(mode="navigation")
    rss = 1e-6 * np.cos((np.radians(90 + 10) - EIGHT) / 2) ** 4
    rates, after = navigator().decide(state, rss)
    expected = FuzzyController().wheel_rates(
        rss, azimuths_rad=EIGHT, cruise_speed_m_per_s=0.09, robot=ROBOT
    )
    assert rates == pytest.approx(expected)
    assert after.mode == "navigation"
    assert after.driven_m == pytest.approx(0.09)


def test_commands_stay_within_the_wheels():
    machine = navigator(robot=replace(ROBOT, max_wheel_speed_m_per_s=0.1))
    rss = 1e-6 * np.cos((np.radians(90 + 70) - EIGHT) / 2) ** 16
    rates, _ = machine.decide(NavigatorState(mode="navigation"), rss)
    assert rates.max() == pytest.approx(0.1 / 0.0825)


def test_reaching_a_tag_selects_the_next_one_and_rotates():
    machine = navigator()
    state = NavigatorState(mode="navigation", driven_m=0.09)
    arrived, state = machine.arrived(state, reading(2, strength_w=2e-8))
    assert not arrived
    assert state.arrival.armed
    arrived, state = machine.arrived(replace(state, driven_m=0.09), weak())
    assert arrived
    assert (state.mode, state.target, state.arrival.armed) == ("rotation", 1, False)


def test_reaching_the_last_tag_stops():
    machine = navigator()
    state = NavigatorState(mode="navigation", target=1)
    _, state = machine.arrived(state, reading(2, strength_w=2e-8))
    arrived, state = machine.arrived(replace(state, driven_m=0.09), weak())
    assert arrived
    assert (state.mode, state.target) == ("stopped", 1)
    rates, _ = machine.decide(state, weak())
    assert (rates == 0.0).all()


def test_silence_waits_in_rotation_and_coasts_in_navigation():
    machine = navigator()
    silent = np.zeros(8)
    arrived, state = machine.arrived(NavigatorState(), silent)
    assert not arrived
    rates, state = machine.decide(state, silent)
    assert (rates == 0.0).all()
    assert (state.mode, state.silent_readings) == ("rotation", 1)
    _, state = machine.arrived(NavigatorState(mode="navigation"), silent)
    rates, state = machine.decide(state, silent)
    assert ROBOT.twist(rates) == pytest.approx([0.09, 0.0])
    assert state.silent_readings == 1
    _, state = machine.arrived(state, reading(2))
    assert state.silent_readings == 0


def test_dead_reckoning_begins_anew_with_every_leg():
    machine = navigator()
    state = NavigatorState(mode="navigation")
    for _ in range(3):
        _, state = machine.arrived(state, reading(2))
        _, state = machine.decide(state, reading(2))
    assert state.reckoned_pose == pytest.approx((0.27, 0.0, 0.0))
    arrived, state = machine.arrived(state, weak())
    assert not arrived  # 0.09 m cannot have brought it from a strong field to the tag
    state = replace(state, arrival=replace(state.arrival, armed=True, least_distance_m=0.0))
    arrived, state = machine.arrived(state, weak())
    assert arrived
    assert state.reckoned_pose == (0.0, 0.0, 0.0)
