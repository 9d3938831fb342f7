"""Rooms: closed shells over any outline, with doorways where wanted.

Bodies "walls", "floor" and "ceiling", normals into the room, fit corner to corner.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number, refuse_unknown_keys
from octant.geometries._plane_geometry import FloatArray
from octant.geometries._polygons import (
    check_simple,
    mesh_of_triangles,
    signed_area_m2,
    triangulate_polygon,
)
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError

PARTS = ("walls", "floor", "ceiling")
"""Names of a room's bodies, in the order in which they are returned."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Doorway:
    """A rectangular opening in a wall, from the floor up, with nothing behind it.

    Parameters
    ----------
    wall : Number of the wall: wall i runs from corner i of the outline to corner i + 1.
    offset_m : Distance from the wall's first corner to the opening, along the wall [m]; positive.
    width_m : Width of the opening [m]; the opening must end before the wall does.
    height_m : Height of the opening [m]; lower than the room.
    """

    wall: int
    offset_m: float
    width_m: float
    height_m: float

    def __post_init__(self) -> None:
        if not isinstance(self.wall, int) or self.wall < 0:
            msg = f"a doorway's wall must be 0, 1, 2 ..., but {self.wall!r} was given."
            raise GeometryError(msg)
        for field in ("offset_m", "width_m", "height_m"):
            value = positive_number(getattr(self, field), name=f"{field} of a doorway")
            object.__setattr__(self, field, value)


def prism_room(
    outline_xy_m: Sequence[Sequence[float]] | FloatArray,
    height_m: float,
    *,
    origin_m: Sequence[float] = (0.0, 0.0, 0.0),
    material: str = "concrete",
    materials: Mapping[str, str] | None = None,
    doorways: Sequence[Doorway] = (),
) -> tuple[Body, ...]:
    """Return "walls", "floor", "ceiling" of a room with upright walls over any simple outline.

    Walls have few triangles; doorways' feet are corners of the floor: no T-junctions.

    Parameters
    ----------
    outline_xy_m : (k, 2) — Corners of the floor in order, either way round, none repeated [m].
    height_m : Height of the room [m].
    origin_m : (3,) — Added to every corner; its z is the height of the floor [m].
    material : Label of every part that `materials` does not name.
    materials : Labels of "walls", "floor" and "ceiling".
    doorways : Openings; without any the room is closed.
    """
    outline = np.array(frozen_array(outline_xy_m, name="outline_xy_m", shape=(None, 2)))
    origin = frozen_array(origin_m, name="origin_m", shape=(3,))
    height = positive_number(height_m, name="height_m of the room")
    check_simple(outline, name="the room's outline")
    named = dict(materials or {})
    refuse_unknown_keys(named, allowed=PARTS, name="the room's material table")
    openings = _openings_by_wall(outline, height, doorways)
    corners = outline + origin[:2]
    inward = 1 if signed_area_m2(outline) < 0.0 else -1  # wall triangles wind clockwise in a
    walls: list[FloatArray] = []  # counter-clockwise outline, seen from outside
    rim: list[FloatArray] = []
    for i, start in enumerate(corners):
        triangles, feet = _wall(start, corners[(i + 1) % len(corners)], height, openings[i])
        walls.append(triangles[:, ::inward])
        rim += [start, *feet]
    surfaces = (
        np.concatenate(walls),
        _level(np.array(rim), 0.0),
        _level(corners, height)[:, ::-1],
    )
    lift = np.array((0.0, 0.0, origin[2]))
    bodies = []
    for name, triangles in zip(PARTS, surfaces, strict=True):
        vertices, faces = mesh_of_triangles(triangles + lift)
        label = named.get(name, material)
        bodies.append(Body(name=name, vertices_m=vertices, faces=faces, material=label))
    return tuple(bodies)


