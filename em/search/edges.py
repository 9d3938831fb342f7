"""Complete enumeration of the routes over an edge: reflections, a diffraction, reflections.

What comes before the edge is an image of the source, what comes after it an image of the edge. A
combination is dropped only when no path can use it:

* the source's image stands outside the wedge's sector of air, or sees no part of the edge through
  the facets that it was mirrored by;
* a plane after the edge has no facet in the sector, lies through the edge, or (a wall of the room)
  would reflect from outside;
* a further plane has no facet on the side to which the one before it reflects.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.records import CHUNK, EdgeTreeArrays
from octant.em.search import _edge_kernels
from octant.em.search.facets import inner_sides, search_facets
from octant.em.search.images import ImageTree
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries.errors import GeometryError
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.geometries.wedges import Wedges

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

MAX_NODES = 20_000_000
"""Routes over edges beyond which a search stops with an error instead of filling the memory."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EdgeTree:
    """All routes from a source over one edge, or two of one facet, as images of the edges.

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
    """Return (w, 14): origin [m], axis, tangent, normal [-], air [rad] and length [m] of wedges.

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
        )
    )


def search_edges(
    scene: Scene, wedges: Wedges, tree: ImageTree, *, max_diffractions: int = 1
) -> EdgeTree:
    """Return every route from a source over the edges of a scene that a path can use.

    Their number grows with images x wedges x planes per order: for rooms with furniture, not for
    scanned meshes of thousands of edges.

    Parameters
    ----------
    scene : Geometry.
    wedges : Its wedges, or those of them that shall diffract.
    tree : Images of the source; its order bounds a path's interactions, but for diffractions alone.
    max_diffractions : Diffractions of a path: 1, or 2 for those over two edges of one facet as well
        (the top of a cabinet, both rims of a plate).
    """
    if max_diffractions not in (1, 2):
        msg = f"max_diffractions = {max_diffractions} is not available; give 1 or 2."
        raise GeometryError(msg)
    images = _EdgeImages(scene, wedges, tree)
    for _ in range(tree.max_order - 1):
        images.grow()
    pairs = _pairs_over_a_facet(wedges) if max_diffractions > 1 else np.zeros((0, 2), np.int64)
    return _combine(images, tree, _light(scene, wedges, tree), pairs, max_diffractions)


def _light(scene: Scene, wedges: Wedges, tree: ImageTree) -> tuple[FloatArray, FloatArray]:
    """Return which part of each edge each image lights, and the image's place, (i, w, 2) [m]."""
    f = scene.facets
    hulls = search_facets(scene, tree.source_m, tree.region_m, tree.opaque_facets)
    shape = (len(tree.image_m), len(wedges), 2)
    reach, source = np.empty(shape), np.empty(shape)
    known = (
        tree.image_m,
        tree.order,
        tree.branch_start,
        np.column_stack((tree.branch_plane, tree.branch_parent)),
        np.column_stack((f.plane_normal, f.plane_offset_m)),
        f.plane_facet_start,
        hulls.hull_start,
        hulls.hulls_m,
        wedge_frames(wedges),
    )
    _edge_kernels.light_edges(
        *read_only(known),
        scene.tolerance_m,
        reach,
        source,
    )
    return reach, source


def _pairs_over_a_facet(wedges: Wedges) -> IntArray:
    """Return (p, 2) wedges, first and last, that bound one side of a facet at different edges."""
    w = np.arange(len(wedges))
    same = wedges.facets[:, None, :, None] == wedges.facets[None, :, None, :]
    normals = wedges.face_normals
    same &= np.einsum("iac,jbc->ijab", normals, normals) > 0.0
    shared = same.any(axis=(2, 3))
    shared &= wedges.edge[:, None] != wedges.edge[None, :]
    # Edges of one line do not see one another over the facet.
    offset = wedges.origin_m[None] - wedges.origin_m[:, None]
    aside = np.linalg.norm(np.cross(offset, wedges.axis[:, None]), axis=2)
    parallel = np.linalg.norm(np.cross(wedges.axis[None], wedges.axis[:, None]), axis=2)
    shared &= (aside > LENGTHS.same_m) | (parallel > 1e-9)
    first, last = np.nonzero(shared)
    pairs: IntArray = np.column_stack((w[first], w[last]))
    return pairs


