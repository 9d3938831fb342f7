"""Where a tag hangs, estimated from bearings that reflections falsify, while the robot drives.

One bearing may point anywhere; many from different places agree only at the tag. The estimate is a
histogram over the floor with a likelihood that expects outliers.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TagPlaceBelief:
    """What is known of a tag's place in the frame of the robot's odometry.

    Parameters
    ----------
    axis_m : (g,) float64 — Coordinates of the cells along x and along y [m].
    log_weight : (g, g) float64 — Logarithm of each cell's weight, rows along y [-].
    window_m : Half the side of the square about the best cell over which the place is averaged [m].
    """

    axis_m: FloatArray
    log_weight: FloatArray
    window_m: float

    @property
    def weight(self) -> FloatArray:
        """Return the (g, g) probabilities of the cells, rows along y [-]."""
        raw = np.exp(self.log_weight - self.log_weight.max())
        return np.asarray(raw / raw.sum())

    def place(self) -> tuple[FloatArray, float]:
        """Return the mean of the cells about the best, (2,), and the RMS distance of all [m]."""
        weight = self.weight
        row, column = np.unravel_index(int(np.argmax(weight)), weight.shape)
        near_x = np.abs(self.axis_m - self.axis_m[column]) <= self.window_m
        near_y = np.abs(self.axis_m - self.axis_m[row]) <= self.window_m
        local = weight * near_y[:, None] * near_x
        local = local / local.sum()
        place = np.array([local.sum(axis=0) @ self.axis_m, local.sum(axis=1) @ self.axis_m])
        dx, dy = self.axis_m - place[0], self.axis_m - place[1]
        variance = weight.sum(axis=0) @ dx**2 + weight.sum(axis=1) @ dy**2
        return place, float(np.sqrt(variance))


@dataclass(frozen=True, slots=True, kw_only=True)
class TagPlaceFilter:
    """An estimator of a tag's place from bearings.

    Parameters
    ----------
    reach_m : How far from its start the robot looks for the tag, along x and y [m].
    spacing_m : Size of a cell [m].
    bearing_sd_rad : Standard deviation of a good bearing [rad].
    outlier_share : Share of bearings that point anywhere, in (0, 1) [-].
    blur_m : How well odometry knows where a bearing was taken [m]; it counts near the tag.
    trust : Power of each likelihood, in (0, 1] [-]: near readings share their reflections.
    """

    reach_m: float = 9.0
    spacing_m: float = 0.25
    bearing_sd_rad: float = 0.35
    outlier_share: float = 0.3
    blur_m: float = 0.3
    trust: float = 0.5

    def __post_init__(self) -> None:
        for name, unit in (
            ("reach_m", "m"),
            ("spacing_m", "m"),
            ("bearing_sd_rad", "rad"),
            ("blur_m", "m"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)
        if not (0.0 < self.outlier_share < 1.0 and 0.0 < self.trust <= 1.0):
            msg = (
                f"outlier_share is {self.outlier_share} and trust is {self.trust}, but both must "
                "lie between 0 and 1: 0.3 and 0.5 suit a concrete room."
            )
            raise NavigationError(msg)

    def start(self) -> TagPlaceBelief:
        """Return the belief before the first bearing: the tag is anywhere within reach."""
        cells = 2 * round(self.reach_m / self.spacing_m) + 1
        axis = np.asarray(self.spacing_m * (np.arange(cells) - (cells - 1) / 2.0))
        return TagPlaceBelief(
            axis_m=axis, log_weight=np.zeros((cells, cells)), window_m=3.0 * self.spacing_m
        )

    def observe(
        self, belief: TagPlaceBelief, pose: npt.ArrayLike, *, bearing_rad: float
    ) -> TagPlaceBelief:
        """Return the belief after one bearing.

        Parameters
        ----------
        belief : Belief before.
        pose : (3,) array_like — x [m], y [m], heading [rad] by odometry, from the start.
        bearing_rad : Tag from the robot's front, counter-clockwise [rad]; NaN: nothing changes.
        """
        if not np.isfinite(bearing_rad):
            return belief
        x, y, heading = (float(c) for c in np.asarray(pose, dtype=np.float64))
        dx, dy = belief.axis_m - x, (belief.axis_m - y)[:, None]
        error = wrap_angle(np.arctan2(dy, dx) - heading - bearing_rad)
        distance2 = np.maximum(dx**2 + dy**2, (0.5 * self.spacing_m) ** 2)
        # Capped at the variance of a direction that may be any: beside the tag none is informative.
        spread = self.bearing_sd_rad**2 + self.blur_m**2 / distance2
        variance = np.minimum(spread, np.pi**2 / 3.0)
        peak = np.exp(-0.5 * error**2 / variance) / np.sqrt(2.0 * np.pi * variance)
        density = (1.0 - self.outlier_share) * peak + self.outlier_share / (2.0 * np.pi)
        return TagPlaceBelief(
            axis_m=belief.axis_m,
            log_weight=belief.log_weight + self.trust * np.log(density),
            window_m=belief.window_m,
        )
