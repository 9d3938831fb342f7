"""Paths of a tag to the nodes of a coarse grid, by image point: what lies between follows.

Between nodes a path's field without its phase is interpolated, and the phase e^{-jkL} follows
exactly from its image point. That of a path over walls stands still. That of a path over an edge
turns about the edge, mirrored as it is seen: it stays opposite to the place, since a diffracted ray
leaves the edge at the angle at which it came (Keller's cone): L² = (r + r')² + (z - z')², in
cylindrical coordinates about the edge. Where the tag moves, images move with it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.tracing import trace_paths
from octant.em.records import DIFFRACTION, REFLECTION, PathSet
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
ComplexArray = npt.NDArray[np.complex128]

_SHORT = 1e-3
_SHORT_GAIN = math.sqrt(1.5)
_TRACED = 2048
_LEFT_OUT = 0.005
_PRIMES = np.array(
    [1, 100_000_007, 10_000_000_019_000_033, 1_299_709, 15_485_863, 179_424_673, 2_038_074_743,
     22_801_763_489, 252_097_800_623, 2_760_727_302_517]
)  # fmt: skip

EDGE_BENDS = 2
"""Bends of a path over an edge [-] that maps contain: one more multiplies their time by ten."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NodePaths:
    """Paths to the nodes: those of a node together, in the order of their image points.

    Parameters
    ----------
    start : (nodes + 1,) int64 — Where each node's paths begin [-].
    image : (k,) int64 — Image point of each path [-].
    images : (i, 7) float64 — The image points [m]; axis [-] and radius [m] of the circle on which
        they turn about an edge's point, 0 of those that stand still.
    moves : (i, 4, 3) float64 — What the tag's motion is multiplied by: three rows give the motion
        of the image or the edge's point, one that of the radius [-].
    fields : Of every channel (k, 3) complex — Field along x, y, z without its phase, as a gain
        between the tag's antenna and an isotropic one [-].
    """

    start: IntArray
    image: IntArray
    images: FloatArray
    moves: FloatArray
    fields: tuple[npt.NDArray[np.complexfloating], ...]

    def strongest(self) -> "NodePaths":
        """Return them in single precision without the weakest images.

        Those left out carry 0.5 % of a place's power on average over the floor.
        """
        power = np.sum([np.sum(np.abs(field) ** 2, axis=1) for field in self.fields], axis=0)
        node = np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))
        there = np.bincount(node, weights=power)
        share = np.bincount(self.image, weights=power / there[node], minlength=len(self.images))
        order = np.argsort(share, kind="stable")
        weak = np.cumsum(share[order]) <= _LEFT_OUT * share.sum()
        strong = np.ones(len(share), dtype=np.bool_)
        strong[order[weak]] = False
        kept = strong[self.image]
        return replace(
            self,
            start=np.concatenate([[0], np.cumsum(kept)])[self.start],
            image=self.image[kept],
            fields=tuple(field[kept].astype(np.complex64) for field in self.fields),
        )


