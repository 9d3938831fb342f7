"""Progress and messages on stderr, so that stdout carries data only."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from threading import Event, Thread
from typing import Any, TextIO, TypeVar

Item = TypeVar("Item")

FIRST_SHOWN_S = 1.0
"""Time [s] after which something that cannot be counted is shown."""
TICK_S, PIPE_TICK_S = 1.0, 10.0
"""Time [s] between two of its pictures in a terminal, and in a file or a pipe."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Shows a person how far a long run is; it holds no state of the run.

    Parameters
    ----------
    quiet : True: no bars and no messages; the default, so that a library call stays silent.
    stream : Where to write; None: the standard error of the moment.
    bars : False: messages only.
    """

    quiet: bool = True
    stream: TextIO | None = None
    bars: bool = True

    def say(self, message: str) -> None:
        """Write one line, unless quiet.

        Parameters
        ----------
        message : The line, without its end.
        """
        if not self.quiet:
            from tqdm.auto import tqdm

            tqdm.write(message, file=self.stream or sys.stderr)

    @contextmanager
    def track(
        self, items: Iterable[Item], *, total: int | None = None, label: str = ""
    ) -> Iterator[Iterator[Item]]:
        """Yield an iterator over the items, with a bar of the share done and the time left.

        The bar ends with the block, so that after Ctrl-C nothing is drawn below the last message.

        Parameters
        ----------
        items : What is worked through.
        total : Number of items; None: ``len(items)`` where it has one.
        label : What the bar is called.
        """
        from tqdm.auto import tqdm

        file = self.stream or sys.stderr
        with (
            tqdm(
                items,
                total=total,
                desc=label or None,
                disable=self.quiet or not self.bars,
                file=file,
                dynamic_ncols=True,
                mininterval=0.5,
            ) as bar,
            _beating(bar, bar.refresh, every_s=TICK_S if file.isatty() else None),
            closing(iter(bar)) as tracked,
        ):
            yield tracked

    @contextmanager
    def during(self, label: str, *, expected_s: float | None = None) -> Iterator[None]:
        """Show for how long something lasts that cannot be counted, after its first second.

        Parameters
        ----------
        label : What it is.
        expected_s : Time that it is expected to take [s]; None: only the time so far is shown.
        """
        from tqdm.auto import tqdm

        file = self.stream or sys.stderr
        shape = "{desc}: {percentage:3.0f}%|{bar}| {elapsed} of about " + _seconds(expected_s)
        with tqdm(
            total=expected_s,
            desc=label,
            disable=self.quiet or not self.bars,
            file=file,
            dynamic_ncols=True,
            delay=FIRST_SHOWN_S,
            bar_format=shape if expected_s else "{desc}: {elapsed}",
        ) as bar:
            began = time.monotonic()

            def tick() -> None:
                spent_s = time.monotonic() - began
                if expected_s:
                    bar.n = min(spent_s, 0.99 * expected_s)
                if spent_s >= FIRST_SHOWN_S:
                    bar.refresh()

            with _beating(bar, tick, every_s=TICK_S if file.isatty() else PIPE_TICK_S):
                yield
            bar.n = expected_s or bar.n

    @contextmanager
    def count(self, total: int, *, label: str) -> Iterator[Callable[[int], None]]:
        """Yield a function that takes how many items are done, and shows it as a bar.

        Parameters
        ----------
        total, label : Number of items, and what the bar is called.
        """
        from tqdm.auto import tqdm

        file = self.stream or sys.stderr
        with tqdm(
            total=total,
            desc=label,
            disable=self.quiet or not self.bars,
            file=file,
            dynamic_ncols=True,
        ) as bar:

            def done_so_far(done: int) -> None:
                bar.update(done - bar.n)

            with _beating(bar, bar.refresh, every_s=TICK_S if file.isatty() else None):
                yield done_so_far


def _seconds(duration_s: float | None) -> str:
    return "" if duration_s is None else f"{max(1.0, duration_s):.0f} s"


@contextmanager
def _beating(bar: Any, tick: Callable[[], object], *, every_s: float | None) -> Iterator[None]:  # noqa: ANN401  tqdm carries no types
    """Draw a bar again and again while the block runs, since nothing else does between two items.

    Parameters
    ----------
    bar, tick : The bar, and what draws it.
    every_s : Time between two pictures [s]; None: never.
    """
    if bar.disable or every_s is None:
        yield
        return
    ended = Event()

    def watch() -> None:
        while not ended.wait(every_s):
            tick()

    watcher = Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()
