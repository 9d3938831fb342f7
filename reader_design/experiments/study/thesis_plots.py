"""Figures 5.9 and 5.11 of the thesis as it draws them: watts over the line of sight."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from octant.reader_design.experiments.choice.thesis_setup import (
    TAG_ABOVE_M,
    ThesisDrive,
    ThesisSetup,
)
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.showing.style import (
    NamedFigure,
    antenna_legend,
    draw_antennas,
    figure_style,
    math_text,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 3
_NUMBERS = {"dipole": "5.9", "monopole": "5.11"}


def thesis_figures(setup: ThesisSetup, cells: Sequence[Cell]) -> Iterator[NamedFigure]:
    """Yield RSS [µW] against the line of sight [m] of the thesis' designs, by antenna.

    Parameters
    ----------
    setup, cells : What designs receive in the thesis' set-up; all cells.
    """
    for kind, number in _NUMBERS.items():
        drives = [
            (cell.label, setup.drives[cell.key])
            for cell in cells
            if cell.key in setup.drives and cell.design.antenna_kind == kind
        ]
        if drives:
            yield NamedFigure(
                file=f"thesis_rss_{kind}.png",
                section="thesis",
                title=f"The thesis' drive, {kind}s",
                caption="RSS of all antennas on the drive by which the thesis' claims are judged: "
                f"antenna 1 towards a tag {TAG_ABOVE_M:g} m above the reader's plane "
                f"(thesis Fig. {number}).",
                figure=_drive_figure(drives, title=f"The thesis' drive, {kind}s"),
            )


def _drive_figure(drives: Sequence[tuple[str, ThesisDrive]], *, title: str) -> "Figure":
    columns = min(_COLUMNS, len(drives))
    rows = -(-len(drives) // columns)
    with figure_style():
        figure, axes = new_figure(
            width_in=max(2.2 + 2.7 * columns, 7.0),
            height_in=0.7 + 2.3 * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        for k, (label, drive) in enumerate(drives):
            ax = axes[k // columns, k % columns]
            sight_m = np.hypot(drive.travel_m, TAG_ABOVE_M)
            draw_antennas(ax, sight_m, 1e6 * drive.rss_w)
            ax.set_title(math_text(label))
            ax.set_xlim(float(sight_m[0]), float(sight_m[-1]))
            ax.set_ylim(bottom=0.0)
            if k % columns == 0:
                ax.set_ylabel("RSS [µW]")
            if k + columns >= len(drives):
                ax.set_xlabel("line of sight [m]")
        for k in range(len(drives), rows * columns):
            axes[k // columns, k % columns].set_visible(False)
        antenna_legend(figure, axes[0, 0])
    return figure
