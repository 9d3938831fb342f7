"""Figures of a tolerance study: distributions of scores, slopes, what explains the variance."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.tolerance.sensitivity import Slope
from octant.reader_design.experiments.tolerance.statistics import Explained
from octant.reader_design.experiments.tolerance.views import View
from octant.reader_design.showing.style import figure_style, math_text, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

COLOURS = ("#332288", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499")
"""One colour for each design, in their order."""

MORE, LESS = "#332288", "#ddaa33"
"""Colours of what more, and what less, of a parameter does."""


def distribution_figure(
    shown: Sequence[View],
    designs: Sequence[tuple[str, FloatArray, FloatArray]],
    *,
    title: str,
) -> "Figure":
    """Return each score's distribution: shares as steps, 5 % to 95 % shaded, the drawing as a line.

    Parameters
    ----------
    shown : Scores; a panel each.
    designs : Name, scores of the drawing and of the samples [units of the views].
    title : Above the figure.
    """
    columns = min(4, len(shown))
    rows = -(-len(shown) // columns)
    with figure_style():
        figure, axes = new_figure(
            width_in=0.6 + 2.9 * columns,
            height_in=1.2 + 2.4 * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        for v, view in enumerate(shown):
            ax = axes[v // columns, v % columns]
            for d, (name, nominal, values) in enumerate(designs):
                _draw_distribution(ax, name, nominal[v], values[:, v], COLOURS[d % len(COLOURS)])
            ax.set_xlabel(view.label(), fontsize=9)
            ax.set_ylim(-0.02, 1.02)
            ax.locator_params(axis="x", nbins=4)
            if v % columns == 0:
                ax.set_ylabel("share of readers below [-]")
        for v in range(len(shown), rows * columns):
            axes[v // columns, v % columns].set_visible(False)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(4, len(labels)))
    return figure


def _draw_distribution(
    ax: "Axes", name: str, nominal: float, values: FloatArray, colour: str
) -> None:
    sample = np.sort(values[~np.isnan(values)])
    share = np.arange(1, sample.size + 1) / sample.size
    ax.step(
        np.concatenate((sample[:1], sample)),
        np.concatenate(([0.0], share)),
        where="post",
        color=colour,
        label=f"{name}, as built",
    )
    low, high = np.quantile(sample, (0.05, 0.95))
    ax.axvspan(low, high, color=colour, alpha=0.10, linewidth=0)
    ax.axvline(nominal, color=colour, linestyle="--", linewidth=1.4, label=f"{name}, as drawn")


def slope_figure(shown: Sequence[View], slopes: Sequence[Slope], *, title: str) -> "Figure":
    """Return two bars a parameter: what one millimetre or degree more and less does to every score.

    Parameters
    ----------
    shown : Scores; a panel for each that has slopes.
    slopes : Parameter by parameter [unit of the score per mm or per deg].
    title : Above the figure.
    """
    views = [view for view in shown if any(s.score == view.name for s in slopes)]
    names = list(dict.fromkeys(s.parameter for s in slopes))
    columns = min(3, len(views))
    rows = -(-len(views) // columns)
    with figure_style():
        figure, axes = new_figure(
            width_in=1.6 + 3.1 * columns,
            height_in=1.1 + rows * (0.8 + 0.27 * len(names)),
            title=title,
            rows=rows,
            columns=columns,
        )
        place = np.arange(len(names), dtype=np.float64)
        for v, view in enumerate(views):
            ax = axes[v // columns, v % columns]
            mine = {s.parameter: s for s in slopes if s.score == view.name}
            units = [mine[name].unit.rsplit("/", 1)[1] for name in names]
            ups = [mine[name].up for name in names]
            downs = [-mine[name].down for name in names]
            ax.barh(place - 0.19, ups, 0.36, color=MORE, label="1 mm or 1° more")
            ax.barh(place + 0.19, downs, 0.36, color=LESS, label="1 mm or 1° less")
            ax.axvline(0.0, color="#222222", linewidth=0.8)
            labels = [f"{math_text(n)} [{u}]" for n, u in zip(names, units, strict=True)]
            ax.set_yticks(place, labels if v % columns == 0 else [""] * len(names))
            ax.invert_yaxis()
            ax.set_xlabel(
                f"change of {view.title}\n[{view.change_unit} per mm or per °]", fontsize=9
            )
        for v in range(len(views), rows * columns):
            axes[v // columns, v % columns].set_visible(False)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def explained_figure(
    shown: Sequence[View], explained: Sequence[Explained | None], *, title: str
) -> "Figure | None":
    """Return which kind of error explains how much of each score's variance; None where none does.

    Parameters
    ----------
    shown, explained : Scores, a row each, and what explains them.
    title : Above the figure.
    """
    rows = [(v, e) for v, e in zip(shown, explained, strict=True) if e is not None]
    if not rows:
        return None
    kinds = list(dict.fromkeys(kind for _, e in rows for kind in e.by_kind()))
    table = np.array([[e.by_kind().get(kind, 0.0) for kind in kinds] for _, e in rows])
    with figure_style():
        figure, axes = new_figure(
            width_in=4.2 + 0.85 * len(kinds), height_in=2.3 + 0.36 * len(rows), title=title
        )
        ax = axes[0, 0]
        image = ax.imshow(table, cmap="YlGnBu", vmin=0.0, vmax=1.0, aspect="auto", origin="upper")
        for i, j in np.ndindex(*table.shape):
            colour = "white" if table[i, j] > 0.6 else "#222222"
            text = f"{round(float(table[i, j]), 2) + 0.0:.2f}"  # no sign on zero
            ax.text(j, i, text, ha="center", va="center", color=colour, fontsize=9)
        ax.set_xticks(range(len(kinds)), kinds, rotation=35, ha="right")
        labels = [f"{v.title}  (R² {e.r_squared:.2f}, new {e.r_squared_new:.2f})" for v, e in rows]
        ax.set_yticks(range(len(rows)), labels)
        ax.set_xlabel("kind of error")
        ax.grid(visible=False)
        figure.colorbar(image, ax=ax, label="share of the variance [-]")
    return figure
