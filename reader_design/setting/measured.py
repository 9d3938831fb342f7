"""A study's measured log: read as its table says, laid onto the room, anchors matched with tags."""

from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from octant.geometries.errors import ConfigError, NavigationError
from octant.geometries.names import nearest_name
from octant.geometries.scene import Scene
from octant.navigation.logs.anchors import read_anchors
from octant.navigation.logs.bags import BAG_ENDS, BagForm, read_bag
from octant.navigation.logs.folders import FolderForm, read_folder
from octant.navigation.logs.forms import Columns, TableForm
from octant.navigation.logs.frames import axis_frames, in_room
from octant.navigation.logs.log_csv import LOG_COLUMNS, read_log
from octant.navigation.logs.records import NO_SOURCE, Log, of_ids, readings, taken
from octant.navigation.logs.tables import read_table
from octant.navigation.logs.text_tables import read_text_table
from octant.reader_design.study_file.loading import vary
from octant.reader_design.study_file.log import Log as LogTable
from octant.reader_design.study_file.log import LogFormat, log_frame
from octant.reader_design.study_file.schema import Study

_MOST_NAMED = 5
_OCTANT_NAMES = (
    *("time", "x", "y", "heading", "distance", "turn"),
    *("id", "antenna", "rss", "frequency"),
)
_MOSTLY = 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredLog:
    """A log in the room's frame, whose sources are tags of the study.

    Attributes
    ----------
    log : The log, in [m], [rad], [s], [dBm].
    file : Where it comes from.
    notes : What was left out and why, a sentence each.
    """

    log: Log
    file: Path
    notes: tuple[str, ...]


def with_log(study: Study) -> Study:
    """Return a study with what its table ``[log]`` adds: anchors as tags, the antenna's height [m].

    Parameters
    ----------
    study : A loaded study; without the table it stays as it is.
    """
    table = study.log
    if table is None:
        return study
    values: dict[str, object] = {}
    if table.anchors is not None:
        known = {tag.id for tag in study.tags}
        anchors = read_anchors(
            Path(table.anchors), _form(table), log_frame(table), height_m=table.anchor_height_m
        )
        more = [
            {"id": one.id, "position_m": list(one.position_m), "antenna": table.anchor_antenna}
            for one in anchors
            if one.id not in known
        ]
        values["tag"] = [*(msgspec.to_builtins(tag) for tag in study.tags), *more]
    if table.height_m is not None:
        values["reader.height_m"] = table.height_m
    return study if not values else vary(study, values)


def measured_log(
    study: Study, scene: Scene, *, file: Path | None = None, motion: bool = False
) -> MeasuredLog:
    """Return the log that a study names, in its room's frame, with sources that are its tags.

    Parameters
    ----------
    study : From `with_log`.
    scene : Its room; poses outside it are treated as ``log.outside`` says.
    file : The log in place of ``log.file``; read in the same way.
    motion : Keep rows that hold no reading, for their odometry.

    Raises
    ------
    ConfigError
        No file is named, it cannot be read as the table says, it names tags that the study lacks,
        or too many of its poses lie outside the room.
    """
    table = study.log or LogTable()
    given = table.file if file is None else file
    if given is None:
        msg = "no log is named; give --log FILE, or log.file in the study."
        raise ConfigError(msg)
    path = Path(given)
    if not path.exists():
        raise ConfigError(f"{path} does not exist; give the log as --log FILE, or as log.file.")
    known = tuple(tag.id for tag in study.tags)
    try:
        log = in_room(_read(path, table, study, known), log_frame(table))
        if not np.any(log.sources != NO_SOURCE):
            msg = f"{path} holds no reading at all; give a log with levels of the study's tags."
            raise ConfigError(msg)
    except NavigationError as exc:
        raise ConfigError(f"{path}: {exc}") from exc
    notes: list[str] = []
    log = _matched(log, path, table, known, notes)
    log = _inside(log, path, study, scene, notes)
    if not motion:
        log = readings(log)
    return MeasuredLog(log=log, file=path, notes=tuple(notes))


def _read(path: Path, table: LogTable, study: Study, known: tuple[str, ...]) -> Log:
    kind = _kind(path, table)
    threshold = table.threshold_dbm
    threshold = study.sensor.sensitivity_dbm if threshold is None else threshold
    given = _form(table)
    if kind == "octant" and replace(given, ids={}) == TableForm(columns=Columns()):
        log = read_log(path, threshold_dbm=threshold)
        return replace(log, ids=tuple(table.ids.get(name, name) for name in log.ids))
    if kind == "octant":  # its columns, but in other units
        there = read_text_table(path, separator=given.separator).header
        names = dict(zip(_OCTANT_NAMES, LOG_COLUMNS, strict=True))
        columns = Columns(**{key: name for key, name in names.items() if name in there})
        given = replace(given, columns=columns)
    only = frozenset(known) if table.unknown_ids == "leave_out" else None
    form = replace(given, threshold_dbm=threshold, only=only)
    if kind in {"octant", "table"}:
        return read_table(path, form)
    if kind == "folder":
        if table.names is None:
            msg = f"{path} is a folder; say by log.names how its files are called, or give a file."
            raise ConfigError(msg)
        places = None if table.places is None else Path(table.places)
        return read_folder(path, form, FolderForm(name=table.names, places=places))
    if table.readings_topic is None:
        msg = f"{path} is a bag; name the topic of the levels by log.readings_topic."
        raise ConfigError(msg)
    bag = BagForm(
        readings=table.readings_topic,
        pose=table.pose_topic,
        odometry=table.odometry_topic,
        messages=tuple(Path(name) for name in table.messages),
    )
    return read_bag(path, form, bag)


