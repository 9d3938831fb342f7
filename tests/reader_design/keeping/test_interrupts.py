"""Ctrl-C in the moments in which Python swallows exceptions."""

import signal
import sys
import weakref

import pytest
from kept_points import Place, Point

from octant.reader_design.keeping.keeper import RecordCodec, map_cases

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals differ")


class _Thing:
    pass


def interrupted_in_a_callback(_place, case):
    """Return a case; while the second is computed, Ctrl-C comes in a weak reference's callback."""
    if case == 1:
        thing = _Thing()
        reference = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))
        del thing
        assert reference() is None
    return Point(x=float(case), values=Place().table)


def test_an_interrupt_that_python_swallows_ends_the_run_with_the_next_case(tmp_path, monkeypatch):
    swallowed = []
    monkeypatch.setattr(sys, "unraisablehook", lambda one: swallowed.append(one.exc_type))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            map_cases(
                interrupted_in_a_callback,
                range(5),
                context=Place(),
                folder=tmp_path,
                codec=RecordCodec(Point),
            )
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert swallowed == [KeyboardInterrupt]
    assert len(list(tmp_path.glob("[!.]*"))) == 2
