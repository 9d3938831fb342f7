"""The table ``[sweep]``: which names it may use, its values, and a study with values put in place.

A bare name is a key of ``[reader]``: ``gap_m = [0.005, 0.02]``. A dotted name in quotes is the path
of any key that a reader's scores depend on: ``"radio.frequency_hz"``, ``"room.material"``,
``"solver.max_reflections"``; through a list of tables it means all of them, so that
``"tag.antenna"`` is the antenna of every tag. A whole table is a parameter too:
``room = [{free_space = true}, {box_m = [5, 5, 3]}]``.
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, get_args

import msgspec

from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name
from octant.reader_design.study_file.errors import path_text, struct_names, unit_of
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Range, Study, Sweep

SWEPT_TABLES = ("radio", "room", "tag", "reader", "solver", "rfid")
"""Tables of a study that decide the scores of a reader [-]."""

MOST_VALUES = 10_000
"""Greatest number of values of one parameter [-]."""
MOST_CELLS = 1_000_000
"""Greatest number of combinations of all parameters [-]."""

Tables = dict[str, Any]


@cache
def parameter_paths() -> Mapping[str, tuple[str, ...]]:
    """Return every name that a sweep may use, ``[reader]``'s bare keys first, and its path."""
    paths: dict[str, tuple[str, ...]] = {key: ("reader", key) for key in struct_names(Reader)}
    kinds = {f.encode_name: f.type for f in msgspec.structs.fields(Study)}
    for table in SWEPT_TABLES:
        for path in ((table,), *_paths_below((table,), kinds[table])):
            paths[".".join(path)] = path
    return MappingProxyType(paths)


def _paths_below(path: tuple[str, ...], kind: Any) -> Iterator[tuple[str, ...]]:  # noqa: ANN401
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        for field in msgspec.structs.fields(kind):
            below = (*path, field.encode_name)
            yield below
            yield from _paths_below(below, field.type)
        return
    for part in get_args(kind):
        yield from _paths_below(path, part)


def parameter_unit(name: str) -> str:
    """Return the unit of a swept parameter's values; empty for a number without one.

    Parameters
    ----------
    name : As ``[sweep]`` names it.
    """
    return unit_of((name,))


def parameter_key(name: str) -> str:
    """Return a parameter's key path as messages write it, for example ``sweep.gap_m``.

    Parameters
    ----------
    name : As ``[sweep]`` names it.
    """
    return path_text(("sweep", name))


def expanded(sweep: Sweep) -> dict[str, tuple[Any, ...]]:
    """Return every parameter of a sweep with the list of its values, ranges written out.

    Parameters
    ----------
    sweep : Table ``[sweep]``; values in the units of their keys ([m], [Hz], ...).
    """
    paths = parameter_paths()
    for name in sweep:
        if name not in paths:
            raise ConfigError(_unknown(name, list(paths)))
    for one, other in itertools.combinations(sweep, 2):
        length = min(len(paths[one]), len(paths[other]))
        if paths[one][:length] == paths[other][:length]:
            msg = (
                f"{parameter_key(one)} and {parameter_key(other)} change the same key "
                f"{path_text(max(paths[one], paths[other], key=len))}; sweep one of them."
            )
            raise ConfigError(msg)
    lists = {name: _values(name, given) for name, given in sweep.items()}
    cells = math.prod(len(values) for values in lists.values())
    if cells > MOST_CELLS:
        msg = (
            f"the sweep has {cells} combinations, but at most {MOST_CELLS} are allowed; sweep less."
        )
        raise ConfigError(msg)
    return lists


def _unknown(name: str, known: list[str]) -> str:
    near = nearest_name(name, known, least_likeness=0.5)
    hint = (
        f"did you mean {near!r}?"
        if near
        else "name a key of [reader], or one of radio, room, tag, reader, solver, rfid by its "
        'path, such as "radio.frequency_hz".'
    )
    return f"{parameter_key(name)} is not a parameter that can be swept; {hint}"


def _values(name: str, given: tuple[Any, ...] | Range) -> tuple[Any, ...]:
    if not isinstance(given, Range):
        if not given:
            msg = (
                f"{parameter_key(name)} is an empty list, but a swept parameter needs at least one "
                "value; name one, or leave the parameter out."
            )
            raise ConfigError(msg)
        if len(given) > MOST_VALUES:
            msg = f"{parameter_key(name)} has {len(given)} values, but at most {MOST_VALUES} are "
            msg += "allowed; name fewer."
            raise ConfigError(msg)
        return given
    if (given.count is None) == (given.step is None):
        what = "neither count nor step" if given.count is None else "both count and step"
        msg = f"{parameter_key(name)} has {what}, but a range needs exactly one of them."
        raise ConfigError(msg)
    if given.low == given.high:
        msg = f"{parameter_key(name)} goes from {given.low:g} to itself; give a list of one value."
        raise ConfigError(msg)
    span = abs(given.high - given.low)
    count = given.count
    if given.step is not None:
        count = math.floor(span / given.step * (1.0 + 1e-12) + 1e-9) + 1
        span = (count - 1) * given.step
    if count is None or count > MOST_VALUES:
        msg = f"{parameter_key(name)} has {count} values, but at most {MOST_VALUES} are allowed."
        raise ConfigError(msg)
    step = math.copysign(span / max(count - 1, 1), given.high - given.low)
    exact = given.count is not None
    numbers = [
        given.high if exact and i == count - 1 else float(f"{given.low + i * step:.12g}")
        for i in range(count)
    ]
    return tuple(int(n) if n.is_integer() else n for n in numbers)


def put(study: Study, values: Mapping[str, Any]) -> Tables:
    """Return a study as plain tables, with other values in some places and no sweep.

    Parameters
    ----------
    study : The study.
    values : Value by parameter of a sweep, or by the dotted path of any other key, in the unit of
        the key ([m], [Hz], ...).
    """
    paths = parameter_paths()
    tables: Tables = msgspec.to_builtins(msgspec.structs.replace(study, sweep={}))
    for name, value in values.items():
        path = paths.get(name) or tuple(name.split("."))
        tables = _placed(tables, path, value, done=())
    return tables


def taken(tables: Tables, name: str) -> Any:  # noqa: ANN401  any value of a study
    """Return the value that a parameter has in a study's tables, without keys that are not given.

    Parameters
    ----------
    tables : A study as plain tables.
    name : A parameter; in a list of tables the first counts.
    """
    node: Any = tables
    path = parameter_paths()[name]
    for i, key in enumerate(path):
        node = node[key]
        if isinstance(node, list | tuple) and i < len(path) - 1:
            node = node[0]
    return _given(node)


def _given(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, dict):
        return {k: _given(v) for k, v in value.items() if v is not None and v not in ((), {})}
    return [_given(v) for v in value] if isinstance(value, list | tuple) else value


def _placed(
    node: Any,  # noqa: ANN401
    path: tuple[str, ...],
    value: Any,  # noqa: ANN401
    *,
    done: tuple[str, ...],
) -> Any:  # noqa: ANN401
    if isinstance(node, list | tuple):
        if not node:
            msg = (
                f"the study has no [[{'.'.join(done)}]] to change; add one, or leave the "
                "parameter out."
            )
            raise ConfigError(msg)
        return [_placed(item, path, value, done=done) for item in node]
    table = node if isinstance(node, dict) else {}
    key, *rest = path
    if not rest:
        return {**table, key: value}
    return {**table, key: _placed(table.get(key), tuple(rest), value, done=(*done, key))}
