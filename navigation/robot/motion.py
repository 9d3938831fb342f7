"""How a robot moves for a moment: forward and turning at constant speeds, along an arc."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError

Integration = Literal["euler", "rk2", "exact"]
"""Euler (11.83), second-order Runge-Kutta (11.84), or the exact arc (11.85) of the textbook."""


def move(
    pose: npt.ArrayLike,
    *,
    distance_m: npt.ArrayLike,
    turn_rad: npt.ArrayLike,
    method: Integration = "exact",
) -> npt.NDArray[np.float64]:
    """Return the pose after one sample interval [m, rad], the heading not wrapped.

    Textbook (11.83)-(11.86); the arc is its chord Δs sinc(Δθ/2) along θ + Δθ/2, as (11.85) without
    its division by ω. Exact for constant v and ω only.

    Parameters
    ----------
    pose : (..., 3) float64 — x [m], y [m], heading [rad] at its start.
    distance_m : (...) float64 — Length Δs = v T of the way, negative backwards [m].
    turn_rad : (...) float64 — Turn Δθ = ω T, counter-clockwise positive [rad].
    method : {"euler", "rk2", "exact"} — Along the old heading, along the mean one, or on the arc.
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
    moved: npt.NDArray[np.float64] = start + np.stack(moves, axis=-1)
    return moved


def pose_on_arc(
    pose: npt.ArrayLike,
    time_s: npt.ArrayLike,
    *,
    speed_m_per_s: npt.ArrayLike,
    turn_rate_rad_per_s: npt.ArrayLike,
) -> npt.NDArray[np.float64]:
    """Return the pose some time later, or earlier, on an arc [m, rad], the heading not wrapped.

    The exact solution of thesis (3.7): a chord of length v t sinc(ω t / 2) along θ + ω t / 2.

    Parameters
    ----------
    pose : (..., 3) float64 — x [m], y [m], heading [rad].
    time_s : (...) float64 — How much later [s]; negative for earlier.
    speed_m_per_s, turn_rate_rad_per_s : (...) float64 — Forward, counter-clockwise [m/s], [rad/s].
    """
    time = np.asarray(time_s)
    return move(
        pose,
        distance_m=time * np.asarray(speed_m_per_s),
        turn_rad=time * np.asarray(turn_rate_rad_per_s),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """How the robot drives while the reader works through its antennas.

    Parameters
    ----------
    speed_m_per_s, turn_rate_rad_per_s : Forward speed [m/s]; turn rate, counter-clockwise [rad/s].
    """

    speed_m_per_s: float = 0.0
    turn_rate_rad_per_s: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite([self.speed_m_per_s, self.turn_rate_rad_per_s]).all():
            msg = (
                f"the robot is said to drive {self.speed_m_per_s} m/s and turn "
                f"{self.turn_rate_rad_per_s} rad/s, but both must be finite: give its real speeds."
            )
            raise NavigationError(msg)

    @property
    def rests(self) -> bool:
        """Whether the robot stands still."""
        return self.speed_m_per_s == 0.0 and self.turn_rate_rad_per_s == 0.0

    def poses(self, pose: npt.ArrayLike, time_s: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the poses (k, 3) before (negative times) and after a pose [m, rad], not wrapped.

        Parameters
        ----------
        pose : (3,) float64 — x [m], y [m], heading [rad] at time zero.
        time_s : (k,) float64 — Times [s].
        """
        return pose_on_arc(
            np.asarray(pose, dtype=np.float64),
            time_s,
            speed_m_per_s=self.speed_m_per_s,
            turn_rate_rad_per_s=self.turn_rate_rad_per_s,
        )


AT_REST = Motion()
"""A robot that stands still while it reads."""
