import itertools

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive, ramp
from octant.navigation.robot.kinematics import CarDrive, SynchroDrive
from octant.navigation.robot.odometry import Rolling, RollingWheels

SCOUT = DifferentialDrive()
CAR = CarDrive(wheelbase_m=0.4, steering_limit_rad=np.radians(30.0))
SYNCHRO = SynchroDrive(turn_rate_limit_rad_per_s=1.5)
RNG = np.random.default_rng(0)


def rates_of(robot, speed, turn_rate):
    return robot.wheel_rates(speed_m_per_s=speed, turn_rate_rad_per_s=turn_rate)


def test_a_car_drives_the_circle_of_the_bicycle_model():
    """Independent: both axles' wheels roll along themselves about one centre, R = L / tan δ."""
    steering, period_s = np.radians(20.0), 0.05
    turn_rate = 0.3 * np.tan(steering) / CAR.wheelbase_m
    rates = CAR.saturate(rates_of(CAR, 0.3, turn_rate))
    poses = [np.zeros(3)]
    for _ in range(200):
        poses.append(CAR.step_arc(poses[-1], rates, period_s=period_s))
    poses = np.array(poses)
    radius = CAR.wheelbase_m / np.tan(steering)
    assert np.hypot(poses[:, 0], poses[:, 1] - radius) == pytest.approx(radius)
    # The front wheel's centre moves along the wheel's own direction.
    front = poses[:, :2] + CAR.wheelbase_m * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], 1)
    assert np.hypot(front[:, 0], front[:, 1] - radius) == pytest.approx(
        CAR.wheelbase_m / np.sin(steering)
    )


@pytest.mark.parametrize("speed", [0.4, -0.4])
def test_a_car_turns_within_its_least_radius_at_best(speed):
    least = 0.4 / np.tan(np.radians(30.0))
    assert CAR.least_radius_m == pytest.approx(least)
    for wanted in (0.1, 5.0, -5.0):
        v, w = CAR.twist(CAR.saturate(rates_of(CAR, speed, wanted)))
        assert abs(w) <= abs(v) / least * (1.0 + 1e-12)
        if abs(wanted) < abs(speed) / least:
            assert (v, w) == pytest.approx((speed, wanted))
    assert CAR.saturate(rates_of(CAR, 0.0, 1.0)) == pytest.approx([0.0, 0.0])


def test_a_car_at_full_lock_has_its_outer_wheel_at_the_limit():
    w = CAR.turning_limit_rad_per_s(10.0)
    rates = rates_of(CAR, *CAR.turning(w))
    assert CAR.saturate(rates) == pytest.approx(rates)
    assert rates.max() == pytest.approx(CAR.max_wheel_rate_rad_per_s)
    assert CAR.turning(-1.0, reverse=True) == pytest.approx((-CAR.least_radius_m, -1.0))
    assert CAR.turning_limit_rad_per_s(0.1) == pytest.approx(0.1 / CAR.least_radius_m)


@pytest.mark.parametrize(
    ("place", "inside"), [((0.0, 0.5), True), ((1.0, 0.2), False), ((0.0, 1.5), False)]
)
def test_what_lies_inside_the_tightest_circle_is_not_reached_ahead(place, inside):
    assert CAR.encircles(*place) == inside
    assert not SCOUT.encircles(*place)


def test_heading_and_speed_of_a_synchro_drive_are_independent():
    v, w = SYNCHRO.twist(SYNCHRO.saturate(rates_of(SYNCHRO, 9.0, 9.0)))
    assert (v, w) == pytest.approx((0.75, 1.5))
    v, w = SYNCHRO.twist(SYNCHRO.saturate(rates_of(SYNCHRO, 0.2, 9.0)))
    assert (v, w) == pytest.approx((0.2, 1.5))
    assert SYNCHRO.max_turn_rate_rad_per_s == pytest.approx(1.5)
    # What a planner that knows wheel rates only may ask for can be done.
    corners = np.array(list(itertools.product([-1.0, 0.3, 1.0], repeat=2)))
    wanted = SYNCHRO.max_wheel_rate_rad_per_s * corners
    assert SYNCHRO.saturate(wanted) == pytest.approx(wanted)


