"""Beams in scenes of very many facets: cut into cells, and at the end held against receivers."""

from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.search import _dense_kernels
from octant.em.search.facets import SearchFacets
from octant.em.search.screens import find_screens, sight_facets
from octant.geometries import _bvh_kernels
from octant.geometries._arrays import read_only
from octant.geometries.scene import Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
Found = tuple[IntArray, IntArray, FloatArray]

RECEIVER_SLACKS = 10.0
"""Slacks [-] within which a receiver at the side of a beam counts as in it."""


class DenseBeams:
    """Finds what the beams of images see.

    Parameters
    ----------
    scene : Geometry.
    facets : Its facets as the beams of one source meet them.
    opaque_facets : (f,) bool — Facets that let nothing through.
    receivers_m : (m, 3) float64 — All receivers [m]; None: they are not known.
    """

    def __init__(
        self,
        scene: Scene,
        facets: SearchFacets,
        opaque_facets: BoolArray,
        receivers_m: FloatArray | None,
    ) -> None:
        self._slack = scene.tolerance_m
        self._facets = sight_facets(scene, facets)
        self._screens = find_screens(scene, facets, opaque_facets)
        self._receivers = None
        if receivers_m is not None:
            order, boxes, links = _bvh_kernels.build(receivers_m, receivers_m)
            points = np.ascontiguousarray(np.tile(receivers_m[order], 2))
            self._receivers = read_only((boxes, links, points))

    def expand(self, images: tuple[npt.NDArray[Any], ...], *, last: bool) -> Found:
        """Return children, windows and corners [m] of images, as `_image_kernels.expand` does.

        Parameters
        ----------
        images : Images with their windows, as that kernel takes them.
        last : Whether this is the greatest order: then no windows are kept, and of the children
            those whose beams hold a receiver.
        """
        receivers = self._receivers if last else None
        children, windows, corners = _dense_kernels.expand_seen(
            *images, self._facets, self._screens, not last or receivers is not None
        )
        if receivers is not None:
            held = _dense_kernels.hold_receivers(
                images[0],
                *read_only((children, windows, corners)),
                self._facets,
                *receivers,
                RECEIVER_SLACKS * self._slack,
            )
            children, windows, corners = children[held], windows[:0], corners[:0]
        return children, windows, corners
