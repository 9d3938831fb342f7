# ruff: noqa: ANN401  numba's objects carry no types
"""Machine code of kernels on disk, which never outlives its source.

Numba's own cache looks only at the file in which a function stands. After an upgrade or an edit, a
function whose file is unchanged still holds the old code of what it calls in another file, and its
numbers are wrong without a word. Here machine code counts only as long as the module and all that
it imports from its package, directly or not, say what they said when it was compiled.
"""

import ast
import contextlib
import functools
import hashlib
import pickle
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

from octant.geometries.errors import ConfigError
from octant.geometries.files import whole_file

try:
    import fcntl
except ImportError:  # Windows: processes compile the same kernel side by side
    fcntl = None  # type: ignore[assignment]

VERSIONS = repr((numba.__version__, llvmlite.__version__, np.__version__))


class KeptCode(FunctionCache):  # type: ignore[misc]  # numba carries no types
    """Numba's cache of one function, in numba's folder, but with files that know their source.

    ``needs`` tells what must be known to a process before it loads a piece of machine code.
    """

    def __init__(self, function: Callable[..., Any], needs: Callable[[Any], list[Any]]) -> None:
        super().__init__(function)
        self.function = function
        self._needs = needs
        self._cache_file = _Files(
            Path(self.cache_path) / self._impl.filename_base, source_digest(function.__module__)
        )

    def alone(self, sig: Any, target_context: Any) -> contextlib.AbstractContextManager[None]:
        """Return a block in which no other process compiles this code, after a wait if need be.

        Parameters
        ----------
        sig, target_context : As numba's caches take them.
        """
        return self._cache_file.alone(self._index_key(sig, target_context.codegen()))

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        kept = self._cache_file.load(self._index_key(sig, target_context.codegen()))
        return None if kept is None else self._impl.rebuild(target_context, kept[1])

    def _save_overload(self, sig: Any, data: Any) -> None:
        if self._impl.check_cachable(data):
            self._impl.locator.ensure_cache_path()
            kept = self._needs(data.library), self._impl.reduce(data)
            self._cache_file.save(self._index_key(sig, data.codegen), kept)


class _Files:
    """The machine code of one function: a file for each signature, which says what it is made from.

    Numba's own index of signatures can name a file with another signature's code, when two
    processes compile at the same time.
    """

    def __init__(self, base: Path, source: bytes) -> None:
        self._base = base
        self._source = source

    def load(self, key: object) -> Any:
        """Return what was kept under a key; None: nothing, or in part, or of old source."""
        try:
            content = self._file(key).read_bytes()
        except OSError:
            return None
        seal, code = content[:_SEAL_BYTES], content[_SEAL_BYTES:]
        return pickle.loads(code) if seal == self._seal(key, code) else None  # noqa: S301  sealed

    def save(self, key: object, compiled: object) -> None:
        """Keep code under a key, in place of an older one; on a full disk it is not kept."""
        code = dumps(compiled)
        with contextlib.suppress(OSError, ConfigError), whole_file(self._file(key)) as part:
            part.write_bytes(self._seal(key, code) + code)

    @contextlib.contextmanager
    def alone(self, key: object) -> Iterator[None]:
        """Let one process at a time work on what is kept under a key, unless it is kept already.

        A process that ends, however it ends, makes way.

        Parameters
        ----------
        key : As for ``load``.
        """
        with contextlib.ExitStack() as stack:
            if fcntl is not None and self.load(key) is None:
                with contextlib.suppress(OSError):  # a folder that cannot be written: no waiting
                    self._base.parent.mkdir(parents=True, exist_ok=True)
                    claim = stack.enter_context(self._claim(key).open("w"))
                    fcntl.flock(claim, fcntl.LOCK_EX)
            yield

    def _file(self, key: object) -> Path:
        digest = hashlib.sha256(repr(key).encode()).hexdigest()
        return self._base.with_name(f"{self._base.name}.{digest[:12]}.nbc")

    def _claim(self, key: object) -> Path:
        return self._file(key).with_suffix(".nbc.lock")

    def _seal(self, key: object, code: bytes) -> bytes:
        return hashlib.sha256(self._source + repr(key).encode() + code).digest()


_SEAL_BYTES = hashlib.sha256().digest_size


@functools.cache
def source_digest(name: str) -> bytes:
    """Return the SHA-256 of a module, of what it imports from its package, and of the compiler.

    Parameters
    ----------
    name : Full name of the module.
    """
    digest = hashlib.sha256(VERSIONS.encode())
    found: set[str] = set()
    waiting = [name]
    while waiting:
        module = waiting.pop()
        if module not in found:
            found.add(module)
            waiting += _imported(module)
    for module in sorted(found):
        digest.update(f"{module}\n{_source(module)}".encode())
    return digest.digest()


@functools.cache
def _source(name: str) -> str:
    loader: Any = sys.modules[name].__loader__
    return loader.get_source(name) or ""


@functools.cache
def _imported(name: str) -> tuple[str, ...]:
    """Return the modules of its own package that a module imports when it is itself imported."""

    def names() -> Iterator[str]:
        for node in ast.parse(_source(name)).body:
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module:
                yield node.module
                yield from (f"{node.module}.{alias.name}" for alias in node.names)

    package = name.partition(".")[0] + "."
    return tuple(each for each in names() if each.startswith(package) and each in sys.modules)
