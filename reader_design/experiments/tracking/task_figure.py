"""The six panels of a tracked task: path, place, heading, error, its percentiles, wheel rates."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.missions.metrics import percentile_curve
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

COLOURS = ("#332288", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499")
WANTED = "#999999"
ARROW_M = 0.35
"""Length of the arrows at start and end [m]."""


def tracking_figure(
    outcomes: Sequence[Outcome], *, title: str, tags_m: FloatArray | None = None
) -> "Figure":
    """Return six panels of a task: path, place, heading, error, its percentiles, wheel rates.

    Parameters
    ----------
    outcomes, title : The methods (errors: median over the runs; the rest: run 0); title above.
    tags_m : (s, 2) float64, optional — Tags on the plan [m].
    """
    with figure_style():
        figure, axes = new_figure(width_in=12.4, height_in=7.2, title=title, rows=2, columns=3)
        _draw_paths(axes[0, 0], outcomes, tags_m)
        _draw_poses(axes[0, 1], axes[0, 2], outcomes)
        _draw_errors(axes[1, 0], axes[1, 1], outcomes)
        _draw_wheels(axes[1, 2], outcomes[0])
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw_paths(ax: "Axes", outcomes: Sequence[Outcome], tags_m: FloatArray | None) -> None:
    desired = outcomes[0].runs.desired.poses
    if tags_m is not None:
        ax.plot(*tags_m[:, :2].T, "x", color="#666666", markersize=5, label="tags", linestyle="")
    ax.plot(*desired[:, :2].T, color=WANTED, linewidth=4, alpha=0.5, label="desired")
    for outcome, colour in zip(outcomes, COLOURS, strict=False):
        poses = outcome.runs.poses[0]
        ax.plot(*poses[:, :2].T, color=colour, label=outcome.method, linewidth=1.2)
        for pose, face in ((poses[0], "white"), (poses[-1], colour)):
            draw_arrow(ax, pose, colour=colour, face=face)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_title("path (run 0); hollow: start")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")


def draw_arrow(ax: "Axes", pose: FloatArray, *, colour: str, face: str) -> None:
    """Draw a pose as an arrow of `ARROW_M` [m].

    Parameters
    ----------
    ax, pose : Where, and x [m], y [m], heading [rad].
    colour, face : Of its rim and of its inside.
    """
    ax.annotate(
        "",
        xy=(pose[0] + ARROW_M * np.cos(pose[2]), pose[1] + ARROW_M * np.sin(pose[2])),
        xytext=(pose[0], pose[1]),
        arrowprops={"arrowstyle": "simple", "facecolor": face, "edgecolor": colour},
    )


def _draw_poses(place: "Axes", heading: "Axes", outcomes: Sequence[Outcome]) -> None:
    time = outcomes[0].runs.desired.time_s
    desired = outcomes[0].runs.desired.poses
    for axis, dash in ((0, "-"), (1, "--")):
        place.plot(time, desired[:, axis], color=WANTED, linewidth=3.5, alpha=0.5, linestyle=dash)
    heading.plot(time, np.degrees(desired[:, 2]), color=WANTED, linewidth=3.5, alpha=0.5)
    for outcome, colour in zip(outcomes, COLOURS, strict=False):
        for axis, dash in ((0, "-"), (1, "--")):
            place.plot(
                time, outcome.runs.poses[0][:, axis], color=colour, linestyle=dash, linewidth=1
            )
        # Whole turns aside, next to the desired heading.
        turns = np.round((outcome.runs.poses[0][:, 2] - desired[:, 2]) / (2.0 * np.pi))
        angle = outcome.runs.poses[0][:, 2] - 2.0 * np.pi * turns
        heading.plot(time, np.degrees(angle), color=colour, linewidth=1)
    place.set_title("place (run 0): x solid, y dashed")
    place.set_ylabel("x, y [m]")
    heading.set_title("heading (run 0)")
    heading.set_ylabel("heading [°]")
    for ax in (place, heading):
        ax.set_xlabel("time [s]")


def _draw_errors(error: "Axes", share: "Axes", outcomes: Sequence[Outcome]) -> None:
    time = outcomes[0].runs.desired.time_s
    for outcome, colour in zip(outcomes, COLOURS, strict=False):
        errors = outcome.runs.errors_m
        middle = np.median(errors, axis=0)
        error.plot(time, middle, color=colour, linewidth=1.2)
        if len(errors) > 1:
            low, high = np.quantile(errors, [0.1, 0.9], axis=0)
            error.fill_between(time, low, high, color=colour, alpha=0.15, linewidth=0)
        percent, values = percentile_curve(errors.ravel())
        share.plot(percent, values, color=colour, linewidth=1.2)
    largest = max(float(np.quantile(o.runs.errors_m, 0.97)) for o in outcomes)
    for ax in (error, share):
        ax.set_ylabel("distance to the desired place [m]")
        ax.set_ylim(0.0, 1.25 * largest)
    many = len(outcomes[0].runs.poses) > 1
    error.set_title("error" + (": median, 10 to 90 % of the runs" if many else ""))
    error.set_xlabel("time [s]")
    share.set_title("error not exceeded" + (", all runs" if many else ""))
    share.set_xlabel("share of the time [%]")


def _draw_wheels(ax: "Axes", outcome: Outcome) -> None:
    time = outcome.runs.desired.time_s[:-1]
    for wheel, (name, colour) in enumerate((("right", COLOURS[3]), ("left", COLOURS[2]))):
        ax.step(
            time,
            outcome.runs.wheel_rates[0, :, wheel],
            where="post",
            color=colour,
            label=name,
            lw=0.9,
        )
    ax.set_title(f"wheels (run 0): {outcome.method}")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("wheel rate [rad/s]")
    ax.legend()
