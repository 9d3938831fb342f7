"""The records that stages hand on: arrays of scenes, images, edges and antennas; paths.

All stages import this module; it imports none of them. The arrays are what compiled kernels take.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.geometries._bvh_kernels import BvhArrays

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

NOTHING, REFLECTION, TRANSMITTED, DIFFRACTION = 0, 1, 2, 3
"""Kinds of interaction, in ``PathSet.kind``."""

LETTERS = ("", "R", "T", "D")
"""Their letters, as path tables write them."""

TRANSMISSION = 1 << 40
"""Code of an interaction in the kernels: a facet that reflects is its number, one that the path
passes through its number plus this, a diffraction at wedge w is -1 - w."""

CHUNK = 256
"""Images that are worked through before their paths are used: bounds the memory per receiver."""


class SceneArrays(NamedTuple):
    """Planes, facets, edges and hierarchies of a scene, and their electrical properties."""

    planes: np.ndarray  # (p, 10): normal, offset [m], axis u, axis v
    plane_facet_start: np.ndarray  # (p + 1,) int64
    supporting: np.ndarray  # (q, 4): inward normal, offset [m] of planes that bound the scene
    facet_box: np.ndarray  # (f, 4) [m]
    facet_outline: np.ndarray  # (f, 2) int64: begin, end of its outline; equal: fills its box
    facet_plane: np.ndarray  # (f,) int64
    outline: np.ndarray  # (e, 4) [m]
    bvh: BvhArrays  # of what blocks
    inner_bvh: BvhArrays  # of what blocks between points on the inner side of supporting planes
    sheet_bvh: BvhArrays  # of what lets waves through, triangles numbered by facet
    tolerance: float  # [m]
    facet_layers: np.ndarray  # (f, 2) int64: begin, end of its layers
    facet_front: np.ndarray  # (f,) bool: whether the first layer is where the normal points
    layer_permittivity: np.ndarray  # (l,) complex128
    layer_thickness: np.ndarray  # (l,) in wavelengths, infinite for all that lies behind
    transmits: bool  # whether any facet lets waves through
    wedge_frame: np.ndarray  # (w, 16): origin [m], axis, tangent, normal, air [rad], length [m],
    # whether it ends in the open at its start and at its end (Wedges.tips)
    wedge_facets: np.ndarray  # (w, 2) int64: face 0, face n
    wedge_utd: np.ndarray  # (w, 13): tangent, normal, air over pi, face 0, face n, the origin's
    # place along the axis [m], length [m], whether it ends in the open at its start and its end
    wedge_faces: np.ndarray  # (w, 2, 4) int64 of face 0 and face n: begin and end of its layers,
    # whether the first is in the wedge's air, whether it lets waves through
    wavelength: float  # [m]


class TreeArrays(NamedTuple):
    """The images of one source."""

    image: np.ndarray  # (n, 3) [m]; image 0 is the source
    order: np.ndarray  # (n,) int64
    branch_start: np.ndarray  # (n + 1,) int64
    branches: np.ndarray  # (b, 2) int64: plane, parent image
    leaves: np.ndarray  # (k,) int64: images whose paths are searched, rising
    ways: int  # greatest number of sequences that lead to one image
    max_order: int


class EdgeTreeArrays(NamedTuple):
    """Edge images of one source: k images, n nodes (a source image each)."""

    wedge: np.ndarray  # (k,) int64: the wedge that diffracts last
    frame: np.ndarray  # (k, 12): mirrored origin [m], axis, tangent, normal
    plane_start: np.ndarray  # (k + 1,) int64
    planes: np.ndarray  # (s,) int64: planes from the edge to the receiver, in that order
    node_start: np.ndarray  # (k + 1,) int64
    leaf: np.ndarray  # (n,) int64: image of the source
    first: np.ndarray  # (n,) int64: the wedge that diffracts first, -1 for a single diffraction
    source: np.ndarray  # (n, 2): the image's distance from the first edge's line, its place along
    reach: np.ndarray  # (n, 2): part of the last edge that can be lit, from and to [m]
    ways: int  # greatest number of paths that one image of the source can give
    rows: int  # room for paths that the largest edge image may need
    max_order: int


class ChannelArrays(NamedTuple):
    """What a scene's walls are at c frequencies; all else of the scene is the same."""

    wavelength: np.ndarray  # (c,) [m]
    layer_permittivity: np.ndarray  # (c, l) complex128
    layer_thickness: np.ndarray  # (c, l) in wavelengths


