"""Designs against two scores at a time, with the front of those that none dominates."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.reader_design.setting.pareto import pareto_front
from octant.reader_design.showing.style import figure_style, math_text, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

FRONT_COLOUR, OTHER_COLOUR, CHOSEN_COLOUR = "#332288", "#b5b5b5", "#cc3311"
MOST_LABELS = 8
"""Designs on a panel's front up to which each is numbered [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParetoScore:
    """One score of all designs.

    Attributes
    ----------
    title : str
        Name with its unit, e.g. ``vector sum rms [°]``.
    values : (k,) float64
        One for each design, in the title's unit [-].
    maximise : bool
        Whether more is better.
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
    pairs : sequence of (ParetoScore, ParetoScore)
        Abscissa and ordinate of each panel.
    on_front : (k,) bool
        Designs that none dominates in all criteria together [-]; filled.
    rank : (k,) int64
        Place of each design in the ranking, from 1 [-]; the first is marked.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        One panel for each pair; an arrow in the corner points to the better side.
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