@pytest.mark.parametrize("robot", [SCOUT, SYNCHRO], ids=["differential", "synchro"])
def test_shafts_and_wheel_rates_say_the_same(robot):
    rates = RNG.normal(size=(5, 2))
    assert robot.of_shafts(robot.shafts(rates)) == pytest.approx(rates)


@pytest.mark.parametrize("wanted", [8.0, 1.0, -2.0])
def test_a_ramp_turns_as_far_as_its_integral(wanted):
    slope, period_s, before = 4.0, 1.0, 2.0
    times = np.linspace(0.0, period_s, 200_001)
    rate = before + np.clip(wanted - before, -slope * times, slope * times)
    mean, end = ramp(before, wanted, period_s=period_s, acceleration=slope)
    assert mean == pytest.approx(0.5 * (rate[1:] + rate[:-1]).mean(), abs=1e-6)
    assert end == pytest.approx(rate[-1])


def test_from_rest_the_way_is_that_of_constant_acceleration():
    wheels = RollingWheels(Rolling(acceleration_rad_per_s2=2.0), SCOUT, RNG)
    turned = [0.1 * wheels.turn(np.full(2, 5.0), period_s=0.1) for _ in range(40)]
    # t = v/a = 2.5 s of ramp, 1.5 s at 5 rad/s.
    assert np.sum(turned, axis=0) == pytest.approx(np.full(2, 0.5 * 5.0 * 2.5 + 1.5 * 5.0))


@pytest.mark.parametrize("robot", [SCOUT, CAR, SYNCHRO], ids=["differential", "car", "synchro"])
def test_below_the_dead_band_nothing_moves(robot):
    wheels = RollingWheels(Rolling(dead_band_rad_per_s=0.5), robot, RNG)
    assert wheels.turn(np.full(2, 0.49), period_s=1.0) == pytest.approx(np.zeros(2))
    assert wheels.turn(np.full(2, 0.51), period_s=1.0) == pytest.approx(np.full(2, 0.51))


def test_a_braking_car_keeps_its_circle():
    wheels = RollingWheels(Rolling(acceleration_rad_per_s2=1.0), CAR, RNG)
    for command in (rates_of(CAR, 0.3, 0.2), np.zeros(2), rates_of(CAR, -0.3, -0.2)):
        v, w = CAR.twist(wheels.turn(command, period_s=0.5))
        assert w / v == pytest.approx(0.2 / 0.3)


def test_encoders_of_a_synchro_drive_count_rolling_and_steering():
    tick = 0.01
    wheels = RollingWheels(Rolling(tick_rad=tick), SYNCHRO, RNG)
    rotations = 0.1 * rates_of(SYNCHRO, 0.123, 0.456)
    counted = SYNCHRO.shafts(sum(wheels.count(rotations) for _ in range(7)))
    assert counted / tick == pytest.approx(np.round(counted / tick))
    assert np.abs(counted - 0.7 * np.array([0.123 / 0.0825, 0.456])).max() <= tick


def test_constant_slip_adds_to_a_robot_that_moves():
    wheels = RollingWheels(Rolling(linear_m_per_s=-0.01, angular_rad_per_s=0.02), SCOUT, RNG)
    rolled = wheels.roll(2.0 * rates_of(SCOUT, 0.3, 0.1), period_s=2.0)
    assert SCOUT.twist(rolled) == pytest.approx([2.0 * 0.29, 2.0 * 0.12])
    assert wheels.roll(np.zeros(2), period_s=2.0) == pytest.approx(np.zeros(2))


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: CarDrive(wheelbase_m=0.0, steering_limit_rad=0.5), "wheelbase_m"),
        (lambda: CarDrive(wheelbase_m=0.4, steering_limit_rad=1.6), "right angle"),
        (lambda: SynchroDrive(turn_rate_limit_rad_per_s=-1.0), "turn_rate_limit"),
        (
            lambda: SynchroDrive(turn_rate_limit_rad_per_s=1.0, turn_acceleration_rad_per_s2=0.0),
            "turn_acceleration",
        ),
        (lambda: Rolling(acceleration_rad_per_s2=0.0), "acceleration"),
        (lambda: Rolling(linear_m_per_s=np.inf), "finite"),
    ],
)
def test_impossible_robots_are_refused(make, word):
    with pytest.raises(NavigationError, match=word):
        make()
