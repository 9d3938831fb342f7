"""Figures of what the textbook and the docking paper derive: odometry, observability."""

from typing import TYPE_CHECKING

import numpy as np

from octant.navigation.estimators.observability import (
    attitude_gramian,
    position_gramian,
    slip_deviation,
)
from octant.navigation.robot.motion import Integration, move
from octant.reader_design.experiments.docking.textbook import (
    INTEGRATIONS,
    TURN_RATES_RAD_PER_S,
    half_circle,
    odometry_error_m,
)
from octant.reader_design.showing.style import figure_style, new_figure
from octant.reader_design.study_file.dock import Dock

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TRACT_RAD = np.radians(100.0)


def odometry_figure(table: Dock) -> "Figure":
    """Return figure 11.21 of the textbook [m], and the error of half a circle by period [m].

    Parameters
    ----------
    table : The table ``[dock]``: its limits make the circle.
    """
    speed, turn_rate, time_s = half_circle(table)
    periods = np.geomspace(0.02, 0.4 * time_s, 25)
    with figure_style():
        figure, axes = new_figure(
            width_in=12.4,
            height_in=3.9,
            title="Odometry of an arc of constant v and ω (textbook, Fig. 11.21)",
            columns=4,
        )
        for ax, (name, method) in zip(axes[0], INTEGRATIONS.items(), strict=False):
            _tract(ax, method)
            ax.set_title(name)
        axes[0, 0].set_ylabel("y [radii]")
        growth = axes[0, 3]
        for (name, method), style in zip(INTEGRATIONS.items(), ("-", "--", ":"), strict=True):
            errors = [odometry_error_m(table, method, float(period)) for period in periods]
            growth.loglog(periods, np.maximum(errors, 1e-17), style, label=name)
        growth.set_xlabel("sample period T [s]")
        growth.set_ylabel("error at the end [m]")
        growth.set_title(f"half a circle at {speed:g} m/s, {turn_rate:.2g} rad/s")
        handles = [*axes[0, 0].get_legend_handles_labels()[0], *growth.get_lines()]
        figure.legend(handles=handles, loc="outside lower center", ncols=6)
    return figure


def _tract(axes: "Axes", method: Integration) -> None:
    """Draw one tract of an arc, and where a step of odometry believes its end."""
    along = np.linspace(0.0, _TRACT_RAD, 100)
    way = np.column_stack([np.sin(along), 1.0 - np.cos(along), along])
    end = move(np.zeros(3), distance_m=_TRACT_RAD, turn_rad=_TRACT_RAD, method=method)
    axes.plot(*way[:, :2].T, color="#777777", label="true way")
    axes.plot([0.0, end[0]], [0.0, end[1]], "--", color="#cc6677", label="step of odometry")
    for pose, colour, label in (
        (way[0], "#222222", "q(k)"),
        (way[-1], "#777777", "true q(k+1)"),
        (end, "#cc6677", "q(k+1) by odometry"),
    ):
        axes.plot(*pose[:2], "o", color=colour, label=label)
        axes.quiver(
            *pose[:2], np.cos(pose[2]), np.sin(pose[2]), color=colour, angles="xy", scale=6.0
        )
    axes.set_aspect("equal")
    axes.set_xlim(-0.3, 2.1)
    axes.set_ylim(-0.3, 2.0)
    axes.set_xlabel("x [radii]")


def observability_figure(table: Dock) -> "Figure":
    """Return how well the slips can be known after a time in sight of the landmark [m/s], [rad/s].

    Parameters
    ----------
    table : The table ``[dock]``: noise of the camera and its sample time.
    """
    times = np.geomspace(0.5, 60.0, 60)
    period_s = table.sample_time_s
    with figure_style():
        figure, axes = new_figure(
            width_in=9.6,
            height_in=4.2,
            title="What a landmark in sight tells of the slips (docking paper, (7) and (27))",
            columns=2,
        )
        place, attitude = axes[0]
        for rate, style in zip(TURN_RATES_RAD_PER_S, ("-", "--", ":"), strict=True):
            known = [
                slip_deviation(
                    position_gramian(float(t), turn_rate_rad_per_s=rate),
                    measured_variance=table.position_sd_m**2,
                    period_s=period_s,
                )
                for t in times
            ]
            place.loglog(times, known, style, label=f"ω = {rate:g} rad/s")
        variance = float(np.radians(table.attitude_sd_deg)) ** 2
        attitude.loglog(
            times,
            [
                slip_deviation(
                    attitude_gramian(float(t)), measured_variance=variance, period_s=period_s
                )
                for t in times
            ],
            color="#222222",
            label="any motion",
        )
        place.set_ylabel("least deviation of the linear slip b [m/s]")
        attitude.set_ylabel("least deviation of the angular slip s [rad/s]")
        for ax in (place, attitude):
            ax.set_xlabel("time in sight [s]")
            ax.legend()
    return figure


def textbook_figures(table: Dock) -> dict[str, "Figure"]:
    """Return these figures by file name [m], [s].

    Parameters
    ----------
    table : The table ``[dock]``.
    """
    return {
        "dock_odometry": odometry_figure(table),
        "dock_observability": observability_figure(table),
    }
