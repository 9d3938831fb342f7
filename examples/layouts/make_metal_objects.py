"""Write the metal objects of the layouts: three of arbitrary shape, and a shelf.

The thesis (5.4.3) shows three metal objects near the way without saying what they are. These
are a console with a sloping top, a pillar that narrows and twists, and a lump with no two faces
alike. The shelf is a rack of sheets: a back, two sides and four boards, open in front.

    python examples/layouts/make_metal_objects.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.bodies import Body
from octant.geometries.mesh_files import save_bodies

Floats = npt.NDArray[np.float64]

CONSOLE_OUTLINE_M = ((-0.25, 0.0), (0.25, 0.0), (0.25, 0.75), (-0.05, 1.05), (-0.25, 1.05))
"""Side view of the console: y and z of its corners, counter-clockwise."""
CONSOLE_WIDTH_M = 0.9

LUMP_CORNERS_M = (
    (-0.32, -0.20, 0.0),
    (0.28, -0.27, 0.0),
    (0.34, 0.18, 0.0),
    (-0.12, 0.33, 0.0),
    (-0.38, 0.05, 0.42),
    (0.10, -0.34, 0.55),
    (0.30, 0.12, 0.72),
    (-0.05, 0.24, 0.86),
    (-0.16, -0.14, 0.95),
)
"""Corners of the lump, all on its convex hull."""

SHELF_SIZE_M = (2.0, 0.5, 2.0)
SHELF_BOARDS_M = (0.15, 0.75, 1.35, 1.95)


def solid(name: str, corners_m: npt.ArrayLike) -> Body:
    """Return the convex body with the given corners [m], of metal."""
    from scipy.spatial import ConvexHull

    corners = np.asarray(corners_m, dtype=np.float64)
    hull = ConvexHull(corners)
    faces = hull.simplices.copy()
    normals = np.cross(
        corners[faces[:, 1]] - corners[faces[:, 0]], corners[faces[:, 2]] - corners[faces[:, 0]]
    )
    inward = (normals * hull.equations[:, :3]).sum(axis=1) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return Body(name=name, vertices_m=corners, faces=faces.astype(np.int64), material="metal")


def console() -> Body:
    """Return a console with a sloping top, 0.9 m wide and 1.05 m high."""
    half = 0.5 * CONSOLE_WIDTH_M
    return solid("console", [(x, y, z) for x in (-half, half) for y, z in CONSOLE_OUTLINE_M])


def pillar() -> Body:
    """Return a six-sided pillar, 1.2 m high, that narrows from 0.30 to 0.18 m and turns by 20°."""
    corners = []
    for height_m, radius_m, turn_deg in ((0.0, 0.30, 0.0), (1.2, 0.18, 20.0)):
        angle = np.radians(turn_deg + 60.0 * np.arange(6))
        ring = radius_m * np.column_stack((np.cos(angle), np.sin(angle)))
        corners += [(x, y, height_m) for x, y in ring]
    return solid("pillar", corners)


def lump() -> Body:
    """Return a body without parallel faces, 0.95 m high."""
    return solid("lump", LUMP_CORNERS_M)


def shelf() -> Body:
    """Return a rack of sheets, 2 m long, 0.5 m deep and 2 m high, open towards -y.

    Its boards end 1 cm before sides and back, as sheets on brackets do.
    """
    length, depth, height = SHELF_SIZE_M
    gap = 0.01
    quads = [
        [(0.0, depth, 0.0), (length, depth, 0.0), (length, depth, height), (0.0, depth, height)],
        *(
            [(x, 0.0, 0.0), (x, depth - gap, 0.0), (x, depth - gap, height), (x, 0.0, height)]
            for x in (gap, length - gap)
        ),
        *(
            [
                (2.0 * gap, 0.0, z),
                (length - 2.0 * gap, 0.0, z),
                (length - 2.0 * gap, depth - gap, z),
                (2.0 * gap, depth - gap, z),
            ]
            for z in SHELF_BOARDS_M
        ),
    ]
    vertices: Floats = np.array(quads).reshape(-1, 3)
    first = 4 * np.arange(len(quads))
    faces = np.concatenate([np.column_stack((first, first + i, first + i + 1)) for i in (1, 2)])
    return Body(name="shelf", vertices_m=vertices, faces=faces, material="metal")


def main() -> None:
    """Write one GLB file a body into the folder given, or beside this script."""
    given = sys.argv[1:]
    folder = Path(given[0]) if given else Path(__file__).parent
    for body in (console(), pillar(), lump(), shelf()):
        path = folder / f"{body.name}.glb"
        save_bodies((body,), path)
        print(f"{path}: {len(body.faces)} triangles")


if __name__ == "__main__":
    main()