def _kind(path: Path, table: LogTable) -> LogFormat:
    if table.format is not None:
        return table.format
    if path.suffix.casefold() in BAG_ENDS or (path / "metadata.yaml").is_file():
        return "bag"
    if path.is_dir():
        return "folder"
    return "octant" if table.columns == LogTable().columns else "table"


def _form(table: LogTable) -> TableForm:
    return TableForm(
        columns=Columns(**msgspec.structs.asdict(table.columns)),
        time_unit=table.time_unit,
        length_unit=table.length_unit,
        angle_unit=table.angle_unit,
        rss_unit=table.rss_unit,
        heading_zero_deg=table.heading_zero_deg,
        clockwise=table.clockwise,
        not_heard=table.not_heard,
        empty=table.empty,
        ids=table.ids,
        separator=table.separator,
        header=table.header,
    )


def _matched(
    log: Log, path: Path, table: LogTable, known: tuple[str, ...], notes: list[str]
) -> Log:
    """Return the log with the study's tags as its sources, in their order."""
    unknown = [name for name in log.ids if name not in known]
    if not unknown:
        return of_ids(log, known)
    shown = ", ".join(map(repr, unknown[:_MOST_NAMED]))
    shown += f" and {len(unknown) - _MOST_NAMED} more" if len(unknown) > _MOST_NAMED else ""
    near = nearest_name(unknown[0], known, least_likeness=0.5)
    hint = f"did you mean {near!r}?" if near else f"its tags are {', '.join(known) or 'none'}."
    if table.unknown_ids == "refuse":
        msg = (
            f"{path} has readings of {shown}, but the study has no such [[tag]]; add it, name it "
            f'in [log.ids], or set log.unknown_ids = "leave_out"; {hint}'
        )
        raise ConfigError(msg)
    lost = int(np.sum(np.isin(log.sources, [log.ids.index(name) for name in unknown])))
    matched = of_ids(log, known)
    if not np.any(matched.sources != NO_SOURCE):
        msg = f"{path} has readings of {shown} only, but the study has no such [[tag]]; {hint}"
        raise ConfigError(msg)
    notes.append(f"{lost} readings of {shown}, which the study has no [[tag]] for, are left out.")
    return matched


def _inside(log: Log, path: Path, study: Study, scene: Scene, notes: list[str]) -> Log:
    """Return the log without poses outside the room, if they are few, or refuse it."""
    table, height_m = study.log or LogTable(), study.reader.height_m
    if table.outside == "keep" or not scene.has_room:
        return log
    placed = np.isfinite(log.poses[:, :2]).all(axis=1)
    places = log.poses[placed, :2]
    if not len(places):
        return log
    outside = np.zeros(len(log), dtype=bool)
    outside[placed] = ~_in_room(scene, places, height_m)
    count = len(np.unique(log.poses[outside, :2], axis=0)) if outside.any() else 0
    poses = len(np.unique(places, axis=0))
    if not count:
        return log
    low, high = scene.bounds_m[0], scene.bounds_m[1]
    room = f"x from {low[0]:g} to {high[0]:g} m and y from {low[1]:g} to {high[1]:g} m"
    x, y = log.poses[outside][0, :2]
    what = f"{count} of {poses} poses of {path} lie outside the room, the first at {x:g}, {y:g} m"
    if table.outside == "refuse" and count > table.outside_share * poses:
        hint = _hint(scene, places, height_m, moved=not log_frame(table).same)
        msg = f'{what} (the room has {room}); {hint}, or set log.outside = "leave_out".'
        raise ConfigError(msg)
    notes.append(f"{what}; readings there are left out.")
    return taken(log, ~outside)


def _in_room(scene: Scene, places: np.ndarray, height_m: float) -> np.ndarray:
    z = np.full(len(places), scene.floor_height_m + height_m)
    return np.asarray(scene.inside_room(np.column_stack([places, z])))


def _hint(scene: Scene, places: np.ndarray, height_m: float, *, moved: bool) -> str:
    """Return what probably is the matter with poses outside the room."""
    low, high = scene.bounds_m[:, :2]
    for name, frame in axis_frames(low, high).items():
        if np.mean(_in_room(scene, frame.places_m(places), height_m)) >= _MOSTLY:
            how = f": try {frame.text()} in [log]" if not moved else ""
            return f"{name} nearly all lie inside{how}"
    for unit, metres in (("cm", 0.01), ("mm", 0.001), ("ft", 0.3048)):
        if np.mean(_in_room(scene, metres * places, height_m)) >= _MOSTLY:
            return f'in {unit} nearly all lie inside: try log.length_unit = "{unit}"'
    return "give log.points_log_m and log.points_room_m, three points in both coordinates"
