"""Where the runs of a campaign start: at given poses in turn, or anywhere on free floor."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]

_DRAWS = 1000
_STREAM = 1_000_003


class Starts(Protocol):
    """Gives each run its start, by the run's seed alone."""

    def start(self, seed: np.random.SeedSequence) -> FloatArray:
        """Return the start of a run: x [m], y [m], heading [rad].

        Parameters
        ----------
        seed : The run's seed: a child of the campaign's.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedStarts:
    """Starts that the runs take in turn.

    Parameters
    ----------
    poses : (k, 3) float64 — x [m], y [m], heading [rad].
    """

    poses: FloatArray

    def __post_init__(self) -> None:
        poses = frozen_array(self.poses, name="poses", shape=(None, 3), error=NavigationError)
        if not len(poses):
            msg = "the list of starts is empty: give at least one pose."
            raise NavigationError(msg)
        object.__setattr__(self, "poses", poses)

    def start(self, seed: np.random.SeedSequence) -> FloatArray:
        """Return the start of a run."""
        return np.asarray(self.poses[seed.spawn_key[-1] % len(self.poses)])


@dataclass(frozen=True, slots=True, kw_only=True)
class RandomStarts:
    """Starts anywhere on the free floor of a rectangle.

    Parameters
    ----------
    low_m, high_m : (2,) float64 — Corners of the rectangle [m].
    fits : (m, 2) points [m] -> (m,) bool: where the robot can stand.
    headings_rad : Between which headings [rad]; by default any.
    """

    low_m: FloatArray
    high_m: FloatArray
    fits: Callable[[FloatArray], npt.NDArray[np.bool_]]
    headings_rad: tuple[float, float] = (-np.pi, np.pi)

    def __post_init__(self) -> None:
        for name in ("low_m", "high_m"):
            corner = frozen_array(getattr(self, name), name=name, shape=(2,), error=NavigationError)
            object.__setattr__(self, name, corner)
        if not (self.low_m < self.high_m).all():
            msg = (
                f"the starts lie between {self.low_m.tolist()} and {self.high_m.tolist()} m, but "
                "the first corner must be the lower one: exchange them."
            )
            raise NavigationError(msg)

    def start(self, seed: np.random.SeedSequence) -> FloatArray:
        """Return the start of a run."""
        own = np.random.SeedSequence(seed.entropy, spawn_key=(*seed.spawn_key, _STREAM))
        return self.draw(np.random.default_rng(own))

    def draw(self, rng: np.random.Generator) -> FloatArray:
        """Return a random start: x [m], y [m], heading [rad].

        Parameters
        ----------
        rng : Source of the start.
        """
        for _ in range(_DRAWS):
            point = rng.uniform(self.low_m, self.high_m)
            if bool(self.fits(point[None])[0]):
                return np.array([*point, rng.uniform(*self.headings_rad)])
        msg = (
            f"the robot found no room between {self.low_m.tolist()} and {self.high_m.tolist()} m "
            f"in {_DRAWS} draws: widen the area of the starts."
        )
        raise NavigationError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Carried:
    """Somebody carries the robot elsewhere on its mission, unnoticed by its wheels.

    Parameters
    ----------
    at_s : When [s].
    to : Where it may be put down.
    """

    at_s: float
    to: RandomStarts
