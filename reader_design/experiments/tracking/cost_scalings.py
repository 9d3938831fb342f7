"""How the measured costs of Table 8.1 grow: with tags, steps, states, iterations and horizons."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from octant.navigation.estimators.law_fit import LawFittingKalman
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    RssAssumptions,
    UnscentedKalman,
)
from octant.navigation.sensing.rss_models import TagMesh, tag_grid
from octant.navigation.tracking import shapes
from octant.navigation.tracking.controllers import MeasurementFeedback
from octant.navigation.tracking.measurement_feedback import FeedbackTask, FeedbackTraining
from octant.navigation.tracking.nominal import BoundedIlqr, GainDescent
from octant.reader_design.experiments.tracking.chapters import (
    neighbouring_setup,
    predictive_control,
)
from octant.reader_design.experiments.tracking.costs import feedback_task_of, loop_step, seconds
from octant.reader_design.experiments.tracking.settings import LEMNISCATE_START, Settings

TAG_SIDES = (2, 4, 6, 8, 10)
"""Sides of the meshes over which the cost of a step is measured [-]."""
STEP_COUNTS = (75, 150, 300, 600, 1200)
"""Numbers of steps over which the cost of a training iteration is measured [-]."""
STATE_COUNTS = (3, 4, 5, 6)
"""Numbers of states n of the filters: the pose; with the noise's mean; with the law; with both."""
ITERATIONS = (25, 50, 100, 200, 400)
"""Numbers N of iterations offline over which a training is measured."""
HORIZONS = (5, 10, 20, 40, 80)
"""Horizons over which the cost of a plan is measured, in periods."""


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


def cost_scalings(settings: Settings) -> tuple[CostScaling, ...]:
    """Return how costs grow with the number of tags and of steps.

    Parameters
    ----------
    settings : Everything.
    """
    return (
        _step_scaling(settings),
        _training_by_tags(settings),
        _training_by_steps(settings),
        _step_by_states(settings),
        _training_by_iterations(settings),
        _step_by_horizon(settings),
    )


def _step_scaling(settings: Settings) -> CostScaling:
    setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    motion, noise = settings.motion, settings.assumptions
    times: dict[str, list[float]] = {"feedback": [], "EKF": [], "UKF": []}
    for side in TAG_SIDES:
        spacing_m = 12.0 / (side - 1)
        mesh = TagMesh(tags_m=tag_grid(side, spacing_m=spacing_m, height_m=3.0), law=settings.law)
        feedback = MeasurementFeedback(gains=np.zeros((1, 2, side**2)))
        readings, pose = np.zeros((1, side**2)), np.zeros((1, 3))
        times["feedback"].append(seconds(partial(feedback.wheel_rates, 0, pose, readings)))
        for name, kind in (("EKF", ExtendedKalman), ("UKF", UnscentedKalman)):
            step = loop_step(setup.control, kind(motion=motion, sensor=mesh, noise=noise), mesh)
            times[name].append(seconds(step))
    return CostScaling(
        what="one control step",
        quantity="number of tags s",
        sizes=tuple(side**2 for side in TAG_SIDES),
        times_us={name: tuple(1e6 * t for t in values) for name, values in times.items()},
    )


def _training_by_tags(settings: Settings) -> CostScaling:
    values = []
    for side in TAG_SIDES:
        task = feedback_task_of(settings, side**2, 600)
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
        task = feedback_task_of(settings, 9, steps)
        feedback.append(_iteration_us(settings, task))
        for solver, times in (
            (GainDescent(iterations=20), printed),
            (BoundedIlqr(iterations=5, tolerance=0.0, first_rates_rad_per_s=((1.0, 1.0),)), ilqr),
        ):
            done = solver.solve(task.problem).iterations
            times.append(1e6 * seconds(partial(solver.solve, task.problem)) / done)
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


def _step_by_states(settings: Settings) -> CostScaling:
    """Return what a filter's step costs by its number of states n, and SLAM's by its tags."""
    mesh, pose = settings.mesh, np.array([LEMNISCATE_START])
    rates, rngs = np.full((1, 2), 2.0), [np.random.default_rng(0)]
    rss = mesh.rss_dbm(pose[:, :2])
    times = []
    for states in STATE_COUNTS:
        mean = settings.noise.sigma_db if states in (4, 6) else 0.0
        noise = RssAssumptions(sigma_db=settings.noise.sigma_db, mean_sigma_db=mean)
        estimator: ExtendedKalman | LawFittingKalman = ExtendedKalman(
            motion=settings.motion, sensor=mesh, noise=noise
        )
        if states > 4:
            estimator = LawFittingKalman(
                motion=settings.motion,
                noise=noise,
                tags_m=mesh.tags_m,
                guess=settings.law,
                alpha_sigma_dbm=1.0,
                beta_sigma_per_m=0.01,
                iterations=1,
            )
        belief = estimator.begin(pose, 0.01 * np.eye(3), rngs)
        times.append(1e6 * seconds(partial(estimator.step, belief, rates, rss, rngs)))
    return CostScaling(
        what="one filter step",
        quantity="number of states n",
        sizes=STATE_COUNTS,
        times_us={"EKF": tuple(times)},
    )


def _training_by_iterations(settings: Settings) -> CostScaling:
    task = feedback_task_of(settings, 9, 600)
    record = settings.noise.draw(task.record_shape, np.random.default_rng(0))[None]
    feedback, printed = [], []
    for iterations in ITERATIONS:
        training = FeedbackTraining(iterations=iterations, tolerance=0.0)
        feedback.append(1e6 * seconds(partial(training.train, task, record)))
        solver = GainDescent(iterations=iterations, tolerance=0.0)
        printed.append(1e6 * seconds(partial(solver.solve, task.problem)))
    return CostScaling(
        what="a whole training",
        quantity="number of iterations N",
        sizes=ITERATIONS,
        times_us={"feedback, chapter 6": tuple(feedback), "printed update, 7.2": tuple(printed)},
    )


def _step_by_horizon(settings: Settings) -> CostScaling:
    setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    pose, rss = np.array([LEMNISCATE_START]), np.zeros((1, 1))
    times = []
    for horizon in HORIZONS:
        control = replace(predictive_control(settings, setup), horizon=horizon)
        times.append(1e6 * seconds(partial(control.wheel_rates, 100, pose, rss)))
    return CostScaling(
        what="one plan of the predictive control",
        quantity="horizon [periods]",
        sizes=HORIZONS,
        times_us={"predictive": tuple(times)},
    )


def _iteration_us(settings: Settings, task: FeedbackTask) -> float:
    record = settings.noise.draw(task.record_shape, np.random.default_rng(0))[None]
    training = FeedbackTraining(iterations=10)
    return 1e6 * seconds(lambda: training.train(task, record)) / 10
