"""Triangle meshes of the reader for the method of moments, antennas included.

Sheets share vertices wherever they meet: plates on the ground plane, plates at the axis, joined
monopoles on the ground plane. Congruent pieces get congruent meshes, so the mesh has every rotation
that the reader has.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave._built_mesh import (
    AROUND,
    PLANE,
    STRIP,
    Parts,
    built_lines_m,
    built_vertices_m,
)
from octant.em.reader.fullwave._clearance import clearance_m, close_doubts, refuse_crossed_planes
from octant.em.reader.fullwave._element_size import GROWTH, ElementSize
from octant.em.reader.fullwave._reader_pieces import (
    PieceMesher,
    ground_pieces,
    joined_pieces,
    plane_pieces,
    plate_pieces,
)
from octant.em.reader.fullwave._strips import Strip, strip_cells, strip_triangles
from octant.em.reader.fullwave.conductor import Conductor, surface_impedance
from octant.em.reader.fullwave.surroundings import even_mesh
from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.occlusion import build_bvh, segments_blocked
from octant.geometries.reader_body import MIN_ROUND_SIDES, ReaderBody, ground_plane_outline_m

ElementKind = Literal["dipole", "monopole"]
"""Kinds of antenna that the mesh can carry."""

CELLS_PER_WAVELENGTH = 10.0
"""Default number of elements per wavelength [-]; 14 for final figures."""

WIRE_RADIUS_M = 0.0005
"""Default radius [m] of the antennas' wire."""

FEED_GAP_M = 0.0057
"""Default length [m] over which the source's voltage is spread evenly along the strip."""

BODY, BESIDE = -1, -2
"""Marks of triangles of the reader's sheets, and of metal beside the reader, in place of an
antenna's number [-]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReaderMesh:
    """Triangles of a reader's body and antennas, and where the antennas are fed.

    Parameters
    ----------
    vertices_m : (v, 3) float64 — Vertices [m], in the reader frame; sheets that touch share them.
    faces : (f, 3) int64 — Vertex indices of each triangle [-].
    antenna_of_face : (f,) int64 — Antenna, from 0, whose strip the triangle belongs to; ``BODY``
        or ``BESIDE`` on other metal [-].
    feed_bottom_m : (n, 3) float64 — Lower end of each antenna's feed, on the strip's middle line
        [m].
    feed_top_m : (n, 3) float64 — Upper end of each antenna's feed [m]; equal to the lower one for a
        delta gap.
    strip_of_feed : (n,) int64 — Strip, from 0, that each feed is on [-]; a strip may have several.
    phase_centres_m : (n, 3) float64 — Middle of each dipole, foot of each monopole [m].
    coarse_m : Edge length [m] away from the antennas.
    frequency_hz : Frequency that the edge length was taken from [Hz].
    warnings : What makes the result doubtful, one sentence each.
    conductor : What the reader is made of; None: perfect metal, as what is beside it always is.
    wire_radius_m : Radius of the wire that the antennas' strips stand for [m].
    """

    vertices_m: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]
    antenna_of_face: npt.NDArray[np.int64]
    feed_bottom_m: npt.NDArray[np.float64]
    feed_top_m: npt.NDArray[np.float64]
    strip_of_feed: npt.NDArray[np.int64]
    phase_centres_m: npt.NDArray[np.float64]
    coarse_m: float
    frequency_hz: float
    warnings: tuple[str, ...] = ()
    conductor: Conductor | None = None
    wire_radius_m: float = WIRE_RADIUS_M

    def __post_init__(self) -> None:
        count = len(self.feed_bottom_m)
        for name, shape, dtype in (
            ("vertices_m", (None, 3), np.float64),
            ("faces", (None, 3), np.int64),
            ("antenna_of_face", (len(self.faces),), np.int64),
            ("feed_bottom_m", (count, 3), np.float64),
            ("feed_top_m", (count, 3), np.float64),
            ("strip_of_feed", (count,), np.int64),
            ("phase_centres_m", (count, 3), np.float64),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    @property
    def antennas(self) -> int:
        """Number of feeds."""
        return len(self.feed_bottom_m)

    def surface_impedance_ohm(self, frequency_hz: float) -> npt.NDArray[np.complex128]:
        """Return (f,) the surface impedance of the triangles [ohm].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        return surface_impedance(
            self.conductor,
            frequency_hz,
            wire_radius_m=np.where(self.antenna_of_face >= 0, self.wire_radius_m, 0.0),
            perfect=self.antenna_of_face == BESIDE,
        )


