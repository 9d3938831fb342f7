"""Rotations about z that map a triangle mesh onto itself."""

import math

import numpy as np

from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.tolerances import LENGTHS


def turns_of(antennas: int) -> tuple[int, ...]:
    """Return the numbers of sectors that ports may map to ports in, greatest first, without 1."""
    return tuple(d for d in range(antennas, 1, -1) if antennas % d == 0)


def turned(points_m: FloatArray, angle_rad: float) -> FloatArray:
    """Return points (n, 3) turned about z [m]."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    there: FloatArray = points_m @ np.array(((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)))
    return there


def turned_vertices(vertices_m: FloatArray, sectors: int) -> IntArray | None:
    """Return the vertex that each goes to in a turn by 2 pi / sectors, or None."""
    from scipy.spatial import cKDTree

    there = turned(vertices_m, 2.0 * math.pi / sectors)
    distance, index = cKDTree(vertices_m).query(there)
    span = float(np.ptp(vertices_m, axis=0).max())
    if distance.max() > LENGTHS.turned_share * span or len(np.unique(index)) < len(index):
        return None
    return np.asarray(index, dtype=np.int64)


def sector_faces(faces: IntArray, image: IntArray, sectors: int) -> IntArray | None:
    """Return (sectors, f, 3) triangles, each sector the image of the one before, or None.

    Also None when a triangle, or an edge off the axis, is mapped onto itself by part of a turn, or
    when the turned triangles are not the same set.
    """
    number = {tuple(sorted(face)): i for i, face in enumerate(faces.tolist())}
    onward = np.empty(len(faces), dtype=np.int64)
    for i, face in enumerate(image[faces].tolist()):
        target = number.get(tuple(sorted(face)))
        if target is None:
            return None
        onward[i] = target
    taken = np.zeros(len(faces), dtype=bool)
    first = []
    for i in range(len(faces)):
        if taken[i]:
            continue
        orbit = [i]
        while (following := int(onward[orbit[-1]])) != i:
            orbit.append(following)
        if len(orbit) != sectors:
            return None
        taken[orbit] = True
        first.append(i)
    layers = [faces[first]]
    for _ in range(sectors - 1):
        layers.append(image[layers[-1]])
    return np.stack(layers)
