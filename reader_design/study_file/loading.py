"""Reading a study file and writing it back with every default resolved."""

import itertools
import math
import os
from collections.abc import Callable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec

from octant.em.antennas.kinds import PATCHES
from octant.geometries.errors import ConfigError, InfeasibleDesignError
from octant.navigation.navigators.loading import is_file
from octant.reader_design.study_file.checks import TAG_ANTENNAS, check_study
from octant.reader_design.study_file.errors import (
    path_text,
    sentence,
    unit_of,
    unknown_name,
    value_text,
)
from octant.reader_design.study_file.materials import room_material
from octant.reader_design.study_file.reader_metal import FileBody
from octant.reader_design.study_file.room import MeshObject, Room, RoomMesh, RoomObject
from octant.reader_design.study_file.schema import Layout, Study, Tag
from octant.reader_design.study_file.sweep import expanded, parameter_key, put, taken
from octant.reader_design.study_file.toml import toml_text
from octant.reader_design.study_file.toml_files import toml_file_text, toml_tables

replace = msgspec.structs.replace

BUILT_IN = ("office", "thesis", "track", "dock", "demo")
"""Names of the studies that come with Octant; a verb takes one where it takes a file."""
LAYOUT_TABLES = ("radio", "tag", "mission", "robot", "sensor", "solver", "rfid")
"""Tables of which a layout may change keys."""
LAYOUT_KEPT = ("tag.id", "mission.tags")
"""Keys of these that it may not change: results list the same visits in all rooms."""
MOST_TRIED = 1000
"""Combinations in which a swept value is tried before it is refused [-]."""


def load_study(path: str | Path | None = None, *, built_in: str = "office") -> Study:
    """Return the study of a file, checked, with every default and every path resolved.

    What is missing, unknown, wrong or contradicts another key is a ConfigError with the key path.

    Parameters
    ----------
    path : A TOML file, or the name of one of the `BUILT_IN` studies; a file of such a name is meant
        only by a path with a folder or an ending. None: a built-in study.
    built_in : Which.
    """
    name = built_in.removesuffix("_study") if path is None else str(path)
    if name in BUILT_IN:
        folder = Path(str(resources.files(__package__)))
        text = (folder / f"{name}_study.toml").read_text("utf-8")
        return parse_study(text, source=f"the built-in study {name}", directory=folder)
    if path is None:
        raise ConfigError(unknown_name("built_in", name, BUILT_IN, what="built-in study"))
    text = toml_file_text(path, what="study")
    return parse_study(text, source=str(path), directory=Path(path).resolve().parent)


def parse_study(text: str, *, source: str, directory: Path) -> Study:
    """Return the study that TOML text describes, checked and resolved.

    Parameters
    ----------
    text : TOML.
    source : Name of the file in messages.
    directory : Where relative mesh files are looked for.
    """
    return study_of_tables(toml_tables(text, source=source), source=source, directory=directory)


def study_of_tables(raw: dict[str, Any], *, source: str, directory: Path) -> Study:
    """Return the study that plain tables describe, as those of a study file, checked and resolved.

    Parameters
    ----------
    raw : Tables with the keys of a study file: text, numbers, booleans, lists and dicts.
    source : Name of what holds them in messages.
    directory : Where relative mesh files are looked for.
    """
    try:
        _refuse_infinite(raw, ())
        try:
            study = msgspec.convert(raw, Study)
        except msgspec.ValidationError as exc:
            raise ConfigError(sentence(exc, raw, Study)) from exc
        check_study(study)
        whole = _with_sweep(resolved(study, directory=directory), directory)
        for layout in whole.layouts:
            layout_study(whole, layout)
    except ConfigError as exc:
        msg = f"{source}: {exc}"
        raise ConfigError(msg) from exc
    return whole


