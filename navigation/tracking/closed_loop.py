"""The closed loop: robot, readings, estimator and controller, all runs of a set in step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.estimators.pose_filters import PoseEstimator, RssModel
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.odometry import Rolling, RollingWheels
from octant.navigation.sensing.device import TagReceiver
from octant.navigation.sensing.rss_models import RssNoise
from octant.navigation.sensing.tag_frames import Hearing
from octant.navigation.sensing.tag_reader import BoardReader
from octant.navigation.tracking.controllers import TrackingController
from octant.navigation.tracking.trajectories import DesiredTrajectory

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """What really happens: the robot, its disturbances and its readings.

    Parameters
    ----------
    robot : The robot and its limits.
    period_s : Sample period T [s].
    sensor : RSS that the tags really send.
    noise : On every reading.
    rate_sigma_rad_per_s : Standard deviation of what is added to each wheel's rate [rad/s].
    start_covariance : (3, 3) float64 — How wrong the assumed start is, or its diagonal [m², rad²].
    reading_every : Periods from one reading of the tags to the next.
    rolling : Motors, slip and encoders; the estimator gets what encoders of a resolution count,
        and without one the commands.
    receiver : What the robot's receiver makes of the readings; None: a perfect one.
    hearing : How far tags reach, in which codes they answer, and when; None: always, exactly.
    reader : What reads in place of ``sensor`` with its ``noise``, which then say nothing; None:
        nothing does.
    """

    robot: DifferentialDrive
    period_s: float
    sensor: RssModel
    noise: RssNoise
    rate_sigma_rad_per_s: float
    start_covariance: FloatArray
    reading_every: int = 1
    rolling: Rolling = field(default_factory=Rolling)
    receiver: TagReceiver | None = None
    hearing: Hearing | None = None
    reader: BoardReader | None = None

    def __post_init__(self) -> None:
        given = np.array(self.start_covariance, dtype=np.float64)
        covariance = frozen_array(
            np.diag(given) if given.ndim == 1 else given,
            name="start_covariance",
            shape=(3, 3),
            error=NavigationError,
        )
        object.__setattr__(self, "start_covariance", covariance)
        if not (
            self.period_s > 0.0 and self.rate_sigma_rad_per_s >= 0.0 and self.reading_every > 0
        ):
            msg = (
                f"period_s is {self.period_s} s, rate_sigma {self.rate_sigma_rad_per_s} rad/s and "
                f"reading_every {self.reading_every}, but they must be positive, not negative and "
                "at least 1: correct the one that is not."
            )
            raise NavigationError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingRecord:
    """What a set of runs did.

    Parameters
    ----------
    desired : What was to be followed.
    poses, estimates : (r, k + 1, 3) float64 — True and estimated x [m], y [m], heading [rad].
    wheel_rates : (r, k, 2) float64 — Commanded right and left, cut to the limits [rad/s].
    watched : (r, k + 1, m) float64 or None — What `drive` was asked to keep besides
        [any].
    """

    desired: DesiredTrajectory
    poses: FloatArray
    estimates: FloatArray
    wheel_rates: FloatArray
    watched: FloatArray | None = None

    def __post_init__(self) -> None:
        runs, samples = len(self.poses), self.desired.steps + 1
        for name, shape in (
            ("poses", (runs, samples, 3)),
            ("estimates", (runs, samples, 3)),
            ("wheel_rates", (runs, samples - 1, 2)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)

    @property
    def errors_m(self) -> FloatArray:
        """Return the (r, k + 1) distances to the desired place at the same time [m]."""
        offset = self.poses[..., :2] - self.desired.poses[:, :2]
        errors: FloatArray = np.linalg.norm(offset, axis=-1)
        return errors

    @property
    def average_error_m(self) -> FloatArray:
        """Return the (r,) errors averaged over time, E / (t_f - t_0) of thesis (3.11) [m]."""
        average: FloatArray = self.errors_m[:, :-1].mean(axis=1)
        return average

    @property
    def final_error_m(self) -> FloatArray:
        """Return the (r,) last errors [m]."""
        return self.errors_m[:, -1]

    @property
    def final_heading_error_rad(self) -> FloatArray:
        """Return the (r,) sizes of the last heading errors [rad]."""
        return np.abs(wrap_angle(self.poses[:, -1, 2] - self.desired.poses[-1, 2]))

    def share_within_m(self, share: float) -> FloatArray:
        """Return the (r,) errors that are not exceeded for a share of the time [m].

        Parameters
        ----------
        share : From 0 to 1 [-]; 0.9 for the thesis' "90 % of the time".
        """
        quantile: FloatArray = np.quantile(self.errors_m, share, axis=1)
        return quantile


def run_seeds(seed: int, runs: int) -> list[np.random.SeedSequence]:
    """Return one seed for each run, the same for run i whatever the number of runs.

    Parameters
    ----------
    seed : Base seed, not negative.
    runs : Number of runs, at least 1.
    """
    if seed < 0 or runs < 1:
        msg = f"seed is {seed} and runs is {runs}, but they must be at least 0 and 1: raise them."
        raise NavigationError(msg)
    return np.random.SeedSequence(seed).spawn(runs)


def drive(
    controller: TrackingController,
    estimator: PoseEstimator[Any],
    world: World,
    desired: DesiredTrajectory,
    *,
    start: npt.ArrayLike,
    seeds: Sequence[np.random.SeedSequence],
    watch: Callable[[Any], FloatArray] | None = None,
) -> TrackingRecord:
    """Return the record of many runs of one tracking task, in the order of their seeds.

    Each period: decide, move on the exact arc with the wheels' noise added, read, estimate.

    Parameters
    ----------
    controller : What decides.
    estimator : Gives it the pose.
    world : What really happens.
    desired : Sampled at the world's period.
    start : (3,) float64 — True x [m], y [m], heading [rad] at the beginning of every run.
    seeds : From `run_seeds`: what happens in a run depends on its seed alone.
    watch : A belief to what is to be kept of it, (r, m), in every period; None: nothing.
    """
    if abs(desired.period_s - world.period_s) > 1e-12:
        msg = (
            f"the trajectory is sampled every {desired.period_s:g} s, but the world's period is "
            f"{world.period_s:g} s: sample it at the same."
        )
        raise NavigationError(msg)
    pairs = [[np.random.default_rng(child) for child in _children(seed)] for seed in seeds]
    rngs, own = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    runs, steps, period_s = len(rngs), desired.steps, world.period_s
    true = np.tile(np.asarray(start, dtype=np.float64), (runs, 1))
    wrong = np.linalg.cholesky(world.start_covariance + 1e-18 * np.eye(3))
    assumed = true + np.array([wrong @ rng.normal(size=3) for rng in rngs])
    belief = estimator.begin(assumed, world.start_covariance, own)
    rss = read_tags(world, true, np.zeros((runs, 2)), rngs)
    poses, estimates = np.empty((runs, steps + 1, 3)), np.empty((runs, steps + 1, 3))
    commanded = np.empty((runs, steps, 2))
    wheels = RollingWheels(world.rolling, world.robot, *rngs)
    poses[:, 0], estimates[:, 0] = true, estimator.poses(belief)
    seen = [] if watch is None else [watch(belief)]
    for k in range(steps):
        rates = world.robot.saturate(controller.wheel_rates(k, estimates[:, k].copy(), rss))
        noise = np.array([rng.normal(0.0, world.rate_sigma_rad_per_s, 2) for rng in rngs])
        real = wheels.turn(rates, period_s=period_s) + noise
        rolled = wheels.roll(real, period_s=1.0)  # of rates: rotations in a second
        true = world.robot.step_arc(true, rolled, period_s=period_s)
        counted = wheels.count(period_s * real) / period_s if world.rolling.tick_rad else rates
        heard = _replying(world, k, rss.shape[1])
        read = None
        if heard.any():
            now = read_tags(world, true, world.robot.twist(rolled), rngs)
            read = np.where(heard, now, np.nan)
            rss = np.where(heard, now, rss)
        belief = estimator.step(belief, counted, read, own)
        poses[:, k + 1], estimates[:, k + 1] = true, estimator.poses(belief)
        if watch is not None:
            seen.append(watch(belief))
        commanded[:, k] = rates
    return TrackingRecord(
        desired=desired,
        poses=poses,
        estimates=estimates,
        wheel_rates=commanded,
        watched=np.stack(seen, axis=1) if seen else None,
    )


def _children(seed: np.random.SeedSequence) -> list[np.random.SeedSequence]:
    """Return the seeds of the world and of the estimator; unlike spawn, the same every time."""
    return [
        np.random.SeedSequence(entropy=seed.entropy, spawn_key=(*seed.spawn_key, i))
        for i in range(2)
    ]


def read_tags(
    world: World, true: FloatArray, twists: FloatArray, rngs: Sequence[np.random.Generator]
) -> FloatArray:
    """Return one reading of all tags in every run, (r, s) [dBm]; NaN of tags that are not heard.

    Parameters
    ----------
    world : Tags, noise, receiver and hearing, or a reader in place of all that.
    true : (r, 3) float64 — True x [m], y [m], heading [rad].
    twists : (r, 2) float64 — Forward speed [m/s] and turn rate [rad/s] until then.
    rngs : One for each run.
    """
    if world.reader is not None:
        return world.reader.read(true, twists, rngs)
    clean = world.sensor.rss_dbm(true[:, :2])
    noisy: FloatArray = clean + np.array([world.noise.draw((clean.shape[1],), rng) for rng in rngs])
    read = noisy if world.receiver is None else world.receiver.heard(noisy, rngs)
    return read if world.hearing is None else world.hearing.heard(true, read)


def _replying(world: World, step: int, tags: int) -> npt.NDArray[np.bool_]:
    """Return which tags' replies arrive in a period, (s,); its end counts as the time of them."""
    if world.hearing is None or world.hearing.polling is None:
        return np.full(tags, (step + 1) % world.reading_every == 0)
    return world.hearing.polling.heard(step * world.period_s, (step + 1) * world.period_s)