def grid_points(x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Return the (nx ny, 2) points of a grid, y fastest [m].

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Coordinates [m].
    """
    gx, gy = np.meshgrid(x_m, y_m, indexing="ij")
    return np.column_stack([gx.ravel(), gy.ravel()])


def trace_node_paths(
    radios: Sequence[RadioScene],
    node_x_m: FloatArray,
    node_y_m: FloatArray,
    *,
    tag_position_m: FloatArray,
    tag_antennas: Sequence[Antenna],
    reader_z_m: float,
    solver: SolverSettings,
) -> NodePaths:
    """Return the paths of a tag to the nodes of a grid, over one edge at most.

    Parameters
    ----------
    radios : The room at every channel.
    node_x_m, node_y_m, reader_z_m : Coordinates of the nodes, and their height [m].
    tag_position_m, tag_antennas : (3,) float64 — Place of the tag [m]; its antenna at each channel.
    solver : How paths are searched.
    """
    nodes = grid_points(node_x_m, node_y_m)
    places = np.column_stack([nodes, np.full(len(nodes), reader_z_m)])
    first = radios[0]
    inside = np.ones(len(places), dtype=np.bool_)
    if first.scene.has_room:
        inside = first.scene.inside_room(places)
    inside &= ~first.scene.inside_solid(places)
    free = np.flatnonzero(inside)
    blocks = [
        (some[paths.receiver], *_field_at(radios, paths, tag_antennas))
        for some, paths in _traced(first, places, free, tag_position_m, solver)
    ]
    node, images, moves, *fields = (np.concatenate(part) for part in zip(*blocks, strict=True))
    if not len(node):
        msg = (
            f"no path of the tag at {tag_position_m.tolist()} m arrives on the floor's "
            "map: move the tag."
        )
        raise GeometryError(msg)
    _, one, number = np.unique(_keys(images, moves), return_index=True, return_inverse=True)
    both, at = np.unique(node * len(one) + number.ravel(), return_inverse=True)
    summed = []
    for field in fields:
        total = np.zeros((len(both), 3), dtype=np.complex128)
        np.add.at(total, at.ravel(), field)
        summed.append(total)
    return NodePaths(
        start=np.searchsorted(both // len(one), np.arange(len(places) + 1)),
        image=both % len(one),
        images=images[one],
        moves=moves[one],
        fields=tuple(summed),
    )


def _traced(
    radio: RadioScene,
    places: FloatArray,
    free: IntArray,
    tag_position_m: FloatArray,
    solver: SolverSettings,
) -> Iterator[tuple[IntArray, PathSet]]:
    """Return numbers of places with their paths over walls, then with those over an edge."""
    blocks = np.split(free, np.arange(_TRACED, len(free), _TRACED))
    walls = search_candidates(radio, tag_position_m, replace(solver, diffraction=False))
    for some in blocks:
        yield some, trace_paths(radio, walls, places[some])
    bends = min(solver.max_reflections, EDGE_BENDS)
    if not (solver.diffraction and bends and len(radio.wedges)):
        return
    few = replace(solver, max_reflections=bends, max_diffractions=1)
    edges = search_candidates(radio, tag_position_m, few)
    for some in blocks:
        found = trace_paths(radio, edges, places[some])
        over = (found.kind == DIFFRACTION).any(axis=1)
        yield (
            some,
            replace(
                found,
                receiver=found.receiver[over],
                kind=found.kind[over],
                element=found.element[over],
                vertices_m=found.vertices_m[over],
            ),
        )


def _field_at(
    radios: Sequence[RadioScene], found: PathSet, tag_antennas: Sequence[Antenna]
) -> tuple[npt.NDArray[np.float64 | np.complex128], ...]:
    """Return where each path seems to come from, and its field without phase at every channel."""
    length = found.length_m
    arrival = np.empty((len(found), 3))
    fields = []
    for radio, antenna in zip(radios, tag_antennas, strict=True):
        parts = []
        for axis in np.eye(3):
            # A short dipole receives the component of the field along it.
            probe = make_antenna(
                "dipole", radio.frequency_hz, length_m=_SHORT * radio.wavelength_m, axis=axis
            )
            gains = path_gains(radio, found, transmitter=antenna, receiver=probe)
            parts.append(gains.gain / _SHORT_GAIN)
        arrival = gains.arrival
        turn = 2.0 * math.pi / radio.wavelength_m
        fields.append(np.column_stack(parts) * np.exp(1j * turn * length)[:, None])
    return *_images(radios[0], found, arrival), *fields


def _images(
    radio: RadioScene, found: PathSet, arrival: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where paths seem to come from (k, 7), and how that moves with the tag (k, 4, 3).

    A path that comes to an edge of direction t along i, after a way s, is one of an image of the
    tag at -s (i.t) along the edge and s |i x t| from it.
    """
    count, width = found.kind.shape
    over = found.kind == DIFFRACTION
    column = np.arange(width)
    bend = np.where(over, column, width).min(axis=1, initial=width)
    images, moves = np.zeros((count, 7)), np.zeros((count, 4, 3))
    images[:, :3] = found.receivers_m[found.receiver] + found.length_m[:, None] * arrival
    moves[:, :3] = _mirrors(radio, found, column < bend[:, None])
    some = np.flatnonzero(bend < width)
    at = bend[some]
    axis = radio.wedges.axis[found.element[some, at]]
    legs = np.linalg.norm(np.diff(found.vertices_m[some], axis=1), axis=2)
    way = np.where(np.arange(width + 1) <= at[:, None], legs, 0.0).sum(axis=1)[:, None]
    back = found.vertices_m[some, at] - found.vertices_m[some, at + 1]
    back *= way / np.linalg.norm(back, axis=1, keepdims=True)
    along = np.sum(back * axis, axis=1, keepdims=True)
    aside = back - along * axis
    radius = np.linalg.norm(aside, axis=1, keepdims=True)
    after = _mirrors(radio, found, column > bend[:, None])[some]
    turned = (after @ axis[:, :, None])[:, :, 0]
    images[some, :3] -= way * arrival[some] - along * turned
    images[some, 3:] = np.hstack([turned, radius])
    before = moves[some, :3]
    moves[some, :3] = turned[:, :, None] * (axis[:, None, :] @ before)
    moves[some, 3] = ((aside / radius)[:, None, :] @ before)[:, 0]
    return images, moves


def _mirrors(radio: RadioScene, found: PathSet, counted: BoolArray) -> FloatArray:
    """Return the product of each path's mirrors, (k, 3, 3), the last reflection's on the left.

    counted (k, w): which interactions count.
    """
    facets = radio.scene.facets
    product = np.tile(np.eye(3), (len(found), 1, 1))
    for column in range(found.kind.shape[1]):
        some = (found.kind[:, column] == REFLECTION) & counted[:, column]
        normal = facets.plane_normal[facets.facet_plane[found.element[some, column]]]
        mirror = np.eye(3) - 2.0 * normal[:, :, None] * normal[:, None, :]
        product[some] = mirror @ product[some]
    return product


def _keys(images: FloatArray, moves: FloatArray) -> IntArray:
    """Return a number for each image, the same for those that cannot be told apart."""
    cells = np.floor(np.hstack([images, moves[:, 3]]) / LENGTHS.weld_m + 0.12345).astype(np.int64)
    # As in `image_fields`: two walls in either order have one image.
    keys: IntArray = cells @ _PRIMES
    return keys
