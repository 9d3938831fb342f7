"""Images found by launched rays: for dense meshes, where a complete search is out of reach.

Rays are mirrored where they meet a facet. Each sequence of planes that some ray followed becomes an
image, with all that led to it, and the exact path stage takes the tree as any other: its paths are
exact, but what no ray met is missing. Independent sets of rays say how much that may be
(`octant.em.search.ray_share`), and more are launched until it is little enough.
"""

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em.blocks import Progress, run_blocks
from octant.em.search import _ray_kernels
from octant.em.search.images import MAX_IMAGES, ImageTree, TreeBuilder, checked_source, opaque_mask
from octant.em.search.once import once
from octant.em.search.ray_share import RayShare, estimated_share
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries._plane_geometry import row_numbers
from octant.geometries.errors import GeometryError
from octant.geometries.occlusion import build_bvh
from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

DEFAULT_RAYS = 1_000_000
"""Rays [-] of a launch: 80,000 per steradian, 30 mm apart at 8 m."""

MOST_RAYS = 100_000_000
"""Rays [-] beyond which no more are launched, whatever may be missing."""

SETS = 8
"""Independent sets [-] of the first launch; each further one doubles them."""

RAYS_PER_BLOCK = 16_384
"""Rays [-] whose sequences one call of the kernel collects."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RaySearch:
    """The images that rays have found.

    Parameters
    ----------
    tree : Images; complete for no receiver. Its ``rays`` say what share of the power is missing.
    rays : Rays launched.
    found : (orders + 1,) int64 — Sequences of planes that rays followed.
    """

    tree: ImageTree
    rays: int
    found: IntArray

    @property
    def rays_per_sr(self) -> float:
        """Density of the launch [1/sr]."""
        return self.rays / (4.0 * math.pi)


class _Met(NamedTuple):
    """Sequences of planes as a tree, parents before children, and what rays bring after them."""

    nodes: IntArray  # (k, 3): parent, plane, order
    power: FloatArray  # (k,)
    sets: IntArray  # (k, 2): first and last set that met it


def ray_search(
    scene: Scene,
    source_m: npt.ArrayLike,
    max_reflections: int,
    *,
    rays: int = DEFAULT_RAYS,
    tolerance_db: float | None = None,
    opaque_facets: npt.ArrayLike | None = None,
    wall_powers: FloatArray | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> RaySearch:
    """Return the images of a source that launched rays find. They are not complete.

    Directions are spherical Fibonacci lattices (Swinbank and Purser, 2006), each turned at random,
    the same way every time. Small far facets and high orders over curved meshes are met by chance.
    The tree serves all receivers. Time grows with rays times orders, memory with the sequences
    found. How much is missing, `octant.em.search.ray_share` estimates.

    Parameters
    ----------
    scene : Geometry, of any number of triangles.
    source_m : (3,) float — Place of the antenna [m], off every facet.
    max_reflections : Greatest order, >= 0.
    rays : Rays to launch, >= `SETS`, rounded down to a multiple of it.
    tolerance_db : By how much [dB] the power may be too low at most: as long as the bound of what
        is missing is greater, as many rays again are launched, up to `MOST_RAYS`. None: once only.
    opaque_facets : (f,) bool — Facets that let nothing through [-]; rays both pass and are
        reflected by the others. None: all.
    wall_powers : (materials, 2, 2, n) float64 — What walls do to power, as `ray_share.wall_powers`
        returns it [-]; None: they reflect, and the others let through, all of it.
    executor : Runs blocks of rays, sharing memory; None: a thread per core. The same bits with any.
    progress : Called with (rays done, rays in all).
    """
    source = checked_source(scene, source_m, max_reflections)
    if rays < SETS:
        msg = f"rays = {rays} are too few to estimate what is missing; launch {SETS} or more."
        raise GeometryError(msg)
    opaque = opaque_mask(scene, opaque_facets)
    launch = _Launch(
        scene,
        source,
        max_order=max_reflections,
        rays_per_set=rays // SETS,
        clear=~opaque,
        wall_powers=wall_powers,
        executor=executor,
        progress=progress,
    )
    share = launch.more(SETS, tolerance_db)
    while not (share.suffices or 2 * share.rays > MOST_RAYS or launch.count > MAX_IMAGES // 2):
        share = launch.more(share.sets, tolerance_db)
    order = launch.met.nodes[:, 2]
    return RaySearch(
        tree=launch.tree(scene, opaque, share),
        rays=share.rays,
        found=np.bincount(order, minlength=max_reflections + 1).astype(np.int64),
    )


def launch_directions(begin: int, end: int, count: int) -> FloatArray:
    """Return directions begin to end of a spherical Fibonacci lattice, (n, 3) [-].

    Parameters
    ----------
    begin, end : Rows that are wanted.
    count : Directions of the whole lattice.
    """
    i = np.arange(begin, end, dtype=np.float64)
    z = 1.0 - (2.0 * i + 1.0) / count
    azimuth = math.pi * (3.0 - math.sqrt(5.0)) * i
    across = np.sqrt(1.0 - z * z)
    return np.column_stack((across * np.cos(azimuth), across * np.sin(azimuth), z))


def _turn(number: int) -> FloatArray:
    """Return the rotation (3, 3) [-] of a set's lattice: any, but always the same."""
    w, x, y, z = np.random.default_rng(number).normal(size=4)
    square = w * w + x * x + y * y + z * z
    turned = [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    rotation: FloatArray = np.array(turned) / square
    return rotation


class _Launch:
    """The sets of rays launched so far, and what they have met."""

    def __init__(
        self,
        scene: Scene,
        source: FloatArray,
        *,
        max_order: int,
        rays_per_set: int,
        clear: npt.NDArray[np.bool_],
        wall_powers: FloatArray | None,
        executor: Executor | None,
        progress: Progress | None,
    ) -> None:
        f = scene.facets
        # A plane lets rays pass where one of its facets does: too many candidates, never too few.
        clear_planes = np.zeros(len(f.plane_normal), dtype=np.bool_)
        clear_planes[f.facet_plane[clear]] = True
        walls = (
            np.ones((len(scene.material_names), 2, 2, 1)) if wall_powers is None else wall_powers
        )
        box = np.stack(
            (np.minimum(scene.bounds_m[0], source), np.maximum(scene.bounds_m[1], source))
        )
        by_facet = once(
            scene,
            "triangles by facet",
            lambda: build_bvh(
                scene.triangle_corners_m, scene.triangle_facet, extent_m=scene.extent_m
            ),
        )
        self._known = read_only(
            (
                by_facet,
                f.facet_plane,
                clear_planes,
                f.plane_normal,
                scene.facet_front,
                f.facet_material,
                np.ascontiguousarray(walls),
                box,
            )
        )
        self._source, self._max_order, self._rays_per_set = source, max_order, rays_per_set
        self._executor, self._progress = executor, progress
        self._set_power = np.zeros(0)
        self.met = _Met(np.array([[-1, -1, 0]]), np.zeros(1), np.zeros((1, 2), dtype=np.int64))

    @property
    def count(self) -> int:
        """Sequences met so far."""
        return len(self.met.nodes)

    def more(self, sets: int, tolerance_db: float | None) -> RayShare:
        """Launch further sets and return what share of the power is missing."""
        first, n = len(self._set_power), self._rays_per_set
        begins = [
            (k, row) for k in range(first, first + sets) for row in range(0, n, RAYS_PER_BLOCK)
        ]
        found: dict[int, _Met] = {}

        def work(begin: int, end: int) -> None:
            for block in range(begin, end):
                number, row = begins[block]
                found[block] = self._launched(number, row, min(row + RAYS_PER_BLOCK, n))

        def report(done: int, total: int) -> None:
            if self._progress is not None:
                rays = (first + sets) * n
                self._progress(first * n + done * sets * n // total, rays)

        power = np.zeros(sets)
        if self._max_order:
            run_blocks(work, len(begins), block_size=1, executor=self._executor, progress=report)
            for block, (number, _) in enumerate(begins):
                power[number - first] += found[block].power.sum()
            parts = [self.met, *(found[block] for block in range(len(begins)))]
            self.met = _united(parts, self._max_order)
        self._set_power = np.concatenate((self._set_power, power))
        return estimated_share(
            self.met.power[1:],
            self.met.sets[1:],
            self._set_power,
            rays=(first + sets) * n,
            tolerance_db=tolerance_db,
        )

    def tree(self, scene: Scene, opaque: npt.NDArray[np.bool_], share: RayShare) -> ImageTree:
        """Return the images of all sequences."""
        builder, nodes = TreeBuilder(scene, self._source), self.met.nodes
        image_of = np.zeros(len(nodes), dtype=np.int64)
        for order in range(1, self._max_order + 1):
            here = np.flatnonzero(nodes[:, 2] == order)
            pairs = np.column_stack((image_of[nodes[here, 0]], nodes[here, 1]))
            number, start, member = row_numbers(pairs)
            images = builder.add_level(pairs[member[start[:-1]]], considered=len(here), pruned=0)
            image_of[here] = images[number]
        everywhere = np.array([[-math.inf] * 3, [math.inf] * 3])
        region = frozen_array(everywhere, name="region_m", shape=(2, 3), finite=False)
        return builder.finish(region_m=region, opaque_facets=opaque, rays=share)

    def _launched(self, number: int, begin: int, end: int) -> _Met:
        directions = launch_directions(begin, end, self._rays_per_set) @ _turn(number).T
        nodes, power = _ray_kernels.launch(self._source, directions, *self._known, self._max_order)
        return _Met(nodes, power, np.full((len(nodes), 2), number))


def _united(parts: Sequence[_Met], max_order: int) -> _Met:
    """Return the sequences of all parts as one tree, each once, parents before children."""
    sizes = [len(part.nodes) for part in parts]
    nodes, power, sets = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    offset = np.repeat(np.cumsum(sizes) - sizes, sizes)
    place = np.zeros(len(nodes), dtype=np.int64)  # of each part's sequence in the united tree
    rows, first = [np.array([[-1, -1, 0]])], 1
    for order in range(1, max_order + 1):
        here = np.flatnonzero(nodes[:, 2] == order)
        parent = place[nodes[here, 0] + offset[here]]
        number, start, member = row_numbers(np.column_stack((parent, nodes[here, 1])))
        place[here] = first + number
        one = member[start[:-1]]
        rows.append(np.column_stack((parent[one], nodes[here[one], 1], np.full(len(one), order))))
        first += len(one)
    total = np.zeros(first)
    np.add.at(total, place, power)
    span = np.column_stack((np.full(first, np.iinfo(np.int64).max), np.full(first, -1)))
    np.minimum.at(span[:, 0], place, sets[:, 0])
    np.maximum.at(span[:, 1], place, sets[:, 1])
    return _Met(np.concatenate(rows), total, span)