def reader_mesh(
    body: ReaderBody,
    *,
    frequency_hz: float,
    antenna: ElementKind = "dipole",
    length_m: float | None = None,
    gap_m: float = 0.005,
    cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    wire_radius_m: float = WIRE_RADIUS_M,
    feed_gap_m: float = FEED_GAP_M,
    graded_tips: bool = True,
    surroundings: Sequence[Body] = (),
    conductor: Conductor | None = None,
) -> ReaderMesh:
    """Return the triangles [m] of a reader and its antennas for the method of moments.

    Parameters
    ----------
    body : Ground plane, plates, places of the antennas.
    frequency_hz : Frequency [Hz], above 0.
    antenna : "dipole" or "monopole".
    length_m : Length of a dipole, height of a monopole [m]; None takes half, or a quarter,
        wavelength.
    gap_m : Height of a dipole's lower end, or of a monopole's own plane, above the ground plane
        [m], above 0. A monopole without a plane of its own stands on the ground plane, gap or not.
    cells_per_wavelength : Elements per wavelength [-], at least 4.
    wire_radius_m : Radius a of the antennas' wire [m]; the strip is 4 a wide and stands across the
        radius.
    feed_gap_m : Length of the feed [m]; 0 is a delta gap. It is at a dipole's middle, at a
        monopole's foot.
    graded_tips : Cut the strips' last cells finer, where charge gathers; see Notes.
    surroundings : Further perfectly conducting meshes in the reader frame, such as a robot, not
        touching it.
    conductor : What the reader is made of; None: perfect metal.

    Notes
    -----
    A strip of width 4 a has the capacitance and inductance of a round wire of radius a (the
    equivalent radius of a thin strip is a quarter of its width). A dipole of 6.25 cm, a = 0.5 mm,
    feed 5.7 mm, has 91.3 + j50.5 ohm as a round tube; as a strip of 24 cells with graded tips it
    has 89.7 + j49.1 (2 % off), as with 96 even cells; with 24 even cells 88.9 + j47.1 (4 % off).

    Within a wedge of plates nearer than about 1 cm to the strip the result depends on the mesh;
    ``warnings`` says so.

    References
    ----------
    .. [1] C. A. Balanis, Antenna Theory, 3rd ed. (2005), table 9.3: equivalent radius of a strip.
    """
    return reader_meshes(
        (body,),
        frequency_hz=frequency_hz,
        antenna=antenna,
        length_m=length_m,
        gap_m=gap_m,
        cells_per_wavelength=cells_per_wavelength,
        wire_radius_m=wire_radius_m,
        feed_gap_m=feed_gap_m,
        graded_tips=graded_tips,
        surroundings=surroundings,
        conductor=conductor,
    )[0]


