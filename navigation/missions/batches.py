"""Many seeded runs of one job, in this process or shared by others, the same to the bit."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np

from octant.geometries.errors import NavigationError

Result = TypeVar("Result")
Job = Callable[[np.random.SeedSequence], Result]
"""Makes one run from its seed; picklable where other processes run it."""


class Mapper(Protocol):
    """What applies a function to many arguments, as `map` or the method of an executor does."""

    def __call__(self, call: Callable[[Any], Any], items: Sequence[Any], /) -> Iterable[Any]:
        """Return the results of a call for each item, in the order of the items."""


def run_seeded(
    job: Job[Result],
    *,
    runs: int,
    seed: int,
    mapper: Mapper = map,
    progress: Callable[[int], object] | None = None,
) -> tuple[Result, ...]:
    """Return the results of many runs of one job, run 0 first, each with own random numbers.

    Parameters
    ----------
    job : Seed of one run -> its result.
    runs : Number of runs.
    seed : Base seed, not negative; run i uses child i of its numpy SeedSequence and nothing else.
    mapper : Runs them: `map` in this process. Arrays that come from another process are writable.
    progress : Called with the number of finished runs, whenever one has finished.
    """
    if runs < 1 or seed < 0:
        msg = (
            f"runs is {runs} and seed is {seed}, but runs must be 1 or more and the seed 0 or "
            "more: correct the one that is not."
        )
        raise NavigationError(msg)
    results: list[Result] = []
    for result in mapper(job, np.random.SeedSequence(seed).spawn(runs)):
        results.append(result)
        if progress is not None:
            progress(len(results))
    return tuple(results)
