"""The folder of an experiment's results: whose it is, and whether everything is there already."""

import json
import os
from collections.abc import Callable, Iterable
from pathlib import Path

from octant.geometries.errors import ConfigError
from octant.geometries.files import write_text
from octant.reader_design.keeping.keys import digest
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.versions import versions

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
    if study.is_file() and study.read_bytes() == text.encode("utf-8"):
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


def files_of(folder: Path, outputs: Iterable[str]) -> tuple[Path, ...]:
    """Return what an experiment left for people in a folder: files, and folders of figures.

    Parameters
    ----------
    folder, outputs : Folder of the results, and patterns of the files in it; study.toml is added.
    """
    found: list[Path] = []
    for pattern in (*outputs, STUDY_FILE):
        inside, _, _ = pattern.rpartition("/")
        there = [folder / inside] if inside else sorted(folder.glob(pattern))
        found += [path for path in there if path.exists()]
    return tuple(dict.fromkeys(found))


def write_once(
    stamp: Path,
    inputs: object,
    write: Callable[[], Iterable[Path]],
    *,
    force: bool,
    progress: Progress,
) -> bool:
    """Write results unless a former run finished exactly these; return whether it wrote.

    Parameters
    ----------
    stamp : The file that says so, in a folder inside the folder of the results.
    inputs : Everything that the results depend on, as `digest` takes it; versions are added.
    write : Writes the results and returns the paths of all files.
    force, progress : Write all the same; shows that nothing was left to do.
    """
    folder, key = stamp.parents[1], digest([inputs, versions()])
    if not force and _is_complete(stamp, key, folder):
        progress.say(complete_line(folder))
        return False
    stamp.unlink(missing_ok=True)
    names = [Path(os.path.relpath(file, folder)).as_posix() for file in write()]
    write_text(stamp, json.dumps({"key": key, "files": names}, indent=1) + "\n")
    return True


def wrote(stamp: Path, file: Path) -> bool:
    """Return whether `write_once` wrote a file, as its stamp says.

    Parameters
    ----------
    stamp, file : As there.
    """
    try:
        names = json.loads(stamp.read_text("utf-8"))["files"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return Path(os.path.relpath(file, stamp.parents[1])).as_posix() in names


def complete_line(*places: Path) -> str:
    """Return what is said when nothing is left to do.

    Parameters
    ----------
    *places : Folder of the results, or their files.
    """
    named = " and ".join(map(str, places))
    return f"{named} {'is' if len(places) == 1 else 'are'} complete already; nothing was written."


def _is_complete(stamp: Path, key: str, folder: Path) -> bool:
    """Return whether a former run left this stamp and every file that it names is there."""
    try:
        found = json.loads(stamp.read_text("utf-8"))
        return bool(found["key"] == key) and all((folder / f).is_file() for f in found["files"])
    except (OSError, ValueError, KeyError, TypeError):
        return False
