"""A room seen from above: walls and objects as lines and patches of a figure."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FloatArray = npt.NDArray[np.float64]

TAG_COLOUR = "#cc3311"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """A room seen from above.

    Attributes
    ----------
    cuts_m : (k, 2, 2) float64
        Segments in which the reader's plane cuts walls and objects [m].
    solids_m : (t, 3, 2) float64
        Triangles of closed objects, projected to the floor [m].
    bounds_m : (2, 2) float64
        Least and greatest x and y of the room [m]; zeros without any.
    """

    cuts_m: FloatArray
    solids_m: FloatArray
    bounds_m: FloatArray


def plan_of(scene: Scene, height_m: float) -> Plan:
    """Return the plan of a scene, cut at a height [m].

    Parameters
    ----------
    scene : Scene
        Room and objects.
    height_m : float
        Height coordinate of the cut in the room's frame [m].

    Returns
    -------
    Plan
        Walls and objects that the cut meets, and the footprint of closed objects at any height.
    """
    corners = [body.vertices_m[body.faces] for body in scene.bodies]
    triangles = np.concatenate(corners) if corners else np.zeros((0, 3, 3))
    solids = [solid[:, :, :2] for solid in scene.solids]
    return Plan(
        cuts_m=cut_triangles(triangles, height_m + LENGTHS.facet_per_extent * scene.extent_m),
        solids_m=np.concatenate(solids) if solids else np.zeros((0, 3, 2)),
        bounds_m=scene.bounds_m[:, :2],
    )


def cut_triangles(triangles_m: FloatArray, height_m: float) -> FloatArray:
    """Return the segments in which a horizontal plane cuts triangles, seen from above [m].

    Parameters
    ----------
    triangles_m : (t, 3, 3) float64
        Corners [m].
    height_m : float
        Height of the plane [m]; a corner exactly on it counts as above.

    Returns
    -------
    (k, 2, 2) float64
        Ends of each segment [m].
    """
    if len(triangles_m) == 0:
        return np.zeros((0, 2, 2))
    height = triangles_m[:, :, 2] - height_m
    above = height >= 0.0
    cut = np.flatnonzero(above.any(axis=1) & ~above.all(axis=1))
    corner, height, above = triangles_m[cut], height[cut], above[cut]
    lone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    row = np.arange(len(cut))
    ends = []
    for step in (1, 2):
        other = (lone + step) % 3
        here, there = height[row, lone], height[row, other]
        share = (here / (here - there))[:, None]
        a, b = corner[row, lone, :2], corner[row, other, :2]
        ends.append(a + share * (b - a))
    return np.stack(ends, axis=1)


def draw_plan(axes: "Axes", plan: Plan, *, extra_m: FloatArray | None = None) -> None:
    """Return nothing; draw walls and objects and set equal axes in [m].

    Parameters
    ----------
    axes : Axes
        Where to draw.
    plan : Plan
        From :func:`plan_of`.
    extra_m : (k, 2) float64, optional
        Points that must be in view besides the room [m].
    """
    from matplotlib.collections import LineCollection, PolyCollection

    axes.add_collection(
        PolyCollection(list(plan.solids_m), facecolor="#9a9a9a", edgecolor="#9a9a9a", zorder=2.0),
        autolim=False,
    )
    axes.add_collection(
        LineCollection(list(plan.cuts_m), colors="#222222", linewidths=1.8, zorder=2.5),
        autolim=False,
    )
    points = [plan.bounds_m] if np.ptp(plan.bounds_m) > 0.0 else []
    if extra_m is not None and len(extra_m):
        points.append(np.asarray(extra_m))
    seen = np.concatenate(points) if points else np.array([[-1.0, -1.0], [1.0, 1.0]])
    low, high = seen.min(axis=0), seen.max(axis=0)
    # Names of points at the very edge need room; walls do not.
    within = bool(points) and bool(
        (plan.bounds_m[0] <= low).all() and (plan.bounds_m[1] >= high).all()
    )
    pad = (0.04 if within else 0.09) * float(max(*(high - low), 0.5))
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(low[1] - pad, high[1] + pad)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def draw_tags(axes: "Axes", tags: Mapping[str, FloatArray]) -> None:
    """Return nothing; draw crosses with the tags' names at their points [m].

    Parameters
    ----------
    axes : Axes
        A plan view.
    tags : mapping of str to (2,) float64
        Names and points [m].
    """
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.5, foreground="white")]
    for name, point in tags.items():
        axes.plot(
            *point,
            "x",
            color=TAG_COLOUR,
            markersize=8,
            markeredgewidth=2.2,
            zorder=6,
            path_effects=[withStroke(linewidth=4.0, foreground="white")],
        )
        axes.annotate(
            name,
            (float(point[0]), float(point[1])),
            xytext=(0, 7),
            textcoords="offset points",
            ha="center",
            fontsize=8,
            color="#222222",
            path_effects=halo,
            zorder=7,
        )


def plan_shape(plan: Plan, x_m: FloatArray, y_m: FloatArray) -> float:
    """Return height over width of a plan view, kept between 0.35 and 1.8 [-].

    Parameters
    ----------
    plan : Plan
        The room.
    x_m, y_m : (k,) float64
        Coordinates that must be in view [m].

    Returns
    -------
    float
        What a page can take.
    """
    low = np.minimum(plan.bounds_m[0], [x_m.min(), y_m.min()])
    high = np.maximum(plan.bounds_m[1], [x_m.max(), y_m.max()])
    size = high - low
    return float(np.clip(size[1] / max(size[0], 1e-9), 0.35, 1.8))
