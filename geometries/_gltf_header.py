"""What a glTF file says about itself, checked where trimesh would go on with wrong vertices."""

import json
import struct
from pathlib import Path
from typing import Any

from octant.geometries.errors import GeometryError

# Required extensions that only change how a surface looks; any other required one may hold the
# geometry itself, and trimesh would go on without it.
_LOOKS_ONLY = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_")
_HARMLESS = (*_LOOKS_ONLY, "KHR_mesh_quantization", "KHR_xmp")
_TRIANGLE_FAN = 6
_GLB_MAGIC = b"glTF"


def gltf_node_names(path: Path) -> frozenset[str]:
    """Return the names that a GLB or GLTF file gives to its nodes.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    frozenset of str
        Names of the nodes that have one.

    Raises
    ------
    GeometryError
        When the file is not glTF 2, or holds geometry that trimesh does not decode: compressed
        meshes, normalised integer positions, sparse positions or triangle fans.
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