def layout_study(study: Study, layout: Layout | None) -> Study:
    """Return a study with the other values that hold in one of its layouts, checked.

    Parameters
    ----------
    study, layout : The study; one of its layouts, None: its own room.
    """
    if layout is None or not layout.values:
        return study
    where = f"layout {layout.name!r}: values"
    for key in layout.values:
        table, _, below = key.partition(".")
        if table not in LAYOUT_TABLES or not below or key in LAYOUT_KEPT:
            msg = (
                f"{where} names {key!r}, but a layout may change keys of "
                f'{", ".join(LAYOUT_TABLES)} by their path, such as "mission.navigator", and not '
                f"{' and '.join(LAYOUT_KEPT)}."
            )
            raise ConfigError(msg)
    hung = {"tag.axis": None} if "tag.antenna" in layout.values else {}
    try:
        other = vary(study, {**hung, **layout.values})
    except ConfigError as exc:
        msg = f"{where}: {exc}"
        raise ConfigError(msg) from exc
    return replace(other, sweep=study.sweep)


def to_toml(study: Study, *, relative_to: Path | None = None) -> str:
    """Return a study as TOML text, every default written out; `load_study` reads back an equal one.

    Parameters
    ----------
    study : The study [m], [Hz], [deg].
    relative_to : Folder in which the text will lie: mesh files are named relative to it; None names
        them by absolute path.
    """
    base = None if relative_to is None else relative_to.resolve()

    def named(file: str) -> str:
        return file if base is None else os.path.relpath(file, base)

    tables = msgspec.to_builtins(_with_files(study, named, named, axes=False))
    tables["sweep"] = {key: _named(values, named) for key, values in expanded(study.sweep).items()}
    for room in [tables["room"], *(e["room"] for e in tables["layout"] if e["room"])]:
        _tidy_room(room)
    _tidy_objects(tables["reader"]["object"])
    for layout in tables["layout"]:
        _tidy_objects(layout["object"])
        layout["values"] = layout["values"] or None
    tables["reader"]["object"] = tables["reader"]["object"] or None
    if tables["track"]:
        tables["track"]["trajectory"] = tables["track"]["trajectory"] or None
    if tables["tolerance"]:
        tables["tolerance"]["rival"] = tables["tolerance"]["rival"] or None
    empty = [key for key in ("tag", "layout") if not tables[key]]
    return toml_text({key: value for key, value in tables.items() if key not in empty})


def resolved(study: Study, *, directory: Path) -> Study:
    """Return a study with the defaults that depend on other keys, and its files, made explicit.

    The ranges of the sweep, the map's height, the room's material, the tags' axes; mesh and pattern
    files as absolute paths. What depends on a swept key stays open.

    Parameters
    ----------
    study : A checked study.
    directory : Where relative mesh files are looked for.
    """

    def absolute(file: str) -> str:
        full = Path(os.path.normpath(directory / file))
        if not full.is_file():
            msg = f"the file {file!r} does not exist in {directory}; give an existing file."
            raise ConfigError(msg)
        return str(full)

    def absolute_folder(folder: str) -> str:
        full = Path(os.path.normpath(directory / folder))
        if not full.is_dir():
            msg = f"the folder {folder!r} does not exist in {directory}; give an existing folder."
            raise ConfigError(msg)
        return str(full)

    sweep = expanded(study.sweep)
    height_m = study.map.height_m
    if not {"height_m", "reader.height_m", "reader"} & set(sweep):
        height_m = height_m or study.reader.height_m
    return replace(
        _with_files(study, absolute, absolute_folder, axes=not {"tag", "tag.antenna"} & set(sweep)),
        sweep=dict(sweep),
        map=replace(study.map, height_m=height_m),
    )


def vary(
    study: Study, values: Mapping[str, Any], *, directory: Path = Path("/"), shapes: bool = True
) -> Study:
    """Return a study, checked and resolved, with other values in some places and without a sweep.

    Parameters
    ----------
    study : The study.
    values : Value by parameter, named as in ``[sweep]``, or by the dotted path of any other key
        such as ``mission.runs``; in the unit of the key ([m], [Hz], ...).
    directory : Where relative files among the values are looked for; those of a loaded study are
        absolute.
    shapes : As in `check_study`.
    """
    tables = put(study, values)
    try:
        variant = msgspec.convert(tables, Study)
    except msgspec.ValidationError as exc:
        raise ConfigError(sentence(exc, tables, Study)) from exc
    check_study(variant, shapes=shapes)
    return resolved(variant, directory=directory)


