"""Paths of a tag to the nodes of a coarse grid, by image point: what lies between follows.

Between nodes a path's field without its phase is interpolated, and the phase e^{-jkL} follows
exactly from its image point, which does not move; where the tag moves by d, the image moves by R d,
R being the product of the mirrors that lead to it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.tracing import trace_paths
from octant.em.records import REFLECTION, PathSet
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
ComplexArray = npt.NDArray[np.complex128]

_SHORT = 1e-3
_SHORT_GAIN = math.sqrt(1.5)
_TRACED = 2048


@dataclass(frozen=True, slots=True, kw_only=True)
class NodePaths:
    """Paths to the nodes: those of a node together, in the order of their image points.

    Parameters
    ----------
    start : (nodes + 1,) int64 — Where each node's paths begin [-].
    image : (k,) int64 — Image point of each path [-].
    images_m : (i, 3) float64 — The image points [m].
    mirrors : (i, 3, 3) float64 — By how much an image moves when the tag does [-].
    fields : Of every channel (k, 3) complex128 — Field along x, y, z without its phase, as a gain
        between the tag's antenna and an isotropic one [-].
    """

    start: IntArray
    image: IntArray
    images_m: FloatArray
    mirrors: FloatArray
    fields: tuple[ComplexArray, ...]


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
    """Return the paths of a tag to the nodes of a grid; nothing diffracts.

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
    candidates = search_candidates(first, tag_position_m, replace(solver, diffraction=False))
    free = np.flatnonzero(inside)
    blocks = []
    for some in np.split(free, np.arange(_TRACED, len(free), _TRACED)):
        paths = trace_paths(first, candidates, places[some])
        fields_there = _field_at(radios, paths, tag_antennas)
        blocks.append((some[paths.receiver], _mirrors(first, paths), *fields_there))
    node, mirrors, image, *fields = (np.concatenate(part) for part in zip(*blocks, strict=True))
    if not len(node):
        msg = (
            f"no path of the tag at {tag_position_m.tolist()} m arrives on the floor's "
            "map: move the tag."
        )
        raise GeometryError(msg)
    # As in `image_fields`: two walls in either order have one image.
    cells = np.floor(image / LENGTHS.weld_m + 0.12345).astype(np.int64)
    keys = cells @ np.array([1, 100_000_007, 10_000_000_019_000_033])
    _, one, number = np.unique(keys, return_index=True, return_inverse=True)
    both, at = np.unique(node * len(one) + number.ravel(), return_inverse=True)
    summed = []
    for field in fields:
        total = np.zeros((len(both), 3), dtype=np.complex128)
        np.add.at(total, at.ravel(), field)
        summed.append(total)
    return NodePaths(
        start=np.searchsorted(both // len(one), np.arange(len(places) + 1)),
        image=both % len(one),
        images_m=image[one],
        mirrors=mirrors[one],
        fields=tuple(summed),
    )


def _field_at(
    radios: Sequence[RadioScene], found: PathSet, tag_antennas: Sequence[Antenna]
) -> tuple[npt.NDArray[np.float64 | np.complex128], ...]:
    """Return the image point of each path, and its field without phase at every channel."""
    length = found.length_m
    image = np.empty((len(found), 3))
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
        image = found.receivers_m[found.receiver] + length[:, None] * gains.arrival
        turn = 2.0 * math.pi / radio.wavelength_m
        fields.append(np.column_stack(parts) * np.exp(1j * turn * length)[:, None])
    return image, *fields


def _mirrors(radio: RadioScene, found: PathSet) -> FloatArray:
    """Return the product of each path's mirrors, (k, 3, 3), the last reflection's on the left."""
    facets = radio.scene.facets
    product = np.tile(np.eye(3), (len(found), 1, 1))
    for column in range(found.kind.shape[1]):
        some = found.kind[:, column] == REFLECTION
        normal = facets.plane_normal[facets.facet_plane[found.element[some, column]]]
        mirror = np.eye(3) - 2.0 * normal[:, :, None] * normal[:, None, :]
        product[some] = mirror @ product[some]
    return product
