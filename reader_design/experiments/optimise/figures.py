"""Figures of a search for a reader: Pareto front, convergence, winner against reader."""

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.reader_design.experiments.optimise.goals import goal_name
from octant.reader_design.experiments.optimise.search import Search
from octant.reader_design.experiments.optimise.shortlist import front
from octant.reader_design.showing.style import (
    antenna_legend,
    draw_antennas,
    figure_style,
    new_figure,
)
from octant.reader_design.study_file.optimise import SIZES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

STAGES = (
    ("survey", "#88ccee", "o", 26.0),
    ("refinement", "#332288", ".", 26.0),
    ("reader", "#cc6677", "s", 48.0),
)
"""Colour, marker and size [points^2] of each stage of a search."""
DASHES = ("-", "--", ":", "-.")
"""Line styles that keep lines apart which lie on each other."""
MOST_SCORES = 3
"""Scores that the figure of the Pareto front pairs [-]; more would make too many panels."""
BEST_COLOUR, GOAL_COLOUR = "#117733", "#999999"


def pareto_figure(search: Search, *, title: str) -> "Figure":
    """Return every feasible design in the plane of each two goals, front and winner marked.

    Sizes, and scores that do not vary, are left out.

    Parameters
    ----------
    search, title : A finished search; title above the figure.
    """
    goals = search.targets.goals
    feasible = [t for t in search.trials if t.evaluation.feasible]
    scores = np.array([search.targets.scores(t.evaluation) for t in feasible])
    varied = [i for i, goal in enumerate(goals) if goal.score not in SIZES and _tells(scores[:, i])]
    if len(varied) > MOST_SCORES:
        varied = [i for i in varied if goals[i].score != "right_share"][:MOST_SCORES]
    pairs = list(itertools.combinations(varied, 2)) or [(0, len(goals) - 1)]
    on_front = np.isin([t.number for t in feasible], [t.number for t in front(search)])
    with figure_style():
        figure, axes = new_figure(
            width_in=max(3.6 * len(pairs), 5.0), height_in=4.4, title=title, columns=len(pairs)
        )
        for ax, (a, b) in zip(axes[0], pairs, strict=True):
            x, y = scores[:, a], scores[:, b]
            for stage, colour, marker, size in STAGES:
                mine = [i for i, t in enumerate(feasible) if t.stage == stage]
                label = "the study's reader" if stage == "reader" else stage
                ax.scatter(x[mine], y[mine], s=size, c=colour, marker=marker, label=label)
            ax.scatter(
                x[on_front],
                y[on_front],
                s=42,
                facecolors="none",
                edgecolors=BEST_COLOUR,
                label="Pareto front of all goals",
                linewidths=0.7,
            )
            best = [t.number for t in feasible].index(search.winner.number)
            ax.scatter(
                x[best],
                y[best],
                s=260,
                c=BEST_COLOUR,
                marker="*",
                label="chosen",
                zorder=5,
                edgecolors="white",
            )
            ax.axvline(goals[a].value, color=GOAL_COLOUR, linewidth=0.9, linestyle="--")
            ax.axhline(
                goals[b].value, color=GOAL_COLOUR, linewidth=0.9, linestyle="--", label="goal"
            )
            ax.set_xlabel(goal_name(goals[a]))
            ax.set_ylabel(goal_name(goals[b]))
            if _spans_decades(x):
                ax.set_xscale("log")
            if _spans_decades(y):
                ax.set_yscale("log")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=6)
    return figure


def _tells(values: FloatArray) -> bool:
    """Return whether more than one in ten designs differs from the best in a score."""
    return float(np.mean(np.abs(values - np.median(values)) > 1e-9)) > 0.1


def _spans_decades(values: FloatArray) -> bool:
    """Return whether a score needs a logarithmic axis, as bearing errors do."""
    return float(values.min()) > 0.0 and float(values.max()) > 8.0 * float(values.min())


