"""The table of a study file that says where a log of readings is, and how to read it."""

import math
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.logs.forms import Empty
from octant.navigation.logs.frames import Frame, fitted_frame
from octant.navigation.logs.units import AngleUnit, LengthUnit, LevelUnit, TimeUnit
from octant.reader_design.study_file.quantities import (
    Angle,
    Coordinate,
    DistanceOrZero,
    FileName,
    Level,
    Number,
    Share,
    Spot,
    Word,
)
from octant.reader_design.study_file.room import Table

LogFormat = Literal["octant", "table", "folder", "bag"]
"""Shapes of logs."""


class LogColumns(Table, frozen=True, kw_only=True):
    """Names of a foreign log's columns, or of the fields of messages: table ``[log.columns]``.

    Parameters
    ----------
    time, x, y, heading : When and where the robot was.
    qx, qy, qz, qw : Its orientation as a quaternion, in place of ``heading``.
    distance, turn : Odometry since the row before.
    id, antenna : Tag or anchor; number of the robot's antenna, from 1.
    rss : Level. With ``{id}`` in it, and ``{antenna}`` if need be, a pattern of the names of many
        columns, one a tag or anchor: ``rssi_{id}``; ``{id}`` alone is every column that has no
        other name here.
    frequency : Carrier frequency [Hz].
    """

    time: Word | None = None
    x: Word | None = None
    y: Word | None = None
    heading: Word | None = None
    qx: Word | None = None
    qy: Word | None = None
    qz: Word | None = None
    qw: Word | None = None
    distance: Word | None = None
    turn: Word | None = None
    id: Word | None = None
    antenna: Word | None = None
    rss: Word | None = None
    frequency: Word | None = None


class Log(Table, frozen=True, kw_only=True):
    """A log of readings that others have measured: table ``[log]``.

    Parameters
    ----------
    file : The log: a file, or the folder of a rosbag2 or of one file a place. None: ``--log`` names
        it.
    format : ``octant``: the CSV of `octant simulate-log`; ``table``: any table of text, its columns
        named in ``[log.columns]``; ``folder``: such tables, one file a place; ``bag``: a bag of ROS
        1 or 2, or an MCAP file. None: ``bag`` by the file's ending, else ``folder``, ``table`` or
        ``octant`` by which of their keys are given.
    columns : Names of its columns.
    separator : Between cells: ``comma``, ``semicolon``, ``tab``, ``bar``, ``space``; None: found.
    header : Whether the first line names the columns; else they are called "1", "2" and so on.
    time_unit : ``s``, ``ms``, ``us``, ``ns``, or ``iso`` for dates and times.
    length_unit : ``m``, ``cm``, ``mm``, ``ft`` or ``in``.
    angle_unit : ``deg``, ``rad`` or ``turn``.
    rss_unit : ``dbm``; ``minus_dbm``, levels without their sign; or a power in ``w``, ``mw``,
        ``uw``, ``nw``.
    heading_zero_deg : Direction of heading 0, counter-clockwise from the log's +x [deg]; of a
        compass 90, where +y is north.
    clockwise : Whether headings and turns grow clockwise, as a compass counts.
    not_heard : Numbers that say that a source was not heard, in the log's unit: 100 often.
    empty : What an empty level says: ``not_heard``, or that there was ``no_reading``.
    threshold_dbm : Level below which the receiver hears nothing [dBm]; None: that of
        ``sensor.sensitivity_dbm``, or unknown.
    ids : Tag of the study by the anchor's name in the log; others have one name in both.
    unknown_ids : Of tags that the study lacks: ``refuse`` the log, or ``leave_out`` their readings.
    outside : Of poses outside the room: ``refuse`` the log where they are more than
        ``outside_share``, ``leave_out`` their readings, or ``keep`` them.
    outside_share : Share of poses outside the room that is left out as error of the positions [-].
    turn_deg, shift_m, mirrored : How the log's coordinates lie in the room: mirrored (y becomes
        -y), then turned counter-clockwise [deg], then shifted [m].
    points_log_m, points_room_m : Two or more reference points in the log's coordinates, in metres,
        and in the room's [m], from which turn, shift and mirror are fitted; three tell whether the
        log is mirrored.
    height_m : Height of the robot's antenna above the floor in this log [m]; None: that of the
        reader.
    anchors : A table of anchors (id, x, y, z) in the log's coordinates, which become tags of the
        study besides its own. None: the study's tags only.
    anchor_height_m : Height coordinate of anchors that have none there [m].
    anchor_antenna : Their antenna, as in ``[[tag]]``.
    names : Pattern of the names of a folder's files, such as ``room1_{x}_{y}.csv`` or
        ``{place}/{id}.csv``: {x}, {y}, {heading}, {place}, {id}, {antenna} and {any} stand for
        what they are.
    places : A table of the places (place, x, y, heading) of a folder's files.
    readings_topic, pose_topic, odometry_topic : Topics of a bag: levels; poses in the log's
        coordinates; odometry.
    messages : Files of own types of messages, ``PACKAGE/msg/Type.msg``, where a bag lacks them.
    """

    file: FileName | None = None
    format: LogFormat | None = None
    columns: LogColumns = LogColumns()
    separator: Literal["comma", "semicolon", "tab", "bar", "space"] | None = None
    header: bool = True
    time_unit: TimeUnit = "s"
    length_unit: LengthUnit = "m"
    angle_unit: AngleUnit = "deg"
    rss_unit: LevelUnit = "dbm"
    heading_zero_deg: Angle = 0.0
    clockwise: bool = False
    not_heard: Annotated[tuple[Number, ...], Meta(max_length=100)] = ()
    empty: Empty = "not_heard"
    threshold_dbm: Level | None = None
    ids: dict[Word, Word] = {}  # noqa: RUF012  msgspec gives every table one of its own
    unknown_ids: Literal["refuse", "leave_out"] = "refuse"
    outside: Literal["refuse", "leave_out", "keep"] = "refuse"
    outside_share: Share = 0.01
    turn_deg: Angle = 0.0
    shift_m: Spot = (0.0, 0.0)
    mirrored: bool | None = None
    points_log_m: Annotated[tuple[Spot, ...], Meta(max_length=1000)] = ()
    points_room_m: Annotated[tuple[Spot, ...], Meta(max_length=1000)] = ()
    height_m: DistanceOrZero | None = None
    anchors: FileName | None = None
    anchor_height_m: Coordinate | None = None
    anchor_antenna: FileName = "dipole"
    names: Word | None = None
    places: FileName | None = None
    readings_topic: Word | None = None
    pose_topic: Word | None = None
    odometry_topic: Word | None = None
    messages: tuple[FileName, ...] = ()


