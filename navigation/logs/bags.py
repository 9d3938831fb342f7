"""Logs out of ROS: bags of ROS 1, rosbag2 folders and MCAP files, topics by their names."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name
from octant.navigation.logs.forms import Columns, TableForm, quaternion_heading_rad
from octant.navigation.logs.records import Log
from octant.navigation.logs.tables import log_of_table
from octant.navigation.logs.text_tables import TextTable

FloatArray = npt.NDArray[np.float64]

BAG_ENDS = (".bag", ".mcap", ".db3")
"""Endings of files that are bags."""

_NANOSECONDS = 1e-9
_DEEPEST = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class BagForm:
    """Which topics of a bag hold what.

    Parameters
    ----------
    readings : Topic of the levels. The form's columns are fields of its messages, with points
        between a field and its own field (``tag.id``); where a message holds a list of readings,
        that list's field stands before them with ``[]``: ``beacons[].rssi``.
    pose : Topic of poses: geometry_msgs Pose, PoseStamped, PoseWithCovarianceStamped, or
        nav_msgs Odometry in the map's frame; None: none.
    odometry : Topic of odometry: the same types, in a frame that drifts; None: none.
    messages : Files of own message types, ``.msg``, where the bag does not hold them.
    """

    readings: str
    pose: str | None = None
    odometry: str | None = None
    messages: tuple[Path, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Track:
    """Poses of a topic in order of time: (m,) [s], (m, 3) [m], [rad] with headings unwrapped."""

    time_s: FloatArray
    poses: FloatArray


def read_bag(path: Path, form: TableForm, bag: BagForm) -> Log:
    """Return the log of a bag: readings with the pose interpolated to their time.

    Times are those of the messages' headers, of the bag's clock where they have none. Readings
    before the first pose and after the last have none. Odometry becomes way and turn since the
    reading before, along the arc between both.

    Parameters
    ----------
    path : The bag: ``.bag``, ``.mcap``, ``.db3`` or the folder of a rosbag2.
    form : Fields and units of the readings.
    bag : Its topics.

    Raises
    ------
    ConfigError
        The package rosbags is not installed (extra ``bags``), the bag cannot be read, a topic or a
        field is not there, or its messages hold no poses.
    """
    wanted = [topic for topic in (bag.readings, bag.pose, bag.odometry) if topic]
    messages = _messages(path, wanted, bag.messages)
    table, time_s = _table(path, form, bag, messages[bag.readings])
    names = {name: name for name in table.header}
    columns = Columns(**names)
    log = log_of_table(table, replace(form, columns=columns, separator=None))
    if "time" in names:
        time_s = log.time_s
    poses = log.poses
    if bag.pose:
        frame_rad = np.array([0.0, 0.0, math.radians(form.heading_zero_deg)])
        found = _at(_track(path, bag.pose, messages[bag.pose]), time_s) + frame_rad
        poses = np.where(np.isnan(poses), found, poses)
    distance_m, turn_rad = log.distance_m, log.turn_rad
    if bag.odometry:
        distance_m, turn_rad = _steps(
            _at(_track(path, bag.odometry, messages[bag.odometry]), time_s)
        )
    return replace(log, time_s=time_s, poses=poses, distance_m=distance_m, turn_rad=turn_rad)


Stamped = tuple[float, Any]
"""Time [s] and message."""


def _messages(
    path: Path, topics: Sequence[str], own_types: Sequence[Path]
) -> Mapping[str, list[Stamped]]:
    """Return the messages of each topic in order of time."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError as exc:
        msg = 'ROS bags are read by rosbags; install it: pip install "octant[bags]".'
        raise ConfigError(msg) from exc
    if not path.exists():
        raise ConfigError(f"{path} does not exist; give a bag, an .mcap file or a rosbag2 folder.")
    store = get_typestore(Stores.LATEST)
    for file in own_types:
        store.register(
            get_types_from_msg(
                file.read_text("utf-8"), f"{file.parent.parent.name}/msg/{file.stem}"
            )
        )
    found: dict[str, list[Stamped]] = {topic: [] for topic in topics}
    try:
        with AnyReader([path], default_typestore=store) as reader:
            connections = [c for c in reader.connections if c.topic in found]
            for topic in topics:
                if topic not in {c.topic for c in connections}:
                    _refuse_topic(path, topic, sorted({c.topic for c in reader.connections}))
            for connection, stamp, data in reader.messages(connections=connections):
                message = reader.deserialize(data, connection.msgtype)
                found[connection.topic].append((_time_s(message, stamp), message))
    except (AnyReaderError, KeyError, OSError, ValueError) as exc:
        if isinstance(exc, ConfigError):
            raise
        msg = f"{path} cannot be read as a bag ({exc}); give a whole bag, and its own .msg files."
        raise ConfigError(msg) from exc
    return {topic: sorted(some, key=lambda one: one[0]) for topic, some in found.items()}


