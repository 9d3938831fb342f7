"""A slow, independent image method: every plane sequence, no pruning, plain NumPy.

It shares nothing with the package but the facets' outlines, which it turns into polygons itself.
"""

import itertools

import numpy as np

EPS = 1e-9


def polygons(scene):
    """Return per facet: normal, offset, (k, 2, 3) outline, plane number."""
    f = scene.facets
    return [
        (f.plane_normal[p], f.plane_offset_m[p], f.outline_room_m(i), p)
        for i, p in enumerate(f.facet_plane)
    ]


def inside(point, normal, outline):
    """Winding angle of the outline about the point, seen along the normal."""
    a, b = outline[:, 0] - point, outline[:, 1] - point
    cross = np.cross(a, b) @ normal
    dot = np.sum(a * b, axis=1)
    return abs(np.sum(np.arctan2(cross, dot))) > np.pi


def blocked(p, q, faces, skip):
    for normal, offset, outline, plane in faces:
        if plane in skip:
            continue
        hp, hq = normal @ p - offset, normal @ q - offset
        if hp * hq >= 0.0:
            continue
        hit = p + hp / (hp - hq) * (q - p)
        if inside(hit, normal, outline):
            return True
    return False


def paths(scene, source, receiver, max_order):
    """Return the sorted list of (order, length, vertices) of all specular paths."""
    found = [
        (len(planes), float(np.linalg.norm(image - receiver)), vertices)
        for planes, image, vertices in sequences(scene, source, receiver, max_order)
    ]
    return sorted(found, key=lambda path: path[:2])


def sequences(scene, source, receiver, max_order, opaque=None):
    """Yield planes, image and vertices of all specular paths; facets not opaque let them pass."""
    faces = polygons(scene)
    walls = faces if opaque is None else [f for f, o in zip(faces, opaque, strict=True) if o]
    planes = {p: (n, d) for n, d, _, p in faces}
    for order in range(max_order + 1):
        for sequence in itertools.product(planes, repeat=order):
            if any(a == b for a, b in itertools.pairwise(sequence)):
                continue
            images = [np.asarray(source, float)]
            for p in sequence:
                n, d = planes[p]
                images.append(images[-1] - 2.0 * (n @ images[-1] - d) * n)
            vertices = [np.asarray(receiver, float)]
            ok = True
            for step in range(order, 0, -1):
                n, d = planes[sequence[step - 1]]
                hi, hp = n @ images[step] - d, n @ vertices[-1] - d
                if hi * hp >= 0.0:
                    ok = False
                    break
                hit = vertices[-1] + hp / (hp - hi) * (images[step] - vertices[-1])
                on = [f for f in faces if f[3] == sequence[step - 1] and inside(hit, n, f[2])]
                if not on:
                    ok = False
                    break
                vertices.append(hit)
            if not ok:
                continue
            vertices.append(images[0])
            ends = [None, *sequence[::-1], None]
            if any(
                blocked(vertices[i], vertices[i + 1], walls, {ends[i], ends[i + 1]})
                for i in range(order + 1)
            ):
                continue
            yield sequence, images[-1], vertices[::-1]


def through_sheets(scene, source, receiver, max_order, sheet):
    """Return the sorted (length, words) of all specular paths, sheets that they cross included.

    A word holds ``R`` and ``T`` with the facet's plane; facets that are no sheets block.
    """
    faces = polygons(scene)
    found = []
    walls = [not s for s in sheet]
    for planes, image, vertices in sequences(scene, source, receiver, max_order, walls):
        ends = [None, *planes, None]
        word = []
        for i in range(len(vertices) - 1):
            word += [("T", p) for p in _crossed(faces, sheet, vertices[i : i + 2], ends[i : i + 2])]
            word += [("R", planes[i])] if i < len(planes) else []
        found.append((float(np.linalg.norm(image - receiver)), tuple(word)))
    return sorted(found)


def _crossed(faces, sheet, ends, skip):
    """Return the planes of the sheets between two points, the nearest first."""
    p, q = ends
    places = []
    for (normal, offset, outline, plane), lets_through in zip(faces, sheet, strict=True):
        hp, hq = normal @ p - offset, normal @ q - offset
        if not lets_through or plane in skip or hp * hq >= 0.0:
            continue
        t = hp / (hp - hq)
        if inside(p + t * (q - p), normal, outline):
            places.append((t, plane))
    return [plane for _, plane in sorted(places)]