def reader_meshes(
    bodies: Sequence[ReaderBody],
    *,
    frequency_hz: float,
    antenna: ElementKind = "dipole",
    length_m: float | None = None,
    gap_m: float = 0.005,
    cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    wire_radius_m: float = WIRE_RADIUS_M,
    feed_gap_m: float = FEED_GAP_M,
    graded_tips: bool = True,
    surroundings: Sequence[Body] = (),
    conductor: Conductor | None = None,
) -> tuple[ReaderMesh, ...]:
    """Return the triangles [m] of one drawn reader in several builds: the same ones, moved.

    Parameters
    ----------
    bodies : One drawn reader, built otherwise each.
    frequency_hz, antenna, length_m, gap_m, cells_per_wavelength : As for `reader_mesh` [Hz], [m].
    wire_radius_m, feed_gap_m, graded_tips, surroundings, conductor : As for `reader_mesh` [m].
    """
    body = bodies[0]
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / positive_number(
        frequency_hz, name="frequency_hz", unit="Hz"
    )
    if antenna not in ("dipole", "monopole"):
        msg = f"antenna is {antenna!r}, but the full-wave mesh carries 'dipole' or 'monopole'."
        raise GeometryError(msg)
    if not cells_per_wavelength >= 4.0:
        msg = f"cells_per_wavelength is {cells_per_wavelength}, but it must be at least 4."
        raise GeometryError(msg)
    share = 0.5 if antenna == "dipole" else 0.25
    length = share * wavelength_m
    if length_m is not None:
        length = positive_number(length_m, name="length_m")
    radius = positive_number(wire_radius_m, name="wire_radius_m")
    feed = positive_number(feed_gap_m, name="feed_gap_m", allow_zero=True)
    _refuse_long_feed(feed, length)
    own_plane_m = body.fitted_monopole_plane_m if antenna == "monopole" else 0.0
    joined = antenna == "monopole" and own_plane_m == 0.0
    gap = 0.0 if joined else positive_number(gap_m, name="gap_m")
    cells = strip_cells(length, wavelength_m, cells_per_wavelength)
    coarse = wavelength_m / cells_per_wavelength
    rim = _rim_m(body, coarse)
    strips = [
        Strip.upright(
            float(azimuth),
            antenna_radius_m=body.antenna_radius_m,
            bottom_m=gap,
            length_m=length,
            width_m=4.0 * radius,
            cells=cells,
            grounded=antenna == "monopole",
            graded=graded_tips,
            rim_m=rim if joined else None,
        )
        for azimuth in body.element_azimuths_rad
    ]
    size = ElementSize(
        coarse_m=coarse,
        finest_m=min(2.0 * radius, coarse, GROWTH * gap if antenna == "dipole" else coarse),
        strips_m=np.array([strip.middle_line_m for strip in strips]),
        planes_m=np.array([s.middle_line_m[0] for s in strips if own_plane_m > 0.0]).reshape(-1, 3),
        plane_side_m=own_plane_m,
    )
    mesher = PieceMesher(size)
    ground = ground_pieces(body, rim, strips, mesher, joined=joined)
    plates = plate_pieces(body, mesher)
    planes = plane_pieces(strips, own_plane_m, mesher) if own_plane_m > 0.0 else []
    around = [
        even_mesh(b.vertices_m, b.faces, edge_m=coarse, turns=body.antennas) for b in surroundings
    ]
    upright = [strip_triangles(strip) for strip in strips]
    parts = _joined_parts((ground, plates, planes, around, upright))
    laid = _Laid(
        parts=parts,
        strips=strips,
        around=around,
        rim_m=rim,
        joined=joined,
        wire_radius_m=radius,
        feed_m=feed,
        coarse_m=coarse,
        frequency_hz=frequency_hz,
        conductor=conductor,
    )
    return tuple(_as_built(laid, one) for one in bodies)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Laid:
    """A drawn reader's joined mesh, and what its builds need to know of it."""

    parts: Parts
    strips: Sequence[Strip]
    around: Sequence[tuple[FloatArray, IntArray]]
    rim_m: FloatArray
    joined: bool
    wire_radius_m: float
    feed_m: float
    coarse_m: float
    frequency_hz: float
    conductor: Conductor | None


def _as_built(laid: _Laid, body: ReaderBody) -> ReaderMesh:
    """Return the mesh with its corners where they are as built."""
    parts, strips, feed = laid.parts, laid.strips, laid.feed_m
    dipole = not strips[0].grounded
    lines = built_lines_m(body, strips, joined=laid.joined)
    _refuse_long_feed(feed, float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).min()))
    vertices = built_vertices_m(parts, body, strips, lines, rim_m=laid.rim_m, joined=laid.joined)
    outlines = [vertices[parts.vertices_of(STRIP, i), :2] for i in range(len(strips))]
    clearance = clearance_m(body, outlines, lines, width_m=4.0 * laid.wire_radius_m)
    if body.errors is not None and (parts.kind == PLANE).any():
        both = ((2 * i, 2 * i + 1) for i in range(len(strips)))
        refuse_crossed_planes(
            body,
            [vertices[np.union1d(*(parts.vertices_of(PLANE, k) for k in p)), :2] for p in both],
        )
    beside = _beside_m(vertices, parts, laid.around)
    bottom, middle = lines[:, 0], lines.mean(axis=1)
    up = lines[:, 1] - lines[:, 0]
    up *= feed / np.linalg.norm(up, axis=1)[:, None]
    doubts = [*close_doubts(clearance), *_near_doubts(beside, laid.coarse_m)]
    if laid.conductor is not None:
        over = float(bottom[:, 2].min()) if dipole else math.inf
        apart = min(clearance, over, beside)
        doubts += laid.conductor.doubts(laid.frequency_hz, apart_m=apart)
    owner = np.where(parts.kind == STRIP, parts.number, BODY)
    owner[parts.kind == AROUND] = BESIDE
    return ReaderMesh(
        vertices_m=vertices,
        faces=parts.faces,
        antenna_of_face=owner,
        feed_bottom_m=middle - 0.5 * up if dipole else bottom,
        feed_top_m=middle + 0.5 * up if dipole else bottom + up,
        strip_of_feed=np.arange(len(strips)),
        phase_centres_m=middle if dipole else bottom,
        coarse_m=laid.coarse_m,
        frequency_hz=laid.frequency_hz,
        warnings=tuple(doubts),
        conductor=laid.conductor,
        wire_radius_m=laid.wire_radius_m,
    )


