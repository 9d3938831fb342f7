# mypy: allow-untyped-defs
"""Compiled kernels of the image search: which planes can follow which image."""

import numpy as np
from numba import njit

MAX_CORNERS = 24
"""Greatest number of corners of a window; a window that would have more is left uncut there."""


@njit(cache=True, error_model="numpy")
def _cut(corners, count, nx, ny, nz, offset, slack, out):
    """Keep the part of a convex polygon where n . x >= offset - slack; return its corner count."""
    kept = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        a = nx * corners[i, 0] + ny * corners[i, 1] + nz * corners[i, 2] - offset + slack
        b = nx * corners[j, 0] + ny * corners[j, 1] + nz * corners[j, 2] - offset + slack
        if a >= 0.0:
            out[kept] = corners[i]
            kept += 1
        if (a >= 0.0) != (b >= 0.0):
            t = a / (a - b)
            for k in range(3):
                out[kept, k] = corners[i, k] + t * (corners[j, k] - corners[i, k])
            kept += 1
    return kept


@njit(cache=True, error_model="numpy")
def _copy(source, count, target):
    for i in range(count):
        for k in range(3):
            target[i, k] = source[i, k]


@njit(cache=True, error_model="numpy")
def clip_to_beam(hull, count, image, window, window_count, slack, work, out):
    """Return the corner count of the part of a facet that a beam can reach, written to ``out``.

    The beam leaves ``image`` through the convex polygon ``window`` and counts beyond it. Every cut
    gives way by ``slack`` [m], so that what is dropped cannot carry a path.
    """
    _copy(hull, count, out)
    mx, my, mz = 0.0, 0.0, 0.0
    for i in range(window_count):
        mx += window[i, 0] / window_count
        my += window[i, 1] / window_count
        mz += window[i, 2] / window_count
    # Beyond the window: the plane's normal by Newell's sum, turned away from the image.
    nx, ny, nz = 0.0, 0.0, 0.0
    for i in range(window_count):
        j = i + 1 if i + 1 < window_count else 0
        nx += (window[i, 1] - window[j, 1]) * (window[i, 2] + window[j, 2])
        ny += (window[i, 2] - window[j, 2]) * (window[i, 0] + window[j, 0])
        nz += (window[i, 0] - window[j, 0]) * (window[i, 1] + window[j, 1])
    norm = np.sqrt(nx * nx + ny * ny + nz * nz)
    # A window thinner than the slack has no reliable normal, and a full polygon no room for cuts.
    if norm < slack * slack:
        return count
    nx, ny, nz = nx / norm, ny / norm, nz / norm
    if nx * (mx - image[0]) + ny * (my - image[1]) + nz * (mz - image[2]) < 0.0:
        nx, ny, nz = -nx, -ny, -nz
    if count < MAX_CORNERS:
        kept = _cut(out, count, nx, ny, nz, nx * mx + ny * my + nz * mz, slack, work)
        _copy(work, kept, out)
        count = kept
    for i in range(window_count):
        if count < 3:
            return 0
        if count >= MAX_CORNERS:
            return count
        j = i + 1 if i + 1 < window_count else 0
        ax, ay, az = window[i, 0] - image[0], window[i, 1] - image[1], window[i, 2] - image[2]
        bx, by, bz = window[j, 0] - image[0], window[j, 1] - image[1], window[j, 2] - image[2]
        sx, sy, sz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        norm = np.sqrt(sx * sx + sy * sy + sz * sz)
        if norm < slack * np.sqrt(ax * ax + ay * ay + az * az):
            continue
        sx, sy, sz = sx / norm, sy / norm, sz / norm
        if sx * (mx - image[0]) + sy * (my - image[1]) + sz * (mz - image[2]) < 0.0:
            sx, sy, sz = -sx, -sy, -sz
        # The beam widens with distance: a corner of the window that is off by the slack moves the
        # side of the beam further out there.
        reach = 0.0
        for k in range(count):
            reach = max(
                reach,
                abs(out[k, 0] - image[0]) + abs(out[k, 1] - image[1]) + abs(out[k, 2] - image[2]),
            )
        near = np.sqrt(min(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz))
        give = slack * (1.0 + reach / max(near, slack))
        offset = sx * image[0] + sy * image[1] + sz * image[2]
        kept = _cut(out, count, sx, sy, sz, offset, give, work)
        _copy(work, kept, out)
        count = kept
    return count if count >= 3 else 0


