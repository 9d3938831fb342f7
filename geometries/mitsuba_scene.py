"""Scenes of Mitsuba and Sionna RT (XML with PLY or OBJ meshes and simple shapes) as meshes.

Shapes, their places and materials count; cameras, lights and integrators are left out.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from lxml.etree import _Element as Element

from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box
from octant.geometries.names import unused_name
from octant.geometries.xml_files import xml_root

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Attributes = Callable[[Element, str], str | None]
"""Returns an attribute of an element with its ``$variables`` filled in, or None."""
MeshReader = Callable[..., Sequence[Body]]
"""Reads the bodies of a mesh file, as `octant.geometries.mesh_files.load_bodies` does."""

MESH_SHAPES = ("ply", "obj")
"""Shapes that stand in a file of their own."""
CIRCLE_SIDES = 24
"""Flat sides [-] of cylinders and disks, which Octant's rays see as prisms and polygons."""

_AXES = ("x", "y", "z")
_NOT_SEEN = ("sensor", "emitter", "integrator", "texture", "medium", "phase", "default", "path")
_VALUES = ("integer", "float", "string", "boolean", "rgb", "spectrum", "transform")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MitsubaShape:
    """One shape of a scene, in its place.

    Parameters
    ----------
    name : The shape's id without ``mesh-`` before it, or its type; numbered where it repeats.
    vertices : (n, 3) float64 — Corners in the unit of the file [-], z up.
    faces : (m, 3) int64 — Vertex numbers of each triangle.
    material : Label that the file gives; None where it gives none.
    """

    name: str
    vertices: FloatArray
    faces: IntArray
    material: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Document:
    """A parsed scene file: its root, its ``<default>`` values and its materials by id."""

    path: Path
    load_mesh: MeshReader
    root: Element
    defaults: Mapping[str, str]
    materials: Mapping[str, Element]

    def attribute(self, element: Element, name: str) -> str | None:
        """Return an attribute with its ``$variables`` filled in, or None."""
        text = element.get(name)
        if text is None or "$" not in text:
            return text

        def value(found: re.Match[str]) -> str:
            if found[1] not in self.defaults:
                msg = (
                    f"{self.path}, line {element.sourceline}, uses ${found[1]}, but no <default> "
                    "gives it a value; add one."
                )
                raise GeometryError(msg)
            return self.defaults[found[1]]

        return re.sub(r"\$(\w+)", value, text)

    def where(self, element: Element) -> str:
        """Return what messages call an element."""
        name = element.get("id") or element.get("type") or ""
        return f"{element.tag} {name!r} of {self.path}, line {element.sourceline}"

    def child(self, element: Element, name: str) -> Element | None:
        """Return the child whose attribute ``name`` is this, or None."""
        return next((c for c in element if c.get("name") == name), None)

    def text(self, element: Element, name: str) -> str | None:
        """Return the value of a property, or None."""
        child = self.child(element, name)
        return None if child is None else self.attribute(child, "value")

    def number(self, element: Element, name: str) -> float | None:
        """Return the value of a property that is a number, or None."""
        text = self.text(element, name)
        if text is None:
            return None
        where = f"{name} of {self.where(element)},"
        found = _numbers_of(text, where=where)
        if len(found) != 1:
            msg = f"{where} gives {text!r}, but one number is needed."
            raise GeometryError(msg)
        return found[0]


def read_mitsuba(path: Path, load_mesh: MeshReader) -> list[MitsubaShape]:
    """Return the shapes of a Mitsuba or Sionna RT scene in their places, in its order.

    ``ply``, ``obj``, ``rectangle``, ``cube``, ``disk``, ``cylinder`` and ``sphere`` are read;
    circles become polygons of ``CIRCLE_SIDES`` sides, spheres 320 triangles. Materials:
    ``itu-radio-material`` (type, thickness), ``radio-material`` (permittivity, conductivity,
    thickness), and any other BSDF, also inside another, by an id such as ``mat-itu_concrete``.
    Without a thickness a wall is a half-space, where Sionna RT takes 0.1 m. An axis of rotation may
    have any length; Mitsuba asks for 1. Sources: W. Jakob et al., Mitsuba 3 documentation, "Scene
    XML file format" and "Shapes"; Sionna RT 1.2, ``scene_utils.process_xml`` and "Radio Materials".

    Parameters
    ----------
    path : The XML file; its meshes are looked for beside it.
    load_mesh : Reads a mesh file of a shape; it gets the path, ``unit`` and ``material``.
    """
    document = _parsed(path, load_mesh)
    used: set[str] = set()
    shapes = []
    for element in document.root:
        kind = str(element.tag)
        if kind == "shape":
            shapes.append(_shape(document, element, used))
        elif kind not in {*_NOT_SEEN, *_VALUES, "bsdf"}:
            msg = (
                f"<{kind}> in {path}, line {element.sourceline}, is not read; write out what it "
                "stands for (shapes, materials and defaults are read)."
            )
            raise GeometryError(msg)
    return shapes


