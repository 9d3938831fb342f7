"""The interface of pose estimators, and the wheel motion that all of them predict with.

Every array has the runs of a Monte-Carlo set as its first axis: one call serves them all, and what
it returns for a run depends on nothing but that run.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import Integration, move
from octant.navigation.robot.odometry import wheel_travel

FloatArray = npt.NDArray[np.float64]
Belief = TypeVar("Belief")


class RssModel(Protocol):
    """What an estimator knows of the RSS, or what the world really sends."""

    def rss_dbm(self, places_m: FloatArray) -> FloatArray:
        """Return the RSS of all tags at places of the robot, (m, s) [dBm].

        Parameters
        ----------
        places_m : (m, 2) float64 — x, y [m].
        """


class SmoothRssModel(RssModel, Protocol):
    """An RSS model with slopes, as the extended Kalman filters need it."""

    def slopes_db_per_m(self, places_m: FloatArray) -> FloatArray:
        """Return the derivatives of the RSS along x and y, (m, s, 2) [dB/m].

        Parameters
        ----------
        places_m : (m, 2) float64 — x, y [m].
        """


class PoseEstimator(Protocol[Belief]):
    """What turns wheel rates and RSS into poses."""

    def begin(
        self, poses: FloatArray, covariance: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> Belief:
        """Return what is believed at the start.

        Parameters
        ----------
        poses : (r, 3) float64 — Assumed x [m], y [m], heading [rad] of every run.
        covariance : (3, 3) float64 — How uncertain they are [m², rad²].
        rngs : One for each run.
        """

    def step(
        self,
        belief: Belief,
        wheel_rates: FloatArray,
        rss_dbm: FloatArray | None,
        rngs: Sequence[np.random.Generator],
    ) -> Belief:
        """Return what is believed one period later.

        Parameters
        ----------
        belief : What `begin` or `step` returned; it must not be changed.
        wheel_rates : (r, 2) float64 — Right and left, commanded or counted by encoders [rad/s].
        rss_dbm : (r, s) float64 or None — What was read at its end [dBm], NaN of tags that were not
            heard; None when nothing was read.
        rngs : One for each run.
        """

    def poses(self, belief: Belief) -> FloatArray:
        """Return the estimated poses, (r, 3) [m, rad].

        Parameters
        ----------
        belief : What `begin` or `step` returned.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelMotion:
    """The motion model: odometry with noise on the wheel rates.

    Parameters
    ----------
    robot : Wheels and axle.
    period_s : Sample period T [s].
    rate_sigma_rad_per_s : Standard deviation of each wheel's rate in a period [rad/s].
    method : {"euler", "rk2", "exact"} — How a period is integrated.
    """

    robot: DifferentialDrive
    period_s: float
    rate_sigma_rad_per_s: float
    method: Integration = "exact"

    def __post_init__(self) -> None:
        for name, unit in (("period_s", "s"), ("rate_sigma_rad_per_s", "rad/s")):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                msg = (
                    f"{name} is {value} {unit}, but a filter needs a positive, finite one (its "
                    "covariance must not be zero): raise it."
                )
                raise NavigationError(msg)

    def moved(self, poses: FloatArray, wheel_rates: FloatArray) -> FloatArray:
        """Return the poses one period later, (..., 3) [m, rad].

        Parameters
        ----------
        poses : (..., 3) float64 — x [m], y [m], heading [rad].
        wheel_rates : (..., 2) float64 — Right and left [rad/s].
        """
        distance, turn = wheel_travel(self.period_s * np.asarray(wheel_rates), self.robot)
        return move(poses, distance_m=distance, turn_rad=turn, method=self.method)

    def jacobians(
        self, poses: FloatArray, wheel_rates: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives of `moved` by pose, (r, 3, 3), and by wheel rates, (r, 3, 2).

        Those of the second-order Runge-Kutta step, whatever the method: they differ from the arc's
        by the square of the turn. The thesis prints cos in the second row of L; it is sin.

        Parameters
        ----------
        poses, wheel_rates : As for `moved` [m, rad], [rad/s].
        """
        distance, turn = wheel_travel(self.period_s * np.asarray(wheel_rates), self.robot)
        along = poses[:, 2] + 0.5 * turn
        cos, sin = np.cos(along), np.sin(along)
        half = 0.5 * self.robot.wheel_radius_m * self.period_s
        spin = self.robot.wheel_radius_m * self.period_s / self.robot.axle_length_m
        by_pose = np.tile(np.eye(3), (len(poses), 1, 1))
        by_pose[:, 0, 2], by_pose[:, 1, 2] = -distance * sin, distance * cos
        by_rates = np.empty((len(poses), 3, 2))
        for wheel, sign in ((0, 1.0), (1, -1.0)):
            by_rates[:, 0, wheel] = half * cos - sign * 0.5 * spin * distance * sin
            by_rates[:, 1, wheel] = half * sin + sign * 0.5 * spin * distance * cos
            by_rates[:, 2, wheel] = sign * spin
        return by_pose, by_rates


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadReckoning:
    """The estimator that only adds up the wheels' motion: others are compared with it.

    Parameters
    ----------
    motion : How the wheels move the robot.
    """

    motion: WheelMotion

    def begin(
        self, poses: FloatArray, covariance: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> FloatArray:
        """Return the assumed poses, (r, 3) [m, rad]."""
        del covariance, rngs
        return poses

    def step(
        self,
        belief: FloatArray,
        wheel_rates: FloatArray,
        rss_dbm: FloatArray | None,
        rngs: Sequence[np.random.Generator],
    ) -> FloatArray:
        """Return the poses one period later, (r, 3) [m, rad]."""
        del rss_dbm, rngs
        return self.motion.moved(belief, wheel_rates)

    def poses(self, belief: FloatArray) -> FloatArray:
        """Return the belief itself, (r, 3) [m, rad]."""
        return belief
