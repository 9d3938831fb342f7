"""Wheels on a real floor: they slip, their encoders count whole ticks, and odometry adds up."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.robot.drive import DifferentialDrive

FloatArray = npt.NDArray[np.float64]


def wheel_travel(
    increments_rad: npt.ArrayLike, robot: DifferentialDrive
) -> tuple[FloatArray, FloatArray]:
    """Return way Δs = r (Δφ_R + Δφ_L)/2 [m] and turn Δθ = r (Δφ_R - Δφ_L)/d [rad] of the wheels.

    Below textbook (11.86); true while the wheels roll without slip.

    Parameters
    ----------
    increments_rad : (..., 2) float64 — Rotations, right and left, in the interval [rad].
    robot : Its wheel radius and axle length.
    """
    travel = robot.twist(increments_rad)
    return travel[..., 0], travel[..., 1]


def counted_rotation(turned_rad: npt.ArrayLike, *, tick_rad: float) -> FloatArray:
    """Return the whole counts of an incremental encoder since it was zeroed [rad].

    Parameters
    ----------
    turned_rad : (...) float64 — How far it has turned [rad].
    tick_rad : Rotation that one count stands for [rad].
    """
    if not (np.isfinite(tick_rad) and tick_rad > 0.0):
        msg = f"tick_rad is {tick_rad} rad, but it must be positive and finite: give one count."
        raise NavigationError(msg)
    counted: FloatArray = tick_rad * np.floor(np.asarray(turned_rad) / tick_rad)
    return counted


@dataclass(frozen=True, slots=True, kw_only=True)
class Rolling:
    """How wheels turn and roll: their motors, slip, and the encoders' resolution.

    Encoders see the rotation only. 2 % each and 2000 counts a turn are a usual indoor robot. Where
    this says wheels, a synchro drive has its rolling and its steering.

    Parameters
    ----------
    slip_sd, scale_sd : Standard deviations of a wheel's share of slip, anew in every period and
        constant over a run (tyres, load, floor) [-].
    tick_rad : Rotation that one count of an encoder stands for [rad]; 0 for an exact one.
    acceleration_rad_per_s2 : Greatest acceleration of a wheel [rad/s²]; None: at once.
    dead_band_rad_per_s : Slower commands do not turn a wheel [rad/s].
    linear_m_per_s, angular_rad_per_s : What is added to speed [m/s] and turn rate [rad/s] of a
        robot that moves: the slips b and s of the docking paper.
    """

    slip_sd: float = 0.0
    scale_sd: float = 0.0
    tick_rad: float = 0.0
    acceleration_rad_per_s2: float | None = None
    dead_band_rad_per_s: float = 0.0
    linear_m_per_s: float = 0.0
    angular_rad_per_s: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (
            ("slip_sd", "1"),
            ("scale_sd", "1"),
            ("tick_rad", "rad"),
            ("dead_band_rad_per_s", "rad/s"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit, allow_zero=True)
        if self.acceleration_rad_per_s2 is not None:
            check_positive(
                self.acceleration_rad_per_s2, name="acceleration_rad_per_s2", unit="rad/s²"
            )
        if not np.isfinite([self.linear_m_per_s, self.angular_rad_per_s]).all():
            msg = (
                f"the slips are {self.linear_m_per_s} m/s and {self.angular_rad_per_s} rad/s, but "
                "both must be finite: give numbers."
            )
            raise NavigationError(msg)


class RollingWheels:
    """The wheels of one run, or of many in step; what they truly do is for the world only.

    Parameters
    ----------
    rolling : How they turn and roll.
    robot : Its kinematics.
    rngs : Source of each run's slip; nothing is drawn where a deviation is zero.
    """

    def __init__(
        self, rolling: Rolling, robot: DifferentialDrive, *rngs: np.random.Generator
    ) -> None:
        self._rolling, self._robot, self._rngs = rolling, robot, rngs
        self._scale: FloatArray = 1.0 + self._shares(rolling.scale_sd)
        self._turned_rad: FloatArray = np.zeros(self._scale.shape)
        self._rates: FloatArray = np.zeros(self._scale.shape)

    def _shares(self, deviation: float) -> FloatArray:
        if deviation == 0.0:
            drawn = np.zeros((len(self._rngs), 2))
        else:
            drawn = np.array([rng.normal(0.0, deviation, 2) for rng in self._rngs])
        return drawn[0] if len(drawn) == 1 else drawn

    def turn(self, rates_rad_per_s: FloatArray, *, period_s: float) -> FloatArray:
        """Return the mean rates with which the motors turn the wheels in a period [rad/s].

        Parameters
        ----------
        rates_rad_per_s : (..., 2) float64 — Command, right and left, within the limits [rad/s].
        period_s : Length of the period [s].
        """
        mean, self._rates = self._robot.follow(
            self._rates,
            rates_rad_per_s,
            period_s=period_s,
            acceleration_rad_per_s2=self._rolling.acceleration_rad_per_s2,
            dead_band_rad_per_s=self._rolling.dead_band_rad_per_s,
        )
        return mean

    def roll(self, rotations_rad: FloatArray, *, period_s: float) -> FloatArray:
        """Return the rotations that would make the same way without slip [rad].

        Parameters
        ----------
        rotations_rad : (..., 2) float64 — Right and left, in a period [rad].
        period_s : Its length [s].
        """
        rolling, robot = self._rolling, self._robot
        share = self._scale
        if rolling.slip_sd > 0.0:
            share = share + self._shares(rolling.slip_sd)
        rolled = robot.of_shafts(robot.shafts(rotations_rad) * share)
        if rolling.linear_m_per_s != 0.0 or rolling.angular_rad_per_s != 0.0:
            slip = period_s * robot.wheel_rates(
                speed_m_per_s=rolling.linear_m_per_s, turn_rate_rad_per_s=rolling.angular_rad_per_s
            )
            rolled = rolled + np.any(rotations_rad != 0.0, axis=-1, keepdims=True) * slip
        return rolled

    def turned(self, rolled_rad: FloatArray, *, period_s: float) -> FloatArray:
        """Return the rotations of wheels that have made a way: the inverse of `roll` [rad].

        Parameters
        ----------
        rolled_rad : (..., 2) float64 — The way, as rotations without slip, right and left [rad].
        period_s : Its length in time [s].
        """
        rolling, robot = self._rolling, self._robot
        share = self._scale
        if rolling.slip_sd > 0.0:
            share = share + self._shares(rolling.slip_sd)
        slip = period_s * robot.wheel_rates(
            speed_m_per_s=rolling.linear_m_per_s, turn_rate_rad_per_s=rolling.angular_rad_per_s
        )
        way = rolled_rad - np.any(rolled_rad != 0.0, axis=-1, keepdims=True) * slip
        return robot.of_shafts(robot.shafts(way) / share)

    def count(self, rotations_rad: FloatArray) -> FloatArray:
        """Return the whole ticks that the encoders report [rad]; what is less is counted later.

        Parameters
        ----------
        rotations_rad : (..., 2) float64 — Right and left, since the last call [rad].
        """
        tick_rad = self._rolling.tick_rad
        before = self._turned_rad
        self._turned_rad = before + self._robot.shafts(rotations_rad)
        if tick_rad == 0.0:
            return rotations_rad
        counted = counted_rotation(self._turned_rad, tick_rad=tick_rad) - counted_rotation(
            before, tick_rad=tick_rad
        )
        return self._robot.of_shafts(counted)
