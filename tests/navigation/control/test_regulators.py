import json
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import NavigationError
from octant.navigation.control.closed_loop import integrate
from octant.navigation.control.docking_law import TwistLimits
from octant.navigation.control.polar import polar_rate, pose_in_goal_frame
from octant.navigation.control.regulators import CartesianRegulator, GracefulLaw, posture_regulator

REFERENCE = json.loads(
    (Path(__file__).parents[2] / "reference" / "navigation" / "closed_loop.json").read_text()
)["regulators"]
LAWS = {"cart": CartesianRegulator(), "post": posture_regulator()}


@pytest.mark.parametrize(
    "run", REFERENCE["runs"], ids=lambda r: f"{r['regulator']} from {r['q0'][:2]}"
)
def test_the_runs_of_figures_11_19_and_11_20_follow_the_reference(run):
    loop = integrate(LAWS[run["regulator"]], run["q0"], REFERENCE["times"])
    np.testing.assert_allclose(loop.pose, run["states"], atol=2e-9)
    np.testing.assert_allclose(loop.twist, np.transpose([run["v"], run["w"]]), atol=2e-9)
    dense = integrate(LAWS[run["regulator"]], run["q0"], np.linspace(0.0, 8.0, 400))
    assert np.count_nonzero(np.diff(np.sign(dense.twist[:, 0]))) == run["inversions"]


def test_the_cartesian_law_is_the_textbooks_in_cartesian_coordinates():
    from octant.navigation.control.polar import polar_state

    for x, y, heading in np.random.default_rng(1).uniform(-3, 3, (20, 3)):
        angle = np.arctan2(y, x) - heading + np.pi
        want = [
            -(x * np.cos(heading) + y * np.sin(heading)),
            3.0 * np.arctan2(np.sin(angle), np.cos(angle)),
        ]
        np.testing.assert_allclose(LAWS["cart"].twist(polar_state([x, y, heading])), want)


def test_the_graceful_law_drives_the_heading_to_its_lead_angle():
    # z = -α - atan(k1 φ)... obeys dz/dt = -k2 (v/e) z, equation (10) of the authors.
    law = GracefulLaw()
    states = np.random.default_rng(2).uniform([0.2, -2, -2], [3, 2, 2], (40, 3))
    twist = law.twist(states)
    rate = polar_rate(states, twist)
    phi = states[:, 2]
    z = states[:, 1] + np.arctan(law.k1 * phi)
    dz = rate[:, 1] + law.k1 / (1 + (law.k1 * phi) ** 2) * rate[:, 2]
    np.testing.assert_allclose(dz, -law.k2 * twist[:, 0] / states[:, 0] * z, atol=1e-12)


def test_the_graceful_path_does_not_depend_on_its_speed():
    start = [-2.0, 1.0, 1.0]
    slow, fast = GracefulLaw(max_speed_m_per_s=0.1), GracefulLaw(max_speed_m_per_s=0.2)
    first = integrate(slow, start, [4.0, 10.0, 20.0], tolerance=1e-10)
    second = integrate(fast, start, [2.0, 5.0, 10.0], tolerance=1e-10)
    np.testing.assert_allclose(first.pose, second.pose, atol=1e-8)


def test_every_law_arrives_and_those_with_a_heading_arrive_with_it():
    start = [-1.5, 1.0, 1.0]
    for law, seconds in ((LAWS["cart"], 20.0), (LAWS["post"], 20.0), (GracefulLaw(), 80.0)):
        loop = integrate(law, start, [seconds], limits=TwistLimits(), tolerance=1e-9)
        assert loop.polar[0, 0] < 0.1
        if law is not LAWS["cart"]:
            assert abs(loop.pose[0, 2]) < 0.05


def test_the_goal_sees_a_pose_where_it_is():
    rng = np.random.default_rng(3)
    poses, goals = rng.uniform(-3, 3, (10, 3)), rng.uniform(-3, 3, (10, 3))
    ahead, left, turn = pose_in_goal_frame(poses, goals).T
    back = goals[:, :2].T + ahead * np.array([np.cos(goals[:, 2]), np.sin(goals[:, 2])])
    back += left * np.array([-np.sin(goals[:, 2]), np.cos(goals[:, 2])])
    np.testing.assert_allclose(back.T, poses[:, :2], atol=1e-14)
    np.testing.assert_allclose(np.cos(goals[:, 2] + turn - poses[:, 2]), 1.0, atol=1e-14)
    seen = pose_in_goal_frame([2, 3, 1], [2, 2, np.pi / 2])
    np.testing.assert_allclose(seen, [1, 0, 1 - np.pi / 2], atol=1e-15)


def test_bad_gains_starts_and_times_are_refused():
    with pytest.raises(NavigationError, match="k2_per_s"):
        CartesianRegulator(k2_per_s=-1.0)
    with pytest.raises(NavigationError, match="slowing_radius_m"):
        GracefulLaw(slowing_radius_m=0.0)
    with pytest.raises(NavigationError, match="the goal"):
        integrate(LAWS["cart"], [0.0, 0.0, 1.0], [1.0])
    with pytest.raises(NavigationError, match="ascend"):
        integrate(LAWS["cart"], [1.0, 0.0, 1.0], [1.0, 1.0])
