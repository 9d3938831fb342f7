"""Triangles of the reader's sheets, conforming where sheets meet.

A rim is (k, 2): its corners, counter-clockwise around the centre [m]. Azimuths run from +x towards
+y [rad], distances from the axis [m]; arrays hold one value for each antenna or plate.
"""

import math
from collections.abc import Sequence

import numpy as np

from octant.geometries._plane_geometry import FloatArray
from octant.geometries._polygons import triangulate_polygon
from octant.geometries.tolerances import LENGTHS


def reach_to_rim_m(azimuths_rad: FloatArray, rim_m: FloatArray) -> FloatArray:
    """Return the (a,) distances from the centre to a convex rim in each direction [m]."""
    normal = np.roll(rim_m, -1, axis=0) - rim_m
    normal = np.column_stack((normal[:, 1], -normal[:, 0]))  # outwards: the rim runs anticlockwise
    offset = (normal * rim_m).sum(axis=1)
    direction = np.column_stack((np.cos(azimuths_rad), np.sin(azimuths_rad)))
    along = direction @ normal.T
    distance = np.full(along.shape, np.inf)
    np.divide(offset, along, out=distance, where=along > 0.0)
    nearest: FloatArray = distance.min(axis=1)
    return nearest


def _polar(radius_m: float, azimuth_rad: float) -> FloatArray:
    """Return the point of the ground plane at a radius and azimuth [m]."""
    return radius_m * np.array((math.cos(azimuth_rad), math.sin(azimuth_rad)))


def ground_triangles(
    rim_m: FloatArray,
    antenna_radii_m: FloatArray,
    elements_rad: FloatArray,
    plate_reaches_m: FloatArray,
    plates_rad: FloatArray,
) -> list[FloatArray]:
    """Return the ground plane's (3, 3) triangles [m], normal up, cut at plates and antennas."""
    spokes = list(zip(elements_rad.tolist(), antenna_radii_m.tolist(), strict=True))
    spokes = sorted(spokes + list(zip(plates_rad.tolist(), plate_reaches_m.tolist(), strict=True)))
    angles = np.array([a for a, _ in spokes])
    ends = reach_to_rim_m(angles, rim_m)
    close = LENGTHS.same_share * float(ends.max())
    places: list[list[FloatArray]] = []  # of each spoke, from the axis (left out) to the rim
    for (azimuth, radius), end in zip(spokes, ends, strict=True):
        outer = _polar(float(end), azimuth)
        near = np.flatnonzero(np.abs(rim_m - outer).max(axis=1) <= close)
        outer = rim_m[near[0]] if near.size else outer
        on_rim = radius >= end - close
        places.append([outer] if on_rim else [_polar(radius, azimuth), outer])
    rim_angles = np.mod(np.arctan2(rim_m[:, 1], rim_m[:, 0]), 2.0 * math.pi)
    triangles: list[FloatArray] = []
    for i, (azimuth, _) in enumerate(spokes):
        following = (i + 1) % len(spokes)
        width = (angles[following] - azimuth) % (2.0 * math.pi)
        ahead = np.mod(rim_angles - azimuth, 2.0 * math.pi)
        between = np.flatnonzero(
            (ahead > LENGTHS.same_share) & (ahead < width - LENGTHS.same_share)
        )
        between = between[np.argsort(ahead[between])]
        corners = [np.zeros(2), *places[i], *rim_m[between], *places[following][::-1]]
        sector = np.array(corners)
        flat = sector[triangulate_polygon(sector, name="the ground plane")]
        triangles += list(np.concatenate((flat, np.zeros((*flat.shape[:2], 1))), axis=2))
    return triangles


def plate_triangles(
    reaches_m: FloatArray,
    plates_rad: FloatArray,
    *,
    heights_m: Sequence[FloatArray],
) -> list[FloatArray]:
    """Return the plates' (3, 3) triangles, each plate from the axis out [m].

    ``heights_m`` holds each plate's heights at even distances from the axis to its outer end. The
    triangles fan out from the axis' foot, which must see all of the upper edge.
    """
    triangles: list[FloatArray] = []
    for azimuth, reach_m, heights in zip(plates_rad, reaches_m, heights_m, strict=True):
        axis = (0.0, 0.0, 0.0)
        away = np.linspace(0.0, float(reach_m), len(heights))
        tops = [(*_polar(r, float(azimuth)), h) for r, h in zip(away, heights, strict=True)]
        if heights[-1] > 0.0:
            triangles.append(np.array((axis, (*tops[-1][:2], 0.0), tops[-1])))
        inner = [(tops[j], tops[j - 1]) for j in range(len(tops) - 1, 1, -1)]
        triangles += [np.array((axis, out, within)) for out, within in inner]
        if heights[0] > 0.0:
            triangles.append(np.array((axis, tops[1], tops[0])))
    return triangles
