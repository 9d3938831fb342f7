"""Ctrl-C: who ignores it, and how none is lost."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def ignored_interrupts() -> Iterator[None]:
    """Let processes started in the block ignore Ctrl-C: only this process reacts to it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def swallowed_interrupts() -> Iterator[Callable[[], None]]:
    """Yield what raises a Ctrl-C of the block once more, if Python has swallowed its exception.

    It does so where the exception rises in the callback of a weak reference, of which futures and
    locks have many: one of 75 interrupts of a study was lost.
    """
    came: list[int] = []

    def noted(number: int, frame: FrameType | None) -> None:
        came.append(number)
        signal.default_int_handler(number, frame)

    def raise_swallowed() -> None:
        if came:
            raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    here = threading.current_thread() is threading.main_thread()
    if not here or before is not signal.default_int_handler:
        yield raise_swallowed
        return
    signal.signal(signal.SIGINT, noted)
    try:
        yield raise_swallowed
    finally:
        signal.signal(signal.SIGINT, before)
