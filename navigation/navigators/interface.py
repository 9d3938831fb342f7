"""What every navigator is: readings and odometry in, wheel rates and a verdict out.

A navigator knows the order of its tags, its pose at the start and its reader, but not where the
tags are; at most how they hang (height, antenna, orientation).
"""

from dataclasses import dataclass
from typing import Generic, Literal, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]

Mode = Literal["rotation", "navigation", "search", "evade", "stopped"]
"""What the robot does in a period: turn to the tag, drive to it, look for it, back off, stand."""

Memory = TypeVar("Memory")
"""What a navigator remembers between readings; frozen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Odometry:
    """What the robot measured of its own motion since the previous reading.

    Parameters
    ----------
    distance_m : Way by the wheels' encoders, negative backwards [m].
    turn_rad : Turn by the same, counter-clockwise positive [rad].
    contact : The bumper touched something.

    Examples
    --------
    >>> import octant
    >>> octant.Odometry(distance_m=0.09).turn_rad
    0.0
    """

    distance_m: float = 0.0
    turn_rad: float = 0.0
    contact: bool = False


STILL = Odometry()
"""No motion since the previous reading."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision(Generic[Memory]):
    """What a navigator makes of one reading.

    Parameters
    ----------
    rates : (2,) float64 — Right and left wheel in the coming period, within the limits [rad/s].
    memory : What it remembers from now on.
    reached : The tag is declared reached; the rates are zero then.
    mode : {"rotation", "navigation", "search", "evade", "stopped"} — What it does in that period.
    place_m : (2,) float64 or None — Where it believes the tag, ahead and to the left [m].
    pose : (3,) float64 or None — Where it believes itself in the room, x, y [m], heading [rad];
        None: it counts its wheels and no more.
    """

    rates: FloatArray
    memory: Memory
    reached: bool
    mode: Mode
    place_m: FloatArray | None = None
    pose: FloatArray | None = None

    def __post_init__(self) -> None:
        for name, size in (("rates", 2), ("place_m", 2), ("pose", 3)):
            value = getattr(self, name)
            if value is not None:
                array = frozen_array(value, name=name, shape=(size,), error=NavigationError)
                object.__setattr__(self, name, array)


class Navigator(Protocol[Memory]):
    """Decides period by period; itself without a state, so that runs can share it."""

    def begin(self, target: int, before: Memory | None, *, heading_rad: float) -> Memory:
        """Return what is remembered for the first reading of a leg.

        Parameters
        ----------
        target : Index of the tag to be reached, in the mission's order.
        before : What was remembered at the end of the leg before, or None.
        heading_rad : Heading at the mission's start, which the robot knows [rad].
        """
        ...

    def decide(
        self,
        memory: Memory,
        rss_w: FloatArray,
        odometry: Odometry,
        rng: np.random.Generator,
    ) -> Decision[Memory]:
        """Return the command for the coming period, or that the tag is reached.

        Parameters
        ----------
        memory : What was remembered after the previous reading.
        rss_w : (n,) float64 — One reading of the current tag; zero where nothing was received [W].
        odometry : Motion since the previous reading.
        rng : Source of whatever the navigator draws.
        """
        ...
