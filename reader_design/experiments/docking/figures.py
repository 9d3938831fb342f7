"""Figures of a docking study: its missions, the landmark filters and the docking law."""

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.control.closed_loop import ClosedLoop
from octant.navigation.control.docking_law import DockingLaw, stall_distance_m
from octant.navigation.control.polar import pose_in_goal_frame
from octant.navigation.docking.task import DockingResult
from octant.reader_design.experiments.docking.compute import DockingContent, dock_table
from octant.reader_design.experiments.docking.filter_figures import filter_figures, legend_below
from octant.reader_design.experiments.docking.published import (
    FilterExperiment,
    figure_4_law,
    figure_4_loops,
    regulator_loops,
)
from octant.reader_design.experiments.docking.textbook_figures import textbook_figures
from octant.reader_design.showing.plan import Plan, draw_plan, draw_tags, plan_of, plan_shape
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]


_MOST_PATHS = 20
PHASE_COLOURS = {
    "approach": "#332288",
    "search": "#ddaa33",
    "refine": "#88ccee",
    "dock": "#117733",
    "back off": "#cc6677",
}


def docking_paths_figure(
    rooms: Sequence[tuple[str, Sequence[DockingResult], Plan]],
    tag: tuple[str, FloatArray],
    *,
    title: str,
) -> "Figure":
    """Return the robots' paths of up to 20 runs in each room [m]; failed ones end in a cross.

    Parameters
    ----------
    rooms, title : Name, runs and plan of each; title above the figure.
    tag : (str, (2,) float64) — The station's tag and its point on the floor [m].
    """
    reach = [np.concatenate([r.poses[:, :2] for r in runs[:_MOST_PATHS]]) for _, runs, _ in rooms]
    shape = max(
        plan_shape(plan, *points.T) for (_, _, plan), points in zip(rooms, reach, strict=True)
    )
    with figure_style():
        figure, axes = new_figure(
            width_in=0.6 + 4.4 * len(rooms),
            height_in=1.2 + 4.0 * shape,
            title=title,
            columns=len(rooms),
        )
        for ax, (name, runs, plan), points in zip(axes[0], rooms, reach, strict=True):
            draw_plan(ax, plan, extra_m=points)
            for result in runs[:_MOST_PATHS]:
                _draw_path(ax, result)
            landmark = runs[0].task.landmark
            ax.plot(*landmark.position_m[:2], "s", color="#222222", label="landmark", zorder=6)
            draw_tags(ax, {tag[0]: tag[1]})
            docked = sum(result.success for result in runs)
            ax.set_title(f"{name}: {docked} of {len(runs)} docked")
        legend_below(figure, *axes[0], columns=7 if len(rooms) > 1 else 4)
    return figure


def docking_figure(result: DockingResult, *, title: str) -> "Figure":
    """Return one docking over time, figures 18 and 19 of the docking paper [m], [rad], [s].

    Parameters
    ----------
    result, title : A run that docks, of which the last try is shown; title above the figure.
    """
    rows = _last_docking(result)
    time = result.time_s[rows] - result.time_s[rows[0]]
    way = pose_in_goal_frame(result.poses[rows], result.task.goal)
    law = result.task.fine.law
    polar, twist = result.polar[rows], result.twist[rows]
    with figure_style():
        figure, axes = new_figure(width_in=10.4, height_in=6.4, title=title, rows=2, columns=3)
        plan = axes[0, 0]
        plan.plot(way[:, 0], way[:, 1], color=PHASE_COLOURS["dock"], label="true path")
        plan.plot(0.0, 0.0, "x", color="#222222", markersize=9, label="dock")
        plan.set_aspect("equal", adjustable="datalim")
        plan.set_xlabel("x in the goal frame [m]")
        plan.set_ylabel("y in the goal frame [m]")
        plan.legend(loc="best")
        for ax, values, label in (
            (axes[0, 1], twist[:, 0], "speed command v [m/s]"),
            (axes[0, 2], twist[:, 1], "turn command ω [rad/s]"),
            (axes[1, 0], polar[:, 0], "estimated e [m]"),
            (axes[1, 1], None, "estimated angles [rad]"),
            (axes[1, 2], law.lyapunov(polar), "V = (e² + α² + h φ²)/2"),
        ):
            if values is not None:
                ax.plot(time, values)
            ax.set_xlabel("time [s]")
            ax.set_ylabel(label)
        axes[1, 0].plot(time, np.hypot(*way[:, :2].T), "--", color="#222222", label="true e")
        axes[1, 0].legend()
        axes[1, 1].plot(time, polar[:, 1], label="α")
        axes[1, 1].plot(time, polar[:, 2], label="φ")
        axes[1, 1].legend()
        axes[1, 2].set_yscale("log")
    return figure


