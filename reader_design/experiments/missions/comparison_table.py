"""Comparison files: layouts, links, readers, controllers, worlds, and errors that are swept."""

import math
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.missions.sensitivity import (
    ErrorEntry,
    check_error,
    error_truths,
)
from octant.reader_design.study_file.errors import sentence
from octant.reader_design.study_file.loading import named_class
from octant.reader_design.study_file.quantities import (
    Count,
    Distance,
    FileName,
    Name,
    Seed,
    Share,
    Word,
)
from octant.reader_design.study_file.room import Table
from octant.reader_design.study_file.toml_files import toml_file_text, toml_tables

Keys = dict[Word, Any]

OWN = "the study's"
"""Name of a link or reader that is as each study has it."""


class LayoutEntry(Table, frozen=True, kw_only=True):
    """A layout: ``[[layout]]``.

    Parameters
    ----------
    study : Study file with room, tags and mission, relative to the comparison file.
    published_rmse_m : RMSE that was published for it [m], to stand beside the computed ones.
    """

    study: FileName
    published_rmse_m: Distance | None = None


class ControllerEntry(Table, frozen=True, kw_only=True):
    """A controller, and the robot that it drives: ``[[controller]]``.

    Parameters
    ----------
    name : Name in the results.
    mission, robot : Keys of the tables ``[mission]`` and ``[robot]`` that it sets.
    """

    name: Name
    mission: Keys = msgspec.field(default_factory=dict)
    robot: Keys = msgspec.field(default_factory=dict)


class ReaderEntry(Table, frozen=True, kw_only=True):
    """A reader: ``[[reader]]``.

    Parameters
    ----------
    name, reader : Name in the results, and the keys of the table ``[reader]`` that it sets.
    """

    name: Name = OWN
    reader: Keys = msgspec.field(default_factory=dict)


class LinkEntry(Table, frozen=True, kw_only=True):
    """The link of tag and reader: ``[[link]]``.

    Parameters
    ----------
    name, radio, sensor : Name in the results; keys of ``[radio]``, ``[sensor]`` that it sets.
    solver : Keys of ``[solver]`` that it sets, for what navigators are told of the field.
    tag : Keys that it sets in every ``[[tag]]``; an antenna without ``axis`` hangs as usual.
    """

    name: Name = OWN
    radio: Keys = msgspec.field(default_factory=dict)
    sensor: Keys = msgspec.field(default_factory=dict)
    solver: Keys = msgspec.field(default_factory=dict)
    tag: Keys = msgspec.field(default_factory=dict)


class WorldEntry(Table, frozen=True, kw_only=True):
    """How the world differs from what navigators are told: ``[[world]]``.

    Parameters
    ----------
    name, truth : Name in the results, and the keys of the table ``[truth]`` that it sets.
    """

    name: Name = OWN
    truth: Keys = msgspec.field(default_factory=dict)


class Comparison(Table, frozen=True, kw_only=True):
    """The root of a comparison file; every combination of its entries is one cell.

    Parameters
    ----------
    name, seed, runs : Name in the report; seed and number of runs of each cell.
    layouts, controllers : The tables ``[[layout]]`` and ``[[controller]]``.
    links, readers, worlds : The tables ``[[link]]``, ``[[reader]]`` and ``[[world]]``; none: as in
        each study.
    errors : The tables ``[[error]]``: each is swept with every link, reader and controller, beside
        the worlds.
    breaks_below : A sweep of an error ends with the first value at which less than this share of
        the runs reaches every tag [-]; 0: with its last.
    """

    name: Name = "comparison"
    seed: Seed = 1
    runs: Count = 100
    layouts: Annotated[tuple[LayoutEntry, ...], Meta(min_length=1)] = msgspec.field(name="layout")
    links: tuple[LinkEntry, ...] = msgspec.field(default=(LinkEntry(),), name="link")
    readers: tuple[ReaderEntry, ...] = msgspec.field(default=(ReaderEntry(),), name="reader")
    worlds: tuple[WorldEntry, ...] = msgspec.field(default=(WorldEntry(),), name="world")
    errors: tuple[ErrorEntry, ...] = msgspec.field(default=(), name="error")
    breaks_below: Share = 0.5
    controllers: Annotated[tuple[ControllerEntry, ...], Meta(min_length=1)] = msgspec.field(
        name="controller"
    )

    def every_world(self) -> list[tuple[WorldEntry, str, float]]:
        """Return the worlds, then those of the swept errors, with its name and value (else NaN)."""
        worlds = [(world, "", math.nan) for world in self.worlds]
        for entry in self.errors:
            for value, keys in error_truths(entry):
                world = WorldEntry(name=f"{entry.name} {value:g}", truth=keys)
                worlds.append((world, entry.name, value))
        return worlds


def load_comparison(path: str | Path) -> Comparison:
    """Return the comparison of a file, its study files by absolute path.

    Parameters
    ----------
    path : A TOML file.
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
        ("world", given.worlds),
        ("error", given.errors),
    ):
        names = [entry.name for entry in entries]
        for name in names:
            if names.count(name) > 1:
                msg = f"{path}: the name {name!r} of a [[{kind}]] stands twice; rename one of them."
                raise ConfigError(msg)
    for entry in given.errors:
        check_error(entry)
    folder = Path(path).resolve().parent
    layouts = tuple(
        msgspec.structs.replace(layout, study=str(folder / layout.study))
        for layout in given.layouts
    )
    controllers = tuple(
        msgspec.structs.replace(entry, mission=_with_class(entry.mission, folder))
        for entry in given.controllers
    )
    return msgspec.structs.replace(given, layouts=layouts, controllers=controllers)


def _with_class(keys: Keys, folder: Path) -> Keys:
    """Return keys of ``[mission]`` in which a navigator's file is named by absolute path."""
    named = keys.get("navigator")
    if not isinstance(named, str):
        return keys
    return {**keys, "navigator": named_class(named, lambda file: str(folder / file))}
