"""Complete enumeration of the images of a source: every reflection sequence that can carry a path.

Images are built per plane, order by order. A sequence is dropped only when no path can use it:

* the plane was the last one reflected by, or the image lies on it;
* every body, the source and all receivers lie on one side of the plane (a wall of the room), and
  the image is on the other: the reflection would come from outside;
* the beam from the image through the part of the last facets that it can reach misses every facet
  of the plane. Beams are cut by convex hulls and never too tightly.

Sequences of one order that lead to the same point (two walls at right angles, either way round) are
one image with several branches. For a receiver at most one branch carries a path, because all of
them leave the receiver in the same direction, where the first facet met decides.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em import _image_kernels
from octant.em._path_kernels import TreeArrays
from octant.em.blocks import Progress
from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import weld
from octant.geometries.errors import GeometryError
from octant.geometries.facets import Facets
from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PAIRS_PER_CALL = 1_000_000
"""Pairs of image and plane [-] that one call of the kernel works through."""

MAX_IMAGES = 20_000_000
"""Images beyond which a search stops with an error instead of filling the memory."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageTree:
    """All images of a source up to an order, and how many sequences it took to find them.

    Parameters
    ----------
    source_m : (3,) float64
        The source [m]; it is image 0, of order 0.
    image_m : (n, 3) float64
        Position of each image [m], by ascending order.
    order : (n,) int64
        Number of reflections [-].
    branch_start : (n + 1,) int64
        Branches of image i are ``branch_start[i]`` up to ``branch_start[i + 1]`` [-], by ascending
        plane.
    branch_plane : (b,) int64
        Plane of a branch's last reflection [-].
    branch_parent : (b,) int64
        Image before that reflection [-].
    considered, pruned, merged, kept : (orders + 1,) int64
        Per order [-]: sequences looked at, dropped because no path can use them, found to lead to
        the same point as another, and images left. considered = pruned + merged + kept.
    region_m : (2, 3) float64
        Box [m] that receivers must lie in; infinite when they may be anywhere.
    """

    source_m: FloatArray
    image_m: FloatArray
    order: IntArray
    branch_start: IntArray
    branch_plane: IntArray
    branch_parent: IntArray
    considered: IntArray
    pruned: IntArray
    merged: IntArray
    kept: IntArray
    region_m: FloatArray

    @property
    def max_order(self) -> int:
        """Greatest number of reflections that was searched [-]."""
        return len(self.kept) - 1

    def kernel_arrays(self) -> TreeArrays:
        """Return the tree as the path kernels take it [m]."""
        return TreeArrays(
            image=self.image_m,
            order=self.order,
            branch_start=self.branch_start,
            branches=np.column_stack((self.branch_plane, self.branch_parent)),
            ways=int(self._ways().max()),
            max_order=self.max_order,
        )

    def _ways(self) -> IntArray:
        """Return the number of sequences that lead to each image [-], (n,)."""
        ways = np.ones(len(self.image_m), dtype=np.int64)
        image_of = np.repeat(np.arange(len(self.image_m)), np.diff(self.branch_start))
        for order in range(1, self.max_order + 1):
            now = self.order[image_of] == order
            total = np.bincount(
                image_of[now],
                weights=ways[self.branch_parent[now]],
                minlength=len(ways),
            )
            level = self.order == order
            ways[level] = total[level].astype(np.int64)
        return ways


def search_images(
    scene: Scene,
    source_m: npt.ArrayLike,
    max_reflections: int,
    *,
    region_m: npt.ArrayLike | None = None,
    progress: Progress | None = None,
) -> ImageTree:
    """Return every image of a source that a path of up to so many reflections can use.

    Parameters
    ----------
    scene : Scene
        Geometry.
    source_m : (3,) float
        Place of the antenna [m], off every facet.
    max_reflections : int
        Greatest order [-], >= 0.
    region_m : (2, 3) float, optional
        Least and greatest corner [m] of the box that all receivers lie in. Default: the scene's
        bounds when the source is in a room, else everywhere. A smaller region prunes more; the
        images of a box seen from inside are 1, 6, 18, 38, 66, 102 ... (4 n^2 + 2).
    progress : callable, optional
        Told (images done, images in all) of each order as it grows.

    Returns
    -------
    ImageTree
        Complete for receivers in the region.

    Raises
    ------
    GeometryError
        For a bad source or order, or when the images would exceed ``MAX_IMAGES``.

    Notes
    -----
    Cost grows with the product of images and planes per order. For meshes of thousands of planes
    low orders stay tractable; high ones do not.
    """
    source = frozen_array(source_m, name="source_m", shape=(3,))
    if max_reflections < 0:
        msg = f"max_reflections = {max_reflections} is negative; give 0 or more."
        raise GeometryError(msg)
    region = _region(scene, source, region_m)
    search = _Search(scene, source, region, progress)
    for _ in range(max_reflections):
        search.grow(keep_windows=search.order_reached + 1 < max_reflections)
    return search.finish()


