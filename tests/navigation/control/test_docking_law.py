import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import NavigationError, PhysicsWarning
from octant.navigation.angles import wrap_angle
from octant.navigation.control.closed_loop import integrate
from octant.navigation.control.docking_law import (
    DockingLaw,
    TwistLimits,
    faded,
    latched,
    slip_compensated,
    stall_distance_m,
)
from octant.navigation.control.polar import polar_rate, polar_state, pose_of_polar

REFERENCE = json.loads(
    (Path(__file__).parents[2] / "reference" / "navigation" / "closed_loop.json").read_text()
)["docking_law"]
FIG4 = DockingLaw(gamma_per_s=3.0, h=1.0, k_per_s=6.0)
STATES = np.random.default_rng(8).uniform([0.1, -3.0, -3.0], [3.0, 3.0, 3.0], (50, 3))


@pytest.mark.parametrize("run", REFERENCE["fig4"]["runs"], ids=lambda r: f"{r['alpha0_deg']} deg")
def test_the_runs_of_figure_4_follow_the_reference(run):
    alpha = np.radians(run["alpha0_deg"])
    loop = integrate(FIG4, pose_of_polar([3.0, alpha, alpha]), REFERENCE["fig4"]["times"])
    np.testing.assert_allclose(loop.polar, run["polar"], atol=2e-9)
    np.testing.assert_allclose(loop.pose, run["pose"], atol=2e-9)


@pytest.mark.parametrize("run", REFERENCE["saturated"]["runs"], ids=lambda r: str(r["q0"]))
def test_the_saturated_runs_follow_the_reference(run):
    limits = TwistLimits(saturation=run["mode"])
    loop = integrate(DockingLaw(), run["q0"], REFERENCE["saturated"]["times"], limits=limits)
    np.testing.assert_allclose(loop.pose, run["pose"], atol=1e-8)


def test_the_lyapunov_rate_is_the_derivative_along_the_closed_loop():
    for law in (DockingLaw(), FIG4, DockingLaw(approach="reverse")):
        rate = polar_rate(STATES, law.twist(STATES))
        step = 1e-6
        ahead, behind = law.lyapunov(STATES + step * rate), law.lyapunov(STATES - step * rate)
        e, alpha, _ = STATES.T
        if law.approach == "reverse":
            alpha = wrap_angle(alpha + np.pi)
        want = -law.gamma_per_s * (e * np.cos(alpha)) ** 2 - law.k_per_s * alpha**2
        np.testing.assert_allclose((ahead - behind) / (2 * step), want, rtol=1e-6, atol=1e-6)
        assert (want <= 0.0).all()


def test_near_the_goal_distance_and_angles_fall_at_the_predicted_rates():
    law = DockingLaw(gamma_per_s=1.0, h=8.0, k_per_s=6.5)
    slowest = np.roots([1.0, law.k_per_s, law.gamma_per_s**2 * law.h]).real.max()
    loop = integrate(law, pose_of_polar([1.0, 0.01, 0.01]), [4.0, 5.0])
    falls = np.diff(np.log(np.abs(loop.polar)), axis=0)[0]
    assert falls[0] == pytest.approx(-1.0, abs=1e-6)
    assert falls[1:] == pytest.approx([slowest, slowest], abs=0.05)


@pytest.mark.parametrize(("k", "bounded"), [(1.5, False), (2.5, True), (3.5, True), (4.5, False)])
def test_the_curvature_stays_bounded_exactly_inside_the_region_of_the_gains(k, bounded):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        law = DockingLaw(gamma_per_s=1.0, h=3.0, k_per_s=k)
    times = np.linspace(2.0, 14.0, 121)
    loop = integrate(law, pose_of_polar([1.0, 1e-3, 2e-3]), times)
    curvature = np.abs(loop.twist[:, 1] / loop.twist[:, 0])
    assert bool(curvature[-40:].max() < curvature[:40].max()) is bounded


