"""A scene as a GLB file: its bodies with materials, and what is shown with it, each a named node.

Paths are tubes between their ends, tags and ends are balls, a way is a tube on the floor.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.geometries.bodies import Body, place
from octant.geometries.files import whole_file
from octant.geometries.mesh_files import save_bodies
from octant.geometries.names import unused_name
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.study_file.reader import Reader

if TYPE_CHECKING:
    from octant.reader_design.showing.scene_picture import DrawnPaths

FloatArray = npt.NDArray[np.float64]

WALL_OPACITY = 0.3
"""Opacity [-] of what closes a room, so that a viewer sees into it."""
TUBE_RADIUS_PER_EXTENT = 8e-4
END_RADIUS_PER_EXTENT = 6e-3
_TUBE_SIDES = 6
_LEAST_WIRE_M = 1e-3


def write_scene(
    scene: Scene,
    path: Path,
    *,
    paths: "DrawnPaths | None",
    ends_m: Mapping[str, FloatArray],
    shown: Sequence[Body] = (),
) -> None:
    """Write a scene to a GLB file, whole or not at all; refuse when there is nothing to write.

    Parameters
    ----------
    scene, path : Room and objects, and the file.
    paths : Paths to be drawn as tubes, named by their rank, order and gain.
    ends_m : Places of transmitter and receiver [m], drawn as balls.
    shown : Further bodies, such as `tag_bodies`.
    """
    used: set[str] = set()
    bodies = [replace(b, name=unused_name(b.name, used)) for b in scene.bodies]
    opacity = {b.name: WALL_OPACITY for b in bodies if closes_room(b, scene)}
    extra: list[Body] = []
    for name, end in ends_m.items():
        extra.append(_ball(name, end, END_RADIUS_PER_EXTENT * scene.extent_m))
    if paths is not None:
        for k, vertices in enumerate(paths.vertices_m):
            order = int(paths.order[k])
            name = f"path {k + 1}, order {order}, {paths.gain_db[k]:.1f} dB"
            radius = TUBE_RADIUS_PER_EXTENT * scene.extent_m
            extra.append(tube(vertices, radius, name=name, material=f"path of order {order}"))
    further = [replace(b, name=unused_name(b.name, used)) for b in (*extra, *shown)]
    with whole_file(path) as part:
        save_bodies([*bodies, *further], part, opacity=opacity)


def tag_bodies(tags_m: Mapping[str, FloatArray], extent_m: float) -> list[Body]:
    """Return a ball for each tag, named ``tag`` and its id.

    Parameters
    ----------
    tags_m, extent_m : Places of the tags by id [m]; size of the scene, by which the balls go [m].
    """
    radius_m = END_RADIUS_PER_EXTENT * extent_m
    return [_ball(f"tag {tag}", at, radius_m, "tag") for tag, at in tags_m.items()]


def axes_bodies(extent_m: float) -> list[Body]:
    """Return the axes of the room's frame at its origin, 1 m long, named ``axis x`` and so on.

    Parameters
    ----------
    extent_m : Size of the scene, by which their thickness goes [m].
    """
    radius_m = 2.0 * TUBE_RADIUS_PER_EXTENT * extent_m
    return [
        tube(np.stack([np.zeros(3), end]), radius_m, name=f"axis {name}", material=f"axis {name}")
        for name, end in zip("xyz", np.eye(3), strict=True)
    ]


def way_body(places_m: FloatArray, floor_m: float, extent_m: float, *, name: str) -> Body:
    """Return a way on the floor as a tube.

    Parameters
    ----------
    places_m : (k, 2) float64 — Places, in order [m].
    floor_m, extent_m : Height of the floor; size of the scene, by which the tube goes [m].
    name : Of the body.
    """
    radius_m = 2.0 * TUBE_RADIUS_PER_EXTENT * extent_m
    heights = np.full((len(places_m), 1), floor_m + radius_m)
    return tube(np.hstack([places_m, heights]), radius_m, name=name, material="trajectory")


def reader_bodies(
    design: Reader, pose: tuple[float, float, float], plane_m: float, *, frequency_hz: float
) -> list[Body]:
    """Return a reader's metal, named ``reader``, and its antennas, ``antenna 1`` and so on.

    Parameters
    ----------
    design, frequency_hz : The reader; where antennas without a length are resonant [Hz].
    pose, plane_m : x [m], y [m], heading of the robot [rad]; height of the ground plane [m].
    """
    built = design.body()
    x, y, heading = pose
    turn, where = heading - 0.5 * math.pi, (x, y, plane_m)  # the reader's +y looks ahead
    length_m = design.element(frequency_hz).length_m or 0.0
    joined = design.antenna == "monopole" and design.monopole_plane_m == 0.0
    foot_m = 0.0 if joined else design.gap_m
    bodies = [replace(built.body, name="reader", material="metal")]
    for number, foot in enumerate(built.element_feet_m, start=1):
        low = np.array([foot[0], foot[1], foot_m])
        ends = np.stack([low, low + np.array([0.0, 0.0, length_m])])
        radius_m = max(design.wire_radius_m, _LEAST_WIRE_M)
        bodies.append(tube(ends, radius_m, name=f"antenna {number}", material="antenna"))
    return [place(body, position_m=where, yaw_rad=turn) for body in bodies]


def closes_room(body: Body, scene: Scene) -> bool:
    """Return whether a body is a wall or a ceiling: it reaches the bounds, but is no floor.

    Parameters
    ----------
    body, scene : The body, and the scene it stands in.
    """
    if not scene.has_room:
        return False
    low, high = body.bounds_m
    slack = LENGTHS.plane_per_extent * scene.extent_m
    is_floor = high[2] <= scene.floor_height_m + slack
    touched = (low <= scene.bounds_m[0] + slack) | (high >= scene.bounds_m[1] - slack)
    touched[2] = high[2] >= scene.bounds_m[1, 2] - slack
    return bool(touched.any()) and not is_floor


def tube(vertices_m: FloatArray, radius_m: float, *, name: str, material: str) -> Body:
    """Return a path as open prisms of six sides, one a leg; refuse when no leg has a length.

    Parameters
    ----------
    vertices_m : (n, 3) float64 — Corners of the path [m].
    radius_m : Radius [m].
    name, material : Of the body.
    """
    angle = 2.0 * np.pi * np.arange(_TUBE_SIDES) / _TUBE_SIDES
    i = np.arange(_TUBE_SIDES)
    j = (i + 1) % _TUBE_SIDES
    sides = np.concatenate(
        (
            np.column_stack((i, j, j + _TUBE_SIDES)),
            np.column_stack((i, j + _TUBE_SIDES, i + _TUBE_SIDES)),
        )
    )
    points: list[FloatArray] = []
    faces: list[npt.NDArray[np.int64]] = []
    for start, end in pairwise(vertices_m):
        along = end - start
        length = float(np.linalg.norm(along))
        if length == 0.0:
            continue
        axis = along / length
        aside = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        aside = aside / np.linalg.norm(aside)
        ring = np.outer(np.cos(angle), aside) + np.outer(np.sin(angle), np.cross(axis, aside))
        faces.append(sides + 2 * _TUBE_SIDES * len(faces))
        points += [start + radius_m * ring, end + radius_m * ring]
    return Body(
        name=name,
        vertices_m=np.concatenate(points) if points else np.zeros((0, 3)),
        faces=np.concatenate(faces) if faces else np.zeros((0, 3), dtype=np.int64),
        material=material,
    )


def _ball(name: str, place_m: FloatArray, radius_m: float, material: str = "") -> Body:
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=2, radius=radius_m)
    return Body(
        name=name,
        vertices_m=np.asarray(ball.vertices) + place_m,
        faces=np.asarray(ball.faces, dtype=np.int64),
        material=material or name,
    )
