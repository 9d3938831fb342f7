"""Where tags and robots stand in a room: inside it, off its surfaces, in no solid."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import ConfigError
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.setting.antennas import named_antenna
from octant.reader_design.setting.robot import free_place_m, mission_space
from octant.reader_design.study_file.room import Room
from octant.reader_design.study_file.schema import Radio, Study, Tag

FloatArray = npt.NDArray[np.float64]

CLEAR_M = 0.2
"""Room around the robot [m] at a start that is proposed."""
_Y_UP = (".glb", ".gltf")
ROUND = ("dipole", "monopole", "isotropic_theta")
"""Antennas that are alike all around their axis [-]."""


def alike_from_all_sides(tag: Tag) -> bool:
    """Return whether a tag's antenna is alike from all sides: round, and upright.

    Parameters
    ----------
    tag : Its table ``[[tag]]``.
    """
    return tag.antenna in ROUND and (tag.axis is None or not any(tag.axis[:2]))


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacedTag:
    """A tag where the radio model sees it.

    Parameters
    ----------
    id : Its name.
    position_m : (3,) float64 — Place in the room, after the stand-off [m].
    given_m : (3,) float64 — Place that the study gives [m].
    antennas : Its antenna at each frequency of the study [Hz]: the same metal, cut for the carrier;
        axis in the room's frame.
    """

    id: str
    position_m: FloatArray
    given_m: FloatArray
    antennas: tuple[Antenna, ...]

    def __post_init__(self) -> None:
        for name in ("position_m", "given_m"):
            value = frozen_array(getattr(self, name), name=name, shape=(3,))
            object.__setattr__(self, name, value)

    @property
    def point_m(self) -> FloatArray:
        """The tag's point on the ground, (2,) float64 [m]: below where the study puts the tag."""
        return self.given_m[:2]


def place_tags(study: Study, scene: Scene) -> tuple[tuple[PlacedTag, ...], tuple[str, ...]]:
    """Return the tags in their places, and a line for each that had to be moved.

    Parameters
    ----------
    study : With its tags [m].
    scene : The room they hang in.
    """
    placed, notes = [], []
    for i, tag in enumerate(study.tags):
        position, moved = place_antenna(
            scene,
            tag.position_m,
            study.solver.standoff_m,
            name=f"tag {tag.id!r}",
            key=f"tag[{i}].position_m",
            remark=turned_remark(study.room),
        )
        if moved:
            notes.append(moved)
        placed.append(
            PlacedTag(
                id=tag.id,
                position_m=position,
                given_m=np.array(tag.position_m),
                antennas=_tag_antennas(tag, study.radio, key=f"tag[{i}].antenna"),
            )
        )
    return tuple(placed), tuple(notes)


def turned_remark(room: Room) -> str:
    """Return that the room's file was turned, and how to keep it as it is, or "".

    Parameters
    ----------
    room : The table ``[room]``.
    """
    if not isinstance(room.mesh, str):
        return ""
    turned = room.up == "y" or (room.up is None and Path(room.mesh).suffix.lower() in _Y_UP)
    if not turned:
        return ""
    return ' (its file was turned from y up to z up; give room.up = "z" if it stands upright as is)'


def place_antenna(
    scene: Scene,
    point_m: npt.ArrayLike,
    standoff_m: float,
    *,
    name: str,
    key: str,
    remark: str = "",
) -> tuple[FloatArray, str]:
    """Return where an antenna is put, and a line that says so when that is not where it was given.

    A place outside the room or inside an object is refused.

    Parameters
    ----------
    scene : The room.
    point_m : (3,) array_like — Given place [m].
    standoff_m : How far it is moved off a surface that it lies on [m].
    name, key : Name in the line, and key path or option that gave the place, for errors.
    remark : What is added where the place is outside.
    """
    given = np.asarray(point_m, dtype=np.float64)
    text = _point_text(given)
    points, moved = scene.stand_off(given[None, :], standoff_m)
    if not scene.inside_room(points)[0]:
        low, high = (_point_text(corner) for corner in scene.bounds_m)
        msg = (
            f"{key} is {text} m, which is outside the room that spans {low} to {high} m"
            f"{remark}; move it inside."
        )
        raise ConfigError(msg)
    if scene.inside_solid(points)[0]:
        msg = f"{key} is {text} m, which is inside a solid object; move it out, or the object."
        raise ConfigError(msg)
    if not moved[0]:
        return given, ""
    note = (
        f"{name} at {text} m lies on a surface and is moved "
        f"{100.0 * float(np.linalg.norm(points[0] - given)):.3g} cm off it, "
        f"to {_point_text(points[0])} m (solver.standoff_m)."
    )
    return np.asarray(points[0], dtype=np.float64), note


