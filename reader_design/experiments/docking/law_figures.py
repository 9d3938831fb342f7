"""Figures of the docking law and the regulators, as ideal closed loops."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.control.closed_loop import ClosedLoop
from octant.navigation.control.docking_law import DockingLaw
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]


def docking_law_figure(loops: Mapping[str, ClosedLoop], law: DockingLaw) -> "Figure":
    """Return figure 4 of the docking paper [m], and the Lyapunov function along each run.

    Parameters
    ----------
    loops : mapping of str to ClosedLoop
        Runs by the first bearing of the goal.
    law : DockingLaw
        The law that drove them.

    Returns
    -------
    Figure
        Two panels.
    """
    title = (
        f"Docking law: γ = {law.gamma_per_s:g}/s, h = {law.h:g}, k = {law.k_per_s:g}/s "
        "(docking paper, Fig. 4)"
    )
    with figure_style():
        figure, axes = new_figure(width_in=9.6, height_in=4.4, title=title, columns=2)
        plan, fall = axes[0]
        for name, loop in loops.items():
            (line,) = plan.plot(*loop.pose[:, :2].T, label=f"α(0) = {name}")
            _headings(plan, loop, line.get_color())
            fall.semilogy(loop.time_s, law.lyapunov(loop.polar), color=line.get_color())
        plan.plot(0.0, 0.0, "x", color="#222222", markersize=9, label="goal")
        plan.set_aspect("equal")
        plan.set_xlabel("x in the goal frame [m]")
        plan.set_ylabel("y in the goal frame [m]")
        plan.set_title("paths from 3 m away, ψ(0) = 0")
        fall.set_xlabel("time [s]")
        fall.set_ylabel("V = (e² + α² + h φ²)/2")
        fall.set_title("Lyapunov function (e in m, angles in rad)")
        figure.legend(*plan.get_legend_handles_labels(), loc="outside right center")
    return figure


def regulators_figure(loops: Mapping[str, Sequence[ClosedLoop]]) -> "Figure":
    """Return the paths of regulators to the origin [m], figures 11.19 and 11.20 of the textbook.

    Parameters
    ----------
    loops : mapping of str to sequence of ClosedLoop
        Runs by the regulator's name.

    Returns
    -------
    Figure
        One panel for each regulator.
    """
    with figure_style():
        figure, axes = new_figure(
            width_in=3.6 * len(loops),
            height_in=4.3,
            title="Regulation to the origin from two starts",
            columns=len(loops),
        )
        for ax, (name, runs) in zip(axes[0], loops.items(), strict=True):
            for loop in runs:
                x, y, heading = loop.pose[0]
                label = f"from ({x:g}, {y:g}) m, {np.degrees(heading):.0f}°"
                (line,) = ax.plot(*loop.pose[:, :2].T, label=label)
                _headings(ax, loop, line.get_color())
            ax.plot(0.0, 0.0, "x", color="#222222", markersize=9, label="goal, heading 0°")
            ax.set_aspect("equal")
            ax.set_xlim(-1.4, 1.7)
            ax.set_ylim(-1.4, 1.7)
            ax.set_xlabel("x [m]")
            ax.set_ylabel("y [m]")
            ax.set_title(name)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def gain_region_figure(laws: Mapping[str, DockingLaw]) -> "Figure":
    """Return where in the plane of h and k/γ the curvature stays bounded.

    Parameters
    ----------
    laws : mapping of str to DockingLaw
        Gains to mark, by name.

    Returns
    -------
    Figure
        One panel.
    """
    h = np.linspace(0.2, 40.0, 400)
    with figure_style():
        figure, axes = new_figure(
            width_in=6.4, height_in=4.4, title="Gains of the docking law: curvature at arrival"
        )
        ax = axes[0, 0]
        inside = h >= 1.0
        ax.fill_between(
            h[inside],
            2.0,
            h[inside] + 1.0,
            color="#117733",
            alpha=0.15,
            linewidth=0,
            label="bounded curvature",
        )
        ax.plot(h, np.full_like(h, 2.0), color="#117733", label="k = 2γ")
        ax.plot(h, h + 1.0, "--", color="#117733", label="k = γ(h + 1)")
        for (name, law), mark in zip(laws.items(), "os^Dv", strict=False):
            ax.plot(law.h, law.k_per_s / law.gamma_per_s, mark, markersize=8, label=name)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel("h [-]")
        ax.set_ylabel("k/γ [-]")
        ax.set_title("the robot arrives for all positive gains; outside, it turns without bound")
        figure.legend(*ax.get_legend_handles_labels(), loc="outside right center")
    return figure


def _headings(axes: "Axes", loop: ClosedLoop, colour: str) -> None:
    """Draw the robot's heading at places evenly spaced along the path."""
    steps = np.linalg.norm(np.diff(loop.pose[:, :2], axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    rows = np.searchsorted(way, np.linspace(0.0, 0.93 * way[-1], 7))
    pose = loop.pose[np.minimum(rows, len(way) - 1)]
    axes.quiver(
        pose[:, 0],
        pose[:, 1],
        np.cos(pose[:, 2]),
        np.sin(pose[:, 2]),
        color=colour,
        angles="xy",
        scale=16.0,
        width=0.006,
        zorder=4,
    )
