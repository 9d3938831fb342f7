"""Thesis chapters 6 and 7: the RSS law, measurement feedback, optimal control and EKF SLAM."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from octant.navigation.estimators.ekf_slam import SlamRecord, SlamTask, run_slam
from octant.navigation.estimators.pose_filters import PoseEstimator, WheelMotion
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    KalmanBucy,
    RssAssumptions,
    UnscentedKalman,
)
from octant.navigation.sensing.rss_models import (
    XBEE_DISTANCES_M,
    XBEE_RSS_DBM,
    LogDistanceLaw,
    LogExponentialLaw,
    RssNoise,
    fit_log_distance,
    fit_log_exponential,
)
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import TrackingRecord, drive, run_seeds
from octant.navigation.tracking.controllers import (
    NeighbouringControl,
    OpenLoop,
    PredictiveControl,
    TrackingController,
)
from octant.navigation.tracking.measurement_feedback import (
    FeedbackRun,
    FeedbackTask,
    FeedbackTraining,
    replay_and_fresh_m,
    run_heard,
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
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.settings import (
    EULER_STEP_S,
    LEMNISCATE_START,
    NOMINAL_PERIOD_S,
    POINT_GOAL,
    POINT_START,
    Settings,
)

FloatArray = npt.NDArray[np.float64]


PUBLISHED_FIT = LogExponentialLaw(alpha_dbm=-35.5, beta_per_m=0.1071)
"""The thesis' fit to its samples."""
PUBLISHED_NOISY_FIT = LogExponentialLaw(alpha_dbm=-60.0, beta_per_m=0.2)
"""The thesis' fit to the noisy signal."""
NOISY_RECORDS = 400
"""Noisy records of Table 6.1 that are fitted [-]."""
REPLAY, FRESH, MANY = "one record, replayed", "one record, fresh noise", "many records, fresh noise"
Start = tuple[float, float, float]
FEEDBACK_TASKS: dict[str, tuple[Curve, Start]] = {
    "line": (shapes.line(), (-3.5, -4.0, 0.0)),
    "sine": (shapes.sine(), (-2.5, 1.5, 0.0)),
    "lemniscate": (shapes.lemniscate(), LEMNISCATE_START),
}
"""Trajectories of thesis 6.5.3 and 6.5.4, and that of 7.5.2.2 for comparison, with starts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RssFits:
    """The fits of Table 6.1.

    Parameters
    ----------
    exponential, distance : Least squares of (6.2), and of the log-distance law.
    exponential_rms_db, published_rms_db, distance_rms_db : Residuals of (6.2) as fitted and as
        printed, and of the log-distance law [dB].
    noisy : (n, 2) float64 — Alpha [dBm] and beta [1/m] fitted to noisy records.
    noisy_share : Share of them at least as far from the mean noisy signal as the printed fit [-].
    distance_m, rss_dbm : (k,) float64 — The samples: Table 6.1's, or the study's own [m], [dBm].
    """

    exponential: LogExponentialLaw
    exponential_rms_db: float
    published_rms_db: float
    distance: LogDistanceLaw
    distance_rms_db: float
    noisy: FloatArray
    noisy_share: float
    distance_m: FloatArray
    rss_dbm: FloatArray


def fit_samples(settings: Settings) -> RssFits:
    """Return the fits of Table 6.1, or of the study's samples, and of Table 6.1 with noise.

    Parameters
    ----------
    settings : For samples and seed. The noise is that of thesis 6.5.1, whatever the study's.
    """
    xbee = np.array(XBEE_DISTANCES_M)
    samples = np.column_stack([xbee, XBEE_RSS_DBM])
    distance, rss = (samples if settings.samples is None else settings.samples).T
    exponential, rms = fit_log_exponential(distance, rss)
    law, distance_rms = fit_log_distance(distance, rss)
    published = float(np.sqrt(np.mean((PUBLISHED_FIT.rss_dbm(distance) - rss) ** 2)))
    noise, rng = RssNoise(), np.random.default_rng([settings.study.seed, 6])
    clean = PUBLISHED_FIT.rss_dbm(xbee)
    fits, away = [], []
    for _ in range(NOISY_RECORDS):
        fit, _ = fit_log_exponential(xbee, clean + noise.draw(xbee.shape, rng))
        fits.append((fit.alpha_dbm, fit.beta_per_m))
        away.append(float(np.sqrt(np.mean((fit.rss_dbm(xbee) - clean - noise.mean_db) ** 2))))
    printed = PUBLISHED_NOISY_FIT.rss_dbm(xbee) - clean - noise.mean_db
    share = float(np.mean(np.array(away) >= np.sqrt(np.mean(printed**2))))
    return RssFits(
        exponential=exponential,
        exponential_rms_db=rms,
        published_rms_db=published,
        distance=law,
        distance_rms_db=distance_rms,
        noisy=np.array(fits),
        noisy_share=share,
        distance_m=distance,
        rss_dbm=rss,
    )


def feedback_task(
    settings: Settings,
    curve: Curve,
    start: tuple[float, float, float],
    *,
    weights: Weights | None = None,
) -> FeedbackTask:
    """Return the task of measurement feedback along a curve.

    Parameters
    ----------
    settings, weights : Robot, tags, law, and weights, unless other weights are given.
    curve, start : The way, and where the robot starts: x [m], y [m], heading [rad].
    """
    desired = desired_trajectory(curve, period_s=settings.track.period_s)
    problem = TrackingProblem(
        desired=desired,
        start=np.array(start),
        weights=weights or settings.weights,
        robot=settings.feedback_robot,
    )
    return FeedbackTask(
        problem=problem,
        tags_m=settings.feedback_tags_m,
        law=settings.law,
        range_m=settings.track.tag_range_m or math.inf,
    )


def feedback_run(settings: Settings, task: str, run: int) -> tuple[Outcome, ...]:
    """Return the outcomes of gains trained on one noise record: replayed, and on fresh noise.

    Parameters
    ----------
    settings : Everything.
    task, run : A name of `FEEDBACK_TASKS`, and the run, which has its own random numbers.
    """
    work = feedback_task(settings, *FEEDBACK_TASKS[task])
    training = FeedbackTraining(iterations=settings.track.training_iterations)
    seed = run_seeds(settings.study.seed, run + 1)[run]
    hearing = settings.hearing(work.tags_m)
    _, *both = replay_and_fresh_m(work, settings.noise, training, seed, hearing)
    return tuple(
        feedback_outcome(work, method, [one])
        for method, one in zip((REPLAY, FRESH), both, strict=True)
    )


def trained_over_many(settings: Settings, task: str) -> tuple[Outcome, ...]:
    """Return the outcome of gains trained over many noise records, on fresh noise.

    Parameters
    ----------
    settings, task : Everything, and a name of `FEEDBACK_TASKS`.
    """
    work = feedback_task(settings, *FEEDBACK_TASKS[task])
    training = FeedbackTraining(iterations=settings.track.training_iterations)
    rng = np.random.default_rng([settings.study.seed, 7])
    shape = (settings.track.training_records, *work.record_shape)
    gains, _ = training.train(work, settings.noise.draw(shape, rng))
    hearing = settings.hearing(work.tags_m)
    runs = [
        run_heard(
            work,
            gains,
            settings.noise.draw(work.record_shape, np.random.default_rng(seed)),
            hearing,
        )
        for seed in run_seeds(settings.study.seed, settings.track.runs)
    ]
    return (feedback_outcome(work, MANY, runs),)


def feedback_outcome(
    work: FeedbackTask,
    method: str,
    runs: Sequence[FeedbackRun],
    *,
    chapter: str = "feedback",
    task: str = "",
) -> Outcome:
    """Return the outcome of runs of the measurement feedback ([m], [rad]).

    Parameters
    ----------
    work, method, runs : What was followed, the name of how, and the runs.
    chapter, task : Of the outcome; by default the trajectory is the task.
    """
    rates = np.array([run.wheel_rates for run in runs])
    record = without_estimates(work.problem.desired, [run.poses for run in runs], rates)
    return Outcome(chapter=chapter, task=task or record.desired.name, method=method, runs=record)


def without_estimates(
    desired: DesiredTrajectory, poses: Sequence[FloatArray], wheel_rates: FloatArray
) -> TrackingRecord:
    """Return the record of runs in which nothing was estimated ([m], [rad], [rad/s]).

    Parameters
    ----------
    desired, poses, wheel_rates : What was followed, and what each run did [m, rad], [rad/s].
    """
    return TrackingRecord(
        desired=desired,
        poses=np.array(poses),
        estimates=np.array(poses),
        wheel_rates=wheel_rates,
    )


NOMINAL_TASKS: dict[str, tuple[Curve, Start]] = {
    "point": (shapes.fixed_pose(POINT_GOAL), POINT_START),
    "sigmoid": (shapes.sigmoid(), (-3.0, -3.0, math.radians(45.0))),
    "parabola": (shapes.parabola(), (-4.0, 5.0, 0.0)),
    "ellipse": (shapes.ellipse(), (3.0, -0.2, math.radians(45.0))),
}
"""Thesis 7.5.1: curve and start [m, rad]. The parabola's start is not printed: this one is chosen
so that the error is about the printed 0.18 m."""
EIGHT_POSES = "eight poses"
EIGHT_POSES_RADIUS_M = 4.0
"""The eight poses of Fig. 7.3(b) are not printed: here on this circle, heading outwards [m]."""
ILQR, LBFGSB, PRINTED = "bounded iLQR", "L-BFGS-B on the inputs", "printed gain update"
NOMINAL_SOLVERS: dict[str, NominalSolver] = {
    ILQR: BoundedIlqr(),
    PRINTED: GainDescent(),
    LBFGSB: InputSearch(iterations=400, first_rates_rad_per_s=((0.1, 0.1),)),
}
NOMINAL_RUNS = (
    ("point", ILQR),
    ("point", PRINTED),
    ("sigmoid", ILQR),
    ("parabola", ILQR),
    ("ellipse", ILQR),
    ("ellipse", PRINTED),
    ("ellipse", LBFGSB),
    (EIGHT_POSES, ILQR),
)
"""Task and method; the printed update takes seconds for each task, so it solves two of them."""
EKF, BUCY, MPC = "neighbouring + EKF", "neighbouring + Kalman-Bucy", "predictive + UKF"
IGNORED, BLIND = "neighbouring + EKF, mean ignored", "nominal inputs, no feedback"
WHEEL_SIGMAS_RAD_PER_S = (0.01, 0.1, 0.3, 0.5)
"""Wheel noises whose effect is shown, since the thesis prints none [rad/s]."""
LABORATORY_TAGS_M = ((-0.2, 0.1, 0.5), (2.1, 0.1, 0.5), (2.1, 3.1, 0.5), (-0.2, 3.1, 0.5))
"""Tags of thesis 7.6.1, their heights above the antenna, as in (6.2) [m]."""
SLAM_WHEEL_SIGMAS_RAD_PER_S = (0.01, 0.1)
"""The printed wheel noise of 7.7, and ten times it, at which the thesis says that SLAM fails."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NominalRun:
    """One nominal problem solved by one method.

    Parameters
    ----------
    outcome, solution : Errors and way, and the cost after every iteration.
    """

    outcome: Outcome
    solution: NominalSolution


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
    settings, weights : Robot and weights, unless other weights are given.
    curve : The way; a period that does not divide it is made a little shorter.
    start, period_s : x [m], y [m], heading [rad]; longest time of constant wheel rates [s].
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


