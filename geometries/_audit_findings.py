"""What an audit says about each fault of a mesh."""

from dataclasses import dataclass

from octant.geometries._plane_geometry import FloatArray

LARGEST_PLAUSIBLE_M = 500.0
"""Extent above which a mesh is suspected to be in another unit [m]."""

SMALLEST_PLAUSIBLE_M = 0.02
"""Extent below which a mesh is suspected to be in another unit [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One thing worth knowing about a mesh.

    Parameters
    ----------
    kind : str
        Name of the check, such as "free_edges".
    what : str
        What was found, in a few words.
    meaning : str
        What it means for rays, and what to do about it.
    """

    kind: str
    what: str
    meaning: str


def counted(number: int, one: str, many: str | None = None) -> str:
    """Return a number with its noun.

    Parameters
    ----------
    number : int
        How many.
    one : str
        The noun for one.
    many : str or None
        The noun for any other number; None adds an s.
    """
    return f"{number} {one if number == 1 else many or one + 's'}"


def list_findings(
    numbers: dict[str, int], *, free_m: float, size_m: FloatArray
) -> tuple[Finding, ...]:
    """Return what is worth knowing, the most important first; empty when there is nothing.

    Parameters
    ----------
    numbers : dict
        Count of each kind of fault.
    free_m : float
        Total length of the free edges [m].
    size_m : (3,) float64
        Extent of the mesh [m].
    """
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
            what = f"{counted(numbers[kind], *things.get(kind, ('edge', 'edges')))} {nouns[kind]}"
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
        "are wound alike before it is asked what stands inside of them."
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
    if size_m[2] > max(size_m[0], size_m[1]) and longest > 1.0:
        what = f"the mesh is higher ({size_m[2]:.4g} m) than it is long or wide"
        meaning = "if it is a room, it may lie on its side; check which axis is up in the file."
        findings.append(Finding(kind="up", what=what, meaning=meaning))
    return findings
