"""How a worker process begins and ends; imports nothing that reads the settings made here."""

import os
import signal
import threading
from multiprocessing.connection import Connection

ONE_THREAD = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Settings of linear algebra, read when it is first loaded."""

THREADS_VARIABLE = "OCTANT_THREADS"
"""As in :mod:`octant.em.blocks`, which must not be imported before the settings are made."""


def begin(lifeline: Connection, threads: int) -> None:
    """Return nothing; make a new process a worker that ends with the one that started it.

    Parameters
    ----------
    lifeline : Connection
        Its other end is held by the starting process alone: when that one ends, however it ends,
        or closes it, the worker leaves at once.
    threads : int
        Threads that the worker may use.
    """
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
