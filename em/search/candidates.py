"""Candidates for paths from one source: images over walls, ways over edges."""

from dataclasses import dataclass
from typing import Literal

import numpy.typing as npt

from octant.em.blocks import Progress
from octant.em.medium.radio_scene import RadioScene
from octant.em.search.edge_search import EdgeTree, search_edges
from octant.em.search.image_tree import ImageTree
from octant.em.search.ray_search import DEFAULT_RAYS, find_images


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidates:
    """What the exact path stage tries for one source.

    Parameters
    ----------
    images : ImageTree
        Images of the source.
    edges : EdgeTree or None
        Ways over edges; None where nothing diffracts.
    """

    images: ImageTree
    edges: EdgeTree | None


def search_candidates(
    radio: RadioScene,
    source_m: npt.ArrayLike,
    max_reflections: int,
    *,
    max_diffractions: int = 1,
    search: Literal["complete", "rays"] = "complete",
    rays: int = DEFAULT_RAYS,
    region_m: npt.ArrayLike | None = None,
    progress: Progress | None = None,
) -> Candidates:
    """Return the candidates of one source, as the radio scene's walls and wedges ask for.

    Parameters
    ----------
    radio : RadioScene
        Scene; it says which facets let waves through and which wedges diffract.
    source_m : (3,) float
        Place of the source [m].
    max_reflections : int
        Greatest number of bends of a path: reflections and diffractions.
    max_diffractions : int
        Diffractions of a path, 1 or 2, where the scene has wedges.
    search : str
        ``complete``, or ``rays``: what launched rays find, for meshes of very many triangles.
    rays : int
        Rays launched by ``rays``.
    region_m : (2, 3) float, optional
        Box [m] that all receivers lie in.
    progress : callable, optional
        Told (images done, images in all) of each order.

    Returns
    -------
    Candidates
        Images and ways over edges.

    Raises
    ------
    GeometryError
        For a bad source or order, an unknown search, or more candidates than memory takes.
    """
    images = find_images(
        radio.scene,
        source_m,
        max_reflections,
        search=search,
        rays=rays,
        region_m=region_m,
        opaque_facets=radio.opaque_facets,
        progress=progress,
    )
    if len(radio.wedges) == 0:
        return Candidates(images=images, edges=None)
    edges = search_edges(radio.scene, radio.wedges, images, max_diffractions=max_diffractions)
    return Candidates(images=images, edges=edges)
