"""The ROS 2 messages of a drive, topic by topic.

Frames after REP 105: ``map`` is the room, ``odom`` the wheels' own axes, ``base_link`` the robot on
the floor, x ahead, where it believes to be; ``base_link_true`` is where it is. ``reader`` is the
reader's frame, whose +y looks ahead, and ``antenna_1`` ... stand in it, x outwards.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries.appearance import looks_of
from octant.geometries.bodies import Body
from octant.navigation.sensing.bearing import FRONT_AZIMUTH_RAD
from octant.reader_design.drives.log import DriveLog
from octant.reader_design.showing.scene_glb import WALL_OPACITY

FloatArray = npt.NDArray[np.float64]
Message = dict[str, Any]

START_NS = 1_000_000_000
"""Stamp of the time 0 of a drive [ns]: a stamp of zero means "the latest" to ROS."""
MOST_TRIANGLES = 150_000
"""Triangles of a room that is written as markers [-]."""
_CYLINDER, _SPHERE, _TEXT, _TRIANGLES = 3, 2, 9, 11
_TAG_M = 0.06
_TEXT_M = 0.15
_TAG_RGB, _ROBOT_RGB, _TRUE_RGB = (0.85, 0.2, 0.1), (0.2, 0.3, 0.7), (0.1, 0.6, 0.3)
_OCCUPIED = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """Name, type and manner of a topic.

    Attributes
    ----------
    name : As ``/odom``.
    kind : As ``nav_msgs/Odometry``.
    kept : Whether who comes late gets the last message, as for maps.
    """

    name: str
    kind: str
    kept: bool = False


def drive_messages(log: DriveLog) -> Iterator[tuple[Topic, int, Message]]:
    """Yield topic, stamp [ns] and content of every message of a drive, in the order of time.

    Parameters
    ----------
    log : The drive.
    """
    yield from _once(log)
    corrections = log.corrections
    bearing, truth = log.bearing_rad, log.true_bearing_rad
    for k, time_s in enumerate(log.time_s):
        stamp = stamp_ns(float(time_s))
        for name, kind, message in _sample(log, k, stamp, corrections[k]):
            yield Topic(name=name, kind=kind), stamp, message
        if bearing is not None and np.isfinite(bearing[k]):
            pose = _pose(0.0, 0.0, log.carrier.reader_height_m, bearing[k])
            arrow = {"header": _header(stamp, "base_link"), "pose": pose}
            yield Topic(name="/bearing", kind="geometry_msgs/PoseStamped"), stamp, arrow
            degrees = {"data": math.degrees(bearing[k])}
            yield Topic(name="/bearing_deg", kind="std_msgs/Float64"), stamp, degrees
        if truth is not None:
            degrees = {"data": math.degrees(truth[k])}
            yield Topic(name="/ground_truth/bearing_deg", kind="std_msgs/Float64"), stamp, degrees


def stamp_ns(time_s: float) -> int:
    """Return the stamp of a time of the drive [ns].

    Parameters
    ----------
    time_s : Since its start [s].
    """
    return START_NS + round(time_s * 1e9)


def room_triangles(log: DriveLog) -> int:
    """Return how many triangles stand about a drive; above `MOST_TRIANGLES` none is written [-].

    Parameters
    ----------
    log : The drive.
    """
    return sum(len(body.faces) for body in log.around.bodies)


def _once(log: DriveLog) -> Iterator[tuple[Topic, int, Message]]:
    """Yield what holds for the whole drive."""
    first = stamp_ns(float(log.time_s[0]))
    header = _header(first, "map")
    still = Topic(name="/tf_static", kind="tf2_msgs/TFMessage", kept=True)
    transforms = list(_static_transforms(log, first))
    if transforms:
        yield still, first, {"transforms": transforms}
    markers = "visualization_msgs/MarkerArray"
    if log.around.bodies and room_triangles(log) <= MOST_TRIANGLES:
        room = [
            _body_marker(body, i, header, see_through=body.name in log.around.closing)
            for i, body in enumerate(log.around.bodies)
        ]
        yield Topic(name="/room", kind=markers, kept=True), first, {"markers": room}
    if log.tags_m:
        tags = list(_tag_markers(log, header))
        yield Topic(name="/tags", kind=markers, kept=True), first, {"markers": tags}
    if log.around.floor is not None:
        grid = _grid(log, header, first)
        yield Topic(name="/map", kind="nav_msgs/OccupancyGrid", kept=True), first, grid
    robots = [
        _robot_marker(log, first, frame, i)
        for i, frame in enumerate(("base_link", "base_link_true"))
        if frame != "base_link" or log.odometry is not None or log.belief is not None
    ]
    yield Topic(name="/robot", kind=markers, kept=True), first, {"markers": robots}
    for name, way in (("/plan", log.wanted), ("/ground_truth/path", log.poses)):
        if way is not None:
            yield Topic(name=name, kind="nav_msgs/Path", kept=True), first, _path(log, way, header)


def _sample(
    log: DriveLog, k: int, stamp: int, correction: FloatArray
) -> Iterator[tuple[str, str, Message]]:
    """Yield topic, type and content of what stands in one row."""
    header = _header(stamp, "map")
    floor = log.floor_m
    transforms = [_transform(header, "base_link_true", log.poses[k], floor)]
    believed = None if log.belief is None or np.isnan(log.belief[k]).any() else log.belief[k]
    if log.odometry is not None:
        own = _header(stamp, "odom")
        transforms.append(_transform(header, "odom", correction, floor))
        transforms.append(_transform(own, "base_link", log.odometry[k], 0.0))
        yield "/odom", "nav_msgs/Odometry", _odometry(log, k, own)
    elif believed is not None:
        transforms.append(_transform(header, "base_link", believed, floor))
    yield "/tf", "tf2_msgs/TFMessage", {"transforms": transforms}
    stamped = "geometry_msgs/PoseStamped"
    yield "/ground_truth/pose", stamped, _stamped(header, log.poses[k], floor)
    if believed is not None:
        yield "/belief/pose", stamped, _stamped(header, believed, floor)
    if log.commands is not None:
        yield "/cmd_vel", "geometry_msgs/Twist", _twist(*log.commands[k])
    if log.rss_w is not None and np.isfinite(log.rss_w[k]).any():
        array = "std_msgs/Float64MultiArray"
        yield "/rss_w", array, _array(log.rss_w[k])
        yield "/rss_dbm", array, _array(_dbm(log.rss_w[k]))
    if log.believed_tag_m is not None and np.isfinite(log.believed_tag_m[k]).all():
        x, y = log.believed_tag_m[k]
        point = {"x": float(x), "y": float(y), "z": floor}
        yield "/belief/tag", "geometry_msgs/PointStamped", {"header": header, "point": point}
    for name, texts in (("/target_tag", log.targets), ("/state", log.states)):
        if texts:
            yield name, "std_msgs/String", {"data": texts[k]}


def _dbm(power_w: FloatArray) -> FloatArray:
    """Return levels [dBm]; NaN, which plots leave open, where nothing is received."""
    with np.errstate(divide="ignore"):
        level: FloatArray = 10.0 * np.log10(power_w) + 30.0
    return np.where(power_w > 0.0, level, np.nan)


def _header(stamp: int, frame: str) -> Message:
    return {"stamp": _time(stamp), "frame_id": frame}


def _time(stamp: int) -> Message:
    return {"sec": stamp // 1_000_000_000, "nanosec": stamp % 1_000_000_000}


def _xyz(x: float, y: float, z: float) -> Message:
    return {"x": float(x), "y": float(y), "z": float(z)}


def _turn(yaw_rad: float) -> Message:
    return {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * yaw_rad), "w": math.cos(0.5 * yaw_rad)}


def _pose(x: float, y: float, z: float, yaw_rad: float) -> Message:
    return {"position": _xyz(x, y, z), "orientation": _turn(float(yaw_rad))}


def _stamped(header: Message, pose: FloatArray, floor_m: float) -> Message:
    return {"header": header, "pose": _pose(pose[0], pose[1], floor_m, pose[2])}


def _transform(header: Message, child: str, pose: FloatArray, z: float) -> Message:
    moved = {"translation": _xyz(pose[0], pose[1], z), "rotation": _turn(float(pose[2]))}
    return {"header": header, "child_frame_id": child, "transform": moved}


def _static_transforms(log: DriveLog, stamp: int) -> Iterator[Message]:
    carrier = log.carrier
    if not len(carrier.azimuths_rad):
        return
    at_front = np.array([0.0, 0.0, -FRONT_AZIMUTH_RAD])
    base = "base_link" if log.odometry is not None or log.belief is not None else "base_link_true"
    yield _transform(_header(stamp, base), "reader", at_front, carrier.reader_height_m)
    for number, azimuth in enumerate(carrier.azimuths_rad.tolist(), start=1):
        radius = carrier.antenna_radius_m
        place = np.array([radius * math.cos(azimuth), radius * math.sin(azimuth), azimuth])
        yield _transform(_header(stamp, "reader"), f"antenna_{number}", place, 0.0)


def _odometry(log: DriveLog, k: int, header: Message) -> Message:
    """Return pose by the wheels, and the speeds by them in the period before."""
    assert log.odometry is not None  # noqa: S101  asked for only then
    x, y, heading = log.odometry[k]
    speed = rate = 0.0
    if k:
        period = float(log.time_s[k] - log.time_s[k - 1])
        before = log.odometry[k - 1]
        turn = math.remainder(heading - before[2], 2.0 * math.pi)
        middle = before[2] + 0.5 * turn
        along = (x - before[0]) * math.cos(middle) + (y - before[1]) * math.sin(middle)
        speed, rate = along / period, turn / period
    unknown = [0.0] * 36
    return {
        "header": header,
        "child_frame_id": "base_link",
        "pose": {"pose": _pose(x, y, 0.0, heading), "covariance": unknown},
        "twist": {"twist": _twist(speed, rate), "covariance": unknown},
    }


def _twist(speed_m_per_s: float, turn_rate_rad_per_s: float) -> Message:
    return {
        "linear": _xyz(speed_m_per_s, 0.0, 0.0),
        "angular": _xyz(0.0, 0.0, turn_rate_rad_per_s),
    }


def _array(values: FloatArray) -> Message:
    size = len(values)
    along = {"label": "antenna", "size": size, "stride": size}
    return {"layout": {"dim": [along], "data_offset": 0}, "data": values.tolist()}


def _path(log: DriveLog, way: FloatArray, header: Message) -> Message:
    return {"header": header, "poses": [_stamped(header, pose, log.floor_m) for pose in way]}


def _colour(rgb: Sequence[float], alpha: float) -> Message:
    return {"r": float(rgb[0]), "g": float(rgb[1]), "b": float(rgb[2]), "a": alpha}


def _marker(header: Message, kind: int, number: int, **fields: object) -> Message:
    marker: Message = {
        "header": header,
        "ns": "octant",
        "id": number,
        "type": kind,
        "action": 0,
        "pose": _pose(0.0, 0.0, 0.0, 0.0),
        "scale": _xyz(1.0, 1.0, 1.0),
        "color": _colour((0.5, 0.5, 0.5), 1.0),
        "lifetime": {"sec": 0, "nanosec": 0},
        "frame_locked": False,
        "points": [],
        "colors": [],
        "texture_resource": "",
        "texture": {"header": header, "format": "", "data": b""},
        "uv_coordinates": [],
        "text": "",
        "mesh_resource": "",
        "mesh_file": {"filename": "", "data": b""},
        "mesh_use_embedded_materials": False,
    }
    return {**marker, **fields}


def _body_marker(body: Body, number: int, header: Message, *, see_through: bool) -> Message:
    looks = looks_of(body.material)
    points = body.triangles_m.reshape(-1, 3).tolist()
    return _marker(
        header,
        _TRIANGLES,
        number,
        ns=body.name,
        color=_colour(looks.colour, WALL_OPACITY if see_through else looks.opacity),
        points=[{"x": x, "y": y, "z": z} for x, y, z in points],
    )


def _tag_markers(log: DriveLog, header: Message) -> Iterator[Message]:
    for number, (tag, place) in enumerate(log.tags_m.items()):
        x, y, z = (float(c) for c in place)
        yield _marker(
            header,
            _SPHERE,
            2 * number,
            ns="tags",
            pose=_pose(x, y, z, 0.0),
            scale=_xyz(_TAG_M, _TAG_M, _TAG_M),
            color=_colour(_TAG_RGB, 1.0),
        )
        yield _marker(
            header,
            _TEXT,
            2 * number + 1,
            ns="tags",
            pose=_pose(x, y, z - _TEXT_M, 0.0),
            scale=_xyz(0.0, 0.0, _TEXT_M),
            color=_colour(_TAG_RGB, 1.0),
            text=tag,
        )


def _robot_marker(log: DriveLog, stamp: int, frame: str, number: int) -> Message:
    carrier, true = log.carrier, frame == "base_link_true"
    width = 2.0 * carrier.radius_m
    return _marker(
        _header(stamp, frame),
        _CYLINDER,
        number,
        ns="robot",
        pose=_pose(0.0, 0.0, 0.5 * carrier.height_m, 0.0),
        scale=_xyz(width, width, carrier.height_m),
        color=_colour(_TRUE_RGB if true else _ROBOT_RGB, 0.8 if true else 0.4),
        frame_locked=True,
    )


def _grid(log: DriveLog, header: Message, stamp: int) -> Message:
    assert log.around.floor is not None  # noqa: S101  asked for only then
    floor = log.around.floor.squared()
    free = floor.values.T
    cells = np.where(free == 1.0, 0, np.where(free == 0.0, _OCCUPIED, -1))
    x, y = floor.low_m
    return {
        "header": header,
        "info": {
            "map_load_time": _time(stamp),
            "resolution": floor.cell_m[0],
            "width": len(floor.x_m),
            "height": len(floor.y_m),
            "origin": _pose(x, y, log.floor_m, 0.0),
        },
        "data": cells.ravel().tolist(),
    }
