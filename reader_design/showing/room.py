"""Figures of the room: plan views of maps, and what a mission did.

As in :mod:`octant.reader_design.showing.style`, every function takes arrays and returns a figure.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.missions.metrics import measure, percentile_curve
from octant.navigation.missions.records import MissionResult
from octant.reader_design.showing.plan import Plan, draw_plan, draw_tags, plan_of, plan_shape
from octant.reader_design.showing.style import (
    antenna_legend,
    draw_antennas,
    figure_style,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Drive",
    "MapPanel",
    "drive_of",
    "map_figure",
    "percentile_figure",
    "plan_of",
    "rss_time_figure",
    "trajectory_figure",
]

FloatArray = npt.NDArray[np.float64]

PATH_COLOUR = "#332288"


@dataclass(frozen=True, slots=True, kw_only=True)
class MapPanel:
    """One panel of a map figure.

    Attributes
    ----------
    title : str
        Above the panel.
    values : (ny, nx) float64
        What is mapped, in the unit of the colour bar [dBm or deg]; NaN where no robot can stand.
    tags : mapping of str to (2,) float64
        Names and places of the tags that are drawn [m].
    """

    title: str
    values: FloatArray
    tags: Mapping[str, FloatArray]


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
    """Return plan views of the room with one common colour bar, axes in [m].

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64
        Grid [m].
    panels : sequence of MapPanel
        One map each.
    plan : Plan
        Walls and objects.
    title : str
        Above the figure.
    bar_label : str
        Quantity and unit at the colour bar.
    limits : (float, float), optional
        Ends of the colour bar in its unit [dBm] or [deg]; default: the 2nd and 99.8th percentile
        of all panels.
    colours : str
        Matplotlib colour map.
    columns : int
        Most panels in a row.
    levels : int, optional
        Number of colours between the limits; default: a smooth bar.

    Returns
    -------
    Figure
        Grey where no robot can stand.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """What one run of a mission leaves to be drawn.

    Attributes
    ----------
    time_s : (k,) float64
        Times [s].
    path_m : (k, 2) float64
        Robot's positions [m].
    heading_rad : (k,) float64
        Robot's headings [rad].
    rss_w : (k, n) float64
        RSS of every antenna from the tag in force [W].
    target : (k,) int64
        Index of the tag in force [-].
    position_error_m : (k,) float64
        Distance to the desired segment [m].
    heading_error_rad : (k,) float64
        Absolute heading error [rad].
    believed_m : (k, 2) float64 or None
        Where the navigator believed the tag in force [m]; NaN where nowhere.
    """

    time_s: FloatArray
    path_m: FloatArray
    heading_rad: FloatArray
    rss_w: FloatArray
    target: npt.NDArray[np.int64]
    position_error_m: FloatArray
    heading_error_rad: FloatArray
    believed_m: FloatArray | None = None


def drive_of(result: MissionResult) -> Drive:
    """Return a run as the figures take it.

    Parameters
    ----------
    result : MissionResult
        The run.

    Returns
    -------
    Drive
        With its errors to the straight segments ([s], [m], [rad], [W]).
    """
    metrics = measure(result)
    return Drive(
        time_s=result.time_s,
        path_m=result.poses[:, :2],
        heading_rad=result.poses[:, 2],
        rss_w=result.rss_w,
        target=result.targets,
        position_error_m=metrics.position_errors_m,
        heading_error_rad=metrics.heading_errors_rad,
        believed_m=result.believed_points_m,
    )


