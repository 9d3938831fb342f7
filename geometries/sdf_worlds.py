"""Gazebo worlds and models (SDF) as meshes: includes, nested models, poses and frames.

Source: Open Robotics, SDFormat specification 1.11, and "Pose Frame Semantics" (sdformat.org).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from lxml.etree import _Element as Element

from octant.geometries.errors import GeometryError
from octant.geometries.world_places import shown
from octant.geometries.world_shapes import (
    WorldReading,
    WorldShape,
    shapes_of_geometry,
    uniquely_named,
    with_ground,
    without_lost,
)
from octant.geometries.xml_files import finite_numbers, pose_matrix, xml_root

FloatArray = npt.NDArray[np.float64]

VERSIONS = ("1.3", "1.4", "1.5", "1.6", "1.7", "1.8", "1.9", "1.10", "1.11", "1.12")
"""Versions of SDF that are read."""
DEEPEST = 32
"""Includes and models that may stand inside one another [-]."""
MOST_SHAPES = 100_000
"""Bodies of one world that are read [-]."""
_LIGHTS_ONLY = ("sun", "Sun")
_GROUNDS = ("ground_plane", "Ground Plane")
_GROUND_M = 100.0  # the plane of Gazebo's own model ground_plane
_OWN_FRAME = ("", "__model__", "world")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """Where an element stands: its file, the chain that led there, its model's place and name."""

    file: Path
    chain: tuple[str, ...]
    pose: FloatArray
    name: str
    depth: int = 0


def read_sdf(path: Path, reading: WorldReading) -> list[WorldShape]:
    """Return the bodies of an SDF world or model in their places [m], in its order.

    Models, nested and included ones too, with their links' visuals or collisions. Lights, actors,
    plugins, sensors and joints' motions are left out, and, with a warning, what `without_lost`
    names; height maps are refused. Level planes end a metre beyond everything else. Gazebo's own
    ``model://sun`` and ``model://ground_plane`` need
    no files.

    Parameters
    ----------
    path : The file.
    reading : How it is read.
    """
    top = _Place(file=path, chain=(str(path),), pose=np.eye(4), name="")
    root = _sdf_root(path, top.chain)
    worlds = root.findall("world")
    if len(worlds) > 1:
        msg = f"{path} holds {len(worlds)} worlds, but one is read; keep one of them in the file."
        raise GeometryError(msg)
    shapes: list[WorldShape] = []
    for holder in worlds or [root]:
        _children(holder, top, reading, shapes)
    if not shapes:
        other = "collision" if reading.geometry == "visual" else "visual"
        msg = (
            f"{path} holds no {reading.geometry} geometry; check the file, or give "
            f'room.geometry = "{other}".'
        )
        raise GeometryError(msg)
    return uniquely_named(with_ground(without_lost(shapes, path)))


def _sdf_root(path: Path, chain: Sequence[str]) -> Element:
    try:
        root = xml_root(path, what="an SDF file", roots=("sdf", "gazebo"))
    except GeometryError as exc:
        if len(chain) < 2:
            raise
        msg = f"{shown(chain)}: {exc}"
        raise GeometryError(msg) from exc
    version = root.get("version", "")
    if version not in VERSIONS:
        msg = (
            f"{shown(chain)} is SDF {version or 'of no version'}, but {VERSIONS[0]} to "
            f"{VERSIONS[-1]} are read; convert it (gz sdf -p FILE > NEW)."
        )
        raise GeometryError(msg)
    return root


def _children(
    holder: Element, place: _Place, reading: WorldReading, shapes: list[WorldShape]
) -> None:
    """Add the models and includes of a world, a model or a file."""
    if place.depth > DEEPEST:
        msg = f"{shown(place.chain[:6])} ...: models include one another without end; break that."
        raise GeometryError(msg)
    frames = _frames(holder)
    for child in holder:
        kind = str(child.tag)
        if kind == "model":
            pose = place.pose @ _pose_of(child, place, frames)
            _model(child, replace(place, pose=pose), reading, shapes)
        elif kind == "include":
            _include(child, place, frames, reading, shapes)
        if len(shapes) > MOST_SHAPES:
            msg = f"{shown(place.chain)}: more than {MOST_SHAPES} bodies; split the world."
            raise GeometryError(msg)


def _include(
    element: Element,
    place: _Place,
    frames: Mapping[str, Element],
    reading: WorldReading,
    shapes: list[WorldShape],
) -> None:
    uri = (element.findtext("uri") or "").strip()
    name = (element.findtext("name") or "").strip()
    chain = (*place.chain, f"<include> {uri or 'without a <uri>'}, line {element.sourceline}")
    if not uri:
        msg = f"{shown(chain)}: an <include> needs a <uri>; add one."
        raise GeometryError(msg)
    bare = uri.removeprefix("model://").strip("/")
    own = uri.startswith("model://") and bare in {*_LIGHTS_ONLY, *_GROUNDS}
    try:
        file = reading.places.model_file(uri, place.file.parent, chain=chain)
    except GeometryError:
        if not own:
            raise
        if bare in _GROUNDS:
            pose = place.pose @ _pose_of(element, place, frames)
            shapes.append(_ground_plane(name or bare, pose))
        return
    reading.files[file] = None
    root = _sdf_root(file, chain)
    models = [child for child in root if child.tag == "model"]
    if not models:
        if root.find("light") is not None or root.find("actor") is not None:
            return
        msg = f"{shown(chain)}: {file} holds no <model>; name a model's file."
        raise GeometryError(msg)
    inner = replace(place, file=file, chain=chain, depth=place.depth + 1)
    model = models[0]
    # The pose of an include takes the place of the model's own.
    given = element.find("pose") is not None
    pose = _pose_of(element, place, frames) if given else _pose_of(model, inner, {})
    anchor = element.findtext("placement_frame") or ""
    if anchor:
        pose = pose @ np.linalg.inv(_frame_pose(anchor, _frames(model), inner))
    _model(model, replace(inner, pose=place.pose @ pose), reading, shapes, name=name)


