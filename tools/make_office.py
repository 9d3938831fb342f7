"""Write the mesh of the built-in office: a room as it would come from a modelling program.

6 x 5 x 2.7 m with its lowest corner at (0, 0, 0): a window in the north wall, a door in the south
wall, two desks under the window, one at the west wall, a metal cabinet at the east wall. Walls,
window, door and desks are sheets, whose thickness stands in the study.

    python tools/make_office.py [FILE.glb]
"""

import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.bodies import Body
from octant.geometries.furniture import cabinet
from octant.geometries.mesh_files import save_bodies
from octant.geometries.rooms import Doorway, box_room

Floats = npt.NDArray[np.float64]

SIZE_M = (6.0, 5.0, 2.7)
WINDOW_M = (1.5, 4.5, 0.9, 2.3)  # least and greatest x, least and greatest z, in the north wall
DOOR = Doorway(wall=0, offset_m=4.7, width_m=0.9, height_m=2.1)
DESKS_M = ((1.2, 4.15, 1.6, 0.75), (3.2, 4.15, 1.6, 0.75), (0.1, 1.7, 0.75, 1.6))  # x, y, sizes
DESK_HEIGHT_M = 0.74
TARGET = Path(__file__).parents[1] / "reader_design" / "study_file" / "office.glb"


def rectangle(corner_m: tuple[float, ...], along: int, up: int, *sizes_m: float) -> Floats:
    """Return the two triangles of a rectangle along two axes [m]."""
    corners = np.tile(np.array(corner_m, dtype=float), (4, 1))
    corners[1:3, along] += sizes_m[0]
    corners[2:, up] += sizes_m[1]
    return corners[[[0, 1, 2], [0, 2, 3]]]


def sheets(name: str, material: str, *parts: Floats) -> Body:
    """Return triangles as a body, every corner stored once."""
    corners = np.concatenate(parts).reshape(-1, 3)
    vertices, faces = np.unique(corners, axis=0, return_inverse=True)
    return Body(name=name, vertices_m=vertices, faces=faces.reshape(-1, 3), material=material)


def outer_wall() -> Floats:
    """Return the north wall around its window [m]."""
    x0, x1, z0, z1 = WINDOW_M
    width, y, height = SIZE_M
    return np.concatenate(
        [
            rectangle((0.0, y, 0.0), 0, 2, x0, height),
            rectangle((x1, y, 0.0), 0, 2, width - x1, height),
            rectangle((x0, y, 0.0), 0, 2, x1 - x0, z0),
            rectangle((x0, y, z1), 0, 2, x1 - x0, height - z1),
        ]
    )


def desk(x: float, y: float, *sizes_m: float) -> Floats:
    """Return a table top and two side panels [m]."""
    along, across = (0, 1) if sizes_m[0] > sizes_m[1] else (1, 0)
    far = [x, y, 0.0]
    far[along] += sizes_m[along]
    return np.concatenate(
        [
            rectangle((x, y, DESK_HEIGHT_M), 0, 1, *sizes_m),
            rectangle((x, y, 0.0), across, 2, sizes_m[across], DESK_HEIGHT_M),
            rectangle(tuple(far), across, 2, sizes_m[across], DESK_HEIGHT_M),
        ]
    )


def office() -> tuple[Body, ...]:
    """Return every body of the office [m], z up."""
    shell = {
        body.name: body
        for body in box_room(
            SIZE_M,
            materials={"walls": "plasterboard", "floor": "concrete", "ceiling": "concrete"},
            doorways=[DOOR],
        )
    }
    walls = shell["walls"].vertices_m[shell["walls"].faces]
    inner = walls[~(np.abs(walls[:, :, 1] - SIZE_M[1]) < 1e-9).all(axis=1)]
    x0, x1, z0, z1 = WINDOW_M
    return (
        shell["floor"],
        shell["ceiling"],
        sheets("inner_walls", "plasterboard", inner),
        sheets("outer_wall", "concrete", outer_wall()),
        sheets("window", "glass", rectangle((x0, SIZE_M[1], z0), 0, 2, x1 - x0, z1 - z0)),
        sheets(
            "door",
            "wood",
            rectangle((DOOR.offset_m, 0.0, 0.0), 0, 2, DOOR.width_m, DOOR.height_m),
        ),
        sheets("desks", "wood", *(desk(*at) for at in DESKS_M)),
        cabinet((0.45, 1.2, 1.2), position_m=(5.5, 2.2, 0.0), material="metal"),
    )


def main() -> None:
    """Write the file named on the command line, or the mesh of the package."""
    path = Path(sys.argv[1]) if sys.argv[1:] else TARGET
    bodies = office()
    save_bodies(bodies, path)
    listed = ", ".join(f"{b.name} ({len(b.faces)})" for b in bodies)
    print(f"{path}: {path.stat().st_size} bytes; bodies (triangles): {listed}")


if __name__ == "__main__":
    main()
