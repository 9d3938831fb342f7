"""A first study of a mesh file: what is guessed, put to the test, and written down."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from octant.geometries.bodies import Body
from octant.geometries.errors import ConfigError
from octant.geometries.guesses import FrameGuess, odd_shape
from octant.geometries.mesh_files import (
    Reading,
    UpAxis,
    frame_of,
    load_bodies,
    materials_of_file,
    toml_key,
)
from octant.geometries.scene import Scene, build_scene
from octant.reader_design.drafting.floor import OpenFloor, floor_level_m, open_floor
from octant.reader_design.drafting.materials import BodyMaterial, body_materials
from octant.reader_design.drafting.places import DraftPlaces, choose_places
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.loading import parse_study

FREQUENCY_HZ = 2.44e9
CHANNELS_HZ = (2.405e9, 2.43e9, 2.455e9, 2.48e9)
"""Carrier and hopping channels of a draft, in the band at 2.4 GHz [Hz]."""
FEW_FACES, MANY_FACES = 120, 1500
"""Faces of a scene up to which three reflections are searched, and up to which all are [-]."""
RAYS = 200_000
"""Rays launched where there are more faces [-]."""
MAP_PLACES = 2500.0
"""Places of a map, about [-]."""
LEAST_INSIDE = 0.02
"""Share of the floor that must be inside the room for it to be one [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """A study that was drafted.

    Parameters
    ----------
    text : The study file.
    setting : The same, ready to compute.
    said : What was guessed, in sentences.
    """

    text: str
    setting: Setting
    said: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Found:
    """What is known of a mesh before the study is written."""

    mesh: str
    guess: FrameGuess
    bodies: tuple[Body, ...]
    materials: tuple[BodyMaterial, ...]
    scene: Scene
    is_room: bool
    floor: OpenFloor
    places: DraftPlaces
    height_m: float | None

    @property
    def faces(self) -> int:
        """Flat faces of the scene [-]."""
        return len(self.scene.facets.facet_plane)

    @property
    def transmission(self) -> bool:
        """Whether sheets let waves through: some do, and all paths are searched."""
        through = any(one.thickness_m is not None for one in self.materials)
        return through and self.faces <= MANY_FACES


def draft_study(mesh: Path, out: Path, *, reading: Reading | None = None) -> Draft:
    """Return a study of a room from its mesh file, such that it can be mapped and driven in.

    A mesh in which no robot could drive is refused with a sentence.

    Parameters
    ----------
    mesh : Any file that `load_bodies` reads.
    out : Where the study will lie, from which it names the mesh.
    reading : How a world or a floor plan is read.
    """
    how = reading or Reading()
    guess = frame_of(mesh, reading=how)
    up: UpAxis = "y" if guess.up == "y" else "z"
    bodies = load_bodies(mesh, unit=guess.unit, up=up, material="any", reading=how)
    materials = body_materials(
        bodies, materials_of_file(mesh, reading=how), frequency_hz=FREQUENCY_HZ
    )
    labels = {one.body: one.name or one.why for one in materials}
    bodies = tuple(replace(body, material=labels[body.name]) for body in bodies)
    scene, is_room, floor = _room(mesh, bodies)
    found = _Found(
        mesh=os.path.relpath(mesh, out.parent),
        guess=guess,
        bodies=bodies,
        materials=materials,
        scene=scene,
        is_room=is_room,
        floor=floor,
        places=_chosen(mesh, scene, floor),
        height_m=how.height_m,
    )
    text = _text(out.stem, found, how)
    study = parse_study(text, source=str(out), directory=out.parent.resolve())
    return Draft(text=text, setting=build_setting(study), said=tuple(_said(found)))


def _room(mesh: Path, bodies: Sequence[Body]) -> tuple[Scene, bool, OpenFloor]:
    """Return the scene, whether it is a room (not only objects), and where a robot can stand."""
    scene = build_scene(bodies)
    level_m = floor_level_m(scene)
    if level_m is None:
        size = " x ".join(f"{c:.3g}" for c in np.ptp(scene.bounds_m, axis=0))
        msg = (
            f"{mesh} ({size} m) has no level floor with a metre free above it, on which a robot "
            "could drive; add a floor to the mesh, or check unit and axis with octant audit."
        )
        raise ConfigError(msg)
    scene = replace(scene, floor_m=level_m)
    floor = open_floor(scene, level_m)
    if floor.places_m.size:
        return scene, True, floor
    # A floor or a site without walls around is no room: everything is then an object in the open.
    scene = build_scene((), objects=bodies, floor_m=level_m)
    return scene, False, open_floor(scene, level_m)


def _chosen(mesh: Path, scene: Scene, floor: OpenFloor) -> DraftPlaces:
    try:
        return choose_places(scene, floor)
    except ConfigError as exc:
        msg = f"{mesh}: {exc}"
        raise ConfigError(msg) from exc


def _text(name: str, found: _Found, how: Reading) -> str:
    """Return the study file."""
    blocks = [
        (
            f"# A first study of {found.mesh}, written by octant init. 'guessed' marks what\n"
            "# you should look over; the reference of the study file describes every key.\n"
            f"name = {_quoted(name)}\nseed = 1"
        ),
        (
            "[radio]\n"
            f"frequency_hz = {FREQUENCY_HZ:.4g}\n"
            f"channels_hz = [{', '.join(f'{f:.4g}' for f in CHANNELS_HZ)}]"
            "   # hopping: a reading is the mean over them"
        ),
        *_room_blocks(found, how),
        *_tag_blocks(found),
        (
            "[reader]                # eight dipoles between plates, 0.3 m above the floor\n"
            "antenna_radius_m = 0.10\nplate_height_m = 0.08"
        ),
        _solver_block(found),
        f"[map]\nspacing_m = {_spacing_m(found):g}",
        _mission_block(found),
    ]
    return "\n\n".join(blocks) + "\n"


def _room_blocks(found: _Found, how: Reading) -> list[str]:
    guess, level = found.guess, found.floor.level_m
    unit = [] if guess.unit is None else [f'unit = "{guess.unit}"   # guessed: {guess.unit_reason}']
    axis = f'up = "{guess.up}"   # {"guessed: " if guess.against else ""}{guess.up_reason}'
    floor = f"floor_m = {_number(level)}   # guessed: the lowest level with room above it"
    more = []
    if how.geometry != "visual":
        more.append(f'geometry = "{how.geometry}"')
    if how.resource_path:
        listed = ", ".join(_quoted(os.path.abspath(p)) for p in how.resource_path)  # noqa: PTH100
        more.append(f"resource_path = [{listed}]")
    if how.metres_per_pixel is not None:
        more.append(f"metres_per_pixel = {how.metres_per_pixel:g}")
    if how.height_m is not None:
        more.append(f"height_m = {how.height_m:g}   # of the walls")
    lines = [_material_line(one) for one in found.materials]
    note = "one for each body; without thickness_m it is opaque"
    if found.is_room:
        keys = [f"mesh = {_quoted(found.mesh)}", *unit, axis, *more, floor]
        return ["[room]\n" + "\n".join(keys), f"[room.materials]   # {note}\n" + "\n".join(lines)]
    head = (
        "[room]                  # no walls close it: the mesh stands in the open\n"
        f"free_space = true\n{floor}"
    )
    keys = ['kind = "mesh"', f"file = {_quoted(found.mesh)}", *unit, axis, *more]
    keys += ["position_m = [0.0, 0.0, 0.0]", 'material = "concrete"   # of bodies not named below']
    table = "[room.object.materials]"
    return [
        head,
        "[[room.object]]\n" + "\n".join(keys),
        f"{table}   # {note}\n" + "\n".join(lines),
    ]


def _material_line(one: BodyMaterial) -> str:
    key = toml_key(one.body)
    if one.name is None:
        return f"# {key} has its properties from the file: {one.why}"
    value = _quoted(one.name)
    if one.thickness_m is not None:
        value = f"{{ name = {value}, thickness_m = {one.thickness_m:g} }}"
    return f"{key} = {value}   # {one.why}"


def _tag_blocks(found: _Found) -> list[str]:
    blocks = []
    for i, (place, on) in enumerate(
        zip(found.places.tags_m, found.places.on_ceiling, strict=True), 1
    ):
        where = "under the ceiling" if on else "in the air, as no ceiling is near"
        blocks.append(
            f'[[tag]]\nid = "{i}"\nposition_m = {_point(place)}   # guessed: {where}\n'
            'antenna = "conical_patch"'
        )
    return blocks


def _solver_block(found: _Found) -> str:
    lines = ["[solver]"]
    if found.faces <= MANY_FACES:
        order = 3 if found.faces <= FEW_FACES else 2
        lines += [f"max_reflections = {order}   # {found.faces} flat faces: every path is searched"]
    else:
        lines += [
            f'search = "rays"   # {found.faces} flat faces are too many to search every path',
            f"rays = {RAYS}",
            "max_reflections = 2",
        ]
    if found.transmission:
        lines.append("transmission = true   # through sheets that have a thickness_m")
    return "\n".join(lines)


def _mission_block(found: _Found) -> str:
    places = found.places
    names = ", ".join(f'"{i}"' for i in range(1, len(places.tags_m) + 1))
    return (
        "[mission]\n"
        f"start_m = {_point(places.start_m)}   # guessed: free floor, in sight of the first tag\n"
        f"heading_deg = {_number(places.heading_deg)}\n"
        f"tags = [{names}]\n"
        'navigator = "tracker"\n'
        "runs = 10\nnoise_db = 1.0"
    )


def _spacing_m(found: _Found) -> float:
    """Return the spacing of the map [m]: about `MAP_PLACES` over the floor, in steps of 5 cm."""
    size = np.ptp(found.scene.bounds_m, axis=0)
    if not found.is_room:
        return 0.1
    return max(0.1, float(np.ceil(np.sqrt(size[0] * size[1] / MAP_PLACES) / 0.05)) * 0.05)


def _said(found: _Found) -> list[str]:
    """Return what was guessed, in sentences."""
    guess, places = found.guess, found.places
    size = (
        np.ptp(found.scene.bounds_m, axis=0)
        if found.is_room
        else np.ptp(np.concatenate([body.bounds_m for body in found.bodies]), axis=0)
    )
    triangles = sum(len(body.faces) for body in found.bodies)
    unit = guess.unit or ("m" if guess.metres == 1.0 else f"{guess.metres:g} m")
    said = [
        (
            f"{found.mesh}: {size[0]:.4g} x {size[1]:.4g} m, {size[2]:.4g} m high; "
            f"{len(found.bodies)} bodies, {triangles} triangles, {found.faces} flat faces."
        ),
        f"unit {unit}: {guess.unit_reason}.",
        f"up {guess.up}: {guess.up_reason}.",
    ]
    if odd := odd_shape(size):
        said.append(f"the room is {odd}, an odd shape; if it lies on its side, correct room.up.")
    if not found.is_room:
        said.append("no walls close it, so it stands as an object in the open.")
    guessed = [one for one in found.materials if one.why.startswith("guessed")]
    if guessed:
        blind = sum(one.why.startswith("guessed:") for one in guessed)
        said.append(
            f"materials of {len(guessed)} bodies are guessed from their names"
            + (f", {blind} of which say nothing (concrete)." if blind else ".")
        )
    if found.faces > MANY_FACES:
        said.append(
            f"{found.faces} faces are too many to search every path: rays are launched instead "
            "(solver.search), and walls are opaque."
        )
    hang = "under the ceiling" if all(places.on_ceiling) else "in the air, as no ceiling is near"
    where = ", ".join(f"({x:g}, {y:g}, {z:g})" for x, y, z in places.tags_m)
    said.append(
        f"{len(places.tags_m)} tag(s) {hang} at {where} m; the robot starts at "
        f"({places.start_m[0]:g}, {places.start_m[1]:g}) m."
    )
    return said


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _number(value: float) -> str:
    return repr(round(float(value), 6) + 0.0)


def _point(place: Sequence[float]) -> str:
    return "[" + ", ".join(_number(c) for c in place) + "]"
