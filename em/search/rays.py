"""Images found by launched rays: for dense meshes, where a complete search is out of reach.

Rays are mirrored where they meet a facet. Each sequence of planes that some ray followed becomes an
image, with all that led to it, and the exact path stage takes the tree as any other: its paths are
exact, but what no ray met is missing. Two independent sets of rays say how much that may be.
"""

import math
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.blocks import Progress, run_blocks
from octant.em.search import _ray_kernels
from octant.em.search.images import ImageTree, TreeBuilder, checked_source, opaque_mask
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries._plane_geometry import row_numbers
from octant.geometries.errors import GeometryError
from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

DEFAULT_RAYS = 1_000_000
"""Rays [-] of a launch: 80,000 per steradian, 30 mm apart at 8 m."""

RAYS_PER_BLOCK = 16_384
"""Rays [-] whose sequences one call of the kernel collects."""

_TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
"""Rotation [-] of the second half's lattice against the first's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RaySearch:
    """The images that rays have found, and how many they may have missed.

    Parameters
    ----------
    tree : Images; complete for no receiver.
    rays : Rays launched, half of them in each of two independent sets.
    found, found_by_both : (orders + 1,) int64 — Sequences that rays, and both halves, followed.
    found_by_half : (orders + 1, 2) int64 — Sequences that each half of the rays followed.
    met_once, met_twice : (orders + 1,) int64 — Sequences that one ray, or two, of all followed.
    """

    tree: ImageTree
    rays: int
    found: IntArray
    found_by_half: IntArray
    found_by_both: IntArray
    met_once: IntArray
    met_twice: IntArray

    @property
    def rays_per_sr(self) -> float:
        """Density of the launch [1/sr]."""
        return self.rays / (4.0 * math.pi)

    @property
    def estimated_total(self) -> FloatArray:
        """Least number of sequences that there are per order, (orders + 1,) [-].

        The greater of Chapman's (1951) estimate by capture and recapture and Chao's (1984) by
        sequences met once and twice; both fall short where some are met more easily.
        """
        a, b = self.found_by_half.T.astype(np.float64)
        recapture = (a + 1.0) * (b + 1.0) / (self.found_by_both + 1.0) - 1.0
        once, twice = self.met_once.astype(np.float64), self.met_twice
        chao = self.found + once * (once - 1.0) / (2.0 * (twice + 1.0))
        total: FloatArray = np.maximum(self.found, np.maximum(recapture, chao))
        return total

    @property
    def unseen_share(self) -> FloatArray:
        """Share of all launch directions that belong to sequences not found, (orders + 1,) [-].

        Good's (1953) estimate: the sequences met by one ray, per ray. Those not found are narrow: a
        receiver meets one of their paths about as seldom as a ray did.
        """
        share: FloatArray = self.met_once / float(self.rays)
        return share


def ray_search(
    scene: Scene,
    source_m: npt.ArrayLike,
    max_reflections: int,
    *,
    rays: int = DEFAULT_RAYS,
    opaque_facets: npt.ArrayLike | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> RaySearch:
    """Return the images of a source that launched rays find. They are not complete.

    Directions are two spherical Fibonacci lattices (Swinbank and Purser, 2006), one turned. A
    sequence is sure to be met only when its beam is wider than the rays' spacing, sqrt(4 pi / rays)
    rad, at its narrowest; small far facets and high orders over curved meshes are met by chance.
    The tree serves all receivers. Time grows with rays times orders, memory with the sequences
    found. Estimates: D. G. Chapman, Univ. California Publ. Stat. 1, 1951, p. 131; A. Chao, Scand.
    J. Statist. 11, 1984, p. 265; I. J. Good, Biometrika 40, 1953, p. 237, equation 9.

    Parameters
    ----------
    scene : Geometry, of any number of triangles.
    source_m : (3,) float — Place of the antenna [m], off every facet.
    max_reflections : Greatest order, >= 0.
    rays : Rays to launch, >= 2; an odd number is rounded down.
    opaque_facets : (f,) bool — Facets that let nothing through [-]; rays both pass and are
        reflected by the others. None: all.
    executor : Runs blocks of rays, sharing memory; None: a thread per core. The same bits with any.
    progress : Called with (rays done, rays in all).
    """
    source = checked_source(scene, source_m, max_reflections)
    if rays < 2:
        msg = f"rays = {rays} are too few to estimate what is missing; launch 2 or more."
        raise GeometryError(msg)
    opaque = opaque_mask(scene, opaque_facets)
    nodes, met = _sequences(
        scene,
        source,
        max_order=max_reflections,
        rays_per_half=rays // 2,
        clear=~opaque,
        executor=executor,
        progress=progress,
    )
    tree = _tree(scene, source, nodes, max_reflections, opaque)
    by_order = [met[nodes[:, 2] == order] for order in range(max_reflections + 1)]
    return RaySearch(
        tree=tree,
        rays=2 * (rays // 2),
        found=np.array([len(m) for m in by_order]),
        found_by_half=np.array([(m > 0).sum(axis=0) for m in by_order]),
        found_by_both=np.array([(m > 0).all(axis=1).sum() for m in by_order]),
        met_once=np.array([(m.sum(axis=1) == 1).sum() for m in by_order]),
        met_twice=np.array([(m.sum(axis=1) == 2).sum() for m in by_order]),
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


def _sequences(
    scene: Scene,
    source: FloatArray,
    *,
    max_order: int,
    rays_per_half: int,
    clear: npt.NDArray[np.bool_],
    executor: Executor | None,
    progress: Progress | None,
) -> tuple[IntArray, IntArray]:
    """Return (k, 3) parent, plane and order of each sequence met, by order, and (k, 2) its rays."""
    bvh, plane_normal = read_only((scene.bvh, scene.facets.plane_normal))
    found: dict[int, tuple[IntArray, IntArray]] = {}
    # A plane lets rays pass wherever one of its facets does: too many candidates, never too few.
    clear_planes = np.zeros(len(plane_normal), dtype=np.bool_)
    clear_planes[scene.facets.facet_plane[clear]] = True

    def work(begin: int, end: int) -> None:
        half, offset = divmod(begin, rays_per_half)
        directions = launch_directions(offset, offset + end - begin, rays_per_half)
        found[begin] = _ray_kernels.launch(
            source,
            directions @ _TURN.T if half else directions,
            half,
            bvh.boxes,
            bvh.links,
            bvh.triangles,
            bvh.planes,
            clear_planes,
            plane_normal,
            max_order,
        )

    for half in range(2 if max_order else 0):
        first = half * rays_per_half

        def block(begin: int, end: int, first: int = first) -> None:
            work(first + begin, first + end)

        def report(done: int, _: int, first: int = first) -> None:
            if progress is not None:
                progress(first + done, 2 * rays_per_half)

        run_blocks(
            block, rays_per_half, block_size=RAYS_PER_BLOCK, executor=executor, progress=report
        )
    return _united([found[begin] for begin in sorted(found)], max_order, rays_per_half)


def _united(
    blocks: list[tuple[IntArray, IntArray]], max_order: int, rays_per_half: int
) -> tuple[IntArray, IntArray]:
    """Return the sequences of all blocks as one tree, each once, parents before children."""
    sizes = [len(nodes) for nodes, _ in blocks]
    nodes = np.concatenate([np.zeros((0, 3), np.int64), *(block for block, _ in blocks)])
    met = np.concatenate([np.zeros((0, 2), np.int64), *(counts for _, counts in blocks)])
    offset = np.repeat(np.cumsum(sizes) - sizes, sizes)
    place = np.zeros(len(nodes), dtype=np.int64)  # of each block's sequence in the united tree
    rows = [np.array([[-1, -1, 0]])]
    counts = [np.array([[rays_per_half, rays_per_half]])]
    first = 1
    for order in range(1, max_order + 1):
        here = np.flatnonzero(nodes[:, 2] == order)
        parent = place[nodes[here, 0] + offset[here]]
        number, start, member = row_numbers(np.column_stack((parent, nodes[here, 1])))
        place[here] = first + number
        total = np.zeros((len(start) - 1, 2), dtype=np.int64)
        np.add.at(total, number, met[here])
        one = member[start[:-1]]
        level = np.column_stack((parent[one], nodes[here[one], 1], np.full(len(one), order)))
        rows.append(level)
        counts.append(total)
        first += len(one)
    return np.concatenate(rows), np.concatenate(counts)


def _tree(
    scene: Scene, source: FloatArray, nodes: IntArray, max_order: int, opaque: npt.NDArray[np.bool_]
) -> ImageTree:
    """Return the images of all sequences."""
    builder = TreeBuilder(scene, source)
    image_of = np.zeros(len(nodes), dtype=np.int64)
    for order in range(1, max_order + 1):
        here = np.flatnonzero(nodes[:, 2] == order)
        pairs = np.column_stack((image_of[nodes[here, 0]], nodes[here, 1]))
        number, start, member = row_numbers(pairs)
        images = builder.add_level(pairs[member[start[:-1]]], considered=len(here), pruned=0)
        image_of[here] = images[number]
    everywhere = np.array([[-math.inf] * 3, [math.inf] * 3])
    region = frozen_array(everywhere, name="region_m", shape=(2, 3), finite=False)
    return builder.finish(region_m=region, opaque_facets=opaque)