def trajectory_figure(
    drives: Sequence[tuple[str, Drive, Plan]],
    tags: Mapping[str, FloatArray],
    *,
    title: str,
) -> "Figure":
    """Return the robot's path through each room, axes in [m], as in thesis Fig. 5.12 (a).

    Parameters
    ----------
    drives : sequence of (str, Drive, Plan)
        Name of the room, run, plan.
    tags : mapping of str to (2,) float64
        The points to visit, in order [m].
    title : str
        Above the figure.

    Returns
    -------
    Figure
        Desired segments dashed, tags as crosses, the path as a line.
    """
    columns = min(len(drives), 3)
    rows = -(-len(drives) // columns)
    points = np.array(list(tags.values())).reshape(-1, 2)
    shape = max(plan_shape(plan, *np.concatenate([points, d.path_m]).T) for _, d, plan in drives)
    with figure_style():
        figure, axes = new_figure(
            width_in=0.6 + (3.6 if columns > 1 else 5.2) * columns,
            height_in=0.9 + (0.5 + (2.95 if columns > 1 else 4.6) * shape) * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        for k, (name, drive, plan) in enumerate(drives):
            ax = axes[k // columns, k % columns]
            draw_plan(ax, plan, extra_m=np.concatenate([points, drive.path_m]))
            wanted = np.concatenate([drive.path_m[:1], points])
            ax.plot(*wanted.T, "--", color="#777777", linewidth=1.2, label="desired", zorder=3)
            ax.plot(*drive.path_m.T, color=PATH_COLOUR, label="path of run 0", zorder=4)
            ax.plot(*drive.path_m[0], "o", color=PATH_COLOUR, label="start", zorder=5)
            draw_tags(ax, tags)
            ax.set_title(name)
        for k in range(len(drives), rows * columns):
            axes[k // columns, k % columns].set_visible(False)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def percentile_figure(drives: Sequence[tuple[str, Drive]], *, title: str) -> "Figure":
    """Return position [cm] and heading error [deg] against their percentile, thesis Fig. 5.12 (b).

    Parameters
    ----------
    drives : sequence of (str, Drive)
        Name of the room and run.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        Two panels; the 90th percentile is marked.
    """
    share = np.linspace(0.0, 100.0, 201)
    with figure_style():
        figure, axes = new_figure(width_in=8.6, height_in=3.5, title=title, columns=2)
        for k, (name, drive) in enumerate(drives):
            errors = (100.0 * drive.position_error_m, np.degrees(np.abs(drive.heading_error_rad)))
            for ax, error in zip(axes[0], errors, strict=True):
                known = error[np.isfinite(error)]
                if known.size:
                    ax.plot(
                        *percentile_curve(known, share),
                        label=name,
                        linestyle=("-", "--", "-.", ":")[k % 4],
                    )
        for ax, label in zip(axes[0], ("position error [cm]", "heading error [°]"), strict=True):
            ax.axvline(90.0, color="#999999", linewidth=0.9, linestyle=":")
            ax.set_xlim(0.0, 100.0)
            ax.set_ylim(bottom=0.0)
            ax.set_xlabel("percentile of the time [%]")
            ax.set_ylabel(label)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def rss_time_figure(drive: Drive, tag_names: Sequence[str], *, title: str) -> "Figure":
    """Return RSS [dBm] of all antennas over time [s], as in thesis Fig. 5.12 (c).

    Parameters
    ----------
    drive : Drive
        One run.
    tag_names : sequence of str
        Names of the tags in the order of the visit; their spans are marked.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        One panel.
    """
    with figure_style():
        figure, axes = new_figure(width_in=9.2, height_in=3.8, title=title)
        ax = axes[0, 0]
        level = power_dbm(np.maximum(drive.rss_w, 0.0))
        draw_antennas(ax, drive.time_s, level)
        finite = level[np.isfinite(level)]
        if finite.size:
            ax.set_ylim(
                max(float(finite.min()), float(finite.max()) - 60.0) - 1.0, finite.max() + 5
            )
        edges = np.flatnonzero(np.diff(drive.target)) + 1
        starts = np.concatenate([[0], edges])
        for start in starts[1:]:
            ax.axvline(drive.time_s[start], color="#555555", linewidth=0.9, linestyle=":")
        upper = ax.get_ylim()[1]
        for start in starts:
            index = int(drive.target[start])
            if 0 <= index < len(tag_names):
                ax.annotate(
                    f"to {tag_names[index]}",
                    (float(drive.time_s[start]), upper),
                    xytext=(3, -3),
                    textcoords="offset points",
                    va="top",
                    fontsize=8,
                    color="#444444",
                )
        ax.set_xlim(float(drive.time_s[0]), float(drive.time_s[-1]))
        ax.set_xlabel("time [s]")
        ax.set_ylabel("RSS [dBm]")
        antenna_legend(figure, ax)
    return figure
