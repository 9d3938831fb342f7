"""Contour maps of a sweep: every score over the two parameters that take the most values."""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from octant.reader_design.showing.designs_view import Column
from octant.reader_design.showing.pages import ReportFigure
from octant.reader_design.showing.style import figure_png, figure_style, new_figure

FloatArray = npt.NDArray[np.float64]

LEAST_VALUES = 3
"""Values of a parameter below which no map is drawn over it [-]."""
PANELS = 4, 3
"""Rows and columns of panels on one figure [-]."""
MOST_MAPS = 4
"""Combinations of the other parameters that are drawn [-]."""
LEVELS = 9
"""Contours of a panel [-], about."""


def design_maps(parameters: Sequence[Column], scores: Sequence[Column]) -> tuple[ReportFigure, ...]:
    """Return maps of all scores over two parameters, of each combination of the others.

    None where no two parameters are numbers of at least `LEAST_VALUES` values each. Combinations
    beyond the first `MOST_MAPS` are left out.

    Parameters
    ----------
    parameters, scores : One value a design each, in the unit that the heading names.
    """
    axes = _axes(parameters)
    if axes is None:
        return ()
    others = [column for column in parameters if column not in axes]
    rows = list(zip(*(column.texts for column in others), strict=True)) if others else []
    rows = rows or [()] * len(axes[0].texts)
    figures = []
    for combination in list(dict.fromkeys(rows))[:MOST_MAPS]:
        chosen = np.array([row == combination for row in rows])
        pairs = zip(others, combination, strict=True)
        named = ", ".join(f"{column.heading} {text}" for column, text in pairs)
        figures += list(_figures(axes, scores, chosen, named))
    return tuple(figures)


def _axes(parameters: Sequence[Column]) -> tuple[Column, Column] | None:
    """Return the two numbers of the most values, abscissa first."""
    numbers = [(len(set(column.texts)), column) for column in parameters if column.values]
    many = [(count, column) for count, column in numbers if count >= LEAST_VALUES]
    first = sorted(many, key=lambda pair: -pair[0])[:2]
    return (first[0][1], first[1][1]) if len(first) == 2 else None


def _figures(
    axes: tuple[Column, Column], scores: Sequence[Column], chosen: npt.NDArray[np.bool_], named: str
) -> Iterator[ReportFigure]:
    """Yield figures of as many panels as fit; scores that do not change have none."""
    x, y = (np.asarray(axis.values, dtype=np.float64)[chosen] for axis in axes)
    panels = []
    for score in scores:
        if not score.values:
            continue
        values = np.asarray(score.values, dtype=np.float64)[chosen]
        finite = values[np.isfinite(values)]
        if finite.size and float(np.ptp(finite)) > 1e-9 * float(np.abs(finite).max()):
            panels.append((score.heading, grid_of(x, y, values)))
    per_page = PANELS[0] * PANELS[1]
    pages = range(0, len(panels), per_page)
    over = f"over {axes[0].heading} and {axes[1].heading}"
    for page in pages:
        title = f"Scores {over}" + (f": {named}" if named else "")
        title += f" ({page // per_page + 1} of {len(pages)})" if len(pages) > 1 else ""
        yield ReportFigure(
            title=title,
            caption="Contours between the designs, which are dots; blank where a design has none.",
            png=_drawn(panels[page : page + per_page], axes, title),
        )


def grid_of(
    x: FloatArray, y: FloatArray, values: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the values of x, those of y, and a (y, x) table, NaN where there is no design.

    Parameters
    ----------
    x, y, values : (k,) float64 — Of each design [any].
    """
    across, column = np.unique(x, return_inverse=True)
    up, row = np.unique(y, return_inverse=True)
    table = np.full((len(up), len(across)), np.nan)
    table[row, column] = values
    return across, up, table


def _drawn(
    panels: Sequence[tuple[str, tuple[FloatArray, FloatArray, FloatArray]]],
    axes: tuple[Column, Column],
    title: str,
) -> bytes:
    """Return panels of filled contours as the content of a PNG file."""
    from matplotlib.ticker import MaxNLocator

    columns = min(PANELS[1], len(panels))
    rows = -(-len(panels) // columns)
    with figure_style():
        figure, places = new_figure(
            width_in=3.4 * columns, height_in=2.7 * rows + 0.5, title=title, rows=rows,
            columns=columns,
        )  # fmt: skip
        for place, panel in itertools.zip_longest(places.ravel(), panels):
            if panel is None:
                place.set_axis_off()
                continue
            heading, (across, up, table) = panel
            levels = MaxNLocator(LEVELS).tick_values(np.nanmin(table), np.nanmax(table))
            filled = place.contourf(across, up, table, levels=levels, cmap="viridis")
            place.contour(
                across, up, table, levels=levels, colors="white", linewidths=0.4, linestyles="solid"
            )
            there = np.isfinite(table)
            dots = np.array(np.meshgrid(across, up))[:, there]
            place.plot(*dots, linestyle="", marker=".", markersize=1.5, color="black", alpha=0.5)
            figure.colorbar(filled, ax=place)
            place.set_title(heading, fontsize=8)
            place.set_xlabel(axes[0].heading)
            place.set_ylabel(axes[1].heading)
        return figure_png(figure)
