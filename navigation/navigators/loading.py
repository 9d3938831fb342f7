"""Where a navigator of the user's own is found: a file, a package, or an entry point."""

import importlib
import importlib.util
import inspect
import sys
import sysconfig
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any

from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name

GROUP = "octant.navigators"
"""Entry points of packages that bring navigators."""


def is_file(where: str) -> bool:
    """Return whether a place is a file, not a module.

    Parameters
    ----------
    where : What stands before the colon.
    """
    return where.endswith(".py")


def entry_point_names() -> tuple[str, ...]:
    """Return the names of all navigators that installed packages bring."""
    return tuple(sorted({point.name for point in metadata.entry_points(group=GROUP)}))


def class_place(text: str) -> tuple[str, str]:
    """Return file or module, and class, of a navigator's name.

    Parameters
    ----------
    text : ``FILE.py:Class``, ``package.module:Class``, or the name of an entry point.
    """
    if ":" not in text:
        points = {point.name: point.value for point in metadata.entry_points(group=GROUP)}
        text = points.get(text, text)
    where, _, name = text.rpartition(":")
    if not where or not name:
        msg = (
            f"the navigator {text!r} is no class; write FILE.py:Class, package.module:Class, or "
            f"the name of an entry point of the group {GROUP}."
        )
        raise ConfigError(msg)
    return where, name.strip()


def load_class(where: str, name: str) -> Any:  # noqa: ANN401  anything of that name
    """Return what a module or a file calls by a name; what goes wrong is one sentence.

    Parameters
    ----------
    where, name : From `class_place`; a file by absolute path.
    """
    module = _file_module(where) if is_file(where) else _module(where)
    found: Any = module
    for part in name.split("."):
        if not hasattr(found, part):
            classes = [n for n, c in vars(module).items() if inspect.isclass(c)]
            near = nearest_name(name, classes, least_likeness=0.5)
            hint = f"; did you mean {near!r}?" if near else "."
            msg = f"{_shown(where)} has no class {name!r}{hint}"
            raise ConfigError(msg)
        found = getattr(found, part)
    return found


def source_files(kind: type) -> tuple[str, ...]:
    """Return the files in which a class and those it is derived from stand, besides Python's own.

    Parameters
    ----------
    kind : A class; Octant's own are counted by Octant's version.
    """
    library = sysconfig.get_paths()["stdlib"]
    found = []
    for one in kind.__mro__:
        module = sys.modules.get(one.__module__)
        file = getattr(module, "__file__", None)
        if file and not file.startswith(library) and not one.__module__.startswith("octant."):
            found.append(str(Path(file).resolve()))
    return tuple(dict.fromkeys(found))


def _module(where: str) -> ModuleType:
    try:
        with _one_sentence(where):
            return importlib.import_module(where)
    except ModuleNotFoundError as exc:
        if not where.startswith(str(exc.name)):
            msg = f"{where} cannot be imported: it needs {exc.name!r}, which is not installed."
            raise ConfigError(msg) from exc
        msg = (
            f"there is no module {where!r} to import for the navigator; install it, or name a file "
            f"as {where.split('.', maxsplit=1)[0]}.py:Class."
        )
        raise ConfigError(msg) from exc


def _file_module(where: str) -> ModuleType:
    file = Path(where)
    if not file.is_file():
        msg = f"the navigator's file {where} does not exist; give an existing file."
        raise ConfigError(msg)
    about = file.stat()
    return _executed(where, (about.st_mtime_ns, about.st_size))


@lru_cache(maxsize=32)
def _executed(where: str, state: tuple[int, int]) -> ModuleType:
    """Return the module of a file in a state; its neighbours can be imported by it."""
    name = f"octant_navigator_{Path(where).stem}_{abs(hash((where, state))):x}"
    spec = importlib.util.spec_from_file_location(name, where)
    assert spec is not None  # noqa: S101  every .py file has a loader
    assert spec.loader is not None  # noqa: S101
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    sys.path.insert(0, str(Path(where).parent))
    try:
        with _one_sentence(where):
            spec.loader.exec_module(module)
    except ModuleNotFoundError as exc:
        msg = f"{_shown(where)} needs {exc.name!r}, which is not installed."
        raise ConfigError(msg) from exc
    finally:
        sys.path.remove(str(Path(where).parent))
    return module


@contextmanager
def _one_sentence(where: str) -> Iterator[None]:
    """Turn what a module raises while it is imported into one sentence with its line."""
    try:
        yield
    except ModuleNotFoundError:
        raise
    except SyntaxError as exc:
        msg = f"{_shown(where)} is no Python, line {exc.lineno}: {exc.msg}."
        raise ConfigError(msg) from exc
    except Exception as exc:
        line = traceback.extract_tb(exc.__traceback__)[-1].lineno
        said = str(exc).rstrip(".").replace("\n", " ")
        msg = f"{_shown(where)} cannot be imported (line {line}): {type(exc).__name__}: {said}."
        raise ConfigError(msg) from exc


def _shown(where: str) -> str:
    return Path(where).name if is_file(where) else where
