"""Designs side by side: one table with a choice of columns, and plots to play with beside it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from octant.reader_design.showing.pages import ReportFigure, ReportTable, ReportWidget

FIRST_COLUMNS = 6
"""Columns that the table of designs shows at first, their names among them [-]."""
AXES = 7
"""Axes of the plot of parallel qualities [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One quality of all designs.

    Attributes
    ----------
    heading : With its unit.
    texts : One cell each.
    values : The same as numbers, in the heading's unit; empty: it is no number.
    """

    heading: str
    texts: tuple[str, ...]
    values: tuple[float, ...] = ()


def designs_table(
    labels: Sequence[str], columns: Sequence[Column], *, caption: str, best: int | None = None
) -> ReportTable:
    """Return the one table of designs, a few columns of it shown at first.

    Parameters
    ----------
    labels, columns : Names of the designs, and their qualities.
    caption, best : Text above the table; the row that is set off.
    """
    return ReportTable(
        caption=caption,
        header=("design", *(column.heading for column in columns)),
        rows=tuple(
            (label, *(column.texts[row] for column in columns)) for row, label in enumerate(labels)
        ),
        best=best,
        first=FIRST_COLUMNS,
    )


def designs_widget(
    labels: Sequence[str],
    columns: Sequence[Column],
    *,
    front: Sequence[bool] | None = None,
    fallback: tuple[ReportFigure, ...] = (),
) -> ReportWidget | None:
    """Return plots of any two qualities, and of several in parallel; None: nothing to compare.

    Parameters
    ----------
    labels, columns : Names of the designs as in the table below, and their qualities.
    front : Which are on the Pareto front; None: there is none.
    fallback : What stands there without scripts and on paper.
    """
    numbers = [column for column in columns if column.values]
    if len(labels) < 2 or len(numbers) < 2:
        return None
    varied = [k for k, c in enumerate(numbers) if len({f"{v:.4g}" for v in c.values}) > 1]
    axes = (varied if len(varied) > 1 else list(range(len(numbers))))[:AXES]
    best = [label for label, one in zip(labels, front or (), strict=False) if one]
    return ReportWidget(
        kind="designs",
        title="Designs compared",
        caption="Any two qualities against each other, and several in parallel. "
        + ("Designs on the Pareto front are diamonds. " if front else "")
        + "Click a design, here or in the table, to set it off; two are compared.",
        alt=f"{len(best)} of {len(labels)} designs are on the Pareto front: {'; '.join(best[:6])}."
        if front
        else f"{len(labels)} designs.",
        data={
            "columns": [column.heading for column in numbers],
            "rows": [
                {
                    "label": label,
                    "front": bool(front[row]) if front else False,
                    "values": [
                        float(f"{c.values[row]:.5g}") if math.isfinite(c.values[row]) else None
                        for c in numbers
                    ],
                }
                for row, label in enumerate(labels)
            ],
            "x": axes[0],
            "y": axes[1],
            "axes": axes,
        },
        fallback=fallback,
    )
