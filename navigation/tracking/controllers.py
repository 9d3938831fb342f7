"""Tracking controllers behind one interface: open loop, neighbouring, predictive, RSS feedback."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.tracking import _ilqr_kernels
from octant.navigation.tracking.problem import Weights
from octant.navigation.tracking.trajectories import DesiredTrajectory

FloatArray = npt.NDArray[np.float64]


class TrackingController(Protocol):
    """What decides the wheel rates of the next period, for all runs of a set at once."""

    def wheel_rates(self, step: int, poses: FloatArray, rss_dbm: FloatArray) -> FloatArray:
        """Return the wanted rates of the right and the left wheel, (r, 2), not cut [rad/s].

        The call changes nothing, and what it returns for a run depends on nothing but that run.

        Parameters
        ----------
        step : Number k of the period, which begins at k T.
        poses : (r, 3) float64 — Estimated x [m], y [m], heading [rad] then, not wrapped.
        rss_dbm : (r, s) float64 — What was read last [dBm]; NaN: out of range then.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenLoop:
    """A controller that plays wheel rates and looks at nothing.

    Parameters
    ----------
    rates : (k, 2) float64 — Right and left in every period [rad/s].
    """

    rates: FloatArray

    def __post_init__(self) -> None:
        rates = frozen_array(self.rates, name="rates", shape=(None, 2), error=NavigationError)
        object.__setattr__(self, "rates", rates)

    def wheel_rates(self, step: int, poses: FloatArray, rss_dbm: FloatArray) -> FloatArray:
        """Return the rates of a period, (r, 2) [rad/s]."""
        del rss_dbm
        return np.tile(self.rates[step], (len(poses), 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class NeighbouringControl:
    """Thesis (7.34): the nominal inputs less C times the deviation from the nominal pose.

    Parameters
    ----------
    nominal_poses : (k, 3) float64 — x [m], y [m], heading [rad] at the beginning of every period.
    nominal_rates : (k, 2) float64 — Right and left [rad/s].
    gains : (k, 2, 3) float64 — C [rad/s per m, rad/s per rad].
    """

    nominal_poses: FloatArray
    nominal_rates: FloatArray
    gains: FloatArray

    def __post_init__(self) -> None:
        steps = len(self.gains)
        for name, shape in (
            ("nominal_poses", (steps, 3)),
            ("nominal_rates", (steps, 2)),
            ("gains", (steps, 2, 3)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)

    def wheel_rates(self, step: int, poses: FloatArray, rss_dbm: FloatArray) -> FloatArray:
        """Return the rates of a period, (r, 2) [rad/s]."""
        del rss_dbm
        deviation = poses - self.nominal_poses[step]
        deviation[:, 2] = wrap_angle(deviation[:, 2])
        # Not one matrix product: its rounding would depend on the number of runs.
        correction = np.sum(self.gains[step] * deviation[:, None, :], axis=-1)
        rates: FloatArray = self.nominal_rates[step] - correction
        return rates


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasurementFeedback:
    """Thesis (6.3): the wheel rates are a varying matrix times the RSS of all tags.

    Parameters
    ----------
    gains : (k, 2, s) float64 — K of every period [rad/s per dBm].
    """

    gains: FloatArray

    def __post_init__(self) -> None:
        gains = frozen_array(self.gains, name="gains", shape=(None, 2, None), error=NavigationError)
        object.__setattr__(self, "gains", gains)

    def wheel_rates(self, step: int, poses: FloatArray, rss_dbm: FloatArray) -> FloatArray:
        """Return the rates of a period, (r, 2) [rad/s]."""
        del poses
        heard = np.where(np.isnan(rss_dbm), 0.0, rss_dbm)
        rates: FloatArray = np.sum(self.gains[step] * heard[:, None, :], axis=-1)
        return rates


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictiveControl:
    """Model predictive control: bounded iLQR over a horizon, anew in every period.

    Parameters
    ----------
    desired : What to follow, sampled at the control period; beyond its end the last pose is held.
    robot : The robot and its limits.
    weights : Q, R (on the deviation from the feed-forward) and the final weight of each horizon.
    horizon : Periods looked ahead.
    iterations : iLQR iterations in each period.
    """

    desired: DesiredTrajectory
    robot: DifferentialDrive
    weights: Weights
    horizon: int = 20
    iterations: int = 5

    def __post_init__(self) -> None:
        if self.horizon < 1 or self.iterations < 1:
            msg = (
                f"horizon is {self.horizon} and iterations {self.iterations}, but both must be at "
                "least 1: raise them."
            )
            raise NavigationError(msg)

    def wheel_rates(self, step: int, poses: FloatArray, rss_dbm: FloatArray) -> FloatArray:
        """Return the first rates of the best plan from each estimated pose, (r, 2) [rad/s]."""
        del rss_dbm
        ahead = np.minimum(np.arange(step, step + self.horizon + 1), self.desired.steps)
        reference = self.desired.poses[ahead]
        starts = np.array(poses)
        starts[:, 2] = reference[0, 2] + wrap_angle(starts[:, 2] - reference[0, 2])
        wanted = self.desired.wheel_rates(self.robot)[ahead[:-1]]
        wanted[ahead[1:] == ahead[:-1]] = 0.0
        rates = np.empty((len(poses), 2))
        _ilqr_kernels.plan_first_rates(
            wanted,
            starts,
            reference,
            self.weights.state,
            self.weights.final,
            self.weights.inputs,
            self.desired.period_s,
            self.robot.wheel_radius_m,
            self.robot.axle_length_m,
            self.robot.max_wheel_rate_rad_per_s,
            self.iterations,
            rates,
        )
        return rates
