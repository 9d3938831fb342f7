"""Complete enumeration of the images of a source: every reflection sequence that can carry a path.

Images are built per plane, order by order. A sequence is dropped only when no path can use it:

* the plane was the last one reflected by, or the image lies on it;
* all bodies, the source and all receivers lie on one side of the plane (a wall of the room) and the
  image on the other: the reflection would come from outside;
* the facet is of a closed opaque part, and would reflect on the side where the source is not;
* the beam from the image through what it reaches of the last facets misses every facet of the
  plane; beams are cut by convex hulls and never too tightly;
* all of the facet that the beam reaches is hidden behind one convex opaque facet.

docs/evidence/completeness.md proves that nothing else is lost. Sequences of one order that lead to
one point (two walls at right angles, in either order) are one image with several branches, of which
at most one carries a path to a receiver: all leave it in one direction, where the first facet met
decides.
"""

import math
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.blocks import Progress
from octant.em.records import TreeArrays
from octant.em.search import _image_kernels
from octant.em.search.budget import Budget, gather_blocks
from octant.em.search.dense import DenseBeams
from octant.em.search.facets import SearchFacets, search_facets
from octant.em.search.ray_share import RayShare
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries._plane_geometry import weld
from octant.geometries.errors import GeometryError
from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

MAX_IMAGES = 20_000_000
"""Images of one order beyond which a search stops with an error instead of filling the memory."""

IMAGE_BYTES, WINDOW_BYTES = 260.0, 260.0
"""Memory [B] that an image takes while its order is found, and its window where one is kept."""

DENSE_FACETS = 10_000
"""Facets [-] of a scene beyond which beams are cut into cells to find what they see."""

IMAGES_PER_BLOCK = 64
"""Images [-] whose beams one call of the kernel follows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageTree:
    """All images of a source up to an order, and how many sequences it took to find them.

    Parameters
    ----------
    source_m : (3,) float64 — The source [m]; it is image 0, of order 0.
    image_m : (n, 3) float64 — Position of each image [m], by ascending order.
    order : (n,) int64 — Number of reflections.
    branch_start : (n + 1,) int64 — Where each image's branches start, by ascending plane.
    branch_plane : (b,) int64 — Plane of a branch's last reflection.
    branch_parent : (b,) int64 — Image before that reflection.
    considered, pruned, merged, kept : (orders + 1,) int64 — Sequences looked at, of no use to a
        path, at another's point, and left: considered = pruned + merged + kept.
    region_m : (2, 3) float64 — Box [m] that receivers must lie in; infinite: anywhere.
    opaque_facets : (f,) bool — Facets that the search took to let nothing through.
    receivers_m : (m, 3) float64 or None — Receivers [m] that the images of the greatest order were
        searched for; None: for any in the region.
    rays : What share of the power is missing, where rays have found the images; None: none is.
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
    receivers_m: FloatArray | None = None
    rays: RayShare | None = None

    @property
    def max_order(self) -> int:
        """Greatest number of reflections that was searched."""
        return len(self.kept) - 1

    def kernel_arrays(self) -> TreeArrays:
        """Return the tree as the path kernels take it [m]."""
        arrays = TreeArrays(
            image=self.image_m,
            order=self.order,
            branch_start=self.branch_start,
            branches=np.column_stack((self.branch_plane, self.branch_parent)),
            leaves=np.arange(len(self.image_m)),
            ways=int(self._ways().max()),
            max_order=self.max_order,
        )
        return read_only(arrays)

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
    scene : Geometry.
    source_m : (3,) float64 — The source [m].
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
        children : (c, 2) int64 — Image of the last level and plane of each child, no pair twice.
        considered, pruned : Sequences looked at to find them, and those that no path can use.
        """
        p = self._planes
        normal, offset = p.plane_normal[children[:, 1]], p.plane_offset_m[children[:, 1]]
        parent_m = self.level_m[children[:, 0]]
        height = np.sum(parent_m * normal, axis=1) - offset
        place_m = parent_m - 2.0 * height[:, None] * normal
        kept, image_of = np.unique(weld(place_m, self._slack), return_inverse=True)
        first = self._first + len(self.level_m)
        parents = self._first + children[:, 0]
        self._branches.append(np.column_stack((first + image_of, children[:, 1], parents)))
        self._images.append(place_m[kept])
        merged = considered - pruned - len(kept)
        self._counts.append((considered, pruned, merged, len(kept)))
        self.level_m, self._first = place_m[kept], first
        return image_of.reshape(-1).astype(np.int64)

    def finish(
        self,
        *,
        region_m: FloatArray,
        opaque_facets: BoolArray,
        receivers_m: FloatArray | None = None,
        rays: RayShare | None = None,
    ) -> ImageTree:
        """Return the tree.

        Parameters
        ----------
        region_m : (2, 3) float64 — Box [m] that receivers must lie in.
        opaque_facets : (f,) bool — Facets that were taken to let nothing through.
        receivers_m : (m, 3) float64 — The only receivers [m] that it is for; None: any.
        rays : What is missing where rays have found the images.
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
            receivers_m=receivers_m,
            rays=rays,
        )