def nominal_run(settings: Settings, task: str, method: str) -> NominalRun:
    """Return one of `NOMINAL_RUNS` solved.

    Parameters
    ----------
    settings, task, method : Robot and weights, and the run.
    """
    if task == EIGHT_POSES:
        return _eight_poses(settings)
    curve, start = NOMINAL_TASKS[task]
    problem = nominal_problem(settings, curve, start)
    return _nominal_run(task, method, problem, [NOMINAL_SOLVERS[method].solve(problem)])


def _nominal_run(
    task: str, method: str, problem: TrackingProblem, solutions: Sequence[NominalSolution]
) -> NominalRun:
    rates = np.array([s.wheel_rates for s in solutions])
    record = without_estimates(problem.desired, [s.poses for s in solutions], rates)
    outcome = Outcome(chapter="nominal", task=task, method=method, runs=record)
    return NominalRun(outcome=outcome, solution=solutions[0])


def _eight_poses(settings: Settings) -> NominalRun:
    curve = shapes.fixed_pose((0.0, 0.0, 0.5 * math.pi))
    solutions = []
    for angle in 2.0 * np.pi * np.arange(8) / 8:
        place = EIGHT_POSES_RADIUS_M * np.array([np.cos(angle), np.sin(angle)])
        problem = nominal_problem(settings, curve, (float(place[0]), float(place[1]), float(angle)))
        solutions.append(BoundedIlqr().solve(problem))
    return _nominal_run(EIGHT_POSES, ILQR, problem, solutions)