def _with_sweep(study: Study, directory: Path) -> Study:
    """Return a study whose swept values have been tried one by one; files as absolute paths."""
    lists = expanded(study.sweep)
    tried: dict[str, tuple[Any, ...]] = {}
    for name, values in lists.items():
        tried[name] = tuple(
            _tried(study, lists, name, place, directory) for place in range(len(values))
        )
        seen: set[str] = set()
        for place, value in enumerate(tried[name]):
            text = repr(value)
            if text in seen:
                msg = (
                    f"{parameter_key(name)}[{place}] is {value_text((name,), value)} a second "
                    "time; name every value once."
                )
                raise ConfigError(msg)
            seen.add(text)
    return replace(study, sweep=dict(tried))


def _tried(
    study: Study, lists: Mapping[str, tuple[Any, ...]], name: str, place: int, directory: Path
) -> Any:  # noqa: ANN401
    """Return one value of a sweep as its key holds it, if any combination can have it.

    A reader that cannot be built is no mistake in the file, but a cell with that as its result.
    """
    others = [key for key in lists if key != name]
    refusal: ConfigError | None = None
    combinations = itertools.product(*(lists[key] for key in others))
    for combination in itertools.chain([()], itertools.islice(combinations, MOST_TRIED)):
        values = {name: lists[name][place], **dict(zip(others, combination, strict=False))}
        try:
            variant = vary(study, values, directory=directory, shapes=False)
        except ConfigError as exc:
            refusal = refusal or exc
            if isinstance(exc.__cause__, msgspec.ValidationError):
                break
        else:
            return taken(msgspec.to_builtins(variant), name)
    if isinstance(refusal, InfeasibleDesignError):
        tables = put(study, {name: lists[name][place]})
        return taken(msgspec.to_builtins(msgspec.convert(tables, Study)), name)
    msg = f"{parameter_key(name)}[{place}]: {refusal}"
    raise ConfigError(msg) from refusal


def _refuse_infinite(value: Any, path: tuple[str | int, ...]) -> None:  # noqa: ANN401
    if isinstance(value, dict):
        for key, item in value.items():
            _refuse_infinite(item, (*path, key))
    elif isinstance(value, list):
        for i, item in enumerate(value):
            _refuse_infinite(item, (*path, i))
    elif isinstance(value, float) and not math.isfinite(value):
        unit = unit_of(path)
        msg = (
            f"{path_text(path)} is {value}{' ' if unit else ''}{unit}, but a finite number is "
            "needed."
        )
        raise ConfigError(msg)


