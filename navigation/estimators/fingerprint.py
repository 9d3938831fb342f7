"""Fingerprints: the places of a survey whose RSS is most alike, fused with the wheels' odometry."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.estimators.kalman import Gaussian, innovate, update
from octant.navigation.estimators.pose_filters import WheelMotion
from octant.navigation.estimators.rss_kalman import RssAssumptions, predict_motion
from octant.navigation.sensing.rss_maps import RssMap

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class FingerprintFilter:
    """A filter whose measurement is the mean of the k most similar surveyed places.

    Parameters
    ----------
    motion : How the wheels move the robot.
    survey : RSS at surveyed places.
    sigma_m : Standard deviation of a fix's coordinates [m]; measure it at known places.
    neighbours : How many places k are averaged.
    """

    motion: WheelMotion
    survey: RssMap
    sigma_m: float
    neighbours: int = 4

    def __post_init__(self) -> None:
        places = len(self.survey.x_m) * len(self.survey.y_m)
        if not (self.sigma_m > 0.0 and 1 <= self.neighbours <= places):
            msg = (
                f"sigma_m is {self.sigma_m} m with {self.neighbours} neighbours of {places} "
                "places, but the covariance must not be zero and k must fit: change them."
            )
            raise NavigationError(msg)

    def fix_m(self, rss_dbm: FloatArray) -> FloatArray:
        """Return the mean of the k most similar places, (r, 2) [m].

        Parameters
        ----------
        rss_dbm : (r, s) float64 — Readings [dBm]; NaN: a tag that was not heard.
        """
        x, y = np.meshgrid(self.survey.x_m, self.survey.y_m, indexing="ij")
        places = np.column_stack([x.ravel(), y.ravel()])
        prints = self.survey.rss.reshape(len(places), -1)
        fixes = np.empty((len(rss_dbm), 2))
        for run, reading in enumerate(rss_dbm):
            distance = np.nansum((prints - reading) ** 2, axis=1)
            nearest = np.argpartition(distance, self.neighbours - 1)[: self.neighbours]
            fixes[run] = places[nearest].mean(axis=0)
        return fixes

    def begin(
        self, poses: FloatArray, covariance: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> Gaussian:
        """Return what is believed at the start."""
        del rngs
        return RssAssumptions(mean_sigma_db=0.0).begin(poses, covariance)

    def step(
        self,
        belief: Gaussian,
        wheel_rates: FloatArray,
        rss_dbm: FloatArray | None,
        rngs: Sequence[np.random.Generator],
    ) -> Gaussian:
        """Return what is believed one period later."""
        del rngs
        moved = predict_motion(self.motion, belief, wheel_rates)
        if rss_dbm is None:
            return moved
        innovation = innovate(
            moved,
            self.fix_m(rss_dbm),
            observation=np.tile(np.eye(2, 3), (len(rss_dbm), 1, 1)),
            measurement_noise=self.sigma_m**2 * np.eye(2),
        )
        return update(moved, innovation, accept=~np.isnan(rss_dbm).all(axis=1))

    def poses(self, belief: Gaussian) -> FloatArray:
        """Return the estimated poses, (r, 3) [m, rad]."""
        return belief.mean
