"""Files written whole or not at all: the only place that replaces a file by a finished one."""

import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from octant.geometries.errors import ConfigError


def refuse_overwrite(*paths: Path, force: bool) -> None:
    """Refuse, before any work, to overwrite a file or to write below one.

    Parameters
    ----------
    *paths : Files that would be written.
    force : True: overwriting is what the user asked for.
    """
    for path in paths:
        if path.is_dir():
            msg = f"{path} is a folder, but a file will be written; give the name of a file."
            raise ConfigError(msg)
        above = next(folder for folder in path.absolute().parents if folder.exists())
        if not above.is_dir():
            msg = f"{path} cannot be written, because {above} is a file; give another place."
            raise ConfigError(msg)
        if path.exists() and not force:
            msg = f"{path} exists already; give another place, or --force to overwrite it."
            raise ConfigError(msg)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a file, same folder and suffix, that replaces ``path`` at the end if nothing fails.

    Parameters
    ----------
    path : The file to write; its folder is made where it is missing.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent
        )
    except OSError as exc:
        msg = f"{path} cannot be written ({exc.strerror}); give a folder that can be written to."
        raise ConfigError(msg) from exc
    os.close(handle)
    part = Path(name)
    try:
        yield part
        part.chmod(0o666 & ~_umask())
        part.replace(path)
    except OSError as exc:
        if exc.errno and exc.filename is None:  # as where the disk is full: name the file
            exc.filename = str(path)
        raise
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str, *, force: bool = True) -> None:
    """Write a text file whole, in UTF-8.

    Parameters
    ----------
    path : The file.
    text : Its content.
    force : False: refuse when the file exists.
    """
    refuse_overwrite(path, force=force)
    with whole_file(path) as part:
        part.write_text(text, "utf-8", newline="")


def put_finished(made: Mapping[Path, Path], *, force: bool) -> bool:
    """Return whether files were put in their places; False when the same ones are there already.

    Parameters
    ----------
    made : Finished file by the place where it belongs.
    force : Replace files that are there and differ; else refused.
    """
    there = {place for place in made if place.is_file()}
    same = {place for place in there if place.read_bytes() == made[place].read_bytes()}
    if len(same) == len(made) and not force:
        return False
    refuse_overwrite(*(place for place in made if place not in same), force=force)
    for place, file in made.items():
        with whole_file(place) as part:
            part.write_bytes(file.read_bytes())
    return True


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
