"""The faces of a scene for a picture: what is wall, what is object, what hides the view."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries.bodies import Body
from octant.geometries.facets import build_facets
from octant.geometries.occlusion import build_bvh, segments_blocked
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS

FloatArray = npt.NDArray[np.float64]

MOST_TRIANGLES = 2000
"""Triangles of a body [-] up to which they are joined to flat polygons before they are drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Face:
    """A flat piece of a body.

    Parameters
    ----------
    triangles_m : (t, 3, 3) float64 — The triangles that fill it [m].
    outlines_m : The polygon that fills it as well; its triangles, where it has holes [m].
    rim_m : (e, 2, 3) float64 — Ends of the edges around it and around its holes [m].
    normal : (3,) float64 — Unit normal towards the viewer [-].
    material : Label.
    wall, cut_away : Whether one side is outside the room; whether such a wall hides the room.
    """

    triangles_m: FloatArray
    outlines_m: tuple[FloatArray, ...]
    rim_m: FloatArray
    normal: FloatArray
    material: str
    wall: bool
    cut_away: bool


def scene_faces(scene: Scene, towards: FloatArray) -> list[Face]:
    """Return the faces of all bodies in their order, seen from far away.

    Parameters
    ----------
    scene : Room and objects.
    towards : (3,) float64 — Direction from the scene to the viewer [-].
    """
    faces = [face for body in scene.bodies for face in _faces_of(body, scene, towards)]
    return _with_walls(scene, faces) if faces and scene.has_room else faces


def _faces_of(body: Body, scene: Scene, towards: FloatArray) -> list[Face]:
    triangles = body.triangles_m
    if len(triangles) <= MOST_TRIANGLES:
        zeros = np.zeros(len(triangles), dtype=np.int64)
        flat = build_facets(
            body.vertices_m,
            body.faces,
            zeros,
            tolerance_m=LENGTHS.plane_per_extent * scene.extent_m,
        )
        pieces = [
            (triangles[flat.triangle_facet == i], flat.outline_room_m(i))
            for i in range(len(flat.facet_plane))
        ]
    else:
        pieces = [(triangle[None], np.zeros((0, 2, 3))) for triangle in triangles]
    faces = []
    for corners, rim in pieces:
        a, b, c = np.moveaxis(corners, 1, 0)
        area = np.cross(b - a, c - a)
        normal = area[np.argmax(np.linalg.norm(area, axis=1))]
        length = float(np.linalg.norm(normal))
        if length == 0.0:
            continue
        normal = normal / length * (1.0 if normal @ towards >= 0.0 else -1.0)
        faces.append(
            Face(
                triangles_m=corners,
                outlines_m=_polygon(rim) or tuple(corners),
                rim_m=rim,
                normal=normal,
                material=body.material,
                wall=False,
                cut_away=False,
            )
        )
    return faces


def _polygon(rim_m: FloatArray) -> tuple[FloatArray, ...]:
    """Return the one polygon that directed edges make, or nothing where they make several."""
    if len(rim_m) == 0:
        return ()
    follows = {tuple(np.round(start, 9)): end for start, end in rim_m}
    corners = [rim_m[0, 0]]
    while len(corners) <= len(rim_m):
        end = follows.get(tuple(np.round(corners[-1], 9)))
        if end is None or np.allclose(end, corners[0], atol=LENGTHS.joined_m):
            break
        corners.append(end)
    return (np.array(corners),) if len(corners) == len(rim_m) == len(follows) else ()


def _with_walls(scene: Scene, faces: list[Face]) -> list[Face]:
    """Return the faces with walls marked: a wall has the outside of the room on one side."""
    step = LENGTHS.step_per_extent * scene.extent_m
    middles = []
    for face in faces:
        a, b, c = np.moveaxis(face.triangles_m, 1, 0)
        largest = int(np.argmax(np.linalg.norm(np.cross(b - a, c - a), axis=1)))
        middles.append(face.triangles_m[largest].mean(axis=0))
    centre = np.array(middles)
    normal = np.array([face.normal for face in faces])
    front = scene.inside_room(centre + step * normal)
    back = scene.inside_room(centre - step * normal)
    # The bottom of a cabinet has the outside on one side as well, but solid on the other.
    of_solid = scene.inside_solid(centre + step * normal) | scene.inside_solid(
        centre - step * normal
    )
    return [
        replace(face, wall=bool(f != b and not s), cut_away=bool(b and not f and not s))
        for face, f, b, s in zip(faces, front, back, of_solid, strict=True)
    ]


def hidden_points(
    faces: list[Face], points_m: FloatArray, towards: FloatArray
) -> npt.NDArray[np.bool_]:
    """Return which points objects hide from a viewer far away, (k,).

    Parameters
    ----------
    faces : Those that hide: objects, not walls.
    points_m : (k, 3) float64 — Points [m].
    towards : (3,) float64 — Direction to the viewer [-].
    """
    hiding = [face.triangles_m for face in faces if not face.wall]
    if not hiding or len(points_m) == 0:
        return np.zeros(len(points_m), dtype=np.bool_)
    corners = np.concatenate(hiding)
    both = np.concatenate((corners.reshape(-1, 3), points_m))
    reach = float(np.linalg.norm(np.ptp(both, axis=0))) + 1.0
    planes = np.arange(len(corners), dtype=np.int64)
    tree = build_bvh(corners, planes, extent_m=reach)
    start = points_m + LENGTHS.plane_per_extent * reach * towards
    return segments_blocked(tree, start, start + 2.0 * reach * towards)
