"""Exact specular paths: the image method on every candidate sequence, each segment free."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em import _field_kernels, _path_kernels
from octant.em._path_kernels import SceneArrays
from octant.em.antennas import Antenna
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.image_search import ImageTree
from octant.em.radio_scene import RadioScene
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PathSet:
    """Paths to a number of receivers, one row a path, sorted by receiver and order.

    Parameters
    ----------
    source_m : (3,) float64
        Place of the transmitter [m].
    receivers_m : (m, 3) float64
        Places of the receivers [m].
    receiver : (k,) int64
        Receiver of each path [-].
    order : (k,) int64
        Number of reflections [-].
    vertices_m : (k, order + 2, 3) float64
        Source, reflection points, receiver [m]; short paths repeat the receiver.
    facets : (k, order) int64
        Facet of each reflection [-]; -1 beyond a path's order.
    """

    source_m: FloatArray
    receivers_m: FloatArray
    receiver: IntArray
    order: IntArray
    vertices_m: FloatArray
    facets: IntArray

    def __len__(self) -> int:
        return len(self.order)

    def vertices_of(self, path: int) -> FloatArray:
        """Return the (order + 2, 3) vertices [m] of one path, source first.

        Parameters
        ----------
        path : int
            Row of the path [-].
        """
        return self.vertices_m[path, : self.order[path] + 2]

    @property
    def length_m(self) -> FloatArray:
        """Length of each path [m], (k,)."""
        legs = np.linalg.norm(np.diff(self.vertices_m, axis=1), axis=2)
        length: FloatArray = legs.sum(axis=1)
        return length


@dataclass(frozen=True, slots=True, kw_only=True)
class PathGains:
    """What each path of a :class:`PathSet` brings from one antenna to another.

    Parameters
    ----------
    gain : (k,) complex128
        Complex gain [-] between the two antennas, free-space loss and phase included.
    length_m : (k,) float64
        Length [m].
    departure, arrival : (k, 3) float64
        Unit vectors [-] in which the wave leaves the source, and from the receiver towards where it
        comes from.
    """

    gain: npt.NDArray[np.complex128]
    length_m: FloatArray
    departure: FloatArray
    arrival: FloatArray

    @property
    def delay_s(self) -> FloatArray:
        """Delay of each path [s], (k,)."""
        return self.length_m / SPEED_OF_LIGHT_M_PER_S


def scene_arrays(radio: RadioScene) -> SceneArrays:
    """Return a radio scene as the path kernels take it, lengths in metres [m].

    Parameters
    ----------
    radio : RadioScene
        Scene with resolved materials.
    """
    scene, f = radio.scene, radio.scene.facets
    outline = np.column_stack((f.outline_start[:-1], f.outline_start[1:]))
    outline[f.facet_is_rectangle, 1] = outline[f.facet_is_rectangle, 0]
    return SceneArrays(
        planes=np.column_stack((f.plane_normal, f.plane_offset_m, f.plane_u, f.plane_v)),
        plane_facet_start=f.plane_facet_start,
        supporting_side=scene.supporting_side,
        facet_box=f.facet_bounds_m,
        facet_outline=outline,
        facet_plane=f.facet_plane,
        outline=f.outline_m,
        bvh=scene.bvh,
        inner_bvh=scene.inner_bvh,
        tolerance=scene.tolerance_m,
        facet_permittivity=radio.facet_permittivity,
        facet_thickness=radio.facet_thickness_m / radio.wavelength_m,
        wavelength=radio.wavelength_m,
    )


def checked_receivers(tree: ImageTree, receivers_m: npt.ArrayLike) -> FloatArray:
    """Return receivers as an (m, 3) array [m], if the images are complete for them.

    Parameters
    ----------
    tree : ImageTree
        Images of the source.
    receivers_m : (m, 3) float
        Places of the receivers [m].

    Raises
    ------
    GeometryError
        For a receiver outside the region that the images were searched for.
    """
    receivers = frozen_array(receivers_m, name="receivers_m", shape=(None, 3))
    slack = 1e-6
    outside = (receivers < tree.region_m[0] - slack) | (receivers > tree.region_m[1] + slack)
    if outside.any():
        worst = receivers[int(np.argmax(outside.any(axis=1)))]
        msg = (
            f"receiver ({worst[0]:g}, {worst[1]:g}, {worst[2]:g}) m lies outside the region "
            f"{tree.region_m.tolist()} m that the images were searched for; pass a region_m that "
            "holds every receiver to search_images."
        )
        raise GeometryError(msg)
    return receivers


def trace_paths(radio: RadioScene, tree: ImageTree, receivers_m: npt.ArrayLike) -> PathSet:
    """Return every specular path to each receiver, up to the order of the image tree.

    Parameters
    ----------
    radio : RadioScene
        Scene that the tree was searched in.
    tree : ImageTree
        Images of the source.
    receivers_m : (m, 3) float
        Places of the receivers [m].

    Returns
    -------
    PathSet
        Possibly without any row: no path is a result.

    Raises
    ------
    GeometryError
        For a receiver outside the region that the images were searched for.

    Notes
    -----
    Reflection points lie inside their facets (rims included) and no other facet stands in the way.
    A path that runs exactly through the shared edge of two facets is counted once.
    """
    receivers = checked_receivers(tree, receivers_m)
    arrays, images = scene_arrays(radio), tree.kernel_arrays()
    m, n = len(receivers), tree.max_order
    counts = np.zeros(m, dtype=np.int64)
    room_for = 0
    while True:  # once to count, once to record
        start = np.concatenate(([0], np.cumsum(counts)))
        order = np.zeros(room_for, dtype=np.int64)
        vertices = np.zeros((room_for, n + 2, 3))
        facets = np.zeros((room_for, n), dtype=np.int64)
        _path_kernels.record_paths(
            arrays, images, receivers, start, order, vertices, facets, counts
        )
        if room_for == int(counts.sum()):
            break
        room_for = int(counts.sum())
    return PathSet(
        source_m=tree.source_m,
        receivers_m=receivers,
        receiver=np.repeat(np.arange(len(receivers)), counts),
        order=order,
        vertices_m=vertices,
        facets=facets,
    )


def path_gains(
    radio: RadioScene, paths: PathSet, *, transmitter: Antenna, receiver: Antenna
) -> PathGains:
    """Return the complex gain of each path between two antennas.

    Parameters
    ----------
    radio : RadioScene
        Scene that the paths were traced in.
    paths : PathSet
        Paths.
    transmitter, receiver : Antenna
        Antennas at the two ends, in the room's frame, with patterns |F|^2 = gain [-].

    Returns
    -------
    PathGains
        Gain F_r . T . F_t lambda / (4 pi L) e^{-jkL} [-]; T carries the polarisation through every
        reflection.

    Notes
    -----
    Far field: antennas and reflection points should be more than a wavelength apart.
    """
    k = len(paths)
    gain = np.zeros(k, dtype=np.complex128)
    directions = np.zeros((k, 2, 3))
    _field_kernels.path_gains(
        scene_arrays(radio),
        transmitter.kernel_arrays(),
        receiver.kernel_arrays(),
        paths.order,
        paths.vertices_m,
        paths.facets,
        gain,
        directions,
    )
    return PathGains(
        gain=gain,
        length_m=paths.length_m,
        departure=directions[:, 0],
        arrival=directions[:, 1],
    )
