"""What the compiler of the kernels does: said to the person who waits, and counted for warm-up.

Kernels are compiled when they are first called and kept on disk: beside the package, or in the
user's cache folder where the package's cannot be written, or in NUMBA_CACHE_DIR.
"""

import json
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

FIRST_USE = (
    "First use on this machine: compiling kernels, once; this takes up to a minute or two in all "
    "('octant warm-up' does it ahead of time)."
)

LIST = Path(__file__).with_name("kernels.json")
"""What each verb needs; `tools/list_kernels.py` writes it."""

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


@contextmanager
def counted_kernels(
    verb: str, count: Callable[[int], AbstractContextManager[Callable[[int], None]]]
) -> Iterator[Callable[[], None]]:
    """Yield a function that starts to show how many of a verb's kernels are ready.

    Those that are looked up before it is called count too; the one at work does not.

    Parameters
    ----------
    verb : Name of the verb; one that the list does not have shows nothing.
    count : Shows a number that is counted up to the given one, while its block lasts.
    """
    from octant.geometries.kernel_list import looked_up

    asked: set[object] = set()
    shown: list[Callable[[int], None]] = []
    listed: list[str] = []

    def seen(function: object, kinds: tuple[object, ...]) -> None:
        asked.add((function, kinds))
        for show in shown:
            show(min(len(asked) - 1, len(listed)))

    with ExitStack() as stack:
        stack.enter_context(looked_up(seen))

        def start() -> None:
            listed.extend(json.loads(LIST.read_text(encoding="utf-8"))["verbs"].get(verb, ()))
            if listed:
                shown.append(stack.enter_context(count(len(listed))))

        yield start


@contextmanager
def compiled_ahead(verb: str, enough_cores: Callable[[], bool]) -> Iterator[Callable[[], None]]:
    """Yield a function that starts a second process, which compiles what a verb needs last.

    It works until the block ends; then it is gone, like any worker, whatever it is at. The kernels
    that it compiles are kept on disk, where this process finds them; neither begins a kernel that
    the other one is at.

    Parameters
    ----------
    verb : Name of the verb; one that the list does not have needs nothing ahead.
    enough_cores : Whether a second process has a core of its own.
    """
    from octant.reader_design.keeping.workers import LocalProcesses

    crew = LocalProcesses(1)

    def start() -> None:
        if enough_cores() and verb in json.loads(LIST.read_text(encoding="utf-8"))["verbs"]:
            with suppress(BrokenExecutor, OSError):
                crew.submit(compile_last_first, verb)

    try:
        yield start
    finally:
        crew.stop()


def compile_last_first(verb: str) -> int:
    """Compile what a verb needs, from the end of its list on; return how many kernels [-].

    Parameters
    ----------
    verb : Its name in the list.
    """
    from octant.geometries.kernel_list import compile_listed

    listed = json.loads(LIST.read_text(encoding="utf-8"))
    return compile_listed(listed, reversed(listed["verbs"][verb]))
