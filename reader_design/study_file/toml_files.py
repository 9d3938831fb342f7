"""Reading TOML files: missing files, wrong encodings and wrong lines as sentences."""

import re
import tomllib
from pathlib import Path
from typing import Any

from octant.geometries.errors import ConfigError


def toml_file_text(path: str | Path, *, what: str) -> str:
    """Return the text of a TOML file.

    Parameters
    ----------
    path : The file.
    what : What it is, for messages, for example ``study``.
    """
    if what == "study" and Path(path).suffix.lower() not in {".toml", ""}:
        _refuse_mesh(Path(path))
    try:
        return Path(path).read_text("utf-8")
    except FileNotFoundError as exc:
        msg = f"The {what} file {str(path)!r} does not exist; give the path of a TOML file."
        raise ConfigError(msg) from exc
    except UnicodeDecodeError as exc:
        msg = f"{path} is not text in UTF-8, which a {what} file must be."
        raise ConfigError(msg) from exc
    except OSError as exc:
        reason = exc.strerror
        msg = f"The {what} file {str(path)!r} cannot be read ({reason}); give a readable file."
        raise ConfigError(msg) from exc


def _refuse_mesh(file: Path) -> None:
    """Refuse a room's mesh where a study is due, and say what writes one for it."""
    from octant.geometries.conversions import is_convertible
    from octant.geometries.mesh_files import readable_extensions

    kind = file.suffix.lower().removeprefix(".")
    if kind in readable_extensions() or is_convertible(kind):
        msg = f"{file} is no study, but a room; write a study for it: octant init {file}"
        raise ConfigError(msg)


def toml_tables(text: str, *, source: str) -> dict[str, Any]:
    """Return the tables of TOML text.

    Parameters
    ----------
    text : TOML.
    source : Name of the file in messages.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as exc:
        found = re.search(r"^(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)$", str(exc))
        where = found[2] if found and found[2] else str(text.count("\n") + 1)
        what = found[1] if found else str(exc)
        msg = f"{source}:{where}: this is not TOML ({what}); correct that line."
        raise ConfigError(msg) from exc
