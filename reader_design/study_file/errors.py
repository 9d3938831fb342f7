"""Sentences for what is wrong with a study file: key path, value, what is allowed, nearest name."""

import re
from collections.abc import Sequence
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import msgspec

from octant.geometries.names import nearest_name
from octant.reader_design.study_file.quantities import limits, range_text

Path = tuple[str | int, ...]

_UNITS = {
    "_s_per_m": "S/m",
    "_rad_per_s": "rad/s",
    "_rad_per_s2": "rad/s²",
    "_db_per_m": "dB/m",
    "_per_m": "1/m",
    "_dbm": "dBm",
    "_m_per_s": "m/s",
    "_deg_per_s": "degrees/s",
    "_deg_per_s2": "degrees/s²",
    "_per_s": "1/s",
    "_m": "m",
    "_hz": "Hz",
    "_nw": "nW",
    "_w": "W",
    "_deg": "degrees",
    "_db": "dB",
    "_ohm": "ohm",
    "_s": "s",
}
_WORDS = {
    "array": "a list",
    "object": "a table",
    "float": "a number",
    "int": "a whole number",
    "str": "text",
    "bool": "true or false",
    "null": "nothing",
}


LONGEST_VALUE = 60
"""Characters of a value that a message repeats."""
LONGEST_NAME = 300
"""Characters of a name or a path that it repeats."""
MOST_NAMES = 40
"""Names that a message lists."""


def shortened(value: Any, most: int = LONGEST_VALUE) -> str:  # noqa: ANN401  any value
    """Return how Python writes a value, without its middle where it is long.

    Parameters
    ----------
    value, most : Any value of a study; greatest number of characters.
    """
    shown = repr(value)
    half = (most - 3) // 2
    return shown if len(shown) <= most else f"{shown[:half]}...{shown[-half:]}"


def unknown_name(path: str, name: str, allowed: Sequence[str], *, what: str) -> str:
    """Return the sentence for a name that does not exist.

    Parameters
    ----------
    path, name : Where it stands, for example ``mission.tags[1]``, and what was given.
    allowed : Names that exist.
    what : What the names are, for example ``tag``.
    """
    near = nearest_name(name[:LONGEST_VALUE], allowed, least_likeness=0.5)
    known = ", ".join(allowed[:MOST_NAMES]) if allowed else "none"
    known += f" and {len(allowed) - MOST_NAMES} more" if len(allowed) > MOST_NAMES else ""
    hint = f"did you mean {near!r} (known are: {known})?" if near else f"known are: {known}."
    return f"{path} is {shortened(name, LONGEST_NAME)}, but there is no such {what}; {hint}"


def path_text(path: Path) -> str:
    """Return a key path as people write it, for example ``room.object[0].size_m[2]``.

    Parameters
    ----------
    path : Keys and list positions from the root.
    """
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            plain = re.fullmatch(r"[\w-]+", part) and len(part) <= LONGEST_VALUE
            text += f".{part}" if plain else f".{shortened(part)}"
    return text.lstrip(".") or "the study"


def unit_of(path: Path) -> str:
    """Return the unit that the last key of a path carries in its name; empty without one.

    Parameters
    ----------
    path : Keys and list positions from the root.
    """
    key = next((p for p in reversed(path) if isinstance(p, str)), "")
    return next((unit for suffix, unit in _UNITS.items() if key.endswith(suffix)), "")


def value_text(path: Path, value: Any) -> str:  # noqa: ANN401  any TOML value
    """Return a value, shortened, as a sentence shows it, with the unit of its key.

    Parameters
    ----------
    path, value : Where it stands, and the TOML value.
    """
    if isinstance(value, bool):
        return str(value).lower()
    shown = shortened(value)
    unit = unit_of(path)
    return f"{shown} {unit}" if unit and isinstance(value, int | float) else shown


def struct_names(struct: type[msgspec.Struct]) -> list[str]:
    """Return the keys that a table of the study file may have, ``kind`` included.

    Parameters
    ----------
    struct : The table's class.
    """
    names = [f.encode_name for f in msgspec.structs.fields(struct)]
    tag = struct.__struct_config__.tag_field
    return [*([tag] if tag else []), *names]


