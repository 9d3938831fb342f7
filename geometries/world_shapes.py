"""Geometry of robot worlds: boxes, cylinders, spheres, planes and meshes of SDF and URDF."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt
from lxml.etree import _Element as Element

from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError, PhysicsWarning
from octant.geometries.names import unused_name
from octant.geometries.world_places import WorldPlaces, shown
from octant.geometries.xml_files import finite_numbers

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
MeshReader = Callable[..., Sequence[Body]]
"""Reads the bodies of a mesh file, as `octant.geometries.mesh_files.load_bodies` does."""
Shown = Literal["visual", "collision"]
"""Which geometry of a world's bodies is read: what is seen, or what robots collide with."""

CIRCLE_SIDES = 24
"""Flat sides [-] of cylinders and capsules."""
LOST_M = 1e4
"""Distance from the middle of a world's bodies beyond which one is lost [m]."""
PLANE_MARGIN_M = 1.0
"""How far a ground plane reaches beyond everything else in the world [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WorldShape:
    """One body of a world, in its place.

    Parameters
    ----------
    name : Of its model, and of link and visual where there are several.
    vertices : (n, 3) float64 — Corners [m], z up.
    faces : (m, 3) int64 — Vertex numbers of each triangle.
    ground : Whether it is a level plane, which ends where the rest of the world does.
    """

    name: str
    vertices: FloatArray
    faces: IntArray
    ground: bool = False


@dataclass(slots=True, kw_only=True)
class WorldReading:
    """What is read of one world, and the meshes that were read already.

    Parameters
    ----------
    places, load_mesh, geometry : Where files lie; reads meshes; which geometry is wanted.
    files, meshes : Every other file that was read, in order; the bodies of its meshes [m].
    """

    places: WorldPlaces
    load_mesh: MeshReader
    geometry: Shown
    files: dict[Path, None]
    meshes: dict[Path, Sequence[Body]]

    def mesh(self, uri: str, beside: Path, *, chain: Sequence[str]) -> Sequence[Body]:
        """Return the bodies of a mesh file [m], read once.

        Parameters
        ----------
        uri, beside, chain : As for `WorldPlaces.found`.
        """
        file = self.places.found(uri, beside, chain=chain)
        self.files[file] = None
        if file not in self.meshes:
            try:
                self.meshes[file] = self.load_mesh(file)
            except GeometryError as exc:
                msg = f"{shown(chain)}: {exc}"
                raise GeometryError(msg) from exc
        return self.meshes[file]


def shapes_of_geometry(
    reading: WorldReading,
    element: Element,
    pose: FloatArray,
    *,
    name: str,
    beside: Path,
    chain: Sequence[str],
) -> list[WorldShape]:
    """Return what a ``<geometry>`` of SDF or URDF holds, in its place [m].

    Ellipsoids, capsules and cones are polyhedra, as spheres and cylinders are.

    Parameters
    ----------
    reading : What is read.
    element, pose : The element, and its (4, 4) place in the world [m].
    name : What its body is called.
    beside, chain : Folder and chain of the file in which it stands.
    """
    found: list[WorldShape] = []
    for child in element:
        kind = str(child.tag)
        where = f"<{kind}> of {name!r} in {shown(chain)}, line {child.sourceline},"
        if kind == "empty":
            continue
        if kind == "mesh":
            found += _meshes(reading, child, name=name, beside=beside, chain=chain, where=where)
        elif kind in _SIMPLE:
            vertices, faces = _SIMPLE[kind](child, where)
            found.append(
                WorldShape(name=name, vertices=vertices, faces=faces, ground=kind == "plane")
            )
        else:
            known = ", ".join(("mesh", *_SIMPLE))
            msg = f"{where} is not read ({known} are); replace it by a mesh."
            raise GeometryError(msg)
    return [_placed(shape, pose) for shape in found]


def with_ground(shapes: Sequence[WorldShape]) -> list[WorldShape]:
    """Return shapes whose level planes end `PLANE_MARGIN_M` beyond everything else [m].

    Simulators draw a ground plane of a hundred metres under a room of five; nothing that a room
    reflects comes from so far. Planes that reach less far, and those of an otherwise empty world,
    stay as they are.

    Parameters
    ----------
    shapes : All of a world.
    """
    solid = [shape.vertices for shape in shapes if not shape.ground]
    if not solid:
        return list(shapes)
    low = np.min([v.min(axis=0) for v in solid], axis=0) - PLANE_MARGIN_M
    high = np.max([v.max(axis=0) for v in solid], axis=0) + PLANE_MARGIN_M
    ended = []
    for shape in shapes:
        v = shape.vertices
        if shape.ground and np.ptp(v[:, 2]) <= 1e-9:
            start, stop = np.maximum(v.min(axis=0), low), np.minimum(v.max(axis=0), high)
            if (stop[:2] - start[:2] <= 0.0).any():
                continue
            corners = [
                (start[0], start[1]),
                (stop[0], start[1]),
                (stop[0], stop[1]),
                (start[0], stop[1]),
            ]
            flat = np.array([(x, y, v[0, 2]) for x, y in corners])
            ended.append(replace(shape, vertices=flat, faces=_QUAD))
        else:
            ended.append(shape)
    return ended


def without_lost(shapes: Sequence[WorldShape], path: Path) -> list[WorldShape]:
    """Return shapes without those that stand farther than `LOST_M` from the middle of the rest.

    A simulator that saves a world after long writes what fell through its floor where it is by
    then, 10^8 m below; it shows none of that, and neither does this. A warning names them.

    Parameters
    ----------
    shapes : All of a world.
    path : Its file, for the warning.
    """
    middles = np.array([0.5 * (s.vertices.min(axis=0) + s.vertices.max(axis=0)) for s in shapes])
    lost = np.abs(middles - np.median(middles, axis=0)).max(axis=1) > LOST_M
    if lost.any():
        names = [shape.name for shape, gone in zip(shapes, lost, strict=True) if gone]
        listed = ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
        warnings.warn(
            f"{path.name}: {len(names)} of {len(shapes)} bodies left out, more than "
            f"{LOST_M / 1000.0:g} km away from the others ({listed})",
            PhysicsWarning,
            stacklevel=2,
        )
    return [shape for shape, gone in zip(shapes, lost, strict=True) if not gone]


def uniquely_named(shapes: Sequence[WorldShape]) -> list[WorldShape]:
    """Return shapes of distinct names.

    Parameters
    ----------
    shapes : All of a world.
    """
    used: set[str] = set()
    return [replace(shape, name=unused_name(shape.name, used)) for shape in shapes]


def _placed(shape: WorldShape, matrix: FloatArray) -> WorldShape:
    vertices = shape.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    mirrored = np.linalg.det(matrix[:3, :3]) < 0.0
    return replace(
        shape, vertices=vertices, faces=shape.faces[:, ::-1] if mirrored else shape.faces
    )


def _meshes(
    reading: WorldReading,
    element: Element,
    *,
    name: str,
    beside: Path,
    chain: Sequence[str],
    where: str,
) -> list[WorldShape]:
    """Return the bodies of a mesh, scaled (a negative scale mirrors), or the wanted submesh."""
    uri = element.get("filename") or element.findtext("uri") or ""
    if not uri:
        msg = f"{where} names no file; add a <uri> (SDF) or filename (URDF)."
        raise GeometryError(msg)
    given = element.get("scale") or element.findtext("scale")
    scale = finite_numbers(given, 3, where=f"scale of {where}", default="1 1 1")
    if (scale == 0.0).any():
        msg = f"{where} has the scale {given!r}, which makes it flat; correct it."
        raise GeometryError(msg)
    bodies = list(reading.mesh(uri, beside, chain=chain))
    wanted = element.findtext("submesh/name")
    if wanted:
        bodies = [b for b in bodies if b.name == wanted or b.name.split(".")[0] == wanted]
        if not bodies:
            msg = f"{where} wants the submesh {wanted!r}, which {uri} does not hold; correct it."
            raise GeometryError(msg)
    centre = np.zeros(3)
    if (element.findtext("submesh/center") or "").strip() in {"true", "1"}:
        bounds = np.array([b.bounds_m for b in bodies])
        centre = 0.5 * (bounds[:, 0].min(axis=0) + bounds[:, 1].max(axis=0))
    scaling = np.eye(4)
    scaling[:3, :3] = np.diag(scale)
    return [
        _placed(
            WorldShape(
                name=name if len(bodies) == 1 else f"{name}.{body.name}",
                vertices=body.vertices_m - centre,
                faces=body.faces,
            ),
            scaling,
        )
        for body in bodies
    ]


def _number(element: Element, key: str, where: str) -> float:
    text = element.get(key) or element.findtext(key)
    value = float(finite_numbers(text, 1, where=f"{key} of {where}")[0])
    if value <= 0.0:
        msg = f"{where} has the {key} {value:g}, but it must be positive; correct it."
        raise GeometryError(msg)
    return value


def _vector(element: Element, key: str, count: int, where: str, default: str = "") -> FloatArray:
    text = element.get(key) or element.findtext(key)
    return finite_numbers(text, count, where=f"{key} of {where}", default=default)


def _box(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    from octant.geometries.furniture import box

    size = _vector(element, "size", 3, where)
    if (size <= 0.0).any():
        msg = f"{where} has the size {size.tolist()} m, but it must be positive; correct it."
        raise GeometryError(msg)
    body = box(tuple(size), material="any", position_m=tuple(-0.5 * size))
    return body.vertices_m, body.faces


def _cylinder(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    from octant.geometries.furniture import cylinder

    radius, length = _number(element, "radius", where), _number(element, "length", where)
    body = cylinder(
        radius, length, sides=CIRCLE_SIDES, material="any", position_m=(0.0, 0.0, -0.5 * length)
    )
    return body.vertices_m, body.faces


def _sphere(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    from trimesh.creation import icosphere

    return _stretched(icosphere(subdivisions=2), np.full(3, _number(element, "radius", where)))


def _ellipsoid(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    from trimesh.creation import icosphere

    return _stretched(icosphere(subdivisions=2), _vector(element, "radii", 3, where))


def _capsule(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    from trimesh.creation import capsule

    radius, length = _number(element, "radius", where), _number(element, "length", where)
    ball = capsule(height=length, radius=radius, count=(CIRCLE_SIDES // 2, CIRCLE_SIDES))
    vertices = np.asarray(ball.vertices, dtype=np.float64)
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return vertices - middle, np.asarray(ball.faces, dtype=np.int64)


def _cone(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    from trimesh.creation import cone

    radius, length = _number(element, "radius", where), _number(element, "length", where)
    made = cone(radius, length, sections=CIRCLE_SIDES)
    vertices = np.asarray(made.vertices, dtype=np.float64)
    vertices[:, 2] -= 0.5 * (vertices[:, 2].min() + vertices[:, 2].max())
    return vertices, np.asarray(made.faces, dtype=np.int64)


def _stretched(ball: object, radii: FloatArray) -> tuple[FloatArray, IntArray]:
    vertices = np.asarray(getattr(ball, "vertices"), dtype=np.float64) * radii  # noqa: B009
    return vertices, np.asarray(getattr(ball, "faces"), dtype=np.int64)  # noqa: B009


def _plane(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    normal = _vector(element, "normal", 3, where, "0 0 1")
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        msg = f"{where} has no normal; give one such as 0 0 1."
        raise GeometryError(msg)
    half = 0.5 * _vector(element, "size", 2, where, "1 1")
    normal = normal / length
    aside = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = aside - (aside @ normal) * normal
    first = first / np.linalg.norm(first)
    second = np.cross(normal, first)
    corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    vertices = np.array([u * half[0] * first + v * half[1] * second for u, v in corners])
    return vertices, _QUAD


def _polyline(element: Element, where: str) -> tuple[FloatArray, IntArray]:
    from octant.geometries.rooms import prism_room

    points = [finite_numbers(p.text, 2, where=f"a point of {where}") for p in element.iter("point")]
    bodies = prism_room([tuple(p) for p in points], _number(element, "height", where))
    offsets = np.cumsum([0] + [len(body.vertices_m) for body in bodies])
    faces = [body.faces[:, ::-1] + n for body, n in zip(bodies, offsets, strict=False)]
    return np.concatenate([body.vertices_m for body in bodies]), np.concatenate(faces)


_QUAD = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int64)
_SIMPLE: Mapping[str, Callable[[Element, str], tuple[FloatArray, IntArray]]] = {
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
    "ellipsoid": _ellipsoid,
    "capsule": _capsule,
    "cone": _cone,
    "plane": _plane,
    "polyline": _polyline,
}
