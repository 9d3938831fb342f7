"""Calls that workers compute meanwhile have results whatever becomes of the workers."""

import threading
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor

import pytest

from octant.reader_design.keeping.workers import GivenExecutor, begun


class Lost(GivenExecutor):
    """A crew whose workers die, when they are asked or at work."""

    def __init__(self, *, asked):
        super().__init__(None)
        self.asked = asked

    def submit(self, call, /, *arguments):
        del call, arguments
        if self.asked:
            raise BrokenExecutor
        future = Future()
        future.set_exception(BrokenExecutor())
        return future


def thread_and_double(number):
    return threading.get_ident(), 2 * number


def test_a_call_is_computed_by_the_workers_from_when_it_is_begun():
    with ThreadPoolExecutor(1) as pool:
        ident, value = begun(GivenExecutor(pool), thread_and_double, 21)()
    assert value == 42
    assert ident != threading.get_ident()


@pytest.mark.parametrize("crew", [None, Lost(asked=True), Lost(asked=False)])
def test_without_workers_or_with_lost_ones_it_is_computed_here(crew):
    assert begun(crew, thread_and_double, 21)() == (threading.get_ident(), 42)


def test_an_error_of_the_call_is_raised_where_its_result_is_asked_for():
    with ThreadPoolExecutor(1) as pool:
        result = begun(GivenExecutor(pool), int, "x")
        with pytest.raises(ValueError, match="invalid literal"):
            result()
