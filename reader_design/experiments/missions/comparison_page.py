"""What a comparison's report says: one table of all cells, and each cell's first run."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from octant.reader_design.experiments.missions.comparison import (
    CellOutcome,
    layouts_of,
    rmse_text,
)
from octant.reader_design.experiments.missions.comparison_table import OWN, Comparison
from octant.reader_design.experiments.missions.sensitivity import (
    BREAK_HEADER,
    break_rows,
    failures_text,
)
from octant.reader_design.showing.pages import (
    Report,
    ReportSection,
    ReportTable,
    embedded_figures,
    read_figure,
)

HEADER = (
    "layout",
    "controller",
    "link",
    "reader",
    "reached every tag",
    "share (95 %)",
    "median RMSE of successes [m] (95 %)",
    "of all runs [m]",
    "published [m]",
    "arrival [m], successes / all",
    "wrong place or held",
    "collided",
    "contacts a run",
    "time [s]",
    "failures by kind",
)


def comparison_report(
    comparison: Comparison,
    outcomes: Sequence[CellOutcome],
    figures: Mapping[str, Sequence[tuple[str, str, Path]]],
    overview: Path,
    sensitivity: Path | None = None,
) -> Report:
    """Return the report of a comparison; numbers carry their units [m], [s].

    Parameters
    ----------
    comparison, outcomes : What was compared, and all cells.
    figures, overview : Title, caption and file of each by layout; PNG of all cells side by side.
    sensitivity : PNG of the swept errors; None: there are none.
    """
    by_layout = layouts_of(outcomes)
    notes = dict.fromkeys(note for outcome in outcomes for note in outcome.mission.notes)
    table = ReportTable(
        caption=(
            f"{comparison.runs} runs a cell. Shares with Wilson's 95 % interval, medians with the "
            "bootstrap's; a run is a success when every tag was declared reached within twice the "
            "arrival radius of its point."
        ),
        header=HEADER,
        rows=tuple(table_row(outcome) for outcome in outcomes),
    )
    sections = [
        ReportSection(
            heading="All cells",
            tables=(table,),
            figures=(
                read_figure(
                    "All cells side by side",
                    "Dots are shares and medians, bars their 95 % intervals.",
                    overview,
                ),
            ),
        )
    ]
    if sensitivity is not None:
        sections.append(_sensitivity_section(comparison, outcomes, sensitivity))
    sections += [
        ReportSection(
            heading=name,
            paragraphs=tuple(
                f"{o.cell.label}: not driven, because {o.mission.reason}"
                for o in group
                if o.mission.reason
            ),
            figures=embedded_figures(figures, name),
        )
        for name, group in by_layout.items()
    ]
    if notes:
        sections.append(ReportSection(heading="Warnings and validity", points=tuple(notes)))
    return Report(
        title=f"{comparison.name}: navigation compared",
        subtitle="Layouts, links, readers and controllers, every combination",
        summary=tuple(
            _best(name, group) for name, group in by_layout.items() if any(o.runs for o in group)
        ),
        warnings=(),
        facts=(
            ("layouts", str(len(by_layout))),
            ("cells", str(len(outcomes))),
            ("runs a cell", str(comparison.runs)),
            ("seed", str(comparison.seed)),
        ),
        sections=tuple(sections),
    )


def _sensitivity_section(
    comparison: Comparison, outcomes: Sequence[CellOutcome], figure: Path
) -> ReportSection:
    share = 100.0 * comparison.breaks_below
    return ReportSection(
        heading="How exact a survey must be",
        tables=(
            ReportTable(
                caption=f"Each error is swept, in the unit of its key in [truth], until less than "
                f"{share:.0f} % of the runs reach every tag; 95 % intervals after Wilson.",
                header=BREAK_HEADER,
                rows=tuple(break_rows(outcomes, comparison.breaks_below)),
                words=True,
            ),
        ),
        figures=(
            read_figure(
                "Success against each error",
                "Dots are shares of the runs that reached every tag, bars their 95 % intervals.",
                figure,
            ),
        ),
    )


def table_row(outcome: CellOutcome) -> tuple[str, ...]:
    """Return one cell's line of the table; numbers stand in the header's units [m], [s].

    Parameters
    ----------
    outcome : The cell.
    """
    cell = outcome.cell
    driven = cell.controller if cell.world == OWN else f"{cell.controller}; {cell.world}"
    names = (cell.layout, driven, cell.link, cell.reader)
    published = "" if cell.published_rmse_m is None else f"{cell.published_rmse_m:.2f}"
    if outcome.runs == 0:
        return (*names, "not driven", "–", "–", "–", published, *("–",) * 6)
    low, high = outcome.success_interval
    arrival = "–"
    if math.isfinite(outcome.arrival_m):
        good = outcome.success_arrival_m
        arrival = f"{'–' if math.isnan(good) else f'{good:.2f}'} / {outcome.arrival_m:.2f}"
    of_successes = "–"
    if outcome.successes:
        of_successes = "{:.3f} ({:.3f} to {:.3f})".format(
            outcome.success_rmse_m, *outcome.success_rmse_interval_m
        )
    return (
        *names,
        f"{outcome.successes} of {outcome.runs}",
        f"{100 * outcome.successes / outcome.runs:.0f} % ({100 * low:.0f} to {100 * high:.0f} %)",
        of_successes,
        f"{outcome.rmse_m:.3f}",
        published,
        arrival,
        str(outcome.captured),
        str(outcome.collided),
        f"{outcome.contacts_mean:.2g}",
        f"{outcome.time_s:.0f}",
        failures_text(outcome),
    )


def _best(name: str, group: Sequence[CellOutcome]) -> str:
    best = max(
        (o for o in group if o.runs),
        key=lambda o: (o.successes / o.runs, -o.success_rmse_m if o.successes else -o.rmse_m),
    )
    return (
        f"{name}: best is {best.cell.label}, with {best.successes} of {best.runs} runs that "
        f"reached every tag, and a median RMSE [m] of {rmse_text(best)}."
    )