def search_images(
    scene: Scene,
    source_m: npt.ArrayLike,
    max_reflections: int,
    *,
    region_m: npt.ArrayLike | None = None,
    receivers_m: npt.ArrayLike | None = None,
    opaque_facets: npt.ArrayLike | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> ImageTree:
    """Return every image of a source that a path of up to so many reflections can use.

    Each image asks a hierarchy of facets what its beam reaches: cost grows with the images, not
    with images times planes. For meshes of thousands of planes only low orders stay tractable.

    Parameters
    ----------
    scene : Geometry.
    source_m : (3,) float — Place of the antenna [m], off every facet.
    max_reflections : Greatest order, >= 0.
    region_m : (2, 3) float — Box [m] of all receivers; None: the scene's bounds if the source is in
        a room, else everywhere. Smaller prunes more; a box from inside has 1, 6, 18 ... (4 n^2 +
        2).
    receivers_m : (m, 3) float — All receivers [m] there will be. Where there are more than
        `DENSE_FACETS` facets, images of the greatest order that reach none of them are left out.
    opaque_facets : (f,) bool — Facets that let nothing through [-]; None: all. Only they hide
        others, and only closed parts wholly of them reflect on one side alone.
    executor : Runs blocks of images, sharing memory; None: a thread per core. Same bits with any.
    progress : Called with (images done, images in all) for each order.
    """
    source = checked_source(scene, source_m, max_reflections)
    region = _region(scene, source, region_m)
    opaque = opaque_mask(scene, opaque_facets)
    facets = search_facets(scene, source, region, opaque)
    dense, receivers = None, None
    if len(opaque) > DENSE_FACETS:
        if receivers_m is not None:
            receivers = frozen_array(receivers_m, name="receivers_m", shape=(None, 3))
        dense = DenseBeams(scene, facets, opaque, receivers)
    search = _Search(
        scene,
        facets,
        source=source,
        region=region,
        dense=dense,
        executor=executor,
        progress=progress,
    )
    for order in range(1, max_reflections + 1):
        search.grow(order, last=order == max_reflections)
    return search.tree.finish(region_m=region, opaque_facets=opaque, receivers_m=receivers)


def checked_source(scene: Scene, source_m: npt.ArrayLike, max_reflections: int) -> FloatArray:
    """Return the source as a (3,) array [m], if it and the order can be searched.

    Parameters
    ----------
    scene : Geometry.
    source_m : (3,) float — Place of the antenna [m].
    max_reflections : Greatest order.
    """
    if max_reflections < 0:
        msg = f"max_reflections = {max_reflections} is negative; give 0 or more."
        raise GeometryError(msg)
    source = frozen_array(source_m, name="source_m", shape=(3,))
    # On a wall neither its side nor where its reflection leaves to would be defined.
    if np.isfinite(scene.distance_to_facets_m(source, within_m=scene.tolerance_m)[0]).any():
        x, y, z = source
        msg = (
            f"the source ({x:g}, {y:g}, {z:g}) m lies on a surface of the scene, where it has no "
            "side; move it off, as Scene.stand_off does."
        )
        raise GeometryError(msg)
    return source


def opaque_mask(scene: Scene, opaque_facets: npt.ArrayLike | None) -> BoolArray:
    """Return (f,) bool, which facets let nothing through: all when nothing is said.

    Parameters
    ----------
    scene : Geometry.
    opaque_facets : (f,) bool or None — What the caller was given [-].
    """
    count = len(scene.facets.facet_plane)
    given = np.ones(count) if opaque_facets is None else opaque_facets
    return frozen_array(given, name="opaque_facets", shape=(count,), dtype=np.bool_)


def _region(scene: Scene, source: FloatArray, region_m: npt.ArrayLike | None) -> FloatArray:
    if region_m is not None:
        return frozen_array(region_m, name="region_m", shape=(2, 3), finite=False)
    slack = scene.tolerance_m
    low, high = scene.bounds_m
    if scene.has_room and bool((source > low - slack).all() and (source < high + slack).all()):
        return frozen_array(scene.bounds_m, name="region_m", shape=(2, 3))
    everywhere = np.array([[-math.inf] * 3, [math.inf] * 3])
    return frozen_array(everywhere, name="region_m", shape=(2, 3), finite=False)


class _Search:
    """The images found so far, order by order."""

    def __init__(
        self,
        scene: Scene,
        facets: SearchFacets,
        *,
        source: FloatArray,
        region: FloatArray,
        dense: DenseBeams | None,
        executor: Executor | None,
        progress: Progress | None,
    ) -> None:
        self.region, self.executor, self.progress = region, executor, progress
        self.planes, self.facets = scene.facets, facets
        self.slack = scene.tolerance_m
        self.tree = TreeBuilder(scene, source)
        self.dense = dense
        self.windows = (
            np.zeros(2, np.int64),
            np.zeros(0, np.int64),
            np.zeros(1, np.int64),
            np.zeros((0, 3)),
        )

    def grow(self, order: int, *, last: bool) -> None:
        """Add the images of the next order."""
        considered = len(self.tree.level_m) * len(self.planes.plane_normal)
        budget = Budget(
            f"images of the source at order {order}",
            most=MAX_IMAGES,
            each_bytes=IMAGE_BYTES + WINDOW_BYTES * (not last),
            advice='lower max_reflections, or take search = "rays"',
        )
        children, windows, corners = self._expand(budget, last=last)
        image_of = self.tree.add_level(
            children, considered=considered, pruned=considered - len(children)
        )
        self.windows = _windows_by_image(windows, corners, image_of, len(self.tree.level_m))

    def _expand(self, budget: Budget, *, last: bool) -> tuple[IntArray, IntArray, FloatArray]:
        """Return children, windows and corners of the level, found block by block."""
        p, f = self.planes, self.facets
        start, *windows = read_only(self.windows)
        images = read_only(np.ascontiguousarray(self.tree.level_m))
        known = read_only(
            (
                p.plane_normal,
                p.plane_offset_m,
                p.facet_plane,
                f.side,
                f.occluder_area_m2,
                f.hull_start,
                f.hulls_m,
                f.boxes,
                f.links,
                f.order,
            )
        )

        def work(begin: int, end: int) -> tuple[IntArray, IntArray, FloatArray]:
            here = images[begin:end], start[begin : end + 1], *windows
            if self.dense:
                children, kept, corners = self.dense.expand(here, last=last)
            else:
                children, kept, corners = _image_kernels.expand(
                    *here, *known, self.slack, f.margin_m, not last
                )
            children[:, 0] += begin
            return children, kept, corners

        found = gather_blocks(
            work,
            len(images),
            budget,
            block_size=IMAGES_PER_BLOCK,
            executor=self.executor,
            progress=self.progress,
        )
        none = np.zeros((0, 2), np.int64), np.zeros((0, 3), np.int64), np.zeros((0, 3))
        parts = [none, *found]
        sizes = np.cumsum([0, *(len(children) for children, _, _ in parts)])
        for part, before in zip(parts, sizes, strict=False):
            part[1][:, 0] += before
        first, second, third = zip(*parts, strict=True)
        return np.concatenate(first), np.concatenate(second), np.concatenate(third)


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
