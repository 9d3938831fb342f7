"""Cases that tests of the keeper compute, in a module that worker processes can import."""

import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from octant.geometries.errors import GeometryError


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """What all cases share."""

    seed: int = 7
    size: int = 200
    name: str = "anything"
    wait_s: float = 0.0
    log: str = ""
    table: np.ndarray = field(default_factory=lambda: np.arange(3.0))
    derived: int = field(init=False, default=0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """What a case computes."""

    x: float
    values: np.ndarray
    words: tuple[str, ...] = ()


def compute(place, case):
    """Return numbers whose last bits depend on the threads of the linear algebra."""
    if case < 0:
        raise GeometryError(f"{case} cannot be built.")
    if place.log:
        with Path(place.log).open("a") as log:
            log.write(f"{case}\n")
    if case == 666 and Path(place.log).with_suffix(".bad").exists():
        raise MemoryError("too little")
    time.sleep(place.wait_s)
    random = np.random.default_rng([place.seed, case])
    matrix = random.standard_normal((place.size, place.size))
    values = np.linalg.solve(matrix, matrix @ matrix[:, 0])
    return Point(x=float(case), values=np.append(values, np.nan), words=("µ", "b"))
