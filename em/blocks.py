"""Work on all cores with the same bits at any number of threads: blocks of receivers, and BLAS."""

import contextlib
import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

BLOCK_SIZE = 256
"""Receivers per block [-]: enough to hide the call, few enough to share out evenly."""

THREADS_VARIABLE = "OCTANT_THREADS"
"""Environment variable of the number of threads of a process; else one for each processor."""

MOST_SHARE = 0.7
"""Greatest share of the machine's memory that a computation may ask for [-]."""

_FAILED = -1

Progress = Callable[[int, int], None]
"""Called with (receivers done, receivers in all) after every block."""


def cores() -> int:
    """Return the number of processors that this process may use, at least 1."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def memory_bytes() -> float:
    """Return the memory of the machine [B]; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return math.inf


def free_memory_bytes() -> float:
    """Return how much memory this process can still get without others being moved to disk [B]."""
    most = memory_bytes()
    with contextlib.suppress(ImportError):  # there is none on Windows
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        most = most if limit == resource.RLIM_INFINITY else min(most, float(limit))
    with contextlib.suppress(OSError, StopIteration), Path("/proc/meminfo").open() as file:
        line = next(line for line in file if line.startswith("MemAvailable:"))
        return min(most, 1024.0 * float(line.split()[1]))
    return most


def run_blocks(
    work: Callable[[int, int], None],
    count: int,
    *,
    block_size: int = BLOCK_SIZE,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Call ``work(begin, end)`` for every block of ``count`` rows; return when all are done.

    Parameters
    ----------
    work : Fills rows begin to end of its own arrays, each by itself, so that block size and threads
        change no bit; must release the interpreter lock to gain from threads.
    count : Number of rows.
    block_size : Rows per call.
    executor : Runs the blocks, sharing memory; None: ``$OCTANT_THREADS`` or all cores.
    progress : Called after every block.
    """
    if count <= block_size and executor is None:
        work(0, count)
        if progress is not None:
            progress(count, count)
        return
    threads = int(os.environ.get(THREADS_VARIABLE) or cores())
    begins = iter(range(0, count, block_size))
    done: SimpleQueue[int] = SimpleQueue()

    def serve() -> None:
        try:
            while (begin := next(begins, count)) < count:
                end = min(begin + block_size, count)
                work(begin, end)
                done.put(end - begin)
        except BaseException:
            done.put(_FAILED)
            raise

    done_rows = 0
    with contextlib.ExitStack() as stack:
        pool = executor or stack.enter_context(ThreadPoolExecutor(threads))
        stack.callback(lambda: list(begins))  # after an error none is begun
        # Blocks are asked for, not handed out: a call to the pool for each would cost as much as a
        # small block does.
        futures = [pool.submit(serve) for _ in range(threads)]
        while done_rows < count:
            rows = done.get()
            if rows == _FAILED:
                list(begins)
                for future in futures:
                    future.result()
            done_rows += rows
            if progress is not None:
                progress(done_rows, count)


@contextlib.contextmanager
def one_blas_thread() -> Iterator[None]:
    """Return a context, or a decorator, in which linear algebra uses one thread.

    Products and factors of matrices depend on the number of threads in their last bits; what is
    kept or compared must not depend on who computed it.
    """
    with _blas_libraries().limit(limits=1, user_api="blas"):
        yield


@lru_cache(maxsize=1)  # the loaded libraries are listed by the system, which takes milliseconds
def _blas_libraries() -> "ThreadpoolController":
    import scipy.linalg  # noqa: F401  its BLAS must be loaded to be limited
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