def convergence_figure(search: Search, *, title: str) -> "Figure":
    """Return attainment over the evaluations of a search, and the best one's slack of each goal.

    Parameters
    ----------
    search, title : A finished search; title above the figure.
    """
    numbers = np.array([t.number for t in search.trials])
    values = np.array([t.attainment for t in search.trials])
    best = [max(search.trials[: i + 1], key=lambda t: t.attainment) for i in range(len(numbers))]
    so_far = np.array([t.attainment for t in best])
    goals = search.targets.goals
    slacks = np.array(
        [
            search.targets.slacks(t.evaluation) if t.evaluation.feasible else [np.nan] * len(goals)
            for t in best
        ]
    )
    known = values[np.isfinite(values)]
    # Designs far off the goals, as most readers are at first, would flatten all that follows.
    low = float(np.quantile(known, 0.1)) - 0.5
    with figure_style():
        figure, axes = new_figure(width_in=10.0, height_in=4.0, title=title, columns=2)
        ax = axes[0, 0]
        for stage, colour, marker, size in STAGES:
            mine = [t.stage == stage and t.evaluation.feasible for t in search.trials]
            label = "the study's reader" if stage == "reader" else stage
            shown = np.maximum(values[mine], low)
            ax.scatter(numbers[mine], shown, s=size, c=colour, marker=marker, label=label)
        barred = ~np.isfinite(values)
        if barred.any():
            floor = np.full(int(barred.sum()), low)
            ax.scatter(numbers[barred], floor, marker="x", c="#aa4499", label="infeasible")
        ax.step(
            numbers, np.maximum(so_far, low), where="post", color=BEST_COLOUR, label="best so far"
        )
        ax.axhline(0.0, color=GOAL_COLOUR, linewidth=0.9, linestyle="--")
        ax.set_ylim(low - 0.2, max(float(known.max(initial=0.0)), 0.0) + 0.5)
        ax.set_xlabel("evaluation")
        ax.set_ylabel("attainment of the goals (0: all met)")
        ax.set_title("lower designs stand at the rim")
        ax.legend(loc="best")
        right = axes[0, 1]
        for i, goal in enumerate(goals):
            label = goal_name(goal).split(" [", maxsplit=1)[0]
            right.step(numbers, slacks[:, i], where="post", label=label, linewidth=1.6)
        right.axhline(0.0, color=GOAL_COLOUR, linewidth=0.9, linestyle="--")
        finite = slacks[np.isfinite(slacks)]
        right.set_ylim(max(float(finite.min()), -4.0) - 0.2, float(finite.max()) + 0.3)
        right.set_xlabel("evaluation")
        right.set_ylabel("weighted slack (0: met)")
        right.set_title("each goal, best design so far")
        handles, labels = right.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower right", ncols=2)
    return figure


def comparison_figure(
    azimuths_rad: FloatArray,
    rows: Sequence[tuple[str, FloatArray]],
    distances_m: Sequence[float],
    *,
    title: str,
) -> "Figure":
    """Return RSS [dBm] of all antennas against azimuth [deg], a row a design, a column a distance.

    Parameters
    ----------
    azimuths_rad : (a,) float64 — Azimuths of the tag in the reader frame [rad].
    rows : Name of each design and its RSS [W].
    distances_m : Horizontal distances of the tag [m].
    title : Above the figure.
    """
    levels = [power_dbm(np.maximum(rss, 1e-30)) for _, rss in rows]
    top = max(float(level.max()) for level in levels)
    with figure_style():
        figure, axes = new_figure(
            width_in=2.0 + 3.2 * len(distances_m),
            height_in=0.8 + 2.8 * len(rows),
            title=title,
            rows=len(rows),
            columns=len(distances_m),
        )
        for line, (name, _), level in zip(axes, rows, levels, strict=True):
            for ax, distance, values in zip(line, distances_m, level, strict=True):
                draw_antennas(ax, np.degrees(azimuths_rad), values)
                ax.set_xlim(0.0, 360.0)
                ax.set_xticks(np.arange(0, 361, 90))
                ax.set_ylim(top - 32.0, top + 2.0)
                ax.set_title(f"{name}, {distance:g} m away")
            line[0].set_ylabel("RSS [dBm]")
        for ax in axes[-1]:
            ax.set_xlabel("azimuth of the tag [°]")
        antenna_legend(figure, axes[0, 0])
    return figure


def survey_figure(search: Search, name: str, *, title: str) -> "Figure":
    """Return each goal's score over a numeric choice, lines by ground plane's shape and antenna.

    Parameters
    ----------
    search, title : A search whose designs differ in choices; title above the figure.
    name : The choice on the abscissa, in the unit that it carries.
    """
    goals = search.targets.goals
    lines: dict[str, list[tuple[float, tuple[float, ...]]]] = {}
    for trial in reversed(search.trials):
        design = trial.evaluation.design
        label = f"{design.ground_plane_shape}, {design.antenna}s"
        # The study's reader, first of all, joins a line only where it is one of the choices.
        if trial.evaluation.feasible and (trial.number > 0 or label in lines):
            scores = search.targets.scores(trial.evaluation)
            lines.setdefault(label, []).append((float(getattr(design, name)), scores))
    per_unit, unit = (1e3, "mm") if name.endswith("_m") else (1.0, name.rsplit("_", 1)[-1])
    words = name.removesuffix("_m").replace("_", " ")
    with figure_style():
        figure, axes = new_figure(
            width_in=3.3 * len(goals), height_in=3.7, title=title, columns=len(goals)
        )
        for i, (ax, goal) in enumerate(zip(axes[0], goals, strict=True)):
            for k, (label, points) in enumerate(reversed(lines.items())):
                ordered = sorted(points)
                x = [per_unit * p[0] for p in ordered]
                ax.plot(
                    x, [p[1][i] for p in ordered], marker="o", label=label, linestyle=DASHES[k % 4]
                )
            ax.set_xlabel(f"{words} [{unit}]")
            ax.set_ylabel(goal_name(goal))
            values = np.array([p[1][i] for points in lines.values() for p in points])
            if _spans_decades(values):
                ax.set_yscale("log")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure
