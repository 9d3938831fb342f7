"""COLLADA files (.dae), as Gazebo worlds and SketchUp write them, through pycollada.

Source: Khronos Group, COLLADA 1.4.1 Specification (2008), "asset", "node", "polylist".
"""

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from lxml import etree

from octant.geometries.errors import GeometryError
from octant.geometries.names import unused_name
from octant.geometries.xml_files import xml_root

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
ColladaPart = tuple[str, FloatArray, IntArray]

VERSIONS = ("1.4", "1.5")
"""Versions of COLLADA that are read."""
_X_UP = np.array([(0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)])
_LEFT_OUT = (
    "library_animations", "library_cameras", "library_effects", "library_images",
    "library_lights", "library_materials", "library_physics_models", "library_physics_scenes",
    "library_physics_materials", "bind_material", "instance_camera", "instance_light",
    "instance_physics_scene", "extra",
)  # fmt: skip


def read_collada(path: Path) -> tuple[list[ColladaPart], float, str]:
    """Return the bodies of a COLLADA file as stored, the length of its unit [m] and "y" or "z" up.

    Bodies are named by node, and ``node.material`` where a node has several. Files drawn with x up
    are turned so that z is up. Polygons are cut into fans, right for convex ones only.

    Parameters
    ----------
    path : The file.
    """
    root = xml_root(path, what="a COLLADA file", roots=("COLLADA",))
    version = root.get("version", "")
    if not version.startswith(VERSIONS):
        msg = (
            f"{path} is COLLADA {version or 'of no version'}, but {' and '.join(VERSIONS)} are "
            "read; export it again."
        )
        raise GeometryError(msg)
    collada = _pycollada()
    _refuse_foreign(path, root)
    for name in _LEFT_OUT:
        for element in list(root.iter(f"{{*}}{name}")):
            parent = element.getparent()
            if parent is not None:
                parent.remove(element)
    try:
        document = collada.Collada(io.BytesIO(etree.tostring(root)))
        nodes = [] if document.scene is None else document.scene.nodes
        parts = list(_parts(nodes, collada))
        metres = 1.0 if document.assetInfo is None else document.assetInfo.unitmeter
        up = document.assetInfo.upaxis if document.assetInfo is not None else "Y_UP"
    except Exception as exc:  # pycollada raises anything at all on a damaged file
        reason = " ".join(str(exc).split())[:120] or type(exc).__name__
        msg = f"{path} cannot be read as COLLADA ({reason}); export it again."
        raise GeometryError(msg) from exc
    scale = 1.0 if metres is None else float(metres)
    if not (np.isfinite(scale) and scale > 0.0):
        msg = f"{path} has the unit {metres} m, but it must be a positive length; correct it."
        raise GeometryError(msg)
    if up == "X_UP":
        parts = [(name, vertices @ _X_UP.T, faces) for name, vertices, faces in parts]
    used: set[str] = set()
    named = [(unused_name(name, used), vertices, faces) for name, vertices, faces in parts]
    return named, scale, "y" if up == "Y_UP" else "z"


def _pycollada() -> Any:  # noqa: ANN401  an optional module
    try:
        import collada
    except ImportError as exc:
        msg = 'DAE files are read by pycollada; install it: pip install "octant[worlds]".'
        raise GeometryError(msg) from exc
    return collada


def _refuse_foreign(path: Path, root: etree._Element) -> None:
    """Refuse geometry in other files, and skinned bodies, which would be left out silently."""
    for kind in ("instance_geometry", "instance_node", "instance_visual_scene"):
        for element in root.iter(f"{{*}}{kind}"):
            url = element.get("url", "")
            if not url.startswith("#"):
                msg = (
                    f"{path}, line {element.sourceline}, refers to {url[:200]!r}, but only what "
                    "stands in the file itself is read; export it as one file."
                )
                raise GeometryError(msg)
    skin = next(root.iter("{*}instance_controller"), None)
    if skin is not None:
        msg = (
            f"{path}, line {skin.sourceline}, holds a skinned body, which is not read; apply the "
            "armature and export it again."
        )
        raise GeometryError(msg)


def _parts(nodes: Any, collada: Any) -> Iterator[ColladaPart]:  # noqa: ANN401
    waiting = [(node, np.eye(4), "") for node in reversed(nodes)]
    while waiting:
        node, above, name = waiting.pop()
        if isinstance(node, collada.scene.GeometryNode):
            yield from _primitives(node.geometry, above, name, collada)
        elif isinstance(node, collada.scene.Node):
            inner = getattr(node, "node", node)  # an instance of a node of the library
            own = getattr(inner, "name", None) or node.id or name
            matrix = above @ np.asarray(node.matrix, dtype=np.float64)
            waiting += [(child, matrix, own) for child in reversed(node.children)]


def _primitives(
    geometry: Any,  # noqa: ANN401  of pycollada
    matrix: FloatArray,
    name: str,
    collada: Any,  # noqa: ANN401
) -> Iterator[ColladaPart]:
    cut = (collada.polylist.Polylist, collada.triangleset.TriangleSet)
    found: dict[str, list[tuple[FloatArray, IntArray]]] = {}
    for primitive in geometry.primitives:
        if not isinstance(primitive, cut):
            continue  # lines and points
        triangles = primitive.triangleset() if isinstance(primitive, cut[0]) else primitive
        if triangles.vertex is None or triangles.vertex_index is None:
            continue
        if len(triangles.vertex_index):
            faces = np.asarray(triangles.vertex_index, dtype=np.int64).reshape(-1, 3)
            vertices = np.asarray(triangles.vertex, dtype=np.float64)
            found.setdefault(str(primitive.material or ""), []).append((vertices, faces))
    own = name or geometry.name or geometry.id or "body"
    for symbol, pieces in found.items():
        offsets = np.cumsum([0] + [len(vertices) for vertices, _ in pieces])
        faces = np.concatenate([f + n for (_, f), n in zip(pieces, offsets, strict=False)])
        vertices = np.concatenate([vertices for vertices, _ in pieces])
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        if np.linalg.det(matrix[:3, :3]) < 0.0:  # a mirrored node would turn inside out
            faces = faces[:, ::-1]
        yield (f"{own}.{symbol}" if len(found) > 1 and symbol else own), vertices, faces
