"""Facets the slow way: plane after plane and edge after edge, in plain Python.

Every triangle is held against the largest one's plane, within one tolerance for the whole scene.
"""

from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

SLIVER_ASPECT = 1e-4


def facet_outlines(vertices, faces, material, tolerance):
    """Return per facet: material, triangles and (k, 2, 3) outline edges."""
    plane_of = group_planes(vertices, faces, tolerance)
    found = []
    for plane in range(plane_of.max(initial=-1) + 1):
        triangles = np.flatnonzero(plane_of == plane)
        area = area_vectors(vertices, faces[triangles])
        same_side = area @ area[np.argmax(np.linalg.norm(area, axis=1))]
        for kind in np.unique(material[triangles]):
            chosen = material[triangles] == kind
            own = faces[triangles[chosen]]
            turned = np.where((same_side[chosen] < 0)[:, None], own[:, ::-1], own)
            for edges, members in _outlines(vertices, turned, tolerance):
                if edges:
                    found.append((kind, triangles[chosen][members], vertices[np.array(edges)]))
    return found


def area_vectors(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def connected_labels(count, pairs):
    ones = np.ones(len(pairs), dtype=np.int8)
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def group_planes(vertices_m, faces, tolerance_m):
    """Return the (t,) plane label of each triangle, -1 for triangles without area."""
    area = area_vectors(vertices_m, faces)
    size = np.linalg.norm(area, axis=1)
    corners = vertices_m[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    flat = size > 0.5 * tolerance_m * longest
    label = np.full(len(faces), -1, dtype=np.int64)
    if not flat.any():
        return label
    normal = np.divide(area, size[:, None], out=np.zeros_like(area), where=size[:, None] > 0)
    sliver = 2 * size < SLIVER_ASPECT * longest**2
    trusted = np.flatnonzero(flat & ~sliver)
    untrusted = np.flatnonzero(flat & sliver)
    tree = cKDTree(np.vstack((normal[trusted], -normal[trusted]))) if len(trusted) else None
    count = 0
    for seed in sorted(np.flatnonzero(flat), key=lambda i: (-size[i], i)):
        if label[seed] >= 0:
            continue
        near = untrusted
        if tree is not None:
            found = np.asarray(tree.query_ball_point(normal[seed], 0.02), dtype=np.int64)
            near = np.concatenate((trusted[found % len(trusted)], untrusted))
        near = near[label[near] < 0]
        distance = np.abs((corners[near] - corners[seed, 0]) @ normal[seed]).max(axis=1)
        label[near[distance <= tolerance_m]] = count
        label[seed] = count
        count += 1
    return label


def _outlines(vertices_m, faces, tolerance_m):
    """Return, per connected piece, its directed outline edges and the triangles it is made of.

    Directed edges that run in opposite senses cancel. Where a corner of one triangle stands on the
    side of another (a T-junction) the side is split there first, so that seams cancel as well.
    """
    if len(faces) == 1:  # every triangle of a curved surface: nothing to cancel or to join
        a, b, c = faces[0].tolist()
        return [([(a, b), (b, c), (c, a)], np.zeros(1, dtype=np.int64))]
    net = {}
    for a, b in np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]])).tolist():
        _count_edge(net, a, b, 1)
    links = [(a, b) for a, b in faces[:, [0, 1]].tolist()] + faces[:, [1, 2]].tolist()
    split = {}
    corners = np.array(sorted({vertex for edge in net for vertex in edge}), dtype=np.int64)
    for (a, b), times in net.items():
        chain = [a, *_corners_on_edge(vertices_m, corners, a, b, tolerance_m), b]
        links += list(pairwise(chain))
        for p, q in pairwise(chain):
            _count_edge(split, p, q, times)
    used, index = np.unique(np.concatenate((faces.ravel(), np.ravel(links))), return_inverse=True)
    label = connected_labels(len(used), index[faces.size :].reshape(-1, 2))
    piece_of_triangle = label[index[: faces.size].reshape(-1, 3)[:, 0]]
    place = {int(vertex): int(label[i]) for i, vertex in enumerate(used)}
    by_piece = {}
    for (a, b), times in split.items():
        by_piece.setdefault(place[a], []).extend([(a, b)] * times)
    order = dict.fromkeys(piece_of_triangle.tolist())
    return [
        (
            _merge_straight(vertices_m, by_piece.get(piece, []), tolerance_m),
            np.flatnonzero(piece_of_triangle == piece),
        )
        for piece in order
    ]


def _count_edge(net, a, b, times):
    """Add a directed edge, cancelling it against its reverse; counts stay positive."""
    for _ in range(times):
        if net.get((b, a), 0) > 0:
            net[b, a] -= 1
            if net[b, a] == 0:
                del net[b, a]
        else:
            net[a, b] = net.get((a, b), 0) + 1


def _corners_on_edge(vertices_m, corners, a, b, tolerance_m):
    """Return those of the outline's corners that stand on the edge between a and b, in order."""
    start, span = vertices_m[a], vertices_m[b] - vertices_m[a]
    length = float(np.linalg.norm(span))
    along = (vertices_m[corners] - start) @ span / length
    aside = np.linalg.norm(vertices_m[corners] - start - along[:, None] * span / length, axis=1)
    on = (aside <= tolerance_m) & (along > tolerance_m) & (along < length - tolerance_m)
    hits = corners[on][np.argsort(along[on])]
    return [int(v) for v in hits]


def _merge_straight(vertices_m, edges, tolerance_m):
    """Return the outline with straight runs of edges joined into single edges."""
    following = {}
    leading = {}
    for a, b in edges:
        following.setdefault(a, []).append(b)
        leading.setdefault(b, []).append(a)
    for vertex in list(following):
        if len(following[vertex]) != 1 or len(leading.get(vertex, [])) != 1:
            continue
        before, after = leading[vertex][0], following[vertex][0]
        span = vertices_m[after] - vertices_m[before]
        length = float(np.linalg.norm(span))
        if length == 0.0 or before == vertex:
            continue
        offset = vertices_m[vertex] - vertices_m[before]
        along = float(offset @ span) / length
        aside = float(np.linalg.norm(offset - along * span / length))
        if aside <= tolerance_m and 0.0 < along < length:
            following[before][following[before].index(vertex)] = after
            leading[after][leading[after].index(vertex)] = before
            del following[vertex], leading[vertex]
    return [(a, b) for a, ends in following.items() for b in ends]