def _parsed(path: Path, load_mesh: MeshReader) -> _Document:
    """Return the document."""
    root = xml_root(path, what="a Mitsuba scene", roots=("scene",))
    defaults = {
        str(e.get("name")): str(e.get("value")) for e in root.iter("default") if e.get("name")
    }
    materials = {str(e.get("id")): e for e in root.iter("bsdf") if e.get("id")}
    return _Document(
        path=path, load_mesh=load_mesh, root=root, defaults=defaults, materials=materials
    )


def _shape(document: _Document, element: Element, used: set[str]) -> MitsubaShape:
    """Return one shape, placed and labelled."""
    kind = document.attribute(element, "type") or ""
    where = document.where(element)
    if kind in MESH_SHAPES:
        vertices, faces = _mesh_of_file(document, element)
    elif kind in _SIMPLE:
        vertices, faces = _SIMPLE[kind](document, element)
    else:
        listed = ", ".join((*MESH_SHAPES, *_SIMPLE))
        msg = f"{where} has the type {kind!r}, but only {listed} are read; export it as a mesh."
        raise GeometryError(msg)
    placing = document.child(element, "to_world")
    placing = document.child(element, "toWorld") if placing is None else placing
    matrix = _transform_matrix(placing, document.attribute, where=where)
    flips = [document.text(element, n) for n in ("flip_normals", "flipNormals")]
    if (np.linalg.det(matrix[:3, :3]) < 0.0) != ("true" in flips):
        faces = faces[:, ::-1]
    given = document.attribute(element, "id") or document.attribute(element, "name") or kind
    return MitsubaShape(
        name=unused_name(given.removeprefix("mesh-") or kind, used),
        vertices=vertices @ matrix[:3, :3].T + matrix[:3, 3],
        faces=faces,
        material=_material_of(document, element),
    )


def _mesh_of_file(document: _Document, element: Element) -> tuple[FloatArray, IntArray]:
    """Return the mesh that a shape's ``filename`` names, relative to the scene."""
    name = document.text(element, "filename")
    if not name:
        msg = f"{document.where(element)} names no file; add a <string name='filename'>."
        raise GeometryError(msg)
    try:
        parts = document.load_mesh(document.path.parent / name, unit="m", material="any")
    except GeometryError as exc:
        msg = f"{document.where(element)}: {exc}"
        raise GeometryError(msg) from exc
    offsets = np.cumsum([0] + [len(part.vertices_m) for part in parts])
    faces = [part.faces + int(n) for part, n in zip(parts, offsets, strict=False)]
    return np.concatenate([part.vertices_m for part in parts]), np.concatenate(faces)


def _square(document: _Document, element: Element) -> tuple[FloatArray, IntArray]:
    del document, element
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=np.float64)
    return corners, np.array([(0, 1, 2), (0, 2, 3)])


def _cube(document: _Document, element: Element) -> tuple[FloatArray, IntArray]:
    del document, element
    body = box((2.0, 2.0, 2.0), material="any", position_m=(-1.0, -1.0, -1.0))
    return body.vertices_m, body.faces


def _ring(z: float) -> FloatArray:
    angle = 2.0 * math.pi * np.arange(CIRCLE_SIDES) / CIRCLE_SIDES
    return np.column_stack((np.cos(angle), np.sin(angle), np.full(CIRCLE_SIDES, z)))


def _disk(document: _Document, element: Element) -> tuple[FloatArray, IntArray]:
    del document, element
    i = np.arange(1, CIRCLE_SIDES - 1)
    return _ring(0.0), np.column_stack((np.zeros_like(i), i, i + 1))


