"""Candidates for paths from one source: images over walls and over edges, as a solver is set."""

import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Literal

import numpy.typing as npt

from octant.em.blocks import Progress
from octant.em.medium.materials import Material
from octant.em.medium.radio_scene import RadioScene, radio_scene
from octant.em.search.edges import EdgeTree, search_edges
from octant.em.search.images import ImageTree, search_images
from octant.em.search.ray_share import wall_powers
from octant.em.search.rays import DEFAULT_RAYS, ray_search
from octant.geometries.errors import GeometryError, PhysicsWarning
from octant.geometries.scene import Scene
from octant.geometries.wedges import find_wedges


@dataclass(frozen=True, slots=True, kw_only=True)
class SolverSettings:
    """What a room's radio model includes.

    Parameters
    ----------
    max_reflections : Greatest number of bends of a path, reflections and diffractions.
    diffraction : Whether edges diffract.
    max_diffractions : Diffractions of a path: 1, or 2: over both edges of one face, or two edges
        in sight of each other, as well.
    transmission : Whether sheets with a thickness let waves through.
    search : ``complete`` finds every path; ``rays`` are launched in meshes of very many triangles.
    rays : Rays launched by ``rays`` at first.
    ray_tolerance_db : By how much [dB] the mean power may be too low for paths that rays have not
        found; more are launched until it is not. None: no more are.
    """

    max_reflections: int
    diffraction: bool = False
    max_diffractions: int = 1
    transmission: bool = False
    search: Literal["complete", "rays"] = "complete"
    rays: int = DEFAULT_RAYS
    ray_tolerance_db: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidates:
    """What the exact path stage tries for one source.

    Parameters
    ----------
    images : Images of the source.
    edges : Its images over edges; None where nothing diffracts.
    """

    images: ImageTree
    edges: EdgeTree | None = None


def radio_scenes(
    scene: Scene,
    frequencies_hz: Sequence[float],
    solver: SolverSettings,
    materials: Mapping[str, Material] | None = None,
) -> tuple[RadioScene, ...]:
    """Return a scene at each frequency [Hz], with the wedges and sheets that the solver asks for.

    Parameters
    ----------
    scene : Geometry with material labels.
    frequencies_hz : Frequencies [Hz].
    solver : Says whether edges diffract and sheets let waves through.
    materials : Meaning of labels; the others are looked up in the P.2040 table.
    """
    wedges = find_wedges(scene) if solver.diffraction else None
    return tuple(
        radio_scene(scene, f, materials, transmission=solver.transmission, wedges=wedges)
        for f in frequencies_hz
    )


def search_candidates(
    radio: RadioScene,
    source_m: npt.ArrayLike,
    solver: SolverSettings,
    *,
    region_m: npt.ArrayLike | None = None,
    receivers_m: npt.ArrayLike | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Candidates:
    """Return the candidates of one source.

    Parameters
    ----------
    radio : Scene; it says which facets let waves through and which wedges diffract.
    source_m : (3,) float — Place of the source [m], off every facet.
    solver : Greatest order, kind of search, and whether the scene's wedges count.
    region_m : (2, 3) float, optional — Box [m] that all receivers lie in; for the complete search.
    receivers_m : (m, 3) float, optional — All receivers [m] there will be, as in `search_images`.
    executor : Runs the blocks of work, sharing memory.
    progress : Called with (done, in all) as the search goes on.
    """
    if solver.search == "complete":
        images = search_images(
            radio.scene,
            source_m,
            solver.max_reflections,
            region_m=region_m,
            receivers_m=receivers_m,
            opaque_facets=radio.opaque_facets,
            executor=executor,
            progress=progress,
        )
    elif solver.search == "rays":
        images = ray_search(
            radio.scene,
            source_m,
            solver.max_reflections,
            rays=solver.rays,
            tolerance_db=solver.ray_tolerance_db,
            wall_powers=wall_powers(radio),
            opaque_facets=radio.opaque_facets,
            executor=executor,
            progress=progress,
        ).tree
        if images.rays is not None and not images.rays.suffices:
            msg = (
                f"{images.rays.text()[:-1]}, and more rays are not launched: give a greater "
                "solver.ray_tolerance_db, a lower max_reflections, or another search"
            )
            warnings.warn(msg, PhysicsWarning, stacklevel=2)
    else:
        msg = f"search = {solver.search!r} is unknown; it is 'complete' or 'rays'."
        raise GeometryError(msg)
    if not (solver.diffraction and len(radio.wedges)):
        return Candidates(images=images)
    edges = search_edges(
        radio.scene,
        radio.wedges,
        images,
        max_diffractions=solver.max_diffractions,
        executor=executor,
    )
    return Candidates(images=images, edges=edges)
