"""A room seen from above: walls, objects and tags in a figure, and maps over the floor."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

TAG_COLOUR = "#cc3311"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """A room seen from above.

    Attributes
    ----------
    cuts_m : (k, 2, 2) float64 — Segments in which the reader's plane cuts walls and objects [m].
    solids_m : (t, 3, 2) float64 — Triangles of closed objects, projected to the floor [m].
    bounds_m : (2, 2) float64 — Least and greatest x and y of the room [m]; zeros without any.
    """

    cuts_m: FloatArray
    solids_m: FloatArray
    bounds_m: FloatArray


def plan_of(scene: Scene, height_m: float) -> Plan:
    """Return the walls and objects that a cut of a scene meets, and closed objects' footprints [m].

    Parameters
    ----------
    scene : Room and objects.
    height_m : Height coordinate of the cut in the room's frame [m].
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
    """Return the (k, 2, 2) segments in which a horizontal plane cuts triangles, from above [m].

    Parameters
    ----------
    triangles_m : (t, 3, 3) float64 — Corners [m].
    height_m : Height of the plane [m]; a corner exactly on it counts as above.
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
    """Draw walls and objects and set equal axes in [m].

    Parameters
    ----------
    axes, plan : Where to draw, and what.
    extra_m : (k, 2) float64, optional — Points that must be in view besides the room [m].
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
    """Draw crosses with the tags' names at their points [m].

    Parameters
    ----------
    axes, tags : A plan view; names and points [m].
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
    plan : The room.
    x_m, y_m : (k,) float64 — Coordinates that must be in view [m].
    """
    low = np.minimum(plan.bounds_m[0], [x_m.min(), y_m.min()])
    high = np.maximum(plan.bounds_m[1], [x_m.max(), y_m.max()])
    size = high - low
    return float(np.clip(size[1] / max(size[0], 1e-9), 0.35, 1.8))


@dataclass(frozen=True, slots=True, kw_only=True)
class MapPanel:
    """One panel of a map figure.

    Attributes
    ----------
    title : Above the panel.
    values : (ny, nx) float64 — What is mapped, in the unit of the colour bar [dBm or deg]; NaN
        where no robot can stand.
    tags : Names and places of the tags that are drawn [m].
    contour : Value along which a line is drawn, in the unit of the colour bar; None: no line.
    """

    title: str
    values: FloatArray
    tags: Mapping[str, FloatArray]
    contour: float | None = None


def map_figure(
    x_m: FloatArray,
    y_m: FloatArray,
    panels: Sequence[MapPanel],
    plan: Plan,
    *,
    title: str,
    bar_label: str,
    limits: tuple[float, float] | None = None,
    colours: str = "viridis",
    columns: int = 2,
    levels: int | None = None,
) -> "Figure":
    """Return plan views of the room with one colour bar, axes in [m]; grey: no robot can stand.

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Grid [m].
    panels : One map each.
    plan : Walls and objects.
    title : Above the figure.
    bar_label : Quantity and unit at the colour bar.
    limits : (float, float), optional — Ends of the colour bar in its unit [dBm] or [deg]; default:
        the 2nd and 99.8th percentile of all panels.
    colours : Matplotlib colour map.
    columns : Most panels in a row.
    levels : Number of colours between the limits; default: a smooth bar.
    """
    from matplotlib import colormaps

    columns = min(len(panels), columns)
    rows = -(-len(panels) // columns)
    finite = np.concatenate([p.values[np.isfinite(p.values)] for p in panels])
    extend = "neither" if limits is not None else "both"
    if limits is None:
        limits = tuple(np.quantile(finite, [0.02, 0.998])) if finite.size else (0.0, 1.0)
    extent = plan_shape(plan, x_m, y_m)
    colour_map = colormaps[colours] if levels is None else colormaps[colours].resampled(levels)
    with figure_style():
        figure, axes = new_figure(
            width_in=1.3 + 4.1 * columns,
            height_in=0.6 + 0.25 * title.count("\n") + (0.85 + 3.35 * extent) * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        mesh: Any = None
        for k, panel in enumerate(panels):
            ax = axes[k // columns, k % columns]
            ax.set_facecolor("#d8d8d8")
            ax.grid(visible=False)
            mesh = ax.pcolormesh(
                x_m,
                y_m,
                panel.values,
                shading="nearest",
                cmap=colour_map,
                vmin=limits[0],
                vmax=limits[1],
                rasterized=True,
            )
            _draw_contour(ax, x_m, y_m, panel)
            draw_plan(ax, plan, extra_m=np.array([[x_m[0], y_m[0]], [x_m[-1], y_m[-1]]]))
            draw_tags(ax, panel.tags)
            ax.set_title(panel.title)
        for k in range(len(panels), rows * columns):
            axes[k // columns, k % columns].set_visible(False)
        bar = figure.colorbar(
            mesh, ax=list(axes.ravel()), label=bar_label, shrink=0.9, extend=extend, aspect=30
        )
        bar.outline.set_visible(False)
    return figure


def _draw_contour(axes: "Axes", x_m: FloatArray, y_m: FloatArray, panel: MapPanel) -> None:
    """Draw where a map crosses a value, white on a dark line; nothing where it does not."""
    from matplotlib.patheffects import withStroke

    level, values = panel.contour, panel.values
    known = values[np.isfinite(values)]
    if level is None or min(values.shape) < 2 or not known.size:
        return
    if known.min() < level < known.max():
        line: Any = {"linewidths": 1.2, "linestyles": "solid"}
        drawn = axes.contour(x_m, y_m, values, levels=[level], colors="white", **line)
        drawn.set_path_effects([withStroke(linewidth=2.6, foreground="#222222")])
