"""Any metal with ports: triangles as given, fed at edges, alone or over an infinite plane.

A port is a row of edges: a volt across it drives current out of the triangles on one side. The
plane z = 0 is taken in by images: the metal and its mirror image in free space, fed so that the
tangential field vanishes half-way between them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave._metal_checks import (
    edges_m,
    refuse_crossing,
    refuse_loose,
    refuse_other_unit,
    refuse_shared,
)
from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.em.reader.fullwave.conductor import Conductor, surface_impedance
from octant.em.reader.fullwave.mesh import BODY
from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import FloatArray, IntArray, weld
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS

MOST_EDGE = 0.3
"""Longest edge that a triangle may have [wavelengths]; with 4 cells per wavelength some have it."""
MOST_HALVINGS = 8
"""How often triangles are halved when they are refined [-]."""
GROUND = "ground"
"""Name of the infinite plane where a port says between which parts it lies."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PortedMesh:
    """Triangles of metal and the edges at which it is fed.

    Parameters
    ----------
    vertices_m : (v, 3) float64 — Vertices [m]; sheets that touch share them.
    faces : (f, 3) int64 — Vertex indices of each triangle [-].
    ports : Half-functions (k, 2) of each port, triangle and corner opposite the edge [-], out of
        which a positive voltage drives current.
    phase_centres_m : (n, 3) float64 — Middle of each port's edges [m].
    coarse_m : Longest edge [m].
    frequency_hz : Frequency that it is meshed for [Hz].
    ground : Whether the plane z = 0 is infinite metal.
    warnings : What makes the result doubtful, one sentence each.
    conductor : What it is made of; None: perfect metal, as the infinite plane always is.
    wire_radius_m : (f,) float64 — Radius of the wire that each triangle's strip stands for; 0 on
        sheets [m].
    """

    vertices_m: FloatArray
    faces: IntArray
    ports: tuple[IntArray, ...]
    phase_centres_m: FloatArray
    coarse_m: float
    frequency_hz: float
    ground: bool = False
    warnings: tuple[str, ...] = ()
    conductor: Conductor | None = None
    wire_radius_m: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        count = len(self.ports)
        if not len(self.wire_radius_m):
            object.__setattr__(self, "wire_radius_m", np.zeros(len(self.faces)))
        for name, shape, dtype in (
            ("vertices_m", (None, 3), np.float64),
            ("faces", (None, 3), np.int64),
            ("phase_centres_m", (count, 3), np.float64),
            ("wire_radius_m", (len(self.faces),), np.float64),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    @property
    def antennas(self) -> int:
        """Number of ports."""
        return len(self.ports)

    @property
    def antenna_of_face(self) -> IntArray:
        """All triangles are the body's."""
        return np.full(len(self.faces), BODY, dtype=np.int64)

    def surface_impedance_ohm(self, frequency_hz: float) -> npt.NDArray[np.complex128]:
        """Return (f,) the surface impedance of the triangles [ohm].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        return surface_impedance(
            self.conductor,
            frequency_hz,
            wire_radius_m=self.wire_radius_m,
            perfect=np.zeros(len(self.faces), dtype=bool),
        )

    def half_excitations(self, basis: SurfaceBasis) -> npt.NDArray[np.float64]:
        """Return (n, f, 3) the product of each half-function with one volt at each port [V m].

        Parameters
        ----------
        basis : Functions of this mesh.
        """
        place = np.empty(len(basis.faces), dtype=np.int64)
        place[basis.given_face] = np.arange(len(basis.faces))
        lengths = basis.edge_lengths_m
        halves = np.zeros((len(self.ports), len(basis.faces), 3))
        for one, port in zip(halves, self.ports, strict=True):
            for face, corner in port.tolist():
                # The corner by its vertex: the basis may have turned the triangle.
                given = self.faces[face]
                own = place[face]
                local = int(np.flatnonzero(basis.faces[own] == given[corner])[0])
                one[own, local] += lengths[own, local]
        return halves


def over_ground(mesh: PortedMesh) -> PortedMesh:
    """Return metal over an infinite plane together with its image, ports driven with theirs.

    Half the power and half the admittance of the whole are those over the plane.

    Parameters
    ----------
    mesh : Metal at z >= 0; edges on z = 0 are joined to the plane.
    """
    points, tolerance_m = mesh.vertices_m, LENGTHS.weld_m
    if float(points[:, 2].min()) < -tolerance_m:
        msg = (
            f"metal reaches down to z = {points[:, 2].min():.3g} m, but the infinite plane is at "
            "z = 0 and all metal above it; raise it."
        )
        raise GeometryError(msg)
    flat = np.flatnonzero((np.abs(points[mesh.faces][:, :, 2]) < tolerance_m).all(axis=1))
    if len(flat):
        msg = (
            f"triangle {flat[0]} lies in the infinite plane, z = 0, which is metal already; leave "
            "it out."
        )
        raise GeometryError(msg)
    count = len(mesh.faces)
    both = np.concatenate((points, points * np.array((1.0, 1.0, -1.0))))
    faces = weld(both, tolerance_m)[np.concatenate((mesh.faces, mesh.faces + len(points)))]
    ports = []
    for port in mesh.ports:
        ends = [mesh.faces[f][[k for k in range(3) if k != c]] for f, c in port.tolist()]
        grounded = np.abs(points[np.array(ends)][:, :, 2]).max() < tolerance_m
        image = port + np.array((count, 0))
        if grounded:
            # Out of the image, into the metal: two volts across both.
            ports.append(np.concatenate((image, image)))
        else:
            ports.append(np.concatenate((port, _other_side(faces, image))))
    used, packed = np.unique(faces, return_inverse=True)
    return replace(
        mesh,
        vertices_m=both[used],
        faces=packed.reshape(-1, 3),
        ports=tuple(ports),
        ground=True,
        wire_radius_m=np.tile(mesh.wire_radius_m, 2),
    )


def _other_side(faces: IntArray, port: IntArray) -> IntArray:
    """Return the half-functions (k, 2) of the triangles on the other side of a port's edges."""
    side = {tuple(sorted(np.delete(faces[f], c).tolist())) for f, c in port.tolist()}
    given = {int(f) for f, _ in port.tolist()}
    found = [
        (f, c)
        for f in _touching(faces, {v for edge in side for v in edge})
        if f not in given
        for c in range(3)
        if tuple(sorted(np.delete(faces[f], c).tolist())) in side
    ]
    return np.array(found, dtype=np.int64)


def _touching(faces: IntArray, vertices: set[int]) -> list[int]:
    """Return the triangles that have two or more of some vertices."""
    return np.flatnonzero(np.isin(faces, list(vertices)).sum(axis=1) >= 2).tolist()


def ported_mesh(
    parts: Sequence[tuple[str, FloatArray, IntArray]],
    ports: Sequence[tuple[str, str]],
    *,
    frequency_hz: float,
    ground: bool = False,
    conductor: Conductor | None = None,
    wires_m: Mapping[str, float] = MappingProxyType({}),
) -> PortedMesh:
    """Return named parts of metal joined where they share edges, with ports between them.

    Parameters
    ----------
    parts : Name, vertices (v, 3) [m] and triangles (f, 3) of each part; parts of one name are one.
    ports : Names of the two parts of each port: a positive voltage drives current from the first
        into the second; ``ground`` is the infinite plane.
    frequency_hz : Frequency [Hz].
    ground : Whether the plane z = 0 is infinite metal.
    conductor : What the parts are made of; None: perfect metal.
    wires_m : Radius of the wire that the strips of a part stand for, by the part's name [m].
    """
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / frequency_hz
    names = list(dict.fromkeys(name for name, _, _ in parts))
    start = np.cumsum([0, *(len(v) for _, v, _ in parts)])
    points = np.concatenate([np.asarray(v, dtype=np.float64) for _, v, _ in parts])
    given = np.concatenate([np.asarray(f) + s for (_, _, f), s in zip(parts, start, strict=False)])
    owner = np.repeat([names.index(name) for name, _, _ in parts], [len(f) for _, _, f in parts])
    refuse_other_unit(points, wavelength_m)
    faces = weld(points, LENGTHS.weld_m)[given]
    used, packed = np.unique(faces, return_inverse=True)
    points, faces = points[used], packed.reshape(-1, 3).astype(np.int64)
    longest_m = float(edges_m(points, faces).max())
    if longest_m > MOST_EDGE * wavelength_m:
        msg = (
            f"the metal has triangles with edges of {longest_m:.3g} m, "
            f"{longest_m / wavelength_m:.2g} wavelengths, but at most {MOST_EDGE:g} are solved; "
            "refine them, or mesh them finer."
        )
        raise GeometryError(msg)
    refuse_loose(points, faces)
    refuse_crossing(points, faces)
    halves = [
        _port(points, faces, owner, names, pair, number=i, ground=ground)
        for i, pair in enumerate(ports)
    ]
    refuse_shared(faces, halves)
    middles = [
        points[np.array([np.delete(faces[f], c) for f, c in one.tolist()])].mean(axis=(0, 1))
        for one in halves
    ]
    mesh = PortedMesh(
        vertices_m=points,
        faces=faces,
        ports=tuple(halves),
        phase_centres_m=np.array(middles).reshape(-1, 3),
        coarse_m=longest_m,
        frequency_hz=frequency_hz,
        warnings=() if conductor is None else conductor.doubts(frequency_hz),
        conductor=conductor,
        wire_radius_m=np.array([wires_m.get(name, 0.0) for name in names])[owner],
    )
    return over_ground(mesh) if ground else mesh


def refined(
    parts: Sequence[tuple[str, FloatArray, IntArray]], *, edge_m: float
) -> list[tuple[str, FloatArray, IntArray]]:
    """Return named parts, all their triangles cut in four until no edge is longer than wanted.

    All parts are cut alike, so that edges that they share stay shared.

    Parameters
    ----------
    parts : Name, vertices (v, 3) [m] and triangles (f, 3) of each.
    edge_m : Longest edge [m].
    """
    found = list(parts)
    for _ in range(MOST_HALVINGS):
        longest_m = max((float(edges_m(v, f).max()) for _, v, f in found), default=0.0)
        if longest_m <= edge_m * (1.0 + LENGTHS.same_share):
            break
        found = [(name, *_halved(points, faces)) for name, points, faces in found]
    return found


def _halved(points_m: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Return a mesh with every triangle cut in four."""
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, number = np.unique(sides, axis=0, return_inverse=True)
    middle = number.reshape(-1, 3) + len(points_m)
    a, b, c = faces.T
    ab, bc, ca = middle.T
    cut = np.stack(((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)), axis=0)
    points = np.concatenate((points_m, points_m[edges].mean(axis=1)))
    return points, np.moveaxis(cut, 2, 0).reshape(-1, 3)


def _port(
    points_m: FloatArray,
    faces: IntArray,
    owner: IntArray,
    names: Sequence[str],
    pair: tuple[str, str],
    *,
    number: int,
    ground: bool,
) -> IntArray:
    """Return the half-functions (k, 2) of a port between two parts."""
    for name in pair:
        if name not in names and not (ground and name == GROUND):
            known = ", ".join(repr(one) for one in names)
            msg = f"port {number + 1} names the part {name!r}, but there are {known}; name these."
            raise GeometryError(msg)
    of_edge: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for f, face in enumerate(faces.tolist()):
        for c in range(3):
            a, b = sorted((face[(c + 1) % 3], face[(c + 2) % 3]))
            of_edge.setdefault((a, b), []).append((f, c))
    found: list[tuple[int, int]] = []
    if GROUND in pair and ground:
        (part,) = (names.index(name) for name in pair if name != GROUND)
        for (a, b), sides in of_edge.items():
            low = max(abs(points_m[a, 2]), abs(points_m[b, 2])) < LENGTHS.weld_m
            found += [side for side in sides if low and owner[side[0]] == part]
    else:
        first, second = (names.index(name) for name in pair)
        for sides in of_edge.values():
            parts = {int(owner[f]) for f, _ in sides}
            if first != second and {first, second} <= parts:
                found += [side for side in sides if owner[side[0]] == first]
    if not found:
        msg = (
            f"port {number + 1} is on no edge: the parts {pair[0]!r} and {pair[1]!r} share none; "
            "let them meet in an edge of both meshes."
        )
        raise GeometryError(msg)
    return np.array(found, dtype=np.int64)


def ruled_sheet(
    left_m: npt.ArrayLike, right_m: npt.ArrayLike, *, columns: int = 1
) -> tuple[FloatArray, IntArray]:
    """Return vertices [m] and triangles of a sheet between two lines of as many points.

    Parameters
    ----------
    left_m, right_m : (k, 3) array_like — Points of both rims, row by row [m].
    columns : Cells from rim to rim.
    """
    left, right = np.asarray(left_m, dtype=np.float64), np.asarray(right_m, dtype=np.float64)
    share = np.linspace(0.0, 1.0, columns + 1)[:, None]
    points = left[:, None] + (right - left)[:, None] * share
    row, column = np.divmod(np.arange((len(left) - 1) * columns), columns)
    a = row * (columns + 1) + column
    c = a + columns + 2
    faces = np.stack(((a, a + 1, c), (a, c, c - 1)), axis=0)
    return points.reshape(-1, 3), np.moveaxis(faces, 2, 0).reshape(-1, 3)


def strip(
    start_m: npt.ArrayLike,
    end_m: npt.ArrayLike,
    *,
    width_m: float,
    across: npt.ArrayLike,
    rows: int,
    columns: int = 1,
) -> tuple[FloatArray, IntArray]:
    """Return vertices [m] and triangles of a straight strip.

    Parameters
    ----------
    start_m, end_m : (3,) array_like — Ends of its middle line [m].
    width_m : Width [m]; four times the radius of the wire that it stands for.
    across : (3,) array_like — Direction of the width [-].
    rows, columns : Cells along and across.
    """
    side = np.asarray(across, dtype=np.float64)
    half = 0.5 * width_m * side / math.sqrt(float(side @ side))
    line = np.linspace(np.asarray(start_m, float), np.asarray(end_m, float), rows + 1)
    return ruled_sheet(line - half, line + half, columns=columns)
