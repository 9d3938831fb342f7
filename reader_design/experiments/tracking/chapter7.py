"""Chapter 7: nominal control, neighbouring control with its filters and peers, and EKF SLAM."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.navigation.estimators.ekf_slam import SlamRecord, SlamTask, run_slam
from octant.navigation.estimators.kalman_bucy import KalmanBucy
from octant.navigation.estimators.pose_filters import PoseEstimator, WheelMotion
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    RssAssumptions,
    UnscentedKalman,
)
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import drive, run_seeds
from octant.navigation.tracking.controllers import (
    NeighbouringControl,
    OpenLoop,
    PredictiveControl,
    TrackingController,
)
from octant.navigation.tracking.neighbouring import (
    StabilityReport,
    riccati_gains,
    stability_report,
)
from octant.navigation.tracking.nominal import (
    BoundedIlqr,
    GainDescent,
    InputSearch,
    NominalSolution,
    NominalSolver,
)
from octant.navigation.tracking.problem import TrackingProblem, Weights
from octant.navigation.tracking.trajectories import (
    Curve,
    DesiredTrajectory,
    check_feasible,
    desired_trajectory,
)
from octant.reader_design.experiments.tracking.outcomes import Outcome, outcome_of
from octant.reader_design.experiments.tracking.settings import (
    EULER_STEP_S,
    LEMNISCATE_START,
    NOMINAL_PERIOD_S,
    POINT_GOAL,
    POINT_START,
    Settings,
)

FloatArray = npt.NDArray[np.float64]

NOMINAL_TASKS: tuple[tuple[Curve, tuple[float, float, float]], ...] = (
    (shapes.fixed_pose(POINT_GOAL), POINT_START),
    (shapes.sigmoid(), (-3.0, -3.0, math.radians(45.0))),
    (shapes.parabola(), (-4.0, 5.0, 0.0)),
    (shapes.ellipse(), (3.0, -0.2, math.radians(45.0))),
)
"""Thesis 7.5.1: curve and start [m, rad]. The parabola's start is not printed: this one is chosen
so that the error is about the printed 0.18 m."""
PRINTED_TASKS = ("point", "ellipse")
"""Tasks that the printed update solves too: it takes seconds for each."""
EIGHT_POSES_RADIUS_M = 4.0
"""The eight poses of Fig. 7.3(b) are not printed: here on this circle, heading outwards [m]."""
ILQR, LBFGSB, PRINTED = "bounded iLQR", "L-BFGS-B on the inputs", "printed gain update"
EKF, BUCY, MPC = "neighbouring + EKF", "neighbouring + Kalman-Bucy", "predictive + UKF"
IGNORED, BLIND = "neighbouring + EKF, mean ignored", "nominal inputs, no feedback"
WHEEL_SIGMAS_RAD_PER_S = (0.01, 0.1, 0.3, 0.5)
"""Wheel noises whose effect is shown, since the thesis prints none [rad/s]."""
SLAM_TAGS_M = ((-0.2, 0.1), (2.1, 0.1), (2.1, 3.1), (-0.2, 3.1))
"""Tags of thesis 7.6.1 [m]."""
SLAM_WHEEL_SIGMAS_RAD_PER_S = (0.01, 0.1)
"""The printed wheel noise of 7.7, and ten times it, at which the thesis says that SLAM fails."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NominalRun:
    """Return one nominal problem solved by one method.

    Parameters
    ----------
    outcome : Outcome
        Errors and way.
    solution : NominalSolution
        With the cost after every iteration.
    """

    outcome: Outcome
    solution: NominalSolution


def nominal_runs(settings: Settings) -> tuple[NominalRun, ...]:
    """Return thesis 7.5.1 solved: point, curves and eight poses, some by all three solvers.

    Parameters
    ----------
    settings : Settings
        Robot and weights.
    """
    runs = []
    for curve, start in NOMINAL_TASKS:
        runs.append(_nominal(settings, curve, start, ILQR, BoundedIlqr()))
        if curve.name in PRINTED_TASKS:
            runs.append(_nominal(settings, curve, start, PRINTED, GainDescent()))
        if curve.name == "ellipse":
            search = InputSearch(iterations=400, first_rates_rad_per_s=((0.1, 0.1),))
            runs.append(_nominal(settings, curve, start, LBFGSB, search))
    runs.append(_eight_poses(settings))
    return tuple(runs)


