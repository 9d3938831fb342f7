"""A particle filter on an RSS model of any shape, such as a map full of fades."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.estimators.pose_filters import RssModel, WheelMotion

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Particles:
    """What a particle filter believes.

    Parameters
    ----------
    poses : (r, n, 3) float64 — x [m], y [m], heading [rad] of every particle of every run.
    log_weights : (r, n) float64 — Logarithms of their weights, up to a constant for each run [-].
    """

    poses: FloatArray
    log_weights: FloatArray

    def __post_init__(self) -> None:
        for name, shape in (
            ("poses", (None, None, 3)),
            ("log_weights", self.poses.shape[:2]),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)

    @property
    def weights(self) -> FloatArray:
        """Return the (r, n) weights, one in sum for each run [-]."""
        weights = np.exp(self.log_weights - self.log_weights.max(axis=1, keepdims=True))
        normal: FloatArray = weights / weights.sum(axis=1, keepdims=True)
        return normal


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleFilter:
    """A bootstrap particle filter with systematic resampling.

    Parameters
    ----------
    motion : How the wheels move the robot; every particle draws its own wheel noise.
    sensor : RSS against place.
    sigma_db : Standard deviation of a reading from the model, its own error included [dB].
    particles : Number of particles.
    jitter_m, jitter_rad : Spread added after resampling, so that equal particles part [m], [rad].
    """

    motion: WheelMotion
    sensor: RssModel
    sigma_db: float
    particles: int = 500
    jitter_m: float = 0.005
    jitter_rad: float = 0.005

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sigma_db) and self.sigma_db > 0.0 and self.particles > 1):
            msg = (
                f"sigma_db is {self.sigma_db} dB with {self.particles} particles, but the "
                "readings' covariance must not be zero and there must be at least two: raise them."
            )
            raise NavigationError(msg)

    def begin(
        self, poses: FloatArray, covariance: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> Particles:
        """Return particles spread around the assumed poses."""
        root = np.linalg.cholesky(covariance + 1e-18 * np.eye(3))
        spread = np.array([rng.normal(size=(self.particles, 3)) for rng in rngs]) @ root.T
        return Particles(
            poses=poses[:, None] + spread, log_weights=np.zeros((len(poses), self.particles))
        )

    def step(
        self,
        belief: Particles,
        wheel_rates: FloatArray,
        rss_dbm: FloatArray | None,
        rngs: Sequence[np.random.Generator],
    ) -> Particles:
        """Return the particles one period later."""
        sigma = self.motion.rate_sigma_rad_per_s
        slips = np.array([rng.normal(0.0, sigma, (self.particles, 2)) for rng in rngs])
        poses = self.motion.moved(belief.poses, wheel_rates[:, None] + slips)
        weights = belief.log_weights
        if rss_dbm is not None:
            runs = len(poses)
            expected = self.sensor.rss_dbm(poses.reshape(-1, 3)[:, :2])
            offset = rss_dbm[:, None] - expected.reshape(runs, self.particles, -1)
            offset = np.where(np.isnan(offset), 0.0, offset)  # a tag not heard says nothing
            weights = weights - 0.5 * np.sum(offset**2, axis=2) / self.sigma_db**2
            poses, weights = self._resampled(Particles(poses=poses, log_weights=weights), rngs)
        return Particles(poses=poses, log_weights=weights)

    def _resampled(
        self, belief: Particles, rngs: Sequence[np.random.Generator]
    ) -> tuple[FloatArray, FloatArray]:
        """Return poses and log weights, drawn anew in runs where fewer than half of them count."""
        poses, weights = belief.poses.copy(), belief.weights
        log_weights = belief.log_weights - belief.log_weights.max(axis=1, keepdims=True)
        n = self.particles
        jitter = np.array([self.jitter_m, self.jitter_m, self.jitter_rad])
        for run in np.flatnonzero(1.0 / np.sum(weights**2, axis=1) < 0.5 * n).tolist():
            marks = (np.arange(n) + rngs[run].uniform()) / n
            total = np.cumsum(weights[run])
            drawn = np.minimum(np.searchsorted(total, marks * total[-1]), n - 1)
            poses[run] = poses[run, drawn] + jitter * rngs[run].normal(size=(n, 3))
            log_weights[run] = 0.0
        return poses, log_weights

    def poses(self, belief: Particles) -> FloatArray:
        """Return the weighted mean poses, (r, 3) [m, rad]; headings are never wrapped."""
        mean: FloatArray = np.sum(belief.weights[..., None] * belief.poses, axis=1)
        return mean
