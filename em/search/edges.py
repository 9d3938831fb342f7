"""Complete enumeration of the routes over an edge: reflections, a diffraction, reflections.

What comes before the edge is an image of the source, what comes after it an image of the edge. A
combination is dropped only when no path can use it:

* the source's image stands outside the wedge's sector of air, or sees no part of the edge through
  the facets that it was mirrored by;
* a plane after the edge has no facet in the sector, lies through the edge, or (a wall of the room)
  would reflect from outside;
* a further plane has no facet on the side to which the one before it reflects.
"""

import math
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.records import CHUNK, EdgeTreeArrays
from octant.em.search import _edge_kernels, _sight_kernels
from octant.em.search.budget import Budget, gather_blocks
from octant.em.search.facets import SearchFacets, inner_sides, search_facets
from octant.em.search.images import ImageTree
from octant.geometries import _bvh_kernels
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries.errors import GeometryError
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.geometries.wedges import ANGLE_TOLERANCE_RAD, Wedges

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MAX_NODES = 20_000_000
"""Routes over edges beyond which a search stops with an error instead of filling the memory."""

ROUTE_BYTES, EDGE_IMAGE_BYTES = 160.0, 400.0
"""Memory [B] that a route over an edge, and an image of an edge, takes while they are found."""

IMAGES_PER_BLOCK = 64
"""Images [-] of the source, or of edges, that one call of a kernel follows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EdgeTree:
    """All routes from a source over one edge, or two, as images of the edges.

    Parameters
    ----------
    wedge : (k,) int64 — Wedge that diffracts last, of each edge image.
    frame : (k, 12) float64 — Its origin [m], axis, tangent, normal [-], mirrored.
    plane_start : (k + 1,) int64 — Where in ``plane`` those of each edge image start.
    plane : (s,) int64 — Planes that reflect between edge and receiver, in that order.
    node_start : (k + 1,) int64 — Where the source images that light each edge image start.
    leaf : (n,) int64 — Image of the source.
    first : (n,) int64 — Wedge that diffracts before the last one, or -1.
    source_m : (n, 2) float64 — Source image's distance from the first edge, and place along it [m].
    reach_m : (n, 2) float64 — Part of the last edge that can be lit, from and to [m].
    considered, kept : Combinations of source image, wedges and planes looked at, and left.
    max_order : Greatest number of interactions of a path over the edges.
    """

    wedge: IntArray
    frame: FloatArray
    plane_start: IntArray
    plane: IntArray
    node_start: IntArray
    leaf: IntArray
    first: IntArray
    source_m: FloatArray
    reach_m: FloatArray
    considered: int
    kept: int
    max_order: int

    def kernel_arrays(self, ways: int) -> EdgeTreeArrays:
        """Return the tree as the path kernels take it [m].

        Parameters
        ----------
        ways : Greatest number of paths that one image of the source can give.
        """
        largest = int(np.diff(self.node_start).max(initial=0))
        arrays = EdgeTreeArrays(
            wedge=self.wedge,
            frame=self.frame,
            plane_start=self.plane_start,
            planes=self.plane,
            node_start=self.node_start,
            leaf=self.leaf,
            first=self.first,
            source=self.source_m,
            reach=self.reach_m,
            ways=ways,
            rows=max(CHUNK, largest * ways) if len(self.wedge) else 0,
            max_order=self.max_order,
        )
        return read_only(arrays)


def no_edges() -> EdgeTree:
    """Return an empty tree: no route leads over any edge."""
    whole, pairs = np.zeros(0, dtype=np.int64), np.zeros((0, 2))
    return EdgeTree(
        wedge=whole,
        frame=np.zeros((0, 12)),
        plane_start=np.zeros(1, dtype=np.int64),
        plane=whole,
        node_start=np.zeros(1, dtype=np.int64),
        leaf=whole,
        first=whole,
        source_m=pairs,
        reach_m=pairs,
        considered=0,
        kept=0,
        max_order=0,
    )


def wedge_frames(wedges: Wedges) -> FloatArray:
    """Return (w, 16): origin [m], axis, tangent, normal [-], air [rad], length [m], tips of wedges.

    Parameters
    ----------
    wedges : Wedges of a scene.
    """
    return np.column_stack(
        (
            wedges.origin_m,
            wedges.axis,
            wedges.tangent,
            wedges.normal,
            wedges.exterior_rad,
            wedges.length_m,
            wedges.tips,
        )
    )


def search_edges(
    scene: Scene,
    wedges: Wedges,
    tree: ImageTree,
    *,
    max_diffractions: int = 1,
    executor: Executor | None = None,
) -> EdgeTree:
    """Return every route from a source over the edges of a scene that a path can use.

    With single diffractions alone the cost grows with what images light of the edges; each further
    reflection multiplies it by the planes that an edge sees.

    Parameters
    ----------
    scene : Geometry.
    wedges : Its wedges, or those of them that shall diffract.
    tree : Images of the source; its order bounds a path's interactions, but for diffractions alone.
    max_diffractions : Diffractions of a path: 1, or 2 for those over two edges as well: of one
        facet (the top of a cabinet, both rims of a plate), or apart and in sight of each other.
    executor : Runs blocks of the work, sharing memory; None: a thread per core. Same bits with any.
    """
    if max_diffractions not in (1, 2):
        msg = f"max_diffractions = {max_diffractions} is not available; give 1 or 2."
        raise GeometryError(msg)
    hulls = search_facets(scene, tree.source_m, tree.region_m, tree.opaque_facets)
    light = _light(scene, wedges, tree, hulls, executor)
    images = _EdgeImages(scene, wedges, tree, hulls, executor)
    for _ in range(tree.max_order - 1):
        images.grow()
    pairs = np.zeros((0, 2), dtype=np.int64)
    if max_diffractions > 1:
        pairs = np.concatenate(
            (
                _pairs_over_a_facet(wedges, tree),
                _pairs_in_sight(scene, wedges, tree, hulls, executor),
            )
        )
    return _combine(images, tree, light, pairs, max_diffractions)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Light:
    """Which images light which edges, by wedge and then by image.

    Parameters
    ----------
    start : (w + 1,) int64 — Where the images of each wedge start.
    leaf : (n,) int64 — Image of the source.
    reach_m : (n, 2) float64 — Part of the edge that it lights, from and to [m].
    source_m : (n, 2) float64 — The image's distance from the edge and place along it [m].
    """

    start: IntArray
    leaf: IntArray
    reach_m: FloatArray
    source_m: FloatArray

    def counts(self, order: IntArray, most: int) -> IntArray:
        """Return (w,) how many images of at most so many reflections light each wedge."""
        # Images stand by their order, so that those are the first of each wedge.
        before = np.concatenate(([0], np.cumsum(order[self.leaf] <= most)))
        number: IntArray = np.diff(before[self.start])
        return number


def _light(
    scene: Scene,
    wedges: Wedges,
    tree: ImageTree,
    hulls: SearchFacets,
    executor: Executor | None,
) -> _Light:
    """Return what those images light that leave a path the bend at an edge."""
    f, frame = scene.facets, wedge_frames(wedges)
    order, boxes, links = _edge_hierarchy(frame)
    known = read_only(
        (
            tree.image_m,
            tree.order,
            tree.branch_start,
            np.column_stack((tree.branch_plane, tree.branch_parent)),
            np.column_stack((f.plane_normal, f.plane_offset_m)),
            f.plane_facet_start,
            hulls.hull_start,
            hulls.hulls_m,
            frame,
            boxes,
            links,
            order,
        )
    )
    budget = _budget("pairs of an image and an edge that it lights", wedges, tree, ROUTE_BYTES)

    def work(begin: int, end: int) -> tuple[IntArray, FloatArray]:
        lit: tuple[IntArray, FloatArray] = _edge_kernels.light_edges(
            *known, begin, end, scene.tolerance_m
        )
        return lit

    count = int(np.searchsorted(tree.order, max(tree.max_order, 1)))
    parts = gather_blocks(work, count, budget, block_size=IMAGES_PER_BLOCK, executor=executor)
    pairs = np.concatenate([np.zeros((0, 2), np.int64), *(part[0] for part in parts)])
    found = np.concatenate([np.zeros((0, 4)), *(part[1] for part in parts)])
    row = np.lexsort((pairs[:, 0], pairs[:, 1]))
    return _Light(
        start=np.searchsorted(pairs[row, 1], np.arange(len(wedges) + 1)),
        leaf=pairs[row, 0],
        reach_m=found[row, :2],
        source_m=found[row, 2:],
    )


def _edge_hierarchy(frame: FloatArray) -> tuple[IntArray, FloatArray, IntArray]:
    """Return order, boxes and links of a hierarchy over edges, of their frames."""
    ends = np.stack((frame[:, :3], frame[:, :3] + frame[:, 13:14] * frame[:, 3:6]))
    hierarchy: tuple[IntArray, FloatArray, IntArray] = _bvh_kernels.build(
        ends.min(axis=0), ends.max(axis=0)
    )
    return hierarchy


def _budget(
    what: str,
    wedges: Wedges,
    tree: ImageTree,
    each_bytes: float,
    advice: str = "lower max_reflections, or leave diffraction out",
) -> Budget:
    """Return the bound on what the search finds over so many edges and images."""
    return Budget(
        f"{what}, over {len(wedges)} edges with {len(tree.image_m)} images of the source",
        most=MAX_NODES,
        each_bytes=each_bytes,
        advice=advice,
    )


def _pairs_over_a_facet(wedges: Wedges, tree: ImageTree) -> IntArray:
    """Return (p, 2) wedges, first and last, that bound one side of a facet at different edges."""
    normals = wedges.face_normals
    facet, side = wedges.facets.reshape(-1), np.tile([0, 1], len(wedges))
    wedge = np.repeat(np.arange(len(wedges)), 2)
    by_facet = np.argsort(facet, kind="stable")
    start = np.searchsorted(facet[by_facet], facet)
    size = np.searchsorted(facet[by_facet], facet, side="right") - start
    _budget("pairs of edges of one facet", wedges, tree, ROUTE_BYTES).add(int(size.sum()))
    one = np.repeat(np.arange(len(facet)), size)
    other = by_facet[expanded(start, size)]
    same = np.sum(normals[wedge[one], side[one]] * normals[wedge[other], side[other]], axis=1) > 0.0
    first, last = np.unique(np.column_stack((wedge[one], wedge[other]))[same], axis=0).T
    # Edges of one line do not see one another over the facet.
    offset = wedges.origin_m[last] - wedges.origin_m[first]
    aside = np.linalg.norm(np.cross(offset, wedges.axis[first]), axis=1)
    parallel = np.linalg.norm(np.cross(wedges.axis[last], wedges.axis[first]), axis=1)
    apart = wedges.edge[first] != wedges.edge[last]
    apart &= (aside > LENGTHS.same_m) | (parallel > 1e-9)
    pairs: IntArray = np.column_stack((first, last))[apart]
    return pairs


def _pairs_in_sight(
    scene: Scene, wedges: Wedges, tree: ImageTree, hulls: SearchFacets, executor: Executor | None
) -> IntArray:
    """Return (p, 2) wedges, first and last, that bend outwards, apart and in sight."""
    outer = np.flatnonzero(wedges.exterior_rad > math.pi + ANGLE_TOLERANCE_RAD)
    f, frame = scene.facets, wedge_frames(wedges)[outer]
    order, boxes, links = _edge_hierarchy(frame)
    known = read_only(
        (
            frame,
            wedges.face_normals[outer],
            wedges.facets[outer],
            boxes,
            links,
            order,
            scene.bvh.boxes,
            scene.bvh.links,
            scene.bvh.triangles,
            scene.bvh.planes,
            np.column_stack((f.plane_normal, f.plane_offset_m)),
            f.plane_facet_start,
            hulls.occluder_area_m2,
            hulls.hull_start,
            hulls.hulls_m,
        )
    )

    def work(begin: int, end: int) -> tuple[IntArray]:
        return (_sight_kernels.edges_in_sight(*known, begin, end, scene.tolerance_m),)

    budget = _budget(
        "pairs of edges that see one another",
        wedges,
        tree,
        ROUTE_BYTES,
        "give max_diffractions = 1",
    )
    parts = gather_blocks(work, len(outer), budget, block_size=IMAGES_PER_BLOCK, executor=executor)
    pairs = outer[np.concatenate([np.zeros((0, 2), np.int64), *(part[0] for part in parts)])]
    both: IntArray = np.concatenate((pairs, pairs[:, ::-1]))
    return both


def expanded(start: IntArray, size: IntArray) -> IntArray:
    """Return the whole numbers of ranges, one range after the other [-].

    Parameters
    ----------
    start, size : (k,) int64 — First number of each range, and how many [-].
    """
    before = np.cumsum(size) - size
    numbers: IntArray = np.repeat(start - before, size) + np.arange(int(size.sum()))
    return numbers


class _EdgeImages:
    """Edges mirrored by sequences of planes, level by level."""

    def __init__(
        self,
        scene: Scene,
        wedges: Wedges,
        tree: ImageTree,
        hulls: SearchFacets,
        executor: Executor | None,
    ) -> None:
        f = scene.facets
        self.planes = np.column_stack((f.plane_normal, f.plane_offset_m))
        self.executor, self.slack_m = executor, scene.tolerance_m
        self.known = read_only(
            (
                wedge_frames(wedges),
                wedges.face_normals,
                self.planes,
                inner_sides(scene, tree.source_m, tree.region_m),
                hulls.hull_start[f.plane_facet_start],
                hulls.hulls_m,
            )
        )
        self.wedges = wedges
        self.wedge = [np.arange(len(wedges))]
        self.frame = [
            np.column_stack((wedges.origin_m, wedges.axis, wedges.tangent, wedges.normal))
        ]
        self.sequence = [np.zeros((len(wedges), 0), dtype=np.int64)]
        self.budget = _budget("images of edges", wedges, tree, EDGE_IMAGE_BYTES)

    def grow(self) -> None:
        """Add the edge images of one more reflection."""
        wedge, frame, sequence = self.wedge[-1], self.frame[-1], self.sequence[-1]
        last = sequence[:, -1].copy() if sequence.shape[1] else np.full(len(wedge), -1)
        level = read_only((frame, wedge, last))

        def work(begin: int, end: int) -> tuple[IntArray, FloatArray]:
            pairs = _edge_kernels.planes_after(*level, begin, end, *self.known, self.slack_m)
            plane = self.planes[pairs[:, 1]]
            return pairs, _mirrored(frame[pairs[:, 0]], plane[:, :3], plane[:, 3])

        parts = gather_blocks(
            work, len(wedge), self.budget, block_size=IMAGES_PER_BLOCK, executor=self.executor
        )
        pairs = np.concatenate([np.zeros((0, 2), np.int64), *(part[0] for part in parts)])
        parent, plane = pairs.T
        self.wedge.append(wedge[parent])
        self.frame.append(np.concatenate([np.zeros((0, 12)), *(part[1] for part in parts)]))
        self.sequence.append(np.column_stack((sequence[parent], plane)))


def _mirrored(frame: FloatArray, normal: FloatArray, offset_m: FloatArray) -> FloatArray:
    """Return (n, 12) frames mirrored by one plane each."""
    out = frame.reshape(-1, 4, 3).copy()
    along = np.einsum("nkc,nc->nk", out, normal)
    along[:, 0] -= offset_m
    out -= 2.0 * along[:, :, None] * normal[:, None, :]
    return out.reshape(-1, 12)


def _combine(
    images: _EdgeImages, tree: ImageTree, light: _Light, pairs: IntArray, max_diffractions: int
) -> EdgeTree:
    """Return the tree of all edge images with the source images that light them."""
    count = len(images.wedges)
    # A way ends at a wedge from an image, or after another wedge that an image lights.
    last = np.concatenate((np.arange(count), pairs[:, 1]))
    first = np.concatenate((np.full(count, -1), pairs[:, 0]))
    way = np.lexsort((first, last))
    last, first = last[way], first[way]
    way_start = np.searchsorted(last, np.arange(count + 1))
    single = first < 0
    own = np.where(single, last, first)
    budget = _budget("routes over edges", images.wedges, tree, ROUTE_BYTES)
    parts = [(np.zeros(0, np.int64),) * 3]
    sizes = []
    for after, wedge in enumerate(images.wedge):
        alone = light.counts(tree.order, max(tree.max_order, 1) - 1 - after)
        behind = light.counts(tree.order, max(tree.max_order, 2) - 2 - after)
        of_way = np.where(single, alone[own], behind[own])
        sizes.append(np.add.reduceat(of_way, way_start[:-1])[wedge])
        budget.add(int(sizes[-1].sum()))
        way = expanded(way_start[wedge], np.diff(way_start)[wedge])
        row = expanded(light.start[own[way]], of_way[way])
        way = np.repeat(way, of_way[way])
        parts.append((light.leaf[row], way, row))
    leaf, way, row = (np.concatenate(part) for part in zip(*parts, strict=True))
    size = np.concatenate(sizes)
    used = np.flatnonzero(size)
    lengths = np.repeat(np.arange(len(images.wedge)), [len(w) for w in images.wedge])[used]
    planes = [s[n > 0].reshape(-1) for s, n in zip(images.sequence, sizes, strict=True)]
    whole = np.column_stack((np.zeros(count), images.wedges.length_m))[last[way]]
    return EdgeTree(
        wedge=np.concatenate(images.wedge)[used],
        frame=frozen_array(np.concatenate(images.frame)[used], name="frame", shape=(None, 12)),
        plane_start=np.concatenate(([0], np.cumsum(lengths))),
        plane=np.concatenate(planes),
        node_start=np.concatenate(([0], np.cumsum(size[used]))),
        leaf=leaf,
        first=first[way],
        source_m=light.source_m[row],
        reach_m=np.where(single[way, None], light.reach_m[row], whole),
        considered=sum(map(len, images.wedge)) * (1 + len(pairs)) * len(tree.image_m),
        kept=len(leaf),
        max_order=max(tree.max_order, max_diffractions),
    )
