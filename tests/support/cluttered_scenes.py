"""Rooms full of things, and whether a search for images holds a sequence of planes."""

from dataclasses import replace

from rooms import l_shaped_room

from octant.geometries.bodies import Body
from octant.geometries.furniture import box, cylinder
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene


def cluttered_scene(rng):
    """A closed, open or missing room with solids that may cross or be inside out, and sheets."""
    room = (
        box_room((4.0, 3.0, 2.5)),
        l_shaped_room((4.0, 3.0, 2.5), (1.7, 1.2)),
        tuple(b for b in box_room((4.0, 3.0, 2.5)) if b.name != "ceiling"),
        (),
    )[rng.integers(4)]
    things = [
        cylinder(
            float(rng.uniform(0.2, 0.5)),
            float(rng.uniform(0.4, 1.5)),
            material="metal",
            sides=5,
            position_m=tuple(rng.uniform((0.5, 0.5, 0.0), (2.5, 1.5, 0.6))),
            name="column",
        )
    ]
    for k in range(int(rng.integers(0, 2))):
        solid = box(
            tuple(rng.uniform(0.3, 1.2, 3)),
            material="metal",
            position_m=(*rng.uniform(0.1, 1.6, 2), float(rng.choice([0.0, 0.7]))),
            yaw_deg=float(rng.choice([0.0, 31.0])),
            name=f"box{k}",
        )
        inside_out = rng.random() < 0.3
        things.append(replace(solid, faces=solid.faces[:, ::-1]) if inside_out else solid)
    for k in range(int(rng.integers(0, 4))):
        corners = rng.uniform((0.2, 0.2, 0.1), (2.6, 1.9, 2.2), (3, 3))
        things.append(
            Body(name=f"sheet{k}", vertices_m=corners, faces=[[0, 1, 2]], material="wood")
        )
    return build_scene(room, objects=things)


def holds_sequence(tree, image, planes):
    """Whether the tree holds a sequence of planes that ends in an image."""
    if not planes:
        return image == 0
    return any(
        tree.branch_plane[b] == planes[-1]
        and holds_sequence(tree, tree.branch_parent[b], planes[:-1])
        for b in range(tree.branch_start[image], tree.branch_start[image + 1])
    )
