"""Figures of a sweep: RSS against distance for every design, and all scores at a glance."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.reader_design.showing.style import (
    antenna_legend,
    draw_antennas,
    figure_style,
    math_text,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class DistancePanel:
    """One panel of the figure of RSS against distance.

    Attributes
    ----------
    title : Above the panel.
    rss_w : (d, n) float64 — RSS as the robot moves away along antenna 1's direction [W].
    """

    title: str
    rss_w: FloatArray


def rss_distance_figure(
    distance_m: FloatArray, panels: Sequence[DistancePanel], *, columns: int, title: str
) -> "Figure":
    """Return RSS [dBm] against the distance [m] from under the tag, as thesis Fig. 5.9 and 5.11.

    Parameters
    ----------
    distance_m : (d,) float64 — Horizontal distance [m].
    panels, columns, title : One for each design, row by row; panels in a row; text above.
    """
    rows = -(-len(panels) // columns)
    with figure_style():
        figure, axes = new_figure(
            width_in=max(2.2 + 2.7 * columns, 7.0),
            height_in=0.7 + 2.3 * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        top = max((float(p.rss_w.max()) for p in panels), default=1.0)
        high = float(np.ceil((power_dbm(max(top, 1e-30)) + 3.0) / 5.0) * 5.0)
        for k, panel in enumerate(panels):
            ax = axes[k // columns, k % columns]
            draw_antennas(ax, distance_m, power_dbm(panel.rss_w))
            ax.set_title(math_text(panel.title))
            ax.set_ylim(high - 50.0, high)
            ax.set_xlim(float(distance_m.min()), float(distance_m.max()))
            if k % columns == 0:
                ax.set_ylabel("RSS [dBm]")
            if k + columns >= len(panels):
                ax.set_xlabel("horizontal distance [m]")
        for k in range(len(panels), rows * columns):
            axes[k // columns, k % columns].set_visible(False)
        fullest = max(range(len(panels)), key=lambda k: panels[k].rss_w.shape[1])
        antenna_legend(figure, axes[fullest // columns, fullest % columns])
    return figure


@dataclass(frozen=True, slots=True, kw_only=True)
class MatrixColumn:
    """One criterion of the sweep matrix.

    Attributes
    ----------
    title, text : Heading with its unit, e.g. ``margin [dB]``; format of a number, e.g. ``{:.1f}``.
    values : (k,) float64 — One for each design, in the title's unit, e.g. [dB] or [%].
    better : ``high`` or ``low``: which end is good; it is drawn dark.
    """

    title: str
    values: FloatArray
    text: str
    better: str


def _goodness(column: MatrixColumn) -> FloatArray:
    """Return how good each value is among its column, 0 to 1 [-]; 0.5 when all are equal."""
    values = column.values if column.better == "high" else -column.values
    low, high = float(np.min(values)), float(np.max(values))
    if high - low <= 1e-12 * max(abs(high), abs(low), 1e-300):
        return np.full(values.size, 0.5)
    return (values - low) / (high - low)


def _number(text: str, value: float) -> str:
    """Return a formatted number whose zero has no sign."""
    shown = text.format(value)
    return shown.lstrip("+-") if float(shown) == 0.0 else shown


def sweep_matrix_figure(
    labels: Sequence[str], columns: Sequence[MatrixColumn], *, title: str
) -> "Figure":
    """Return the sweep as a table of designs and criteria, good values of each column dark.

    Parameters
    ----------
    labels, columns, title : Designs, best first; criteria; text above.
    """
    goodness = np.column_stack([_goodness(c) for c in columns])
    with figure_style():
        figure, axes = new_figure(
            width_in=2.6 + 1.15 * len(columns), height_in=1.35 + 0.32 * len(labels), title=title
        )
        ax = axes[0, 0]
        ax.imshow(goodness, cmap="YlGnBu", vmin=-0.15, vmax=1.15, aspect="auto", origin="upper")
        for j, column in enumerate(columns):
            for i, value in enumerate(column.values):
                ax.text(
                    j,
                    i,
                    _number(column.text, float(value)),
                    ha="center",
                    va="center",
                    fontsize=9,
                    color="white" if goodness[i, j] > 0.62 else "#222222",
                )
        ax.set_xticks(range(len(columns)), [c.title for c in columns])
        ax.set_yticks(
            range(len(labels)), [f"{i + 1}.  {math_text(text)}" for i, text in enumerate(labels)]
        )
        ax.get_yticklabels()[0].set_fontweight("bold")
        ax.tick_params(length=0, top=False, labeltop=True, bottom=False, labelbottom=False)
        ax.set_xticks(np.arange(len(columns) + 1) - 0.5, minor=True)
        ax.set_yticks(np.arange(len(labels) + 1) - 0.5, minor=True)
        ax.grid(visible=False)
        ax.grid(which="minor", color="white", linewidth=2.0)
        ax.tick_params(which="minor", length=0)
        for spine in ax.spines.values():
            spine.set_visible(False)
    return figure
