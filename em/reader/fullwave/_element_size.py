"""Wanted edge lengths: a fraction of the wavelength, finer near the antennas' strips and planes."""

from dataclasses import dataclass

import numpy as np

from octant.geometries._plane_geometry import FloatArray

GROWTH = 0.7
"""Wanted edge length over the distance from the nearest strip [-]; at most 1, or the mesh under a
dipole's foot would be coarser than the gap."""

PLANE_GROWTH = 1.6
"""Wanted edge length over the distance from a monopole's plane to the ground below [-]: charges
that face each other are smooth there, so this is coarser than at a strip."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElementSize:
    """Wanted edge length as a function of place; arrays of strips and planes may be empty.

    ``strips_m`` (s, 2, 3) holds the ends of the strips' middle lines, ``planes_m`` (q, 3) the
    centres of the monopoles' own planes, all at one height above the ground plane.
    """

    coarse_m: float
    finest_m: float
    strips_m: FloatArray
    planes_m: FloatArray
    plane_side_m: float = 0.0

    def at(self, points_m: FloatArray) -> FloatArray:
        """Return the wanted edge length [m] at (n, 3) points [m]."""
        wanted = np.full(len(points_m), self.coarse_m)
        if len(self.strips_m):
            start, along = self.strips_m[:, 0], self.strips_m[:, 1] - self.strips_m[:, 0]
            from_start = points_m[:, None] - start
            t = (from_start * along).sum(axis=2) / (along**2).sum(axis=1)
            away = from_start - np.clip(t, 0.0, 1.0)[:, :, None] * along
            nearest = np.sqrt((away**2).sum(axis=2).min(axis=1))
            np.minimum(wanted, GROWTH * nearest, out=wanted)
        for centre in self.planes_m:
            away = points_m - centre
            radial = np.array((centre[0], centre[1], 0.0)) / np.hypot(centre[0], centre[1])
            half = 0.5 * self.plane_side_m
            u = np.abs(away @ radial) - half
            v = np.abs(away @ np.array((-radial[1], radial[0], 0.0))) - half
            beside = np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0))
            above = np.maximum(points_m[:, 2] - centre[2], 0.0)
            np.minimum(
                wanted, PLANE_GROWTH * np.hypot(np.hypot(beside, above), centre[2]), out=wanted
            )
        result: FloatArray = np.maximum(wanted, self.finest_m)
        return result

    def key(self, origin_m: FloatArray, axes: FloatArray) -> tuple[tuple[float, ...], ...]:
        """Return the strips and planes as seen from a frame, sorted, to tell congruent places."""
        local = [tuple(np.round((s - origin_m) @ axes.T, 10).ravel() + 0.0) for s in self.strips_m]
        local += [tuple(np.round((p - origin_m) @ axes.T, 10) + 0.0) for p in self.planes_m]
        return tuple(sorted(local))
