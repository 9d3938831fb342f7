"""Mesh files: rooms in every format that is read, in metres and z up, with materials by name."""

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Literal
from urllib.parse import unquote

import numpy as np

from octant.geometries._checks import refuse_unknown_keys
from octant.geometries._obj_files import Part, read_obj, write_obj
from octant.geometries._trimesh_files import GLTF, read_with_trimesh
from octant.geometries.appearance import gltf_visual
from octant.geometries.bodies import FARTHEST_M, Body, placed
from octant.geometries.collada_files import read_collada
from octant.geometries.conversions import refuse_kind
from octant.geometries.errors import GeometryError
from octant.geometries.floor_plans import DEFAULT_HEIGHT_M, PLANS, plan_files, read_plan
from octant.geometries.guesses import FrameGuess, guess_frame
from octant.geometries.material_names import USUAL, guess_material
from octant.geometries.mitsuba_scene import read_mitsuba
from octant.geometries.names import nearest_name
from octant.geometries.planes import FLOAT32_BITS, observed_rounding
from octant.geometries.sdf_worlds import read_sdf
from octant.geometries.tolerances import LENGTHS
from octant.geometries.urdf_robots import read_urdf
from octant.geometries.world_places import world_places
from octant.geometries.world_shapes import Shown, WorldReading

UpAxis = Literal["y", "z"]

METRES_PER_UNIT: Mapping[str, float] = MappingProxyType(
    {
        name: metres
        for metres, names in (
            (1.0, "m metre metres meter meters"),
            (0.1, "dm decimetre decimetres decimeter decimeters"),
            (0.01, "cm centimetre centimetres centimeter centimeters"),
            (0.001, "mm millimetre millimetres millimeter millimeters"),
            (1e-6, "um micron microns micrometre micrometres micrometer micrometers"),
            (1000.0, "km kilometre kilometres kilometer kilometers"),
            (0.0254, "in inch inches"),
            (0.3048, "ft foot feet"),
            (0.9144, "yd yard yards"),
        )
        for name in names.split()
    }
)
"""Length of each unit that a mesh file may be given in [m]."""

NAMED_FORMATS = (*GLTF, "3mf")
"""Formats that keep several bodies apart when trimesh writes them."""
ONE_BODY_FORMATS = ("stl", "ply", "off")
WORLDS = ("sdf", "world", "urdf")
"""Formats of Gazebo and ROS, whose bodies stand in many files."""
_SCENE, _COLLADA = "xml", "dae"
_NOT_SURFACES = ("xyz", "stl_ascii")  # points only; an internal name that no file carries


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """How files are read that hold more than a mesh.

    Parameters
    ----------
    geometry : Of SDF and URDF: what is seen, or what robots collide with.
    height_m : Height of the walls of a floor plan [m]; None: `DEFAULT_HEIGHT_M`.
    metres_per_pixel : Scale of a floor plan that is a picture [m].
    resource_path : Folders in which SDF and URDF look for models besides the usual ones.
    """

    geometry: Shown = "visual"
    height_m: float | None = None
    metres_per_pixel: float | None = None
    resource_path: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Contents:
    """What stands in a mesh file: parts [unit of the file], and what it says of itself."""

    parts: list[Part]
    says: str
    metres: float | None = None
    up: str | None = None
    fixed_unit: bool = False
    own: dict[str, str] = field(default_factory=dict)
    stored: dict[str, float] = field(default_factory=dict)


def metres_per_unit(unit: str) -> float:
    """Return the length of a named unit [m].

    Parameters
    ----------
    unit : A key of `METRES_PER_UNIT`, such as "m", "cm", "mm", "in" or "ft"; case does not matter.
    """
    try:
        return METRES_PER_UNIT[unit.strip().lower()]
    except (KeyError, AttributeError) as exc:
        near = nearest_name(str(unit), METRES_PER_UNIT)
        msg = (
            f"unit {unit!r} is unknown; give m, dm, cm, mm, um, km, in, ft or yd, or one of their "
            f"English names (did you mean {near!r}?)."
        )
        raise GeometryError(msg) from exc


def readable_extensions() -> tuple[str, ...]:
    """Return the file extensions, lower case without dot, that `load_bodies` can read here."""
    from trimesh.exchange.load import mesh_formats

    more = {"obj", _SCENE, _COLLADA, *WORLDS, *PLANS}
    return tuple(sorted((mesh_formats() | more) - {*_NOT_SURFACES, "zae"}))