class AntennaArrays(NamedTuple):
    """One antenna of a closed-form pattern for the kernels; its far field is real."""

    kind: int
    half_length_rad: float  # k l / 2 of dipole, monopole with its image, patch; k a of a disc
    half_width_rad: float  # k w / 2 of the patch
    amplitude: float  # makes the mean of |F|^2 over all directions 1
    axis_x: float
    axis_y: float
    axis_z: float
    side_x: float  # unit vector across the axis from which azimuth counts
    side_y: float
    side_z: float


class PatternArrays(NamedTuple):
    """One antenna given by a table of its complex far field for the kernels."""

    table: np.ndarray  # (T + 2 PAD, P + 2 PAD, 1, 2) complex128, padded over the poles and around
    linear: np.ndarray  # (T - 1, P) bool: cells of straight lines, at steps
    step_theta: float  # [rad]
    step_phi: float  # [rad]
    axis_x: float
    axis_y: float
    axis_z: float
    side_x: float
    side_y: float
    side_z: float


class AntennaChannels(NamedTuple):
    """One antenna of a closed-form pattern at c frequencies."""

    kind: np.ndarray  # (c,) int64
    numbers: np.ndarray  # (c, 9): what follows the kind in AntennaArrays


class PatternChannels(NamedTuple):
    """One antenna given by tables of one grid at c frequencies."""

    tables: np.ndarray  # (c, T + 2 PAD, P + 2 PAD, 1, 2) complex128
    linear: np.ndarray  # (c, T - 1, P) bool
    numbers: np.ndarray  # (c, 8): what follows these two in PatternArrays


class ResponseArrays(NamedTuple):
    """Embedded patterns of n antennas at c frequencies on one grid, padded over poles and around.

    All frequencies of a direction stand together (a path has one direction); real and imaginary
    parts are weighed apart, without complex products.
    """

    table: np.ndarray  # (T + 2 PAD, P + 2 PAD, 4 c n): real and imaginary parts of F_theta, F_phi,
    # each of all antennas at all frequencies, phase at each antenna's own centre
    linear: np.ndarray  # (T - 1, P) bool: cells of straight lines, at steps
    step_theta: float  # [rad]
    step_phi: float  # [rad]
    centre_rad: np.ndarray  # (3, c n): wavenumber times phase centre, reader frame


@dataclass(frozen=True, slots=True, kw_only=True)
class PathSet:
    """Paths to a number of receivers, one row a path; those of one receiver stand together.

    Parameters
    ----------
    source_m : (3,) float64 — Place of the transmitter [m].
    receivers_m : (m, 3) float64 — Places of the receivers [m].
    receiver : (k,) int64 — Receiver of each path.
    kind : (k, w) int8 — What happens from the source on [-]: 1 reflection, 2 transmission through a
        sheet, 3 diffraction at an edge, 0 nothing more.
    element : (k, w) int64 — Facet of a reflection or transmission, wedge of a diffraction, else -1.
    vertices_m : (k, w + 2, 3) float64 — Source, interactions, receiver [m], the last repeated.
    """

    source_m: FloatArray
    receivers_m: FloatArray
    receiver: IntArray
    kind: npt.NDArray[np.int8]
    element: IntArray
    vertices_m: FloatArray

    def __len__(self) -> int:
        return len(self.receiver)

    @property
    def interactions(self) -> IntArray:
        """Number of interactions of each path, (k,): bends and transmissions."""
        count: IntArray = (self.kind != NOTHING).sum(axis=1)
        return count

    @property
    def order(self) -> IntArray:
        """Number of bends of each path, (k,): reflections and diffractions."""
        bends = (self.kind == REFLECTION) | (self.kind == DIFFRACTION)
        count: IntArray = bends.sum(axis=1)
        return count

    @property
    def codes(self) -> IntArray:
        """Interactions as the kernels take them, (k, w); -1 where there is nothing more."""
        codes: IntArray = np.select(
            [self.kind == REFLECTION, self.kind == TRANSMITTED, self.kind == DIFFRACTION],
            [self.element, self.element + TRANSMISSION, -1 - self.element],
            -1,
        )
        return codes

    def letters_of(self, path: int) -> tuple[str, ...]:
        """Return the kinds of one path's interactions as letters: R, T and D.

        Parameters
        ----------
        path : Row of the path.
        """
        return tuple(LETTERS[kind] for kind in self.kind[path] if kind != NOTHING)

    def vertices_of(self, path: int) -> FloatArray:
        """Return the (interactions + 2, 3) vertices [m] of one path, source first.

        Parameters
        ----------
        path : Row of the path.
        """
        return self.vertices_m[path, : int(np.count_nonzero(self.kind[path])) + 2]

    @property
    def length_m(self) -> FloatArray:
        """Length of each path [m], (k,)."""
        legs = np.linalg.norm(np.diff(self.vertices_m, axis=1), axis=2)
        length: FloatArray = legs.sum(axis=1)
        return length