def _cylinder(document: _Document, element: Element) -> tuple[FloatArray, IntArray]:
    """Return an open cylinder of a radius about the line from p0 to p1."""
    start = _point(document, element, "p0", (0.0, 0.0, 0.0))
    end = _point(document, element, "p1", (0.0, 0.0, 1.0))
    along = end - start
    length = float(np.linalg.norm(along))
    if length == 0.0:
        msg = f"{document.where(element)} has p0 and p1 in the same place; move one of them."
        raise GeometryError(msg)
    axis = along / length
    aside = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    aside /= np.linalg.norm(aside)
    frame = np.column_stack((aside, np.cross(axis, aside), axis))
    radius = _radius(document, element)
    rings = np.concatenate((_ring(0.0), _ring(1.0))) * (radius, radius, length)
    i = np.arange(CIRCLE_SIDES)
    j = (i + 1) % CIRCLE_SIDES
    halves = (
        np.column_stack((i, j, j + CIRCLE_SIDES)),
        np.column_stack((i, j + CIRCLE_SIDES, i + CIRCLE_SIDES)),
    )
    return rings @ frame.T + start, np.concatenate(halves)


def _sphere(document: _Document, element: Element) -> tuple[FloatArray, IntArray]:
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=2)
    centre = _point(document, element, "center", (0.0, 0.0, 0.0))
    vertices: FloatArray = np.asarray(ball.vertices) * _radius(document, element) + centre
    return vertices, np.asarray(ball.faces, dtype=np.int64)


_SIMPLE = {
    "rectangle": _square,
    "cube": _cube,
    "disk": _disk,
    "cylinder": _cylinder,
    "sphere": _sphere,
}


def _point(
    document: _Document, element: Element, name: str, default: tuple[float, float, float]
) -> FloatArray:
    child = document.child(element, name)
    if child is None:
        return np.array(default)
    where = f"{name} of {document.where(element)},"
    return _vector_of(child, document.attribute, where=where, default=0.0)


def _radius(document: _Document, element: Element) -> float:
    radius = document.number(element, "radius")
    if radius is not None and radius <= 0.0:
        msg = f"{document.where(element)} has the radius {radius:g}, but it must be positive."
        raise GeometryError(msg)
    return 1.0 if radius is None else radius


def _material_of(document: _Document, shape: Element) -> str | None:
    """Return the label of the material that a shape holds or refers to, or None."""
    for child in shape:
        if child.tag == "bsdf":
            return _label(document, child)
        if child.tag == "ref" and child.get("name") in {None, "bsdf"}:
            wanted = document.attribute(child, "id") or ""
            if wanted not in document.materials:
                known = ", ".join(document.materials) or "none"
                msg = (
                    f"{document.where(shape)} refers to the material {wanted!r}, but the file "
                    f"defines {known}; correct the <ref>."
                )
                raise GeometryError(msg)
            return _label(document, document.materials[wanted])
    return None


def _label(document: _Document, bsdf: Element) -> str | None:
    """Return the label of a BSDF: a name, or keys and values as a study file's table has them."""
    kind = (document.attribute(bsdf, "type") or "").replace("_", "-")
    name = (document.attribute(bsdf, "id") or "").removeprefix("mat-")
    itu = re.fullmatch(r"itu[_-](.+)", name)
    thickness = document.number(bsdf, "thickness")
    keys: dict[str, str | float | None] = {}
    if kind == "radio-material":
        keys["eps_r"] = document.number(bsdf, "relative_permittivity") or 1.0
        keys["sigma_s_per_m"] = document.number(bsdf, "conductivity") or 0.0
    elif kind == "itu-radio-material" or itu:
        chosen = document.text(bsdf, "type") or (itu[1] if itu else name)
        keys["name"] = re.sub(r"^itu[_-]", "", chosen).replace("-", "_")
    else:
        inner = bsdf.find("bsdf")
        found = None if inner is None else _label(document, inner)
        keys["name"] = name or found
    keys["thickness_m"] = thickness
    if not keys.get("name") and "eps_r" not in keys:
        return None
    given = {key: value for key, value in keys.items() if value is not None}
    if set(given) == {"name"}:
        return str(given["name"])
    return ", ".join(f"{key} = {value}" for key, value in given.items())


def _numbers_of(text: str, *, where: str) -> list[float]:
    """Return the finite numbers [-] of a text such as ``1, 2, 3``, split at spaces or commas."""
    try:
        found = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        found = [math.nan]
    if not all(math.isfinite(number) for number in found):
        msg = f"{where} gives {text!r}, but finite numbers are needed there."
        raise GeometryError(msg)
    return found


