"""Logs out of folders with one file a place: the place stands in the file's name, or in a list."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name
from octant.navigation.logs.forms import TableForm, name_pattern
from octant.navigation.logs.records import Log, joined, of_ids
from octant.navigation.logs.tables import read_table
from octant.navigation.logs.text_tables import read_text_table

_NUMBERS = frozenset({"x", "y", "heading", "antenna", "time"})
_KNOWN = ("x", "y", "heading", "place", "id", "antenna", "any")


@dataclass(frozen=True, slots=True, kw_only=True)
class FolderForm:
    """How the files of a folder are called.

    Parameters
    ----------
    name : Pattern of the names with ``{x}``, ``{y}``, ``{heading}``, ``{place}``, ``{id}``,
        ``{antenna}`` and ``{any}`` in it, such as ``room1_{x}_{y}.csv``; units as in the table.
        Folders below count: ``{place}/{id}.csv``. What it does not match is no file of the log.
    places : A table with the columns ``place``, x, y and heading, as the form names them, for the
        names of places; None: places stand in the names.
    """

    name: str
    places: Path | None = None


def read_folder(path: Path, form: TableForm, folder: FolderForm) -> Log:
    """Return the log of a folder's files in the order of their names, each with its place.

    Parameters
    ----------
    path : The folder.
    form : Columns and units of every file.
    folder : How they are called.

    Raises
    ------
    ConfigError
        No file matches, a place is not in the list, or a file is wrong.
    """
    pattern = name_pattern(folder.name, _NUMBERS)
    unknown = [name for name in pattern.groupindex if name not in _KNOWN]
    if unknown:
        msg = (
            f"the pattern {folder.name!r} has {{{unknown[0]}}}, but knows {', '.join(_KNOWN)} only."
        )
        raise ConfigError(msg)
    if not path.is_dir():
        raise ConfigError(f"{path} is no folder, but the log is one with a file a place.")
    matches = {
        file: match
        for file in sorted(path.rglob("*"))
        if file.is_file() and (match := pattern.fullmatch(file.relative_to(path).as_posix()))
    }
    if not matches:
        some = sorted(f.relative_to(path).as_posix() for f in path.rglob("*") if f.is_file())[:3]
        msg = f"{path} has no file like {folder.name!r}; it has {', '.join(some) or 'none at all'}."
        raise ConfigError(msg)
    places = None if folder.places is None else _places(folder.places, form)
    return joined([_one(file, match.groupdict(), form, places) for file, match in matches.items()])


_Place = tuple[float, float, float]


def _one(
    file: Path, said: dict[str, str], form: TableForm, places: dict[str, _Place] | None
) -> Log:
    named = {key: value for key, value in said.items() if value is not None}
    whole = form.columns.wide or "id" not in named
    own = form if whole else replace(form, columns=replace(form.columns, id=None))
    log = _of_one_source(file, named["id"], own) if not whole else read_table(file, own)
    pose = _pose(file, named, form, places)
    poses = np.where(np.isnan(log.poses), pose, log.poses)
    antennas = log.antennas
    if "antenna" in named:
        antennas = np.where(antennas == 0, int(float(named["antenna"])), antennas)
    kept = dict(log.kept)
    if "place" in named and "place" not in kept:
        kept["place"] = (named["place"],) * len(log)
    return replace(log, poses=poses, antennas=antennas, kept=kept)


def _of_one_source(file: Path, source: str, form: TableForm) -> Log:
    """Return the log of a file whose one column of levels is that of the source in its name."""
    columns = replace(form.columns, rss="{id}")
    level = str(form.columns.rss)
    name = form.ids.get(source, source)
    log = read_table(file, replace(form, columns=columns, ids={level: name}, only=None))
    return log if form.only is None or name in form.only else of_ids(log, ())


def _pose(
    file: Path, said: dict[str, str], form: TableForm, places: dict[str, _Place] | None
) -> _Place:
    def number(name: str) -> float:
        return float(said[name].replace(",", ".")) if name in said else math.nan

    heading = form.headings_rad(np.array(number("heading")))
    x, y, turn = form.metres * number("x"), form.metres * number("y"), float(heading)
    if places is not None and "place" in said:
        if said["place"] not in places:
            near = nearest_name(said["place"], places)
            msg = f"{file}: the place {said['place']!r} is not in the list; did you mean {near!r}?"
            raise ConfigError(msg)
        listed = places[said["place"]]
        x, y = (
            given if math.isnan(own) else own for own, given in zip((x, y), listed[:2], strict=True)
        )
        turn = listed[2] if math.isnan(turn) else turn
    return x, y, turn


def _places(path: Path, form: TableForm) -> dict[str, _Place]:
    table = read_text_table(path, separator=form.separator, what="a list of places")
    names = table.texts("place")
    x, y = (form.metres * table.numbers(n) for n in (form.columns.x or "x", form.columns.y or "y"))
    heading = form.columns.heading or "heading"
    turn = np.full(len(table), np.nan)
    if heading in table.header:
        turn = form.headings_rad(table.numbers(heading))
    return {n: (float(a), float(b), float(c)) for n, a, b, c in zip(names, x, y, turn, strict=True)}
