"""The folder of an experiment's results: whose it is, and whether everything is there already."""

import json
from collections.abc import Iterable
from pathlib import Path

from octant.geometries.errors import ConfigError
from octant.geometries.files import write_text

STUDY_FILE = "study.toml"
"""The study with every default resolved, in each folder of results."""


def refuse_another(folder: Path, text: str, *, force: bool, outputs: Iterable[str] = ()) -> None:
    """Refuse a folder that holds the results of another study; clear it with ``force``.

    Parameters
    ----------
    folder : Where results would go.
    text : The resolved study, as it will be stored there.
    force : True: delete the results of another study. Kept cases stay, so that what both studies
        have in common is not computed again.
    outputs : Patterns of the files that hold results.
    """
    if folder.exists() and not folder.is_dir():
        msg = f"{folder} is a file, but the results need a folder; give another --out."
        raise ConfigError(msg)
    study = folder / STUDY_FILE
    if study.is_file() and study.read_text("utf-8") == text:
        return
    there = [path for pattern in outputs for path in sorted(folder.glob(pattern))]
    if not (there or study.exists()):
        return
    if not force:
        msg = (
            f"{folder} holds the results of another study (or another version of this one); give "
            "another --out, or --force to replace them: what both have in common is kept."
        )
        raise ConfigError(msg)
    for path in (*there, study):
        path.unlink(missing_ok=True)


def is_complete(stamp: Path, key: str) -> bool:
    """Return whether a former run finished exactly these results, and all files are still there.

    Parameters
    ----------
    stamp : The file that the former run left, in a folder of the results folder.
    key : Hash of everything that the results depend on.
    """
    try:
        found = json.loads(stamp.read_text("utf-8"))
        files = [stamp.parents[1] / name for name in found["files"]]
        return bool(found["key"] == key) and all(file.is_file() for file in files)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def mark_complete(stamp: Path, key: str, files: Iterable[Path]) -> None:
    """Write the file by which the next run knows that everything is there.

    Parameters
    ----------
    stamp : The file; two levels below it stand all others.
    key : Hash of everything that the results depend on.
    files : What was written.
    """
    names = [file.relative_to(stamp.parents[1]).as_posix() for file in files]
    write_text(stamp, json.dumps({"key": key, "files": names}, indent=1) + "\n")


def complete_line(folder: Path) -> str:
    """Return what is said when nothing is left to do.

    Parameters
    ----------
    folder : Folder of the results.
    """
    return f"{folder} is complete already; nothing was written."
