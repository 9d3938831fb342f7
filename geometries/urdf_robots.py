"""URDF files as meshes: links in the places that their joints give them, all joints at zero.

Source: ROS 2 documentation, "URDF XML specification" (link, joint, geometry).
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from lxml.etree import _Element as Element

from octant.geometries.errors import GeometryError
from octant.geometries.world_shapes import (
    WorldReading,
    WorldShape,
    shapes_of_geometry,
    uniquely_named,
)
from octant.geometries.xml_files import finite_numbers, pose_matrix, xml_root

FloatArray = npt.NDArray[np.float64]
_XACRO = "{http://www.ros.org/wiki/xacro}"


def read_urdf(path: Path, reading: WorldReading) -> list[WorldShape]:
    """Return the bodies of a URDF file in their places [m], named by link.

    Parameters
    ----------
    path : The file.
    reading : How it is read.
    """
    root = xml_root(path, what="a URDF file", roots=("robot",))
    if next((e for e in root.iter() if str(e.tag).startswith(_XACRO)), None) is not None:
        msg = f"{path} holds xacro macros; expand them: ros2 run xacro xacro FILE.xacro > NEW.urdf"
        raise GeometryError(msg)
    links = {e.get("name", ""): e for e in root.findall("link")}
    joints: dict[str, Element] = {}
    for joint in root.findall("joint"):
        child = joint.find("child")
        joints["" if child is None else child.get("link", "")] = joint
    chain = (str(path),)
    shapes: list[WorldShape] = []
    for name, link in links.items():
        at = _link_pose(name, links, joints, path)
        seen = link.findall(reading.geometry)
        for i, visual in enumerate(seen):
            geometry = visual.find("geometry")
            if geometry is None:
                continue
            label = name if len(seen) == 1 else f"{name}.{visual.get('name') or i + 1}"
            shapes += shapes_of_geometry(
                reading,
                geometry,
                at @ _origin(visual, path),
                name=label,
                beside=path.parent,
                chain=chain,
            )
    if not shapes:
        msg = f"{path} holds no {reading.geometry} geometry; check the file, or room.geometry."
        raise GeometryError(msg)
    return uniquely_named(shapes)


def _link_pose(
    name: str, links: dict[str, Element], joints: dict[str, Element], path: Path
) -> FloatArray:
    """Return the place of a link in the frame of its robot's root [m]."""
    matrix, seen = np.eye(4), {name}
    while name in joints:
        joint = joints[name]
        matrix = _origin(joint, path) @ matrix
        parent = joint.find("parent")
        name = "" if parent is None else parent.get("link", "")
        if name not in links or name in seen:
            what = "lead in a circle" if name in seen else f"name the link {name!r}, which is none"
            msg = f"{path}: the joints {what}; correct joint {joint.get('name') or ''!r}."
            raise GeometryError(msg)
        seen.add(name)
    return matrix


def _origin(element: Element, path: Path) -> FloatArray:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    where = f"<origin> in {path}, line {origin.sourceline},"
    xyz = finite_numbers(origin.get("xyz"), 3, where=f"xyz of {where}", default="0 0 0")
    rpy = finite_numbers(origin.get("rpy"), 3, where=f"rpy of {where}", default="0 0 0")
    return pose_matrix(xyz, rpy)
