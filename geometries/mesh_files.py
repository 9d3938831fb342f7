"""Mesh files: what trimesh reads, with the unit and the materials given where the file has none."""

import json
import logging
import math
import os
import re
import struct
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal
from urllib.parse import unquote

import numpy as np

from octant.geometries._checks import refuse_unknown_keys
from octant.geometries._obj_files import Part, read_obj, write_obj
from octant.geometries.appearance import gltf_visual
from octant.geometries.bodies import FARTHEST_M, Body, placed
from octant.geometries.errors import GeometryError
from octant.geometries.mitsuba_scene import read_mitsuba
from octant.geometries.names import nearest_name, unused_name
from octant.geometries.planes import FLOAT32_BITS, observed_rounding
from octant.geometries.tolerances import LENGTHS

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

GLTF = ("glb", "gltf")
NAMED_FORMATS = (*GLTF, "3mf")
"""Formats that keep several bodies apart when trimesh writes them."""
ONE_BODY_FORMATS = ("stl", "ply", "off")
_SCENE = "xml"
_NOT_SURFACES = ("xyz", "stl_ascii")  # points only; an internal name that no file carries


# Required extensions that only change how a surface looks; any other required one may hold the
# geometry itself, and trimesh would go on without it.
_LOOKS_ONLY = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_")
_HARMLESS = (*_LOOKS_ONLY, "KHR_mesh_quantization", "KHR_xmp")
_TRIANGLE_FAN = 6
_GLB_MAGIC = b"glTF"


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

    return tuple(sorted((mesh_formats() | {"obj", _SCENE}) - set(_NOT_SURFACES)))


def carries_materials(path: str | Path) -> bool:
    """Return whether files of this kind may name materials of bodies: GLB, GLTF, Mitsuba XML.

    Parameters
    ----------
    path : A mesh file; it need not exist.
    """
    return Path(path).suffix.lower().removeprefix(".") in (*GLTF, _SCENE)


def files_named(path: str | Path) -> tuple[Path, ...]:
    """Return the other files in which bodies of a mesh file stand, sorted: what it is changed by.

    They are every file that a text in quotes of a GLTF or Mitsuba XML file names, relative to it.

    Parameters
    ----------
    path : A mesh file, or any other: nothing.
    """
    file = Path(path)
    if file.suffix.lower() not in {".gltf", f".{_SCENE}"}:
        return ()
    text = file.read_text(errors="replace")
    quoted = set(re.findall(r"[\"']([^\"'\n]{1,500})[\"']", text))
    found = {file.parent / unquote(name) for name in quoted}
    # Unlike Path.is_file, isfile takes any text, however long, for a name that may not exist.
    return tuple(sorted(name for name in found if os.path.isfile(name) and name != file))  # noqa: PTH113


