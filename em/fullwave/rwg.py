"""Rao-Wilton-Glisson functions on triangle meshes with junctions, and their impedance matrix.

A half-function of a triangle is l / (2A) (r - corner): it carries unit current density across the
edge opposite the corner, out of the triangle. A function joins two half-functions of triangles that
share an edge, so that no charge gathers there; an edge of n triangles carries n - 1 functions.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from octant.em.blocks import run_blocks
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.fullwave import _rwg_kernels
from octant.em.fullwave._rwg_kernels import FunctionArrays, TriangleArrays
from octant.em.fullwave._symmetry import sector_faces, turned_vertices
from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number
from octant.geometries.errors import GeometryError

VACUUM_PERMEABILITY = 4e-7 * math.pi
"""Permeability of vacuum [H/m]."""

VACUUM_IMPEDANCE_OHM = VACUUM_PERMEABILITY * SPEED_OF_LIGHT_M_PER_S
"""Wave impedance of vacuum [ohm]."""

NEAR = 1.5
"""Distance of centroids over the sum of both radii [-] below which 1/R is integrated exactly."""

MID = 4.0
"""The same [-] below which seven points are taken instead of three."""

ROWS_PER_BLOCK = 16
"""Triangles that a thread takes at a time [-]."""

TILE = 32
"""Side of the tiles in which the matrix is mirrored [entries, -]."""

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


SEVEN_POINTS, SEVEN_WEIGHTS = _seven_points()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SurfaceBasis:
    """Functions on a triangle mesh, in as many sectors as a turn about z leaves the mesh the same.

    Parameters
    ----------
    vertices_m : (v, 3) float64
        Vertices [m].
    faces : (sectors * f, 3) int64
        Vertex indices [-], sector by sector; a sector is the one before turned by 2 pi / sectors.
    given_face : (sectors * f,) int64
        Place of each triangle in the mesh that was given [-].
    sectors : int
        Number of sectors [-]; 1 without symmetry.
    functions : int
        Functions of one sector [-], half-functions on the axis counted as functions.
    axis_groups : tuple of (g,) int64
        Half-functions of the first sector that meet at each edge on the axis [-]; their sum over
        all sectors must vanish.
    start : (f + 1,) int64
        First entry of each of the first sector's triangles in the four arrays below [-].
    function : (e,) int64
        Function that a half-function belongs to [-].
    turn : (e,) int64
        Sectors by which that function is turned from the first sector [-].
    local : (e,) int64
        Corner, 0 to 2, opposite the edge [-].
    sign : (e,) float64
        Factor of the half-function in its function [-].
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
        """Number of independent functions on the whole mesh [-]."""
        return self.sectors * self.functions - len(self.axis_groups)

    @property
    def triangles_per_sector(self) -> int:
        """Number of triangles of one sector [-]."""
        return len(self.faces) // self.sectors

    @property
    def corners_m(self) -> npt.NDArray[np.float64]:
        """Return (f, 3, 3) the corners of all triangles [m]."""
        return cast(npt.NDArray[np.float64], self.vertices_m[self.faces])

    @property
    def edge_lengths_m(self) -> npt.NDArray[np.float64]:
        """Return (f, 3) the length of the edge opposite each corner [m]."""
        corners = self.corners_m
        sides = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
        return cast(npt.NDArray[np.float64], np.linalg.norm(sides, axis=2))

    @property
    def areas_m2(self) -> npt.NDArray[np.float64]:
        """Return (f,) the area of all triangles [m^2]."""
        a, b, c = np.moveaxis(self.corners_m, 1, 0)
        return cast(npt.NDArray[np.float64], 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))

    def triangle_arrays(self) -> TriangleArrays:
        """Return all triangles as the kernels take them [m]."""
        corner = np.ascontiguousarray(self.corners_m)
        centre = corner.mean(axis=1)
        offset = corner - centre[:, None]
        return TriangleArrays(
            count=self.triangles_per_sector,
            sectors=self.sectors,
            corner=corner,
            centre=centre,
            radius=np.linalg.norm(offset, axis=2).max(axis=1),
            area=self.areas_m2,
            offset=offset,
            length=self.edge_lengths_m,
            three=np.ascontiguousarray(np.einsum("ab,fbc->fac", THREE_POINTS, offset)),
            seven=np.ascontiguousarray(np.einsum("ab,fbc->fac", SEVEN_POINTS, offset)),
            seven_weight=SEVEN_WEIGHTS,
        )

    def half_coefficients(
        self, coefficients: npt.NDArray[np.complex128]
    ) -> npt.NDArray[np.complex128]:
        """Return (k, f, 3) the factor of every half-function of every triangle [as given].

        Parameters
        ----------
        coefficients : (k, sectors, functions) complex128
            Factors of the functions, sector by sector [any unit].

        Returns
        -------
        (k, sectors * f, 3) complex128
            Factors of the half-functions [same unit].
        """
        count = self.triangles_per_sector
        result = np.zeros((len(coefficients), self.sectors, count, 3), dtype=np.complex128)
        owner = np.repeat(np.arange(count), np.diff(self.start))
        flat = owner * 3 + self.local
        for s in range(self.sectors):
            part = coefficients[:, (self.turn + s) % self.sectors, self.function] * self.sign
            target = result[:, s].reshape(len(coefficients), -1)
            np.add.at(target, (slice(None), flat), part)
        return result.reshape(len(coefficients), -1, 3)

    def gathered(self, halves: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the products of functions with a field, from those of their half-functions.

        Parameters
        ----------
        halves : (k, sectors * f, 3) float64 or complex128
            Product of the field with every half-function [any unit].

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
            np.add.at(result, (slice(None), (self.turn + s) % self.sectors, self.function), part)
        return result


def surface_basis(
    vertices_m: npt.ArrayLike, faces: npt.ArrayLike, *, sectors: int = 1
) -> SurfaceBasis:
    """Return the Rao-Wilton-Glisson functions of a mesh.

    Parameters
    ----------
    vertices_m : (v, 3) array_like
        Vertices [m]; sheets that touch must share vertices and edges there.
    faces : (f, 3) array_like
        Vertex indices [-] of each triangle; orientation does not matter.
    sectors : int
        Ask for this rotational symmetry about z [-]; 1 for none.

    Returns
    -------
    SurfaceBasis
        Functions; its triangles are sorted by sector.

    Raises
    ------
    GeometryError
        When a triangle has no area, no edge is shared, or the mesh does not have the symmetry.
    """
    points = frozen_array(vertices_m, name="vertices_m", shape=(None, 3))
    given = frozen_array(faces, name="faces", shape=(None, 3), dtype=np.int64)
    _refuse_flat(points, given)
    if sectors == 1:
        layers: npt.NDArray[np.int64] | None = given[None]
        image: npt.NDArray[np.int64] | None = np.arange(len(points))
    else:
        image = turned_vertices(points, sectors)
        layers = None if image is None else sector_faces(given, image, sectors)
    entries = None
    if layers is not None and image is not None:
        entries = _functions(layers, image, sectors)
    if layers is None or entries is None:
        msg = (
            f"sectors is {sectors}, but a turn by {360.0 / sectors:g} deg about z does not map the "
            "mesh onto itself; give 1."
        )
        raise GeometryError(msg)
    count, groups, table = entries
    if count == 0:
        msg = "the mesh has no edge that two triangles share; weld its vertices first."
        raise GeometryError(msg)
    table = table[np.lexsort((table[:, 2], table[:, 1], table[:, 3], table[:, 0]))]
    per_triangle = np.bincount(table[:, 0], minlength=layers.shape[1])
    return SurfaceBasis(
        vertices_m=points,
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
    """Return the first of some numbers of sectors that a mesh has, or 1 [-].

    Parameters
    ----------
    vertices_m : (v, 3) float64
        Vertices [m].
    faces : (f, 3) int64
        Vertex indices [-].
    candidates : tuple of int
        Numbers of sectors to try, best first [-].

    Returns
    -------
    int
        Number of sectors [-].
    """
    for sectors in candidates:
        image = turned_vertices(vertices_m, sectors)
        if image is None:
            continue
        layers = sector_faces(faces, image, sectors)
        if layers is not None and _functions(layers, image, sectors) is not None:
            return sectors
    return 1


def _same_faces(
    given: npt.NDArray[np.int64], faces: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Return the place among the given triangles of each triangle of a rearranged mesh [-]."""
    rank, order = (np.lexsort(np.sort(some, axis=1).T) for some in (given, faces))
    place = np.empty(len(faces), dtype=np.int64)
    place[order] = rank
    return place


def _refuse_flat(points_m: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]) -> None:
    """Raise for triangles without area and for indices out of range."""
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


def _functions(
    layers: npt.NDArray[np.int64], image: npt.NDArray[np.int64], sectors: int
) -> tuple[int, tuple[npt.NDArray[np.int64], ...], npt.NDArray[np.int64]] | None:
    """Return number of functions, axis groups and entries (triangle, function, turn, local, sign).

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
            for (s, t, i), (s2, t2, i2) in zip(around[:-1], around[1:], strict=True):
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


def _colours(basis: SurfaceBasis) -> list[npt.NDArray[np.int64]]:
    """Return the first sector's triangles in groups that share no function [-]."""
    count = basis.triangles_per_sector
    members: Mapping[int, list[int]] = {m: [] for m in range(basis.functions)}
    own: list[list[int]] = [[] for _ in range(count)]
    for t in range(count):
        for m in basis.function[basis.start[t] : basis.start[t + 1]].tolist():
            members[m].append(t)
            own[t].append(m)
    colour = [-1] * count
    for t in range(count):
        taken = {colour[other] for m in own[t] for other in members[m]}
        colour[t] = next(c for c in range(count + 1) if c not in taken)
    array = np.array(colour)
    return [np.flatnonzero(array == c) for c in range(array.max() + 1)]


def impedance_matrix(
    basis: SurfaceBasis,
    *,
    frequency_hz: float,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
    near: float = NEAR,
    mid: float = MID,
) -> npt.NDArray[np.complex128]:
    """Return the matrix of the electric-field integral equation [ohm m^2].

    Parameters
    ----------
    basis : SurfaceBasis
        Functions.
    frequency_hz : float
        Frequency [Hz].
    surface_impedance_ohm : complex or (f,) array_like
        Tangential field over sheet current of every triangle [ohm]; 0 is a perfect conductor.
    near : float
        Distance of centroids over the sum of radii [-] below which 1/R is integrated exactly.
    mid : float
        The same [-] below which seven points are taken instead of three.

    Returns
    -------
    (functions, sectors, functions) complex128
        Entry (m, d, n): function m of the first sector tested by function n of sector d. It holds
        the same sum, bit for bit, whatever the number of threads.

    Notes
    -----
    Z = j w mu <f, A> + <div f, div-potential> / (j w eps) with exp(-jkR) / (4 pi R); functions test
    themselves (Galerkin). Near pairs take the closed forms of [2]_ over one triangle, and the mean
    of both orders. A closed surface has no solution at its interior resonances.

    References
    ----------
    .. [1] S. M. Rao, D. R. Wilton, A. W. Glisson, IEEE Trans. Antennas Propag. 30 (1982) 409,
       equations 10, 17-19.
    .. [2] D. R. Wilton et al., IEEE Trans. Antennas Propag. 32 (1984) 276, equations 5 and 6;
       R. D. Graglia, ibid. 41 (1993) 1448.
    """
    frequency = positive_number(frequency_hz, name="frequency_hz", unit="Hz")
    omega = 2.0 * math.pi * frequency
    wavenumber = omega / SPEED_OF_LIGHT_M_PER_S
    triangles = basis.triangle_arrays()
    functions = FunctionArrays(basis.start, basis.function, basis.turn, basis.local, basis.sign)
    sheet = np.zeros(len(basis.faces), dtype=np.complex128) + np.asarray(surface_impedance_ohm)
    counts = np.zeros(basis.triangles_per_sector, dtype=np.int64)
    _rwg_kernels.near_counts(triangles, near, counts)
    near_start = np.concatenate(([0], np.cumsum(counts)))
    near_list = np.empty(near_start[-1], dtype=np.int64)
    _rwg_kernels.near_lists(triangles, near, near_start, near_list)
    vector = 1j * omega * VACUUM_PERMEABILITY / (16.0 * math.pi)
    scalar = VACUUM_IMPEDANCE_OHM / (4j * math.pi * wavenumber)
    size = basis.functions
    z = np.zeros((size, basis.sectors, size), dtype=np.complex128)
    for rows in _colours(basis):

        def work(begin: int, end: int, rows: npt.NDArray[np.int64] = rows) -> None:
            _rwg_kernels.add_far(
                triangles, functions, rows, begin, end, wavenumber, near, mid, vector, scalar, z
            )
            _rwg_kernels.add_near(
                triangles,
                functions,
                rows,
                begin,
                end,
                near_start,
                near_list,
                wavenumber,
                vector,
                scalar,
                sheet,
                z,
            )

        run_blocks(work, len(rows), block_size=ROWS_PER_BLOCK)

    def mirror(begin: int, end: int) -> None:
        _rwg_kernels.add_mirror(z, TILE, begin, end)

    run_blocks(mirror, -(-size // TILE), block_size=2)
    return z