def _tag_antennas(tag: Tag, radio: Radio, *, key: str) -> tuple[Antenna, ...]:
    antennas: list[Antenna] = []
    cut = None
    for f in (radio.frequency_hz, *radio.frequencies_hz):
        antennas.append(
            named_antenna(
                tag.antenna, f, key=key, axis=tag.axis, azimuth_deg=tag.azimuth_deg, length_m=cut
            )
        )
        cut = antennas[0].length_m or None  # the same metal at all frequencies
    return tuple(antennas[1:])


def check_starts(study: Study, scene: Scene, reader_z_m: float) -> None:
    """Refuse a mission that starts outside the room, in an object or too close to a wall.

    Parameters
    ----------
    study, scene : With or without a mission; its room [m].
    reader_z_m : Height coordinate of the reader's ground plane in the room's frame [m].
    """
    if study.mission is None:
        return
    _check_start(study, scene, reader_z_m, key="mission.start_m", place_m=study.mission.start_m)
    for i, (x, y, _) in enumerate(study.mission.starts):
        _check_start(study, scene, reader_z_m, key=f"mission.starts[{i}]", place_m=(x, y))


def _check_start(
    study: Study, scene: Scene, reader_z_m: float, *, key: str, place_m: tuple[float, float]
) -> None:
    start = np.array([*place_m, reader_z_m])
    shown = f"{key} is {list(place_m)} m"
    if not scene.inside_room(start[None, :])[0]:
        low, high = scene.bounds_m[:, :2].tolist()
        where = f"outside the room that spans {low} to {high} m{turned_remark(study.room)}"
        msg = f"{shown}, which is {where}; start inside it"
        raise ConfigError(msg + _such_as(study, scene, place_m))
    heights = np.linspace(scene.floor_height_m + LENGTHS.step_m, reader_z_m, 5)
    column = np.column_stack([np.tile(start[:2], (5, 1)), heights])
    if scene.inside_solid(column).any():
        msg = f"{shown}, which is inside an object; start beside it"
        raise ConfigError(msg + _such_as(study, scene, place_m))
    radius_m = study.reader.ground_plane_m / 2.0
    distance_m = float(scene.distance_to_facets_m(start[None, :])[0][0])
    beside = distance_m < radius_m and distance_m < study.reader.height_m - LENGTHS.same_m
    if beside:
        msg = (
            f"{shown}, {distance_m:g} m from a wall or an object, but the reader reaches "
            f"{radius_m:g} m from its centre; start further off (or move the room: room.origin_m)"
        )
        raise ConfigError(msg + _such_as(study, scene, place_m))


def _such_as(study: Study, scene: Scene, place_m: tuple[float, float]) -> str:
    """Return the end of a sentence that names the nearest place where the robot can stand."""
    found = free_place_m(mission_space(study, scene), place_m, clear_m=CLEAR_M)
    return "." if found is None else f", for example at {list(found)} m."


def check_heights(study: Study, scene: Scene, reader_z_m: float, map_z_m: float) -> None:
    """Refuse a reader or a map above the room.

    Parameters
    ----------
    study, scene : With the heights above the floor; its room [m].
    reader_z_m, map_z_m : Their height coordinates in the room's frame [m].
    """
    if not scene.has_room:
        return
    top_m = float(scene.bounds_m[1, 2])
    heights = {
        "reader.height_m": (study.reader.height_m, reader_z_m),
        "map.height_m": (study.map.height_m, map_z_m),
    }
    for path, (height_m, z_m) in heights.items():
        if z_m >= top_m:
            msg = (
                f"{path} is {height_m:g} m above the floor, but the room is only "
                f"{top_m - scene.floor_height_m:g} m high; choose less."
            )
            raise ConfigError(msg)


def _point_text(point_m: npt.ArrayLike) -> str:
    return "(" + ", ".join(f"{c:.6g}" for c in np.asarray(point_m)) + ")"