def _rim_m(body: ReaderBody, coarse_m: float) -> npt.NDArray[np.float64]:
    """Return the corners of the ground plane's rim [m]; a round one as round as the mesh allows."""
    if body.ground_plane_shape != "round":
        return ground_plane_outline_m(
            body.ground_plane_m, shape=body.ground_plane_shape, antennas=body.antennas
        )
    step = 2 * body.antennas
    sides = max(math.pi * body.ground_plane_m / coarse_m, MIN_ROUND_SIDES)
    sides = step * math.ceil(sides / step)
    angle = 2.0 * math.pi * np.arange(sides) / sides
    rim: npt.NDArray[np.float64] = (0.5 * body.ground_plane_m) * np.column_stack(
        (np.cos(angle), np.sin(angle))
    )
    return rim


def _refuse_long_feed(feed_m: float, length_m: float) -> None:
    """Raise when the feed is not shorter than the antenna."""
    if feed_m >= length_m:
        msg = (
            f"feed_gap_m is {feed_m:g} m, but the antenna is only {length_m:g} m long; give a "
            "shorter feed, or 0 for a delta gap."
        )
        raise GeometryError(msg)


def _joined_parts(kinds: Sequence[Sequence[tuple[FloatArray, IntArray]]]) -> Parts:
    """Return the pieces of each kind of sheet as one mesh, numbered within their kind."""
    vertices, faces = joined_pieces([piece for kind in kinds for piece in kind])
    sizes = [len(triangles) for kind in kinds for _, triangles in kind]
    return Parts(
        vertices_m=vertices,
        faces=faces,
        kind=np.repeat([number for number, kind in enumerate(kinds) for _ in kind], sizes),
        number=np.repeat([i for kind in kinds for i in range(len(kind))], sizes),
    )


def _beside_m(
    vertices_m: FloatArray, parts: Parts, around: Sequence[tuple[FloatArray, IntArray]]
) -> float:
    """Return the least distance between corners of reader and surroundings [m]; refuse crossings.

    Meshes that cross would have no common edge there, and no current could pass.
    """
    from scipy.spatial import cKDTree

    least = math.inf
    own_faces = parts.faces[parts.kind < AROUND]
    own = (vertices_m, own_faces)
    for given in around:
        for (v, f), (w, g) in ((given, own), (own, given)):
            bvh = build_bvh(w[g], np.zeros(len(g), dtype=np.int64), extent_m=1.0)
            starts, ends = v[f].reshape(-1, 3), v[f[:, [1, 2, 0]]].reshape(-1, 3)
            if segments_blocked(bvh, starts, ends).any():
                msg = "surroundings cross the reader's ground plane or plates; move them apart."
                raise GeometryError(msg)
        corners = cKDTree(vertices_m[np.unique(own_faces)])
        least = min(least, float(corners.query(given[0])[0].min()))
    return least


def _near_doubts(beside_m: float, coarse_m: float) -> tuple[str, ...]:
    """Return a warning when surroundings come nearer than one element."""
    if beside_m >= coarse_m:
        return ()
    text = (
        f"surroundings come within {1e3 * beside_m:.1f} mm of the reader, nearer than an element "
        f"of {1e3 * coarse_m:.1f} mm: currents do not pass between them, and their coupling is "
        "coarse"
    )
    return (text,)