def _region(scene: Scene, source: FloatArray, region_m: npt.ArrayLike | None) -> FloatArray:
    if region_m is not None:
        return frozen_array(region_m, name="region_m", shape=(2, 3), finite=False)
    slack = scene.tolerance_m
    low, high = scene.bounds_m
    if scene.has_room and bool((source > low - slack).all() and (source < high + slack).all()):
        return frozen_array(scene.bounds_m, name="region_m", shape=(2, 3))
    everywhere = np.array([[-math.inf] * 3, [math.inf] * 3])
    return frozen_array(everywhere, name="region_m", shape=(2, 3), finite=False)


def inner_sides(scene: Scene, source: FloatArray, region: FloatArray) -> IntArray:
    """Return +1, -1 or 0 [-] per plane: the one side on which everything lies, receivers included.

    Parameters
    ----------
    scene : Scene
        Geometry.
    source : (3,) float64
        Place of the source [m].
    region : (2, 3) float64
        Least and greatest corner [m] of the box that receivers lie in.
    """
    sides = scene.supporting_side.copy()
    for plane in np.flatnonzero(sides):
        normal = sides[plane] * scene.facets.plane_normal[plane]
        offset = sides[plane] * scene.facets.plane_offset_m[plane]
        # The corner of the region that lies farthest out; 0 * inf must not become NaN.
        corner = np.where(normal > 0.0, region[0], region[1])
        used = normal != 0.0
        lowest = float(normal[used] @ corner[used])
        if min(lowest, float(normal @ source)) - offset < -scene.tolerance_m:
            sides[plane] = 0
    return sides


