"""Mesh files through trimesh: parts by name in their places, damaged files refused."""

import json
import logging
import re
import struct
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from octant.geometries._obj_files import Part
from octant.geometries.errors import GeometryError
from octant.geometries.names import unused_name
from octant.geometries.planes import observed_rounding
from octant.geometries.xml_files import URL

GLTF = ("glb", "gltf")

# Required extensions that only change how a surface looks; any other required one may hold the
# geometry itself, and trimesh would go on without it.
_LOOKS_ONLY = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_")
_HARMLESS = (*_LOOKS_ONLY, "KHR_mesh_quantization", "KHR_xmp")
_TRIANGLE_FAN = 6
_GLB_MAGIC = b"glTF"


def read_with_trimesh(
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
    """Return what `read_with_trimesh` does, with the errors of trimesh."""
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
    _refuse_far_files(path, header)
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


def _refuse_far_files(path: Path, header: dict[str, Any]) -> None:
    """Refuse buffers of a glTF file that lie on a network or out of its folder."""
    folder = path.parent.resolve()
    for buffer in header.get("buffers", []):
        uri = unquote(str(buffer.get("uri", "")))
        if not uri or uri.startswith("data:"):
            continue
        if URL.match(uri) or not (folder / uri).resolve().is_relative_to(folder):
            msg = (
                f"{path} > {uri[:200]!r}: this buffer does not lie beside the file, or below; "
                "export it as one .glb."
            )
            raise GeometryError(msg)
        if not (folder / uri).is_file():
            msg = f"{path} > {uri[:200]!r}: this buffer does not exist; copy it there."
            raise GeometryError(msg)
