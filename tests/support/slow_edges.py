"""Slow, independent paths over edges: every edge, every plane sequence, plain NumPy and SciPy.

It finds the edges itself, from the facets' outlines, and the diffraction points by minimising the
length numerically. Only solid boxes and single sheets may stand in the scene, apart from its room.
"""

import itertools

import numpy as np
from scipy.optimize import minimize, minimize_scalar
from slow_images import blocked, inside, polygons

EPS = 1e-7


def edges(scene):
    """Return (start, end, plane numbers) of the edges that are no inner corners of the room."""
    faces = polygons(scene)
    found = {}
    for _, _, outline, plane in faces:
        for a, b in outline:
            key = tuple(sorted((tuple(np.round(a, 6)), tuple(np.round(b, 6)))))
            found.setdefault(key, (a, b, set()))[2].add(plane)
    low, high = scene.bounds_m
    return [
        (np.array(a), np.array(b), planes)
        for a, b, planes in found.values()
        if not (
            scene.has_room
            and any(
                abs(a[k] - side[k]) < EPS and abs(b[k] - side[k]) < EPS
                for k in range(3)
                for side in (low, high)
            )
        )
    ]


def mirror(point, plane):
    normal, offset = plane
    return point - 2.0 * (normal @ point - offset) * normal


def reflections(scene_faces, planes, sequence, start, end):
    """Return the points at which the planes of a sequence reflect between two points, or None."""
    images = [np.asarray(start, float)]
    for p in sequence:
        images.append(mirror(images[-1], planes[p]))
    points = []
    here = np.asarray(end, float)
    for step in range(len(sequence), 0, -1):
        n, d = planes[sequence[step - 1]]
        hi, hp = n @ images[step] - d, n @ here - d
        if min(abs(hi), abs(hp)) < EPS or hi * hp >= 0.0:
            return None
        hit = here + hp / (hp - hi) * (images[step] - here)
        if not any(f[3] == sequence[step - 1] and inside(hit, n, f[2]) for f in scene_faces):
            return None
        points.append(hit)
        here = hit
    return points[::-1]


def through_air(faces, vertices, touched):
    """Return whether no facet stands between neighbours, each ignoring the planes it touches."""
    return not any(
        blocked(vertices[i], vertices[i + 1], faces, touched[i] | touched[i + 1])
        for i in range(len(vertices) - 1)
    )


def leaves_into_air(scene, edge_point, other):
    """Return whether a ray from an edge point starts outside every solid."""
    step = 1e-4 * (other - edge_point) / np.linalg.norm(other - edge_point)
    return not scene.inside_solid((edge_point + step)[None, :])[0]


def paths(scene, source, receiver, max_order):
    """Return the sorted (order, length, letters) of all paths over one edge."""
    faces = polygons(scene)
    planes = {p: (n, d) for n, d, _, p in faces}
    found = []
    for a, b, own in edges(scene):
        for before in range(max_order):
            for after in range(max_order - before):
                for first in itertools.product(planes, repeat=before):
                    for second in itertools.product(planes, repeat=after):
                        path = _single(
                            scene, faces, planes, (a, b, own), first, second, source, receiver
                        )
                        if path is not None:
                            found.append(
                                (before + after + 1, path, before * "R" + "D" + after * "R")
                            )
    return sorted(found)


def _single(scene, faces, planes, edge, first, second, source, receiver):
    a, b, own = edge
    pairs = [*itertools.pairwise(first), *itertools.pairwise(second)]
    if any(p == q for p, q in pairs):
        return None
    image_s, image_r = np.asarray(source, float), np.asarray(receiver, float)
    for p in first:
        image_s = mirror(image_s, planes[p])
    for p in second[::-1]:
        image_r = mirror(image_r, planes[p])

    def length(t):
        point = a + t * (b - a)
        return np.linalg.norm(point - image_s) + np.linalg.norm(point - image_r)

    best = minimize_scalar(length, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12})
    if not 1e-6 < best.x < 1.0 - 1e-6:
        return None
    point = a + best.x * (b - a)
    lead = reflections(faces, planes, first, source, point)
    tail = reflections(faces, planes, second, point, receiver)
    if lead is None or tail is None:
        return None
    vertices = [np.asarray(source, float), *lead, point, *tail, np.asarray(receiver, float)]
    touched = [set(), *({p} for p in first), own, *({p} for p in second), set()]
    k = len(lead) + 1
    if not through_air(faces, vertices, touched):
        return None
    if not all(leaves_into_air(scene, point, vertices[j]) for j in (k - 1, k + 1)):
        return None
    return float(best.fun)


def over_two_edges(scene, source, receiver):
    """Return the sorted lengths of all paths over two edges of one plane, without reflections."""
    faces = polygons(scene)
    found = []
    for (a, b, own), (c, d, other) in itertools.permutations(edges(scene), 2):
        if not own & other:
            continue

        def length(t, a=a, b=b, c=c, d=d):
            p, q = a + t[0] * (b - a), c + t[1] * (d - c)
            return np.linalg.norm(p - source) + np.linalg.norm(p - q) + np.linalg.norm(q - receiver)

        best = minimize(
            length, (0.5, 0.5), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-14}
        )
        if not all(1e-6 < t < 1.0 - 1e-6 for t in best.x):
            continue
        p, q = a + best.x[0] * (b - a), c + best.x[1] * (d - c)
        vertices = [np.asarray(source, float), p, q, np.asarray(receiver, float)]
        if not through_air(faces, vertices, [set(), own, other, set()]):
            continue
        if leaves_into_air(scene, p, vertices[0]) and leaves_into_air(scene, q, vertices[3]):
            found.append(float(best.fun))
    return sorted(found)
