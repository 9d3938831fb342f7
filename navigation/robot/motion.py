"""How a robot moves for a moment: forward and turning at constant speeds, along an arc."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError


def pose_on_arc(
    pose: npt.ArrayLike,
    time_s: npt.ArrayLike,
    *,
    speed_m_per_s: npt.ArrayLike,
    turn_rate_rad_per_s: npt.ArrayLike,
) -> npt.NDArray[np.float64]:
    """Return the pose some time later, or earlier, on an arc [m, rad], the heading not wrapped.

    Parameters
    ----------
    pose : (..., 3) float64
        x [m], y [m], heading [rad].
    time_s : (...) float64
        How much later [s]; negative for earlier.
    speed_m_per_s : (...) float64
        Forward speed [m/s].
    turn_rate_rad_per_s : (...) float64
        Turn rate, counter-clockwise positive [rad/s].

    Notes
    -----
    The exact solution of thesis (3.7): a chord of length v t sinc(ω t / 2) along θ + ω t / 2.
    """
    start = np.asarray(pose, dtype=np.float64)
    turn = np.asarray(time_s) * np.asarray(turn_rate_rad_per_s)
    chord = np.asarray(time_s) * np.asarray(speed_m_per_s) * np.sinc(turn / (2.0 * np.pi))
    along = start[..., 2] + 0.5 * turn
    moves = np.broadcast_arrays(chord * np.cos(along), chord * np.sin(along), turn)
    moved: npt.NDArray[np.float64] = start + np.stack(moves, axis=-1)
    return moved


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """How the robot drives while the reader works through its antennas.

    Parameters
    ----------
    speed_m_per_s : float
        Forward speed [m/s].
    turn_rate_rad_per_s : float
        Turn rate, counter-clockwise positive [rad/s].
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
        pose : (3,) float64
            x [m], y [m], heading [rad] at time zero.
        time_s : (k,) float64
            Times [s].
        """
        return pose_on_arc(
            np.asarray(pose, dtype=np.float64),
            time_s,
            speed_m_per_s=self.speed_m_per_s,
            turn_rate_rad_per_s=self.turn_rate_rad_per_s,
        )


AT_REST = Motion()
"""A robot that stands still while it reads."""
