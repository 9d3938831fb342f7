"""Progress and messages on stderr, so that stdout carries data only."""

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO, TypeVar

Item = TypeVar("Item")


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """What tells a person how far a long run is; it holds no state of the run.

    Parameters
    ----------
    quiet : bool
        True: no bars and no messages; the default, so that a library call stays silent.
    stream : TextIO or None
        Where to write; None: the standard error of the moment.
    """

    quiet: bool = True
    stream: TextIO | None = None

    def say(self, message: str) -> None:
        """Return nothing; write one line, unless quiet.

        Parameters
        ----------
        message : str
            The line, without its end.
        """
        if not self.quiet:
            from tqdm import tqdm

            tqdm.write(message, file=self.stream or sys.stderr)

    def track(
        self, items: Iterable[Item], *, total: int | None = None, label: str = ""
    ) -> Iterator[Item]:
        """Yield the items, with a bar that shows the share done and the time left.

        Parameters
        ----------
        items : iterable
            What is worked through.
        total : int or None
            Number of items [-]; None: ``len(items)`` where it has one.
        label : str
            What the bar is called.

        Yields
        ------
        object
            Each item, in order.
        """
        from tqdm import tqdm

        bar = tqdm(
            items,
            total=total,
            desc=label or None,
            disable=self.quiet,
            file=self.stream or sys.stderr,
            dynamic_ncols=True,
            mininterval=0.5,
        )
        yield from bar

    @contextmanager
    def count(self, total: int, *, label: str) -> Iterator[Callable[[int], None]]:
        """Yield a function that is told how many of the items are done, and shows it as a bar.

        Parameters
        ----------
        total : int
            Number of items [-].
        label : str
            What the bar is called.

        Yields
        ------
        callable
            Takes the number of items done so far [-].
        """
        from tqdm import tqdm

        with tqdm(
            total=total,
            desc=label,
            disable=self.quiet,
            file=self.stream or sys.stderr,
            dynamic_ncols=True,
        ) as bar:

            def done_so_far(done: int) -> None:
                bar.update(done - bar.n)

            yield done_so_far

    def announce_compilation(self, needed: Sequence[str] | None = None) -> None:
        """Return nothing; say so when kernels that are needed have to be compiled first.

        Parameters
        ----------
        needed : sequence of str or None
            Kernel modules, for example ``em._path_kernels``; None: all.
        """
        missing = [name for name in uncompiled_kernels() if needed is None or name in needed]
        if missing:
            self.say(
                f"First run on this machine: compiling {', '.join(missing)}; this takes up to a "
                "minute or two, once."
            )


def uncompiled_kernels(root: Path | None = None) -> tuple[str, ...]:
    """Return the kernel modules of which no compiled function is cached beside their source.

    Parameters
    ----------
    root : Path or None
        Folder of the layers; None: where Octant is installed.

    Returns
    -------
    tuple of str
        Module names like ``em._path_kernels`` or ``em.fullwave._rwg_kernels`` [-]; empty when every
        kernel module has an index file of numba in its ``__pycache__``. Where numba caches
        elsewhere (NUMBA_CACHE_DIR, a read-only installation), or after an upgrade of numba or a
        change of the source, an old or absent index says nothing certain: this is a hint for
        people, no more.
    """
    layers = root or Path(__file__).resolve().parent.parent
    return tuple(
        ".".join(kernels.relative_to(layers).with_suffix("").parts)
        for layer in ("geometries", "em", "navigation")
        for kernels in sorted((layers / layer).rglob("_*_kernels.py"))
        if not any((kernels.parent / "__pycache__").glob(f"{kernels.stem}.*.nbi"))
    )
