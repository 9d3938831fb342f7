"""The mark on a folder of results: whose they are, and whether they are complete."""

import hashlib
import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from octant.geometries.errors import ConfigError
from octant.geometries.files import refuse_overwrite, write_text
from octant.reader_design.keeping.versions import versions

MARK = ".octant.json"
"""Name of the mark."""


def begin_results(
    folder: Path, identity: Sequence[str], *, files: Iterable[str], force: bool
) -> bool:
    """Return whether a former run completed these very results; else mark the folder as theirs.

    Parameters
    ----------
    folder : Path
        Folder of the results.
    identity : sequence of str
        What the results depend on, such as the resolved study; the versions in force count too.
    files : iterable of str
        Names of the files that will be written; without a mark in the folder none of them may be
        there.
    force : bool
        Write over results of another run, and over complete ones.

    Raises
    ------
    ConfigError
        When the folder holds results of another study, or files that are not results, and
        ``force`` is false.
    """
    key = hashlib.sha256(json.dumps([*identity, versions()]).encode()).hexdigest()
    mark = folder / MARK
    try:
        found = json.loads(mark.read_text("utf-8"))
        former, written = str(found["key"]), [str(name) for name in found["files"]]
    except (OSError, ValueError, KeyError, TypeError):
        refuse_overwrite(*(folder / name for name in files), force=force)
    else:
        if former == key and written and all((folder / name).is_file() for name in written):
            if not force:
                return True
        elif former != key and not force:
            msg = (
                f"{folder} holds the results of another study, or of other versions; give another "
                "--out, or --force to replace them."
            )
            raise ConfigError(msg)
    write_text(mark, json.dumps({"key": key, "files": []}))
    return False


def finish_results(folder: Path, files: Iterable[Path]) -> None:
    """Mark the results of a folder as complete.

    Parameters
    ----------
    folder : Path
        Folder of the results, marked by `begin_results`.
    files : iterable of Path
        The files that were written.
    """
    mark = folder / MARK
    key = json.loads(mark.read_text("utf-8"))["key"]
    names = [str(path.relative_to(folder)) for path in files]
    write_text(mark, json.dumps({"key": key, "files": names}, indent=1))
