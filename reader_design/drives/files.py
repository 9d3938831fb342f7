"""Files of a drive: MCAP with ROS 2 messages, TUM trajectories, CSV."""

import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.files import whole_file, write_text
from octant.navigation.angles import wrap_angle
from octant.navigation.csv_files import number_text, write_csv
from octant.reader_design.drives.definitions import definition
from octant.reader_design.drives.layout import LAYOUT_NAME, layout_text
from octant.reader_design.drives.log import DriveLog
from octant.reader_design.drives.messages import (
    MOST_TRIANGLES,
    Topic,
    drive_messages,
    room_triangles,
)

FloatArray = npt.NDArray[np.float64]

DriveFile = Literal["mcap", "tum", "csv"]
DRIVE_FILES: tuple[DriveFile, ...] = ("mcap", "tum", "csv")
"""What a drive is written as."""
DRIVES = "drives"
"""Folder of these files in a folder of results."""
DRIVE_COLUMNS = (
    "t_s",
    "x_m",
    "y_m",
    "heading_deg",
    "believed_x_m",
    "believed_y_m",
    "believed_heading_deg",
    "odometry_x_m",
    "odometry_y_m",
    "odometry_heading_deg",
    "speed_m_per_s",
    "turn_rate_rad_per_s",
    "target",
    "state",
    "bearing_deg",
)
"""First columns of a drive's CSV file [s], [m], [deg]; rss_1_w ... rss_n_w [W] follow."""
_KEPT, _PASSING = 1, 2  # durability: transient local, volatile
_QOS = (
    "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n"
    "  deadline:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  avoid_ros_namespace_conventions: false"
)


def check_kinds(kinds: Iterable[str]) -> None:
    """Refuse MCAP where the packages that write it are missing, before anything is computed.

    Parameters
    ----------
    kinds : Of `DRIVE_FILES`.
    """
    if "mcap" in kinds:
        _libraries()


def write_drive(log: DriveLog, stem: Path, kinds: Iterable[DriveFile]) -> tuple[Path, ...]:
    """Return the files of a drive, once written: STEM.mcap, STEM_truth.tum and so on.

    Parameters
    ----------
    log, kinds : The drive, and what it is written as.
    stem : Path without an ending; beside an MCAP file Foxglove's layout is put.
    """
    written: list[Path] = []
    for kind in dict.fromkeys(kinds):
        if kind == "mcap":
            path = stem.with_name(f"{stem.name}.mcap")
            write_mcap(log, path)
            layout = stem.with_name(LAYOUT_NAME)
            write_text(layout, layout_text(len(log.carrier.azimuths_rad)))
            written += [path, layout]
        elif kind == "tum":
            for what, poses in (("truth", log.poses), ("belief", log.belief)):
                if poses is not None:
                    path = stem.with_name(f"{stem.name}_{what}.tum")
                    write_tum(path, log.time_s, poses)
                    written.append(path)
        else:
            path = stem.with_name(f"{stem.name}.csv")
            write_drive_csv(path, log)
            written.append(path)
    return tuple(written)


def left_out(log: DriveLog, kinds: Iterable[str]) -> str:
    """Return what a drive's files lack, as a sentence; empty: nothing.

    Parameters
    ----------
    log, kinds : As in `write_drive`.
    """
    triangles = room_triangles(log)
    if "mcap" in kinds and triangles > MOST_TRIANGLES:
        return (
            f"the room has {triangles} triangles, more than the {MOST_TRIANGLES} that are written "
            "into an MCAP file: it shows the map of the floor alone; octant scene writes the room."
        )
    return ""


