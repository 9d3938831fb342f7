import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.control.controllers import FuzzyController, VectorSumController
from octant.navigation.control.fuzzy import Rule, RuleBase, thesis_rule_base
from octant.navigation.robot.drive import DifferentialDrive

EIGHT = np.radians(45.0 * np.arange(8))
ROBOT = DifferentialDrive()
CONTROLLERS = [
    FuzzyController(),
    FuzzyController(steering_input="nanowatt"),
    VectorSumController(),
]


def rss_from(bearing_deg, *, scale_w=1e-6, azimuths=EIGHT):
    """RSS of cardioid antennas for a tag at an angle left of the front."""
    return scale_w * np.cos((np.radians(90 + bearing_deg) - azimuths) / 2) ** 4


def twist(controller, rss, *, azimuths=EIGHT):
    rates = controller.wheel_rates(
        rss, azimuths_rad=azimuths, cruise_speed_m_per_s=0.1, robot=ROBOT
    )
    return ROBOT.twist(rates)


@pytest.mark.parametrize("controller", CONTROLLERS, ids=["normalised", "nanowatt", "vector"])
def test_straight_ahead_is_driven_at_cruise_speed(controller):
    assert twist(controller, rss_from(0.0)) == pytest.approx([0.1, 0.0], abs=1e-12)


@pytest.mark.parametrize("controller", CONTROLLERS, ids=["normalised", "nanowatt", "vector"])
@pytest.mark.parametrize("bearing_deg", [5.0, 20.0, 60.0])
def test_robot_turns_towards_the_tag_and_mirrors_it(controller, bearing_deg):
    left = twist(controller, rss_from(bearing_deg))
    right = twist(controller, rss_from(-bearing_deg))
    assert left[1] > 0.005
    assert right == pytest.approx(left * [1, -1], abs=1e-12)


def test_normalised_input_does_not_depend_on_the_field_strength():
    controller = FuzzyController()
    strong = controller.steering(rss_from(20.0), EIGHT)
    assert controller.steering(rss_from(20.0, scale_w=1e-12), EIGHT) == pytest.approx(strong)
    z2, z4 = rss_from(20.0)[[1, 3]]
    assert strong == pytest.approx((z2 - z4) / (z2 + z4))
    assert strong < 0  # the tag is on the left: negative, so the right wheel is the faster


def test_nanowatt_input_is_the_difference_over_1200_nw_and_clipped():
    controller = FuzzyController(steering_input="nanowatt")
    rss = np.zeros(8)
    rss[1], rss[3] = 700e-9, 100e-9
    assert controller.steering(rss, EIGHT) == pytest.approx(0.5)
    rss[1] = 5e-6
    assert controller.steering(rss, EIGHT) == 1.0


def test_nanowatt_input_starves_under_the_tag_and_the_normalised_one_does_not():
    weak = rss_from(30.0, scale_w=1e-9)
    assert abs(twist(FuzzyController(steering_input="nanowatt"), weak)[1]) < 1e-3
    assert abs(twist(FuzzyController(), weak)[1]) > 0.1


def test_neither_neighbour_receiving_means_straight_on():
    rss = np.zeros(8)
    rss[2] = 1e-9
    assert FuzzyController().steering(rss, EIGHT) == 0.0


@pytest.mark.parametrize("antennas", [4, 6, 12])
def test_fuzzy_controller_works_for_other_even_numbers_of_antennas(antennas):
    azimuths = 2 * np.pi * np.arange(antennas) / antennas
    ahead = rss_from(0.0, azimuths=azimuths)
    assert twist(FuzzyController(), ahead, azimuths=azimuths)[1] == pytest.approx(0.0, abs=1e-12)
    left = rss_from(20.0, azimuths=azimuths)
    assert twist(FuzzyController(), left, azimuths=azimuths)[1] > 0.01


def test_vector_sum_law_is_the_gain_times_the_bearing_error_and_stops_facing_away():
    controller = VectorSumController(gain_per_s=0.4)
    cardioid = 1 + np.cos(np.radians(90 + 30) - EIGHT)
    assert twist(controller, cardioid) == pytest.approx(
        [0.1 * np.cos(np.radians(30)), 0.4 * np.radians(30)]
    )
    behind = 1 + np.cos(np.radians(90 + 150) - EIGHT)
    assert twist(controller, behind) == pytest.approx([0.0, 0.4 * np.radians(150)], abs=1e-12)


def test_controllers_that_cannot_be_are_refused():
    with pytest.raises(NavigationError, match="steering_input is 'watt'"):
        FuzzyController(steering_input="watt")
    with pytest.raises(NavigationError, match="full_scale_w is 0"):
        FuzzyController(full_scale_w=0.0)
    with pytest.raises(NavigationError, match="gain_per_s is -1"):
        VectorSumController(gain_per_s=-1.0)
    base = thesis_rule_base()
    single = RuleBase(
        input_variable=base.input_variable,
        outputs=base.outputs[:1],
        rules=tuple(Rule(when=rule.when, then=rule.then[:1]) for rule in base.rules),
    )
    with pytest.raises(NavigationError, match="1 outputs, but the robot has two"):
        FuzzyController(rules=single)
