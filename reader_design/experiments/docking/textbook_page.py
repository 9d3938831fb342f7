"""The report's sections on what textbook and paper derive: laws, odometry, observability."""

from collections.abc import Mapping
from pathlib import Path

from octant.reader_design.experiments.docking.published import regulator_loops
from octant.reader_design.experiments.docking.textbook import (
    PERIODS_S,
    SIGHTS_S,
    observability_rows,
    odometry_rows,
    regulator_rows,
)
from octant.reader_design.showing.pages import (
    ReportFigure,
    ReportSection,
    ReportTable,
    read_figure,
)
from octant.reader_design.study_file.dock import Dock


def law_section(table: Dock, figures: Mapping[str, Path]) -> ReportSection:
    """Return the report's section on laws without noise [m].

    Parameters
    ----------
    table, figures : The table ``[dock]``, and PNG files by name.
    """
    return ReportSection(
        heading="Laws without noise",
        tables=(
            ReportTable(
                caption="Regulators to the origin: where they end, and how often they turn back.",
                header=(
                    "law",
                    "start",
                    "final distance [m]",
                    "final heading [°]",
                    "inversions",
                    "ends",
                ),
                rows=regulator_rows(regulator_loops(table.regulation)),
            ),
        ),
        figures=(
            shown(figures, "dock_law", "Docking law (Fig. 4)", "V never rises."),
            shown(figures, "dock_gains", "Gains", "2γ <= k <= γ(h + 1) bounds the curvature."),
            shown(
                figures,
                "dock_regulators",
                "Regulators (textbook 11.19, 11.20)",
                "The posture regulator is the docking law under other names.",
            ),
        ),
    )


def derived_section(table: Dock, figures: Mapping[str, Path]) -> ReportSection:
    """Return the report's section on odometry and observability [m], [s].

    Parameters
    ----------
    table, figures : The table ``[dock]``, and PNG files by name.
    """
    times = tuple(f"after {t:g} s" for t in SIGHTS_S)
    return ReportSection(
        heading="Odometry and observability",
        tables=(
            ReportTable(
                caption="Odometry's error at the end of half a circle at the dock's limits [m].",
                header=("step", *(f"T = {period:g} s" for period in PERIODS_S)),
                rows=odometry_rows(table),
            ),
            ReportTable(
                caption="Rank, and the least deviation of the slip that the camera's images allow.",
                header=("observed", "rank", *times),
                rows=observability_rows(table),
            ),
        ),
        figures=(
            shown(
                figures,
                "dock_odometry",
                "Odometry (textbook 11.21)",
                "Where a step believes the end of an arc; error by sample period.",
            ),
            shown(
                figures,
                "dock_observability",
                "Observability (paper (7), (27))",
                "From images alone: no plant noise, nothing known before.",
            ),
        ),
    )


def shown(figures: Mapping[str, Path], key: str, title: str, caption: str) -> ReportFigure:
    """Return a figure as the report shows it.

    Parameters
    ----------
    figures, key : PNG files by name, and one of the names.
    title, caption : Above and below it.
    """
    return read_figure(title, caption, figures[key])
