"""Writing bodies in the formats that trimesh writes."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from octant.geometries.appearance import gltf_visual
from octant.geometries.bodies import Body

GLTF = ("glb", "gltf")
NAMED_FORMATS = (*GLTF, "3mf")
"""Formats that keep several bodies apart when trimesh writes them."""
ONE_BODY_FORMATS = ("stl", "ply", "off")


def write_with_trimesh(
    bodies: Sequence[Body], file: Path, kind: str, opacity: Mapping[str, float]
) -> None:
    """Write bodies in one of the formats that are left to trimesh.

    Parameters
    ----------
    bodies : sequence of Body
        In metres and z up, with distinct names.
    file : Path
        Where to.
    kind : str
        Its extension.
    opacity : mapping of str to float
        Opacity of bodies by name [-], for GLB and GLTF.
    """
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