def stall_figure(
    runs: Mapping[bool, Sequence[DockingResult]], law: DockingLaw, *, slip_m_per_s: float
) -> "Figure":
    """Return the true distance from the dock over time with and without slip compensation [m], [s].

    Parameters
    ----------
    runs : By whether slips were compensated.
    law, slip_m_per_s : Gains, and the linear slip b [m/s].
    """
    with figure_style():
        figure, axes = new_figure(
            width_in=8.4, height_in=4.0, title=f"Docking with a slip of {slip_m_per_s:g} m/s"
        )
        ax = axes[0, 0]
        for compensated, colour, label in (
            (True, "#332288", "command v - b̂, ω - ŝ"),
            (False, "#cc6677", "without compensation"),
        ):
            for k, result in enumerate(runs[compensated][:10]):
                rows = _last_docking(result)
                away = np.hypot(*pose_in_goal_frame(result.poses[rows], result.task.goal)[:, :2].T)
                ax.semilogy(
                    result.time_s[rows] - result.time_s[rows[0]],
                    away,
                    color=colour,
                    linewidth=0.9,
                    label=label if k == 0 else None,
                )
        stall_m = stall_distance_m(law, slip_m_per_s)
        ax.axhline(stall_m, color="#222222", linestyle="--", label=f"|b|/γ = {stall_m:.3g} m")
        ax.set_xlabel("time since the docking began [s]")
        ax.set_ylabel("true distance from the dock [m]")
        figure.legend(*ax.get_legend_handles_labels(), loc="outside right center")
    return figure


