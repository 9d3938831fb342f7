"""Optimal measurement feedback, thesis chapter 6: wheel rates straight from RSS, by training."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.sensing.rss_models import LogExponentialLaw, RssNoise, TagMesh
from octant.navigation.sensing.tag_frames import Hearing
from octant.navigation.tracking import _feedback_kernels
from octant.navigation.tracking.descent import Descent
from octant.navigation.tracking.problem import TrackingProblem

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class FeedbackTask:
    """What a feedback gain is trained for.

    Parameters
    ----------
    problem : Trajectory, start, weights and robot; without substeps, as in the thesis.
    tags_m : (s, 3) float64 — Places of the tags [m]; the robot does not know them.
    law : RSS of the tags, (6.2).
    range_m : Distance from which on a tag is not heard and counts for nothing [m].
    """

    problem: TrackingProblem
    tags_m: FloatArray
    law: LogExponentialLaw
    range_m: float = np.inf

    def __post_init__(self) -> None:
        mesh = TagMesh(tags_m=self.tags_m, law=self.law)
        object.__setattr__(self, "tags_m", mesh.tags_m)
        if self.problem.substeps != 1:
            msg = (
                f"the problem has {self.problem.substeps} substeps, but measurement feedback reads "
                "in every step: sample the trajectory at the control period."
            )
            raise NavigationError(msg)

    @property
    def record_shape(self) -> tuple[int, int]:
        """Return periods and tags of a noise record."""
        return self.problem.intervals, len(self.tags_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class FeedbackRun:
    """One run of the feedback on one noise record.

    Parameters
    ----------
    cost : J of (6.5) [-].
    gradient : (k, 2, s) float64 — dJ/dK, period times gradient (6.23) [dBm s/rad].
    poses : (k + 1, 3) float64 — x [m], y [m], heading [rad].
    wheel_rates : (k, 2) float64 — Right and left [rad/s].
    """

    cost: float
    gradient: FloatArray
    poses: FloatArray
    wheel_rates: FloatArray

    def errors_m(self, problem: TrackingProblem) -> FloatArray:
        """Return the (k + 1,) distances to the desired places [m].

        Parameters
        ----------
        problem : With the desired trajectory.
        """
        offset = self.poses[:, :2] - problem.desired.poses[:, :2]
        errors: FloatArray = np.linalg.norm(offset, axis=1)
        return errors


def run_feedback(task: FeedbackTask, gains: FloatArray, noise_db: FloatArray) -> FeedbackRun:
    """Return what u = K z does with one noise record, and the gradient of its cost.

    Thesis (6.1)-(6.8): the state equation meant is (6.4), with K of 2 x s (6.5 prints 2 x 4 for
    nine tags). The costate (6.11) holds the slopes of the RSS as well.

    Parameters
    ----------
    task : The task.
    gains : (k, 2, s) float64 — K of every period [rad/s per dBm].
    noise_db : (k, s) float64 — ζ of every period [dB].
    """
    steps, tags = task.record_shape
    gradient = np.zeros((steps, 2, tags))
    poses, rates = np.empty((steps + 1, 3)), np.empty((steps, 2))
    cost = _feedback_kernels.feedback_cost(
        np.ascontiguousarray(gains, dtype=np.float64),
        np.ascontiguousarray(noise_db, dtype=np.float64),
        *_arguments(task),
        poses,
        rates,
        np.empty((steps, tags)),
        gradient,
    )
    return FeedbackRun(cost=float(cost), gradient=gradient, poses=poses, wheel_rates=rates)


def run_heard(
    task: FeedbackTask, gains: FloatArray, noise_db: FloatArray, hearing: Hearing | None
) -> FeedbackRun:
    """Return what u = K z does when the tags answer in codes, one after another, within a range.

    A tag keeps its last value until it answers again; one out of range counts for nothing. The
    cost's gradient is then not computed: the codes have none.

    Parameters
    ----------
    task, gains, noise_db : As for `run_feedback` [rad/s per dBm], [dB].
    hearing : Range, codes and turns of the tags; None: as for `run_feedback`.
    """
    if hearing is None or (hearing.codes is None and hearing.polling is None):
        return run_feedback(task, gains, noise_db)
    problem, mesh = task.problem, TagMesh(tags_m=task.tags_m, law=task.law)
    steps, tags = task.record_shape
    poses, rates = np.empty((steps + 1, 3)), np.empty((steps, 2))
    poses[0] = problem.start
    read = np.zeros(tags)
    for k in range(steps):
        clean = mesh.rss_dbm(poses[k : k + 1, :2])
        now = np.nan_to_num(hearing.heard(poses[k : k + 1], clean + noise_db[k])[0])
        begin, end = (k - 1) * problem.period_s, k * problem.period_s
        answers = k == 0 or hearing.polling is None or hearing.polling.heard(begin, end)
        read = np.where(answers, now, read)
        rates[k] = problem.robot.saturate(gains[k] @ read)
        poses[k + 1] = problem.robot.step_euler(poses[k], rates[k], period_s=problem.period_s)
    offset, weights = poses - problem.desired.poses, problem.weights
    running = np.sum((offset[:-1] @ weights.state) * offset[:-1])
    final = offset[-1] @ weights.final @ offset[-1]
    return FeedbackRun(
        cost=0.5 * float(problem.period_s * running + final),
        gradient=np.full((steps, 2, tags), np.nan),
        poses=poses,
        wheel_rates=rates,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class FeedbackTraining(Descent):
    """How a gain is trained: the five steps of thesis 6.4.

    Parameters
    ----------
    iterations, momentum : As of `Descent` [-].
    """

    iterations: int = 4000
    momentum: float = 0.99

    def train(self, task: FeedbackTask, noise_db: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return gains K (k, 2, s) [rad/s per dBm] trained on noise records, and the mean costs J.

        Parameters
        ----------
        task : The task.
        noise_db : (n, k, s) float64 — Noise records [dB]; one, as published, is fitted to itself.
        """
        records = frozen_array(
            noise_db, name="noise_db", shape=(None, *task.record_shape), error=NavigationError
        )
        steps, tags = task.record_shape
        arguments = _arguments(task)
        poses, rates = np.empty((steps + 1, 3)), np.empty((steps, 2))
        read = np.empty((steps, tags))

        def cost_of(gains: FloatArray) -> tuple[float, FloatArray, FloatArray]:
            gradient, square = np.empty(gains.shape), np.empty(steps)
            cost = _feedback_kernels.mean_cost(
                gains, records, *arguments, poses, rates, read, gradient, square
            )
            return float(cost), gradient, square

        return self.descend(cost_of, (steps, 2, tags))