def carries_materials(path: str | Path) -> bool:
    """Return whether files of this kind may name materials of bodies: GLB, GLTF, Mitsuba XML.

    Parameters
    ----------
    path : A mesh file; it need not exist.
    """
    return _extension(Path(path)) in (*GLTF, _SCENE)


def declares_unit(path: str | Path) -> bool:
    """Return whether files of this kind say in which unit they are drawn.

    Parameters
    ----------
    path : A mesh file; it need not exist.
    """
    return _extension(Path(path)) in (*GLTF, "3mf", _SCENE, _COLLADA, *WORLDS, *PLANS)


def files_named(path: str | Path) -> tuple[Path, ...]:
    """Return the other files in which bodies of a mesh file stand, sorted: what it is changed by.

    They are every file that a text in quotes of a GLTF or Mitsuba XML file names, relative to it;
    the models and meshes of an SDF or URDF file; the image of a map.

    Parameters
    ----------
    path : A mesh file, or any other: nothing.
    """
    file = Path(path)
    kind = _extension(file)
    if kind in WORLDS:
        return tuple(sorted(_world_files(file, kind)))
    if kind in PLANS:
        return plan_files(file)
    if kind not in {"gltf", _SCENE}:
        return ()
    text = file.read_text(errors="replace")
    quoted = set(re.findall(r"[\"']([^\"'\n]{1,500})[\"']", text))
    found = {file.parent / unquote(name) for name in quoted}
    # Unlike Path.is_file, isfile takes any text, however long, for a name that may not exist.
    return tuple(sorted(name for name in found if os.path.isfile(name) and name != file))  # noqa: PTH113


def frame_of(path: str | Path, *, reading: Reading | None = None) -> FrameGuess:
    """Return the unit and the vertical axis that a mesh file seems to be drawn in, with reasons.

    Parameters
    ----------
    path, reading : As for `load_bodies`.
    """
    file = Path(path)
    contents = _contents(file, _kind_of(file), reading or Reading())
    _refuse_nothing(file, contents)
    if not any(np.isfinite(vertices).all(axis=1).any() for _, vertices, _ in contents.parts):
        msg = f"{file} has no corner whose coordinates are all finite; export it anew."
        raise GeometryError(msg)
    return guess_frame(
        [(name, vertices) for name, vertices, _ in contents.parts],
        declared_m=contents.metres,
        declared_up=contents.up,
        says=contents.says,
        fixed=contents.fixed_unit,
    )


def materials_of_file(path: str | Path, *, reading: Reading | None = None) -> dict[str, str]:
    """Return the material that a mesh file itself gives each body, by name; none where it does not.

    Parameters
    ----------
    path, reading : As for `load_bodies`.
    """
    file = Path(path)
    return dict(_contents(file, _kind_of(file), reading or Reading()).own)