def nominal_problem(
    settings: Settings,
    curve: Curve,
    start: tuple[float, float, float],
    *,
    period_s: float = NOMINAL_PERIOD_S,
    weights: Weights | None = None,
) -> TrackingProblem:
    """Return a nominal problem of a curve.

    Parameters
    ----------
    settings : Settings
        Robot and weights.
    curve : Curve
        The way; a period that does not divide it is made a little shorter.
    start : (3,) tuple of float
        x [m], y [m], heading [rad].
    period_s : float
        For which wheel rates are held, at most [s].
    weights : Weights or None
        None: those of trajectories.
    """
    substeps = round(period_s / EULER_STEP_S)
    intervals = math.ceil(curve.duration_s / (substeps * EULER_STEP_S) - 1e-9)
    step_s = curve.duration_s / (intervals * substeps)
    desired = desired_trajectory(curve, period_s=step_s)
    check_feasible(desired, settings.robot)
    return TrackingProblem(
        desired=desired,
        start=np.array(start),
        weights=weights or settings.weights,
        robot=settings.robot,
        substeps=substeps,
    )


def _nominal(
    settings: Settings,
    curve: Curve,
    start: tuple[float, float, float],
    method: str,
    solver: NominalSolver,
) -> NominalRun:
    problem = nominal_problem(settings, curve, start)
    solution = solver.solve(problem)
    outcome = Outcome(
        chapter="nominal",
        task=curve.name,
        method=method,
        desired=problem.desired,
        poses=solution.poses[None],
        example_rates=solution.wheel_rates,
    )
    return NominalRun(outcome=outcome, solution=solution)


