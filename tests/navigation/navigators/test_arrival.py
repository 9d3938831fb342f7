import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.navigators.arrival import (
    ArrivalState,
    ArrivalTest,
    arrival_tests,
    arrival_threshold_w,
    observe_spread,
    rss_spread_w,
)

STEP_M = 0.09


def spread_at(link, distance_m, heading=np.pi):
    return float(rss_spread_w(link.rss_w(np.array([[distance_m, 0.0, heading]])))[0])


def walk(test, spreads, *, step_m=STEP_M, place_m=None):
    """Indices at which the test fires while the robot drives straight on, or about one place."""
    state, fired = ArrivalState(), []
    for k, spread_w in enumerate(spreads):
        arrived, state = observe_spread(
            test,
            state,
            spread_w=spread_w,
            driven_m=step_m if k else 0.0,
            place_m=(k * step_m, 0.0) if place_m is None else place_m,
        )
        if arrived:
            fired.append(k)
    return fired


@pytest.fixture
def link(free_space_link):
    return free_space_link((0.0, 0.0))


@pytest.fixture
def within_20cm(link):
    return ArrivalTest(threshold_w=arrival_threshold_w(link, (0.0, 0.0), radius_m=0.2))


def test_threshold_is_the_spread_at_the_radius_over_all_directions(link):
    threshold = arrival_threshold_w(link, (0.0, 0.0), radius_m=0.2)
    # Facing the tag, the strongest is antenna 3 and the opposite one receives nothing: by hand.
    height = 2.65
    range_m = np.hypot(0.2, height)
    dipole = 1.6409 * (np.cos(np.pi / 2 * height / range_m) / (0.2 / range_m)) ** 2
    assert threshold == pytest.approx(
        (299_792_458 / 2.4e9 / (4 * np.pi * range_m)) ** 2 * dipole**2, rel=1e-12
    )


def test_threshold_does_not_depend_on_where_the_tag_hangs(free_space_link):
    far = free_space_link((3.5, 2.0))
    near = free_space_link((0.0, 0.0))
    assert arrival_threshold_w(far, (3.5, 2.0), radius_m=0.2) == pytest.approx(
        arrival_threshold_w(near, (0.0, 0.0), radius_m=0.2)
    )


def test_spread_falls_with_the_fourth_power_under_the_tag(link, within_20cm):
    for distance_m in (0.05, 0.1, 0.2, 0.4):
        assert within_20cm.equivalent_distance_m(spread_at(link, distance_m)) == pytest.approx(
            distance_m, rel=0.02
        )


def test_relative_spread_would_never_fire(link):
    relative = []
    for distance_m in (0.01, 0.1, 0.2, 1.0, 3.0):
        rss = link.rss_w(np.array([[distance_m, 0.0, np.pi]]))[0]
        relative.append(np.ptp(rss) / rss.max())
    assert np.ptp(relative) < 1e-9


def test_approach_fires_at_the_first_sample_inside_the_radius(link, within_20cm):
    distances = np.arange(4.0, -1.0, -STEP_M)
    fired = walk(within_20cm, [spread_at(link, abs(d)) for d in distances])
    assert distances[fired[0]] <= 0.2 < distances[fired[0] - 1]


def test_a_tag_too_far_to_be_strong_does_not_fire_until_it_has_been_passed_through(
    link, within_20cm
):
    distances = np.arange(1500.0, 0.0, -0.5)
    spreads = [spread_at(link, d) for d in distances]
    small = np.array(spreads) <= within_20cm.threshold_w
    assert small[:100].all()  # the spread alone would have fired at once
    fired = walk(within_20cm, spreads, step_m=0.5)
    assert not fired or distances[fired[0]] <= 0.2


def test_noise_at_the_far_limit_does_not_fire(link, within_20cm):
    rng = np.random.default_rng(4)
    far_m = 750.0
    assert spread_at(link, far_m) == pytest.approx(within_20cm.threshold_w, rel=0.1)
    noisy = spread_at(link, far_m) * 10 ** (rng.normal(0, 2.0, 3000) / 10)
    assert walk(within_20cm, noisy, step_m=0.01) == []


def test_entering_a_shadow_does_not_fire_but_the_tag_behind_it_does(link, within_20cm):
    distances = np.arange(3.0, -0.5, -STEP_M)
    spreads = np.array([spread_at(link, abs(d)) for d in distances])
    shadow = (distances < 2.5) & (distances > 1.6)
    spreads[shadow] *= 1e-6
    assert (spreads[shadow] < within_20cm.threshold_w).all()
    fired = walk(within_20cm, spreads)
    assert 0.0 < distances[fired[0]] <= 0.2


