"""Who computes the cells of a sweep: this process, processes of this machine, or a cluster.

All take the same cells in the same way: a crew has a size and takes one call at a time, as
:class:`concurrent.futures.Executor` does. Results do not depend on which crew computed them.
"""

import logging
import multiprocessing
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
)
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from typing import Any, Protocol, TypeVar

from octant.em.blocks import THREADS_VARIABLE, cores
from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.interrupts import ignored_interrupts

Result = TypeVar("Result")

ONE_THREAD = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Settings of linear algebra, read when it is first loaded."""

CONNECT_S = 5.0
"""How long a scheduler may take to answer [s]."""
FIRST_WORKER_S = 15.0
"""How long the first worker of a scheduler may take to appear [s]."""
LOCAL = "local:"
"""How an address begins that asks for a cluster on this machine."""
GIVEN_SIZE = 64
"""Cells that an executor of unknown size gets at a time [-]."""

BATCHES = 4
"""Batches that `worker_map` makes for each process."""

FORKED = sys.platform == "linux"
"""Whether workers are copies of one process that has imported what they need, and does nothing
else. Elsewhere each starts anew: the linear algebra of macOS does not bear being copied."""


class Crew(Protocol):
    """Workers that compute cells."""

    @property
    def size(self) -> int:
        """Number of cells computed at the same time."""

    def submit(self, call: Callable[..., Result], /, *arguments: object) -> "Future[Result]":
        """Return the future of a call.

        Parameters
        ----------
        call : A function of a module, which a worker can import.
        *arguments : What it takes; must be picklable.
        """

    def renew(self) -> None:
        """Replace the workers after one was killed and took the others with it."""

    def stop(self) -> None:
        """End all workers at once, whatever they compute."""


class GivenExecutor:
    """A crew made of any executor; it is neither renewed nor stopped here.

    Parameters
    ----------
    executor : Threads, processes, or what behaves like them.
    size : Cells that it gets at a time [-].
    """

    def __init__(self, executor: Executor, size: int = GIVEN_SIZE) -> None:
        self._executor = executor
        self.size = size

    def submit(self, call: Callable[..., Result], /, *arguments: object) -> "Future[Result]":
        """Return the future of a call.

        Parameters
        ----------
        call, *arguments : As in `Crew`.
        """
        return self._executor.submit(call, *arguments)

    def renew(self) -> None:
        """Do nothing: the executor belongs to the caller."""

    def stop(self) -> None:
        """Do nothing: the executor belongs to the caller."""


class LocalProcesses:
    """A crew of processes of this machine, started when they are first needed.

    Parameters
    ----------
    size : Number of processes [-].
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self._pool: ProcessPoolExecutor | None = None
        self._lifeline: Connection | None = None

    def submit(self, call: Callable[..., Result], /, *arguments: object) -> "Future[Result]":
        """Return the future of a call.

        Parameters
        ----------
        call, *arguments : As in `Crew`.
        """
        if self._pool is None:
            prepare_workers()
            context = _context()
            theirs, self._lifeline = context.Pipe(duplex=False)
            self._pool = ProcessPoolExecutor(
                self.size,
                mp_context=context,
                initializer=begin,
                initargs=(theirs, max(1, cores() // self.size), dict(os.environ)),
            )
        return self._pool.submit(call, *arguments)

    def renew(self) -> None:
        """End the processes; the next call starts new ones."""
        self.stop()

    def stop(self) -> None:
        """End the processes at once, whatever they compute."""
        if self._pool is None or self._lifeline is None:
            return
        self._lifeline.close()
        # A worker that leaves while it hands over a result leaves half of it, and whoever reads it
        # would wait for the rest as long as this process could still write it.
        results: Any = self._pool._result_queue  # noqa: SLF001  the executor has no name for it
        results._writer.close()  # noqa: SLF001
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._pool = self._lifeline = None


def prepare_workers(modules: Sequence[str] = ()) -> None:
    """Let the process that workers are copied from start, and import modules while others work.

    Once it runs, a further call does nothing.

    Parameters
    ----------
    modules : Names of what the workers will need.
    """
    if not FORKED:
        return
    from multiprocessing import forkserver

    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # it must not hold threads when it is copied
    try:
        forkserver.set_forkserver_preload(list(modules))
        with ignored_interrupts():
            forkserver.ensure_running()
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _context() -> BaseContext:
    """Return how processes are started: never as copies of this one.

    Whatever numerical libraries are at, a copy would hold their locks as they are at that moment.
    """
    return multiprocessing.get_context("forkserver" if FORKED else "spawn")


def begin(lifeline: Connection, threads: int, environment: Mapping[str, str]) -> None:
    """Make a new process a worker that ends when the process that started it ends.

    Parameters
    ----------
    lifeline : Its other end is held by the starting process alone: when that one ends, however it
        ends, or closes it, the worker leaves at once.
    threads : Threads that the worker may use.
    environment : Variables of the starting process, which may have changed since the process that
        workers are copied from was started.
    """
    os.environ.update(environment)
    for name in ONE_THREAD:
        os.environ[name] = "1"
    os.environ[THREADS_VARIABLE] = str(threads)
    # Ctrl-C reaches every process of a terminal; the starting one alone decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with, args=(lifeline,), daemon=True).start()


def _leave_with(lifeline: Connection) -> None:
    try:
        lifeline.recv_bytes()
    except (EOFError, OSError):
        os._exit(1)


@contextmanager
def open_crew(*, workers: int | None = None, cluster: str | None = None) -> Iterator[Crew | None]:
    """Yield the workers asked for, until the block ends; None: this process computes.

    Parameters
    ----------
    workers : Processes of this machine; None: one for each core; 1: none, this process computes.
    cluster : Address of a dask scheduler, or ``local:N`` for N worker processes of a cluster that
        is started here; instead of ``workers``.
    """
    if cluster is not None:
        with _cluster_crew(cluster) as crew:
            yield crew
        return
    count = cores() if workers is None else workers
    local = LocalProcesses(count) if count > 1 else None
    try:
        yield local
    finally:
        if local is not None:
            local.stop()


def begun(
    crew: Crew | None, call: Callable[..., Result], *arguments: object
) -> Callable[[], Result]:
    """Return what gives the result of a call, on which a worker may be at work meanwhile.

    Without workers, and where they were lost, it is computed here when it is asked for.

    Parameters
    ----------
    crew : Workers, or None.
    call, *arguments : As for a crew.
    """
    here = partial(call, *arguments)
    if crew is None:
        return here
    try:
        future = crew.submit(call, *arguments)
    except BrokenExecutor:
        return here

    def result() -> Result:
        try:
            return future.result()
        except (BrokenExecutor, CancelledError):
            return here()

    return result


@contextmanager
def worker_map(workers: int) -> Iterator[Callable[[Callable[[Any], Any], Sequence[Any]], Any]]:
    """Yield a `map` whose calls processes of this machine share, a batch at a time.

    Parameters
    ----------
    workers : Number of processes; 1: this process makes all calls.
    """
    with open_crew(workers=workers) as crew:
        yield map if crew is None else partial(_shared, crew)


def _shared(crew: Crew, call: Callable[[Any], Result], items: Sequence[Any]) -> Iterator[Result]:
    # A batch carries all that the function holds, such as a field model, so there are few of them.
    size = -(-len(items) // (crew.size * BATCHES))
    futures = [
        crew.submit(_batch, call, items[first : first + size])
        for first in range(0, len(items), size)
    ]
    try:
        for future in futures:
            yield from future.result()
    finally:
        for future in futures:
            future.cancel()


def _batch(call: Callable[[Any], Result], items: Sequence[Any]) -> list[Result]:
    return [call(item) for item in items]


@contextmanager
def _cluster_crew(address: str) -> Iterator[Crew]:
    try:
        import distributed
    except ImportError as exc:
        msg = (
            f"--cluster {address} needs dask, which is not installed; install Octant with its "
            "extra [cluster]: pip install 'octant[cluster]'."
        )
        raise ConfigError(msg) from exc
    # The keeper reports lost connections itself.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with _scheduler(distributed, address) as where:
        try:
            if where == address:
                _answer(address)
            client = distributed.Client(where, timeout=CONNECT_S, set_as_default=False)
        except (OSError, OverflowError) as exc:
            raise ConfigError(_unreachable(address, "does not answer")) from exc
        with client:
            try:
                client.wait_for_workers(1, timeout=FIRST_WORKER_S)
            except TimeoutError as exc:
                raise ConfigError(_unreachable(address, "has no workers")) from exc
            threads = max(1, sum(client.nthreads().values()))
            executor = client.get_executor(pure=False)
            try:
                yield GivenExecutor(executor, threads)
            finally:
                executor.shutdown(wait=False)


@contextmanager
def _scheduler(distributed: Any, address: str) -> Iterator[Any]:  # noqa: ANN401  a module
    """Yield what a client connects to: an address, or a cluster of this machine."""
    if not address.startswith(LOCAL):
        yield address
        return
    count = address.removeprefix(LOCAL)
    if not count.isdecimal() or int(count) < 1:
        msg = f"--cluster is {address!r}, but a number of workers must follow: local:2."
        raise ConfigError(msg)
    with ignored_interrupts():
        started = distributed.LocalCluster(
            n_workers=int(count),
            threads_per_worker=1,
            dashboard_address=":0",  # any free port: several clusters may run on a machine
            silence_logs=logging.CRITICAL,
            env={THREADS_VARIABLE: str(max(1, cores() // int(count)))},
        )
    with started as cluster:
        yield cluster


def _answer(address: str) -> None:
    """Raise at once when nothing answers at HOST:PORT; a client would keep trying."""
    scheme, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if scheme in {"", "tcp", "tls"}:
        if not (host and port.isdecimal()):
            msg = f"--cluster is {address!r}, but the address of a scheduler is HOST:PORT."
            raise ConfigError(msg)
        socket.create_connection((host.strip("[]"), int(port)), timeout=CONNECT_S).close()


def _unreachable(address: str, what: str) -> str:
    return (
        f"the scheduler at {address} {what}; start one with 'dask scheduler' and workers with "
        "'dask worker ADDRESS --nthreads 1', or give --workers instead."
    )
