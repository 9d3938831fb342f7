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
    """How wheels roll: shares of slip, and the encoders' resolution.

    Encoders see the rotation only. 2 % each and 2000 counts a turn are a usual indoor robot.

    Parameters
    ----------
    slip_sd, scale_sd : Standard deviations of a wheel's share of slip, anew in every period and
        constant over a run (tyres, load, floor) [-].
    tick_rad : Rotation that one count of an encoder stands for [rad]; 0 for an exact one.
    """

    slip_sd: float = 0.0
    scale_sd: float = 0.0
    tick_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("slip_sd", "1"), ("scale_sd", "1"), ("tick_rad", "rad")):
            check_positive(getattr(self, name), name=name, unit=unit, allow_zero=True)


class RollingWheels:
    """The two wheels of one run; what they truly do is for the world only.

    Parameters
    ----------
    rolling : How they roll.
    rng : Source of the slip; nothing is drawn where a deviation is zero.
    """

    def __init__(self, rolling: Rolling, rng: np.random.Generator) -> None:
        self._rolling, self._rng = rolling, rng
        scale = rng.normal(0.0, rolling.scale_sd, 2) if rolling.scale_sd > 0.0 else np.zeros(2)
        self._scale: FloatArray = 1.0 + scale
        self._turned_rad: FloatArray = np.zeros(2)

    def roll(self, rotations_rad: FloatArray) -> FloatArray:
        """Return the rotations that would make the same way without slip [rad].

        Parameters
        ----------
        rotations_rad : (2,) float64 — Right and left, in a period [rad].
        """
        share = self._scale
        if self._rolling.slip_sd > 0.0:
            share = share + self._rng.normal(0.0, self._rolling.slip_sd, 2)
        return np.asarray(rotations_rad * share)

    def count(self, rotations_rad: FloatArray) -> FloatArray:
        """Return the whole ticks that the encoders report [rad]; what is less is counted later.

        Parameters
        ----------
        rotations_rad : (2,) float64 — Right and left, since the last call [rad].
        """
        tick_rad = self._rolling.tick_rad
        before = self._turned_rad
        self._turned_rad = before + rotations_rad
        if tick_rad == 0.0:
            return rotations_rad
        return np.asarray(
            counted_rotation(self._turned_rad, tick_rad=tick_rad)
            - counted_rotation(before, tick_rad=tick_rad)
        )
