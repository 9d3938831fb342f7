"""Many seeded runs of one job, in this process or shared by several, the same to the bit."""

from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TypeVar

import numpy as np

from octant.geometries.errors import NavigationError

Result = TypeVar("Result")
Job = Callable[[np.random.SeedSequence], Result]
"""Makes one run from its seed; more than one worker needs it picklable."""

_BATCHES_PER_WORKER = 4


def run_seeded(
    job: Job[Result],
    *,
    runs: int,
    seed: int,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Callable[[int], object] | None = None,
) -> tuple[Result, ...]:
    """Return the results of many runs of one job, in order, each with its own random numbers.

    Parameters
    ----------
    job : callable
        Seed of one run -> its result.
    runs : int
        Number of runs.
    seed : int
        Base seed, not negative. Run i uses child i of its numpy SeedSequence, so its result
        depends neither on the number of runs nor on that of workers.
    workers : int
        Processes that share the runs; 1 stays in this one.
    executor : concurrent.futures.Executor or None
        Runs the batches in place of `workers` own processes; `workers` then only sizes them.
    progress : callable or None
        Called in this process with the number of finished runs, whenever some have finished.

    Returns
    -------
    tuple
        Run 0 first. Arrays that came from another process are writable again.

    Raises
    ------
    NavigationError
        When the number of runs or workers is below 1 or the seed is negative.
    KeyboardInterrupt
        Passed on after the batches that have not begun are cancelled.
    """
    if runs < 1 or workers < 1 or seed < 0:
        msg = (
            f"runs is {runs}, workers is {workers} and seed is {seed}, but runs and workers must "
            "be 1 or more and the seed 0 or more: correct the one that is not."
        )
        raise NavigationError(msg)
    seeds = np.random.SeedSequence(seed).spawn(runs)
    if executor is None and workers == 1:
        results = []
        for one in seeds:
            results.append(job(one))
            if progress is not None:
                progress(len(results))
        return tuple(results)
    if executor is not None:
        return _run_batches(job, seeds, workers=workers, executor=executor, progress=progress)
    # Not forked: the radio model's threads would not survive in a forked child.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        return _run_batches(job, seeds, workers=workers, executor=pool, progress=progress)


def _run_batch(job: Job[Result], seeds: list[np.random.SeedSequence]) -> list[Result]:
    return [job(seed) for seed in seeds]


def _run_batches(
    job: Job[Result],
    seeds: list[np.random.SeedSequence],
    *,
    workers: int,
    executor: Executor,
    progress: Callable[[int], object] | None,
) -> tuple[Result, ...]:
    # A batch carries the field model with it, so there are few of them.
    size = -(-len(seeds) // (workers * _BATCHES_PER_WORKER))
    starts = range(0, len(seeds), size)
    futures = [executor.submit(_run_batch, job, seeds[start : start + size]) for start in starts]
    finished = 0
    try:
        for future in as_completed(futures):
            finished += len(future.result())
            if progress is not None:
                progress(finished)
    except BaseException:
        for future in futures:
            future.cancel()
        raise
    return tuple(result for future in futures for result in future.result())