def test_gains_outside_the_region_are_warned_of_with_the_region():
    with pytest.warns(PhysicsWarning, match=r"2 gamma <= k <= gamma \(h \+ 1\), here 2 to 4"):
        DockingLaw(gamma_per_s=1.0, h=3.0, k_per_s=5.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert FIG4.bounded_curvature_per_s == (6.0, 6.0)  # the corner itself


@pytest.mark.parametrize("gains", [{"gamma_per_s": 0.0}, {"h": -1.0}, {"k_per_s": np.nan}])
def test_gains_that_are_not_positive_are_refused(gains):
    with pytest.raises(NavigationError, match=next(iter(gains))):
        DockingLaw(**gains)


def test_a_reverse_run_is_the_forward_run_turned_half_round():
    times = [1.0, 5.0, 20.0]
    forward = integrate(DockingLaw(), [-2.0, 0.5, 0.3], times)
    reverse = integrate(DockingLaw(approach="reverse"), [2.0, -0.5, 0.3], times)
    np.testing.assert_allclose(reverse.pose[:, :2], -forward.pose[:, :2], atol=1e-9)
    np.testing.assert_allclose(reverse.pose[:, 2], forward.pose[:, 2], atol=1e-9)
    np.testing.assert_allclose(reverse.twist[:, 0], -forward.twist[:, 0], atol=1e-9)


def test_from_every_side_the_robot_arrives_with_the_goals_heading():
    law = DockingLaw()
    for azimuth in np.linspace(-np.pi, np.pi, 9)[:-1] + 0.1:
        start = [2.0 * np.cos(azimuth), 2.0 * np.sin(azimuth), 0.4]
        loop = integrate(law, start, [150.0], tolerance=1e-9)
        assert abs(loop.pose[0, 2]) < 1e-3
        assert loop.polar[0, 0] < 1e-3


def test_curvature_saturation_keeps_the_path_and_clipping_does_not():
    start, times = [-2.0, 0.8, 1.2], np.linspace(0.01, 60.0, 2000)
    free = integrate(DockingLaw(), start, times, tolerance=1e-10).pose[:, :2]
    offsets = {}
    for manner in ("curvature", "clip"):
        limits = TwistLimits(saturation=manner)
        loop = integrate(DockingLaw(), start, times, limits=limits, tolerance=1e-10)
        way = loop.pose[:600:10, :2]
        gaps = np.linalg.norm(way[:, None] - free[None], axis=2).min(axis=1)
        offsets[manner] = gaps.max()
    assert offsets["curvature"] < 0.005  # half the spacing of the compared points
    assert offsets["clip"] > 0.1


def test_limits_are_kept_and_small_commands_left_alone():
    wanted = np.array([[0.1, 0.1], [0.4, 0.1], [-0.1, 0.8], [1.0, 1.0]])
    kept = TwistLimits().apply(wanted)
    np.testing.assert_allclose(kept, [[0.1, 0.1], [0.2, 0.05], [-0.025, 0.2], [0.2, 0.2]])
    clipped = TwistLimits(saturation="clip").apply(wanted)
    np.testing.assert_allclose(clipped, [[0.1, 0.1], [0.2, 0.1], [-0.1, 0.2], [0.2, 0.2]])


def test_an_uncompensated_slip_stalls_the_robot_at_b_over_gamma():
    law, slips = DockingLaw(), (-0.01, 0.0)
    assert stall_distance_m(law, -0.01) == pytest.approx(0.08)
    loop = integrate(law, [-2.0, 0.0, 0.0], [120.0], slips=slips)
    assert loop.polar[0, 0] == pytest.approx(0.08, abs=1e-6)
    np.testing.assert_allclose(slip_compensated([0.1, 0.2], slips), [0.11, 0.2])


def test_the_latch_closes_at_the_radius_and_after_passing_the_goal():
    assert latched([0.019, 0.0, 0.0], radius_m=0.02)
    assert not latched([0.021, 0.0, 0.0], radius_m=0.02)
    assert latched([0.05, 3.0, 3.0], radius_m=0.02)
    assert not latched([0.5, 3.0, 3.0], radius_m=0.02)
    assert not latched([0.05, 3.0, 3.0], radius_m=0.02, approach="reverse")


def test_near_the_goal_its_direction_fades_and_the_heading_stays():
    far, near = np.array([0.3, 0.4, 0.6]), np.array([0.0, 0.4, 0.6])
    np.testing.assert_array_equal(faded(far, radius_m=0.2), far)
    # At the goal only the heading's error is left: -θ = α - φ.
    np.testing.assert_allclose(faded(near, radius_m=0.2), [0.0, -0.2, 0.0], atol=1e-15)
    half = faded([0.1, 0.4, 0.6], radius_m=0.2)
    np.testing.assert_allclose(half, [0.1, 0.4 - 0.75 * 0.6, 0.25 * 0.6], atol=1e-15)
    behind = faded([0.0, np.pi + 0.4, np.pi + 0.6], radius_m=0.2, approach="reverse")
    np.testing.assert_allclose(behind, [0.0, np.pi - 0.2, np.pi], atol=1e-15)


def test_polar_states_continue_through_half_a_turn():
    poses = [[np.cos(a), np.sin(a), 0.0] for a in np.linspace(-0.5, 0.5, 21)]
    state = polar_state(poses[0])
    for pose in poses:
        following = polar_state(pose, previous=state)
        assert np.abs(following - state).max() < 0.06
        state = following
    np.testing.assert_allclose(pose_of_polar(state), poses[-1], atol=1e-14)
