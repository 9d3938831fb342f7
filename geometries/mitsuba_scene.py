"""Scenes of Mitsuba and Sionna RT (XML with PLY or OBJ meshes and simple shapes) as meshes.

What is drawn counts: shapes, their places and their materials. Cameras, lights and integrators are
left out.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from lxml import etree
from lxml.etree import _Element as Element

from octant.geometries._mitsuba_transforms import numbers_of, transform_matrix, vector_of
from octant.geometries.errors import GeometryError
from octant.geometries.names import unused_name

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MESH_SHAPES = ("ply", "obj")
"""Shapes that stand in a file of their own."""
CIRCLE_SIDES = 24
"""Flat sides [-] of cylinders and disks, which Octant's rays see as prisms and polygons."""

_NOT_SEEN = ("sensor", "emitter", "integrator", "texture", "medium", "phase", "default", "path")
_VALUES = ("integer", "float", "string", "boolean", "rgb", "spectrum", "transform")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MitsubaShape:
    """One shape of a scene, in its place.

    Parameters
    ----------
    name : str
        The shape's id without ``mesh-`` before it, or its type; numbered where it repeats.
    vertices : (n, 3) float64
        Corners in the unit of the file [-], z up.
    faces : (m, 3) int64
        Vertex numbers of each triangle.
    material : str or None
        Label that the file gives; None where it gives none.
    """

    name: str
    vertices: FloatArray
    faces: IntArray
    material: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Document:
    """A parsed scene file: its root, its ``<default>`` values and its materials by id."""

    path: Path
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
        found = numbers_of(text, where=where)
        if len(found) != 1:
            msg = f"{where} gives {text!r}, but one number is needed."
            raise GeometryError(msg)
        return found[0]


def read_mitsuba(path: Path) -> list[MitsubaShape]:
    """Return the shapes of a Mitsuba or Sionna RT scene, in their places.

    Parameters
    ----------
    path : Path
        The XML file; its meshes are looked for beside it.

    Returns
    -------
    list of MitsubaShape
        In the order of the file.

    Raises
    ------
    GeometryError
        When the file is no such scene, a mesh is missing, a shape or a reference is unknown, or a
        matrix is singular.

    Notes
    -----
    ``ply``, ``obj``, ``rectangle``, ``cube``, ``disk``, ``cylinder`` and ``sphere`` are read;
    circles become polygons of ``CIRCLE_SIDES`` sides, spheres 320 triangles. Materials:
    ``itu-radio-material`` (type, thickness), ``radio-material`` (permittivity, conductivity,
    thickness), and any other BSDF, also inside another, by an id such as ``mat-itu_concrete``. A
    thickness makes a slab; without one a wall is a half-space, where Sionna RT takes 0.1 m. An axis
    of rotation of any length counts as a direction; Mitsuba asks for unit length.

    References
    ----------
    .. [1] W. Jakob et al., Mitsuba 3 documentation, "Scene XML file format" and "Shapes".
    .. [2] Sionna RT 1.2, ``scene_utils.process_xml`` and "Radio Materials".
    """
    document = _parsed(path)
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


def _parsed(path: Path) -> _Document:
    """Return the document, parsed without entities, without DTD and without network."""
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True,
        remove_pis=True,
    )  # fmt: skip
    try:
        tree = etree.parse(str(path), parser)
    except (etree.XMLSyntaxError, OSError) as exc:
        reason = str(exc).splitlines()[0].rstrip(".")
        msg = f"{path} cannot be read as an XML scene ({reason}); check the file."
        raise GeometryError(msg) from exc
    root = tree.getroot()
    if tree.docinfo.doctype or root.tag != "scene":
        what = "declares a DOCTYPE" if tree.docinfo.doctype else f"starts with <{root.tag}>"
        msg = f"{path} {what}, but a Mitsuba scene is a plain <scene> file; export it again."
        raise GeometryError(msg)
    defaults = {
        str(e.get("name")): str(e.get("value")) for e in root.iter("default") if e.get("name")
    }
    materials = {str(e.get("id")): e for e in root.iter("bsdf") if e.get("id")}
    return _Document(path=path, root=root, defaults=defaults, materials=materials)


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
    matrix = transform_matrix(placing, document.attribute, where=where)
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
    from octant.geometries.mesh_files import load_bodies

    name = document.text(element, "filename")
    if not name:
        msg = f"{document.where(element)} names no file; add a <string name='filename'>."
        raise GeometryError(msg)
    try:
        parts = load_bodies(document.path.parent / name, unit="m", material="any")
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
    from octant.geometries.furniture import box

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
    return vector_of(child, document.attribute, where=where, default=0.0)


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