def sentence(error: msgspec.ValidationError, raw: Any, root: type) -> str:  # noqa: ANN401
    """Return one sentence for what msgspec found wrong.

    Parameters
    ----------
    error : What ``msgspec.convert`` raised.
    raw, root : The parsed file, and the class that it should become.
    """
    text, _, where = str(error).partition(" - at ")
    path, value, kind = _locate(where.strip("`"), raw, root)
    shown = path_text(path)
    if where.startswith("`key` in"):
        kind = next(get_args(m)[0] for m in _members(kind) if get_origin(m) is dict)
        value = next(name for name in value if not _converts(name, kind))
        shown = f"a name in {shown}"
    if found := re.match(r"Object contains unknown field `(.+)`", text):
        keys = struct_names(_struct_for(kind, value))
        near = nearest_name(found[1], keys, least_likeness=0.5)
        hint = f"did you mean {near!r}?" if near else f"known here are: {', '.join(keys)}."
        return f"{path_text((*path, found[1]))} is not a key of a study file; {hint}"
    if found := re.match(r"Object missing required field `(.+)`", text):
        return f"{path_text((*path, found[1]))} is missing; every {_table(path)} needs it."
    if text.startswith("Invalid"):
        return unknown_name(shown, str(value), _choices(kind, path), what="choice")
    return f"{shown} is {value_text(path, value)}, but {_wanted(text, kind, path)} is needed."


def _table(path: Path) -> str:
    keys = [p for p in path if isinstance(p, str)]
    return (
        f"[[{'.'.join(keys)}]]"
        if path and isinstance(path[-1], int)
        else (f"[{'.'.join(keys)}]" if keys else "study")
    )


def _wanted(text: str, kind: Any, path: Path) -> str:  # noqa: ANN401
    allowed = limits(kind)
    if allowed and re.match(r"Expected `(int|float)` [<>]|Expected `str` [om]|Integer", text):
        return range_text(*allowed, unit_of(path))
    if found := re.match(r"Expected `(array|object)` of length (>= |<= )?(\d+)", text):
        compared = {">= ": "at least ", "<= ": "at most ", None: ""}[found[2]]
        return f"{_WORDS[found[1]]} of {compared}{found[3]}"
    if found := re.match(r"Expected `([^`]+)`", text):
        words = [_WORDS.get(w, w) for w in found[1].split(" | ") if w != "null"]
        return " or ".join(words)
    return text


def _locate(where: str, raw: Any, root: Any) -> tuple[Path, Any, Any]:  # noqa: ANN401
    """Follow msgspec's path; a dict's key is not named there, so the first bad one is found."""
    path: Path = ()
    value, kind = raw, root
    for token in re.findall(r"\.([^.\[]+)|\[(\d+|\.\.\.)\]", where.removeprefix("$")):
        key, index = token
        if key:
            struct = _struct_for(kind, value)
            tag = struct.__struct_config__.tag_field
            kind = kind if key == tag else _field_type(struct, key)
            path, value = (*path, key), value[key]
        elif index == "...":
            kind = _item_type(kind, dict)
            bad = next(k for k, v in value.items() if not _converts(v, kind))
            path, value = (*path, bad), value[bad]
        else:
            kind = _item_type(kind, tuple, int(index))
            path, value = (*path, int(index)), value[int(index)]
    return path, value, kind


def _converts(value: Any, kind: Any) -> bool:  # noqa: ANN401
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError:
        return False
    return True


def _members(kind: Any) -> list[Any]:  # noqa: ANN401
    origin = get_origin(kind)
    if origin is Annotated:
        return _members(get_args(kind)[0])
    if origin in {Union, UnionType}:
        return [m for arg in get_args(kind) for m in _members(arg)]
    return [kind]


def _struct_for(kind: Any, value: Any) -> type[msgspec.Struct]:  # noqa: ANN401
    structs = [m for m in _members(kind) if isinstance(m, type) and issubclass(m, msgspec.Struct)]
    for struct in structs:
        config = struct.__struct_config__
        if config.tag_field and value.get(config.tag_field) == config.tag:
            return struct
    return structs[0]


def _field_type(struct: type[msgspec.Struct], key: str) -> Any:  # noqa: ANN401
    return next(f.type for f in msgspec.structs.fields(struct) if f.encode_name == key)


def _item_type(kind: Any, container: type, index: int = 0) -> Any:  # noqa: ANN401
    for member in _members(kind):
        if get_origin(member) is container:
            args = get_args(member)
            if container is dict or Ellipsis in args:
                return args[-1] if container is dict else args[0]
            return args[index]
    return object


def _choices(kind: Any, path: Path) -> list[str]:  # noqa: ANN401
    members = _members(kind)
    names = [str(a) for m in members if get_origin(m) is Literal for a in get_args(m)]
    tags = [
        str(m.__struct_config__.tag)
        for m in members
        if isinstance(m, type) and issubclass(m, msgspec.Struct) and path[-1] == "kind"
    ]
    return names + tags