def check_log(log: Log) -> None:
    """Refuse keys of the table that contradict each other.

    Parameters
    ----------
    log : A table whose single values are within their ranges.
    """
    points = log.points_log_m, log.points_room_m
    if len(points[0]) != len(points[1]):
        msg = (
            f"log.points_log_m has {len(points[0])} points and log.points_room_m {len(points[1])}, "
            "but they are the same points in two coordinates; give each in both."
        )
        raise ConfigError(msg)
    if points[0] and (log.turn_deg or any(log.shift_m)):
        msg = (
            "log.points_log_m is given, from which turn and shift are fitted, and log.turn_deg or "
            "log.shift_m too; leave one of them out."
        )
        raise ConfigError(msg)
    try:
        log_frame(log)
    except NavigationError as exc:
        raise ConfigError(f"log.points_log_m: {exc}") from exc
    if len(set(log.ids.values())) < len(log.ids):
        msg = "log.ids names one tag for two anchors; give every anchor a tag of its own."
        raise ConfigError(msg)
    orientation = (log.columns.qz, log.columns.qw)
    if any(orientation) and (not all(orientation) or log.columns.heading):
        msg = (
            "log.columns needs qz and qw for a quaternion, and then no heading; give both, or "
            "heading alone."
        )
        raise ConfigError(msg)


def log_frame(log: Log) -> Frame:
    """Return how the log's coordinates lie in the room [m], [rad].

    Parameters
    ----------
    log : The table; reference points are fitted.
    """
    if log.points_log_m:
        found = fitted_frame(log.points_log_m, log.points_room_m, mirrored=log.mirrored)
        return found.frame
    return Frame(
        turn_rad=math.radians(log.turn_deg),
        shift_m=np.array(log.shift_m),
        mirrored=bool(log.mirrored),
    )
