"""Rooms and objects drawn at random, the same ones badly meshed, and awkward places for antennas.

Sizes and places are multiples of a quarter of a metre, so that faces touch, coincide, lie in one
plane and cut through one another far more often than by chance.
"""

from dataclasses import replace

import numpy as np

from octant.geometries.bodies import Body
from octant.geometries.furniture import box, cylinder
from octant.geometries.rooms import box_room

STEP_M = 0.25
ROOM_M = (4.0, 3.0, 2.5)
MATERIALS = ("concrete", "metal", "pec", "pane")


def sheet(corners_m, material, name="sheet"):
    """A strip of quadrangles over the (n, 2, 3) pairs of corners."""
    vertices = np.asarray(corners_m, float).reshape(-1, 3)
    faces = [
        t for k in range(0, len(vertices) - 2, 2) for t in ((k, k + 1, k + 3), (k, k + 3, k + 2))
    ]
    return Body(name=name, vertices_m=vertices, faces=np.array(faces), material=material)


def snapped(rng, low, high):
    """A point of the coarse grid between two corners."""
    return np.round(rng.uniform(low, high) / STEP_M) * STEP_M


def draw_object(rng):
    """One object: a box, a plate, a folded sheet, a flat box, a cylinder; perhaps turned."""
    material = str(rng.choice(MATERIALS))
    place = snapped(rng, np.full(3, -0.5), np.array(ROOM_M))
    size = np.maximum(snapped(rng, np.full(3, 0.2), np.array([1.5, 1.5, 1.5])), STEP_M)
    yaw = float(rng.choice([0.0, 0.0, 90.0, 37.0]))
    kind = rng.integers(6)
    if kind < 2:
        return box(size, position_m=place, yaw_deg=yaw, material=material)
    if kind == 2:
        flat = box(size, position_m=place, yaw_deg=yaw, material=material)
        vertices = flat.vertices_m.copy()
        axis = rng.integers(3)
        vertices[:, axis] = place[axis]
        return replace(flat, vertices_m=vertices)
    if kind == 3:
        return cylinder(
            0.5 * size[0],
            size[2],
            sides=int(rng.integers(3, 7)),
            position_m=place,
            yaw_deg=yaw,
            material=material,
        )
    side, up = np.array([size[0], 0.0, 0.0]), np.array([0.0, 0.0, size[2]])
    if kind == 4:
        return sheet([[place, place + up], [place + side, place + side + up]], material)
    bend = np.array([0.0, size[1], float(rng.choice([0.0, STEP_M]))])
    rows = [place, place + side, place + side + bend]
    return sheet([[row, row + up] for row in rows], material)


def draw_scene(rng):
    """Bodies of a room (closed, open, or none) and of its objects."""
    room = box_room(ROOM_M, material="concrete")
    kind = rng.integers(6)
    if kind == 0:
        room = ()
    elif kind == 1:
        gone = rng.integers(len(room))
        room = tuple(body for k, body in enumerate(room) if k != gone or len(room) == 1)
    count = int(rng.integers(0 if room else 1, 4))
    return room, tuple(draw_object(rng) for _ in range(count))


def duplicated(rng, body):
    again = body.faces[rng.integers(len(body.faces), size=3)]
    again = np.stack([np.roll(face, rng.integers(3)) for face in again])
    return replace(body, faces=np.concatenate((body.faces, again)))


def turned(rng, body):
    """Some triangles wound the other way, or all."""
    flips = rng.random(len(body.faces)) < rng.choice([0.5, 1.0])
    faces = np.where(flips[:, None], body.faces[:, ::-1], body.faces)
    return replace(body, faces=faces)


def with_slivers(rng, body):
    """Triangles without an area: a corner twice, a needle along an edge, a point on an edge."""
    a, b, _ = body.faces[rng.integers(len(body.faces))]
    middle = body.vertices_m[a] + rng.uniform() * (body.vertices_m[b] - body.vertices_m[a])
    n = len(body.vertices_m)
    new = [[a, a, b], [a, b, n], [n, n, n]]
    return replace(
        body,
        vertices_m=np.concatenate((body.vertices_m, middle[None])),
        faces=np.concatenate((body.faces, new)),
    )


def with_unused_vertices(rng, body):
    stray = rng.normal(size=(2, 3)) * 10.0 ** rng.uniform(0, 7)
    return replace(body, vertices_m=np.concatenate((body.vertices_m, stray)))


def unwelded(_rng, body):
    return replace(
        body,
        vertices_m=body.triangles_m.reshape(-1, 3),
        faces=np.arange(3 * len(body.faces)).reshape(-1, 3),
    )


def unevenly_cut(rng, body):
    """Some triangles cut in two across a side, and not their neighbours: T-junctions."""
    vertices, faces = list(body.vertices_m), []
    for face in body.faces:
        if rng.random() < 0.5:
            a, b, c = np.roll(face, rng.integers(3))
            share = rng.choice([0.5, rng.uniform(0.1, 0.9)])
            vertices.append(body.vertices_m[a] * (1.0 - share) + body.vertices_m[b] * share)
            m = len(vertices) - 1
            faces += [(a, m, c), (m, b, c)]
        else:
            faces.append(tuple(face))
    return replace(body, vertices_m=np.array(vertices), faces=np.array(faces))


def shuffled(rng, body):
    return replace(body, faces=body.faces[rng.permutation(len(body.faces))])


def rounded(_rng, body):
    """Stored in float32, as mesh files are."""
    return replace(body, vertices_m=body.vertices_m.astype(np.float32).astype(np.float64))


EQUIVALENT = (
    duplicated,
    turned,
    with_slivers,
    with_unused_vertices,
    unwelded,
    unevenly_cut,
    shuffled,
)
"""What a modelling program may do to a mesh without changing the surface that it stands for."""


def badly_meshed(rng, bodies):
    """The same surfaces, each body spoilt in one to three of the ways of ``EQUIVALENT``."""
    spoilt = []
    for body in bodies:
        bad = body
        for number in rng.choice(len(EQUIVALENT), size=rng.integers(1, 4), replace=False):
            bad = EQUIVALENT[number](rng, bad)
        spoilt.append(bad)
    return tuple(spoilt)


def draw_place(rng, bodies):
    """A place of an antenna: anywhere, on a wall, on an edge, on its extension, at a corner."""
    kind = rng.integers(6)
    anywhere = rng.uniform(np.full(3, 0.05), np.array(ROOM_M) - 0.05)
    if kind == 0 or not bodies:
        return anywhere
    if kind == 1:
        return snapped(rng, np.zeros(3), np.array(ROOM_M))
    triangles = bodies[rng.integers(len(bodies))].triangles_m
    a, b, c = triangles[rng.integers(len(triangles))]
    if kind == 2:
        u, v = np.sort(rng.choice([0.25, 0.5, 0.75, rng.random()], size=2))
        return u * a + (v - u) * b + (1.0 - v) * c
    if kind == 3:
        return a + rng.choice([0.0, 0.5, 1.0, 1.5, -0.25, rng.random()]) * (b - a)
    if kind == 4:
        return anywhere + np.eye(3)[rng.integers(3)] * rng.choice([-30.0, 30.0])
    return anywhere
