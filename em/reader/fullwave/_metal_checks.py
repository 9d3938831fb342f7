"""What is wrong with metal that is to be solved: size, loose edges, crossings, ports."""

import itertools
from collections.abc import Sequence

import numpy as np

from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.errors import GeometryError
from octant.geometries.occlusion import build_bvh, segments_blocked
from octant.geometries.tolerances import LENGTHS

LEAST_SPAN, MOST_SPAN = 0.02, 30.0
"""Size of metal with ports in wavelengths [-], outside which its unit is likely to be wrong."""


def refuse_other_unit(points_m: FloatArray, wavelength_m: float) -> None:
    """Refuse metal whose size in wavelengths tells of another unit."""
    span_m = float(np.linalg.norm(np.ptp(points_m, axis=0)))
    span = span_m / wavelength_m
    if LEAST_SPAN <= span <= MOST_SPAN:
        return
    units = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
    fits = [
        f"{name} instead of {other}"
        for name, other in itertools.permutations(units, 2)
        if LEAST_SPAN <= span * units[name] / units[other] <= 4.0
    ]
    hint = f" it would fit with {' or '.join(fits[:2])}" if fits else " give another size"
    msg = (
        f"the metal is {span_m:.3g} m large, {span:.2g} wavelengths, but {LEAST_SPAN:g} to "
        f"{MOST_SPAN:g} are solved; look at its unit:{hint}."
    )
    raise GeometryError(msg)


def refuse_loose(points_m: FloatArray, faces: IntArray) -> None:
    """Refuse a vertex that lies on another triangle's open edge: no current would pass there."""
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    rim = edges[count == 1]
    corners = np.unique(rim)
    start, end = points_m[rim[:, 0]], points_m[rim[:, 1]]
    along = end - start
    square = (along**2).sum(axis=1)
    for vertex in corners.tolist():
        share = ((points_m[vertex] - start) * along).sum(axis=1) / square
        off = np.linalg.norm(points_m[vertex] - start - share[:, None] * along, axis=1)
        inside = (share > 1e-6) & (share < 1.0 - 1e-6) & (off < LENGTHS.weld_m)
        if inside.any():
            place = ", ".join(f"{x:.4g}" for x in points_m[vertex])
            msg = (
                f"the metal is open at ({place}) m: a corner there lies on another triangle's edge "
                "without sharing it, so that no current passes; mesh both sides alike."
            )
            raise GeometryError(msg)


def refuse_crossing(points_m: FloatArray, faces: IntArray) -> None:
    """Refuse triangles that edges of others cross."""
    bvh = build_bvh(points_m[faces], np.arange(len(faces)), extent_m=1.0)
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    start, end = points_m[edges[:, 0]], points_m[edges[:, 1]]
    inner = 1e-6 * (end - start)
    crossed = np.flatnonzero(segments_blocked(bvh, start + inner, end - inner))
    for i in crossed.tolist():
        middle = ", ".join(f"{x:.4g}" for x in 0.5 * (start[i] + end[i]))
        msg = (
            f"triangles cross near ({middle}) m without a common edge, so that no current passes "
            "there; cut them along their line, or move them apart."
        )
        raise GeometryError(msg)


def refuse_shared(faces: IntArray, ports: Sequence[IntArray]) -> None:
    """Refuse two ports on one edge."""
    taken: dict[tuple[int, ...], int] = {}
    for number, port in enumerate(ports):
        edges = {tuple(sorted(np.delete(faces[f], c).tolist())) for f, c in port.tolist()}
        for edge in edges:
            if taken.setdefault(edge, number) != number:
                msg = (
                    f"ports {taken[edge] + 1} and {number + 1} are on one edge, but an edge has "
                    "one voltage; give them different ones."
                )
                raise GeometryError(msg)


def edges_m(points_m: FloatArray, faces: IntArray) -> FloatArray:
    """Return (f, 3) the lengths of all triangles' edges [m]."""
    corners = points_m[faces]
    lengths: FloatArray = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    return lengths
