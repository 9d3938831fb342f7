"""Write ``docs/reference/study_file.md``: every key, its unit, default, range and meaning.

``python tools/list_keys.py`` writes it anew from the classes in ``reader_design/study_file``;
``--check`` only says whether it is up to date (exit code 1 if not).
"""

import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import click
import msgspec

from octant.reader_design.study_file.errors import unit_of
from octant.reader_design.study_file.quantities import limits, range_text
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.tables_read import READ_BY, SHARE_A_STUDY

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "study_file.md"
HEAD = """# Every key of a study file

Written by `python tools/list_keys.py` from the classes in `reader_design/study_file`. A value
outside its range is refused with a sentence that names both ends. The ranges are wide: they keep
out what no model here means, not what is rare. Where the default is `-` the key is left out: the
meaning says what holds then. A dash for the unit: a number without one, a name, or a table.
"""


def described(table: type) -> dict[str, str]:
    """Return the meaning of each key of a table, from its docstring."""
    text = inspect.getdoc(table) or ""
    parts = re.split(
        r"^([a-z_]\w*(?:, [a-z_]\w*)*) : ", text.split("----------\n", 1)[-1], flags=re.MULTILINE
    )
    meanings = {}
    for names, meaning in zip(parts[1::2], parts[2::2], strict=True):
        line = " ".join(meaning.split("\n\n")[0].split("— ", 1)[-1].split())
        meanings |= dict.fromkeys(names.split(", "), line.replace("``", "`").replace("|", "\\|"))
    return meanings


def allowed(kind: Any, unit: str) -> str:  # noqa: PLR0911  one for each kind of type
    """Return what a key may hold, in words."""
    if (found := limits(kind)) is not None and get_origin(kind) is Annotated:
        return range_text(*found, unit)
    if get_origin(kind) in {Union, UnionType}:
        words = [allowed(part, unit) for part in get_args(kind) if part is not type(None)]
        return " or ".join(dict.fromkeys(words))
    if get_origin(kind) is Annotated:
        inner, meta = get_args(kind)[:2]
        ends = (meta.min_length or 0, meta.max_length)
        return allowed(inner, unit).replace("a list of", f"a list of {ends[0]} to {ends[1]}:", 1)
    if get_origin(kind) is Literal:
        return ", ".join(f"`{value}`" for value in get_args(kind))
    if get_origin(kind) is tuple:
        parts = [allowed(part, unit) for part in get_args(kind) if part is not ...]
        return f"a list of {', '.join(dict.fromkeys(parts))}"
    if get_origin(kind) is dict:
        return f"a table by name of {allowed(get_args(kind)[1], unit)}"
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return f"the table `{kind.__name__}`"
    return {bool: "true or false", str: "text"}.get(kind, "any value")


def tables_of(kind: Any) -> Iterator[type[msgspec.Struct]]:
    """Yield the tables that a type holds, the outer ones first."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        yield kind
        for field in msgspec.structs.fields(kind):
            yield from tables_of(field.type)
    for part in get_args(kind):
        yield from tables_of(part)


def default_text(field: msgspec.structs.FieldInfo) -> str:
    """Return the default of a key as a study file writes it."""
    if field.required:
        return "must be given"
    value = msgspec.to_builtins(field.default) if field.default is not msgspec.NODEFAULT else ()
    if value is None or value in ((), {}) or isinstance(value, dict):
        return "-"
    if isinstance(value, tuple):
        return "-" if isinstance(value[0], dict) else f"`{msgspec.json.encode(value).decode()}`"
    return f"`{msgspec.json.encode(value).decode()}`"


def page() -> str:
    """Return the text of the page."""
    lines = [HEAD, *experiments()]
    for table in dict.fromkeys(tables_of(Study)):
        meanings = described(table)
        lines += [
            f"## {table.__name__}",
            "",
            (inspect.getdoc(table) or "").split("\n", 1)[0].replace("``", "`"),
            "",
        ]
        lines += ["| key | unit | default | allowed | meaning |", "|---|---|---|---|---|"]
        for field in msgspec.structs.fields(table):
            unit = unit_of((field.encode_name,))
            words = allowed(field.type, unit)
            meaning = meanings.get(field.name) or inherited(table, field.name)
            cells = (f"`{field.encode_name}`", unit or "–", default_text(field), words, meaning)
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def experiments() -> list[str]:
    """Return the lines of the section that says which verb reads which tables."""
    rows = [
        f"| `[{table}]` | {', '.join(f'`{verb}`' for verb in verbs)} |"
        for table, verbs in READ_BY.items()
    ]
    return [
        "## Which verb reads which table",
        "",
        "All read the room, the tags, the reader, the radio and the solver. The verbs",
        f"{', '.join(f'`{verb}`' for verb in sorted(SHARE_A_STUDY))} share one study file: each",
        "leaves to the others what is theirs. A table that is of no use to an experiment, and that",
        "says anything but defaults, is refused with the verbs that read it. Verbs that answer one",
        "question (`paths`, `explain`, `scene`, `map`, `rss`, `reader`) take any study.",
        "",
        "| table | read by |",
        "|---|---|",
        *rows,
        "",
    ]


def inherited(table: type, name: str) -> str:
    """Return the meaning of a key that a table has from the class below it."""
    return next(filter(None, (described(base).get(name) for base in table.__mro__[1:-1])), "")


if __name__ == "__main__":
    if "--check" in sys.argv:
        if PAGE.read_text("utf-8") != page():
            click.echo(f"{PAGE} is not up to date: python tools/list_keys.py", err=True)
            sys.exit(1)
    else:
        PAGE.write_text(page(), "utf-8")
