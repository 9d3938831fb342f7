"""The file of a comparison: layouts x links x readers x controllers, each a study of its own."""

from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.errors import sentence
from octant.reader_design.study_file.room import Name, Positive, PositiveCount, Table
from octant.reader_design.study_file.toml_files import toml_file_text, toml_tables

Keys = dict[str, Any]

OWN = "the study's"
"""Name of a link or reader that is as each study has it."""


class LayoutEntry(Table, frozen=True, kw_only=True):
    """A layout: ``[[layout]]``.

    Parameters
    ----------
    study : str
        Study file with room, tags and mission, relative to the comparison file.
    published_rmse_m : float or None
        RMSE that was published for it [m], to stand beside the computed ones.
    """

    study: Name
    published_rmse_m: Positive | None = None


class ControllerEntry(Table, frozen=True, kw_only=True):
    """A controller: ``[[controller]]``.

    Parameters
    ----------
    name : str
        Name in the results.
    mission : dict
        Keys of the table ``[mission]`` that it sets.
    """

    name: Name
    mission: Keys


class ReaderEntry(Table, frozen=True, kw_only=True):
    """A reader: ``[[reader]]``.

    Parameters
    ----------
    name : str
        Name in the results.
    reader : dict
        Keys of the table ``[reader]`` that it sets.
    """

    name: Name = OWN
    reader: Keys = msgspec.field(default_factory=dict)


class LinkEntry(Table, frozen=True, kw_only=True):
    """The link of tag and reader: ``[[link]]``.

    Parameters
    ----------
    name : str
        Name in the results.
    radio, sensor : dict
        Keys of the tables ``[radio]`` and ``[sensor]`` that it sets.
    tag : dict
        Keys that it sets in every ``[[tag]]``; an antenna without ``axis`` hangs as usual.
    """

    name: Name = OWN
    radio: Keys = msgspec.field(default_factory=dict)
    sensor: Keys = msgspec.field(default_factory=dict)
    tag: Keys = msgspec.field(default_factory=dict)


class Comparison(Table, frozen=True, kw_only=True):
    """The root of a comparison file; every combination of its entries is one cell.

    Parameters
    ----------
    name : str
        Name in the report.
    seed : int
        Seed of every cell.
    runs : int
        Runs of each cell.
    layouts : tuple of LayoutEntry
        The tables ``[[layout]]``.
    links : tuple of LinkEntry
        The tables ``[[link]]``; none: as in each study.
    readers : tuple of ReaderEntry
        The tables ``[[reader]]``; none: as in each study.
    controllers : tuple of ControllerEntry
        The tables ``[[controller]]``.
    """

    name: Name = "comparison"
    seed: Annotated[int, Meta(ge=0)] = 1
    runs: PositiveCount = 100
    layouts: Annotated[tuple[LayoutEntry, ...], Meta(min_length=1)] = msgspec.field(name="layout")
    links: tuple[LinkEntry, ...] = msgspec.field(default=(LinkEntry(),), name="link")
    readers: tuple[ReaderEntry, ...] = msgspec.field(default=(ReaderEntry(),), name="reader")
    controllers: Annotated[tuple[ControllerEntry, ...], Meta(min_length=1)] = msgspec.field(
        name="controller"
    )


def load_comparison(path: str | Path) -> Comparison:
    """Return the comparison of a file, its study files by absolute path.

    Parameters
    ----------
    path : str or Path
        A TOML file.
    """
    raw = toml_tables(toml_file_text(path, what="comparison"), source=str(path))
    try:
        given = msgspec.convert(raw, Comparison)
    except msgspec.ValidationError as exc:
        msg = f"{path}: {sentence(exc, raw, Comparison)}"
        raise ConfigError(msg) from exc
    for kind, entries in (
        ("controller", given.controllers),
        ("reader", given.readers),
        ("link", given.links),
    ):
        names = [entry.name for entry in entries]
        for name in names:
            if names.count(name) > 1:
                msg = f"{path}: the name {name!r} of a [[{kind}]] stands twice; rename one of them."
                raise ConfigError(msg)
    folder = Path(path).resolve().parent
    layouts = tuple(
        msgspec.structs.replace(layout, study=str(folder / layout.study))
        for layout in given.layouts
    )
    return msgspec.structs.replace(given, layouts=layouts)
