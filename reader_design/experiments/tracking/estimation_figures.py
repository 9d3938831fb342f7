"""Figures of estimation and cost: SLAM (thesis Fig. 7.15), the room solver's part, Table 8.1."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.reader_design.experiments.tracking.costs import CostScaling
from octant.reader_design.experiments.tracking.figures import COLOURS, WANTED
from octant.reader_design.experiments.tracking.outcomes import Outcome
from octant.reader_design.experiments.tracking.room import RoomResults
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

ELLIPSE_SCALE = 50.0
"""The pose's one-sigma ellipse is millimetres wide: it is drawn this much larger [-]."""


def slam_figure(record: SlamRecord, tags_m: FloatArray, *, wheel_sigma: float) -> "Figure":
    """Return way, map and errors of EKF SLAM: thesis Fig. 7.15.

    Parameters
    ----------
    record : SlamRecord
        The runs; run 0 is drawn.
    tags_m : (s, 2) float64
        True tags [m].
    wheel_sigma : float
        Noise of the wheels, for the title [rad/s].
    """
    from matplotlib.gridspec import GridSpec

    with figure_style():
        figure, axes = new_figure(
            width_in=11.0,
            height_in=5.2,
            title=f"EKF SLAM along 3 m, wheel noise {wheel_sigma:g} rad/s",
            columns=1,
        )
        axes[0, 0].remove()
        grid = GridSpec(3, 2, figure=figure)
        plan = figure.add_subplot(grid[:, 0])
        plan.plot(*tags_m.T, "x", color="#222222", label="tags")
        plan.plot(*record.true_poses[0, :, :2].T, color=WANTED, linewidth=4, label="true way")
        plan.plot(*record.poses[0, :, :2].T, color=COLOURS[0], label="estimated way")
        mean, covariance = record.final.mean[0], record.final.covariance[0]
        label: str | None = f"pose, one sigma x {ELLIPSE_SCALE:g}"
        _ellipse(plan, mean[:2], ELLIPSE_SCALE**2 * covariance[:2, :2], COLOURS[0], label)
        for tag in range(len(tags_m)):
            at = slice(3 + 2 * tag, 5 + 2 * tag)
            label = "tags by SLAM, one sigma" if tag == 0 else None
            _ellipse(plan, mean[at], covariance[at, at], COLOURS[1], label)
        plan.set_aspect("equal", adjustable="datalim")
        plan.set_title("plan (run 0)")
        plan.set_xlabel("x [m]")
        plan.set_ylabel("y [m]")
        plan.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=3)
        error = record.poses - record.true_poses
        error[..., 2] = wrap_angle(error[..., 2])
        names = (("x", 1000.0, "mm"), ("y", 1000.0, "mm"), ("heading", np.degrees(1.0), "°"))
        for row, (name, scale, unit) in enumerate(names):
            ax = figure.add_subplot(grid[row, 1])
            ax.plot(record.time_s, scale * error[:, :, row].T, color="#bbbbbb", linewidth=0.4)
            ax.plot(record.time_s, scale * error[0, :, row], color=COLOURS[0], linewidth=1.3)
            for sign in (-1.0, 1.0):
                sigma = sign * scale * record.sigmas[0, :, row]
                ax.plot(record.time_s, sigma, color=COLOURS[1], linestyle="--", linewidth=1.2)
            ax.set_ylabel(f"{name} error [{unit}]")
        figure.axes[1].set_title("errors: run 0, all runs (grey), ± one sigma (dashed)")
        figure.axes[-1].set_xlabel("time [s]")
    return figure


def _ellipse(
    ax: "Axes", centre: FloatArray, covariance: FloatArray, colour: str, label: str | None
) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    root = np.linalg.cholesky(covariance + 1e-15 * np.eye(2))
    points = centre[:, None] + root @ np.stack([np.cos(angle), np.sin(angle)])
    ax.plot(*centre, "+", color=colour)
    ax.plot(*points, color=colour, linewidth=1.0, label=label)


