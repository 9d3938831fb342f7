"""Writing a study as TOML text (the standard library only reads TOML)."""

import json
import re
from typing import Any

_COMMENTS = {
    "antenna_length_m": "not given: half a wave (dipole), a quarter wave (monopole)",
    "plate_height_axis_m": "not given: as plate_height_m",
    "plate_outer_radius_m": "not given: half of ground_plane_m",
    "encoder_counts": "not given: the estimators receive the commands",
    "start_m": "not given: on the trajectory",
    "start_heading_deg": "not given: along the trajectory",
    "bandwidth_hz": "not given: no thermal noise",
    "required_snr_db": "not given: no ratio is required",
    "sensitivity_dbm": "not given: no limit",
    "bits": "not given: readings are not rounded",
    "max_time_s": "not given: 60 s and four times what the straight way takes",
}


def toml_text(tables: dict[str, Any]) -> str:
    """Return nested plain values as TOML text that ``tomllib`` reads back to the same values.

    Dicts at the root, and the room, become tables, as do lists of dicts; other dicts stand inline.

    Parameters
    ----------
    tables : Text keys; values are text, numbers, booleans, lists, dicts; None leaves a key out.
    """
    lines: list[str] = []
    _table(lines, (), tables)
    return "\n".join(lines).strip() + "\n"


def _table(lines: list[str], path: tuple[str, ...], table: dict[str, Any]) -> None:
    later: list[tuple[str, Any]] = []
    for key, value in table.items():
        if _is_table(path, key, value) or _is_table_list(value):
            later.append((key, value))
        elif value is not None:
            lines.append(f"{key_text(key)} = {value_text(value)}")
        elif key in _COMMENTS:
            lines.append(f"# {key}  {_COMMENTS[key]}")
    for key, value in later:
        name = ".".join(key_text(p) for p in (*path, key))
        for part in value if isinstance(value, list | tuple) else [value]:
            brackets = f"[[{name}]]" if isinstance(value, list | tuple) else f"[{name}]"
            lines.extend(["", brackets])
            _table(lines, (*path, key), part)


def _is_table(path: tuple[str, ...], key: str, value: Any) -> bool:  # noqa: ANN401
    return isinstance(value, dict) and (not path or key == "room")


def _is_table_list(value: Any) -> bool:  # noqa: ANN401
    return isinstance(value, list | tuple) and bool(value) and isinstance(value[0], dict)


def key_text(key: str) -> str:
    """Return a key as TOML writes it.

    Parameters
    ----------
    key : Any text.
    """
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else value_text(key)


def value_text(value: Any) -> str:  # noqa: ANN401
    """Return a plain value as TOML writes it in one line.

    Parameters
    ----------
    value : Text, number, boolean, list or dict.
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, dict):
        items = (f"{key_text(k)} = {value_text(v)}" for k, v in value.items() if v is not None)
        return "{" + ", ".join(items) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_text(v) for v in value) + "]"
    return repr(value)
