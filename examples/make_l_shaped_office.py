"""Write l_shaped_office.glb: a furnished room as a modelling program would hand it over.

The room is L-shaped, 7 x 6 m and 3 m high, with its lowest corner at (-1, -1, 0), so that there is
floor on all sides of the thesis' start at (0, 0), and its four tags at 3 m hang on the ceiling. It
is deliberately not a clean mesh: a doorway in the east wall leads nowhere, one ceiling panel is
missing, a partition ends in free edges, and every surface is cut into triangles of its own,
unequal sizes, which do not meet corner to corner.

    python examples/make_l_shaped_office.py [FILE.glb]
"""

import itertools
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.bodies import Body
from octant.geometries.furniture import box, cabinet
from octant.geometries.mesh_files import save_bodies

Floats = npt.NDArray[np.float64]
Area = tuple[float, float, float, float]  # least and greatest u, least and greatest v [m]

HEIGHT_M = 3.0
NOTCH: Area = (-1.0, 0.5, 2.5, 5.0)  # what the L lacks of the rectangle, in x and y
MISSING_CEILING_PANEL: Area = (-0.6, 0.0, 0.6, 1.2)
EAST_DOORWAY: Area = (0.5, 1.4, 0.0, 2.1)  # in y and z, at x = 6
PARTITION_DOORWAY: Area = (3.3, 4.2, 0.0, 2.1)  # in y and z, at x = 5


def uneven_lines(
    start_m: float, stop_m: float, count: int, *, growth: float, through_m: Sequence[float] = ()
) -> Floats:
    """Return grid lines whose distances grow along the way, through given places [m]."""
    lines = start_m + (stop_m - start_m) * (np.arange(count + 1) / count) ** growth
    return np.unique(np.round(np.concatenate((lines, through_m)), 3))


def panel(
    corner_m: Sequence[float],
    u_axis: Sequence[int],
    v_axis: Sequence[int],
    u_lines_m: Floats,
    v_lines_m: Floats,
    *,
    without: Sequence[Area] = (),
) -> Floats:
    """Return the triangles of a grid in a plane, normal along u x v, less the given areas [m]."""
    triangles = []
    u_unit, v_unit = np.array(u_axis, dtype=float), np.array(v_axis, dtype=float)
    for i, (u0, u1) in enumerate(itertools.pairwise(u_lines_m)):
        for j, (v0, v1) in enumerate(itertools.pairwise(v_lines_m)):
            u, v = 0.5 * (u0 + u1), 0.5 * (v0 + v1)
            if any(a < u < b and c < v < d for a, b, c, d in without):
                continue
            ring = np.array([(u0, v0), (u1, v0), (u1, v1), (u0, v1)])
            quad = corner_m + ring[:, :1] * u_unit + ring[:, 1:] * v_unit
            turn = (i + j) % 2  # neighbours are cut along different diagonals
            order = ((0, 1, 2), (0, 2, 3)) if turn else ((0, 1, 3), (1, 2, 3))
            triangles += [quad[list(t)] for t in order]
    return np.array(triangles)


def body(name: str, material: str, triangles_m: Floats) -> Body:
    """Return triangles as a body, every corner stored once."""
    vertices, faces = np.unique(triangles_m.reshape(-1, 3), axis=0, return_inverse=True)
    return Body(name=name, vertices_m=vertices, faces=faces.reshape(-1, 3), material=material)