def load_bodies(
    path: str | Path,
    *,
    unit: str | None = None,
    material: str | None = None,
    materials_by_name: Mapping[str, str] | None = None,
    up: UpAxis | None = None,
) -> tuple[Body, ...]:
    """Return the bodies of a mesh file, in metres and z up, exactly as meshed in the file.

    One for each object, its placing applied, named by node (GLB, GLTF), object (OBJ ``o`` and
    ``g``, 3MF), solid (ASCII STL), or else the file; several materials in one (GLB, OBJ) give
    ``object.material`` each. Files that are unreadable, empty or not finite are refused, and units
    or materials that are missing or contradict the file.

    Nothing is merged, repaired or left out but points and lines; see `octant.geometries.audit`.
    Concave polygons are right in OBJ; trimesh cuts those of PLY and OFF into fans, right for convex
    ones only (the audit reports folded triangles). GLB, GLTF, binary STL and most PLY files hold
    float32: 0.5 µm at 5 m. Units and axes: Khronos Group, glTF 2.0 Specification, section 3.4; 3MF
    Core Specification 1.3, section 3.4.

    Parameters
    ----------
    path : Any file that trimesh reads: STL, OBJ, PLY, OFF, GLB, GLTF, 3MF and more; or XML of
        Mitsuba or Sionna RT (`octant.geometries.mitsuba_scene`).
    unit : Unit of the coordinates, such as "m" or "mm"; may be left out for GLB, GLTF and XML, in
        metres, and for 3MF, which declares it.
    material : Label of bodies that `materials_by_name` lacks; GLB, GLTF and XML may have their own.
    materials_by_name : Label of each body by its exact name.
    up : The vertical axis; None: "y" for GLB and GLTF by specification, else "z". Give "z" for a
        GLB written without the conversion (trimesh's own export, for one).
    """
    file = Path(path)
    kind = _kind_of(file)
    own: dict[str, str] = {}
    stored: dict[str, float] = {}
    if kind == "obj":
        parts, declared = read_obj(file), None
    elif kind == _SCENE:
        shapes = read_mitsuba(file, load_bodies)
        parts, declared = [(s.name, s.vertices, s.faces) for s in shapes], "m"
        own = {s.name: s.material for s in shapes if s.material}
    else:
        parts, declared = _read_with_trimesh(file, kind, own, stored)
    if not parts:
        msg = (
            f"{file} holds no triangles; it is empty, or not a {kind.upper()} mesh, or holds only "
            "points and lines."
        )
        raise GeometryError(msg)
    scale = _metres_per_file_unit(file, unit=unit, declared=declared)
    labels = _materials(file, [p[0] for p in parts], material, materials_by_name, own)
    vertical = up if up is not None else ("y" if kind in GLTF else "z")
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
    """
    bodies = load_bodies(
        path, unit=unit, material=material, materials_by_name=materials_by_name, up=up
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
    kind = file.suffix.lower().removeprefix(".")
    known = readable_extensions()
    if kind not in known:
        listed = ", ".join(f".{k}" for k in known)
        msg = f"mesh file {file} ends in '.{kind}', but only {listed} can be read; convert it."
        raise GeometryError(msg)
    return kind


def _metres_per_file_unit(file: Path, *, unit: str | None, declared: str | None) -> float:
    """Return the length of the file's unit [m], from the caller or from the file itself."""
    if unit is None and declared is None:
        msg = (
            f'{file} does not say in which unit it is drawn; give one, such as unit = "m" or '
            'unit = "mm".'
        )
        raise GeometryError(msg)
    if unit is None:
        return metres_per_unit(str(declared))
    given = metres_per_unit(unit)
    is_3mf = file.suffix.lower() == ".3mf"
    if is_3mf and not math.isclose(given, metres_per_unit(str(declared))):
        msg = f"{file} declares its unit as {declared}, but unit {unit!r} was given; leave it out."
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
    labels: dict[str, str] = {}
    for name in names:
        label = by_name.get(name, material) or own.get(name)
        if label is None:
            msg = (
                f"body {name!r} of {file} has no material; name it in the material table, or give "
                "one material for the whole file."
            )
            raise GeometryError(msg)
        labels[name] = label
    return labels


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


def _read_with_trimesh(
    file: Path, kind: str, own: dict[str, str], stored: dict[str, float]
) -> tuple[list[Part], str | None]:
    """Return the named, placed meshes of a file and its unit.

    ``own`` gets the materials in it, ``stored`` the rounding [unit of the file] seen in it.
    """
    try:
        with _silenced():
            parts, declared = _parts_of_scene(file, kind, own, stored)
            _refuse_lost_triangles(file, kind, parts)
            return parts, declared
    except GeometryError:
        raise
    except Exception as exc:  # trimesh's readers raise anything at all on a damaged file
        reason = str(exc) if isinstance(exc, ImportError) else "it is damaged or not complete"
        msg = f"{file} cannot be read as a {kind.upper()} mesh ({reason}); export it again."
        raise GeometryError(msg) from exc


@contextmanager
def _silenced() -> Iterator[None]:
    """Keep from the user what trimesh and NumPy say to a damaged file, which Octant refuses."""
    log, nowhere = logging.getLogger("trimesh"), logging.NullHandler()
    before, log.propagate = log.propagate, False
    log.addHandler(nowhere)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # NumPy says so, and goes on, when a text file ends in the middle of a number.
            warnings.filterwarnings("error", message=".*could not be read to its end.*")
            yield
    finally:
        log.removeHandler(nowhere)
        log.propagate = before


def _refuse_lost_triangles(file: Path, kind: str, parts: Sequence[Part]) -> None:
    """Refuse an STL text of which trimesh has left out a solid, as one that is cut off."""
    data = file.read_bytes() if kind == "stl" else b""
    if not data.lstrip().lower().startswith(b"solid") or b"\0" in data:
        return
    corners = len(re.findall(rb"^\s*vertex\s", data, re.IGNORECASE | re.MULTILINE))
    if corners != 3 * sum(len(faces) for _, _, faces in parts):
        msg = f"{file} names {corners} corners, not all within whole solids; export it again."
        raise GeometryError(msg)


