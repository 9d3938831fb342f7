"""Where the shortest way over two edges meets them, against a search over both places."""

import numpy as np
import pytest
from scipy.optimize import minimize

from octant.em.paths._edge_point_kernels import two_points


def random_case(rng, meeting):
    """Return the rows of two edges' lines, and both ends: how far off and how far along."""
    frame = np.zeros((2, 14))
    frame[:, :3] = rng.normal(size=3) if meeting else rng.normal(size=(2, 3))
    axes = rng.normal(size=(2, 3))
    frame[:, 3:6] = axes / np.linalg.norm(axes, axis=1)[:, None]
    return frame, rng.uniform(0.05, 4.0, 2), rng.uniform(-3.0, 3.0, 2)


def points(frame, places):
    return frame[:, :3] + np.asarray(places)[:, None] * frame[:, 3:6]


def shortest(frame, off, along):
    """Return both places of the shortest way, its length, and the leg between the edges [m]."""

    def length(places):
        p, q = points(frame, places)
        return np.hypot(off, places - along).sum() + np.linalg.norm(p - q)

    options = {"xatol": 1e-10, "fatol": 1e-14, "maxiter": 4000}
    starts = (along, np.full(2, 0.01))
    found = [minimize(length, x, method="Nelder-Mead", options=options) for x in starts]
    best = min(found, key=lambda result: result.fun)
    return best.x, best.fun, np.linalg.norm(np.subtract(*points(frame, best.x)))


@pytest.mark.parametrize("meeting", [True, False])
def test_the_points_are_those_of_the_shortest_way(meeting):
    """Edges of one body meet in its corner, where the length has a kink that is no diffraction."""
    rng = np.random.default_rng(2)
    kinks = 0
    for _ in range(60):
        frame, off, along = random_case(rng, meeting)
        s, t, found = two_points(frame, 0, 1, off[0], along[0], off[1], along[1])
        places, length, leg = shortest(frame, off, along)
        kinks += not found
        if found:
            assert (s, t) == pytest.approx(places, abs=1e-5 * length)
        else:
            assert leg < 1e-5 * length
    assert (kinks > 0) == meeting


def test_both_ways_find_the_same_points():
    rng = np.random.default_rng(1)
    for k in range(6000):
        frame, off, along = random_case(rng, k % 2 == 0)
        s, t, there = two_points(frame, 0, 1, off[0], along[0], off[1], along[1])
        v, u, back = two_points(frame, 1, 0, off[1], along[1], off[0], along[0])
        assert there == back
        if there:
            assert (s, t) == pytest.approx((u, v), abs=1e-9)
