"""Of many cases of one test the first run by default, the rest with the slow tests."""

from collections.abc import Iterable

import pytest


def slow_after(count: int, cases: Iterable) -> list:
    """Return the cases of a parametrization of one name, those after the first `count` slow."""
    return [
        case if i < count else pytest.param(case, marks=pytest.mark.slow)
        for i, case in enumerate(cases)
    ]
