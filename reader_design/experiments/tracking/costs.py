"""Table 8.1 as measured: what a control step and a training cost, and how that grows."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.navigation.control.controllers import FuzzyController
from octant.navigation.estimators.kalman import Gaussian
from octant.navigation.estimators.pose_filters import PoseEstimator
from octant.navigation.estimators.rss_kalman import ExtendedKalman, KalmanBucy, UnscentedKalman
from octant.navigation.sensing.rss_models import TagMesh, tag_grid
from octant.navigation.tracking import shapes
from octant.navigation.tracking.controllers import (
    MeasurementFeedback,
    TrackingController,
)
from octant.navigation.tracking.measurement_feedback import FeedbackTask, FeedbackTraining
from octant.navigation.tracking.nominal import BoundedIlqr, GainDescent
from octant.navigation.tracking.problem import TrackingProblem
from octant.navigation.tracking.trajectories import desired_trajectory
from octant.reader_design.experiments.tracking.chapters import (
    BUCY,
    EKF,
    FRESH,
    MANY,
    MPC,
    REPLAY,
    neighbouring_setup,
    predictive_control,
)
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.settings import LEMNISCATE_START, Settings

FloatArray = npt.NDArray[np.float64]

TAG_SIDES = (2, 4, 6, 8, 10)
"""Sides of the meshes over which the cost of a step is measured [-]."""
STEP_COUNTS = (75, 150, 300, 600, 1200)
"""Numbers of steps over which the cost of a training iteration is measured [-]."""
TIMED_S = 0.05
"""At least so long is every measurement [s]; the quickest of three counts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CostScaling:
    """Measured times against the size of the problem.

    Parameters
    ----------
    what, quantity, sizes : What was timed, what counts as its size, and the sizes.
    times_us : By method: time for each size [µs].
    """

    what: str
    quantity: str
    sizes: tuple[int, ...]
    times_us: dict[str, tuple[float, ...]]

    def exponent(self, name: str) -> float:
        """Return the power of the size with which the cost grows, fitted to the larger sizes [-].

        Parameters
        ----------
        name : A method.
        """
        times = self.times_us[name]
        return float(np.polyfit(np.log(self.sizes[-3:]), np.log(times[-3:]), 1)[0])


