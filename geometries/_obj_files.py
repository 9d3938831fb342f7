"""Wavefront OBJ, read and written so that no body, polygon or digit is lost.

trimesh's own reader cuts every polygon into a fan, which is wrong for a concave one (the floor of
an L-shaped room, as modelling programs write it), and its names depend on what else the file holds.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries._polygons import triangulate_polygon_3d
from octant.geometries.errors import GeometryError
from octant.geometries.names import unused_name

Part = tuple[str, FloatArray, IntArray]
LARGEST = 1e15
"""Greatest coordinate [unit of the file]: squares and cubes of it stay far from overflow."""

_Key = tuple[str, str, str]  # object, group, material


def read_obj(path: Path) -> list[Part]:
    """Return name, vertices [unit of the file] and faces of an OBJ file's parts, in its order.

    A part is what stands under one ``o`` and one ``g``, called after the object, the group, or
    ``object.group`` when they differ; with several ``usemtl`` it is split into ``part.material``.
    """
    vertices: list[list[float]] = []
    polygons: dict[_Key, list[tuple[int, list[int]]]] = {}
    current = {"o": "", "g": "", "usemtl": ""}
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), start=1):
        keyword, _, rest = line.strip().partition(" ")
        try:
            if keyword == "v":
                vertices.append(_vertex(rest))
            elif keyword == "f":
                key = (current["o"], current["g"], current["usemtl"])
                polygons.setdefault(key, []).append((number, _corners(rest, len(vertices))))
            elif keyword in current:
                current[keyword] = rest.strip()
        except ValueError as exc:
            msg = f"{path}, line {number}, {line.strip()!r} cannot be read: {exc}."
            raise GeometryError(msg) from exc
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    names = _names(list(polygons), path.stem)
    return [
        (name, *_part(points, polygons[key], name=name, path=path)) for key, name in names.items()
    ]


def _vertex(text: str) -> list[float]:
    """Return the three coordinates of a ``v`` line."""
    numbers = [float(x) for x in text.split()[:3]]
    if len(numbers) != 3 or not all(abs(x) <= LARGEST for x in numbers):
        msg = f"a vertex needs three finite coordinates of at most {LARGEST:g}"
        raise ValueError(msg)
    return numbers


def _corners(text: str, count: int) -> list[int]:
    """Return the zero-based vertex numbers of an ``f`` line, such as ``7/1/3 8/2/3 -1``."""
    given = [int(item.split("/")[0]) for item in text.split()]
    if len(given) < 3:
        msg = "a face needs at least three corners"
        raise ValueError(msg)
    indices = [i - 1 if i > 0 else count + i for i in given]
    if 0 in given or min(indices) < 0:
        msg = f"a corner stands before the first vertex ({count} vertices were given so far)"
        raise ValueError(msg)
    return indices


def _names(keys: list[_Key], stem: str) -> dict[_Key, str]:
    """Return a distinct name for each (object, group, material)."""
    materials: dict[tuple[str, str], set[str]] = {}
    for obj, group, material in keys:
        materials.setdefault((obj, group), set()).add(material)
    names: dict[_Key, str] = {}
    used: set[str] = set()
    for obj, group, material in keys:
        parts = [p for p in (obj, group if group != obj else "") if p] or [stem]
        if len(materials[obj, group]) > 1 and material:
            parts.append(material)
        names[obj, group, material] = unused_name(".".join(parts), used)
    return names


def _part(
    points: FloatArray, polygons: list[tuple[int, list[int]]], *, name: str, path: Path
) -> tuple[FloatArray, IntArray]:
    """Return the vertices that a part uses, and its triangles."""
    triangles: list[IntArray] = []
    for number, corners in polygons:
        if max(corners) >= len(points):
            msg = f"{path}, line {number}, names vertex {max(corners) + 1} of only {len(points)}."
            raise GeometryError(msg)
        ring = np.array(corners, dtype=np.int64)
        if len(ring) == 3:
            triangles.append(ring[None, :])
            continue
        where = f"the polygon of {name!r} in {path}, line {number},"
        triangles.append(ring[triangulate_polygon_3d(points[ring], name=where)])
    faces = np.concatenate(triangles)
    used, compact = np.unique(faces, return_inverse=True)
    return points[used], compact.reshape(-1, 3).astype(np.int64)


def write_obj(parts: Iterable[Part], path: Path) -> None:
    """Write named parts to an OBJ file, one ``o`` each, with every digit of float64."""
    lines: list[str] = []
    offset = 1
    for name, vertices, faces in parts:
        lines.append(f"o {name}")
        lines.extend(f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist())
        lines.extend(f"f {a} {b} {c}" for a, b, c in (faces + offset).tolist())
        offset += len(vertices)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
