"""EKF SLAM, thesis 7.4: the robot's pose and the tags' places, from ranges and bearings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.estimators.kalman import (
    Gaussian,
    Innovation,
    covariance_matrix,
    innovate,
    nees,
    update,
)
from octant.navigation.estimators.pose_filters import WheelMotion
from octant.navigation.estimators.rss_kalman import predict_motion

FloatArray = npt.NDArray[np.float64]


def range_and_bearing(states: npt.ArrayLike, tag: int) -> FloatArray:
    """Return what the robot would measure of a tag, (r, 2): range [m] and bearing [rad].

    Thesis (7.47), whose atan2(y - yʲ, x - xʲ) points from the tag to the robot: the bearing to the
    tag is half a turn from it. The slopes are the same.

    Parameters
    ----------
    states : (r, 3 + 2 s) float64 — x [m], y [m], heading [rad], then x and y of every tag [m].
    tag : Number of the tag, from 0.
    """
    mean = np.asarray(states, dtype=np.float64)
    offset = mean[:, :2] - mean[:, 3 + 2 * tag : 5 + 2 * tag]
    bearing = wrap_angle(np.arctan2(-offset[:, 1], -offset[:, 0]) - mean[:, 2])
    return np.column_stack([np.hypot(offset[:, 0], offset[:, 1]), bearing])


def tag_innovation(
    belief: Gaussian, tag: int, measured: npt.ArrayLike, noise: npt.ArrayLike
) -> Innovation:
    """Return the innovation of one tag's range and bearing, the bearing wrapped.

    Parameters
    ----------
    belief : (r, 3 + 2 s) states, before.
    tag : Number of the tag, from 0.
    measured : (r, 2) float64 — Range [m] and bearing [rad].
    noise : (2, 2) float64 — Covariance of the measurement [m², rad²].
    """
    mean = belief.mean
    offset = mean[:, :2] - mean[:, 3 + 2 * tag : 5 + 2 * tag]
    square = np.sum(offset**2, axis=1)
    distance = np.sqrt(square)
    slopes = np.zeros((len(mean), 2, mean.shape[1]))
    slopes[:, 0, :2] = offset / distance[:, None]
    slopes[:, 1, 0], slopes[:, 1, 1] = -offset[:, 1] / square, offset[:, 0] / square
    slopes[:, :, 3 + 2 * tag : 5 + 2 * tag] = -slopes[:, :, :2]
    slopes[:, 1, 2] = -1.0
    return innovate(
        belief,
        measured,
        observation=slopes,
        measurement_noise=noise,
        predicted=range_and_bearing(mean, tag),
        angles=(1,),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SlamTask:
    """A SLAM experiment: constant wheel rates among tags; the defaults are thesis 7.7.

    Parameters
    ----------
    motion : The wheels with their noise.
    start : (3,) float64 — x [m], y [m], heading [rad], known exactly.
    wheel_rates_rad_per_s : (2,) float64 — Right and left, commanded all the time [rad/s].
    steps : Number of periods.
    tags_m : (s, 2) float64 — True places of the tags [m].
    tag_sigma_m : Standard deviation of each coordinate of a tag's first guess [m].
    range_sigma_m, bearing_sigma_rad : Of each measurement [m], [rad].
    """

    motion: WheelMotion
    start: FloatArray
    wheel_rates_rad_per_s: FloatArray
    steps: int
    tags_m: FloatArray
    tag_sigma_m: float = 0.5
    range_sigma_m: float = 1.5
    bearing_sigma_rad: float = 0.9

    def __post_init__(self) -> None:
        for name, shape in (
            ("start", (3,)),
            ("wheel_rates_rad_per_s", (2,)),
            ("tags_m", (None, 2)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)
        self.noise  # noqa: B018  refuses a zero covariance before any run
        if self.steps < 1 or len(self.tags_m) == 0 or not self.tag_sigma_m > 0.0:
            msg = (
                f"steps is {self.steps}, with {len(self.tags_m)} tags of {self.tag_sigma_m} m, but "
                "SLAM needs a step, a tag and a positive deviation of the first guess: add them."
            )
            raise NavigationError(msg)

    @property
    def noise(self) -> FloatArray:
        """Return the (2, 2) covariance of a measurement [m², rad²]."""
        return covariance_matrix(
            np.array([self.range_sigma_m**2, self.bearing_sigma_rad**2]),
            states=2,
            name="the covariance of range and bearing",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class SlamRecord:
    """What a set of SLAM runs did.

    Parameters
    ----------
    time_s : (k + 1,) float64 — Times [s].
    true_poses, poses : (r, k + 1, 3) float64 — True and estimated x [m], y [m], heading [rad].
    reckoned : (k + 1, 3) float64 — Dead reckoning from the commands, one for all runs [m, rad].
    sigmas : (r, k + 1, 3) float64 — Standard deviations of the pose by the filter [m, rad].
    final : All states at the end.
    nees : (r,) float64 — Normalised error squared of the last pose [-]; 3 on average if consistent.
    """

    time_s: FloatArray
    true_poses: FloatArray
    poses: FloatArray
    reckoned: FloatArray
    sigmas: FloatArray
    final: Gaussian
    nees: FloatArray

    @property
    def final_error_m(self) -> FloatArray:
        """Return the (r,) errors of the place at the end [m]."""
        offset = self.poses[:, -1, :2] - self.true_poses[:, -1, :2]
        errors: FloatArray = np.linalg.norm(offset, axis=1)
        return errors

    @property
    def reckoned_error_m(self) -> FloatArray:
        """Return the (r,) errors of dead reckoning at the end [m]."""
        offset = self.reckoned[-1, :2] - self.true_poses[:, -1, :2]
        errors: FloatArray = np.linalg.norm(offset, axis=1)
        return errors

    @property
    def diverged(self) -> npt.NDArray[np.bool_]:
        """Return for each run, (r,), whether the pose is out by over five of its sigmas [-]."""
        error = np.abs(self.poses[:, -1] - self.true_poses[:, -1])
        error[:, 2] = np.abs(wrap_angle(error[:, 2]))
        return np.asarray((error > 5.0 * self.sigmas[:, -1]).any(axis=1))


def run_slam(task: SlamTask, seeds: Sequence[np.random.SeedSequence]) -> SlamRecord:
    """Return many runs of EKF SLAM, one for each seed, in order.

    Thesis 7.4.2, misprints corrected: the gain is S Hᵀ (H S Hᵀ + N)⁻¹ (inverse missing), the
    covariance's prediction G S Gᵀ (transpose missing), the second row of L is sin, F̄ is 3 x (2 s +
    3), the bearing's innovation is wrapped; the update is in Joseph form, one tag after another.

    Parameters
    ----------
    task : The experiment.
    seeds : One for each run.
    """
    rngs = [np.random.default_rng(seed) for seed in seeds]
    runs, tags = len(rngs), len(task.tags_m)
    states = 3 + 2 * tags
    mean, covariance = np.zeros((runs, states)), np.zeros((states, states))
    mean[:, :3] = task.start
    flat = task.tags_m.ravel()
    mean[:, 3:] = [flat + rng.normal(0.0, task.tag_sigma_m, 2 * tags) for rng in rngs]
    covariance[3:, 3:] = task.tag_sigma_m**2 * np.eye(2 * tags)
    belief = Gaussian(mean=mean, covariance=np.tile(covariance, (runs, 1, 1)))
    true = np.tile(np.concatenate([task.start, flat]), (runs, 1))
    rates = np.tile(task.wheel_rates_rad_per_s, (runs, 1))
    sigma = np.array([task.range_sigma_m, task.bearing_sigma_rad])
    shape = (runs, task.steps + 1, 3)
    true_poses, poses, sigmas = np.empty(shape), np.empty(shape), np.zeros(shape)
    true_poses[:, 0] = poses[:, 0] = task.start
    for k in range(task.steps):
        slip = task.motion.rate_sigma_rad_per_s * np.array([rng.normal(size=2) for rng in rngs])
        true[:, :3] = task.motion.moved(true[:, :3], rates + slip)
        belief = predict_motion(task.motion, belief, rates)
        errors = sigma * np.array([rng.normal(size=(tags, 2)) for rng in rngs])
        for tag in range(tags):
            measured = range_and_bearing(true, tag) + errors[:, tag]
            belief = update(belief, tag_innovation(belief, tag, measured, task.noise))
        true_poses[:, k + 1], poses[:, k + 1] = true[:, :3], belief.mean[:, :3]
        sigmas[:, k + 1] = np.sqrt(np.diagonal(belief.covariance, axis1=1, axis2=2)[:, :3])
    pose = Gaussian(mean=belief.mean[:, :3], covariance=belief.covariance[:, :3, :3])
    reckoned = np.empty((task.steps + 1, 3))
    reckoned[0] = task.start
    for k in range(task.steps):
        reckoned[k + 1] = task.motion.moved(reckoned[k], task.wheel_rates_rad_per_s)
    return SlamRecord(
        time_s=task.motion.period_s * np.arange(task.steps + 1, dtype=np.float64),
        true_poses=true_poses,
        poses=poses,
        reckoned=reckoned,
        sigmas=sigmas,
        final=belief,
        nees=nees(pose, true[:, :3], angles=(2,)),
    )
