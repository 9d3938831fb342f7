"""EKF SLAM as an estimator in a closed loop: thesis 7.4 with a controller that uses its pose."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.estimators.ekf_slam import tag_innovation
from octant.navigation.estimators.kalman import Gaussian, update
from octant.navigation.estimators.pose_filters import WheelMotion
from octant.navigation.estimators.rss_kalman import predict_motion

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class SlamEstimator:
    """Pose and tags from ranges and bearings, one tag after another, in Joseph form.

    Parameters
    ----------
    motion : How the wheels move the robot.
    tags_m : (s, 2) float64 — True places of the tags, of which the filter gets a first guess [m].
    tag_sigma_m : Standard deviation of each coordinate of that guess [m].
    range_sigma_m, bearing_sigma_rad : Of a measurement [m], [rad].
    """

    motion: WheelMotion
    tags_m: FloatArray
    tag_sigma_m: float = 0.5
    range_sigma_m: float = 1.5
    bearing_sigma_rad: float = 0.9

    def __post_init__(self) -> None:
        tags = frozen_array(self.tags_m, name="tags_m", shape=(None, 2), error=NavigationError)
        object.__setattr__(self, "tags_m", tags)
        for name, unit in (
            ("tag_sigma_m", "m"),
            ("range_sigma_m", "m"),
            ("bearing_sigma_rad", "rad"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)

    def begin(
        self, poses: FloatArray, covariance: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> Gaussian:
        """Return what is believed at the start: the pose, and a guess of every tag."""
        flat = self.tags_m.ravel()
        states = 3 + len(flat)
        mean = np.empty((len(poses), states))
        mean[:, :3] = poses
        mean[:, 3:] = [flat + rng.normal(0.0, self.tag_sigma_m, len(flat)) for rng in rngs]
        whole = self.tag_sigma_m**2 * np.eye(states)
        whole[:3, :3] = covariance
        return Gaussian(mean=mean, covariance=np.tile(whole, (len(poses), 1, 1)))

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
        belief, wheel_rates, rngs : As for `PoseEstimator.step` [rad/s].
        rss_dbm : (r, 2 s) float64 or None — In place of RSS, range [m] and bearing [rad] of every
            tag in turn; NaN: not measured.
        """
        del rngs
        belief = predict_motion(self.motion, belief, wheel_rates)
        if rss_dbm is None:
            return belief
        noise = np.diag([self.range_sigma_m**2, self.bearing_sigma_rad**2])
        measured = rss_dbm.reshape(len(rss_dbm), -1, 2)
        for tag in range(len(self.tags_m)):
            heard = np.asarray(~np.isnan(measured[:, tag]).any(axis=1))
            if heard.any():
                one = np.where(heard[:, None], measured[:, tag], 0.0)
                belief = update(belief, tag_innovation(belief, tag, one, noise), accept=heard)
        return belief

    def poses(self, belief: Gaussian) -> FloatArray:
        """Return the estimated poses, (r, 3) [m, rad]."""
        return belief.mean[:, :3]
