"""Plots of all designs of a sweep: parallel coordinates, and fronts of two scores at a time."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.reader_design.setting.pareto import pareto_front
from octant.reader_design.showing.style import figure_style, math_text, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

FEW_VALUES = 7
"""Different numbers on an axis [-] up to which each gets a tick of its own."""
LINE = 15
"""Letters in a line of a title [-]."""
CHOSEN_COLOUR = "#cc3311"
FRONT_COLOUR, OTHER_COLOUR = "#332288", "#b5b5b5"
MOST_LABELS = 8
"""Designs on a panel's front up to which each is numbered [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParallelAxis:
    """One vertical axis.

    Attributes
    ----------
    title : Below the axis, with its unit, e.g. ``h_p [cm]``.
    values : One for each design in the title's unit [-]; words get a place each.
    """

    title: str
    values: tuple[float, ...] | tuple[str, ...]

    def places(self) -> tuple[FloatArray, list[tuple[float, str]]]:
        """Return each design's height on the axis, 0 to 1, and the ticks with their text [-]."""
        if any(isinstance(v, str) for v in self.values):
            words = list(dict.fromkeys(map(str, self.values)))
            step = 1.0 / max(len(words) - 1, 1)
            at = {word: k * step if len(words) > 1 else 0.5 for k, word in enumerate(words)}
            return np.array([at[str(v)] for v in self.values]), [(y, w) for w, y in at.items()]
        numbers = np.array(self.values, dtype=np.float64)
        low, high = float(numbers.min()), float(numbers.max())
        span = high - low
        heights = (numbers - low) / span if span > 0.0 else np.full(numbers.size, 0.5)
        shown = np.unique(numbers)
        if shown.size > FEW_VALUES:
            shown = np.linspace(low, high, 5)
        ticks = (shown - low) / span if span > 0.0 else np.full(shown.size, 0.5)
        return heights, [(float(y), f"{v:.3g}") for y, v in zip(ticks, shown, strict=True)]


def parallel_figure(
    axes_of: Sequence[ParallelAxis], rank: npt.NDArray[np.int64], *, title: str
) -> "Figure":
    """Return the designs as lines across parameters and scores, coloured by their rank.

    Parameters
    ----------
    axes_of, title : At least two, all of k designs; text above.
    rank : (k,) int64 — Place of each design in the ranking, from 1, which is drawn on top [-].
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize

    drawn = [axis.places() for axis in axes_of]
    heights = np.array([places for places, _ in drawn])
    count, width = len(rank), len(axes_of)
    order = np.argsort(-rank, kind="stable")
    lines = np.stack([np.broadcast_to(np.arange(width), (count, width)), heights.T], axis=-1)[order]
    with figure_style():
        figure, panels = new_figure(
            width_in=max(2.0 + 1.15 * width, 7.0), height_in=4.4, title=title
        )
        ax = panels[0, 0]
        scale = Normalize(1, max(int(rank.max()), 2))
        colours = colormaps["viridis"](scale(rank[order]))
        colours[:, 3] = np.clip(12.0 / np.sqrt(count) / 2.0, 0.12, 0.85)
        ax.add_collection(LineCollection(list(lines[:-1]), colors=colours[:-1], linewidths=1.3))
        ax.plot(*lines[-1].T, color=CHOSEN_COLOUR, linewidth=2.6, label="chosen design", zorder=5)
        for k, (_, ticks) in enumerate(drawn):
            _draw_axis(ax, k, ticks)
        ax.set_xlim(-0.35, width - 0.45)
        ax.set_ylim(-0.06, 1.06)
        ax.set_xticks(range(width), [math_text(fill(a.title, LINE)) for a in axes_of], fontsize=8.5)
        ax.set_yticks([])
        ax.grid(visible=False)
        ax.tick_params(length=0)
        for spine in ax.spines.values():
            spine.set_visible(False)
        bar = figure.colorbar(
            ScalarMappable(scale, "viridis"), ax=ax, label="place in the ranking", pad=0.01
        )
        bar.ax.invert_yaxis()
        bar.outline.set_visible(False)
        figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center")
    return figure


def _draw_axis(ax: "Axes", at: int, ticks: Sequence[tuple[float, str]]) -> None:
    from matplotlib.patheffects import withStroke

    ax.axvline(at, ymin=0.0, ymax=1.0, color="#444444", linewidth=1.0, zorder=3)
    halo = [withStroke(linewidth=2.5, foreground="white")]
    for y, text in ticks:
        ax.plot([at - 0.03, at + 0.03], [y, y], color="#444444", linewidth=1.0, zorder=3)
        ax.text(at + 0.06, y, text, fontsize=8, va="center", path_effects=halo, zorder=6)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParetoScore:
    """One score of all designs.

    Attributes
    ----------
    title : Name with its unit, e.g. ``vector sum rms [°]``.
    values : (k,) float64 — One for each design, in the title's unit [-].
    maximise : Whether more is better.
    """

    title: str
    values: FloatArray
    maximise: bool


def pareto_figure(
    pairs: Sequence[tuple[ParetoScore, ParetoScore]],
    on_front: npt.NDArray[np.bool_],
    rank: npt.NDArray[np.int64],
    *,
    title: str,
) -> "Figure":
    """Return all designs over pairs of scores; each panel shows its own front as a line.

    Parameters
    ----------
    pairs, title : Abscissa and ordinate of each panel; text above.
    on_front : (k,) bool — Designs that none dominates in all criteria together [-]; filled.
    rank : (k,) int64 — Place of each design in the ranking, from 1 [-]; the first is marked.
    """
    columns = min(len(pairs), 3)
    rows = -(-len(pairs) // columns)
    with figure_style():
        figure, axes = new_figure(
            width_in=max(0.4 + 3.9 * columns, 7.0),
            height_in=0.9 + 3.4 * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        for k, (x, y) in enumerate(pairs):
            ax = axes[k // columns, k % columns]
            points = np.column_stack([x.values, y.values])
            front = pareto_front(points, [x.maximise, y.maximise])
            line = points[front][np.argsort(points[front][:, 0], kind="stable")]
            ax.plot(*line.T, "-", color=FRONT_COLOUR, linewidth=1.0, label="front of the two")
            for mask, colour, label in (
                (~on_front, OTHER_COLOUR, "dominated in all criteria"),
                (on_front, FRONT_COLOUR, "dominated by none"),
            ):
                ax.plot(*points[mask].T, "o", color=colour, markersize=5, label=label, zorder=3)
            ax.plot(
                *points[rank == 1].T,
                "*",
                color=CHOSEN_COLOUR,
                markersize=13,
                label="chosen",
                zorder=4,
            )
            if front.sum() <= MOST_LABELS:
                for i in np.flatnonzero(front):
                    ax.annotate(
                        str(rank[i]),
                        points[i],
                        xytext=(5, 5),
                        textcoords="offset points",
                        fontsize=8,
                    )
            ax.set_xlabel(math_text(x.title))
            ax.set_ylabel(math_text(y.title))
            better = ("right" if x.maximise else "left", "up" if y.maximise else "down")
            ax.set_title(f"better: {better[0]} and {better[1]}", fontsize=9)
            ax.margins(0.1)
        for k in range(len(pairs), rows * columns):
            axes[k // columns, k % columns].set_visible(False)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure
