"""Files that are no meshes: what converts them, in one sentence each."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NoReturn

from octant.geometries.errors import GeometryError
from octant.geometries.names import nearest_name

_GMSH = "gmsh {file} -2 -o {stem}.stl (pip install gmsh; the STL is in mm)"
_BLENDER = "open it in Blender and export glTF 2.0 (.glb)"
_TOOLS: Mapping[str, str] = MappingProxyType(
    {
        "step": _GMSH,
        "stp": _GMSH,
        "iges": _GMSH,
        "igs": _GMSH,
        "brep": _GMSH,
        "fcstd": "export it from FreeCAD as OBJ",
        "ifc": "IfcConvert {file} {stem}.glb --use-element-names (IfcOpenShell)",
        "ifczip": "unzip it, then IfcConvert FILE.ifc {stem}.glb (IfcOpenShell)",
        "dwg": "dwg2dxf {file} (LibreDWG), for a floor plan",
        "fbx": _BLENDER,
        "blend": _BLENDER,
        "3ds": _BLENDER,
        "max": "export it from 3ds Max as glTF or OBJ",
        "skp": "export it from SketchUp as DAE or glTF",
        "rvt": "export it from Revit as IFC, then IfcConvert FILE.ifc {stem}.glb (IfcOpenShell)",
        "wrl": _BLENDER,
        "x3d": _BLENDER,
        "usd": _BLENDER,
        "usdz": _BLENDER,
        "gif": "save it as PNG, for a floor plan",
        "zae": "unzip it and name the .dae file in it",
        "xacro": "ros2 run xacro xacro {file} > {stem}.urdf",
        "las": "a point cloud has no surfaces; mesh it first, for example in CloudCompare",
        "e57": "a point cloud has no surfaces; mesh it first, for example in CloudCompare",
        "pcd": "a point cloud has no surfaces; mesh it first, for example in CloudCompare",
    }
)


def is_convertible(kind: str) -> bool:
    """Return whether files of an extension may hold a room, once converted.

    Parameters
    ----------
    kind : Extension, lower case, without dot.
    """
    return kind in _TOOLS


def refuse_kind(file: Path, known: Sequence[str]) -> NoReturn:
    """Refuse a file that is no mesh, with the tool and the command that make one of it.

    Parameters
    ----------
    file : The file.
    known : Extensions that are read.
    """
    kind = file.suffix.lower().removeprefix(".")
    if kind in _TOOLS:
        how = _TOOLS[kind].format(file=file.name, stem=file.stem)
        msg = f"mesh file {file} ends in '.{kind}', which is not read here; convert it: {how}."
        raise GeometryError(msg)
    listed = ", ".join(f".{k}" for k in known)
    near = nearest_name(kind, known, least_likeness=0.6) if kind else None
    hint = f"did you mean '.{near}'?" if near else "convert it, for example to .glb in Blender."
    msg = f"mesh file {file} ends in '.{kind}', but only {listed} can be read; {hint}"
    raise GeometryError(msg)
