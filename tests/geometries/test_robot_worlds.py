"""Worlds of the shape of public robot worlds stand upright, in metres, with all their models."""

import numpy as np
import pytest
from robot_worlds import WORLDS, hospital

from octant.geometries.errors import PhysicsWarning
from octant.geometries.mesh_files import load_bodies

EXPECTED = {
    "warehouse": (8, [(-7, -10, -0.090092), (7, 10, 8)]),
    "small_house": (8, [(-4, -3, -0.02), (4, 3, 2.5)]),
    "turtlebot_house": (6, [(-5.575, -5.575, 0), (5.575, 5.575, 2.5)]),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_a_world_is_read_as_it_is_packed(tmp_path, name):
    count, bounds = EXPECTED[name]
    bodies = load_bodies(WORLDS[name](tmp_path), material="wood")
    assert len(bodies) == count
    spans = np.array([body.bounds_m for body in bodies])
    found = [spans[:, 0].min(axis=0), spans[:, 1].max(axis=0)]
    np.testing.assert_allclose(found, bounds, atol=1e-3)


def test_floors_stand_on_one_another_and_what_fell_is_left_out_and_named(tmp_path):
    world = hospital(tmp_path, includes=8)
    with pytest.warns(PhysicsWarning, match=r"hospital\.world: 1 of \d+ bodies left out.*Visitor"):
        bodies = load_bodies(world, material="wood")
    heights = {body.name: body.bounds_m[:, 2] for body in bodies}
    for part, expected in (("walls", [(0, 3.2), (3.4, 6.6)]), ("Chair", [(0, 0.98), (3.4, 4.38)])):
        found = np.unique([z for name, z in heights.items() if part in name], axis=0)
        np.testing.assert_allclose(found, expected, atol=1e-6)