def shell() -> tuple[Body, ...]:
    """Return floor, ceiling and outer walls; normals point into the room."""
    x, y, z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    floor = panel(
        (0, 0, 0),
        x,
        y,
        uneven_lines(-1, 6, 11, growth=1.25, through_m=(0.5,)),
        uneven_lines(-1, 5, 7, growth=0.8, through_m=(2.5,)),
        without=(NOTCH,),
    )
    ceiling = panel(
        (0, 0, HEIGHT_M),
        y,
        x,
        uneven_lines(-1, 5, 10, growth=1.0, through_m=(0.6, 1.2, 2.5)),
        uneven_lines(-1, 6, 6, growth=1.0, through_m=(-0.6, 0.0, 0.5)),
        without=[(a[2], a[3], a[0], a[1]) for a in (NOTCH, MISSING_CEILING_PANEL)],
    )
    # Each wall: a corner, the grid's axes with u x v into the room, and the lines along both.
    south = panel(
        (0, -1, 0), z, x, uneven_lines(0, 3, 2, growth=1.5), uneven_lines(-1, 6, 9, growth=1.4)
    )
    east = panel(
        (6, 0, 0),
        z,
        y,
        uneven_lines(0, 3, 5, growth=1.0, through_m=(2.1,)),
        uneven_lines(-1, 5, 5, growth=0.7, through_m=(0.5, 1.4)),
        without=[(EAST_DOORWAY[2], EAST_DOORWAY[3], EAST_DOORWAY[0], EAST_DOORWAY[1])],
    )
    north = panel(
        (0, 5, 0), x, z, uneven_lines(0.5, 6, 4, growth=1.0), uneven_lines(0, 3, 7, growth=1.1)
    )
    notch_east = panel(
        (0.5, 0, 0), y, z, uneven_lines(2.5, 5, 3, growth=1.3), uneven_lines(0, 3, 3, growth=1.0)
    )
    notch_north = panel(
        (0, 2.5, 0), x, z, uneven_lines(-1, 0.5, 2, growth=1.0), uneven_lines(0, 3, 1, growth=1.0)
    )
    west = panel(
        (-1, 0, 0), y, z, uneven_lines(-1, 2.5, 6, growth=1.2), uneven_lines(0, 3, 4, growth=0.9)
    )
    walls = np.concatenate((south, east, north, notch_east, notch_north, west))
    return (
        body("floor", "concrete", floor),
        body("ceiling", "plasterboard", ceiling),
        body("outer_walls", "brick", walls),
    )


def fittings() -> tuple[Body, ...]:
    """Return what stands in the room: partition, open door leaf, cabinet and table."""
    y, z = (0, 1, 0), (0, 0, 1)
    partition = panel(
        (5, 0, 0),
        y,
        z,
        uneven_lines(2.5, 5, 6, growth=1.2, through_m=PARTITION_DOORWAY[:2]),
        uneven_lines(0, 3, 4, growth=1.0, through_m=(2.1,)),
        without=(PARTITION_DOORWAY,),
    )
    leaf = panel(
        (0, 0.5, 0), (1, 0, 0), z, np.array((5.1, 6.0)), uneven_lines(0.01, 2.06, 2, growth=1.0)
    )
    top = box((1.4, 0.7, 0.03), position_m=(3.2, -0.85, 0.71), material="wood")
    legs = [
        box((0.06, 0.06, 0.71), position_m=(px, py, 0.0), material="wood")
        for px in (3.25, 4.49)
        for py in (-0.8, -0.26)
    ]
    table = np.concatenate([part.triangles_m for part in (top, *legs)])
    return (
        body("partition", "plasterboard", partition),
        body("door_leaf", "wood", leaf),
        cabinet(position_m=(0.9, 1.8, 0.0), material="metal"),
        body("table", "wood", table),
    )


def office() -> tuple[Body, ...]:
    """Return every body of the office [m], z up."""
    return (*shell(), *fittings())


def main() -> None:
    """Write the file named on the command line, or l_shaped_office.glb beside this script."""
    given = sys.argv[1:]
    path = Path(given[0]) if given else Path(__file__).with_name("l_shaped_office.glb")
    bodies = office()
    save_bodies(bodies, path)
    listed = ", ".join(f"{b.name} ({len(b.faces)})" for b in bodies)
    print(f"{path}: {path.stat().st_size} bytes; bodies (triangles): {listed}")


if __name__ == "__main__":
    main()
