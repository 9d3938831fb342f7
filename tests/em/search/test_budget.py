import numpy as np
import pytest

from octant.em.search.budget import Budget, gather_blocks
from octant.geometries.errors import GeometryError

ROWS = 10_000


def _searched(most, find):
    """Return the rows that were looked at, and what was found, with a bound."""
    looked = []

    def work(begin, end):
        looked.append((begin, end))
        return (np.repeat(np.arange(begin, end), [find(row) for row in range(begin, end)]),)

    budget = Budget("finds", most=most, each_bytes=8.0, advice="ask for less")
    try:
        found = gather_blocks(work, ROWS, budget, block_size=500)
    except GeometryError as refused:
        return looked, str(refused)
    return looked, np.concatenate([part[0] for part in found])


def test_what_cannot_fit_is_refused_before_the_search_starts():
    looked, words = _searched(1_000, lambda row: 9 + row % 2)
    assert len(looked) == 64
    assert all(end - begin == 1 for begin, end in looked)
    assert "would reach about 9.5e+04 finds" in words
    assert "ask for less" in words


@pytest.mark.parametrize("find", [lambda row: 9 + row % 2, lambda row: 5_000 * (row % 1_250 == 0)])
def test_what_may_fit_is_searched_whole(find):
    """Also where few rows find nearly all, and a sample of them far too much."""
    looked, found = _searched(100_000, find)
    assert np.array_equal(found, np.repeat(np.arange(ROWS), [find(row) for row in range(ROWS)]))
    assert sum(end - begin for begin, end in looked) == ROWS + 64
