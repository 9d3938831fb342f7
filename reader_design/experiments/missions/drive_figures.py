"""What one run of a mission leaves to be drawn, and its figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.missions.metrics import measure, percentile_curve
from octant.navigation.missions.records import MissionResult
from octant.reader_design.showing.plan import Plan, draw_plan, draw_tags, plan_shape
from octant.reader_design.showing.style import (
    antenna_legend,
    draw_antennas,
    figure_style,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

PATH_COLOUR = "#332288"


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """What one run of a mission leaves to be drawn.

    Attributes
    ----------
    time_s, path_m, heading_rad : (k,), (k, 2), (k,) float64 — Time [s], robot's pose [m], [rad].
    rss_w : (k, n) float64 — RSS of every antenna from the tag in force [W].
    target : (k,) int64 — Index of the tag in force [-].
    position_error_m : (k,) float64 — Distance to the desired segment [m].
    heading_error_rad : (k,) float64 — Absolute heading error [rad].
    believed_m : (k, 2) float64 or None — Believed place of the tag in force; NaN: none [m].
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
    result : The run.
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
    drives, title : Name of the room, run, plan of each; text above.
    tags : The points to visit, in order [m]; desired segments are dashed.
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
    drives, title : Name of the room and run of each; text above.
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
    drive, tag_names, title : One run; its tags as visited, whose spans are marked; text above.
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
        ax.set_xlim(float(drive.time_s[0]), max(float(drive.time_s[-1]), 1e-9))
        ax.set_xlabel("time [s]")
        ax.set_ylabel("RSS [dBm]")
        antenna_legend(figure, ax)
    return figure