class _EdgeImages:
    """Edges mirrored by sequences of planes, level by level."""

    def __init__(self, scene: Scene, wedges: Wedges, tree: ImageTree) -> None:
        f = scene.facets
        self.normal, self.offset_m = f.plane_normal, f.plane_offset_m
        self.inner_side = inner_sides(scene, tree.source_m, tree.region_m)
        self.slack_m = scene.tolerance_m
        hulls = search_facets(scene, tree.source_m, tree.region_m, tree.opaque_facets)
        self.corner_m = hulls.hulls_m
        corners = np.diff(hulls.hull_start)
        self.corner_plane = np.repeat(f.facet_plane, corners)
        n = len(wedges)
        frame = np.column_stack((wedges.origin_m, wedges.axis, wedges.tangent, wedges.normal))
        self.length_m = wedges.length_m
        self.wedge = [np.arange(n)]
        self.frame = [frame]
        self.sequence = [np.zeros((n, 0), dtype=np.int64)]
        self.in_air = self._planes_in_air(wedges)

    def _any_corner(self, holds: BoolArray) -> BoolArray:
        """Return (..., p) whether any corner of each plane's facets has a property (..., c)."""
        any_corner = np.zeros((*holds.shape[:-1], len(self.normal)), dtype=np.bool_)
        for corner in range(holds.shape[-1]):
            any_corner[..., self.corner_plane[corner]] |= holds[..., corner]
        return any_corner

    def _planes_in_air(self, wedges: Wedges) -> BoolArray:
        """Return (w, p) whether a facet of each plane reaches into each wedge's sector of air."""
        wide = wedges.exterior_rad > np.pi
        turned = wedges.exterior_rad[:, None]
        other = np.sin(turned) * wedges.tangent - np.cos(turned) * wedges.normal
        before_0 = self._heights(wedges.normal, wedges.origin_m) > self.slack_m
        before_n = self._heights(other, wedges.origin_m) > self.slack_m
        narrow = self._any_corner(before_0) & self._any_corner(before_n)
        return np.where(wide[:, None], self._any_corner(before_0 | before_n), narrow)

    def _heights(self, normal: FloatArray, point_m: FloatArray) -> FloatArray:
        """Return (n, c) heights [m] of all corners over planes through points."""
        heights: FloatArray = normal @ self.corner_m.T - np.sum(normal * point_m, axis=1)[:, None]
        return heights

    def grow(self) -> None:
        """Add the edge images of one more reflection."""
        wedge, frame, sequence = self.wedge[-1], self.frame[-1], self.sequence[-1]
        start = frame[:, :3]
        end = start + self.length_m[wedge][:, None] * frame[:, 3:6]
        heights = np.stack(
            (start @ self.normal.T - self.offset_m, end @ self.normal.T - self.offset_m)
        )
        usable = np.abs(heights).max(axis=0) > self.slack_m
        side = self.inner_side[None, :] * heights
        usable &= (self.inner_side[None, :] == 0) | (side.max(axis=0) > self.slack_m)
        if sequence.shape[1] == 0:
            usable &= self.in_air[wedge]
        else:
            usable &= self._reflected_to(sequence[:, -1], start, end)
            usable[np.arange(len(wedge)), sequence[:, -1]] = False
        parent, plane = np.nonzero(usable)
        if len(parent) > MAX_NODES:
            msg = (
                f"{len(parent)} images of edges are more than {MAX_NODES}; lower max_reflections, "
                "or leave diffraction out."
            )
            raise GeometryError(msg)
        self.wedge.append(wedge[parent])
        self.frame.append(_mirrored(frame[parent], self.normal[plane], self.offset_m[plane]))
        self.sequence.append(np.column_stack((sequence[parent], plane)))

    def _reflected_to(self, plane: IntArray, start: FloatArray, end: FloatArray) -> BoolArray:
        """Return (n, p) whether planes have a facet on the side to which a plane reflects."""
        reachable = np.empty((len(plane), len(self.normal)), dtype=np.bool_)
        for q in np.unique(plane):
            rows = np.flatnonzero(plane == q)
            height = self.corner_m @ self.normal[q] - self.offset_m[q]
            above = self._any_corner(height > self.slack_m)
            below = self._any_corner(height < -self.slack_m)
            ends = np.stack((start[rows], end[rows])) @ self.normal[q] - self.offset_m[q]
            # The mirrored edge is behind the plane; what it reflects goes to the other side.
            reachable[rows] = ((ends.min(axis=0) < self.slack_m)[:, None] & above) | (
                (ends.max(axis=0) > -self.slack_m)[:, None] & below
            )
        return reachable


