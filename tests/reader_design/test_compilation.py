"""The bar of first use: how many of a verb's kernels are ready."""

import json
from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from octant.geometries.kept_code import KeptCode
from octant.reader_design import compilation


@pytest.fixture
def listed(monkeypatch, tmp_path):
    """A verb of three kernels, and nothing on disk."""
    (tmp_path / "kernels.json").write_text(json.dumps({"verbs": {"draw": ["a", "b", "c"]}}))
    monkeypatch.setattr(compilation, "LIST", tmp_path / "kernels.json")
    monkeypatch.setattr(KeptCode, "load_overload", lambda _keeper, _sig, _context: None)


def look_up(name, *kinds):
    KeptCode.load_overload(SimpleNamespace(function=name), kinds, None)


@pytest.mark.usefixtures("listed")
def test_kernels_that_are_ready_are_counted_up_to_those_of_the_verb():
    shown, totals = [], []

    @contextmanager
    def count(total):
        totals.append(total)
        yield shown.append
        shown.append("end")

    before = KeptCode.load_overload
    with compilation.counted_kernels("draw", count) as start:
        look_up("a", "int64")
        assert not totals
        start()
        for name in ("b", "b", "c", "d", "e"):
            look_up(name, "int64")
    assert totals == [3]
    assert shown == [1, 1, 2, 3, 3, "end"]
    assert KeptCode.load_overload is before


@pytest.mark.usefixtures("listed")
def test_a_verb_that_the_list_does_not_have_shows_nothing():
    with compilation.counted_kernels("sing", lambda _: pytest.fail("a bar")) as start:
        start()
        look_up("a", "int64")