def load_bodies(
    path: str | Path,
    *,
    unit: str | None = None,
    material: str | None = None,
    materials_by_name: Mapping[str, str] | None = None,
    up: UpAxis | None = None,
    reading: Reading | None = None,
) -> tuple[Body, ...]:
    """Return the bodies of a mesh file, in metres and z up, exactly as meshed in the file.

    One for each object, its placing applied, named by node (GLB, GLTF, DAE), object (OBJ ``o`` and
    ``g``, 3MF), solid (ASCII STL), model (SDF), link (URDF), or else the file; several materials in
    one (GLB, OBJ, DAE) give ``object.material`` each. Files that are unreadable, empty or not
    finite are refused, and units or materials that are missing or contradict the file.

    Nothing is merged, repaired or left out but points and lines; see `octant.geometries.audit`.
    Concave polygons are right in OBJ; those of PLY, OFF and DAE are cut into fans, right for convex
    ones only (the audit reports folded triangles). GLB, GLTF, binary STL and most PLY files hold
    float32: 0.5 µm at 5 m. Units and axes: Khronos Group, glTF 2.0 Specification, section 3.4; 3MF
    Core Specification 1.3, section 3.4. Meshes inside SDF and URDF keep their axes, as in Gazebo,
    which does not turn COLLADA's.

    Parameters
    ----------
    path : Any file that trimesh reads: STL, OBJ, PLY, OFF, GLB, GLTF, 3MF and more; XML of Mitsuba
        or Sionna RT (`octant.geometries.mitsuba_scene`); COLLADA; SDF, world and URDF of Gazebo and
        ROS; a YAML of ROS' map_server, a picture or a DXF (`octant.geometries.floor_plans`).
    unit : Unit of the coordinates, such as "m" or "mm"; may be left out where `declares_unit`.
    material : Label of bodies that `materials_by_name` lacks; GLB, GLTF and XML may have their own.
    materials_by_name : Label of each body by its exact name.
    up : The vertical axis; None: "y" for GLB and GLTF by specification, what a DAE says, else "z".
        Give "z" for a GLB written without the conversion (trimesh's own export, for one).
    reading : How worlds and floor plans are read.
    """
    file = Path(path)
    kind = _kind_of(file)
    contents = _contents(file, kind, reading or Reading())
    parts, stored = contents.parts, contents.stored
    _refuse_nothing(file, contents)
    scale = _metres_per_file_unit(file, contents, unit=unit)
    labels = _materials(file, [p[0] for p in parts], material, materials_by_name, contents.own)
    vertical = up or contents.up or "z"
    if vertical not in ("y", "z"):
        msg = f"up is {up!r} for {file}, but the vertical axis of a mesh file is 'y' or 'z'."
        raise GeometryError(msg)
    rounding_m = {name: scale * stored.get(name, observed_rounding(v)) for name, v, _ in parts}
    _refuse_far_float32(file, rounding_m)
    bodies = []
    for name, vertices, faces in parts:
        if (np.abs(vertices[np.isfinite(vertices)]) > FARTHEST_M / scale).any():
            msg = (
                f"body {name!r} of {file} has coordinates beyond "
                f"{FARTHEST_M / scale:g}, which is {FARTHEST_M:g} m; check the file and its unit."
            )
            raise GeometryError(msg)
        upright = vertices[:, [0, 2, 1]] * (1.0, -1.0, 1.0) if vertical == "y" else vertices
        try:
            body = Body(
                name=name,
                vertices_m=upright * scale,
                faces=faces,
                material=labels[name],
                rounding_m=rounding_m[name],
            )
        except GeometryError as exc:
            msg = f"{file}: {exc}"
            raise GeometryError(msg) from exc
        bodies.append(body)
    return tuple(bodies)


def _refuse_nothing(file: Path, contents: _Contents) -> None:
    if not contents.parts:
        kind = _kind_of(file).upper()
        msg = (
            f"{file} holds no triangles; it is empty, or not a {kind} mesh, or holds only points "
            "and lines."
        )
        raise GeometryError(msg)


def _contents(file: Path, kind: str, reading: Reading) -> _Contents:
    """Return what stands in an existing mesh file."""
    if kind == "obj":
        return _Contents(parts=read_obj(file), says="OBJ")
    if kind == _SCENE:
        shapes = read_mitsuba(file, load_bodies)
        given = {s.name: s.material for s in shapes if s.material}
        parts = [(s.name, s.vertices, s.faces) for s in shapes]
        return _Contents(parts=parts, says="Mitsuba", metres=1.0, up="z", own=given)
    if kind == _COLLADA:
        parts, metres, up = read_collada(file)
        return _Contents(parts=parts, says="the DAE file", metres=metres, up=up)
    if kind in WORLDS:
        parts = _read_world(file, kind, reading)[0]
        says = "URDF" if kind == "urdf" else "SDF"
        return _Contents(parts=parts, says=says, metres=1.0, up="z", fixed_unit=True)
    if kind in PLANS:
        height_m = reading.height_m or DEFAULT_HEIGHT_M
        parts = read_plan(file, height_m, reading.metres_per_pixel)
        says = "the floor plan"
        return _Contents(parts=parts, says=says, metres=1.0, up="z", fixed_unit=True)
    own: dict[str, str] = {}
    stored: dict[str, float] = {}
    parts, declared = read_with_trimesh(file, kind, own, stored)
    return _Contents(
        parts=parts,
        says="glTF" if kind in GLTF else kind.upper(),
        metres=None if declared is None else metres_per_unit(declared),
        up="y" if kind in GLTF else None,
        fixed_unit=kind == "3mf",
        own=own,
        stored=stored,
    )


