"""The law of the tags' RSS fitted on line, thesis 6.3: alpha and beta estimated with the pose."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.estimators.kalman import Gaussian
from octant.navigation.estimators.rss_kalman import (
    RssFilter,
    corrected,
    only_heard,
    predict_motion,
)
from octant.navigation.sensing.rss_models import LogExponentialLaw

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LawFittingKalman(RssFilter):
    """The extended Kalman filter with alpha and beta of (6.2) as further states.

    Section 6.3 says that the two are optimised on line by nonlinear least squares, and no more.
    Constant states of a Kalman filter are recursive least squares: each reading is taken in by
    Gauss-Newton steps from what was believed (the iterated extended filter), with all its
    correlation with the pose, which is estimated from the same readings.

    Parameters
    ----------
    motion, noise : As of `RssFilter`.
    tags_m : (s, 3) float64 — The tags, heights above the antenna [m].
    guess : The law that is believed first.
    alpha_sigma_dbm, beta_sigma_per_m : How uncertain it is [dBm], [1/m].
    iterations : Gauss-Newton steps for each reading.

    Notes
    -----
    States: x [m], y [m], heading [rad], alpha [dBm], beta [1/m], and the noise's mean [dB] where
    ``noise`` has one.
    """

    tags_m: FloatArray
    guess: LogExponentialLaw
    alpha_sigma_dbm: float
    beta_sigma_per_m: float
    iterations: int = 3

    def __post_init__(self) -> None:
        tags = frozen_array(self.tags_m, name="tags_m", shape=(None, 3), error=NavigationError)
        object.__setattr__(self, "tags_m", tags)
        check_positive(self.alpha_sigma_dbm, name="alpha_sigma_dbm", unit="dBm")
        check_positive(self.beta_sigma_per_m, name="beta_sigma_per_m", unit="1/m")

    def begin(
        self, poses: FloatArray, covariance: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> Gaussian:
        """Return what is believed at the start."""
        del rngs
        first = self.noise.begin(poses, covariance)
        runs, states = first.mean.shape
        order = [0, 1, 2, *range(5, states + 2)]
        mean = np.zeros((runs, states + 2))
        mean[:, order] = first.mean
        mean[:, 3:5] = self.guess.alpha_dbm, self.guess.beta_per_m
        spread = np.zeros((runs, states + 2, states + 2))
        spread[:, np.array(order)[:, None], order] = first.covariance
        spread[:, 3, 3], spread[:, 4, 4] = self.alpha_sigma_dbm**2, self.beta_sigma_per_m**2
        return Gaussian(mean=mean, covariance=spread)

    def step(
        self,
        belief: Gaussian,
        wheel_rates: FloatArray,
        rss_dbm: FloatArray | None,
        rngs: Sequence[np.random.Generator],
    ) -> Gaussian:
        """Return what is believed one period later.

        Parameters
        ----------
        belief, wheel_rates, rss_dbm, rngs : As for `PoseEstimator.step` [rad/s], [dBm].
        """
        del rngs
        moved = predict_motion(self.motion, belief, wheel_rates)
        if rss_dbm is None:
            return moved
        found = moved
        for _ in range(self.iterations):
            predicted, slopes = self._expected(found.mean)
            back = (slopes @ (moved.mean - found.mean)[..., None])[..., 0]
            residual, slopes = only_heard(rss_dbm - predicted - back, slopes)
            found = corrected(moved, residual, slopes, sigma_db=self.noise.sigma_db)
        return found

    def _expected(self, mean: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the expected readings (r, s) [dBm] and their slopes by all states."""
        offset = mean[:, None, :2] - self.tags_m[:, :2]
        distance = np.sqrt(np.sum(offset**2, axis=-1) + self.tags_m[:, 2] ** 2)
        alpha, beta = mean[:, 3, None], mean[:, 4, None]
        growth = np.exp(beta * distance)
        rss = alpha * growth
        slopes = np.zeros((*rss.shape, mean.shape[1]))
        slopes[:, :, :2] = (beta * rss / distance)[..., None] * offset
        slopes[:, :, 3], slopes[:, :, 4] = growth, distance * rss
        if mean.shape[1] == 6:
            rss = rss + mean[:, 5:]
            slopes[:, :, 5] = 1.0
        return rss, slopes
