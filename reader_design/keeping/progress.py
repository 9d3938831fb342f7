"""Progress and messages on stderr, so that stdout carries data only."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import TextIO, TypeVar

Item = TypeVar("Item")


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

        with (
            tqdm(
                items,
                total=total,
                desc=label or None,
                disable=self.quiet or not self.bars,
                file=self.stream or sys.stderr,
                dynamic_ncols=True,
                mininterval=0.5,
            ) as bar,
            closing(iter(bar)) as tracked,
        ):
            yield tracked

    @contextmanager
    def count(self, total: int, *, label: str) -> Iterator[Callable[[int], None]]:
        """Yield a function that takes how many items are done, and shows it as a bar.

        Parameters
        ----------
        total, label : Number of items, and what the bar is called.
        """
        from tqdm.auto import tqdm

        with tqdm(
            total=total,
            desc=label,
            disable=self.quiet or not self.bars,
            file=self.stream or sys.stderr,
            dynamic_ncols=True,
        ) as bar:

            def done_so_far(done: int) -> None:
                bar.update(done - bar.n)

            yield done_so_far