def _refuse_topic(path: Path, topic: str, known: Sequence[str]) -> NoReturn:
    near = nearest_name(topic, known)
    hint = f"did you mean {near!r} (it has {', '.join(known)})?" if near else "it has none."
    raise ConfigError(f"{path} has no topic {topic!r}; {hint}")


def _time_s(message: Any, stamp: int) -> float:  # noqa: ANN401  any type of message
    header = getattr(getattr(message, "header", None), "stamp", None)
    if header is None or (header.sec == 0 and header.nanosec == 0):
        return stamp * _NANOSECONDS
    return float(header.sec) + float(header.nanosec) * _NANOSECONDS


def _table(
    path: Path, form: TableForm, bag: BagForm, messages: Sequence[Stamped]
) -> tuple[TextTable, FloatArray]:
    """Return readings as a table whose columns have the names of `Columns`, and their times [s]."""
    given = {f.name: getattr(form.columns, f.name) for f in fields(Columns)}
    names = {name: where for name, where in given.items() if where}
    if "rss" not in names:
        msg = f"{path}: no field of {bag.readings} is named as the level; give columns.rss."
        raise ConfigError(msg)
    lists = {where.split("[]")[0] for where in names.values() if "[]" in where}
    if len(lists) > 1:
        msg = f"{path}: fields of the lists {sorted(lists)} are named, but one list holds readings."
        raise ConfigError(msg)
    rows, times = [], []
    numbered = "antenna" if "id" in names else "id"
    if lists and numbered not in names and names["rss"].endswith("[]"):
        names[numbered] = "[]"
    for time_s, message in messages:
        items = _field(path, message, next(iter(lists))) if lists else [None]
        for number, item in enumerate(items, 1):
            rows.append(
                tuple(_cell(path, message, item, number, where) for where in names.values())
            )
            times.append(time_s)
    if not rows:
        raise ConfigError(f"{path}: the topic {bag.readings} holds no readings; name another.")
    if "id" not in names:
        names["id"] = ""
        rows = [(*row, bag.readings) for row in rows]
    table = TextTable(
        path=path,
        header=tuple(names),
        columns=tuple(zip(*rows, strict=True)),
        lines=tuple(range(1, len(rows) + 1)),
        header_line=0,
    )
    return table, np.array(times)


def _cell(path: Path, message: Any, item: Any, number: int, where: str) -> str:  # noqa: ANN401
    if where == "[]":
        return str(number)
    before, in_list, after = where.partition("[]")
    value = _field(path, item, after.lstrip(".")) if in_list else _field(path, message, before)
    if isinstance(value, str | int):
        return str(value)
    level = float(value)
    return "" if math.isnan(level) else repr(level)


def _field(path: Path, message: Any, where: str) -> Any:  # noqa: ANN401  any type of field
    value = message
    for name in filter(None, where.split(".")):
        if not hasattr(value, name):
            known = [n for n in getattr(value, "__dataclass_fields__", {}) if not n.startswith("_")]
            msg = f"{path}: messages have no field {where!r}; at {name!r} there are {known}."
            raise ConfigError(msg)
        value = getattr(value, name)
    return value


def _track(path: Path, topic: str, messages: Sequence[Stamped]) -> _Track:
    rows = []
    for _, message in messages:
        pose = message
        for _ in range(_DEEPEST):
            if hasattr(pose, "position") or not hasattr(pose, "pose"):
                break
            pose = pose.pose
        if not hasattr(pose, "position"):
            kind = type(message).__name__.replace("__", "/")
            msg = f"{path}: {topic} holds {kind}, but poses or nav_msgs Odometry are needed."
            raise ConfigError(msg)
        q, place = pose.orientation, pose.position
        rows.append((place.x, place.y, q.x, q.y, q.z, q.w))
    if not rows:
        raise ConfigError(f"{path}: the topic {topic} is empty; name another, or none.")
    x, y, *parts = np.array(rows, dtype=np.float64).T
    heading = quaternion_heading_rad(x=parts[0], y=parts[1], z=parts[2], w=parts[3])
    poses = np.column_stack([x, y, np.unwrap(np.nan_to_num(heading))])
    return _Track(time_s=np.array([time for time, _ in messages]), poses=poses)


def _at(track: _Track, time_s: FloatArray) -> FloatArray:
    """Return poses at some times, between those of a track, (n, 3) [m], [rad]; NaN outside."""
    return np.column_stack(
        [np.interp(time_s, track.time_s, column, np.nan, np.nan) for column in track.poses.T]
    )


def _steps(poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return way along an arc [m] and turn [rad] from each pose to the next, (n,) each; 0 first."""
    step = np.diff(poses, axis=0, prepend=poses[:1])
    middle = poses[:, 2] - 0.5 * step[:, 2]
    chord = step[:, 0] * np.cos(middle) + step[:, 1] * np.sin(middle)
    return chord / np.sinc(step[:, 2] / (2.0 * np.pi)), step[:, 2]
