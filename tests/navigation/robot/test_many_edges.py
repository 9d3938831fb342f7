"""Footprints of very many edges look only at near ones, and find the same distances."""

import numpy as np

from octant.navigation.robot.floor import MANY_EDGES, Footprint


def test_a_footprint_of_very_many_edges_finds_the_distance_that_each_edge_alone_gives():
    rng = np.random.default_rng(5)
    start = rng.uniform(-3.0, 3.0, (MANY_EDGES + 500, 2))
    length = np.where(rng.random(len(start)) < 0.01, 4.0, 0.02)
    edges = np.hstack((start, start + rng.normal(size=start.shape) * length[:, None]))
    points = rng.uniform(-9.0, 9.0, (40, 2))
    parts = [
        Footprint(edges_m=part, radius_m=0.15).clearance_m(points)
        for part in np.array_split(edges, 5)
    ]
    found = Footprint(edges_m=edges, radius_m=0.15).clearance_m(points)
    np.testing.assert_array_equal(found, np.min(parts, axis=0))
