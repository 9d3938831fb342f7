"""Furniture: closed solids, normals outwards, drawn in their own frame and put in their place."""

import math
from collections.abc import Sequence

import numpy as np

from octant.geometries._arrays import frozen_array
from octant.geometries._checks import positive_number
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.bodies import Body, placed
from octant.geometries.errors import GeometryError

# Corners of the unit box, x fastest, and its twelve triangles, counter-clockwise from outside.
_BOX_CORNERS = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
_BOX_QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))
_BOX_FACES = np.array([t for a, b, c, d in _BOX_QUADS for t in ((a, b, c), (a, c, d))])


def box(
    size_m: Sequence[float],
    *,
    material: str,
    position_m: Sequence[float] = (0.0, 0.0, 0.0),
    yaw_deg: float = 0.0,
    name: str = "box",
) -> Body:
    """Return a closed box of 12 triangles, normals outwards.

    Parameters
    ----------
    size_m : (3,) — Length in x, y and z before the turn [m].
    material : Label of the material.
    position_m : (3,) — Where the lowest corner (least x, y and z before the turn) stands [m].
    yaw_deg : Turn about the vertical through it, from +x towards +y [deg].
    name : Name of the body.
    """
    size = frozen_array(size_m, name=f"size_m of {name!r}", shape=(3,))
    for axis, length in zip("xyz", size, strict=True):
        positive_number(length, name=f"size_m of {name!r} in {axis}")
    body = Body(name=name, vertices_m=_BOX_CORNERS * size, faces=_BOX_FACES, material=material)
    return placed(body, position_m, yaw_deg)


def cabinet(
    size_m: Sequence[float] = (1.5, 0.35, 1.0),
    *,
    material: str = "metal",
    position_m: Sequence[float] = (0.0, 0.0, 0.0),
    yaw_deg: float = 0.0,
    name: str = "cabinet",
) -> Body:
    """Return a closed file cabinet: a metal box without drawers, feet and gaps.

    Thesis, section 5.4.2: "a large 1.5 x 1 x 0.35 m metal file cabinet"; that 1 m is its height is
    our reading.

    Parameters
    ----------
    size_m : (3,) — Length in x, y and z before the turn [m].
    material : Label of the material.
    position_m : (3,) — Where the lowest corner (least x, y and z before the turn) stands [m].
    yaw_deg : Turn about the vertical through it, from +x towards +y [deg].
    name : Name of the body.
    """
    return box(size_m, material=material, position_m=position_m, yaw_deg=yaw_deg, name=name)


def cylinder(
    radius_m: float,
    height_m: float,
    *,
    material: str,
    sides: int = 24,
    position_m: Sequence[float] = (0.0, 0.0, 0.0),
    yaw_deg: float = 0.0,
    name: str = "cylinder",
) -> Body:
    """Return a closed upright cylinder as a prism of 4 (sides - 1) triangles, normals outwards.

    Its sides are nearer to the axis by radius (1 - cos(pi / sides)), 0.9 % at 24 sides. Rays see
    flat panels: the power that a smooth cylinder spreads over all directions comes back in as many
    narrow, strong glints as there are sides. The mean over several glints is that of the smooth
    cylinder; the value at a place, and coherent sums with other paths, are not, however many sides
    there are. docs/evidence/curved.md says how well the mean holds.

    Parameters
    ----------
    radius_m : Radius of the circle on which the prism's edges stand [m].
    height_m : Height [m].
    material : Label of the material.
    sides : Number of flat sides, at least 3.
    position_m : (3,) — Centre of the base [m].
    yaw_deg : Turn about the axis, from +x towards +y [deg]; at zero an edge points to +x.
    name : Name of the body.
    """
    radius = positive_number(radius_m, name=f"radius_m of {name!r}")
    height = positive_number(height_m, name=f"height_m of {name!r}")
    if not isinstance(sides, int) or sides < 3:
        msg = f"sides of {name!r} is {sides!r}, but a prism needs a whole number of at least 3."
        raise GeometryError(msg)
    angle = 2.0 * math.pi * np.arange(sides) / sides
    ring = radius * np.column_stack((np.cos(angle), np.sin(angle)))
    bottom = np.column_stack((ring, np.zeros(sides)))
    top = np.column_stack((ring, np.full(sides, height)))
    i = np.arange(sides)
    j = (i + 1) % sides
    fan = np.column_stack((np.zeros(sides - 2, dtype=np.int64), i[1:-1], i[2:]))
    faces = np.concatenate(
        (
            np.column_stack((i, j, j + sides)),
            np.column_stack((i, j + sides, i + sides)),
            fan[:, ::-1],
            fan + sides,
        )
    )
    body = Body(name=name, vertices_m=np.concatenate((bottom, top)), faces=faces, material=material)
    return placed(body, position_m, yaw_deg)


def sphere(
    radius_m: float,
    *,
    material: str,
    subdivisions: int = 2,
    position_m: Sequence[float] = (0.0, 0.0, 0.0),
    yaw_deg: float = 0.0,
    name: str = "sphere",
) -> Body:
    """Return a closed sphere of 20 x 4^subdivisions triangles of nearly one size, normals outwards.

    Each is a flat panel to the rays, as in `cylinder`: right in the mean over angles only.

    Parameters
    ----------
    radius_m : Radius of the sphere that the corners lie on [m].
    material : Label of the material.
    subdivisions : How often the 20 faces of an icosahedron are cut into four, 0 to 6.
    position_m : (3,) — Centre [m].
    yaw_deg : Turn about the vertical through the centre, from +x towards +y [deg].
    name : Name of the body.
    """
    radius = positive_number(radius_m, name=f"radius_m of {name!r}")
    if not isinstance(subdivisions, int) or not 0 <= subdivisions <= 6:
        msg = (
            f"subdivisions of {name!r} is {subdivisions!r}, but 0 to 6 (a whole number) is allowed."
        )
        raise GeometryError(msg)
    vertices, faces = _icosahedron()
    for _ in range(subdivisions):
        sides = np.sort(np.stack((faces, np.roll(faces, -1, axis=1)), axis=2), axis=2)
        ends, middle = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
        ab, bc, ca = (len(vertices) + middle.reshape(-1, 3)).T
        a, b, c = faces.T
        corners = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        faces = np.concatenate([np.column_stack(triangle) for triangle in corners])
        vertices = np.concatenate((vertices, vertices[ends].sum(axis=1)))
        vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    body = Body(name=name, vertices_m=radius * vertices, faces=faces, material=material)
    return placed(body, position_m, yaw_deg)


def _icosahedron() -> tuple[FloatArray, IntArray]:
    """Return the unit icosahedron: a pole, two rings of five, a pole; counter-clockwise outside."""
    z, k = 1.0 / math.sqrt(5.0), np.arange(5)
    rings = [
        np.column_stack((np.cos(angle), np.sin(angle), np.full(5, height / 2.0))) * 2.0 * z
        for angle, height in ((0.4 * math.pi * k, 1.0), (0.4 * math.pi * (k + 0.5), -1.0))
    ]
    vertices = np.concatenate(([[0.0, 0.0, 1.0]], *rings, [[0.0, 0.0, -1.0]]))
    upper, lower = 1 + k, 6 + k
    following, below = 1 + (k + 1) % 5, 6 + (k + 1) % 5
    top, bottom = np.zeros(5, dtype=np.int64), np.full(5, 11)
    triangles = (
        (top, upper, following),
        (upper, lower, following),
        (following, lower, below),
        (bottom, below, lower),
    )
    return vertices, np.concatenate([np.column_stack(t) for t in triangles])