@dataclass(frozen=True, slots=True, kw_only=True)
class NeighbouringSetup:
    """A neighbouring control, ready to be driven, and what its theory says.

    Parameters
    ----------
    desired, start : Trajectory at the control period; start: x [m], y [m], heading [rad].
    control, weights : Nominal inputs and gains, and the weights that gave them.
    stability : Lyapunov decay and Gramians along the nominal trajectory.
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
    settings, weights : Robot, period and weights, unless other weights are given.
    curve, start : The way, and where the robot starts: x [m], y [m], heading [rad].
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


def neighbouring_runs(settings: Settings, task: str) -> tuple[tuple[Outcome, ...], StabilityReport]:
    """Return one task of thesis 7.5.2 with every estimator and its peers, and what theory says.

    Parameters
    ----------
    settings : Everything.
    task : ``point``, ``lemniscate``, or a trajectory of the study, which only the EKF follows.
    """
    own = {one.curve.name: one for one in settings.own}
    if task in own:
        setup = neighbouring_setup(
            settings, own[task].curve, own[task].start, weights=own[task].weights
        )
        outcomes = (driven(settings, setup, EKF, setup.control, thesis_filter(settings)),)
        return outcomes, setup.stability
    if task == "point":
        setup = neighbouring_setup(
            settings, shapes.fixed_pose(POINT_GOAL), POINT_START, weights=settings.stabilisation
        )
    else:
        setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    methods = _methods(settings, setup)
    return tuple(driven(settings, setup, *method) for method in methods), setup.stability


def wheel_noise_run(settings: Settings, sigma: float) -> Outcome:
    """Return the lemniscate with another noise of the wheels.

    Parameters
    ----------
    settings, sigma : Everything, and the noise [rad/s].
    """
    track = msgspec.structs.replace(settings.track, wheel_sigma_rad_per_s=sigma)
    setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    noisy = replace(settings, track=track)
    return driven(noisy, setup, EKF, setup.control, thesis_filter(noisy))


def thesis_filter(settings: Settings) -> ExtendedKalman:
    """Return the extended Kalman filter that estimates the noise's mean too.

    Parameters
    ----------
    settings : Everything.
    """
    return ExtendedKalman(motion=settings.motion, sensor=settings.mesh, noise=settings.assumptions)


def predictive_control(settings: Settings, setup: NeighbouringSetup) -> PredictiveControl:
    """Return model predictive control of what a neighbouring control follows.

    Parameters
    ----------
    settings, setup : Robot and horizon, and what is followed.
    """
    return PredictiveControl(
        desired=setup.desired,
        robot=settings.robot,
        weights=setup.weights,
        horizon=settings.track.horizon,
        iterations=settings.track.horizon_iterations,
    )


def _methods(
    settings: Settings, setup: NeighbouringSetup
) -> tuple[tuple[str, TrackingController, PoseEstimator[Any]], ...]:
    motion, mesh, noise = settings.motion, settings.mesh, settings.assumptions
    ekf = thesis_filter(settings)
    ignoring = RssAssumptions(sigma_db=noise.sigma_db, mean_sigma_db=0.0)
    predictive = predictive_control(settings, setup)
    return (
        (EKF, setup.control, ekf),
        (BUCY, setup.control, KalmanBucy(motion=motion, sensor=mesh, noise=noise)),
        (MPC, predictive, UnscentedKalman(motion=motion, sensor=mesh, noise=noise)),
        (IGNORED, setup.control, ExtendedKalman(motion=motion, sensor=mesh, noise=ignoring)),
        (BLIND, OpenLoop(rates=setup.control.nominal_rates), ekf),
    )


def driven(
    settings: Settings,
    setup: NeighbouringSetup,
    method: str,
    controller: TrackingController,
    estimator: PoseEstimator[Any],
    *,
    chapter: str = "neighbouring",
    task: str = "",
    watch: Callable[[Any], FloatArray] | None = None,
) -> Outcome:
    """Return the runs of a controller with an estimator among the tags of chapter 7.

    Parameters
    ----------
    settings, setup : Everything, and what is followed.
    method, controller, estimator : Their name, and both.
    chapter, task : Of the outcome; by default the trajectory is the task.
    watch : What is kept of the estimator's belief, as for `drive` [its units].
    """
    record = drive(
        controller,
        estimator,
        settings.world(settings.mesh, tags_m=settings.mesh.tags_m),
        setup.desired,
        start=setup.start,
        seeds=run_seeds(settings.study.seed, settings.track.runs),
        watch=watch,
    )
    return Outcome(chapter=chapter, task=task or setup.desired.name, method=method, runs=record)


def laboratory_tags_m(settings: Settings) -> FloatArray:
    """Return the tags of the study, or else those of thesis 7.6.1 and 7.7, (s, 3) [m].

    Parameters
    ----------
    settings : Everything.
    """
    given = settings.given_tags_m
    return np.array(LABORATORY_TAGS_M) if given is None else given


def slam_task(settings: Settings, sigma: float) -> SlamTask:
    """Return the 3 m line of thesis 7.7.

    Parameters
    ----------
    settings, sigma : Everything, and the noise of the wheels [rad/s].
    """
    robot, rate, period_s = settings.robot, 2.0, settings.track.period_s
    return SlamTask(
        motion=WheelMotion(robot=robot, period_s=period_s, rate_sigma_rad_per_s=sigma),
        start=np.array([1.0, 0.0, 0.5 * math.pi]),
        wheel_rates_rad_per_s=np.array([rate, rate]),
        steps=round(3.0 / (robot.wheel_radius_m * rate * period_s)),
        tags_m=laboratory_tags_m(settings)[:, :2],
    )


def slam_record(settings: Settings, sigma: float) -> SlamRecord:
    """Return EKF SLAM along the 3 m line of thesis 7.7.

    Parameters
    ----------
    settings, sigma : For seed and runs, and the noise of the wheels [rad/s].
    """
    seeds = run_seeds(settings.study.seed, settings.track.slam_runs)
    return run_slam(slam_task(settings, sigma), seeds)
