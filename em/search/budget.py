"""What a search may find: counted while it grows, and refused in words before memory runs out."""

import math
from collections.abc import Callable, Sequence, Sized
from concurrent.futures import Executor
from statistics import fmean, stdev
from threading import Lock
from typing import TypeVar

from octant.em.blocks import Progress, free_memory_bytes, run_blocks
from octant.geometries.errors import GeometryError

Part = TypeVar("Part", bound=tuple[Sized, ...])

FREE_SHARE = 0.7
"""Share [-] of the free memory that a search may take."""

SAMPLE, SAMPLED_SHARE = 64, 64
"""Rows [-] looked at before a search starts, and how many times as many [-] it must have."""


class Budget:
    """Counts what the blocks of a search find, and ends it with an error above a bound.

    Parameters
    ----------
    what : What is counted, in words that follow a number.
    most : Number [-] at which the search ends, where memory does not end it before.
    each_bytes : Memory [B] that each takes while the search goes on.
    advice : What to do instead.
    """

    def __init__(self, what: str, *, most: int, each_bytes: float, advice: str) -> None:
        self._what, self._advice, self._each_bytes = what, advice, each_bytes
        self._free_bytes = free_memory_bytes()
        self._most = min(most, int(FREE_SHARE * self._free_bytes / each_bytes))
        self._count, self._lock = 0, Lock()

    def add(self, count: int) -> None:
        """Count further finds; 0 asks whether a block needs to start at all.

        Parameters
        ----------
        count : How many [-].
        """
        with self._lock:
            self._count += count
            reached = self._count
        if reached > self._most:
            msg = (
                f"the search has reached {reached} {self._what}, "
                f"{reached * self._each_bytes / 1e9:.2g} GB; at most {self._most} fit "
                f"({self._free_bytes / 1e9:.2g} GB are free): {self._advice}."
            )
            raise GeometryError(msg)

    def foresee(self, counts: Sequence[int], rows: int) -> None:
        """Refuse work of which a sample of rows says, beyond doubt, that it would not fit.

        Its mean less three times its standard error is taken for all rows.

        Parameters
        ----------
        counts : What single rows of the sample have found [-].
        rows : Rows in all [-].
        """
        mean = fmean(counts)
        least = rows * (mean - 3.0 * stdev(counts, mean) / math.sqrt(len(counts)))
        if least > self._most:
            msg = (
                f"the search would reach about {rows * mean:.2g} {self._what}, "
                f"{rows * mean * self._each_bytes / 1e9:.2g} GB; at most {self._most} fit "
                f"({self._free_bytes / 1e9:.2g} GB are free): {self._advice}."
            )
            raise GeometryError(msg)


def gather_blocks(
    work: Callable[[int, int], Part],
    count: int,
    budget: Budget,
    *,
    block_size: int,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> list[Part]:
    """Return what all blocks of a search find, in order, as long as it stays within its budget.

    Where there are very many rows, some of them are looked at first: what cannot fit is refused
    before it starts.

    Parameters
    ----------
    work : Returns arrays of what it finds for rows begin to end; the first array's rows count.
    count : Number of rows.
    budget : Ends the search above its bound.
    block_size, executor, progress : As in `octant.em.blocks.run_blocks`.
    """
    found: dict[int, Part] = {}
    if count >= SAMPLED_SHARE * SAMPLE:
        rows = [i * count // SAMPLE for i in range(SAMPLE)]
        budget.foresee([len(work(row, row + 1)[0]) for row in rows], count)

    def one(begin: int, end: int) -> None:
        budget.add(0)
        part = work(begin, end)
        budget.add(len(part[0]))
        found[begin] = part

    run_blocks(one, count, block_size=block_size, executor=executor, progress=progress)
    return [found[begin] for begin in sorted(found)]