def _with_files(study: Study, convert: Any, folder: Any, *, axes: bool = True) -> Study:  # noqa: ANN401
    """Return a study with names of files and folders converted, str to str, and tags' axes."""

    def existing(name: str) -> str:
        """Return a file's name, or a folder's where there is one."""
        try:
            return str(convert(name))
        except ConfigError:
            return str(folder(name))

    def folders(names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(folder(name) for name in names)

    def of_objects(objects: tuple[RoomObject, ...]) -> tuple[RoomObject, ...]:
        return tuple(
            replace(
                o,
                file=convert(o.file),
                resource_path=folders(o.resource_path),
            )
            if isinstance(o, MeshObject)
            else o
            for o in objects
        )

    def of_room(room: Room) -> Room:
        mesh: str | tuple[RoomMesh, ...] | None = room.mesh
        if isinstance(mesh, str):
            mesh = convert(mesh)
        elif mesh is not None:
            mesh = tuple(
                replace(
                    m,
                    file=convert(m.file),
                    resource_path=folders(m.resource_path),
                )
                for m in mesh
            )
        return replace(
            room,
            mesh=mesh,
            resource_path=folders(room.resource_path),
            material=room_material(room),
            objects=of_objects(room.objects),
        )

    def of_layout(layout: Layout) -> Layout:
        room = None if layout.room is None else of_room(layout.room)
        return replace(layout, room=room, objects=of_objects(layout.objects))

    def of_tag(tag: Tag) -> Tag:
        known = tag.antenna in TAG_ANTENNAS
        down = (0.0, 0.0, -1.0 if tag.antenna in PATCHES else 1.0)
        antenna = tag.antenna if known else convert(tag.antenna)
        return replace(tag, antenna=antenna, axis=tag.axis or (down if axes else None))

    layouts = tuple(of_layout(layout) for layout in study.layouts)
    patterns = tuple(convert(file) for file in study.reader.pattern_files)
    reader = replace(
        study.reader,
        pattern_files=patterns,
        objects=of_objects(study.reader.objects),
        bodies=tuple(
            replace(body, file=convert(body.file)) if isinstance(body, FileBody) else body
            for body in study.reader.bodies
        ),
    )
    if reader.line is not None:
        line = reader.line
        one = {key: getattr(line, key) for key in ("load_file", "off_file") if getattr(line, key)}
        files = {key: convert(file) for key, file in one.items()}
        networks = tuple(convert(file) for file in line.network_files)
        reader = replace(reader, line=replace(line, network_files=networks, **files))
    tags = tuple(of_tag(tag) for tag in study.tags)
    track, rfid, mission, log = study.track, study.rfid, study.mission, study.log
    if log is not None:
        named = {key: getattr(log, key) for key in ("anchors", "places") if getattr(log, key)}
        anchored = log.anchor_antenna in TAG_ANTENNAS
        log = replace(
            log,
            **{key: convert(file) for key, file in named.items()},
            file=log.file and existing(log.file),
            anchor_antenna=log.anchor_antenna if anchored else convert(log.anchor_antenna),
            messages=tuple(convert(file) for file in log.messages),
        )
    if mission is not None:
        learned = mission.map.learned and convert(mission.map.learned)
        mission = replace(
            mission,
            navigator=named_class(mission.navigator, convert),
            map=replace(mission.map, learned=learned),
        )
    if track is not None and track.rss_samples is not None:
        track = replace(track, rss_samples=convert(track.rss_samples))
    if rfid is not None and rfid.transmitter_antenna not in TAG_ANTENNAS:
        rfid = replace(rfid, transmitter_antenna=convert(rfid.transmitter_antenna))
    return replace(
        study,
        room=of_room(study.room),
        tags=tags,
        layouts=layouts,
        reader=reader,
        track=track,
        rfid=rfid,
        mission=mission,
        log=log,
    )


def named_class(text: str, convert: Callable[[str], str]) -> str:
    """Return a class's name with its file, if it stands in one, named anew.

    Parameters
    ----------
    text, convert : ``FILE.py:Class``, or any other; makes another name of the file.
    """
    where, colon, name = text.rpartition(":")
    return f"{convert(where)}{colon}{name}" if is_file(where) else text


def _named(value: Any, named: Any) -> Any:  # noqa: ANN401  named: str -> str
    """Return a swept value in which files, which stand there by absolute path, are named anew."""
    if isinstance(value, dict):
        return {key: _named(item, named) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_named(item, named) for item in value]
    return named(value) if isinstance(value, str) and Path(value).is_absolute() else value


def _tidy_objects(items: Any) -> None:  # noqa: ANN401  a list of tables
    for item in items or ():
        for key in ("materials", "resource_path"):
            if key in item:
                item[key] = item[key] or None


def _tidy_room(room: dict[str, Any]) -> None:
    _tidy_objects(room["object"])
    for key in ("materials", "object", "doorway", "resource_path"):
        room[key] = room[key] or None
    _tidy_objects(room["mesh"] if isinstance(room["mesh"], list | tuple) else ())
    room["free_space"] = room["free_space"] or None
