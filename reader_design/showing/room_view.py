"""The room in three dimensions, for a page: bodies, tags, paths, the robot's start and its ways."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import make_antenna
from octant.em.decibels import decibels
from octant.em.fields.gains import path_gains
from octant.em.paths.tracing import trace_paths
from octant.geometries.appearance import looks_of
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.page.packing import packed
from octant.reader_design.showing.pages import ReportFigure, ReportWidget
from octant.reader_design.showing.scene_faces import Face, scene_faces

FloatArray = npt.NDArray[np.float64]

MOST_TRIANGLES = 30_000
"""Triangles that a page holds [-]; of more, the largest."""
MOST_EDGES = 20_000
"""Edges that a page holds [-]; of more, the longest."""
MOST_PATHS = 12
"""Paths of each tag that a page holds [-]."""
_UP = np.array([0.0, 0.0, 1.0])
_MM = 0.001


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """A way of the robot over the floor.

    Attributes
    ----------
    points_m, end : (k, 2) float64 — Its points [m]; how the run ended, in a word.
    """

    points_m: FloatArray
    end: str


def room_widget(
    setting: Setting,
    *,
    start_m: Sequence[float] | None = None,
    ways: Sequence[Way] = (),
    fallback: tuple[ReportFigure, ...] = (),
) -> ReportWidget | None:
    """Return the room as a page turns it [m]; None where there is nothing to see.

    Parameters
    ----------
    setting, start_m : The room with its tags; the robot's start [m], else the floor's middle.
    ways, fallback : Ways of the robot; what stands there without scripts and on paper.
    """
    scene = setting.scene
    if not scene.bodies:
        return None
    low, high = scene.bounds_m
    place = np.array(start_m if start_m is not None else 0.5 * (low + high)[:2], dtype=np.float64)
    reader = np.append(place, setting.reader_z_m)
    faces = scene_faces(scene, _UP)
    triangles = [_inward(face) for face in faces]
    size = high - low
    looks = {_name(face.material): _hex(face.material) for face in faces}
    count = len(looks)
    return ReportWidget(
        kind="room",
        title="The room",
        caption="Drag to turn it, or use the arrow keys and + and −; walls open towards you. Click "
        "a tag to see its strongest paths to the robot's start.",
        alt=f"The room, {size[0]:.2g} by {size[1]:.2g} by {size[2]:.2g} m, with "
        f"{len(scene.bodies)} bodies of {count} material{'s' if count > 1 else ''} and "
        f"{len(setting.tags)} tag{'' if len(setting.tags) == 1 else 's'}.",
        data={
            "said": f"The room with {len(setting.tags)} tags, seen from above at an angle.",
            "bounds": scene.bounds_m.round(3).tolist(),
            "parts": _parts(faces, triangles),
            "edges": packed(_edges(faces), step=_MM, most=65535),
            "materials": [[name, colour] for name, colour in looks.items()],
            "tags": [
                {"id": t.id, **dict(zip("xyz", t.position_m.round(4).tolist(), strict=True))}
                for t in setting.tags
            ],
            "start": [*place.round(4).tolist(), round(float(low[2]), 4)],
            "reader": packed(_reader(setting, reader), step=0.0005, most=65535),
            "paths": [_paths(setting, number, reader) for number in range(len(setting.tags))],
            "way_z": float(low[2]) + 0.02,
            "ways": [
                {
                    "points": packed(
                        way.points_m[:: -(-len(way.points_m) // 400)], step=0.005, most=65535
                    ),
                    "end": way.end,
                }
                for way in ways
            ],
        },
        fallback=fallback,
    )


def _inward(face: Face) -> FloatArray:
    """Return a face's triangles; those of a wall run counter-clockwise as seen from inside."""
    corners = face.triangles_m
    if not face.wall:
        return corners
    inward = -face.normal if face.cut_away else face.normal
    a, b, c = np.moveaxis(corners, 1, 0)
    turned = np.cross(b - a, c - a) @ inward < 0.0
    return np.where(turned[:, None, None], corners[:, ::-1], corners)


def _parts(faces: Sequence[Face], triangles: Sequence[FloatArray]) -> list[dict[str, object]]:
    areas = np.concatenate([_areas(t) for t in triangles])
    least = 0.0
    if len(areas) > MOST_TRIANGLES:
        least = float(np.sort(areas)[-MOST_TRIANGLES])
    groups: dict[tuple[str, bool], list[FloatArray]] = {}
    for face, corners in zip(faces, triangles, strict=True):
        kept = corners[_areas(corners) >= least]
        if len(kept):
            groups.setdefault((face.material, face.wall), []).append(kept)
    return [
        {
            "name": _name(material),
            "colour": _hex(material),
            "opacity": looks_of(material).opacity,
            "wall": wall,
            "triangles": packed(np.concatenate(some), step=_MM, most=65535),
        }
        for (material, wall), some in groups.items()
    ]


def _areas(triangles_m: FloatArray) -> FloatArray:
    a, b, c = np.moveaxis(triangles_m, 1, 0)
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1))


def _edges(faces: Sequence[Face]) -> FloatArray:
    edges = np.concatenate([face.rim_m for face in faces])
    if len(edges) <= MOST_EDGES:
        return edges
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    return edges[np.argsort(-length, kind="stable")[:MOST_EDGES]]


def _reader(setting: Setting, place_m: FloatArray) -> FloatArray:
    body = setting.reader.body().body
    return np.asarray(body.vertices_m[body.faces] + place_m)


def _paths(setting: Setting, number: int, reader_m: FloatArray) -> list[dict[str, object]]:
    """Return the strongest paths from a tag to a vertical isotropic antenna, [m] and [dB]."""
    tag, radio = setting.tags[number], setting.radios[0]
    found = trace_paths(radio, setting.candidates(tag.position_m), reader_m[None])
    if not len(found):
        return []
    end = make_antenna("isotropic_theta", radio.frequency_hz)
    gains = path_gains(radio, found, transmitter=tag.antennas[0], receiver=end)
    level = decibels(np.maximum(np.abs(gains.gain) ** 2, 1e-30))
    order = np.argsort(-level, kind="stable")[:MOST_PATHS]
    return [
        {
            "points": found.vertices_of(k).round(3).tolist(),
            "gain_db": round(float(level[k]), 1),
            "bends": int(found.order[k]),
        }
        for k in order
    ]


def _name(material: str) -> str:
    for part in material.split(","):
        key, _, value = part.partition("=")
        if key.strip() == "name":
            return value.strip()
    return material


def _hex(material: str) -> str:
    return "#" + "".join(f"{round(255 * c):02x}" for c in looks_of(material).colour)
