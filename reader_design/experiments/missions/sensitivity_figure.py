"""Figure of swept errors: how many missions still arrive, against each."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from octant.reader_design.experiments.missions.comparison import CellOutcome
from octant.reader_design.experiments.missions.sensitivity import ErrorEntry, sweeps
from octant.reader_design.showing.style import ANTENNA_COLOURS, figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 3


def sensitivity_figure(
    errors: Sequence[ErrorEntry], outcomes: Sequence[CellOutcome], *, title: str
) -> "Figure":
    """Return the share of runs that reached every tag [%] against each swept error.

    Parameters
    ----------
    errors, outcomes, title : What was swept, each in the unit of its key; all cells; text above.
    """
    columns = min(len(errors), _COLUMNS)
    rows = -(-len(errors) // columns)
    found = sweeps(outcomes)
    several = len({layout for layout, _, _ in found}) > 1
    labels = {
        (layout, driven): f"{layout}: {driven}" if several else driven
        for layout, _, driven in found
    }
    order = list(dict.fromkeys(labels.values()))
    with figure_style():
        figure, axes = new_figure(
            width_in=0.8 + 3.4 * columns,
            height_in=1.2 + 2.6 * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        for ax in axes.ravel()[len(errors) :]:
            ax.set_visible(False)
        for ax, entry in zip(axes.ravel(), errors, strict=False):
            ax.set_ylim(-3.0, 103.0)
            ax.set_xlabel(f"{entry.name} ({entry.key})")
            ax.set_ylabel("runs that reached every tag [%]")
            for (layout, error, driven), group in found.items():
                if error != entry.name:
                    continue
                tried = [o for o in group if o.runs]
                share = [100.0 * o.successes / o.runs for o in tried]
                bars = [
                    [
                        max(s - 100.0 * o.success_interval[0], 0.0)
                        for s, o in zip(share, tried, strict=True)
                    ],
                    [
                        max(100.0 * o.success_interval[1] - s, 0.0)
                        for s, o in zip(share, tried, strict=True)
                    ],
                ]
                number = order.index(labels[layout, driven])
                ax.errorbar(
                    [o.cell.value for o in tried],
                    share,
                    yerr=bars,
                    fmt="-" + "os^Dv<>P"[(number // len(ANTENNA_COLOURS)) % 8],
                    color=ANTENNA_COLOURS[number % len(ANTENNA_COLOURS)],
                    markersize=4,
                    capsize=2,
                    linewidth=1.1,
                    label=labels[layout, driven],
                )
        drawn = {
            text: handle
            for ax in axes.ravel()[: len(errors)]
            for handle, text in zip(*ax.get_legend_handles_labels(), strict=True)
        }
        if drawn:
            figure.legend(
                list(drawn.values()), list(drawn), loc="outside lower center", ncols=2, fontsize=8
            )
    return figure