def _ground_plane(name: str, pose: FloatArray) -> WorldShape:
    half = 0.5 * _GROUND_M
    corners = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
    vertices = corners @ pose[:3, :3].T + pose[:3, 3]
    return WorldShape(
        name=name, vertices=vertices, faces=np.array([(0, 1, 2), (0, 2, 3)]), ground=True
    )


def _model(
    element: Element,
    place: _Place,
    reading: WorldReading,
    shapes: list[WorldShape],
    *,
    name: str = "",
) -> None:
    """Add the links of a model whose place in the world is ``place.pose``, and its inner models."""
    own = name or element.get("name") or "model"
    inside = replace(
        place, name=f"{place.name}.{own}" if place.name else own, depth=place.depth + 1
    )
    anchor = element.get("placement_frame") or ""
    frames = _frames(element)
    if anchor and not name:
        turn = np.linalg.inv(_frame_pose(anchor, frames, inside))
        inside = replace(inside, pose=inside.pose @ turn)
    links = element.findall("link")
    several = len(links) > 1
    for link in links:
        at = inside.pose @ _pose_of(link, inside, frames)
        seen = link.findall(reading.geometry)
        named = f"{inside.name}.{link.get('name') or 'link'}" if several else inside.name
        for visual in seen:
            geometry, pose = visual.find("geometry"), visual.find("pose")
            if geometry is None:
                continue
            base = "" if pose is None else pose.get("relative_to", "")
            if base in {"", link.get("name")}:
                placed = at @ _pose_of(visual, inside, {}, own=base)
            else:
                placed = inside.pose @ _pose_of(visual, inside, frames)
            label = named if len(seen) == 1 else f"{named}.{visual.get('name') or 'part'}"
            shapes += shapes_of_geometry(
                reading,
                geometry,
                placed,
                name=label,
                beside=inside.file.parent,
                chain=(*inside.chain, inside.name),
            )
    _children(element, inside, reading, shapes)


def _frames(holder: Element) -> dict[str, Element]:
    """Return the elements of a scope that a pose may be relative to, by name."""
    kinds = ("link", "model", "frame", "joint", "include")
    found = {}
    for child in holder:
        name = child.get("name") or (child.findtext("name") if child.tag == "include" else None)
        if str(child.tag) in kinds and name:
            found[name] = child
    return found


def _frame_pose(
    name: str, frames: Mapping[str, Element], place: _Place, seen: tuple[str, ...] = ()
) -> FloatArray:
    """Return the place of a named frame in its scope."""
    if name in _OWN_FRAME:
        return np.eye(4)
    element = frames.get(name)
    if element is None or name in seen:
        what = "is defined by itself" if name in seen else "is not one of its model"
        msg = f"{shown(place.chain)}: the frame {name!r} {what}; write the pose without it."
        raise GeometryError(msg)
    return _pose_of(element, place, frames, (*seen, name))


def _pose_of(
    element: Element,
    place: _Place,
    frames: Mapping[str, Element],
    seen: tuple[str, ...] = (),
    *,
    own: str = "",
) -> FloatArray:
    """Return the (4, 4) pose of an element in its scope [m], or in the frame ``own``."""
    pose = element.find("pose")
    kind = str(element.tag)
    where = f"<pose> of <{kind}> {element.get('name') or ''} in {shown(place.chain)}"
    base = ""
    if kind == "joint":
        base = (element.findtext("child") or "").strip()
    elif kind == "frame":
        base = element.get("attached_to") or ""
    if pose is None:
        return _frame_pose(base, frames, place, seen) if base else np.eye(4)
    base = pose.get("relative_to") or pose.get("frame") or base
    if pose.get("rotation_format") == "quat_xyzw":
        numbers = finite_numbers(pose.text, 7, where=where, default="0 0 0 0 0 0 1")
        local = pose_matrix(numbers[:3], numbers[:3], quaternion=numbers[3:])
    else:
        numbers = finite_numbers(pose.text, 6, where=where, default="0 0 0 0 0 0")
        turn = np.radians(numbers[3:]) if pose.get("degrees") in {"true", "1"} else numbers[3:]
        local = pose_matrix(numbers[:3], turn)
    if base in {*_OWN_FRAME, own}:
        return local
    return _frame_pose(base, frames, place, seen) @ local