def test_a_robot_that_fell_silent_under_the_tag_too_fast_and_stays_there_arrives(link, within_20cm):
    spreads = [spread_at(link, 2.0)] + [spread_at(link, 0.1)] * 60
    straight = walk(within_20cm, spreads)
    assert straight == []
    hovering = walk(within_20cm, spreads, place_m=(0.1, 0.0))
    # The bound of the strong reading has to be driven off first, then 5 R more.
    bound_m = within_20cm.equivalent_distance_m(spreads[0]) / 10 ** (16 / 40)
    assert STEP_M * hovering[0] == pytest.approx(bound_m - 0.2 + 5 * 0.2, abs=2 * STEP_M)


def test_a_shadow_that_deepens_step_by_step_does_not_fire_either(link, within_20cm):
    distances = np.arange(3.0, -0.5, -STEP_M)
    spreads = np.array([spread_at(link, abs(d)) for d in distances])
    begin = np.flatnonzero(distances < 2.5)[0]
    spreads[begin : begin + 6] *= 10.0 ** -np.arange(1.0, 7.0)
    assert spreads[begin + 5] < within_20cm.threshold_w
    assert 0.0 < distances[walk(within_20cm, spreads)[0]] <= 0.2


def test_a_leg_that_begins_in_a_shadow_does_not_fire_there(link, within_20cm):
    distances = np.arange(3.0, 0.0, -STEP_M)
    spreads = np.array([spread_at(link, d) for d in distances])
    spreads[distances > 1.5] *= 1e-6
    assert distances[walk(within_20cm, spreads)[0]] <= 0.2


def test_a_robot_that_begins_under_the_tag_and_stays_there_arrives(link, within_20cm):
    # It hovers at 10 cm: never far enough out to have crossed the lobe.
    spreads = [spread_at(link, 0.1)] * 30
    fired = walk(within_20cm, spreads, place_m=(0.1, 0.0))
    assert STEP_M * (fired[0] - 1) < 5 * 0.2 <= STEP_M * fired[0] + 1e-12
    assert walk(within_20cm, spreads) == []  # driving away all the time: not under a tag


def test_silence_is_never_an_arrival(link, within_20cm):
    spreads = [spread_at(link, d) for d in (1.0, 0.5, 0.3)] + [0.0] * 20
    assert walk(within_20cm, spreads) == []


def test_a_fade_on_the_way_does_not_block_the_arrival(link, within_20cm):
    distances = np.arange(2.0, -0.3, -STEP_M)
    spreads = np.array([spread_at(link, abs(d)) for d in distances])
    spreads[np.argmin(np.abs(distances - 0.9))] *= 1e-6
    assert spreads.min() < within_20cm.threshold_w
    assert abs(distances[walk(within_20cm, spreads)[0]]) <= 0.2


def test_tests_for_a_mission_come_in_its_order(free_space_link):
    links = {"low": free_space_link((1.0, 0.0), height_m=2.0), "high": free_space_link((3.0, 1.0))}
    tests = arrival_tests(links, ["high", "low"], [(3.0, 1.0), (1.0, 0.0)], radius_m=0.3)
    assert [test.radius_m for test in tests] == [0.3, 0.3]
    # (R/h)^4 / h^2: the lower tag's null is the narrower one.
    assert tests[1].threshold_w > 5 * tests[0].threshold_w


def test_thresholds_that_cannot_be_are_refused(link):
    class Dead:
        def rss_w(self, poses):
            return np.zeros((len(poses), 8))

    with pytest.raises(NavigationError, match="arrival cannot be detected"):
        arrival_threshold_w(Dead(), (0.0, 0.0), radius_m=0.2)
    with pytest.raises(NavigationError, match=r"radius_m is -0\.2"):
        arrival_threshold_w(link, (0.0, 0.0), radius_m=-0.2)
    with pytest.raises(NavigationError, match="did you mean 'a'"):
        arrival_tests({"a": link}, ["b"], [(0.0, 0.0)])
    with pytest.raises(NavigationError, match="arming_ratio is 1"):
        ArrivalTest(threshold_w=1e-9, arming_ratio=1.0)
    with pytest.raises(NavigationError, match="threshold_w is 0"):
        ArrivalTest(threshold_w=0.0)
