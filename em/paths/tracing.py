"""Exact paths over walls, through sheets and over edges, each segment free, and their gains."""

import math

import numpy as np
import numpy.typing as npt

from octant.em.medium.radio_scene import RadioScene
from octant.em.paths import _tracing_kernels
from octant.em.records import (
    DIFFRACTION,
    NOTHING,
    REFLECTION,
    TRANSMISSION,
    TRANSMITTED,
    EdgeTreeArrays,
    PathSet,
    SceneArrays,
    TreeArrays,
)
from octant.em.search.candidates import Candidates
from octant.em.search.edges import no_edges, wedge_frames
from octant.em.search.images import ImageTree
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def scene_arrays(radio: RadioScene) -> SceneArrays:
    """Return a radio scene as the path kernels take it, lengths in metres [m].

    Parameters
    ----------
    radio : Scene with resolved materials.
    """
    scene, f, wedges = radio.scene, radio.scene.facets, radio.wedges
    planes = np.column_stack((f.plane_normal, f.plane_offset_m, f.plane_u, f.plane_v))
    outline = np.column_stack((f.outline_start[:-1], f.outline_start[1:]))
    outline[f.facet_is_rectangle, 1] = outline[f.facet_is_rectangle, 0]
    arrays = SceneArrays(
        planes=planes,
        plane_facet_start=f.plane_facet_start,
        supporting=(scene.supporting_side[:, None] * planes[:, :4])[scene.supporting_side != 0],
        facet_box=f.facet_bounds_m,
        facet_outline=outline,
        facet_plane=f.facet_plane,
        outline=f.outline_m,
        bvh=radio.opaque_bvh,
        inner_bvh=radio.opaque_inner_bvh,
        sheet_bvh=radio.sheet_bvh,
        tolerance=scene.tolerance_m,
        facet_layers=radio.facet_layers,
        facet_front=scene.facet_front,
        layer_permittivity=radio.layer_permittivity,
        layer_thickness=radio.layer_thickness_m / radio.wavelength_m,
        transmits=radio.transmits,
        wedge_frame=wedge_frames(wedges),
        wedge_facets=wedges.facets,
        wedge_utd=np.column_stack(
            (
                wedges.tangent,
                wedges.normal,
                wedges.exterior_rad / math.pi,
                wedges.facets,
                np.sum(wedges.origin_m * wedges.axis, axis=1),
                wedges.length_m,
                wedges.tips > 0,
            )
        ),
        wedge_faces=_wedge_faces(radio),
        wavelength=radio.wavelength_m,
    )
    return read_only(arrays)


def _wedge_faces(radio: RadioScene) -> IntArray:
    """Return (w, 2, 4) of both faces of each wedge: layers from, to, front outside, transmits."""
    f, wedges = radio.scene.facets, radio.wedges
    outward = f.plane_normal[f.facet_plane[wedges.facets]]
    same = np.sum(wedges.face_normals * outward, axis=2) > 0.0
    front = radio.scene.facet_front[wedges.facets] == same
    layers = radio.facet_layers[wedges.facets]
    if len(wedges):  # what fills all that lies behind has one side
        front |= np.isinf(radio.layer_thickness_m[layers[..., 1] - 1])
    passes = radio.facet_transmits[wedges.facets]
    return np.concatenate((layers, front[..., None], passes[..., None]), axis=2).astype(np.int64)


def checked_receivers(tree: ImageTree, receivers_m: npt.ArrayLike) -> FloatArray:
    """Return receivers as an (m, 3) array [m], if the images are complete for them.

    Parameters
    ----------
    tree : Images of the source.
    receivers_m : (m, 3) float — Places of the receivers [m].
    """
    receivers = frozen_array(receivers_m, name="receivers_m", shape=(None, 3))
    slack = LENGTHS.place_m
    outside = (receivers < tree.region_m[0] - slack) | (receivers > tree.region_m[1] + slack)
    if outside.any():
        worst = receivers[int(np.argmax(outside.any(axis=1)))]
        msg = (
            f"receiver ({worst[0]:g}, {worst[1]:g}, {worst[2]:g}) m lies outside the region "
            f"{tree.region_m.tolist()} m that the images were searched for; pass a region_m that "
            "holds every receiver to search_images."
        )
        raise GeometryError(msg)
    if tree.receivers_m is not None:
        known = set(map(tuple, tree.receivers_m.tolist()))
        other = next((r for r in map(tuple, receivers.tolist()) if r not in known), None)
        if other is not None:
            msg = (
                f"receiver ({other[0]:g}, {other[1]:g}, {other[2]:g}) m is none of the "
                f"{len(known)} that the images were searched for; give search_images all receivers."
            )
            raise GeometryError(msg)
    offset = np.linalg.norm(receivers - tree.source_m, axis=1)
    if len(offset) and float(offset.min()) <= LENGTHS.same_m:
        x, y, z = receivers[int(np.argmin(offset))]
        msg = (
            f"receiver ({x:g}, {y:g}, {z:g}) m is at the place of the source, where the field has "
            f"no bounds; keep them more than {LENGTHS.same_m:g} m apart."
        )
        raise GeometryError(msg)
    return receivers


