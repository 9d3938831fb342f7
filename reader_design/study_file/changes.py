"""Proposed changes of a study: as lines to paste into its file, and as a study that has them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from octant.reader_design.study_file.loading import study_of_tables
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.toml import key_text, value_text

LARGE = 1e6
"""Least number that is written with an exponent [-]."""

Step = str | int | None
"""A key, the place of a table in a list of tables, or all of them (None)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """One key of a study with another value.

    Attributes
    ----------
    path : Keys from the root; in a list of tables the table's place, None for every one.
    value : Plain value in the unit of the key ([m], [Hz], ...).
    of : Which table of a list is meant, in words.
    why : What the key does, in a few words.
    """

    path: tuple[Step, ...]
    value: Any
    of: str = ""
    why: str = ""

    @property
    def header(self) -> str:
        """The header of the table that the key belongs to, as in a study file."""
        names = [key_text(step) for step in self.path[:-1] if isinstance(step, str)]
        in_list = not isinstance(self.path[-2], str)
        name = f"[[{'.'.join(names)}]]" if in_list else f"[{'.'.join(names)}]"
        return f"{name}  # {self.of}" if self.of and in_list else name

    @property
    def line(self) -> str:
        """The key with its value as a line of TOML."""
        key = str(self.path[-1])
        comment = f"  # {self.why}" if self.why else ""
        return f"{key_text(key)} = {_short(self.value)}{comment}"


def _short(value: Any) -> str:  # noqa: ANN401
    """Return a value as TOML, large numbers as people write them, such as 2.402e9."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_short, value))}]"
    if isinstance(value, float) and value >= LARGE:
        digits, exponent = f"{value:.6e}".split("e")
        return f"{digits.rstrip('0').rstrip('.')}e{int(exponent)}"
    return value_text(value)


def changed(study: Study, changes: Sequence[Change]) -> Study:
    """Return a study with changes made, checked and resolved anew.

    Parameters
    ----------
    study : The study; its files are named by absolute paths.
    changes : What to change.
    """
    tables = msgspec.to_builtins(study)
    for change in changes:
        tables = _set(tables, change.path, change.value)
        if change.path[-1] == "antenna":  # which then hangs as usual
            tables = _set(tables, (*change.path[:-1], "axis"), None)
    return study_of_tables(tables, source="the changed study", directory=Path("/"))


def _set(node: Any, path: tuple[Step, ...], value: Any) -> Any:  # noqa: ANN401  any tree of values
    if not path:
        return value
    step, *rest = path
    if isinstance(step, str):
        table = node if isinstance(node, dict) else {}
        return {**table, step: _set(table.get(step), tuple(rest), value)}
    items = list(node or ())
    return [
        _set(item, tuple(rest), value) if step is None or step == i else item
        for i, item in enumerate(items)
    ]