def _read_world(file: Path, kind: str, reading: Reading) -> tuple[list[Part], tuple[Path, ...]]:
    """Return the parts of an SDF or URDF file [m], and the other files that it was read from."""
    world = WorldReading(
        places=world_places(file, reading.resource_path),
        load_mesh=_world_mesh,
        geometry=reading.geometry,
        files={},
        meshes={},
    )
    shapes = (read_urdf if kind == "urdf" else read_sdf)(file, world)
    return [(s.name, s.vertices, s.faces) for s in shapes], tuple(world.files)


def _world_mesh(file: Path) -> tuple[Body, ...]:
    """Return the bodies of a world's mesh: its unit where the file has one, its axes as drawn."""
    if _extension(file) in (*WORLDS, *PLANS, _SCENE):
        msg = f"{file} is not a mesh, but a mesh is needed here; name one."
        raise GeometryError(msg)
    unit = None if declares_unit(file) else "m"
    up: UpAxis | None = "z" if _extension(file) == _COLLADA else None
    return load_bodies(file, unit=unit, up=up, material="any")


def _world_files(file: Path, kind: str) -> tuple[Path, ...]:
    try:
        return _read_world(file, kind, Reading())[1]
    except GeometryError:  # it is refused with a sentence where it is loaded
        return ()


def _extension(file: Path) -> str:
    return file.suffix.lower().removeprefix(".")


def mesh_object(
    path: str | Path,
    *,
    unit: str | None = None,
    material: str | None = None,
    materials_by_name: Mapping[str, str] | None = None,
    up: UpAxis | None = None,
    position_m: Sequence[float] = (0.0, 0.0, 0.0),
    yaw_deg: float = 0.0,
    name: str | None = None,
    reading: Reading | None = None,
) -> tuple[Body, ...]:
    """Return the bodies of a mesh file, put in their place.

    Parameters
    ----------
    path : Any file that `load_bodies` reads.
    unit : Unit of the file's coordinates; None where the format declares it.
    up : The file's vertical axis; None: the format's own.
    material : Label for every body that `materials_by_name` does not name.
    materials_by_name : Label of each body by its exact name in the file.
    position_m : (3,) — Where the origin of the file's frame comes to stand [m].
    yaw_deg : Turn about the vertical through it, from +x towards +y [deg].
    name : Name of a single body; several become ``name.body``. None: the file's names.
    reading : How worlds and floor plans are read.
    """
    bodies = load_bodies(
        path,
        unit=unit,
        material=material,
        materials_by_name=materials_by_name,
        up=up,
        reading=reading,
    )
    if name is not None:
        single = len(bodies) == 1
        bodies = tuple(replace(b, name=name if single else f"{name}.{b.name}") for b in bodies)
    return tuple(placed(body, position_m, yaw_deg) for body in bodies)


def _kind_of(file: Path) -> str:
    """Return the extension of an existing file, once it is known to be readable."""
    if not file.is_file():
        what = "is a folder" if file.is_dir() else "does not exist"
        msg = f"mesh file {file} {what}; give the path of a mesh file."
        raise GeometryError(msg)
    kind = _extension(file)
    known = readable_extensions()
    if kind not in known:
        refuse_kind(file, known)
    return kind


def _metres_per_file_unit(file: Path, contents: _Contents, *, unit: str | None) -> float:
    """Return the length of the file's unit [m], from the caller or from the file itself."""
    declared = contents.metres
    if unit is None and declared is None:
        msg = (
            f'{file} does not say in which unit it is drawn; give one, such as unit = "m" or '
            'unit = "mm".'
        )
        raise GeometryError(msg)
    if unit is None:
        return float(declared or 1.0)
    given = metres_per_unit(unit)
    if contents.fixed_unit and not math.isclose(given, declared or 1.0):
        names = [name for name, metres in METRES_PER_UNIT.items() if metres == declared]
        said = max(names, key=len) if names else f"{declared:g} m"
        msg = f"{file} declares its unit as {said}, but unit {unit!r} was given; leave it out."
        raise GeometryError(msg)
    return given