def _eight_poses(settings: Settings) -> NominalRun:
    curve = shapes.fixed_pose((0.0, 0.0, 0.5 * math.pi))
    solutions = []
    for angle in 2.0 * np.pi * np.arange(8) / 8:
        place = EIGHT_POSES_RADIUS_M * np.array([np.cos(angle), np.sin(angle)])
        problem = nominal_problem(settings, curve, (float(place[0]), float(place[1]), float(angle)))
        solutions.append(BoundedIlqr().solve(problem))
    outcome = Outcome(
        chapter="nominal",
        task="eight poses",
        method=ILQR,
        desired=problem.desired,
        poses=np.array([s.poses for s in solutions]),
        example_rates=solutions[0].wheel_rates,
    )
    return NominalRun(outcome=outcome, solution=solutions[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class NeighbouringSetup:
    """Return a neighbouring control ready to be driven, and what its theory says.

    Parameters
    ----------
    desired : DesiredTrajectory
        At the control period.
    start : (3,) tuple of float
        x [m], y [m], heading [rad].
    control : NeighbouringControl
        Nominal inputs and gains.
    stability : StabilityReport
        Lyapunov decay and Gramians along the nominal trajectory.
    weights : Weights
        Its weights.
    """

    desired: DesiredTrajectory
    start: tuple[float, float, float]
    control: NeighbouringControl
    stability: StabilityReport
    weights: Weights


def neighbouring_setup(
    settings: Settings,
    curve: Curve,
    start: tuple[float, float, float],
    *,
    weights: Weights | None = None,
) -> NeighbouringSetup:
    """Return the neighbouring control of a curve: nominal solution, Riccati gains, diagnostics.

    Parameters
    ----------
    settings : Settings
        Robot, weights and period.
    curve : Curve
        The way.
    start : (3,) tuple of float
        x [m], y [m], heading [rad].
    weights : Weights or None
        None: those of trajectories.
    """
    weights = weights or settings.weights
    period_s = settings.track.period_s
    desired = desired_trajectory(curve, period_s=period_s)
    fine = TrackingProblem(
        desired=desired_trajectory(curve, period_s=0.5 * period_s),
        start=np.array(start),
        weights=weights,
        robot=settings.robot,
        substeps=2,
    )
    nominal = BoundedIlqr().solve(fine)
    poses, rates = nominal.poses[:-1:2], nominal.wheel_rates[::2]
    riccati = riccati_gains(poses, rates, settings.robot, weights=weights, period_s=period_s)
    return NeighbouringSetup(
        desired=desired,
        start=start,
        control=NeighbouringControl(nominal_poses=poses, nominal_rates=rates, gains=riccati.gains),
        stability=stability_report(
            poses, rates, settings.robot, riccati=riccati, weights=weights, period_s=period_s
        ),
        weights=weights,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class NeighbouringResults:
    """Return thesis 7.5.2.

    Parameters
    ----------
    outcomes : tuple of Outcome
        Stabilisation, lemniscate and the study's own trajectories, by all methods.
    stability : dict of str to StabilityReport
        By task.
    wheel_noise : tuple of (float, Outcome)
        The lemniscate at several wheel noises [rad/s].
    """

    outcomes: tuple[Outcome, ...]
    stability: dict[str, StabilityReport]
    wheel_noise: tuple[tuple[float, Outcome], ...]


def neighbouring_results(settings: Settings) -> NeighbouringResults:
    """Return the neighbouring control's tasks, driven with every estimator, and its peers.

    Parameters
    ----------
    settings : Settings
        Everything.
    """
    point = neighbouring_setup(
        settings, shapes.fixed_pose(POINT_GOAL), POINT_START, weights=settings.stabilisation
    )
    eight = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    outcomes = []
    for setup in (point, eight):
        for method, controller, estimator in _methods(settings, setup):
            outcomes.append(_driven(settings, setup, method, controller, estimator))
    stability = {setup.desired.name: setup.stability for setup in (point, eight)}
    for own in settings.own:
        setup = neighbouring_setup(settings, own.curve, own.start)
        outcomes.append(_driven(settings, setup, EKF, setup.control, _ekf(settings)))
        stability[own.curve.name] = setup.stability
    noises = []
    for sigma in WHEEL_SIGMAS_RAD_PER_S:
        track = _replaced(settings, sigma)
        noises.append((sigma, _driven(track, eight, EKF, eight.control, _ekf(track))))
    return NeighbouringResults(
        outcomes=tuple(outcomes), stability=stability, wheel_noise=tuple(noises)
    )


def _replaced(settings: Settings, wheel_sigma: float) -> Settings:
    import msgspec

    track = msgspec.structs.replace(settings.track, wheel_sigma_rad_per_s=wheel_sigma)
    return replace(settings, track=track)


def _ekf(settings: Settings) -> ExtendedKalman:
    return ExtendedKalman(motion=settings.motion, sensor=settings.mesh, noise=settings.assumptions)


def _methods(
    settings: Settings, setup: NeighbouringSetup
) -> tuple[tuple[str, TrackingController, PoseEstimator[Any]], ...]:
    motion, mesh, noise = settings.motion, settings.mesh, settings.assumptions
    ekf = _ekf(settings)
    ignoring = RssAssumptions(sigma_db=noise.sigma_db, mean_sigma_db=0.0)
    predictive = PredictiveControl(
        desired=setup.desired, robot=settings.robot, weights=setup.weights
    )
    return (
        (EKF, setup.control, ekf),
        (BUCY, setup.control, KalmanBucy(motion=motion, sensor=mesh, noise=noise)),
        (MPC, predictive, UnscentedKalman(motion=motion, sensor=mesh, noise=noise)),
        (IGNORED, setup.control, ExtendedKalman(motion=motion, sensor=mesh, noise=ignoring)),
        (BLIND, OpenLoop(rates=setup.control.nominal_rates), ekf),
    )


def _driven(
    settings: Settings,
    setup: NeighbouringSetup,
    method: str,
    controller: TrackingController,
    estimator: PoseEstimator[Any],
) -> Outcome:
    record = drive(
        controller,
        estimator,
        settings.world(settings.mesh),
        setup.desired,
        start=setup.start,
        seeds=run_seeds(settings.study.seed, settings.track.runs),
    )
    return outcome_of(record, chapter="neighbouring", task=setup.desired.name, method=method)


def slam_records(settings: Settings) -> tuple[tuple[float, SlamRecord], ...]:
    """Return EKF SLAM along the 3 m line of thesis 7.7, at the printed wheel noise and above it.

    Parameters
    ----------
    settings : Settings
        For seed and runs.
    """
    robot, rate = settings.robot, 2.0
    period_s = settings.track.period_s
    length_m = robot.wheel_radius_m * rate * period_s
    records = []
    for sigma in SLAM_WHEEL_SIGMAS_RAD_PER_S:
        task = SlamTask(
            motion=WheelMotion(robot=robot, period_s=period_s, rate_sigma_rad_per_s=sigma),
            start=np.array([1.0, 0.0, 0.5 * math.pi]),
            wheel_rates_rad_per_s=np.array([rate, rate]),
            steps=round(3.0 / length_m),
            tags_m=np.array(SLAM_TAGS_M),
        )
        seeds = run_seeds(settings.study.seed, settings.track.slam_runs)
        records.append((sigma, run_slam(task, seeds)))
    return tuple(records)
