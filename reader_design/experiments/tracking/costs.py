"""Table 8.1 as measured: what a control step and a training cost, and what else it says."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.navigation.control.controllers import FuzzyController
from octant.navigation.estimators.kalman import Gaussian
from octant.navigation.estimators.pose_filters import PoseEstimator
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    KalmanBucy,
    UnscentedKalman,
)
from octant.navigation.sensing.rss_models import TagMesh, tag_grid
from octant.navigation.tracking import shapes
from octant.navigation.tracking.controllers import (
    MeasurementFeedback,
    TrackingController,
)
from octant.navigation.tracking.measurement_feedback import FeedbackTask, FeedbackTraining
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

TIMED_S = 0.05
"""At least so long is every measurement [s]; the quickest of three counts."""


FEEDBACK = "measurement feedback (chapter 6)"
COST_COLUMNS = (
    "method",
    "claimed",
    "offline_s",
    "step_us",
    "line_m",
    "lemniscate_m",
    "knows_tags",
    "rfid_architecture",
    "linearises",
    "tracks",
    "stabilises",
    "point_m",
)
"""Columns of costs.csv [s, µs, m]; those after knows_tags say what Table 8.1 says, and what is so
where that is not the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CostRow:
    """A row of Table 8.1.

    Parameters
    ----------
    method, claimed : Controller and estimator, and what the thesis says of their cost.
    offline_s, step_us : Training or planning [s]; one control step with its estimator [µs].
    line_m, lemniscate_m : Average errors [m], median over the runs, from `with_errors`.
    knows_tags : Whether the robot must know the tags' places.
    architecture, linearises : Which side of the RFID system is modified, and whether the robot's
        model is linearised.
    tracks, stabilises : Whether a trajectory is tracked, and a point held.
    point_m : Final error at the point of thesis 7.5.2.1 [m], from `with_errors`.
    """

    method: str
    claimed: str
    offline_s: float | None
    step_us: float
    knows_tags: bool
    architecture: str = "modified tag"
    linearises: str = "no"
    tracks: str = "yes"
    stabilises: str = "yes"
    line_m: str = "–"
    lemniscate_m: str = "–"
    point_m: str = "–"

    def row(self) -> tuple[object, ...]:
        """Return the row of costs.csv, as `COST_COLUMNS` [s, µs, m]."""
        offline = "" if self.offline_s is None else self.offline_s
        errors = self.line_m, self.lemniscate_m
        known = "yes" if self.knows_tags else "no"
        told = self.architecture, self.linearises, self.tracks, self.stabilises, self.point_m
        return self.method, self.claimed, offline, self.step_us, *errors, known, *told


def seconds(call: Callable[[], object]) -> float:
    """Return the time of one call, the quickest of three series [s].

    Parameters
    ----------
    call : What is timed.
    """
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
        replace(
            row,
            line_m=feedback,
            lemniscate_m=_average_m(outcomes, "lemniscate", (MANY,)),
            point_m=_final_m(outcomes, "stabilisation", FRESH),
        )
        if row.method == FEEDBACK
        else replace(
            row,
            lemniscate_m=_average_m(outcomes, "lemniscate", (row.method,)),
            point_m=_final_m(outcomes, "neighbouring", row.method),
        )
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
    task = feedback_task_of(settings, len(settings.feedback_tags_m), steps)
    record = settings.noise.draw(task.record_shape, np.random.default_rng(0))[None]
    training = FeedbackTraining(iterations=20)
    iteration_s = seconds(lambda: training.train(task, record)) / training.iterations
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
            step_us=1e6 * seconds(_fuzzy_step(settings)),
            line_m="drives to tags only",
            lemniscate_m="drives to tags only",
            knows_tags=False,
            architecture="modified reader",
            tracks="no",
            stabilises="no; at tags only, without a heading",
            point_m="drives to tags only",
        ),
        CostRow(
            method=FEEDBACK,
            claimed="O(n s k_f N)",
            offline_s=trained_s,
            step_us=1e6 * seconds(lambda: feedback.wheel_rates(0, pose, readings)),
            knows_tags=False,
        ),
        *(
            CostRow(
                method=method,
                claimed="O(n² k_f N + n s k_f)" if method != MPC else "not in the thesis",
                offline_s=offline_s,
                step_us=1e6 * seconds(loop_step(controller, estimator, settings.mesh)),
                knows_tags=True,
                linearises="along the nominal (7.28) and at the estimate; Table 8.1: no",
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
    of = [o for o in outcomes if o.chapter in ("feedback", "neighbouring")]
    found = [o for m in methods for o in of if (o.task, o.method) == (task, m)]
    values = [f"{np.median(o.measures()['average_m']):.3f}" for o in found]
    if not values:
        return "–"
    if len(methods) == 1:
        return values[0]
    return f"{values[0]} replayed, {values[1]} fresh, {values[2]} trained over many"


def _final_m(outcomes: Sequence[Outcome], chapter: str, method: str) -> str:
    found = [o for o in outcomes if (o.chapter, o.task, o.method) == (chapter, "point", method)]
    return f"{np.median(found[0].measures()['final_m']):.3f}" if found else "–"


def loop_step(
    controller: TrackingController, estimator: PoseEstimator[Any], mesh: TagMesh
) -> Callable[[], object]:
    """Return what does one step of a controller with its estimator, for one robot.

    Parameters
    ----------
    controller, estimator, mesh : Both, and the tags.
    """
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


def feedback_task_of(settings: Settings, tags: int, steps: int) -> FeedbackTask:
    """Return a lemniscate for chapter 6's feedback.

    Parameters
    ----------
    settings, tags, steps : Robot and weights, about how many tags, and how many periods.
    """
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
