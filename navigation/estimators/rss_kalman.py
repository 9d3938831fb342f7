"""Kalman filters on RSS: extended, unscented, and the continuous-time one of thesis 7.3.2."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.estimators.kalman import Gaussian, innovate, predict, update
from octant.navigation.estimators.pose_filters import RssModel, SmoothRssModel, WheelMotion
from octant.navigation.robot.drive import linear_model

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RssAssumptions:
    """What a filter assumes of the noise on RSS readings.

    Parameters
    ----------
    sigma_db : Standard deviation of each reading [dB].
    mean_sigma_db : The same of the noise's mean at the start [dB]; 0: no mean, as in the thesis.
    """

    sigma_db: float = 50.0
    mean_sigma_db: float = 50.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sigma_db) and self.sigma_db > 0.0):
            msg = (
                f"the readings' standard deviation is {self.sigma_db} dB, but a filter divides by "
                "their covariance, which must not be zero: give a positive deviation."
            )
            raise NavigationError(msg)
        if not (np.isfinite(self.mean_sigma_db) and self.mean_sigma_db >= 0.0):
            msg = (
                f"mean_sigma_db is {self.mean_sigma_db} dB, but it must be finite and not "
                "negative: 0 leaves the mean out."
            )
            raise NavigationError(msg)

    def begin(self, poses: FloatArray, covariance: FloatArray) -> Gaussian:
        """Return the first belief: the pose, and the mean where it is estimated.

        Parameters
        ----------
        poses : (r, 3) float64 — x [m], y [m], heading [rad].
        covariance : (3, 3) float64 — Of the pose [m², rad²].
        """
        states = 4 if self.mean_sigma_db > 0.0 else 3
        mean = np.zeros((len(poses), states))
        mean[:, :3] = poses
        whole = np.zeros((states, states))
        whole[:3, :3] = covariance
        whole[3:, 3:] = self.mean_sigma_db**2
        return Gaussian(mean=mean, covariance=np.tile(whole, (len(poses), 1, 1)))


def with_zero_rows(states: int, matrix: FloatArray) -> FloatArray:
    """Return Jacobians of the pose, (r, 3, c), with zero rows for further states, (r, n, c).

    Parameters
    ----------
    states : Number n of states.
    matrix : (r, 3, c) float64 — Derivatives of the pose [m, rad per unit of the columns].
    """
    out = np.zeros((len(matrix), states, matrix.shape[2]))
    out[:, :3] = matrix
    return out


@dataclass(frozen=True, slots=True, kw_only=True)
class RssFilter:
    """What the Kalman filters on RSS share: motion, noise, first belief, pose.

    Parameters
    ----------
    motion : How the wheels move the robot.
    noise : Of the readings.
    """

    motion: WheelMotion
    noise: RssAssumptions

    def begin(
        self, poses: FloatArray, covariance: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> Gaussian:
        """Return what is believed at the start: (r, 3 or 4) means, the fourth the noise's mean.

        Parameters
        ----------
        poses, covariance, rngs : As for `PoseEstimator.begin` [m, rad], [m², rad²].
        """
        del rngs
        return self.noise.begin(poses, covariance)

    def poses(self, belief: Gaussian) -> FloatArray:
        """Return the estimated poses, (r, 3) [m, rad].

        Parameters
        ----------
        belief : What `step` returned.
        """
        return belief.mean[:, :3]


@dataclass(frozen=True, slots=True, kw_only=True)
class ExtendedKalman(RssFilter):
    """The discrete extended Kalman filter, in Joseph form, with a step of O(n² s).

    All s readings have the same independent noise: with H = Q R, the n numbers Qᵀ (z - h) hold all
    that they say of the n states, and their Jacobian is R.

    Parameters
    ----------
    motion : How the wheels move the robot.
    sensor : RSS against place.
    noise : Of the readings.
    """

    sensor: SmoothRssModel

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
        predicted, slopes = expected_readings(self.sensor, moved)
        residual, slopes = only_heard(rss_dbm - predicted, slopes)
        return corrected(moved, residual, slopes, sigma_db=self.noise.sigma_db)


def corrected(
    belief: Gaussian, residual_db: FloatArray, slopes: FloatArray, *, sigma_db: float
) -> Gaussian:
    """Return a belief after readings of the same independent noise, as of `ExtendedKalman`.

    Parameters
    ----------
    belief : Before, (r, n).
    residual_db, slopes : Readings less what was expected (r, s) [dB], slopes (r, s, n) by states.
    sigma_db : Standard deviation of a reading [dB].
    """
    turned, small = np.linalg.qr(slopes)
    heard = np.swapaxes(turned, 1, 2) @ residual_db[..., None]
    innovation = innovate(
        belief,
        heard[..., 0],
        observation=small,
        measurement_noise=sigma_db**2 * np.eye(small.shape[1]),
        predicted=np.zeros(small.shape[:2]),
    )
    return update(belief, innovation)


def predict_motion(motion: WheelMotion, belief: Gaussian, wheel_rates: FloatArray) -> Gaussian:
    """Return a Gaussian belief after one period of wheel motion, before any reading.

    Parameters
    ----------
    motion : The motion and its noise.
    belief : The first three states are the pose [m, rad]; further ones do not change.
    wheel_rates : (r, 2) float64 — Right and left [rad/s].
    """
    by_pose, by_rates = motion.jacobians(belief.mean[:, :3], wheel_rates)
    states = belief.mean.shape[1]
    transition = np.tile(np.eye(states), (len(by_pose), 1, 1))
    transition[:, :3, :3] = by_pose
    spread = motion.rate_sigma_rad_per_s * with_zero_rows(states, by_rates)
    mean = belief.mean.copy()
    mean[:, :3] = motion.moved(belief.mean[:, :3], wheel_rates)
    return predict(
        belief,
        transition=transition,
        process_noise=spread @ np.swapaxes(spread, 1, 2),
        moved_mean=mean,
    )


def expected_readings(sensor: SmoothRssModel, belief: Gaussian) -> tuple[FloatArray, FloatArray]:
    """Return the expected readings (r, s) [dBm] and their slopes (r, s, n) by all states.

    Parameters
    ----------
    sensor : RSS against place.
    belief : Pose [m, rad], and the noise's mean [dB] where there is a fourth state.
    """
    mean = belief.mean
    predicted = sensor.rss_dbm(mean[:, :2])
    slopes = np.zeros((*predicted.shape, mean.shape[1]))
    slopes[:, :, :2] = sensor.slopes_db_per_m(mean[:, :2])
    if mean.shape[1] == 4:
        predicted = predicted + mean[:, 3:]
        slopes[:, :, 3] = 1.0
    return predicted, slopes


def only_heard(residual_db: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return residuals (r, s) [dB] and what belongs to each, (r, s, n), zero for tags not heard.

    A row of zeros says nothing to a filter, so that it stays as it was without that tag.

    Parameters
    ----------
    residual_db : (r, s) float64 — Readings less what was expected [dB]; NaN: not heard.
    rows : (r, s, n) float64 — Slopes, or sigma points, of every reading [dB per state's unit].
    """
    lost = np.isnan(residual_db)
    if not lost.any():
        return residual_db, rows
    return np.where(lost, 0.0, residual_db), np.where(lost[..., None], 0.0, rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class UnscentedKalman(RssFilter):
    """The unscented Kalman filter: sigma points in place of slopes.

    2 n points with equal weights (Julier and Uhlmann with κ = 0, the cubature rule of third degree)
    for the readings; the motion is predicted as in the extended filter. The gain P_xz (P_zz + σ²
    I)⁻¹ is solved among the 2 n points, not among the s readings.

    Parameters
    ----------
    motion, sensor, noise : As of `ExtendedKalman`, but the sensor need not be smooth.
    """

    sensor: RssModel

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
        return moved if rss_dbm is None else self._corrected(moved, rss_dbm)

    def _corrected(self, belief: Gaussian, rss_dbm: FloatArray) -> Gaussian:
        runs, states = belief.mean.shape
        root = np.swapaxes(np.linalg.cholesky(states * belief.covariance), 1, 2)
        points = belief.mean[:, None] + np.concatenate([root, -root], axis=1)
        flat = points.reshape(-1, states)
        read = self.sensor.rss_dbm(flat[:, :2])
        if states == 4:
            read = read + flat[:, 3:]
        read = read.reshape(runs, 2 * states, -1)
        predicted = read.mean(axis=1)
        spread = (read - predicted[:, None]) / np.sqrt(2 * states)
        offset = (points - belief.mean[:, None]) / np.sqrt(2 * states)
        residual, columns = only_heard(rss_dbm - predicted, np.swapaxes(spread, 1, 2))
        spread = np.swapaxes(columns, 1, 2)
        heard = (spread @ residual[..., None])[..., 0]
        gram = spread @ np.swapaxes(spread, 1, 2)
        noisy = gram + self.noise.sigma_db**2 * np.eye(2 * states)
        # K = X (Y'Y + s² I)^-1 Y' with X the points' and Y' the readings' offsets.
        mean = belief.mean + np.sum(offset * np.linalg.solve(noisy, heard[..., None]), axis=1)
        shrunk = np.swapaxes(offset, 1, 2) @ np.linalg.solve(noisy, gram @ offset)
        covariance = belief.covariance - 0.5 * (shrunk + np.swapaxes(shrunk, 1, 2))
        return Gaussian(mean=mean, covariance=covariance)


@dataclass(frozen=True, slots=True, kw_only=True)
class KalmanBucy(RssFilter):
    """The continuous-time filter of thesis (7.43)-(7.45), readings held over a period.

    Parameters
    ----------
    motion, sensor, noise : As of `ExtendedKalman`.
    substeps : Integration steps in a period.

    Notes
    -----
    Samples with covariance σ² every T have the density N_C = σ² T, and wheel rates held over T the
    density W_C = σ_u² T: with σ² and σ_u² themselves, as (7.41) invites, the filter would believe
    its readings ten times too little at T = 0.1 s.

    Each integration step moves first, then corrects: dS/dt = -S HᵀN⁻¹H S has the exact solution
    S (I + t HᵀN⁻¹H S)⁻¹, which stays positive where the explicit form of (7.44) explodes, as it
    does while the noise's mean is still unknown. The splitting is of first order in the step.
    """

    sensor: SmoothRssModel
    substeps: int = 4

    def step(
        self,
        belief: Gaussian,
        wheel_rates: FloatArray,
        rss_dbm: FloatArray | None,
        rngs: Sequence[np.random.Generator],
    ) -> Gaussian:
        """Return what is believed one period later, the readings held over the period.

        Parameters
        ----------
        belief, wheel_rates, rss_dbm, rngs : As for `PoseEstimator.step` [rad/s], [dBm].
        """
        del rngs
        length = self.motion.period_s / self.substeps
        for _ in range(self.substeps):
            belief = self._drifted(belief, wheel_rates, length)
            if rss_dbm is not None:
                belief = self._corrected(belief, rss_dbm, length)
        return belief

    def _drifted(self, belief: Gaussian, wheel_rates: FloatArray, length_s: float) -> Gaussian:
        """Return the belief after f of (7.45) and the first three terms of (7.44)."""
        mean, _spread = belief.mean, belief.covariance
        motion, states = self.motion, mean.shape[1]
        pose_rate = motion.robot.pose_rate(mean[:, :3], wheel_rates)
        middle = mean[:, :3] + 0.5 * length_s * pose_rate
        pose_rate = motion.robot.pose_rate(middle, wheel_rates)
        f, g = linear_model(middle, wheel_rates, motion.robot)
        moved = mean.copy()
        moved[:, :3] += length_s * pose_rate
        transition = np.tile(np.eye(states), (len(mean), 1, 1))
        transition[:, :3, :3] += length_s * f
        density = motion.rate_sigma_rad_per_s**2 * motion.period_s
        wide = with_zero_rows(states, g)
        return predict(
            belief,
            transition=transition,
            process_noise=length_s * density * wide @ np.swapaxes(wide, 1, 2),
            moved_mean=moved,
        )

    def _corrected(self, belief: Gaussian, rss_dbm: FloatArray, length_s: float) -> Gaussian:
        """Return the belief after the last terms of (7.44), solved exactly, and of (7.45)."""
        predicted, slopes = expected_readings(self.sensor, belief)
        residual, slopes = only_heard(rss_dbm - predicted, slopes)
        density = self.noise.sigma_db**2 * self.motion.period_s
        heard = np.swapaxes(slopes, 1, 2) / density
        growth = np.eye(belief.mean.shape[1]) + length_s * (heard @ slopes) @ belief.covariance
        spread = np.swapaxes(np.linalg.solve(np.swapaxes(growth, 1, 2), belief.covariance), 1, 2)
        spread = 0.5 * (spread + np.swapaxes(spread, 1, 2))
        step = (spread @ heard @ residual[..., None])[..., 0]
        return Gaussian(mean=belief.mean + length_s * step, covariance=spread)