def _materials(
    file: Path,
    names: Sequence[str],
    material: str | None,
    materials_by_name: Mapping[str, str] | None,
    own: Mapping[str, str],
) -> dict[str, str]:
    """Return the material label of every body: by name, for all, or the file's own."""
    by_name = dict(materials_by_name or {})
    refuse_unknown_keys(by_name, allowed=names, name=f"the material table of {file}")
    labels = {name: by_name.get(name, material) or own.get(name) for name in names}
    without = [name for name, label in labels.items() if label is None]
    if without:
        guessed = [(name, (guess_material(name) or (USUAL,))[0]) for name in without]
        lines = ", ".join(f'{toml_key(name)} = "{label}"' for name, label in guessed)
        which = (
            f"body {without[0]!r} of {file} has"
            if len(without) == 1
            else (f"{len(without)} bodies of {file} have")
        )
        msg = (
            f"{which} no material; give one for the whole file, or paste into [room] and correct: "
            f"materials = {{ {lines} }}"
        )
        raise GeometryError(msg)
    return {name: label for name, label in labels.items() if label is not None}


def toml_key(name: str) -> str:
    """Return a name as a key of TOML: in quotes where it needs them.

    Parameters
    ----------
    name : Of a body.
    """
    if re.fullmatch(r"[A-Za-z0-9_-]+", name):
        return name
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _refuse_far_float32(file: Path, rounding_m: Mapping[str, float]) -> None:
    """Refuse a file so far from its origin that float32 has moved its corners noticeably."""
    least = min(rounding_m.values())
    if 4.0 * least > LENGTHS.step_m:
        msg = (
            f"{file} stands {least * 2**FLOAT32_BITS / 1000.0:.4g} km from its origin and holds "
            f"float32 numbers, which are rounded to {2000.0 * least:.2g} mm there, so that thin "
            "walls bend or vanish; export it about an origin of its own (and move it with "
            "room.origin_m), or with all digits of float64, as OBJ."
        )
        raise GeometryError(msg)


def save_bodies(
    bodies: Sequence[Body], path: str | Path, *, opacity: Mapping[str, float] | None = None
) -> None:
    """Write bodies to a mesh file that `load_bodies` reads back to the same place.

    OBJ, OFF and 3MF keep all the digits that matter; GLB, GLTF, STL and PLY keep float32.

    Parameters
    ----------
    bodies : In metres and z up, of different names. Only GLB and GLTF keep materials.
    path : GLB or GLTF (metres, y up), 3MF (millimetres), OBJ (metres), or STL, PLY, OFF (metres, no
        names: all bodies become one). An existing file is overwritten.
    opacity : Opacity of bodies by name in GLB and GLTF [-], where it is not the material's own.
    """
    file = Path(path)
    kind = file.suffix.lower().removeprefix(".")
    writable = sorted({"obj", *NAMED_FORMATS, *ONE_BODY_FORMATS})
    if kind not in writable:
        listed = ", ".join(f".{k}" for k in writable)
        msg = f"{file} ends in '.{kind}', but only {listed} can be written."
        raise GeometryError(msg)
    names = [body.name for body in bodies]
    if not names or len(set(names)) < len(names):
        problem = "there is no body" if not names else f"names repeat among {', '.join(names)}"
        msg = f"cannot write {file}, because {problem}; give bodies with distinct names."
        raise GeometryError(msg)
    if not file.parent.is_dir():
        msg = f"cannot write {file}, because the folder {file.parent} does not exist; create it."
        raise GeometryError(msg)
    if kind == "obj":
        write_obj([(b.name, b.vertices_m, b.faces) for b in bodies], file)
    else:
        _write_with_trimesh(bodies, file, kind, opacity or {})


def _write_with_trimesh(
    bodies: Sequence[Body], file: Path, kind: str, opacity: Mapping[str, float]
) -> None:
    """Write bodies in one of the formats that are left to trimesh."""
    import trimesh

    meshes = {}
    for body in bodies:
        vertices = body.vertices_m
        if kind in GLTF:
            vertices = vertices[:, [0, 2, 1]] * (1.0, 1.0, -1.0)
        elif kind == "3mf":
            vertices = vertices * 1000.0
        mesh = trimesh.Trimesh(vertices, body.faces, process=False)
        if kind in GLTF:
            mesh.visual = gltf_visual(body.material, opacity=opacity.get(body.name))
        meshes[body.name] = mesh
    if kind in ONE_BODY_FORMATS:
        digits = {"digits": 15} if kind == "off" else {}
        trimesh.util.concatenate(list(meshes.values())).export(str(file), **digits)
        return
    scene = trimesh.Scene()
    for name, mesh in meshes.items():
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    options = {"embed_buffers": True} if kind == "gltf" else {}
    scene.export(str(file), **options)