def room_figure(results: RoomResults) -> "Figure":
    """Return the field of one tag with the ways of run 0, and the errors of all estimators.

    Parameters
    ----------
    results : RoomResults
        The room solver's part ([m], [dBm]).

    Returns
    -------
    Figure
        A map and a chart: dots are runs' averages, bars their medians.
    """
    tasks = tuple(dict.fromkeys(o.task for o in results.outcomes))
    methods = tuple(dict.fromkeys(o.method for o in results.outcomes))
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=12.0,
            height_in=4.8,
            title="Tracking the lemniscate with RSS from the room solver",
            columns=2,
        )
        ax = axes[0]
        ax.grid(visible=False)
        mesh = ax.pcolormesh(
            results.map_x_m, results.map_x_m, results.map_dbm.T, shading="nearest", rasterized=True
        )
        figure.colorbar(mesh, ax=ax, label="RSS of the middle tag [dBm]")
        best = results.outcomes[0]
        ax.plot(*best.desired.poses[:, :2].T, color="white", linewidth=3, label="desired")
        ax.plot(*best.poses[0, :, :2].T, color=COLOURS[1], linewidth=1.3, label=best.method)
        ax.set_aspect("equal")
        ax.set_title(f"coherent field, and run 0 with {best.task}")
        ax.set_xlabel("x [m]")
        ax.set_ylabel("y [m]")
        ax.legend(loc="lower left", frameon=True, fontsize=7.5)
        _draw_averages(axes[1], results.outcomes, tasks, methods)
    return figure


def _draw_averages(
    ax: "Axes", outcomes: Sequence[Outcome], tasks: Sequence[str], methods: Sequence[str]
) -> None:
    width = 0.8 / len(tasks)
    for t, task in enumerate(tasks):
        for m, method in enumerate(methods):
            for outcome in outcomes:
                if (outcome.task, outcome.method) != (task, method):
                    continue
                average = outcome.measures()["average_m"]
                row = len(methods) - 1 - m + (0.5 * (len(tasks) - 1) - t) * width
                label = task if m == 0 else None
                median = float(np.median(average))
                ax.barh(row, median, height=0.9 * width, color=COLOURS[t], alpha=0.75, label=label)
                ax.plot(average, np.full(len(average), row), ".", color="#222222", markersize=2)
                right = 1.08 * float(average.max())
                ax.text(right, row, f"{median:.3f}", va="center", fontsize=7.5)
    ax.set_yticks(np.arange(len(methods))[::-1], methods)
    ax.set_xscale("log")
    ax.margins(x=0.12)
    ax.set_title("average error: median (bar), every run (dots)")
    ax.set_xlabel("average distance to the desired place [m]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.35, -0.12), ncols=2)


def cost_figure(scalings: Sequence[CostScaling]) -> "Figure":
    """Return measured costs against what Table 8.1 says that they are proportional to.

    Parameters
    ----------
    scalings : sequence of CostScaling
        One panel each; times in [µs].
    """
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=1.0 + 3.7 * len(scalings),
            height_in=3.8,
            title="Measured cost against Table 8.1",
            columns=len(scalings),
        )
        for ax, scaling in zip(axes, scalings, strict=True):
            for (name, times), colour in zip(scaling.times_us.items(), COLOURS, strict=False):
                slope = scaling.exponent(name)
                ax.loglog(
                    scaling.sizes, times, "o-", color=colour, label=f"{name}: ∝ n^{slope:.2f}"
                )
            first = next(iter(scaling.times_us.values()))
            sizes = np.asarray(scaling.sizes, dtype=np.float64)
            ax.loglog(
                sizes, first[-1] * sizes / sizes[-1], "--", color=WANTED, label="proportional"
            )
            ax.set_xlabel(scaling.quantity)
            ax.set_ylabel("time [µs]")
            ax.set_title(scaling.what)
            ax.legend(fontsize=7.5)
    return figure
