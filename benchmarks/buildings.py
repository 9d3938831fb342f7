"""A furnished building of any number of triangles, the same one each time: workload W6.

Rooms of 5 x 6 m stand along corridors, with a door each; what is in them is made of simple closed
bodies whose edges are bevelled, as meshes of furniture are. Bodies touch but share no corners.
"""

import numpy as np

from octant.geometries.bodies import Body, placed
from octant.geometries.furniture import box, cylinder
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

ROOM_M = (5.0, 6.0)
CORRIDOR_M, HEIGHT_M, WALL_M = 2.4, 2.8, 0.12
DOOR_M = (0.9, 2.05)
BEVEL_M = 0.008


def bevelled_box(size_m, *, material, name, bevel_m=BEVEL_M):
    """Return a closed box of 44 triangles, edges and corners cut off, its lowest corner at 0."""
    size = np.asarray(size_m, dtype=float)
    corners, number = [], {}
    for x in (0, 1):
        for y in (0, 1):
            for z in (0, 1):
                place = np.array([x, y, z])
                for axis in range(3):  # on the face across this axis
                    inwards = bevel_m * (1 - 2 * place)
                    inwards[axis] = 0.0
                    number[x, y, z, axis] = len(corners)
                    corners.append(size * place + inwards)
    vertices = np.array(corners)
    polygons = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            ring = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                at = [0, 0, 0]
                at[axis], at[first], at[second] = side, a, b
                ring.append(number[*at, axis])
            polygons.append(ring)
        for a in (0, 1):
            for b in (0, 1):  # the edge along this axis
                ends = [[0, 0, 0], [0, 0, 0]]
                for i in (0, 1):
                    ends[i][axis], ends[i][first], ends[i][second] = i, a, b
                low, high = ends
                polygons.append(
                    [
                        number[*low, first],
                        number[*low, second],
                        number[*high, second],
                        number[*high, first],
                    ]
                )
    polygons += [[number[x, y, z, k] for k in range(3)] for x, y, z in np.ndindex(2, 2, 2)]
    faces = []
    for ring in polygons:
        a, b, c = vertices[ring[:3]]
        outwards = np.cross(b - a, c - a) @ (vertices[ring].mean(axis=0) - size / 2) > 0.0
        turned = ring if outwards else ring[::-1]
        faces += [(turned[0], turned[i], turned[i + 1]) for i in range(1, len(turned) - 1)]
    return Body(name=name, vertices_m=vertices, faces=faces, material=material)


def _table(size, name):
    length, width, height = size
    yield (
        bevelled_box((length, width, 0.03), material="wood", name=f"{name} top"),
        (
            0.0,
            0.0,
            height - 0.03,
        ),
    )
    for k, (x, y) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        leg = bevelled_box((0.05, 0.05, height - 0.03), material="metal", name=f"{name} leg {k}")
        yield leg, (0.03 + x * (length - 0.11), 0.03 + y * (width - 0.11), 0.0)


def _chair(size, name):
    yield from _table((size[0], size[1], 0.45), name)
    back = bevelled_box((0.03, size[1] - 0.04, 0.45), material="wood", name=f"{name} back")
    yield back, (0.02, 0.02, 0.45)


def _cabinet(size, name):
    length, width, height = size
    yield bevelled_box(size, material="metal", name=f"{name} body"), (0.0, 0.0, 0.0)
    for k in (0, 1):
        door = bevelled_box(
            (0.46 * length, 0.02, height - 0.1), material="metal", name=f"{name} door {k}"
        )
        yield door, ((0.02 + 0.5 * k) * length, width, 0.05)


def _couch(size, name):
    length, width, height = size
    yield from _table((length, width, 0.5 * height), name)
    seat = bevelled_box(
        (length - 0.1, width - 0.1, 0.5 * height), material="wood", name=f"{name} seat"
    )
    yield seat, (0.05, 0.05, 0.5 * height)


KINDS = (
    (_table, (0.9, 0.6, 0.74), (1.35, 0.8, 0.78)),
    (_chair, (0.4, 0.4, 0.9), (0.5, 0.5, 0.9)),
    (_cabinet, (0.8, 0.35, 0.9), (1.2, 0.5, 2.0)),
    (_couch, (1.1, 0.6, 0.6), (1.35, 0.8, 0.9)),
)


