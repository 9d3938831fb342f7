"""Every number, text and list of a study file has limits, and what lies outside is one sentence."""

from functools import reduce
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import fuzz
import msgspec
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.missions.comparison_table import Comparison
from octant.reader_design.study_file.loading import study_of_tables
from octant.reader_design.study_file.quantities import limits, range_text
from octant.reader_design.study_file.schema import Study

UNLIMITED = ("free", "room")
"""Keys of text that must be the name of a score, or empty."""


def unlimited(kind, path):
    """Yield the keys below a type that may hold any number or text."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        for field in msgspec.structs.fields(kind):
            if not (kind.__name__ == "Criterion" and field.name in UNLIMITED):
                yield from unlimited(field.type, f"{path}.{field.encode_name}")
    elif kind in {int, float, str}:
        yield path
    elif get_origin(kind) is Annotated:
        inner, meta = get_args(kind)[0], get_args(kind)[1]
        if inner in {int, float}:
            bounded = meta.ge is not None and meta.le is not None
            if not bounded:
                yield path
        elif inner is not str:
            yield from unlimited(inner, path)
        elif meta.max_length is None:
            yield path
    elif get_origin(kind) in {tuple, dict, Union, UnionType}:
        for part in get_args(kind):
            yield from unlimited(part, path)
    else:
        assert kind in {bool, type(None), Any, Ellipsis} or get_origin(kind) is Literal, (
            path,
            kind,
        )


@pytest.mark.parametrize("root", [Study, Comparison])
def test_every_number_and_text_has_limits(root):
    assert sorted(set(unlimited(root, root.__name__))) == []


TABLES = fuzz.plain(fuzz.bases()[0])
NUMBERS = [
    path
    for path in fuzz.places_of({**TABLES, "sweep": {}})
    if isinstance(reduce(lambda node, key: node[key], path, TABLES), int | float)
    and not isinstance(reduce(lambda node, key: node[key], path, TABLES), bool)
    and path[-1] not in {"max_diffractions", "miller"}  # of a few values
]


def refusal(path, value):
    tables = fuzz.copy.deepcopy(TABLES)
    reduce(lambda node, key: node[key], path[:-1], tables)[path[-1]] = value
    with pytest.raises(ConfigError) as caught:
        study_of_tables(tables, source="s.toml", directory=Path.cwd())
    return str(caught.value)


def test_every_number_outside_its_range_is_refused_with_both_ends_of_it():
    assert len(NUMBERS) > 150
    for path in NUMBERS:
        for value in (1e300, -1e300, 10**30, -(10**18)):
            sentence = refusal(path, value)
            assert ", but a" in sentence, sentence
            assert " from " in sentence or "a whole number is needed" in sentence, sentence
            assert len(sentence) < 250, sentence


@pytest.mark.parametrize(
    ("path", "value", "part"),
    [
        (("name",), "x/y", "without control characters, / and \\"),
        (("name",), "nul\0", "text of 1 to 100 characters"),
        (("name",), " ", "text of 1 to 100 characters"),
        (("tag", 0, "id"), "x" * 5000, "text of 1 to 100 characters"),
        (("reader", "response"), "x" * 5000, "...xxx"),
        (("x" * 5000,), 1, "' is not a key"),
        (("optimise", "choices", "antenna"), [], "a list of at least 1"),
        (("room", "material"), "y" * 150, "yyy"),
        (
            ("mission", "membership"),
            {"input": {"": [0, 0, 1]}},
            "a name in mission.membership.input",
        ),
        (("mission", "membership"), {"input": {}}, "a table of at least 1"),
    ],
)
def test_texts_and_lists_that_say_nothing_are_refused_in_short(path, value, part):
    sentence = refusal(path, value)
    assert part in sentence
    assert len(sentence) < 1000


def test_a_range_is_written_as_people_write_it():
    from octant.reader_design.study_file.quantities import Count, Frequency, Share

    assert range_text(*limits(Frequency | None), "Hz") == "a number from 1e6 to 1e12 Hz"
    assert range_text(*limits(Share)) == "a number from 0 to 1"
    assert range_text(*limits(Count)) == "a whole number from 1 to 1000000"
