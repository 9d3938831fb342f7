"""What the compiler of the kernels does: said to the person who waits, and counted for warm-up.

Kernels are compiled when they are first called and kept on disk: beside the package, or in the
user's cache folder where the package's cannot be written, or in NUMBA_CACHE_DIR.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

FIRST_USE = (
    "First use on this machine: compiling kernels, once; this takes up to a minute or two in all "
    "('octant warm-up' does it ahead of time)."
)

NO_PLACE_FOR_KERNELS = "cannot cache function"
"""How numba's own message begins when compiled kernels can be kept nowhere."""

HOW_TO_GIVE_A_PLACE = (
    "compiled kernels can be kept neither beside the installed package nor in the user's cache "
    "folder, because neither can be written; set the environment variable NUMBA_CACHE_DIR to a "
    "folder that can."
)


@dataclass(slots=True, kw_only=True)
class CompilationRecord:
    """What was compiled during a block of code; it fills while the block runs.

    Parameters
    ----------
    kernels, folders : Names of the functions that were compiled, and where they are kept.
    seconds : Time that took [s].
    """

    kernels: list[str] = field(default_factory=list)
    folders: set[Path] = field(default_factory=set)
    seconds: float = 0.0


@contextmanager
def recorded_compilation(
    on_first: Callable[[], None] | None = None,
) -> Iterator[CompilationRecord]:
    """Yield a record of the kernels that are compiled meanwhile, in any thread of this process.

    Parameters
    ----------
    on_first : Called before the first kernel is compiled, if any is.
    """
    from numba.core import event

    record = CompilationRecord()
    starts: list[float] = []  # kernels that compile the kernels they call are nested

    class Listener(event.Listener):  # type: ignore[misc]  # numba carries no types
        def on_start(self, _event: event.Event) -> None:
            if on_first is not None and not starts and not record.kernels:
                on_first()
            starts.append(time.perf_counter())

        def on_end(self, ended: event.Event) -> None:
            began = starts.pop()
            if not starts:
                record.seconds += time.perf_counter() - began
            kernel = ended.data["dispatcher"]
            if kernel.stats.cache_path is not None:  # else a helper of numba's own, kept within
                record.kernels.append(kernel.py_func.__name__)
                record.folders.add(Path(kernel.stats.cache_path))

    with event.install_listener("numba:compile", Listener()):
        yield record