def _furnished(corner, rng, triangles, name):
    """Return things in a room until they have so many triangles, each in a place of its own."""
    things, count = [], 0
    cells = [(x, y) for x in range(3) for y in range(4)]  # of 1.6 x 1.45 m, in some order
    order = rng.permutation(len(cells))
    used = 0
    while count < triangles:
        make, low, high = KINDS[int(rng.choice(4, p=(0.25, 0.35, 0.25, 0.15)))]
        size = rng.uniform(low, high)
        cell = cells[order[used % len(cells)]]
        level = 2.2 * (used // len(cells))  # what has no floor left hangs under the ceiling
        if level > 0.0:
            make, size = _table, np.array([0.6, 0.4, 0.4])
        used += 1
        yaw = float(rng.choice((0.0, 90.0, 180.0, 270.0)) + rng.choice((0.0, rng.uniform(-9, 9))))
        half = 0.5 * np.array([size[0], size[1]])
        turn = np.deg2rad(yaw)
        cos, sin = np.cos(turn), np.sin(turn)
        centre = np.add(corner, (0.9 + 1.6 * cell[0], 0.85 + 1.45 * cell[1]))
        lowest = centre - (cos * half[0] - sin * half[1], sin * half[0] + cos * half[1])
        for body, (x, y, z) in make(size, f"{name} {used}"):
            at = (lowest[0] + cos * x - sin * y, lowest[1] + sin * x + cos * y, z + level)
            things.append(placed(body, at, yaw))
            count += len(body.faces)
    bin_ = cylinder(
        0.14, 0.3, material="metal", sides=12, position_m=(*(np.array(corner) + 0.3), 0.0),
        name=f"{name} bin",
    )  # fmt: skip
    return [*things, bin_]


def _wall(start, length, along_x, name, doors=()):
    """Return the boxes of a wall with doors: what stands between them, and above each."""
    pieces, at = [], 0.0
    for door in (*doors, None):
        end = length if door is None else door
        size = (end - at, WALL_M) if along_x else (WALL_M, end - at)
        place = (start[0] + at, start[1]) if along_x else (start[0], start[1] + at)
        pieces.append(((*size, HEIGHT_M), (*place, 0.0)))
        if door is not None:
            width, height = DOOR_M
            thin, inset = WALL_M - 0.02, 0.01  # so that it shares no edge with its neighbours
            size = (width, thin) if along_x else (thin, width)
            place = (door, inset) if along_x else (inset, door)
            place = (start[0] + place[0], start[1] + place[1])
            pieces.append(((*size, HEIGHT_M - height), (*place, height)))
            at = door + width
    return [
        box(size, material="concrete", position_m=place, name=f"{name} {k}")
        for k, (size, place) in enumerate(pieces)
    ]


def building_bodies(triangles, seed=0):
    """Return the shell of a building and all that is in it, about so many triangles."""
    rng = np.random.default_rng(seed)
    count = max(2, round(triangles / 2200))
    columns = max(1, round(np.sqrt(count * 0.8)))
    rows = -(-count // columns)
    each = triangles / (rows * columns) - 60
    width, depth = ROOM_M
    pitch_x = width + WALL_M
    floors = -(-rows // 2)  # a corridor serves a row of rooms on each side
    band = 2 * (depth + WALL_M) + CORRIDOR_M
    length = columns * pitch_x + WALL_M
    across = floors * (band + WALL_M) - (0 if rows % 2 == 0 else depth + WALL_M) + WALL_M
    things = []
    for row in range(rows):
        pair, upper = divmod(row, 2)
        base = WALL_M + pair * (band + WALL_M)
        low = base + upper * (depth + WALL_M + CORRIDOR_M + WALL_M)
        doors = [k * pitch_x + WALL_M + 0.4 + rng.uniform(0.0, 3.0) for k in range(columns)]
        wall = low - WALL_M if upper else low + depth
        things += _wall((0.0, wall), length, True, f"corridor wall {row}", doors)
        if not upper and pair:  # between two pairs of rows
            things += _wall((0.0, low - WALL_M), length, True, f"spine {row}")
        for k in range(columns):
            left = WALL_M + k * pitch_x
            if k:
                things += _wall((left - WALL_M, low), depth, False, f"wall {row} {k}")
            things += _furnished((left, low), rng, each, f"room {row} {k}")
    return box_room((length, across, HEIGHT_M), material="concrete"), things


def building(triangles, seed=0):
    """Return the scene of a building of about so many triangles."""
    shell, things = building_bodies(triangles, seed)
    return build_scene(shell, objects=things)


def building_places(scene, count, seed=1, *, height_m=(0.3, 1.6), near_m=None, within_m=np.inf):
    """Return so many places [m] in the building's air, spread evenly, near one if that is given."""
    rng = np.random.default_rng(seed)
    found = np.zeros((0, 3))
    low, high = scene.bounds_m
    while len(found) < count:
        more = rng.uniform((*low[:2], height_m[0]), (*high[:2], height_m[1]), (4 * count, 3))
        if near_m is not None:
            more = more[np.linalg.norm(more[:, :2] - near_m[:2], axis=1) <= within_m]
        found = np.concatenate((found, more[~scene.inside_solid(more)]))
    return found[:count]


def dense_places(scene):
    """Return the source of workload W6, under the ceiling, and 400 receivers around it [m]."""
    middle = scene.bounds_m.mean(axis=0)
    source = building_places(scene, 1, height_m=(2.5, 2.6), near_m=middle, within_m=8.0)[0]
    return source, building_places(scene, 400, seed=2, near_m=source, within_m=12.0)
