"""Small flat panels of metal sheets, as places where currents are known."""

from dataclasses import dataclass

import numpy as np

from octant.geometries._plane_geometry import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panels:
    """Panels: (p, 3) centres [m], (p, 3) unit normals [-], (p,) areas [m^2]."""

    centre_m: FloatArray
    normal: FloatArray
    area_m2: FloatArray


def cut_into_panels(
    triangles_m: FloatArray, wire_m: FloatArray, *, coarse_m: float, fine_m: float
) -> Panels:
    """Return panels of (t, 3, 3) triangles, no side longer than ``coarse_m``.

    Nor longer than the distance of the panel's centre from the upright wire (2, 3), foot and tip,
    down to ``fine_m``.
    """
    kept = []
    rest = triangles_m
    while len(rest):
        sides = np.linalg.norm(np.roll(rest, -1, axis=1) - rest, axis=2)
        centre = rest.mean(axis=1)
        height = np.clip(centre[:, 2], wire_m[0, 2], wire_m[1, 2])
        offset = centre - np.column_stack((np.tile(wire_m[0, :2], (len(rest), 1)), height))
        limit = np.clip(np.linalg.norm(offset, axis=1), fine_m, coarse_m)
        small = sides.max(axis=1) <= limit
        kept.append(rest[small])
        rest = _halved(rest[~small], np.argmax(sides[~small], axis=1))
    corners = np.concatenate(kept)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(across, axis=1)
    return Panels(
        centre_m=corners.mean(axis=1), normal=across / twice[:, None], area_m2=0.5 * twice
    )


def _halved(triangles_m: FloatArray, side: np.ndarray) -> FloatArray:
    """Return each triangle's two halves, its given side cut in the middle."""
    row = np.arange(len(triangles_m))
    start, end = triangles_m[row, side], triangles_m[row, (side + 1) % 3]
    top, middle = triangles_m[row, (side + 2) % 3], 0.5 * (start + end)
    return np.concatenate(
        (np.stack((start, middle, top), axis=1), np.stack((middle, end, top), axis=1))
    )
