"""Chapter 6: the RSS law fitted to samples, and measurement feedback on a line and a sine."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

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
from octant.navigation.tracking.closed_loop import run_seeds
from octant.navigation.tracking.measurement_feedback import (
    FeedbackRun,
    FeedbackTask,
    FeedbackTraining,
    replay_and_fresh_m,
    run_feedback,
)
from octant.navigation.tracking.problem import TrackingProblem
from octant.navigation.tracking.trajectories import Curve, desired_trajectory
from octant.reader_design.experiments.tracking.outcomes import Outcome
from octant.reader_design.experiments.tracking.settings import LEMNISCATE_START, Settings

FloatArray = npt.NDArray[np.float64]

PUBLISHED_FIT = LogExponentialLaw(alpha_dbm=-35.5, beta_per_m=0.1071)
"""The thesis' fit to its samples."""
PUBLISHED_NOISY_FIT = LogExponentialLaw(alpha_dbm=-60.0, beta_per_m=0.2)
"""The thesis' fit to the noisy signal."""
NOISY_RECORDS = 400
"""Noisy records of Table 6.1 that are fitted [-]."""
REPLAY, FRESH, MANY = "one record, replayed", "one record, fresh noise", "many records, fresh noise"
FEEDBACK_TASKS: tuple[tuple[Callable[[], Curve], tuple[float, float, float]], ...] = (
    (shapes.line, (-3.5, -4.0, 0.0)),
    (shapes.sine, (-2.5, 1.5, 0.0)),
    (shapes.lemniscate, LEMNISCATE_START),
)
"""Trajectories of thesis 6.5.3 and 6.5.4, and that of 7.5.2.2 for comparison, with starts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RssFits:
    """Return the fits of Table 6.1.

    Parameters
    ----------
    exponential : LogExponentialLaw
        Least squares of (6.2).
    exponential_rms_db, published_rms_db, distance_rms_db : float
        Residuals of that fit, of the printed parameters and of the log-distance fit [dB].
    distance : LogDistanceLaw
        The log-distance fit.
    noisy : (n, 2) float64
        Alpha [dBm] and beta [1/m] fitted to noisy records of the table's distances.
    noisy_share : float
        Share of those records whose fitted curve lies at least as far from the mean noisy signal
        as the printed one [-].
    """

    exponential: LogExponentialLaw
    exponential_rms_db: float
    published_rms_db: float
    distance: LogDistanceLaw
    distance_rms_db: float
    noisy: FloatArray
    noisy_share: float


def fit_samples(settings: Settings) -> RssFits:
    """Return the fits of Table 6.1, without noise and with it.

    Parameters
    ----------
    settings : Settings
        For the seed. The noise is that of thesis 6.5.1, whatever the study's.
    """
    distance, rss = np.array(XBEE_DISTANCES_M), np.array(XBEE_RSS_DBM)
    exponential, rms = fit_log_exponential(distance, rss)
    law, distance_rms = fit_log_distance(distance, rss)
    published = float(np.sqrt(np.mean((PUBLISHED_FIT.rss_dbm(distance) - rss) ** 2)))
    noise, rng = RssNoise(), np.random.default_rng([settings.study.seed, 6])
    clean = PUBLISHED_FIT.rss_dbm(distance)
    fits, away = [], []
    for _ in range(NOISY_RECORDS):
        fit, _ = fit_log_exponential(distance, clean + noise.draw(distance.shape, rng))
        fits.append((fit.alpha_dbm, fit.beta_per_m))
        away.append(float(np.sqrt(np.mean((fit.rss_dbm(distance) - clean - noise.mean_db) ** 2))))
    printed = PUBLISHED_NOISY_FIT.rss_dbm(distance) - clean - noise.mean_db
    share = float(np.mean(np.array(away) >= np.sqrt(np.mean(printed**2))))
    return RssFits(
        exponential=exponential,
        exponential_rms_db=rms,
        published_rms_db=published,
        distance=law,
        distance_rms_db=distance_rms,
        noisy=np.array(fits),
        noisy_share=share,
    )


def feedback_task(
    settings: Settings, curve: Curve, start: tuple[float, float, float]
) -> FeedbackTask:
    """Return the task of measurement feedback along a curve.

    Parameters
    ----------
    settings : Settings
        Robot, weights, tags and law.
    curve : Curve
        The way.
    start : (3,) tuple of float
        x [m], y [m], heading [rad].
    """
    desired = desired_trajectory(curve, period_s=settings.track.period_s)
    problem = TrackingProblem(
        desired=desired,
        start=np.array(start),
        weights=settings.weights,
        robot=settings.feedback_robot,
    )
    return FeedbackTask(problem=problem, tags_m=settings.feedback_tags_m, law=settings.law)


def feedback_outcomes(
    settings: Settings, *, progress: Callable[[int], None] | None = None
) -> tuple[Outcome, ...]:
    """Return the outcomes of chapter 6: replayed, on fresh noise, and trained over many records.

    Parameters
    ----------
    settings : Settings
        Everything.
    progress : callable or None
        Told the number of finished trainings [-].

    Notes
    -----
    Trainings run on two threads; each has its own random numbers, so that their number changes
    nothing. The lemniscate is trained over many records only.
    """
    track, outcomes, done = settings.track, [], 0
    training = FeedbackTraining(iterations=track.training_iterations)
    tasks = [feedback_task(settings, make(), start) for make, start in FEEDBACK_TASKS]
    seeds = run_seeds(settings.study.seed, track.runs)
    with ThreadPoolExecutor(max_workers=2) as pool:
        trained = pool.map(partial(_trained_over_many, settings, training, seeds), tasks)
        for task in tasks[:2]:
            one = partial(replay_and_fresh_m, task, settings.noise, training)
            replays, fresh = [], []
            for _, replayed, unseen in pool.map(one, seeds):
                replays.append(replayed)
                fresh.append(unseen)
                done += 1
                if progress is not None:
                    progress(done)
            for method, found in ((REPLAY, replays), (FRESH, fresh)):
                outcomes.append(_outcome(task, method, found))
        outcomes += trained
    return tuple(outcomes)


def _trained_over_many(
    settings: Settings,
    training: FeedbackTraining,
    seeds: Sequence[np.random.SeedSequence],
    task: FeedbackTask,
) -> Outcome:
    rng = np.random.default_rng([settings.study.seed, 7])
    shape = (settings.track.training_records, *task.record_shape)
    gains, _ = training.train(task, settings.noise.draw(shape, rng))
    runs = [
        run_feedback(
            task, gains, settings.noise.draw(task.record_shape, np.random.default_rng(seed))
        )
        for seed in seeds
    ]
    return _outcome(task, MANY, runs)


def _outcome(task: FeedbackTask, method: str, runs: list[FeedbackRun]) -> Outcome:
    desired = task.problem.desired
    return Outcome(
        chapter="feedback",
        task=desired.name,
        method=method,
        desired=desired,
        poses=np.array([run.poses for run in runs]),
        example_rates=runs[0].wheel_rates,
    )
