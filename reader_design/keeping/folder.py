"""The folder of cases: where files lie, what they look like, and that nothing half-written stays.

A file is the content that a codec made, followed by one line of JSON: the key, what is known about
the case, and a digest over all of it. Formats such as netCDF read the content as if the line were
not there.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from octant.geometries.errors import ConfigError, SweepStateError
from octant.geometries.files import whole_file

try:
    import fcntl
except ImportError:  # no Unix
    fcntl = None  # type: ignore[assignment]

FAILED = ".json"
"""Ending of the file of a case without a record."""

_HALF_WRITTEN = re.compile(r"\.[0-9a-f]{32}-")


def case_path(folder: Path, key: str, suffix: str) -> Path:
    """Return where the file of a case lies: named by the first 32 digits of its key.

    Parameters
    ----------
    folder, key, suffix : Folder of the cases, key of the case, ending of the name with its dot.
    """
    return folder / f"{key[:32]}{suffix}"


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """Hold a folder while cases may be written to it; remove what killed runs left half-written.

    Parameters
    ----------
    folder : Folder of the cases; made when missing.

    Notes
    -----
    Every run holds a shared lock on the folder, which the system takes back when the process ends,
    however it ends. A run that gets the lock for itself is the only one, so that no other run can
    be writing the temporary files. Where folders cannot be locked (other systems, some network
    disks) these files stay.
    """
    with suppress(OSError):  # reported by the first file that cannot be written
        folder.mkdir(parents=True, exist_ok=True)
    if fcntl is None or not folder.is_dir():
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for left in folder.glob(".*"):
                if _HALF_WRITTEN.match(left.name):
                    left.unlink(missing_ok=True)
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_SH)
        yield
    finally:
        os.close(handle)


def write_case(path: Path, content: bytes, facts: Mapping[str, Any]) -> None:
    """Write the file of a case whole or not at all.

    Parameters
    ----------
    path : The file.
    content : What the codec made; empty for a case without a record.
    facts : Plain values: the key, seconds, and the reason where there is no record.
    """
    line = json.dumps({**facts, "digest": _digest(content, facts)})
    put_bytes(path, content + b"\n" * bool(content) + line.encode() + b"\n")


def put_bytes(path: Path, content: bytes) -> None:
    """Write a file whole or not at all.

    Parameters
    ----------
    path, content : The file, and all of it.
    """
    try:
        with whole_file(path) as part:
            part.write_bytes(content)
    except OSError as exc:
        msg = (
            f"{path} cannot be written ({exc.strerror or exc}); make room for it or give another "
            "folder: what was computed before is kept, and the same command goes on from there."
        )
        raise ConfigError(msg) from exc


def read_case(path: Path, key: str) -> tuple[bytes, dict[str, Any]] | None:
    """Return content and facts of a case's file, checked; None when there is no file.

    A file that cannot be read, is damaged or belongs to another case is a SweepStateError.

    Parameters
    ----------
    path, key : The file, and the key that it must have.
    """
    try:
        whole = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as exc:
        msg = f"the file {path} cannot be read ({exc.strerror or exc})."
        raise SweepStateError(msg) from exc
    content, _, line = whole.removesuffix(b"\n").rpartition(b"\n")
    try:
        facts = json.loads(line)
        digest = facts.pop("digest")
        sound = digest == _digest(content, facts) and facts["key"] == key
    except (ValueError, KeyError, AttributeError, TypeError):
        sound = False
    if not sound:
        msg = f"the file {path} is damaged or belongs to another case."
        raise SweepStateError(msg)
    return content, facts


def _digest(content: bytes, facts: Mapping[str, Any]) -> str:
    digest = hashlib.sha256(json.dumps(facts, sort_keys=True).encode())
    digest.update(content)
    return digest.hexdigest()