def replay_and_fresh_m(
    task: FeedbackTask,
    noise: RssNoise,
    training: FeedbackTraining,
    seed: np.random.SeedSequence,
    hearing: Hearing | None = None,
) -> tuple[FloatArray, FeedbackRun, FeedbackRun]:
    """Return E / (t_f - t_0) of (3.11) on the training's record and on a new one, and both runs.

    Parameters
    ----------
    task : The task.
    noise : Of the readings.
    training : How to train.
    seed : Of both records.
    hearing : As for `run_heard`; the training knows the range only.
    """
    rng = np.random.default_rng(seed)
    seen, unseen = noise.draw(task.record_shape, rng), noise.draw(task.record_shape, rng)
    gains, _ = training.train(task, seen[None])
    replay, fresh = (run_heard(task, gains, one, hearing) for one in (seen, unseen))
    errors = [run.errors_m(task.problem)[:-1].mean() for run in (replay, fresh)]
    return np.array(errors), replay, fresh


def _arguments(task: FeedbackTask) -> tuple[object, ...]:
    """Return what all kernels take after gains and noise."""
    problem = task.problem
    return (
        task.tags_m,
        task.law.alpha_dbm,
        task.law.beta_per_m,
        task.range_m,
        problem.start,
        problem.desired.poses,
        problem.weights.state,
        problem.weights.final,
        problem.period_s,
        problem.robot.wheel_radius_m,
        problem.robot.axle_length_m,
        problem.robot.max_wheel_rate_rad_per_s,
    )
