"""What stands between a tag and the robot, and where it would not."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.medium.materials import Material
from octant.geometries.bodies import Body
from octant.geometries.occlusion import build_bvh, segments_blocked
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.experiments.missions.compute import mission_space
from octant.reader_design.setting.advice import OPAQUE_S_PER_M
from octant.reader_design.setting.robot import floor_places_m
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.bodies import study_materials
from octant.reader_design.study_file.changes import Step
from octant.reader_design.study_file.materials import material_label
from octant.reader_design.study_file.room import MaterialSpec, RoomObject

FloatArray = npt.NDArray[np.float64]

AROUND_M = (0.0, 0.25, 0.5)
"""Distances from a tag's point on the floor [m] at which the robot should see the tag."""
AZIMUTHS = 8
"""Places at each of them [-]."""
SHADED = 0.5
"""Share of these places without a free way to the tag from which it counts as shadowed [-]."""
SHEET_M = 0.1
"""Thickness that is proposed for a wall drawn as one sheet [m]."""
SOLID_M, HOLLOW_M = 0.1, 0.02
"""Thickness [m] above which a closed body is taken for a hollow one; thickness of its walls [m]."""
CLOSED = 1e-6
"""Sum of a body's areas as vectors, by its area, up to which it is closed [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wall:
    """The material of a body in the way, where the study names it.

    Attributes
    ----------
    path, spec, of : Its key, what stands there, and which table of a list that is.
    thickness_m, why : Thickness that is proposed, and why so much [m].
    """

    path: tuple[Step, ...]
    spec: MaterialSpec
    of: str
    thickness_m: float
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Shadow:
    """What keeps the robot from seeing a tag.

    Attributes
    ----------
    stands : Whether the robot can stand anywhere near the tag's point on the floor.
    bodies, walls : Names of the bodies in the way; the materials of those that could let waves
        through. None where the tag is seen.
    """

    stands: bool
    bodies: tuple[str, ...] = ()
    walls: tuple[Wall, ...] = ()


def shadow_of(setting: Setting, tag_id: str, ends: Sequence[FloatArray] = ()) -> Shadow:
    """Return what stands between a tag and the robot near the tag's point on the floor.

    Parameters
    ----------
    setting, tag_id : The reader in its room; the tag.
    ends : Poses [m], [rad] from which the robot should have seen it, too.
    """
    tag = setting.tag(tag_id)
    space = mission_space(setting)
    near = _around(tag.point_m)
    near = near[space(near)]
    if not len(near):
        return Shadow(stands=False)
    shaded = _shading(setting, tag.position_m, near)
    far = np.array([pose[:2] for pose in ends]).reshape(-1, 2)
    if shaded.any(axis=0).mean() < SHADED:
        shaded = _shading(setting, tag.position_m, far)
        if not len(far) or shaded.any(axis=0).mean() < SHADED:
            return Shadow(stands=True)
    bodies = [b for b, row in zip(setting.scene.bodies, shaded, strict=True) if row.any()]
    return Shadow(
        stands=True,
        bodies=tuple(dict.fromkeys(body.name for body in bodies)),
        walls=tuple(_walls(setting, bodies)),
    )


def open_place_m(setting: Setting, tag_id: str) -> tuple[float, float, float] | None:
    """Return the nearest place for a tag, as high as it is, that the robot sees from below [m].

    Parameters
    ----------
    setting, tag_id : The reader in its room; the tag.
    """
    tag = setting.tag(tag_id)
    space = mission_space(setting)
    drop_m = tag.position_m - tag.given_m
    for x, y in floor_places_m(setting.scene, tag.point_m).tolist():
        place = np.array([x, y, tag.given_m[2]])
        near = _around(place[:2])
        if not space(near).all():
            continue
        hung = place + drop_m
        if not setting.scene.inside_room(hung)[0] or setting.scene.inside_solid(hung)[0]:
            continue
        if not _shading(setting, hung, near).any():
            return (x, y, float(tag.given_m[2]))
    return None


def start_clearance_m(setting: Setting) -> float:
    """Return the room between the robot at its start and what is nearest [m].

    Parameters
    ----------
    setting : The reader in its room, with a mission.
    """
    space = mission_space(setting)
    return float(space.footprint.clearance_m(np.array([setting.mission.start_m]))[0])


def _around(point_m: FloatArray) -> FloatArray:
    """Return (p, 2) places around a point of the floor [m]."""
    turns = 2.0 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS
    ring = np.column_stack([np.cos(turns), np.sin(turns)])
    found: FloatArray = np.unique(
        np.concatenate([point_m + radius * ring for radius in AROUND_M]).round(6), axis=0
    )
    return found


def _shading(setting: Setting, tag_m: FloatArray, floor_m: FloatArray) -> npt.NDArray[np.bool_]:
    """Return (bodies, p), whether each body keeps waves of a tag from the reader at each place."""
    materials = study_materials(setting.study)
    reader_m = np.column_stack(
        [floor_m, np.full(len(floor_m), setting.reader_z_m + LENGTHS.step_m)]
    )
    table = np.zeros((len(setting.scene.bodies), len(floor_m)), dtype=np.bool_)
    for row, body in zip(table, setting.scene.bodies, strict=True):
        made_of = materials.get(body.material)
        if not (setting.study.solver.transmission and made_of is not None and _has_back(made_of)):
            corners = body.vertices_m[body.faces]
            tree = build_bvh(corners, np.arange(len(corners)), extent_m=setting.scene.extent_m)
            row[:] = segments_blocked(tree, np.broadcast_to(tag_m, reader_m.shape), reader_m)
    return table


def _has_back(made_of: Material) -> bool:
    return not made_of.is_pec and bool(made_of.thickness_m or made_of.layers)


def _walls(setting: Setting, bodies: Sequence[Body]) -> Iterator[Wall]:
    """Yield where the study says what the bodies are made of; conductors and the shell left out."""
    materials = study_materials(setting.study)
    named = list(_named_materials(setting))
    seen: set[str] = set()
    for body in bodies:
        made_of = materials.get(body.material)
        if body.material in seen or made_of is None or _conducts(made_of):
            continue
        seen.add(body.material)
        thickness_m, why = _thickness_m(body)
        for path, spec, of in named:
            if material_label(spec) == body.material:
                yield Wall(path=path, spec=spec, of=of, thickness_m=thickness_m, why=why)


def _conducts(made_of: Material) -> bool:
    return made_of.is_pec or made_of.sigma_c_s_per_m >= OPAQUE_S_PER_M


def _named_materials(setting: Setting) -> Iterator[tuple[tuple[Step, ...], MaterialSpec, str]]:
    """Yield the path, value and table of every material that bodies of the room are given by."""
    study, layout = setting.study, setting.layout
    room = study.room
    base: tuple[Step, ...] = ("room",)
    places: list[tuple[tuple[Step, ...], Sequence[RoomObject]]]
    places = [(("room", "object"), room.objects)]
    if layout is not None:
        number = next(i for i, one in enumerate(study.layouts) if one.name == layout.name)
        if layout.room is not None:
            room, base = layout.room, ("layout", number, "room")
            places = [((*base, "object"), room.objects)]
        places.append((("layout", number, "object"), layout.objects))
    for name, spec in room.materials.items():
        yield (*base, "materials", name), spec, ""
    for i, mesh in enumerate(room.mesh if isinstance(room.mesh, tuple) else ()):
        of = f'the one with file = "{mesh.file}"'
        for name, spec in mesh.materials.items():
            yield (*base, "mesh", i, "materials", name), spec, of
        if mesh.material is not None:
            yield (*base, "mesh", i, "material"), mesh.material, of
    if isinstance(room.material, str):
        yield (*base, "material"), room.material, ""
    for path, objects in places:
        for i, item in enumerate(objects):
            of = f'the one with name = "{item.name}"' if item.name else f"number {i + 1}"
            yield (*path, i, "material"), item.material, of


def _thickness_m(body: Body) -> tuple[float, str]:
    """Return the thickness [m] to give a body's material, and why so much."""
    a, b, c = np.moveaxis(body.vertices_m[body.faces] - body.vertices_m.mean(axis=0), 1, 0)
    areas = 0.5 * np.cross(b - a, c - a)
    area_m2 = float(np.linalg.norm(areas, axis=1).sum())
    if float(np.linalg.norm(areas.sum(axis=0))) > CLOSED * area_m2:
        return SHEET_M, "if the wall is as thick as this"
    depth_m = 2.0 * abs(float(np.sum(a * areas) / 3.0)) / area_m2
    if depth_m > SOLID_M:
        return HOLLOW_M, "if it is hollow and its walls are as thick as this"
    return float(f"{0.5 * depth_m:.2g}"), "half its thickness, as waves pass both its faces"
