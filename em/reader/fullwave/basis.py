"""Rao-Wilton-Glisson functions on triangle meshes with junctions of any number of sheets.

A half-function of a triangle is l / (2A) (r - corner): it carries unit current density across the
edge opposite the corner, out of the triangle. A function joins two half-functions of triangles that
share an edge, so that no charge gathers there; an edge of n triangles carries n - 1 functions.
"""

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave._rwg_kernels import TriangleArrays
from octant.em.reader.fullwave._symmetry import sector_faces, turned_vertices
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import GeometryError

THREE_POINTS = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
"""Barycentric points [-] of the rule of degree 2, equal weights."""


def _seven_points() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return barycentric points and weights of the rule of degree 5 (Radon)."""
    root = math.sqrt(15.0)
    points = [(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0)]
    weights = [9.0 / 40.0]
    for sign in (1.0, -1.0):
        a = (6.0 + sign * root) / 21.0
        b = 1.0 - 2.0 * a
        points += [(b, a, a), (a, b, a), (a, a, b)]
        weights += [(155.0 + sign * root) / 1200.0] * 3
    return np.array(points), np.array(weights)


def _close_points() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return barycentric points and weights that gather towards the edges of a triangle.

    Each third between the centroid and an edge holds four by four Gauss points; those across stand
    at 1 - (1 - x)^2 of the way to the edge. A triangle's potential has t log t at a distance t from
    its edges, which becomes a cube times a logarithm.
    """
    nodes, weights = np.polynomial.legendre.leggauss(4)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    centre, points, shares = np.full(3, 1.0 / 3.0), [], []
    for a, b in itertools.pairwise((0, 1, 2, 0)):
        for x, w in zip(nodes, weights, strict=True):
            out, step = 1.0 - (1.0 - x) ** 2, 2.0 * (1.0 - x) * w
            for y, v in zip(nodes, weights, strict=True):
                edge = (1.0 - y) * np.eye(3)[a] + y * np.eye(3)[b]
                points.append(centre + out * (edge - centre))
                shares.append(2.0 / 3.0 * out * step * v)
    return np.array(points), np.array(shares)


SEVEN_POINTS, SEVEN_WEIGHTS = _seven_points()
CLOSE_POINTS, CLOSE_WEIGHTS = _close_points()
MOVED_ALIKE_M = 1e-14
"""Steps in which moves of corners are told apart [m]: rounding of places is 100 times finer."""