class _Search:
    """The images found so far, order by order."""

    def __init__(
        self, scene: Scene, source: FloatArray, region: FloatArray, progress: Progress | None
    ) -> None:
        self.source, self.region, self.progress = source, region, progress
        self.facets = scene.facets
        self.inner_side = inner_sides(scene, source, region)
        self.hull_start, self.hulls = facet_hulls(self.facets)
        self.slack = scene.tolerance_m
        self.level_m = source[None, :]
        self.level_first = 0
        self.windows = (
            np.zeros(2, np.int64),
            np.zeros(0, np.int64),
            np.zeros(1, np.int64),
            np.zeros((0, 3)),
        )
        self.images = [source[None, :]]
        self.branches: list[IntArray] = []  # image, plane, parent
        self.counts = [(1, 0, 0, 1)]

    @property
    def order_reached(self) -> int:
        return len(self.images) - 1

    def grow(self, *, keep_windows: bool) -> None:
        """Add the images of the next order."""
        f = self.facets
        planes = len(f.plane_normal)
        children, windows, corners = self._expand(keep_windows=keep_windows)
        considered = len(self.level_m) * planes
        normal, offset = f.plane_normal[children[:, 1]], f.plane_offset_m[children[:, 1]]
        parent_m = self.level_m[children[:, 0]]
        height = np.sum(parent_m * normal, axis=1) - offset
        place_m = parent_m - 2.0 * height[:, None] * normal
        representative = weld(place_m, self.slack) if len(place_m) else np.zeros(0, np.int64)
        kept, image_of = np.unique(representative, return_inverse=True)
        first = self.level_first + len(self.level_m)
        if first + len(kept) > MAX_IMAGES:
            msg = (
                f"{first + len(kept)} images at order {self.order_reached + 1} are more than "
                f"{MAX_IMAGES}; lower max_reflections, or simplify the mesh."
            )
            raise GeometryError(msg)
        parents = self.level_first + children[:, 0]
        self.branches.append(np.column_stack((first + image_of, children[:, 1], parents)))
        self.images.append(place_m[kept])
        self.counts.append(
            (considered, considered - len(children), len(children) - len(kept), len(kept))
        )
        self.level_m, self.level_first = place_m[kept], first
        self.windows = _windows_by_image(windows, corners, image_of, len(kept))

    def _expand(self, *, keep_windows: bool) -> tuple[IntArray, IntArray, FloatArray]:
        """Return children, windows and corners of the level, worked through in short calls.

        Each call does about as many pairs of image and plane as take a tenth of a second, so that
        an interrupt is heard and progress is told.
        """
        f = self.facets
        start, plane, corner_start, window_corners = self.windows
        images = np.ascontiguousarray(self.level_m)
        step = max(1, PAIRS_PER_CALL // max(1, len(f.plane_normal)))
        parts: list[tuple[IntArray, IntArray, FloatArray]] = []
        children_before = 0
        for begin in range(0, max(1, len(images)), step):
            end = min(begin + step, len(images))
            children, windows, corners = _image_kernels.expand(
                images[begin:end],
                start[begin : end + 1],
                plane,
                corner_start,
                window_corners,
                f.plane_normal,
                f.plane_offset_m,
                f.plane_facet_start,
                self.inner_side,
                self.hull_start,
                self.hulls,
                self.slack,
                keep_windows,
            )
            children[:, 0] += begin
            windows[:, 0] += children_before
            children_before += len(children)
            parts.append((children, windows, corners))
            if self.progress is not None:
                self.progress(end, len(images))
        first, second, third = zip(*parts, strict=True)
        return np.concatenate(first), np.concatenate(second), np.concatenate(third)

    def finish(self) -> ImageTree:
        """Return the tree."""
        image = np.concatenate(self.images)
        order = np.repeat(np.arange(len(self.images)), [len(level) for level in self.images])
        none = np.zeros((0, 3), dtype=np.int64)
        branches = np.concatenate(self.branches) if self.branches else none
        branches = branches[np.lexsort((branches[:, 1], branches[:, 0]))]
        start = np.searchsorted(branches[:, 0], np.arange(len(image) + 1))
        considered, pruned, merged, kept = np.array(self.counts, dtype=np.int64).T
        return ImageTree(
            source_m=self.source,
            image_m=frozen_array(image, name="image_m", shape=(None, 3)),
            order=order.astype(np.int64),
            branch_start=start.astype(np.int64),
            branch_plane=np.ascontiguousarray(branches[:, 1]),
            branch_parent=np.ascontiguousarray(branches[:, 2]),
            considered=considered,
            pruned=pruned,
            merged=merged,
            kept=kept,
            region_m=self.region,
        )


def _windows_by_image(
    windows: IntArray, corners: FloatArray, image_of: IntArray, images: int
) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """Return windows sorted by image: start per image, plane, start of corners, corners."""
    image = image_of[windows[:, 0]] if len(windows) else np.zeros(0, np.int64)
    order = np.argsort(image, kind="stable")
    size = windows[order, 2]
    old_start = np.cumsum(windows[:, 2]) - windows[:, 2]
    corner_start = np.concatenate(([0], np.cumsum(size))).astype(np.int64)
    moved = np.repeat(old_start[order] - corner_start[:-1], size) + np.arange(corner_start[-1])
    start = np.searchsorted(image[order], np.arange(images + 1)).astype(np.int64)
    return start, np.ascontiguousarray(windows[order, 1]), corner_start, corners[moved]


def facet_hulls(facets: Facets) -> tuple[IntArray, FloatArray]:
    """Return the convex hull of each facet in room coordinates: start per facet, (v, 3) corners.

    A hull of many corners (a disc) is replaced by its bounding rectangle: a hull may be too large,
    never too small.

    Parameters
    ----------
    facets : Facets
        Facets of a scene [m].
    """
    start, hulls = [0], []
    for facet, plane in enumerate(facets.facet_plane):
        edges = facets.outline_m[facets.outline_start[facet] : facets.outline_start[facet + 1]]
        uv = _convex_hull(edges.reshape(-1, 2))
        if len(uv) > _image_kernels.MAX_CORNERS // 2:
            (u0, v0), (u1, v1) = uv.min(axis=0), uv.max(axis=0)
            uv = np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])
        origin = facets.plane_normal[plane] * facets.plane_offset_m[plane]
        hulls.append(origin + uv[:, :1] * facets.plane_u[plane] + uv[:, 1:] * facets.plane_v[plane])
        start.append(start[-1] + len(uv))
    corners = np.concatenate(hulls) if hulls else np.zeros((0, 3))
    return np.array(start, dtype=np.int64), np.ascontiguousarray(corners)


def _convex_hull(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of (n, 2) points, counter-clockwise.

    Andrew's monotone chain (1979).
    """
    ordered = sorted(set(map(tuple, points.tolist())))
    chains: list[list[tuple[float, float]]] = []
    for sequence in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for p in sequence:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2], chain[-1]
                if (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) > 0.0:
                    break
                chain.pop()
            chain.append(p)
        chains.append(chain[:-1])
    return np.array(chains[0] + chains[1])