def path_arrays(
    radio: RadioScene, candidates: Candidates
) -> tuple[SceneArrays, TreeArrays, EdgeTreeArrays]:
    """Return scene, images and edge images as the path kernels take them, lengths in [m].

    Parameters
    ----------
    radio : Scene that the candidates were searched in.
    candidates : Of one source.
    """
    tree, edges = candidates.images, candidates.edges
    if bool((tree.opaque_facets & radio.facet_transmits).any()):
        msg = (
            "the images were searched as if every facet were opaque, but some let waves through; "
            "give search_images opaque_facets = radio.opaque_facets."
        )
        raise GeometryError(msg)
    images = tree.kernel_arrays()
    if edges is None:
        return scene_arrays(radio), images, no_edges().kernel_arrays(1)
    if len(radio.wedges) <= int(edges.wedge.max(initial=-1)):
        msg = (
            "the candidates' edges belong to wedges that this radio scene does not have; give "
            "radio_scene the wedges that search_edges was given."
        )
        raise GeometryError(msg)
    if len(tree.image_m) <= int(edges.leaf.max(initial=-1)):
        msg = "the candidates' edges belong to another image tree; search them with this one."
        raise GeometryError(msg)
    ways = edges.kernel_arrays(images.ways if radio.transmits else 1)
    return scene_arrays(radio), images, ways


def trace_paths(
    radio: RadioScene,
    candidates: Candidates,
    receivers_m: npt.ArrayLike,
) -> PathSet:
    """Return every path to each receiver, over walls, through sheets, over edges; none is a result.

    Reflection points lie inside their facets (rims included) with nothing in the way but facets
    that let waves through. A path exactly through the shared edge of two facets counts once. One
    that touches more than it interacts with (a rim, a partition's foot, an edge's end), or has a
    leg of no length, counts where a path close by, its ends moved by about 1e-6 m, exists as well.
    Paths through more than 128 sheets are left out.

    A receiver on a wall has the paths of one just before it, on the source's side: the last leg of
    the wall's own reflection has no length. On a rim or edge no path is diffracted by that edge,
    and on a sheet rounding decides which side's diffracted field is taken; ``Scene.stand_off``
    moves receivers off. A source on a surface is refused by the search.

    Parameters
    ----------
    radio : Scene that the candidates were searched in.
    candidates : Of one source.
    receivers_m : (m, 3) float — Places of the receivers [m].
    """
    tree = candidates.images
    receivers = checked_receivers(tree, receivers_m)
    arrays = path_arrays(radio, candidates)
    counts = np.zeros(len(receivers), dtype=np.int64)
    width = tree.max_order
    room_for = 0
    while True:  # once to count, once to record
        start = np.concatenate(([0], np.cumsum(counts)))
        number = np.zeros(room_for, dtype=np.int64)
        vertices = np.zeros((room_for, width + 2, 3))
        codes = np.zeros((room_for, width), dtype=np.int64)
        longest = _tracing_kernels.record_paths(
            *arrays, receivers, start, number, vertices, codes, counts
        )
        if room_for == int(counts.sum()):
            break
        room_for, width = int(counts.sum()), max(width, longest)
    used = np.arange(width) < number[:, None]
    kind = np.where(codes < 0, DIFFRACTION, np.where(codes < TRANSMISSION, REFLECTION, TRANSMITTED))
    element = np.where(codes < 0, -1 - codes, codes % TRANSMISSION)
    return PathSet(
        source_m=tree.source_m,
        receivers_m=receivers,
        receiver=np.repeat(np.arange(len(receivers)), counts),
        kind=np.where(used, kind, NOTHING).astype(np.int8),
        element=np.where(used, element, -1),
        vertices_m=vertices,
    )
