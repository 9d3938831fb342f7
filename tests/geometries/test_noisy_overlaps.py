"""Walls drawn as pieces that overlap, with corners that agree to some micrometres only.

The right value is the triangles themselves: a place is wall when one of them covers it.
"""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from octant.geometries.bodies import Body
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

FAR = np.array([[15.0, -5.6, 2.5], [15.15, -5.6, 2.5], [15.0, -5.6, 0.0]])
RIM_M = 2e-4
PLACES = (0.0, 0.15, 0.3, 0.85, 1.0, 1.81, 2.5, 3.14)


def wall_of(pieces):
    """The scene of triangles (t, 3, 2) in the plane x = 0, and something 15 m away."""
    bodies = [
        Body(
            name=f"piece {k}",
            vertices_m=np.column_stack((np.zeros(3), corners)),
            faces=[[0, 1, 2]],
            material="concrete",
        )
        for k, corners in enumerate(pieces)
    ]
    far = Body(name="far", vertices_m=FAR, faces=[[0, 1, 2]], material="concrete")
    return build_scene((), objects=(*bodies, far))


def rectangle(y0, y1, z0, z1):
    a, b, c, d = (y0, z0), (y1, z0), (y1, z1), (y0, z1)
    return [[a, b, c], [a, c, d]]


def covered(triangles, places):
    """Which places (n, 2) the triangles cover, and how near [m] each is to one's side."""
    start = triangles[None]
    side = np.roll(triangles, -1, axis=1)[None] - start
    to = places[:, None, None] - start
    aside = (side[..., 0] * to[..., 1] - side[..., 1] * to[..., 0]) / np.hypot(
        *np.moveaxis(side, -1, 0)
    )
    inside = (aside > 0.0).all(axis=2) | (aside < 0.0).all(axis=2)
    return inside.any(axis=1), np.abs(aside).min(axis=(1, 2))


def on_facets(scene, places):
    """Which places (n, 2) of the plane x = 0 the outlines of its facets wind around."""
    facets, found = scene.facets, np.zeros(len(places), dtype=bool)
    points = np.column_stack((np.zeros(len(places)), places))
    for facet, plane in enumerate(facets.facet_plane):
        near = np.abs(points @ facets.plane_normal[plane] - facets.plane_offset_m[plane]) < 1e-3
        u, v = points @ facets.plane_u[plane], points @ facets.plane_v[plane]
        begin, end = facets.outline_start[facet : facet + 2]
        winding = np.zeros(len(places), dtype=int)
        for u0, v0, u1, v1 in facets.outline_m[begin:end]:
            left = (u1 - u0) * (v - v0) - (u - u0) * (v1 - v0)
            winding += ((v0 <= v) & (v1 > v) & (left > 0.0)).astype(int)
            winding -= ((v0 > v) & (v1 <= v) & (left < 0.0)).astype(int)
        found |= near & (winding != 0)
    return found


def unbalanced(facets):
    """How many facets have a corner where not as many edges end as begin."""
    count = 0
    for facet in range(len(facets.facet_plane)):
        begin, end = facets.outline_start[facet : facet + 2]
        edges = facets.outline_m[begin:end].reshape(-1, 2, 2)
        _, corner = np.unique(np.round(edges.reshape(-1, 2), 11), axis=0, return_inverse=True)
        corner = corner.reshape(-1, 2)
        size = int(corner.max()) + 1
        begins, ends = (np.bincount(corner[:, k], minlength=size) for k in (0, 1))
        count += bool((begins != ends).any())
    return count


@pytest.mark.parametrize("noise_m", [0.0, 1e-6, 2e-6, 3e-6])
def test_a_window_between_overlapping_pieces_stays_open(noise_m):
    """Sill, lintel, two piers, and the end of a wall that butts against one of them from inside."""
    pieces = np.array(
        [
            *rectangle(0.85, 1.81, 0.5, 2.5),
            *rectangle(1.81, 3.14, 1.7, 2.5),
            *rectangle(3.14, 5.35, 0.0, 2.5),
            *rectangle(0.85, 3.14, 0.0, 0.5),
            *rectangle(0.85, 1.0, 0.0, 2.5),
        ]
    )
    window = np.array([(2.475, 1.1), (1.9, 0.6), (3.0, 1.6), (6.0, 1.0)])
    wall = np.array([(0.9, 0.2), (0.9, 1.0), (2.0, 2.0), (4.0, 0.1), (2.0, 0.3)])
    for seed in range(15):
        noise = np.random.default_rng(seed).uniform(-noise_m, noise_m, pieces.shape)
        scene = wall_of(pieces + noise)
        assert not on_facets(scene, window).any(), seed
        assert on_facets(scene, wall).all(), seed
        assert unbalanced(scene.facets) == 0, seed


def draw_pieces(seed, noise_m):
    """Rectangles and triangles whose corners lie on a lattice, but for the noise."""
    rng = np.random.default_rng(seed)
    pieces = []
    for _ in range(int(rng.integers(3, 9))):
        if rng.random() < 0.5:
            y, z = (np.sort(rng.choice(PLACES, 2, replace=False)) for _ in range(2))
            pieces += rectangle(*y, *z)
        else:
            a, b, c = rng.choice(PLACES, (3, 2))
            if abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) > 1e-3:
                pieces.append([a, b, c])
    pieces = np.array(pieces or rectangle(0.0, 1.0, 0.0, 1.0))
    return pieces + rng.uniform(-noise_m, noise_m, pieces.shape), rng


@given(seed=st.integers(0, 2**32 - 1), noise_m=st.sampled_from([0.0, 3e-7, 1e-6, 3e-6, 1e-5, 3e-5]))
@example(seed=2, noise_m=2e-6)
@example(seed=10, noise_m=1e-5)
@example(seed=243, noise_m=3e-5)  # cut edges cross again
def test_facets_cover_what_their_triangles_cover_and_their_outlines_close(seed, noise_m):
    pieces, rng = draw_pieces(seed, noise_m)
    scene = wall_of(pieces)
    places = rng.uniform(-0.1, 3.3, (200, 2))
    wall, rim_m = covered(pieces, places)
    clear = rim_m > RIM_M
    assert (on_facets(scene, places) == wall)[clear].all()
    assert unbalanced(scene.facets) == 0
    wedges = find_wedges(scene)
    assert np.isfinite(wedges.exterior_rad).all()
    assert (wedges.length_m > 0.0).all()


def test_edges_shorter_than_what_counts_as_one_place_are_none():
    """Undersides of three walls, 3 um off one another: one edge has both its ends in one corner."""
    undersides = [
        [(0.1499978, 9e-07), (-2.4e-06, 2.7e-06), (0.1499996, 2.2999995)],
        [(0.1500004, 0.1499993), (-8e-07, -0.4200002), (1.5e-06, 0.1499978)],
        [(-2e-06, 0.1500025), (0.8200023, 1.9e-06), (1.9e-06, -2e-06)],
    ]
    wedges = find_wedges(wall_of(np.array(undersides)))
    assert len(wedges) > 6
    assert (wedges.length_m > 1e-3).all()