def _parts_of_scene(
    file: Path, kind: str, own: dict[str, str], stored: dict[str, float]
) -> tuple[list[Part], str | None]:
    """Return what `_read_with_trimesh` does, with the errors of trimesh."""
    import trimesh

    node_names = _gltf_node_names(file) if kind in GLTF else None
    options: dict[str, Any] = {"postprocess": False} if kind == "3mf" else {}
    scene = trimesh.load_scene(str(file), process=False, **options)
    order = {name: i for i, name in enumerate(scene.geometry)}
    found: list[tuple[int, Part]] = []
    used: set[str] = set()
    declared = "m" if kind in GLTF else None
    for node in scene.graph.nodes_geometry:
        matrix, geometry_name = scene.graph[node]
        mesh = scene.geometry[geometry_name]
        if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
            continue
        if kind == "3mf":
            declared = str(mesh.metadata.get("units", "millimeter"))
        name = _body_name(file, scene, node, geometry_name, node_names, single=len(order) == 1)
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        faces = np.asarray(mesh.faces, dtype=np.int64)
        rounding = observed_rounding(vertices)
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        if np.linalg.det(matrix[:3, :3]) < 0.0:  # a mirrored instance would turn inside out
            faces = faces[:, ::-1]
        name = unused_name(name, used)
        stored[name] = rounding * float(np.linalg.norm(matrix[:3, :3], 2))
        found.append((order[geometry_name], (name, vertices, faces)))
        label = getattr(getattr(mesh.visual, "material", None), "name", None)
        if kind in GLTF and label:
            own[name] = str(label)
    return [part for _, part in sorted(found, key=lambda item: item[0])], declared


def _body_name(
    file: Path,
    scene: Any,  # noqa: ANN401  (trimesh.Scene; trimesh is imported only when a file is read)
    node: str,
    geometry_name: str,
    node_names: frozenset[str] | None,
    *,
    single: bool,
) -> str:
    """Return what to call the body at a node of a scene."""
    mesh = scene.geometry[geometry_name]
    if node_names is not None and mesh.metadata.get("from_gltf_primitive"):
        # One glTF mesh of several materials: trimesh names the pieces at random.
        owner = str(scene.graph.transforms.parents[node])
        label = getattr(getattr(mesh.visual, "material", None), "name", None)
        return f"{owner}.{label}" if label else f"{owner}.{geometry_name}"
    if node_names is not None:
        return node if node in node_names else geometry_name
    if single and node == geometry_name == file.name:  # the format carries no name at all
        return file.stem
    return node


def _gltf_node_names(path: Path) -> frozenset[str]:
    """Return the nodes' names in a GLB or GLTF file; refuse geometry that trimesh does not decode.

    Refused: not glTF 2, compressed meshes, normalised integer or sparse positions, triangle fans.
    """
    header = _read_header(path)
    for extension in header.get("extensionsRequired", []):
        if not str(extension).startswith(_HARMLESS):
            msg = (
                f"{path} needs the glTF extension {extension}, which Octant does not read; export "
                "it again without compression or instancing."
            )
            raise GeometryError(msg)
    accessors = header.get("accessors", [])
    for mesh in header.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            position = primitive.get("attributes", {}).get("POSITION")
            accessor = accessors[position] if position is not None else {}
            if (
                accessor.get("normalized")
                or "sparse" in accessor
                or primitive.get("mode") == _TRIANGLE_FAN
            ):
                msg = (
                    f"mesh {mesh.get('name', '?')!r} of {path} is stored as normalised integers, "
                    "sparse positions or a triangle fan, which Octant does not read; export it "
                    "again as plain triangles."
                )
                raise GeometryError(msg)
    return frozenset(str(n["name"]) for n in header.get("nodes", []) if "name" in n)


def _read_header(path: Path) -> dict[str, Any]:
    """Return the JSON part of a GLB or GLTF file."""
    data = path.read_bytes()
    try:
        if data[:4] == _GLB_MAGIC:
            version, _, length = struct.unpack("<3I", data[4:16])
            if version != 2:
                msg = f"version {version}"
                raise ValueError(msg)
            data = data[20 : 20 + length]
        header = json.loads(data.decode("utf-8-sig"))
    except (ValueError, struct.error) as exc:
        msg = f"{path} cannot be read as glTF 2 ({exc}); check that it is a .glb or .gltf file."
        raise GeometryError(msg) from exc
    if not isinstance(header, dict):
        msg = f"{path} cannot be read as glTF 2; check that it is a .glb or .gltf file."
        raise GeometryError(msg)
    return header


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
