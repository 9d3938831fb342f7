"""What is wrong with a mesh, and what that means for rays; Octant repairs nothing."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries import _mesh_checks as checks
from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number
from octant.geometries._plane_geometry import FloatArray, IntArray, triangle_area_vectors
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.guesses import frame_lines, odd_shape
from octant.geometries.mesh_files import Reading, UpAxis, frame_of, load_bodies, metres_per_unit
from octant.geometries.scene import build_scene
from octant.geometries.tolerances import LENGTHS

LARGEST_PLAUSIBLE_M = 500.0
"""Extent above which a mesh is suspected to be in another unit [m]."""

SMALLEST_PLAUSIBLE_M = 0.02
"""Extent below which a mesh is suspected to be in another unit [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One thing worth knowing about a mesh.

    Parameters
    ----------
    kind : Name of the check, such as "free_edges".
    what : What was found, in a few words.
    meaning : What it means for rays, and what to do about it.
    """

    kind: str
    what: str
    meaning: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshAudit:
    """The result of looking over a mesh.

    All but the first four counts see the bodies as one mesh whose vertices are joined by position,
    without degenerate and duplicate triangles.

    Parameters
    ----------
    source : The file, or "bodies".
    body_names : Names of the bodies, in order.
    body_faces : (b,) int64 — Number of triangles of each body [-].
    vertices : Number of vertices as stored.
    unreferenced_vertices : Vertices that no triangle uses.
    welded_vertices : Number of different places among the used vertices.
    degenerate_faces : Triangles no higher than the tolerance.
    duplicate_faces : Triangles that repeat another one.
    area_m2 : Area of all triangles, one side each [m²].
    bounds_m : (2, 3) float64 — Lowest and highest corner [m].
    edge_lengths_m : (3,) float64 — Shortest, median and longest edge [m].
    open_edges : Edges that only one triangle has.
    t_junctions : Vertices in the interior of another triangle's open edge.
    free_edges : Pieces of open edges where the surface really ends, T-junctions resolved.
    free_edge_length_m : Their total length [m].
    non_manifold_edges : Edges that three or more triangles share.
    winding_conflicts : Edges whose two triangles, of one body, wind against each other.
    folded_edges : Edges at which two triangles lie on top of each other.
    components : Parts that hang together along edges.
    closed_components : Those of them without a free edge.
    inward_components : Closed ones whose normals point inwards.
    inside_out_components : Inward ones that stand within another part's surrounding box.
    tolerance_m : Vertices nearer than this were joined [m].
    findings : What is worth knowing, the most important first.
    scene_facets : Faces of the scene: flat polygons that its triangles make [-]; 0: not counted.
    frame : Why the file's unit and vertical axis are what they are, in sentences [m].
    """

    source: str
    body_names: tuple[str, ...]
    body_faces: npt.NDArray[np.int64]
    vertices: int
    unreferenced_vertices: int
    welded_vertices: int
    degenerate_faces: int
    duplicate_faces: int
    area_m2: float
    bounds_m: npt.NDArray[np.float64]
    edge_lengths_m: npt.NDArray[np.float64]
    open_edges: int
    t_junctions: int
    free_edges: int
    free_edge_length_m: float
    non_manifold_edges: int
    winding_conflicts: int
    folded_edges: int
    components: int
    closed_components: int
    inward_components: int
    inside_out_components: int
    tolerance_m: float
    findings: tuple[Finding, ...]
    scene_facets: int = 0
    frame: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count = frozen_array(self.body_faces, name="body_faces", shape=(None,), dtype=np.int64)
        bounds = frozen_array(self.bounds_m, name="bounds_m", shape=(2, 3))
        lengths = frozen_array(self.edge_lengths_m, name="edge_lengths_m", shape=(3,))
        object.__setattr__(self, "body_faces", count)
        object.__setattr__(self, "bounds_m", bounds)
        object.__setattr__(self, "edge_lengths_m", lengths)

    @property
    def faces(self) -> int:
        """Number of triangles as stored."""
        return int(self.body_faces.sum())

    def lines(self) -> list[str]:
        """Return the audit as lines of text: facts [m, m²], then each finding with its meaning."""
        low, high = self.bounds_m
        size = high - low
        shortest, median, longest = self.edge_lengths_m
        names = ", ".join(
            f"{name} ({count})"
            for name, count in zip(self.body_names, self.body_faces, strict=True)
        )
        places = f"{self.welded_vertices} places, joined within {1000 * self.tolerance_m:g} mm"
        places_after_point = max(0, 3 - math.floor(math.log10(max(float(size.max()), 1e-9))))
        spans = [
            f"{axis} {round(a, places_after_point) + 0.0:.12g} to "
            f"{round(b, places_after_point) + 0.0:.12g} m"
            for axis, a, b in zip("xyz", low.tolist(), high.tolist(), strict=True)
        ]
        flat = f", {_counted(self.scene_facets, 'flat face')} in the scene"
        facts = (
            f"{self.source}: {_counted(len(self.body_names), 'body', 'bodies')}, "
            f"{_counted(self.faces, 'triangle')}, {_counted(self.vertices, 'vertex', 'vertices')} "
            f"({places}){flat if self.scene_facets else ''}\n"
            f"  bodies (triangles): {names}\n"
            f"  bounds: {', '.join(spans)}\n"
            f"  size: {size[0]:.4g} x {size[1]:.4g} m, {size[2]:.4g} m high (z is up)\n"
            f"  surface: {self.area_m2:.4g} m2; edges: {shortest:.4g} to {longest:.4g} m long, "
            f"median {median:.4g} m\n"
            f"  parts: {self.components}, of which {self.closed_components} closed "
            f"({self.inward_components} with normals inwards)"
        )
        report = facts.split("\n")
        report += [f"  {line}" for line in self.frame]
        if not self.findings:
            report.append("  nothing else to report")
        for finding in self.findings:
            report += [f"  * {finding.what}", f"      {finding.meaning}"]
        return report


def audit_mesh(
    mesh: str | Path | Sequence[Body],
    *,
    unit: str | None = None,
    up: UpAxis | Literal["auto"] | None = None,
    tolerance_m: float = LENGTHS.weld_m,
    reading: Reading | None = None,
) -> MeshAudit:
    """Return what is wrong with a mesh, and what that means for rays.

    Surfaces that cross or touch along the inside of a triangle (a cabinet on a floor) are not
    looked for; the edge of a sheet that rests on another surface counts as free.

    Parameters
    ----------
    mesh : A mesh file, or bodies.
    unit : Unit of a file's coordinates; None where the format declares it.
    up : A file's vertical axis; None: the format's own; "auto": what it seems to be.
    tolerance_m : Vertices nearer than this are joined [m].
    reading : How a world or a floor plan is read.
    """
    tolerance = positive_number(tolerance_m, name="tolerance_m")
    frame: tuple[str, ...] = ()
    if isinstance(mesh, str | Path):
        source = str(mesh)
        guess = frame_of(mesh, reading=reading)
        metres = None if unit is None else metres_per_unit(unit)
        seen_up: UpAxis = "y" if guess.up == "y" else "z"
        bodies = load_bodies(
            mesh,
            unit=unit if unit is not None or guess.unit is None else guess.unit,
            up=seen_up if up == "auto" else up,
            material="any",
            reading=reading,
        )
        taken = None if up == "auto" or (up is None and not guess.against) else up
        if up is None and guess.against:
            taken = "z" if guess.up == "y" else "y"
        frame = frame_lines(guess, metres=metres, up=taken)
    else:
        source, bodies = "bodies", tuple(mesh)
    if not bodies:
        msg = "there is no body to audit; give a mesh file, or at least one body."
        raise GeometryError(msg)
    vertices, faces, body_of_face = _joined(bodies)
    welded = checks.welded_faces(vertices, faces, tolerance)
    flat = checks.degenerate_faces(vertices, welded, tolerance)
    solid = np.setdiff1d(np.arange(len(faces)), flat)
    if len(solid) == 0:
        msg = f"none of the {len(faces)} triangles of {source} has an area; check its unit."
        raise GeometryError(msg)
    repeated = checks.duplicate_faces(welded[solid])
    kept = np.delete(solid, repeated)
    table = checks.edge_table(welded[kept])
    border = checks.open_border(vertices, table, tolerance)
    parts = checks.components(vertices, welded[kept], table, border)
    used = vertices[np.unique(faces)]
    inward = parts.closed & (parts.volume_m3 < 0.0)
    numbers = {
        "unreferenced_vertices": len(vertices) - len(used),
        "degenerate_faces": len(flat),
        "duplicate_faces": len(repeated),
        "open_edges": int((table.sides == 1).sum()),
        "t_junctions": border.t_junctions,
        "free_edges": int(border.free.sum()),
        "non_manifold_edges": int((table.sides > 2).sum()),
        "winding_conflicts": checks.winding_conflicts(table, body_of_face[kept]),
        "folded_edges": checks.folded_edges(vertices, welded[kept], table),
        "components": len(parts.closed),
        "closed_components": int(parts.closed.sum()),
        "inward_components": int(inward.sum()),
        "inside_out_components": _inside_out(inward, parts.bounds_m),
    }
    bounds = np.stack((used.min(axis=0), used.max(axis=0)))
    free_m = float(_lengths_m(vertices, border.piece_vertices[border.free]).sum())
    edges_m = _lengths_m(vertices, table.edge_vertices)
    area = np.linalg.norm(triangle_area_vectors(vertices, faces), axis=1).sum()
    return MeshAudit(
        source=source,
        body_names=tuple(body.name for body in bodies),
        body_faces=np.array([len(body.faces) for body in bodies]),
        vertices=len(vertices),
        welded_vertices=len(np.unique(welded)),
        area_m2=float(area),
        bounds_m=bounds,
        edge_lengths_m=np.array([edges_m.min(), np.median(edges_m), edges_m.max()]),
        free_edge_length_m=free_m,
        tolerance_m=tolerance,
        findings=_findings(numbers, free_m=free_m, size_m=bounds[1] - bounds[0]),
        scene_facets=_scene_facets(bodies),
        frame=frame,
        **numbers,
    )


def _scene_facets(bodies: Sequence[Body]) -> int:
    """Return how many flat faces the bodies make, each of a material of its own [-]."""
    try:
        scene = build_scene([replace(body, material=body.name) for body in bodies])
    except GeometryError:  # what is wrong is said by the other counts
        return 0
    return len(scene.facets.facet_plane)


def _joined(bodies: Sequence[Body]) -> tuple[FloatArray, IntArray, IntArray]:
    """Return vertices, faces and the body of each face, of all bodies together."""
    offsets = np.cumsum([0, *(len(body.vertices_m) for body in bodies[:-1])])
    faces = np.concatenate([b.faces + n for b, n in zip(bodies, offsets, strict=True)])
    owner = np.repeat(np.arange(len(bodies)), [len(body.faces) for body in bodies])
    return np.concatenate([body.vertices_m for body in bodies]), faces, owner


def _lengths_m(vertices_m: FloatArray, ends: IntArray) -> FloatArray:
    """Return the distance between the two vertices of each row [m]."""
    lengths: FloatArray = np.linalg.norm(vertices_m[ends[:, 1]] - vertices_m[ends[:, 0]], axis=1)
    return lengths


def _inside_out(inward: npt.NDArray[np.bool_], bounds_m: FloatArray) -> int:
    """Return how many inward components stand within another component's surrounding box."""
    count = 0
    for part in np.flatnonzero(inward):
        low, high = bounds_m[part]
        around = (bounds_m[:, 0] <= low).all(axis=1) & (bounds_m[:, 1] >= high).all(axis=1)
        larger = np.ptp(bounds_m, axis=1).sum(axis=1) > (high - low).sum()
        count += bool((around & larger).any())
    return count


def _counted(number: int, one: str, many: str | None = None) -> str:
    """Return a number with its noun."""
    return f"{number} {one if number == 1 else many or one + 's'}"


def _findings(numbers: dict[str, int], *, free_m: float, size_m: FloatArray) -> tuple[Finding, ...]:
    """Return what is worth knowing, the most important first; empty when there is nothing."""
    findings = _size_findings(size_m)
    nouns = {
        "free_edges": f"of free border ({free_m:.4g} m in all)",
        "degenerate_faces": "without an area",
        "duplicate_faces": "given more than once",
        "folded_edges": "at which two triangles lie on top of each other",
        "inside_out_components": "inside out",
        "winding_conflicts": "with neighbours winding against each other",
        "t_junctions": "where a vertex lies inside another triangle's edge",
        "non_manifold_edges": "shared by three or more triangles",
        "unreferenced_vertices": "that no triangle uses",
    }
    things = {
        "free_edges": ("piece", "pieces"),
        "degenerate_faces": ("triangle", "triangles"),
        "duplicate_faces": ("triangle", "triangles"),
        "inside_out_components": ("closed part", "closed parts"),
        "t_junctions": ("T-junction", "T-junctions"),
        "unreferenced_vertices": ("vertex", "vertices"),
    }
    for kind, meaning in _MEANINGS.items():
        if numbers[kind]:
            what = f"{_counted(numbers[kind], *things.get(kind, ('edge', 'edges')))} {nouns[kind]}"
            findings.append(Finding(kind=kind, what=what, meaning=meaning))
    return tuple(findings)


_MEANINGS = {
    "folded_edges": (
        "rays reflect from surface that does not exist: this happens when a concave polygon is cut "
        "into a fan; triangulate the mesh in the modelling program."
    ),
    "free_edges": (
        "the surface ends there: rays pass through the opening and around the edge, and power "
        "leaves the room; right for a doorway or a sheet, a hole otherwise; an open room has no "
        "exact inside, so that its surrounding box decides whether an antenna is in it."
    ),
    "duplicate_faces": (
        "nothing changes where they are of one material, since they become one facet; where they "
        "are not, delete one."
    ),
    "degenerate_faces": "nothing changes: they are left out, since a line reflects nothing.",
    "inside_out_components": (
        "paths and powers do not change, since both sides of a facet reflect; figures may shade "
        "the part wrongly."
    ),
    "winding_conflicts": (
        "paths and powers do not change, since both sides of a facet reflect, and closed parts "
        "are wound alike before points are tested for being inside."
    ),
    "t_junctions": (
        "paths and powers do not change, since flat pieces are joined into facets whatever their "
        "mesh, and a part that is closed across T-junctions counts as closed."
    ),
    "non_manifold_edges": (
        "reflections are right; nothing needs doing where sheets meet, as a partition meets a wall."
    ),
    "unreferenced_vertices": "nothing changes.",
}


def _size_findings(size_m: FloatArray) -> list[Finding]:
    """Return doubts about the unit and the vertical axis."""
    findings: list[Finding] = []
    longest = float(size_m.max())
    if not SMALLEST_PLAUSIBLE_M <= longest <= LARGEST_PLAUSIBLE_M:
        what = f"the mesh is {longest:.4g} m long, which is unusual for a room or what stands in it"
        factor = "smaller" if longest > LARGEST_PLAUSIBLE_M else "larger"
        meaning = (
            "paths are right for the size given, but it is probably not the real one; check the "
            f"unit (in a unit 1000 times {factor} it would be "
            f"{longest / 1000 if factor == 'smaller' else longest * 1000:.4g} m)."
        )
        findings.append(Finding(kind="size", what=what, meaning=meaning))
    odd = odd_shape(size_m)
    higher = size_m[2] > max(size_m[0], size_m[1]) and longest > 1.0
    if odd or higher:
        what = f"the mesh is {odd}, which is an odd shape for a room"
        if higher:
            what = f"the mesh is higher ({size_m[2]:.4g} m) than it is long or wide"
        meaning = (
            "if it is a room, it may lie on its side; check which axis is up in the file, and give "
            'room.up = "y" or "z".'
        )
        findings.append(Finding(kind="up", what=what, meaning=meaning))
    return findings
