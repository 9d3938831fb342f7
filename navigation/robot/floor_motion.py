"""One period of a robot on a floor with obstacles: where it gets, and whether it touches."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.robot.drive import DifferentialDrive

FloatArray = npt.NDArray[np.float64]

Blocked = Callable[[FloatArray], npt.NDArray[np.bool_]]
"""Says for (m, 2) points on the floor [m] whether the robot's centre cannot stand there."""

Motion = Literal["euler", "arc"]
"""How a period moves the robot: thesis (5.1), or the exact arc."""

Contact = Literal["end", "slide"]
"""What follows when the robot touches something: the run ends, or it slides along and goes on."""

_SPACING_M = 0.01
_SLIDES_RAD = np.radians([15.0, 30.0, 45.0, 60.0, 75.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Floor:
    """Return how a robot moves on a floor.

    Parameters
    ----------
    robot : DifferentialDrive
        Wheels and axle.
    period_s : float
        Sample period T [s].
    motion : {"euler", "arc"}
        How a period moves the robot.
    contact : {"end", "slide"}
        Whether it slides along what it touches.
    blocked : callable or None
        (m, 2) points [m] -> (m,) bool: where the robot's centre cannot be.
    """

    robot: DifferentialDrive
    period_s: float
    motion: Motion = "euler"
    contact: Contact = "end"
    blocked: Blocked | None = None

    def moved(self, pose: FloatArray, rates_rad_per_s: FloatArray) -> tuple[FloatArray, bool]:
        """Return the pose one period later and whether the robot touched something.

        Parameters
        ----------
        pose : (3,) float64
            x [m], y [m], heading [rad] before.
        rates_rad_per_s : (2,) float64
            Rates of the right and the left wheel, as if they rolled without slip [rad/s].

        Returns
        -------
        pose : (3,) float64
            x [m], y [m], heading in (-π, π] [rad]. On contact the last free point of the way, from
            which a sliding robot goes on, in the direction nearest to its own that is free, by the
            part of the rest of the way that points there; it has then turned as commanded.
        contact : bool
            True when something was in the way.
        """
        step = self.robot.step_euler if self.motion == "euler" else self.robot.step_arc
        reached = step(pose, rates_rad_per_s, period_s=self.period_s)
        length_m = abs(float(self.robot.twist(rates_rad_per_s)[0])) * self.period_s
        touches = False
        if self.blocked is not None and length_m > 0.0:
            parts = int(np.ceil(length_m / _SPACING_M))
            times_s = self.period_s * np.arange(1, parts + 1) / parts
            way = np.array([step(pose, rates_rad_per_s, period_s=float(t)) for t in times_s])
            hits = np.flatnonzero(self.blocked(way[:, :2]))
            if hits.size:
                touches = True
                stopped = np.array(way[hits[0] - 1] if hits[0] > 0 else pose)
                reached = self._slid(stopped, reached) if self.contact == "slide" else stopped
        reached[2] = wrap_angle(reached[2])
        return reached, touches

    def _slid(self, stopped: FloatArray, wanted: FloatArray) -> FloatArray:
        rest = wanted[:2] - stopped[:2]
        for turn in np.stack([_SLIDES_RAD, -_SLIDES_RAD], axis=1).ravel():
            cosine, sine = np.cos(turn), np.sin(turn)
            along = cosine * np.array(
                [cosine * rest[0] - sine * rest[1], sine * rest[0] + cosine * rest[1]]
            )
            parts = max(1, int(np.ceil(np.hypot(*along) / _SPACING_M)))
            shares = np.arange(1, parts + 1) / parts
            if (
                self.blocked is not None
                and not self.blocked(stopped[:2] + shares[:, None] * along).any()
            ):
                return np.array([*(stopped[:2] + along), wanted[2]])
        return np.array([*stopped[:2], wanted[2]])
