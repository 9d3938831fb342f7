"""The key of a case: a hash of everything that its computation receives.

Nothing has to be listed, so nothing can be forgotten: the key covers every field of the context
and of the case, except fields that are named as without effect.
"""

import dataclasses
import enum
import hashlib
import os
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from pathlib import Path
from types import MethodType
from typing import Any

import msgspec
import numpy as np

from octant.geometries.mesh_files import files_named
from octant.reader_design.keeping.versions import versions

KEY_FORMAT = 1
"""Raised when keys or files are made in another way, so that old files are computed again."""


def case_keys(
    compute: Callable[..., object],
    cases: Iterable[object],
    *,
    context: object,
    leave_out: Sequence[str] = (),
) -> tuple[str, ...]:
    """Return the key of each case, 64 hexadecimal digits.

    Parameters
    ----------
    compute : A function of a module; its name is part of the key, as is the version of Octant.
    cases : One of them is what ``compute`` receives after the context. Numbers, text, arrays,
        files, dataclasses, msgspec structs and collections of these; others are a
        TypeError. A path, or a text that is the absolute path of a file, counts by its content and
        that of the files in which its meshes stand.
    context : What ``compute`` receives first; of the same types.
    leave_out : Fields that cannot change a result, each written ``Class.field``, for example
        ``Study.name``. Fields that a dataclass computes itself (``init=False``) never count.
    """
    name = _name_of(compute)
    digests = _Digests(leave_out)
    shared = digests.of([KEY_FORMAT, versions()["octant_version"], name, context])
    return tuple(hashlib.sha256(shared + digests.of(case)).hexdigest() for case in cases)


def digest(value: object) -> str:
    """Return the SHA-256 of a value's content, 64 hexadecimal digits.

    Parameters
    ----------
    value : Of the types that `case_keys` reads.
    """
    return _Digests(()).of(value).hex()


def _name_of(function: Callable[..., object]) -> str:
    name = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', '<')}"
    if "<" in name:
        msg = f"{function!r} is not a function of a module, so worker processes cannot import it."
        raise TypeError(msg)
    return name


class _Digests:
    """Digests of values; what was met before is not read again."""

    def __init__(self, leave_out: Sequence[str]) -> None:
        self._leave_out: dict[str, set[str]] = {}
        for item in leave_out:
            kind, _, field = item.partition(".")
            self._leave_out.setdefault(kind, set()).add(field)
        self._known: dict[int, tuple[object, bytes]] = {}  # holds the object: ids are used again

    def of(self, value: object) -> bytes:
        """Return 32 bytes that are equal for equal values only."""
        known = self._known.get(id(value))
        if known is not None:
            return known[1]
        digest = hashlib.sha256()
        for part in self._parts(value):
            digest.update(part)
        found = digest.digest()
        if isinstance(value, np.ndarray | msgspec.Struct) or dataclasses.is_dataclass(value):
            self._known[id(value)] = value, found
        return found

    def _parts(self, value: Any) -> Iterable[bytes]:  # noqa: ANN401, PLR0911  one for each type
        if isinstance(value, enum.Enum):
            return b"enum ", type(value).__name__.encode(), b".", value.name.encode()
        if value is None or isinstance(value, bool | np.bool_):
            return b"constant ", str(value).encode()
        if isinstance(value, int | np.integer):
            return b"int ", str(int(value)).encode()
        if isinstance(value, float | np.floating):
            return b"float ", struct.pack("<d", float(value))
        if isinstance(value, complex | np.complexfloating):
            return b"complex ", struct.pack("<dd", value.real, value.imag)
        if isinstance(value, str | Path):
            return _text_parts(str(value))
        if isinstance(value, bytes):
            return b"bytes ", value
        if isinstance(value, np.ndarray) and not value.dtype.hasobject:
            head = f"array {value.dtype.str} {value.shape} "
            return head.encode(), np.ascontiguousarray(value).tobytes()
        if isinstance(value, Mapping):
            pairs = sorted(self.of(key) + self.of(item) for key, item in value.items())
            return b"mapping ", *pairs
        if isinstance(value, AbstractSet):
            return b"set ", *sorted(self.of(item) for item in value)
        if isinstance(value, list | tuple):
            return b"sequence ", *(self.of(item) for item in value)
        if isinstance(value, MethodType):  # its object says all that it reads
            return b"method ", value.__name__.encode(), b" of ", self.of(value.__self__)
        return self._fields(value)

    def _fields(self, value: Any) -> Iterable[bytes]:  # noqa: ANN401  anything with fields
        kind = type(value).__name__
        if isinstance(value, msgspec.Struct):
            names = list(value.__struct_fields__)
        elif dataclasses.is_dataclass(value):
            names = [field.name for field in dataclasses.fields(value) if field.init]
        else:
            msg = f"a {kind} cannot be part of a case's key; give numbers, text, arrays, records."
            raise TypeError(msg)
        left_out = self._leave_out.get(kind, set())
        if not left_out <= set(names):
            msg = f"{kind} has no field {min(left_out - set(names))!r} that could be left out."
            raise ValueError(msg)
        counted = [name for name in names if name not in left_out]
        pairs = (name.encode() + b"=" + self.of(getattr(value, name)) for name in counted)
        return b"record ", kind.encode(), b" ", *pairs


def _text_parts(text: str) -> Iterable[bytes]:
    if os.path.isabs(text) and "\n" not in text and os.path.isfile(text):  # noqa: PTH117, PTH113
        files = (Path(text), *files_named(text))
        return b"file ", *(hashlib.sha256(file.read_bytes()).digest() for file in files)
    if os.path.isabs(text) and "\n" not in text and os.path.isdir(text):  # noqa: PTH117, PTH112
        return b"folder ", *_listing(Path(text))
    return b"text ", text.encode()


def _listing(folder: Path) -> Iterable[bytes]:
    """Yield name, size and time of change of each file below a folder of models."""
    for file in sorted(folder.rglob("*")):
        if file.is_file():
            found = file.stat()
            line = f"{file.relative_to(folder)} {found.st_size} {found.st_mtime_ns} "
            yield line.encode()