FEEDBACK = "measurement feedback (chapter 6)"
COST_COLUMNS = (
    "method",
    "claimed",
    "offline_s",
    "step_us",
    "line_m",
    "lemniscate_m",
    "knows_tags",
)
"""Columns of costs.csv [s, µs, m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CostRow:
    """A row of Table 8.1.

    Parameters
    ----------
    method, claimed : Controller and estimator, and what the thesis says of their cost.
    offline_s, step_us : Training or planning [s]; one control step with its estimator [µs].
    line_m, lemniscate_m : Average errors [m], median over the runs, from `with_errors`.
    knows_tags : Whether the robot must know the tags' places.
    """

    method: str
    claimed: str
    offline_s: float | None
    step_us: float
    knows_tags: bool
    line_m: str = "–"
    lemniscate_m: str = "–"

    def row(self) -> tuple[object, ...]:
        """Return the row of costs.csv, as `COST_COLUMNS` [s, µs, m]."""
        offline = "" if self.offline_s is None else self.offline_s
        errors = self.line_m, self.lemniscate_m
        known = "yes" if self.knows_tags else "no"
        return self.method, self.claimed, offline, self.step_us, *errors, known


def _seconds(call: Callable[[], object]) -> float:
    """Return the time of one call, the quickest of three series [s]."""
    call()
    best = np.inf
    for _ in range(3):
        count, began = 0, time.perf_counter()
        while (spent := time.perf_counter() - began) < TIMED_S:
            call()
            count += 1
        best = min(best, spent / count)
    return best


def _once(call: Callable[[], object]) -> float:
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def with_errors(rows: Sequence[CostRow], outcomes: Sequence[Outcome]) -> tuple[CostRow, ...]:
    """Return Table 8.1 with the errors of the outcomes that were computed.

    Parameters
    ----------
    rows, outcomes : From `cost_rows`, and outcomes of chapters 6 and 7 [m].
    """
    feedback = _average_m(outcomes, "line", (REPLAY, FRESH, MANY))
    return tuple(
        replace(row, line_m=feedback, lemniscate_m=_average_m(outcomes, "lemniscate", (MANY,)))
        if row.method == FEEDBACK
        else replace(row, lemniscate_m=_average_m(outcomes, "lemniscate", (row.method,)))
        if row.knows_tags
        else row
        for row in rows
    )


def cost_rows(settings: Settings) -> tuple[CostRow, ...]:
    """Return Table 8.1 with measured costs.

    Parameters
    ----------
    settings : Everything.
    """
    steps = desired_trajectory(shapes.lemniscate(), period_s=settings.track.period_s).steps
    task = _feedback_task(settings, len(settings.feedback_tags_m), steps)
    record = settings.noise.draw(task.record_shape, np.random.default_rng(0))[None]
    training = FeedbackTraining(iterations=20)
    iteration_s = _seconds(lambda: training.train(task, record)) / training.iterations
    trained_s = iteration_s * settings.track.training_iterations
    gains = np.zeros((1, 2, len(settings.feedback_tags_m)))
    feedback = MeasurementFeedback(gains=gains)
    readings = np.full((1, len(settings.feedback_tags_m)), -100.0)
    pose = np.array([LEMNISCATE_START])
    return (
        CostRow(
            method="bearing-sensitive, fuzzy (chapter 5)",
            claimed="O(s + c)",
            offline_s=None,
            step_us=1e6 * _seconds(_fuzzy_step(settings)),
            line_m="drives to tags only",
            lemniscate_m="drives to tags only",
            knows_tags=False,
        ),
        CostRow(
            method=FEEDBACK,
            claimed="O(n s k_f N)",
            offline_s=trained_s,
            step_us=1e6 * _seconds(lambda: feedback.wheel_rates(0, pose, readings)),
            knows_tags=False,
        ),
        *(
            CostRow(
                method=method,
                claimed="O(n² k_f N + n s k_f)" if method != MPC else "not in the thesis",
                offline_s=offline_s,
                step_us=1e6 * _seconds(_loop_step(controller, estimator, settings.mesh)),
                knows_tags=True,
            )
            for method, controller, estimator, offline_s in _loops(settings)
        ),
    )


def _loops(
    settings: Settings,
) -> tuple[tuple[str, TrackingController, PoseEstimator[Any], float], ...]:
    """Return controllers with estimators, and the time to plan them offline [s]."""
    setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    plan_s = _once(lambda: neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START))
    mesh, motion, noise = settings.mesh, settings.motion, settings.assumptions
    predictive = predictive_control(settings, setup)
    ekf = ExtendedKalman(motion=motion, sensor=mesh, noise=noise)
    return (
        (EKF, setup.control, ekf, plan_s),
        (BUCY, setup.control, KalmanBucy(motion=motion, sensor=mesh, noise=noise), plan_s),
        (MPC, predictive, UnscentedKalman(motion=motion, sensor=mesh, noise=noise), 0.0),
    )


def _average_m(outcomes: Sequence[Outcome], task: str, methods: tuple[str, ...]) -> str:
    found = [o for m in methods for o in outcomes if (o.task, o.method) == (task, m)]
    values = [f"{np.median(o.measures()['average_m']):.3f}" for o in found]
    if not values:
        return "–"
    if len(methods) == 1:
        return values[0]
    return f"{values[0]} replayed, {values[1]} fresh, {values[2]} trained over many"


def _loop_step(
    controller: TrackingController, estimator: PoseEstimator[Any], mesh: TagMesh
) -> Callable[[], object]:
    pose = np.array([[0.5, 0.0, 0.5]])
    belief = estimator.begin(pose, 0.01 * np.eye(3), [np.random.default_rng(0)])
    assert isinstance(belief, Gaussian)  # noqa: S101  all timed estimators are Kalman filters
    rss = mesh.rss_dbm(pose[:, :2])
    rngs = [np.random.default_rng(0)]

    def step() -> object:
        rates = controller.wheel_rates(10, pose, rss)
        return estimator.step(belief, rates, rss, rngs)

    return step


def _fuzzy_step(settings: Settings) -> Callable[[], object]:
    controller = FuzzyController()
    azimuths: FloatArray = 0.25 * np.pi * np.arange(8, dtype=np.float64)
    rss = np.linspace(1e-9, 2e-9, 8)
    return lambda: controller.wheel_rates(
        rss, azimuths_rad=azimuths, cruise_speed_m_per_s=0.09, robot=settings.robot
    )


def _feedback_task(settings: Settings, tags: int, steps: int) -> FeedbackTask:
    curve = shapes.lemniscate(duration_s=settings.track.period_s * steps)
    desired = desired_trajectory(curve, period_s=settings.track.period_s)
    problem = TrackingProblem(
        desired=desired,
        start=np.array(LEMNISCATE_START),
        weights=settings.weights,
        robot=settings.feedback_robot,
    )
    side = round(tags**0.5)
    return FeedbackTask(
        problem=problem,
        tags_m=tag_grid(side, spacing_m=settings.track.tag_spacing_m, height_m=3.0),
        law=settings.law,
    )


def cost_scalings(settings: Settings) -> tuple[CostScaling, ...]:
    """Return how costs grow with the number of tags and of steps.

    Parameters
    ----------
    settings : Everything.
    """
    return _step_scaling(settings), _training_by_tags(settings), _training_by_steps(settings)


def _step_scaling(settings: Settings) -> CostScaling:
    setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    motion, noise = settings.motion, settings.assumptions
    times: dict[str, list[float]] = {"feedback": [], "EKF": [], "UKF": []}
    for side in TAG_SIDES:
        spacing_m = 12.0 / (side - 1)
        mesh = TagMesh(tags_m=tag_grid(side, spacing_m=spacing_m, height_m=3.0), law=settings.law)
        feedback = MeasurementFeedback(gains=np.zeros((1, 2, side**2)))
        readings, pose = np.zeros((1, side**2)), np.zeros((1, 3))
        times["feedback"].append(_seconds(partial(feedback.wheel_rates, 0, pose, readings)))
        for name, kind in (("EKF", ExtendedKalman), ("UKF", UnscentedKalman)):
            step = _loop_step(setup.control, kind(motion=motion, sensor=mesh, noise=noise), mesh)
            times[name].append(_seconds(step))
    return CostScaling(
        what="one control step",
        quantity="number of tags s",
        sizes=tuple(side**2 for side in TAG_SIDES),
        times_us={name: tuple(1e6 * t for t in values) for name, values in times.items()},
    )


def _training_by_tags(settings: Settings) -> CostScaling:
    values = []
    for side in TAG_SIDES:
        task = _feedback_task(settings, side**2, 600)
        values.append(_iteration_us(settings, task))
    return CostScaling(
        what="one training iteration",
        quantity="number of tags s (600 steps)",
        sizes=tuple(side**2 for side in TAG_SIDES),
        times_us={"feedback, chapter 6": tuple(values)},
    )


def _training_by_steps(settings: Settings) -> CostScaling:
    feedback: list[float] = []
    printed: list[float] = []
    ilqr: list[float] = []
    for steps in STEP_COUNTS:
        task = _feedback_task(settings, 9, steps)
        feedback.append(_iteration_us(settings, task))
        for solver, times in (
            (GainDescent(iterations=20), printed),
            (BoundedIlqr(iterations=5, tolerance=0.0, first_rates_rad_per_s=((1.0, 1.0),)), ilqr),
        ):
            done = solver.solve(task.problem).iterations
            times.append(1e6 * _seconds(partial(solver.solve, task.problem)) / done)
    return CostScaling(
        what="one training iteration",
        quantity="number of steps k_f",
        sizes=STEP_COUNTS,
        times_us={
            "feedback, chapter 6": tuple(feedback),
            "printed update, 7.2": tuple(printed),
            "bounded iLQR": tuple(ilqr),
        },
    )


def _iteration_us(settings: Settings, task: FeedbackTask) -> float:
    record = settings.noise.draw(task.record_shape, np.random.default_rng(0))[None]
    training = FeedbackTraining(iterations=10)
    return 1e6 * _seconds(lambda: training.train(task, record)) / 10
