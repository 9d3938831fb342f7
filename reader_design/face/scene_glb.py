"""A scene as a GLB file: its bodies with materials, and paths as tubes between its ends."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.geometries.bodies import Body
from octant.geometries.files import whole_file
from octant.geometries.mesh_files import save_bodies
from octant.geometries.names import unused_name
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS

if TYPE_CHECKING:
    from octant.reader_design.showing.scene_picture import DrawnPaths

FloatArray = npt.NDArray[np.float64]

WALL_OPACITY = 0.3
"""Opacity [-] of what closes a room, so that a viewer sees into it."""
TUBE_RADIUS_PER_EXTENT = 8e-4
END_RADIUS_PER_EXTENT = 6e-3
_TUBE_SIDES = 6


def write_scene(
    scene: Scene, path: Path, *, paths: "DrawnPaths | None", ends_m: Mapping[str, FloatArray]
) -> None:
    """Write a scene to a GLB file, whole or not at all; refuse when there is nothing to write.

    Parameters
    ----------
    scene, path : Room and objects, and the file.
    paths : Paths to be drawn as tubes, named by their rank, order and gain.
    ends_m : Places of transmitter and receiver [m], drawn as balls.
    """
    used: set[str] = set()
    bodies = [replace(b, name=unused_name(b.name, used)) for b in scene.bodies]
    opacity = {b.name: WALL_OPACITY for b in bodies if closes_room(b, scene)}
    extra: list[Body] = []
    for name, place in ends_m.items():
        extra.append(_ball(name, place, END_RADIUS_PER_EXTENT * scene.extent_m))
    if paths is not None:
        for k, vertices in enumerate(paths.vertices_m):
            order = int(paths.order[k])
            name = f"path {k + 1}, order {order}, {paths.gain_db[k]:.1f} dB"
            radius = TUBE_RADIUS_PER_EXTENT * scene.extent_m
            extra.append(tube(vertices, radius, name=name, material=f"path of order {order}"))
    with whole_file(path) as part:
        save_bodies([*bodies, *extra], part, opacity=opacity)


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


def _ball(name: str, place_m: FloatArray, radius_m: float) -> Body:
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=2, radius=radius_m)
    return Body(
        name=name,
        vertices_m=np.asarray(ball.vertices) + place_m,
        faces=np.asarray(ball.faces, dtype=np.int64),
        material=name,
    )