def write_mcap(log: DriveLog, path: Path) -> None:
    """Write a drive as an MCAP file with ROS 2 messages in CDR; the same drive, the same bytes.

    Topics and frames are those of `octant.reader_design.drives.messages`; topics that are kept for
    latecomers say so in the quality of service that ``ros2 bag play`` offers.

    Parameters
    ----------
    log, path : The drive; a file that ends in .mcap, replaced where it exists.
    """
    encoder, writer_class, reader_of, no_compression = _libraries()
    topics: dict[str, Topic] = {}
    plain = io.BytesIO()
    encoded = encoder(plain, compression=no_compression)
    schemas: dict[str, Any] = {}
    for topic, stamp, message in drive_messages(log):
        topics[topic.name] = topic
        if topic.kind not in schemas:
            package, name = topic.kind.split("/")
            schemas[topic.kind] = encoded.register_msgdef(
                f"{package}/msg/{name}", definition(topic.kind)
            )
        encoded.write_message(topic.name, schemas[topic.kind], message, stamp, stamp)
    encoded.finish()
    plain.seek(0)
    with whole_file(path) as part, part.open("wb") as out:
        writer = writer_class(out)
        writer.start(profile="ros2", library="octant")
        channels: dict[str, int] = {}
        known: dict[int, int] = {}
        for schema, channel, record in reader_of(plain).iter_messages():
            if schema.id not in known:
                known[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.topic not in channels:
                channels[channel.topic] = writer.register_channel(
                    topic=channel.topic,
                    message_encoding=channel.message_encoding,
                    schema_id=known[schema.id],
                    metadata={"offered_qos_profiles": _quality(topics[channel.topic])},
                )
            writer.add_message(
                channel_id=channels[channel.topic],
                log_time=record.log_time,
                publish_time=record.publish_time,
                sequence=0,
                data=record.data,
            )
        writer.add_metadata("octant", {"name": log.name, **log.facts})
        writer.finish()


def _quality(topic: Topic) -> str:
    return _QOS.format(depth=1 if topic.kept else 10, durability=_KEPT if topic.kept else _PASSING)


def _libraries() -> tuple[Any, Any, Any, Any]:
    """Return encoder, writer, reader and "no compression" of the packages ``mcap``."""
    try:
        from mcap.reader import make_reader
        from mcap.writer import CompressionType
        from mcap.writer import Writer as McapWriter
        from mcap_ros2.writer import Writer
    except ImportError as exc:
        msg = (
            "MCAP files are written by mcap and mcap-ros2-support; install them: "
            'pip install "octant[ros]".'
        )
        raise ConfigError(msg) from exc
    return Writer, McapWriter, make_reader, CompressionType.NONE


def write_tum(path: Path, time_s: FloatArray, poses: FloatArray) -> None:
    """Write a trajectory of the TUM RGB-D benchmark: t x y z qx qy qz qw, [s], [m]; z is 0.

    Parameters
    ----------
    path : The file; replaced where it exists.
    time_s, poses : (s,), (s, 3) float64 — Time [s]; x, y [m], heading [rad]; NaN rows are left out.
    """
    half = 0.5 * wrap_angle(poses[:, 2])
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    for k in np.flatnonzero(np.isfinite(poses).all(axis=1)).tolist():
        x, y = (float(c) for c in poses[k, :2])
        turn = (float(np.sin(half[k])), float(np.cos(half[k])))
        numbers = (float(time_s[k]), x, y, 0.0, 0.0, 0.0, *turn)
        lines.append(" ".join(map(repr, numbers)))
    write_text(path, "\n".join(lines) + "\n")


def write_drive_csv(path: Path, log: DriveLog) -> None:
    """Write a drive as a table; what it does not have is empty.

    Parameters
    ----------
    path, log : The file, replaced where it exists; the drive.
    """
    rows = len(log.time_s)
    nothing = np.full((rows, 3), np.nan)
    bearing = log.bearing_rad
    rss_w = np.zeros((rows, 0)) if log.rss_w is None else log.rss_w
    commands = nothing[:, :2] if log.commands is None else log.commands
    angles = nothing[:, 0] if bearing is None else np.degrees(bearing)
    ways = [
        _in_degrees(nothing if way is None else way)
        for way in (log.poses, log.belief, log.odometry)
    ]
    header = (*DRIVE_COLUMNS, *(f"rss_{i + 1}_w" for i in range(rss_w.shape[1])))
    table = (
        (
            number_text(float(log.time_s[k])),
            *(number_text(value) for way in ways for value in way[k]),
            *(number_text(value) for value in commands[k]),
            log.targets[k] if log.targets else "",
            log.states[k] if log.states else "",
            number_text(angles[k]),
            *(number_text(value) for value in rss_w[k]),
        )
        for k in range(rows)
    )
    write_csv(path, header, table)


def _in_degrees(poses: FloatArray) -> FloatArray:
    return np.column_stack([poses[:, :2], np.degrees(wrap_angle(poses[:, 2]))])


def drive_names(names: Sequence[str]) -> list[str]:
    """Return file names without endings for drives: letters, digits, dashes, each one once.

    Parameters
    ----------
    names : What the drives are called.
    """
    found: list[str] = []
    for name in names:
        plain = "".join(c if c.isalnum() and c.isascii() else "_" for c in name).strip("_").lower()
        plain = "_".join(part for part in plain.split("_") if part) or "drive"
        unused, number = plain, 2
        while unused in found:
            unused, number = f"{plain}_{number}", number + 1
        found.append(unused)
    return found