def _vector_of(
    element: Element,
    attribute: Attributes,
    *,
    where: str,
    default: float,
) -> FloatArray:
    """Return the vector of ``value="x y z"`` (one number for all three) or of x, y and z [-]."""
    value = attribute(element, "value")
    if value is None:
        given = [attribute(element, axis) for axis in _AXES]
        parts = [[default] if g is None else _numbers_of(g, where=where) for g in given]
        if all(len(part) == 1 for part in parts):
            return np.array([part[0] for part in parts])
    else:
        found = _numbers_of(value, where=where)
        if len(found) in (1, 3):
            return np.array(found * (3 // len(found)))
    msg = f"{where} must give one or three numbers."
    raise GeometryError(msg)


def _transform_matrix(
    element: Element | None,
    attribute: Attributes,
    *,
    where: str,
) -> FloatArray:
    """Return the matrix [-] of a ``<transform>``, its first step done first; None: the identity."""
    total = np.eye(4)
    for step in () if element is None else element:
        kind = str(step.tag)
        at = f"<{kind}> in {where}, line {step.sourceline},"
        if kind not in _STEPS:
            msg = f"{at} is not a transformation; known are {', '.join(_STEPS)}."
            raise GeometryError(msg)
        total = _STEPS[kind](step, attribute, at) @ total
    if not np.array_equal(total[3], (0.0, 0.0, 0.0, 1.0)):
        msg = f"the to_world matrix of {where} is a perspective one; give (0, 0, 0, 1) as last row."
        raise GeometryError(msg)
    scale = float(np.abs(total[:3, :3]).max())
    if scale == 0.0 or abs(np.linalg.det(total[:3, :3] / scale)) < 1e-12:
        msg = f"the to_world matrix of {where} is singular: it makes the shape flat; correct it."
        raise GeometryError(msg)
    return total


def _translate(step: Element, attribute: Attributes, where: str) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, 3] = _vector_of(step, attribute, where=where, default=0.0)
    return matrix


def _scale(step: Element, attribute: Attributes, where: str) -> FloatArray:
    return np.diag([*_vector_of(step, attribute, where=where, default=1.0), 1.0])


def _rotate(step: Element, attribute: Attributes, where: str) -> FloatArray:
    axis = _vector_of(step, attribute, where=where, default=0.0)
    angle = _numbers_of(attribute(step, "angle") or "", where=where)
    length = float(np.linalg.norm(axis))
    if length == 0.0 or len(angle) != 1:
        msg = f"{where} needs an axis other than zero and one angle in degrees."
        raise GeometryError(msg)
    x, y, z = axis / length
    quarters = angle[0] / 90.0
    if quarters == round(quarters):  # right angles stay exact
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    else:
        cos, sin = math.cos(math.radians(angle[0])), math.sin(math.radians(angle[0]))
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    unit = np.array([x, y, z])
    matrix = np.eye(4)
    matrix[:3, :3] = cos * np.eye(3) + sin * cross + (1.0 - cos) * np.outer(unit, unit)
    return matrix


def _matrix(step: Element, attribute: Attributes, where: str) -> FloatArray:
    found = _numbers_of(attribute(step, "value") or "", where=where)
    if len(found) == 9:
        matrix = np.eye(4)
        matrix[:3, :3] = np.reshape(found, (3, 3))
        return matrix
    if len(found) != 16:
        msg = f"{where} has {len(found)} numbers, but a matrix has 16 (or 9), row by row."
        raise GeometryError(msg)
    return np.reshape(found, (4, 4)).astype(np.float64)


def _lookat(step: Element, attribute: Attributes, where: str) -> FloatArray:
    given = [_numbers_of(attribute(step, n) or "", where=where) for n in ("origin", "target")]
    above = _numbers_of(attribute(step, "up") or "0 0 1", where=where)
    if any(len(vector) != 3 for vector in (*given, above)):
        msg = f"{where} needs origin, target and up of three numbers each."
        raise GeometryError(msg)
    origin, target, up = (np.array(vector) for vector in (*given, above))
    ahead = target - origin
    left = np.cross(up, ahead)
    if np.linalg.norm(left) <= 1e-12 * np.linalg.norm(up) * np.linalg.norm(ahead):
        msg = f"{where} looks along its own up, or nowhere; give another target or up."
        raise GeometryError(msg)
    ahead, left = ahead / np.linalg.norm(ahead), left / np.linalg.norm(left)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack((left, np.cross(ahead, left), ahead, origin))
    return matrix


_STEPS = {
    "translate": _translate,
    "scale": _scale,
    "rotate": _rotate,
    "matrix": _matrix,
    "lookat": _lookat,
}
