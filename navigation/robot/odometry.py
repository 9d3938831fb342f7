"""Odometric localisation: the pose from wheel-encoder increments or from velocities."""

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive

FloatArray = npt.NDArray[np.float64]

Integration = Literal["euler", "rk2", "exact"]
"""Euler (11.83), second-order Runge-Kutta (11.84), or the exact arc (11.85) of the textbook."""


def move(
    pose: npt.ArrayLike,
    *,
    distance_m: npt.ArrayLike,
    turn_rad: npt.ArrayLike,
    method: Integration = "exact",
) -> FloatArray:
    """Return the pose after one sample interval [m, rad], the heading not wrapped.

    Parameters
    ----------
    pose : (..., 3) float64
        x [m], y [m], heading [rad] at its start.
    distance_m : (...) float64
        Length Δs = v T of the way, negative backwards [m].
    turn_rad : (...) float64
        Turn Δθ = ω T, counter-clockwise positive [rad].
    method : {"euler", "rk2", "exact"}
        Straight along the old heading, along the mean heading, or on the circular arc.

    Notes
    -----
    Textbook (11.83)-(11.86). The exact arc is written as its chord Δs sinc(Δθ/2) along θ + Δθ/2,
    the same as (11.85) without its division by ω. Exact for constant v and ω only.
    """
    start = np.asarray(pose, dtype=np.float64)
    length = np.asarray(distance_m, dtype=np.float64)
    turn = np.asarray(turn_rad, dtype=np.float64)
    if method not in get_args(Integration):
        msg = f"method is {method!r}, but it must be one of {list(get_args(Integration))}."
        raise NavigationError(msg)
    if method == "exact":
        length = length * np.sinc(turn / (2.0 * np.pi))
    along = start[..., 2] + (0.0 if method == "euler" else 0.5) * turn
    moves = np.broadcast_arrays(length * np.cos(along), length * np.sin(along), turn)
    moved: FloatArray = start + np.stack(moves, axis=-1)
    return moved


def wheel_travel(
    increments_rad: npt.ArrayLike, robot: DifferentialDrive
) -> tuple[FloatArray, FloatArray]:
    """Return the way and the turn that the wheels' rotations make.

    Parameters
    ----------
    increments_rad : (..., 2) float64
        Rotations of the right and the left wheel in the interval [rad].
    robot : DifferentialDrive
        Its wheel radius and axle length.

    Returns
    -------
    distance_m : (...) float64
        Δs = r (Δφ_R + Δφ_L) / 2 [m].
    turn_rad : (...) float64
        Δθ = r (Δφ_R - Δφ_L) / d [rad].

    Notes
    -----
    The two formulae below textbook (11.86); true while the wheels roll without slip.
    """
    travel = robot.twist(increments_rad)
    return travel[..., 0], travel[..., 1]


def counted_rotation(turned_rad: npt.ArrayLike, *, tick_rad: float) -> FloatArray:
    """Return the whole counts of an incremental encoder since it was zeroed [rad].

    Parameters
    ----------
    turned_rad : (...) float64
        How far it has turned [rad].
    tick_rad : float
        Rotation that one count stands for [rad].
    """
    if not (np.isfinite(tick_rad) and tick_rad > 0.0):
        msg = f"tick_rad is {tick_rad} rad, but it must be positive and finite: give one count."
        raise NavigationError(msg)
    counted: FloatArray = tick_rad * np.floor(np.asarray(turned_rad) / tick_rad)
    return counted
