"""Figures of a replay: where everything was believed, errors over time and by percentile."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.measured.replay import Replayed
from octant.reader_design.showing.plan import Plan, draw_plan, draw_tags, plan_shape
from octant.reader_design.showing.style import ANTENNA_COLOURS, figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

_PATH_COLOUR = "#bbbbbb"
_MOST_LINES = 8
_LEAST_ERROR_M = 0.01


def plan_figure(
    found: Sequence[Replayed], plan: Plan, points_m: Mapping[str, FloatArray], *, title: str
) -> "Figure":
    """Return the way of the robot and the places that were believed, over the room [m].

    Parameters
    ----------
    found, plan, title : What was said; the room; text above.
    points_m : (2,) float64 by tag — Its point on the floor [m].
    """
    path = np.concatenate([one.poses[:, :2] for one in found])
    path = path[np.isfinite(path).all(axis=1)]
    shown = np.concatenate([path, np.array(list(points_m.values())).reshape(-1, 2)])
    with figure_style():
        shape = plan_shape(plan, *shown.T)
        figure, axes = new_figure(width_in=7.4, height_in=0.9 + 4.8 * shape, title=title)
        ax = axes[0, 0]
        draw_plan(ax, plan, extra_m=shown)
        ax.plot(*path.T, ".", color=_PATH_COLOUR, markersize=3, label="robot, as recorded")
        for number, one in enumerate(found[:_MOST_LINES]):
            late = one.place_m[len(one.place_m) // 2 :]
            late = late[np.isfinite(late).all(axis=1)]
            if len(late):
                colour = ANTENNA_COLOURS[number % len(ANTENNA_COLOURS)]
                label = f"believed, {one.tag}"
                ax.plot(*late.T, "+", color=colour, markersize=5, alpha=0.7, label=label)
        draw_tags(ax, points_m)
        if len(path):
            ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return figure


def errors_figure(found: Sequence[Replayed], *, title: str) -> "Figure":
    """Return the errors of bearing [deg] and place [m] over time, tag by tag.

    Parameters
    ----------
    found, title : What was said; text above.
    """
    places = any(np.isfinite(one.place_error_m).any() for one in found)
    with figure_style():
        rows = 2 if places else 1
        figure, axes = new_figure(width_in=7.4, height_in=0.8 + 2.6 * rows, title=title, rows=rows)
        for number, one in enumerate(found[:_MOST_LINES]):
            colour = ANTENNA_COLOURS[number % len(ANTENNA_COLOURS)]
            time_s = one.time_s - min(other.time_s[0] for other in found)
            error = np.degrees(one.bearing_error_rad)
            axes[0, 0].plot(time_s, error, ".", color=colour, markersize=3, label=one.tag)
            if places:
                error_m = np.maximum(one.place_error_m, _LEAST_ERROR_M)
                axes[1, 0].plot(time_s, error_m, color=colour, linewidth=1.0, label=one.tag)
        axes[0, 0].set_ylim(-180.0, 180.0)
        axes[0, 0].set_yticks(range(-180, 181, 60))
        axes[0, 0].set_ylabel("error of the bearing [°]")
        if places:
            axes[1, 0].set_yscale("log")
            axes[1, 0].set_ylabel("error of the place [m]")
        axes[-1, 0].set_xlabel("time [s]")
        axes[0, 0].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return figure


def percentile_figure(found: Sequence[Replayed], *, title: str) -> "Figure":
    """Return the size of the bearing's error [deg] by percentile, tag by tag and of all.

    Parameters
    ----------
    found, title : What was said; text above.
    """
    share = np.linspace(0.0, 100.0, 201)
    with figure_style():
        figure, axes = new_figure(width_in=6.4, height_in=3.8, title=title)
        ax = axes[0, 0]
        sizes = [np.degrees(np.abs(one.bearing_error_rad)) for one in found]
        for number, (one, size) in enumerate(zip(found[:_MOST_LINES], sizes, strict=False)):
            known = size[np.isfinite(size)]
            if known.size:
                colour = ANTENNA_COLOURS[number % len(ANTENNA_COLOURS)]
                ax.plot(share, np.percentile(known, share), color=colour, label=one.tag)
        whole = np.concatenate(sizes)
        whole = whole[np.isfinite(whole)]
        if whole.size:
            ax.plot(share, np.percentile(whole, share), "k--", label="all tags")
        ax.plot(share, 1.8 * share, color=_PATH_COLOUR, linewidth=1.0, label="by chance")
        ax.set_xlim(0.0, 100.0)
        ax.set_ylim(0.0, math.degrees(math.pi))
        ax.set_yticks(range(0, 181, 30))
        ax.set_xlabel("percentile of the rounds [%]")
        ax.set_ylabel("error of the bearing [°]")
        ax.legend(fontsize=8)
    return figure