RULES = np.concatenate((SEVEN_POINTS, THREE_POINTS))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SurfaceBasis:
    """Functions on a triangle mesh, in as many sectors as a turn about z leaves the mesh the same.

    Parameters
    ----------
    vertices_m : (v, 3) float64 — Vertices [m].
    faces : (sectors * f, 3) int64 — Vertex indices [-], sector by sector; a sector is the one
        before turned by 2 pi / sectors.
    given_face : (sectors * f,) int64 — Place of each triangle in the mesh that was given [-].
    sectors : Number of sectors; 1 without symmetry.
    functions : Functions of one sector, half-functions on the axis counted as functions.
    axis_groups : Half-functions of the first sector that meet at each edge on the axis [-]; their
        sum over all sectors must vanish.
    start : (f + 1,) int64 — First entry of each of the first sector's triangles in the four arrays
        below [-].
    function : (e,) int64 — Function that a half-function belongs to [-].
    turn : (e,) int64 — Sectors by which that function is turned from the first sector [-].
    local : (e,) int64 — Corner, 0 to 2, opposite the edge [-].
    sign : (e,) float64 — Factor of the half-function in its function [-].
    """

    vertices_m: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]
    given_face: npt.NDArray[np.int64]
    sectors: int
    functions: int
    axis_groups: tuple[npt.NDArray[np.int64], ...]
    start: npt.NDArray[np.int64]
    function: npt.NDArray[np.int64]
    turn: npt.NDArray[np.int64]
    local: npt.NDArray[np.int64]
    sign: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        for name, shape, dtype in (
            ("vertices_m", (None, 3), np.float64),
            ("faces", (None, 3), np.int64),
            ("given_face", (len(self.faces),), np.int64),
            ("start", (None,), np.int64),
            ("function", (None,), np.int64),
            ("turn", (None,), np.int64),
            ("local", (None,), np.int64),
            ("sign", (None,), np.float64),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    @property
    def unknowns(self) -> int:
        """Number of independent functions on the whole mesh."""
        return self.sectors * self.functions - len(self.axis_groups)

    @property
    def triangles_per_sector(self) -> int:
        """Number of triangles of one sector."""
        return len(self.faces) // self.sectors

    @property
    def corners_m(self) -> npt.NDArray[np.float64]:
        """Return (f, 3, 3) the corners of all triangles [m]."""
        corners: npt.NDArray[np.float64] = self.vertices_m[self.faces]
        return corners

    @property
    def edge_lengths_m(self) -> npt.NDArray[np.float64]:
        """Return (f, 3) the length of the edge opposite each corner [m]."""
        corners = self.corners_m
        sides = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
        lengths: npt.NDArray[np.float64] = np.linalg.norm(sides, axis=2)
        return lengths

    @property
    def areas_m2(self) -> npt.NDArray[np.float64]:
        """Return (f,) the area of all triangles [m^2]."""
        a, b, c = np.moveaxis(self.corners_m, 1, 0)
        areas: npt.NDArray[np.float64] = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        return areas

    def triangle_arrays(
        self, drawn: "SurfaceBasis | None" = None, *, changed_only: bool = False
    ) -> TriangleArrays:
        """Return all triangles as the kernels take them [m].

        Parameters
        ----------
        drawn : The same functions on the mesh that this one was moved from: distances there decide
            how pairs are integrated; None: distances here.
        changed_only : Leave out pairs that were moved alike.
        """
        corner = np.ascontiguousarray(self.corners_m)
        centre = corner.mean(axis=1)
        offset = corner - centre[:, None]
        given = corner if drawn is None else drawn.corners_m
        place = centre if drawn is None else given.mean(axis=1)
        motion = np.full(len(corner), -1, dtype=np.int64)
        if changed_only:
            shift = np.round((corner - given) / MOVED_ALIKE_M)
            alike = (shift == shift[:, :1]).all(axis=(1, 2))
            motion[alike] = np.unique(shift[alike, 0], axis=0, return_inverse=True)[1].reshape(-1)
        return TriangleArrays(
            per_sector=self.triangles_per_sector,
            sectors=self.sectors,
            corner=corner,
            centre=centre,
            radius=np.linalg.norm(given - place[:, None], axis=2).max(axis=1),
            area=self.areas_m2,
            offset=offset,
            length=self.edge_lengths_m,
            points=np.ascontiguousarray(np.einsum("ab,fbc->fac", RULES, offset)),
            weight=np.concatenate((SEVEN_WEIGHTS, np.ones(3))),
            close=CLOSE_POINTS,
            close_weight=CLOSE_WEIGHTS,
            place=np.ascontiguousarray(place),
            motion=motion,
        )

    def half_coefficients(
        self, coefficients: npt.NDArray[np.complex128]
    ) -> npt.NDArray[np.complex128]:
        """Return (k, f, 3) the factor of every half-function of every triangle [as given].

        Parameters
        ----------
        coefficients : (k, sectors, functions) complex128 — Factors of the functions, sector by
            sector [any unit].
        """
        count = self.triangles_per_sector
        result = np.zeros((len(coefficients), self.sectors, count, 3), dtype=np.complex128)
        owner = np.repeat(np.arange(count), np.diff(self.start))
        flat = owner * 3 + self.local
        for s in range(self.sectors):
            part = coefficients[:, (self.turn + s) % self.sectors, self.function] * self.sign
            target = result[:, s].reshape(len(coefficients), -1)
            for row, value in zip(target, part, strict=True):
                np.add.at(row, flat, value)
        return result.reshape(len(coefficients), -1, 3)

    def gathered(self, halves: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the products of functions with a field, from those of their half-functions.

        Parameters
        ----------
        halves : (k, sectors * f, 3) float64 or complex128 — Product of the field with every
            half-function [any unit].

        Returns
        -------
        (k, sectors, functions) ndarray
            Product with every function [same unit].
        """
        count = self.triangles_per_sector
        result = np.zeros((len(halves), self.sectors, self.functions), dtype=halves.dtype)
        owner = np.repeat(np.arange(count), np.diff(self.start))
        for s in range(self.sectors):
            part = halves[:, s * count + owner, self.local] * self.sign
            place = ((self.turn + s) % self.sectors) * self.functions + self.function
            for row, value in zip(result.reshape(len(halves), -1), part, strict=True):
                np.add.at(row, place, value)
        return result


def surface_basis(
    vertices_m: npt.ArrayLike, faces: npt.ArrayLike, *, sectors: int = 1
) -> SurfaceBasis:
    """Return the Rao-Wilton-Glisson functions of a mesh.

    Parameters
    ----------
    vertices_m : (v, 3) array_like — Vertices [m]; sheets that touch must share vertices and edges
        there.
    faces : (f, 3) array_like — Vertex indices [-] of each triangle; orientation does not matter.
    sectors : Ask for this rotational symmetry about z; 1 for none.

    Returns
    -------
    SurfaceBasis
        Functions; its triangles are sorted by sector.
    """
    points, given = _checked(vertices_m, faces)
    found = _symmetric_functions(points, given, sectors)
    if found is None:
        msg = (
            f"sectors is {sectors}, but a turn by {360.0 / sectors:g} deg about z does not map the "
            "mesh onto itself; give 1."
        )
        raise GeometryError(msg)
    return _basis_of(points, given, sectors, found)


def best_basis(
    vertices_m: npt.ArrayLike, faces: npt.ArrayLike, candidates: tuple[int, ...]
) -> SurfaceBasis:
    """Return the functions of a mesh in the first of some numbers of sectors that it has, or in 1.

    Parameters
    ----------
    vertices_m, faces : As for `surface_basis` [m].
    candidates : Numbers of sectors to try, best first.
    """
    points, given = _checked(vertices_m, faces)
    for sectors in candidates:
        found = _symmetric_functions(points, given, sectors)
        if found is not None:
            return _basis_of(points, given, sectors, found)
    return surface_basis(points, given)


_Functions = tuple[int, tuple[npt.NDArray[np.int64], ...], npt.NDArray[np.int64]]
"""Number of functions, axis groups and entries (triangle, function, turn, local, sign)."""


def _checked(
    vertices_m: npt.ArrayLike, faces: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    points = frozen_array(vertices_m, name="vertices_m", shape=(None, 3))
    given = frozen_array(faces, name="faces", shape=(None, 3), dtype=np.int64)
    _refuse_bad(points, given)
    return points, given


def _symmetric_functions(
    points_m: npt.NDArray[np.float64], faces: npt.NDArray[np.int64], sectors: int
) -> tuple[npt.NDArray[np.int64], _Functions] | None:
    """Return triangles (sectors, f, 3) and functions; None without that symmetry."""
    if sectors == 1:
        layers: npt.NDArray[np.int64] | None = faces[None]
        image: npt.NDArray[np.int64] | None = np.arange(len(points_m))
    else:
        image = turned_vertices(points_m, sectors)
        layers = None if image is None else sector_faces(faces, image, sectors)
    if layers is None or image is None:
        return None
    entries = _functions(layers, image, sectors)
    return None if entries is None else (layers, entries)


def _basis_of(
    points_m: npt.NDArray[np.float64],
    given: npt.NDArray[np.int64],
    sectors: int,
    found: tuple[npt.NDArray[np.int64], _Functions],
) -> SurfaceBasis:
    layers, (count, groups, table) = found
    if count == 0:
        msg = "the mesh has no edge that two triangles share; weld its vertices first."
        raise GeometryError(msg)
    table = table[np.lexsort((table[:, 2], table[:, 1], table[:, 3], table[:, 0]))]
    per_triangle = np.bincount(table[:, 0], minlength=layers.shape[1])
    return SurfaceBasis(
        vertices_m=points_m,
        faces=layers.reshape(-1, 3),
        given_face=_same_faces(given, layers.reshape(-1, 3)),
        sectors=sectors,
        functions=count,
        axis_groups=groups,
        start=np.concatenate(([0], np.cumsum(per_triangle))),
        function=table[:, 1],
        turn=table[:, 2],
        local=table[:, 3],
        sign=table[:, 4].astype(np.float64),
    )


def best_sectors(
    vertices_m: npt.NDArray[np.float64],
    faces: npt.NDArray[np.int64],
    candidates: tuple[int, ...],
) -> int:
    """Return the first of some numbers of sectors that a mesh has, or 1.

    Parameters
    ----------
    vertices_m : (v, 3) float64 — Vertices [m].
    faces : (f, 3) int64 — Vertex indices [-].
    candidates : Numbers of sectors to try, best first.
    """
    found = (n for n in candidates if _symmetric_functions(vertices_m, faces, n) is not None)
    return next(found, 1)


def _same_faces(
    given: npt.NDArray[np.int64], faces: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Return the place among the given triangles of each triangle of a rearranged mesh [-]."""
    rank, order = (np.lexsort(np.sort(some, axis=1).T) for some in (given, faces))
    place = np.empty(len(faces), dtype=np.int64)
    place[order] = rank
    return place


def _refuse_bad(points_m: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]) -> None:
    """Raise for indices out of range, triangles without area and triangles that stand twice."""
    if len(faces) == 0 or faces.min() < 0 or faces.max() >= len(points_m):
        msg = f"faces must hold indices of the {len(points_m)} vertices, at least one triangle."
        raise GeometryError(msg)
    a, b, c = (points_m[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.maximum.reduce([((u - v) ** 2).sum(axis=1) for u, v in ((a, b), (b, c), (c, a))])
    bad = np.flatnonzero(~(area > 1e-9 * longest))
    if len(bad):
        msg = f"triangle {bad[0]} has no area; remove such triangles from the mesh."
        raise GeometryError(msg)
    corners = np.sort(faces, axis=1)
    _, first, number = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[number.ravel()] != np.arange(len(faces)))
    if len(again):
        other = first[number.ravel()[again[0]]]
        msg = (
            f"triangles {other} and {again[0]} lie on each other, so that the currents on them "
            "cannot be told apart; remove one."
        )
        raise GeometryError(msg)


def _functions(
    layers: npt.NDArray[np.int64], image: npt.NDArray[np.int64], sectors: int
) -> _Functions | None:
    """Return the functions of a sector and their entries.

    None when a part of a turn maps an edge off the axis onto itself.
    """
    count = layers.shape[1]
    sheets: dict[tuple[int, int], list[tuple[int, int, int]]] = {}
    for s in range(sectors):
        for t, (a, b, c) in enumerate(layers[s].tolist()):
            for i, (u, v) in enumerate(((b, c), (c, a), (a, b))):
                sheets.setdefault((min(u, v), max(u, v)), []).append((s, t, i))
    done: set[tuple[int, int]] = set()
    rows: list[tuple[int, int, int, int, int]] = []
    groups: list[npt.NDArray[np.int64]] = []
    onward = image.tolist()
    number = 0
    for edge, around in sheets.items():
        if edge in done:
            continue
        orbit = [edge]
        for _ in range(sectors - 1):
            u, v = onward[orbit[-1][0]], onward[orbit[-1][1]]
            orbit.append((min(u, v), max(u, v)))
        done.update(orbit)
        distinct = len(set(orbit))
        if distinct == sectors:
            for (s, t, i), (s2, t2, i2) in itertools.pairwise(around):
                rows.append((t, number, -s % sectors, i, 1))
                rows.append((t2, number, -s2 % sectors, i2, -1))
                number += 1
        elif distinct == 1 and onward[edge[0]] == edge[0]:
            first = [(t, i) for s, t, i in around if s == 0]
            rows += [(t, number + n, 0, i, 1) for n, (t, i) in enumerate(first)]
            groups.append(np.arange(number, number + len(first)))
            number += len(first)
        else:
            return None
    table = np.array(rows, dtype=np.int64).reshape(-1, 5)
    return (number, tuple(groups), table) if count else None
