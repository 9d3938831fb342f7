"""The continuous-time filter of thesis 7.3.2 on RSS."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.estimators.kalman import Gaussian, predict
from octant.navigation.estimators.pose_filters import SmoothRssModel
from octant.navigation.estimators.rss_kalman import (
    RssFilter,
    expected_readings,
    with_zero_rows,
)
from octant.navigation.robot.drive import linear_model

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class KalmanBucy(RssFilter):
    """The continuous-time filter of thesis (7.43)-(7.45), readings held over a period.

    Parameters
    ----------
    motion : WheelMotion
        How the wheels move the robot; its period and noise.
    sensor : SmoothRssModel
        RSS against place.
    noise : RssAssumptions
        Of the readings.
    substeps : int
        Integration steps in a period.

    Notes
    -----
    Samples with covariance σ² every T have the density N_C = σ² T, and wheel rates held over T the
    density W_C = σ_u² T: with σ² and σ_u² themselves, as (7.41) invites, the filter would believe
    its readings ten times too little at T = 0.1 s.

    Each integration step moves first, then hears: dS/dt = -S HᵀN⁻¹H S has the exact solution
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
        """Return what is believed one period later.

        Parameters
        ----------
        belief : Gaussian
            Before.
        wheel_rates : (r, 2) float64
            Right and left [rad/s].
        rss_dbm : (r, s) float64 or None
            Readings of the period [dBm].
        rngs : sequence of numpy.random.Generator
            Not used.
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
        density = self.noise.sigma_db**2 * self.motion.period_s
        heard = np.swapaxes(slopes, 1, 2) / density
        growth = np.eye(belief.mean.shape[1]) + length_s * (heard @ slopes) @ belief.covariance
        spread = np.swapaxes(np.linalg.solve(np.swapaxes(growth, 1, 2), belief.covariance), 1, 2)
        spread = 0.5 * (spread + np.swapaxes(spread, 1, 2))
        step = (spread @ heard @ (rss_dbm - predicted)[..., None])[..., 0]
        return Gaussian(mean=belief.mean + length_s * step, covariance=spread)