def _openings_by_wall(
    outline: FloatArray, height_m: float, doorways: Sequence[Doorway]
) -> list[list[Doorway]]:
    """Return each wall's doorways in order along it, once they are known to fit."""
    openings: list[list[Doorway]] = [[] for _ in outline]
    for door in doorways:
        if door.wall >= len(outline):
            msg = (
                f"a doorway names wall {door.wall}, but the room's walls are numbered 0 "
                f"to {len(outline) - 1}."
            )
            raise GeometryError(msg)
        openings[door.wall].append(door)
    lengths_m = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    for i, doors in enumerate(openings):
        doors.sort(key=lambda door: door.offset_m)
        reached = 0.0
        for door in doors:
            end = door.offset_m + door.width_m
            if door.offset_m <= reached or end >= lengths_m[i] or door.height_m >= height_m:
                msg = (
                    f"the doorway from {door.offset_m:g} to {end:g} m, {door.height_m:g} m high, "
                    f"does not fit into wall {i}, which is {lengths_m[i]:g} m long and "
                    f"{height_m:g} m high; leave some wall beside and above each doorway."
                )
                raise GeometryError(msg)
            reached = end
    return openings


def _wall(
    start_m: FloatArray, end_m: FloatArray, height_m: float, doors: Sequence[Doorway]
) -> tuple[FloatArray, list[FloatArray]]:
    """Return a wall's triangles, facing right of its direction, and its doorways' feet (x, y)."""
    length_m = float(np.linalg.norm(end_m - start_m))
    direction = (end_m - start_m) / length_m
    feet: list[FloatArray] = []
    plan = [(0.0, start_m, 0.0)]  # distance along the wall, place in plan, height
    for door in doors:
        for along in (door.offset_m, door.offset_m + door.width_m):
            feet.append(start_m + along * direction)
            low_then_high = ((0.0, door.height_m), (door.height_m, 0.0))[len(feet) % 2 == 0]
            plan += [(along, feet[-1], z) for z in low_then_high]
    plan += [(length_m, end_m, 0.0), (length_m, end_m, height_m), (0.0, start_m, height_m)]
    flat = np.array([(along, z) for along, _, z in plan])
    space = np.array([(*place_xy, z) for _, place_xy, z in plan])
    return space[triangulate_polygon(flat, name="a wall")], feet


def _level(outline_m: FloatArray, height_m: float) -> FloatArray:
    """Return the triangles that fill an outline at a height, normals up [m]."""
    flat = outline_m[triangulate_polygon(outline_m, name="the room's outline")]
    return np.concatenate((flat, np.full((*flat.shape[:2], 1), height_m)), axis=2)


def box_room(
    size_m: Sequence[float],
    *,
    origin_m: Sequence[float] = (0.0, 0.0, 0.0),
    material: str = "concrete",
    materials: Mapping[str, str] | None = None,
    doorways: Sequence[Doorway] = (),
) -> tuple[Body, ...]:
    """Return "walls", "floor", "ceiling" of a rectangular room.

    Parameters
    ----------
    size_m : (3,) — Length in x, y and z [m].
    origin_m : (3,) — Lowest corner [m].
    material : Label of every part that `materials` does not name.
    materials : Labels of "walls", "floor" and "ceiling".
    doorways : Openings; wall 0 is at the lowest y towards +x, 1, 2, 3 counter-clockwise from above.
    """
    lx, ly, lz = _lengths(size_m, names=("x", "y", "z"), of="the room's size_m")
    return prism_room(
        [(0.0, 0.0), (lx, 0.0), (lx, ly), (0.0, ly)],
        lz,
        origin_m=origin_m,
        material=material,
        materials=materials,
        doorways=doorways,
    )


def _lengths(values: Sequence[float], *, names: Sequence[str], of: str) -> list[float]:
    """Return positive lengths, one for each axis [m]."""
    array = frozen_array(values, name=of, shape=(len(names),))
    return [positive_number(v, name=f"{of} in {n}") for n, v in zip(names, array, strict=True)]