@njit(cache=True, error_model="numpy")
def _grown(array, needed):
    """Return the array with room for ``needed`` rows."""
    if needed <= len(array):
        return array
    larger = np.empty((max(needed, 2 * len(array)), array.shape[1]), dtype=array.dtype)
    larger[: len(array)] = array
    return larger


@njit(cache=True, error_model="numpy")
def expand(
    images,
    window_start,
    window_plane,
    window_corner_start,
    window_corners,
    plane_normal,
    plane_offset,
    plane_facet_start,
    inner_side,
    hull_start,
    hulls,
    slack,
    keep_windows,
):
    """Return the children of every image: which planes its beam can be reflected by next.

    Parameters: (n, 3) images; the windows of image i from ``window_start[i]``, each with its plane
    and its corners; the planes with their facets; ``inner_side`` is +1 or -1 for a plane that
    reflects on that side only, else 0; the convex hulls of the facets.

    Returns: (c, 2) parent image and plane of each child; (w, 3) child, plane and corner count of
    each window; (v, 3) corners of the windows.
    """
    children = np.empty((64, 2), dtype=np.int64)
    windows = np.empty((64, 3), dtype=np.int64)
    corners = np.empty((256, 3))
    n_children, n_windows, n_corners = 0, 0, 0
    work = np.empty((MAX_CORNERS + 4, 3))
    clipped = np.empty((MAX_CORNERS + 4, 3))
    first = np.empty((MAX_CORNERS + 4, 3))
    for node in range(len(images)):
        image = images[node]
        for plane in range(len(plane_normal)):
            height = (
                plane_normal[plane, 0] * image[0]
                + plane_normal[plane, 1] * image[1]
                + plane_normal[plane, 2] * image[2]
                - plane_offset[plane]
            )
            if abs(height) <= slack or height * inner_side[plane] < 0.0:
                continue
            reached = False
            for facet in range(plane_facet_start[plane], plane_facet_start[plane + 1]):
                hull = hulls[hull_start[facet] : hull_start[facet + 1]]
                hits, first_count = 0, 0
                if window_start[node] == window_start[node + 1]:  # the source itself
                    hits, first_count = 1, len(hull)
                    _copy(hull, first_count, first)
                for w in range(window_start[node], window_start[node + 1]):
                    if window_plane[w] == plane:
                        continue
                    lo, hi = window_corner_start[w], window_corner_start[w + 1]
                    count = clip_to_beam(
                        hull, len(hull), image, window_corners[lo:hi], hi - lo, slack, work, clipped
                    )
                    if count > 0:
                        hits += 1
                        if hits == 1:
                            first_count = count
                            _copy(clipped, count, first)
                        else:
                            break
                if hits == 0:
                    continue
                reached = True
                if not keep_windows:
                    break
                if hits > 1:  # lit through several windows: the whole facet stands for their union
                    first_count = len(hull)
                    _copy(hull, first_count, first)
                windows = _grown(windows, n_windows + 1)
                corners = _grown(corners, n_corners + first_count)
                windows[n_windows, 0] = n_children
                windows[n_windows, 1] = plane
                windows[n_windows, 2] = first_count
                _copy(first, first_count, corners[n_corners:])
                n_windows += 1
                n_corners += first_count
            if reached:
                children = _grown(children, n_children + 1)
                children[n_children, 0] = node
                children[n_children, 1] = plane
                n_children += 1
    return children[:n_children].copy(), windows[:n_windows].copy(), corners[:n_corners].copy()
