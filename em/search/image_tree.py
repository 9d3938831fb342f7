"""The images of a source as a tree: every sequence of reflections, merged where they coincide."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.records import TreeArrays
from octant.geometries._arrays import frozen_array
from octant.geometries._plane_geometry import weld
from octant.geometries.errors import GeometryError
from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

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
        Number of reflections.
    branch_start : (n + 1,) int64
        Branches of image i are ``branch_start[i]`` up to ``branch_start[i + 1]``, by ascending
        plane.
    branch_plane : (b,) int64
        Plane of a branch's last reflection.
    branch_parent : (b,) int64
        Image before that reflection.
    considered, pruned, merged, kept : (orders + 1,) int64
        Per order: sequences looked at, dropped because no path can use them, found to lead to
        the same point as another, and images left. considered = pruned + merged + kept.
    region_m : (2, 3) float64
        Box [m] that receivers must lie in; infinite when they may be anywhere.
    opaque_facets : (f,) bool
        Facets that the search took to let nothing through.
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
    opaque_facets: BoolArray

    @property
    def max_order(self) -> int:
        """Greatest number of reflections that was searched."""
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
        """Return the number of sequences that lead to each image, (n,)."""
        ways = np.ones(len(self.image_m), dtype=np.int64)
        image_of = np.repeat(np.arange(len(self.image_m)), np.diff(self.branch_start))
        for order in range(1, self.max_order + 1):
            now = self.order[image_of] == order
            total = np.bincount(
                image_of[now], weights=ways[self.branch_parent[now]], minlength=len(ways)
            )
            level = self.order == order
            ways[level] = total[level].astype(np.int64)
        return ways


class TreeBuilder:
    """Collects the images of a source, order by order.

    Parameters
    ----------
    scene : Scene
        Geometry.
    source_m : (3,) float64
        The source [m].
    """

    def __init__(self, scene: Scene, source_m: FloatArray) -> None:
        self._planes, self._slack = scene.facets, scene.tolerance_m
        self.level_m = source_m[None, :]
        self._first = 0
        self._images = [self.level_m]
        self._branches: list[IntArray] = []  # image, plane, parent
        self._counts = [(1, 0, 0, 1)]

    def add_level(self, children: IntArray, *, considered: int, pruned: int) -> IntArray:
        """Add the images of the next order and return the image in its level that each child is.

        Parameters
        ----------
        children : (c, 2) int64
            Image of the last level and plane of each child, no pair twice.
        considered, pruned : int
            Sequences that were looked at to find them, and that no path can use.

        Returns
        -------
        (c,) int64
            Image of each child, counted within the new level.

        Raises
        ------
        GeometryError
            When the images would exceed ``MAX_IMAGES``.
        """
        p = self._planes
        normal, offset = p.plane_normal[children[:, 1]], p.plane_offset_m[children[:, 1]]
        parent_m = self.level_m[children[:, 0]]
        height = np.sum(parent_m * normal, axis=1) - offset
        place_m = parent_m - 2.0 * height[:, None] * normal
        kept, image_of = np.unique(weld(place_m, self._slack), return_inverse=True)
        first = self._first + len(self.level_m)
        if first + len(kept) > MAX_IMAGES:
            msg = (
                f"{first + len(kept)} images at order {len(self._images)} are more than "
                f"{MAX_IMAGES}; lower max_reflections, or simplify the mesh."
            )
            raise GeometryError(msg)
        parents = self._first + children[:, 0]
        self._branches.append(np.column_stack((first + image_of, children[:, 1], parents)))
        self._images.append(place_m[kept])
        merged = considered - pruned - len(kept)
        self._counts.append((considered, pruned, merged, len(kept)))
        self.level_m, self._first = place_m[kept], first
        return image_of.reshape(-1).astype(np.int64)

    def finish(self, *, region_m: FloatArray, opaque_facets: BoolArray) -> ImageTree:
        """Return the tree.

        Parameters
        ----------
        region_m : (2, 3) float64
            Box [m] that receivers must lie in.
        opaque_facets : (f,) bool
            Facets that were taken to let nothing through.

        Returns
        -------
        ImageTree
            All images so far.
        """
        image = np.concatenate(self._images)
        order = np.repeat(np.arange(len(self._images)), [len(level) for level in self._images])
        none = np.zeros((0, 3), dtype=np.int64)
        branches = np.concatenate(self._branches) if self._branches else none
        branches = branches[np.lexsort((branches[:, 1], branches[:, 0]))]
        start = np.searchsorted(branches[:, 0], np.arange(len(image) + 1))
        considered, pruned, merged, kept = np.array(self._counts, dtype=np.int64).T
        return ImageTree(
            source_m=image[0],
            image_m=frozen_array(image, name="image_m", shape=(None, 3)),
            order=order.astype(np.int64),
            branch_start=start.astype(np.int64),
            branch_plane=np.ascontiguousarray(branches[:, 1]),
            branch_parent=np.ascontiguousarray(branches[:, 2]),
            considered=considered,
            pruned=pruned,
            merged=merged,
            kept=kept,
            region_m=region_m,
            opaque_facets=opaque_facets,
        )