def _mirrored(frame: FloatArray, normal: FloatArray, offset_m: FloatArray) -> FloatArray:
    """Return (n, 12) frames mirrored by one plane each."""
    out = frame.reshape(-1, 4, 3).copy()
    along = np.einsum("nkc,nc->nk", out, normal)
    along[:, 0] -= offset_m
    out -= 2.0 * along[:, :, None] * normal[:, None, :]
    return out.reshape(-1, 12)


def _combine(
    images: _EdgeImages,
    tree: ImageTree,
    light: tuple[FloatArray, FloatArray],
    pairs: IntArray,
    max_diffractions: int,
) -> EdgeTree:
    """Return the tree of all edge images with the source images that light them."""
    lit, source = light
    sees = lit[:, :, 1] >= lit[:, :, 0]
    wedges = sees.shape[1]
    parts: list[tuple[IntArray, IntArray, IntArray, FloatArray, FloatArray]] = []
    sizes, considered = [], 0
    nodes = 0
    tables = [_nodes_of(tree, sees, pairs, wedge) for wedge in range(wedges)]
    for after, wedge_of in enumerate(images.wedge):
        for wedge in wedge_of:
            leaf, first, left = tables[wedge]
            fits = left >= after
            leaf, first = leaf[fits], first[fits]
            single = first < 0
            own = np.where(single, wedge, first)
            reach = lit[leaf, wedge].copy()
            reach[~single] = (0.0, images.length_m[wedge])
            parts.append((leaf, first, own, source[leaf, own], reach))
            sizes.append(len(leaf))
            nodes += len(leaf)
            if nodes > MAX_NODES:
                msg = (
                    f"more than {MAX_NODES} routes lead over the edges; lower max_reflections, or "
                    "leave diffraction out."
                )
                raise GeometryError(msg)
        considered += len(wedge_of) * (1 + len(pairs)) * len(tree.image_m)
    used = np.flatnonzero(np.array(sizes, dtype=np.int64) > 0)
    frame, wedge_of_image = np.concatenate(images.frame), np.concatenate(images.wedge)
    sequences = [row for level in images.sequence for row in level]
    lengths = [len(sequences[k]) for k in used]
    none = np.zeros(0, dtype=np.int64)
    return EdgeTree(
        wedge=wedge_of_image[used],
        frame=frozen_array(frame[used], name="frame", shape=(None, 12)),
        plane_start=np.concatenate(([0], np.cumsum(lengths))).astype(np.int64),
        plane=np.concatenate([none, *(sequences[k] for k in used)]).astype(np.int64),
        node_start=np.concatenate(([0], np.cumsum([sizes[k] for k in used]))).astype(np.int64),
        leaf=np.concatenate([none, *(p[0] for p in parts)]),
        first=np.concatenate([none, *(p[1] for p in parts)]),
        source_m=np.concatenate([np.zeros((0, 2)), *(p[3] for p in parts)]),
        reach_m=np.concatenate([np.zeros((0, 2)), *(p[4] for p in parts)]),
        considered=considered,
        kept=nodes,
        max_order=max(tree.max_order, max_diffractions),
    )


def _nodes_of(
    tree: ImageTree, sees: BoolArray, pairs: IntArray, wedge: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Return source images, first wedges and reflections left over for ways that end at a wedge."""
    leaf = np.flatnonzero(sees[:, wedge])
    leaves, firsts = [leaf], [np.full(len(leaf), -1)]
    left = [max(tree.max_order, 1) - 1 - tree.order[leaf]]
    for first in pairs[pairs[:, 1] == wedge, 0]:
        leaf = np.flatnonzero(sees[:, first])
        leaves.append(leaf)
        firsts.append(np.full(len(leaf), first))
        left.append(max(tree.max_order, 2) - 2 - tree.order[leaf])
    return np.concatenate(leaves), np.concatenate(firsts), np.concatenate(left)
