"""Feeds of antennas: what a volt across a gap excites in each half-function."""

import itertools

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS


def feed_excitation(
    basis: SurfaceBasis,
    faces: npt.NDArray[np.int64],
    bottom_m: npt.ArrayLike,
    top_m: npt.ArrayLike,
    axis: npt.ArrayLike = (0.0, 0.0, 1.0),
) -> npt.NDArray[np.float64]:
    """Return (f, 3) the product of every half-function with the field of a feed at one volt [V m].

    Parameters
    ----------
    basis : Functions.
    faces : (k,) int64 — Triangles of the antenna [-], numbered as in the basis.
    bottom_m : (3,) array_like — Start of the feed [m].
    top_m : (3,) array_like — End of the feed [m]; the same as the start for a delta gap on the
        edges there.
    axis : (3,) array_like — Direction of a delta gap [-]; ignored for a feed of some length.

    Returns
    -------
    (f, 3) float64
        Integral of half-function times field [V m]. The field drives current from bottom to top.

    Notes
    -----
    A feed of length g holds the even field 1/g on the part of every triangle between its ends,
    integrated exactly. A delta gap sits where current leaves the triangles below the edge; where
    there are none, as at the foot of a monopole that stands on a sheet, where it enters those
    above, whatever sheets it comes from.
    """
    bottom, top = np.asarray(bottom_m, dtype=np.float64), np.asarray(top_m, dtype=np.float64)
    length = float(np.linalg.norm(top - bottom))
    halves = np.zeros((len(basis.faces), 3))
    if length == 0.0:
        direction = np.asarray(axis, dtype=np.float64)
        direction = direction / np.linalg.norm(direction)
    else:
        direction = (top - bottom) / length
    corners = basis.corners_m[faces]
    height = (corners - bottom) @ direction
    edge_m = basis.edge_lengths_m
    if length == 0.0:
        at_gap = np.abs(height) < LENGTHS.joined_m
        across = np.stack([at_gap[:, [1, 2, 0]] & at_gap[:, [2, 0, 1]]])[0]
        below = across & (height.mean(axis=1) < 0.0)[:, None]
        chosen, sign = (below, 1.0) if below.any() else (across, -1.0)
        triangle, local = np.nonzero(chosen)
        if len(triangle) == 0:
            msg = (
                f"no edge of the antenna's mesh lies at the feed, {bottom.tolist()} m; mesh the "
                "antenna so that an edge crosses it there, or give the feed a length."
            )
            raise GeometryError(msg)
        halves[faces[triangle], local] = sign * edge_m[faces[triangle], local]
        return halves
    area = basis.areas_m2
    found = False
    inside = np.flatnonzero((height.max(axis=1) > 0.0) & (height.min(axis=1) < length))
    for face, corner, along in zip(
        faces[inside].tolist(), corners[inside], height[inside], strict=True
    ):
        share, middle = _part_between(corner, along, length)
        if share > 0.0:
            found = True
            step = middle - along
            halves[face] = edge_m[face] * share * step / (2.0 * area[face] * length)
    if not found:
        msg = (
            f"no triangle of the antenna lies along the feed from {bottom.tolist()} m to "
            f"{top.tolist()} m; put the feed on the antenna."
        )
        raise GeometryError(msg)
    return halves


def _part_between(
    corner_m: npt.NDArray[np.float64], along_m: npt.NDArray[np.float64], length_m: float
) -> tuple[float, float]:
    """Return area [m^2] and mean height [m] of a triangle's part at heights from 0 to a length."""
    polygon = [np.append(c, h) for c, h in zip(corner_m, along_m, strict=True)]
    for sign, level in ((1.0, 0.0), (-1.0, -length_m)):
        kept = []
        for a, b in zip(polygon, [*polygon[1:], *polygon[:1]], strict=True):
            u, v = sign * a[3] - level, sign * b[3] - level
            if u >= 0.0:
                kept.append(a)
            if (u < 0.0 < v) or (v < 0.0 < u):
                kept.append(a + (b - a) * (u / (u - v)))
        polygon = kept
        if len(polygon) < 3:
            return 0.0, 0.0
    total, moment = 0.0, 0.0
    for a, b in itertools.pairwise(polygon[1:]):
        area = 0.5 * float(np.linalg.norm(np.cross(a[:3] - polygon[0][:3], b[:3] - polygon[0][:3])))
        total += area
        moment += area * float(polygon[0][3] + a[3] + b[3]) / 3.0
    return (total, moment / total) if total > 0.0 else (0.0, 0.0)