def docking_errors_figure(rooms: Mapping[str, Sequence[DockingResult]]) -> "Figure":
    """Return where docked robots stand in the goal frame [cm], and their headings [deg].

    Parameters
    ----------
    rooms : Runs by room.
    """
    with figure_style():
        figure, axes = new_figure(
            width_in=9.4, height_in=4.2, title="Where docked robots stand", columns=2
        )
        place, turn = axes[0]
        for name, runs in rooms.items():
            final = np.array([result.final for result in runs if result.success]).reshape(-1, 3)
            place.plot(*(100.0 * final[:, :2].T), ".", label=name)
            turn.hist(np.degrees(final[:, 2]), bins=15, alpha=0.5, label=name)
        tolerance = 100.0 * next(iter(rooms.values()))[0].task.tolerance_m
        circle = np.linspace(0.0, 2.0 * np.pi, 200)
        place.plot(
            tolerance * np.cos(circle),
            tolerance * np.sin(circle),
            "--",
            color="#777777",
            label="station's contact",
        )
        place.set_aspect("equal")
        place.set_xlabel("x in the goal frame [cm]")
        place.set_ylabel("y in the goal frame [cm]")
        turn.set_xlabel("final heading error [°]")
        turn.set_ylabel("runs [-]")
        figure.legend(*place.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _draw_path(axes: "Axes", result: DockingResult) -> None:
    phases = np.array(result.phases)
    xy = result.poses[:, :2]
    begins = np.concatenate([[0], np.flatnonzero(phases[1:] != phases[:-1]) + 1, [len(phases) - 1]])
    for begin, end in itertools.pairwise(begins):
        phase = str(phases[begin])
        axes.plot(
            *xy[begin : end + 1].T,
            color=PHASE_COLOURS[phase],
            linewidth=0.9,
            label=phase,
            zorder=4,
        )
    axes.plot(*xy[0], "o", color="#555555", markersize=3, label="start", zorder=5)
    if not result.success:
        axes.plot(*xy[-1], "X", color="#000000", label="failed", zorder=7)


def _last_docking(result: DockingResult) -> npt.NDArray[np.int64]:
    """Return the rows in which the last try that got so far followed the law, at least two."""
    docking = np.isfinite(result.polar[:, 0])
    between = np.array([phase in {"back off", "search"} for phase in result.phases])
    tries = np.cumsum(between)
    rows = np.flatnonzero(docking & (tries == tries[docking].max(initial=-1)))
    return rows if len(rows) > 1 else np.arange(len(docking))[-2:]


def docking_law_figure(loops: Mapping[str, ClosedLoop], law: DockingLaw) -> "Figure":
    """Return figure 4 of the docking paper [m], and the Lyapunov function along each run.

    Parameters
    ----------
    loops, law : Runs by the first bearing of the goal, and the law that drove them.
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
    loops : Runs by the regulator's name.
    """
    with figure_style():
        figure, axes = new_figure(
            width_in=3.6 * len(loops),
            height_in=4.3,
            title=f"Regulation to the origin from {len(next(iter(loops.values())))} starts",
            columns=len(loops),
        )
        corners = np.array([loop.pose[0, :2] for runs in loops.values() for loop in runs])
        low = np.minimum(-1.4, corners.min(axis=0) - 0.4)
        high = np.maximum(1.7, corners.max(axis=0) + 0.7)
        for ax, (name, runs) in zip(axes[0], loops.items(), strict=True):
            for loop in runs:
                x, y, heading = np.round(loop.pose[0], 9) + 0.0
                label = f"from ({x:g}, {y:g}) m, {np.degrees(heading):.0f}°"
                (line,) = ax.plot(*loop.pose[:, :2].T, label=label)
                _headings(ax, loop, line.get_color())
            ax.plot(0.0, 0.0, "x", color="#222222", markersize=9, label="goal, heading 0°")
            ax.set_aspect("equal")
            ax.set_xlim(low[0], high[0])
            ax.set_ylim(low[1], high[1])
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
    laws : Gains to mark, by name.
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


def docking_figures(
    content: DockingContent, filters: FilterExperiment, straight: FilterExperiment
) -> dict[str, "Figure"]:
    """Return every figure of a docking study by file name [m], [s], [rad].

    Parameters
    ----------
    content : What was computed.
    filters, straight : From `landmark_filters`.
    """
    table = dock_table(content.study)
    tag_id = table.tag
    (first, _), *_ = content.rooms.values()
    dockings = content.published
    shown = next((r for r in dockings[True] if r.success), dockings[True][0])
    law, slip_m_per_s = shown.task.fine.law, shown.task.slip.linear_m_per_s
    plans = [
        (name, runs, plan_of(room.scene, room.reader_z_m))
        for name, (room, runs) in content.rooms.items()
    ]
    return {
        "dock_ways": docking_paths_figure(
            plans, (tag_id, first.tag(tag_id).point_m), title="From random starts to the dock"
        ),
        "dock_errors": docking_errors_figure(content.results),
        "dock_run": docking_figure(shown, title="Docking on estimates (Fig. 18, 19)"),
        "dock_stall": stall_figure(dockings, law, slip_m_per_s=slip_m_per_s),
        **filter_figures(filters, straight),
        "dock_law": docking_law_figure(figure_4_loops(), figure_4_law()),
        "dock_regulators": regulators_figure(regulator_loops(table.regulation)),
        **textbook_figures(table),
        "dock_gains": gain_region_figure(
            {
                "paper, Fig. 4": figure_4_law(),
                "paper, Fig. 18": DockingLaw(),
                "textbook, Fig. 11.20": DockingLaw(gamma_per_s=1.0, k_per_s=2.5, h=3.0),
                "this study": law,
            }
        ),
    }
