"""What a sweep will take, before anything is meshed: cells, unknowns, memory and time.

The figures are rough on purpose, a third off in unknowns and a factor of two in time on a machine
of 2024, and are scaled by the cells that a folder holds already.
"""

import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from octant.em.blocks import cores
from octant.reader_design.experiments.sweep.plan import PlannedCell, SweepPlan
from octant.reader_design.experiments.sweep.table import DONE, CellRow, missing_cells
from octant.reader_design.setting.cost import (
    duration_text,
    gigabytes_text,
    reader_cost,
    scoring_cost,
    solved_unknowns,
)
from octant.reader_design.setting.design import FULLWAVE

MOST_LINES = 40
"""Cells that are listed one by one at most [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellCost:
    """What one cell is expected to take.

    Attributes
    ----------
    unknowns : Of the moment method; 0 for the models that have none.
    memory_bytes : Of the process that computes it [B].
    seconds : Time of one core [s], nothing known from before.
    """

    unknowns: int
    memory_bytes: float
    seconds: float


def cell_cost(planned: PlannedCell) -> CellCost:
    """Return what a cell is expected to take; nothing for a cell that is refused.

    Parameters
    ----------
    planned : The cell.
    """
    if planned.reason:
        return CellCost(unknowns=0, memory_bytes=0.0, seconds=0.0)
    study, sampling = planned.setting.study, planned.setting.sampling
    solved = reader_cost(study, planned.design)
    scored = scoring_cost(
        study, room_spacing_m=sampling.room_spacing_m, room_azimuths=sampling.room_azimuths
    )
    fullwave = study.reader.response == FULLWAVE
    return CellCost(
        unknowns=solved_unknowns(study, planned.design)[0] if fullwave else 0,
        memory_bytes=solved.memory_bytes,
        seconds=solved.seconds + scored.seconds,
    )


def time_scale(cells: Sequence[PlannedCell], rows: Mapping[str, CellRow]) -> float | None:
    """Return the median of measured over expected time [-]; None where nothing is computed.

    Parameters
    ----------
    cells, rows : The sweep; what is computed, by key.
    """
    ratios = [
        row.seconds / cell_cost(cell).seconds
        for cell in cells
        if (row := rows.get(cell.key)) is not None and row.status == DONE
    ]
    return statistics.median(ratios) if ratios else None


def plan_lines(
    plan: SweepPlan, rows: Mapping[str, CellRow], *, workers: int | None = None
) -> tuple[str, ...]:
    """Return what a sweep would do: its cells, what is there, time [s] and memory [GB].

    Parameters
    ----------
    plan, rows : The sweep; what is there, by key.
    workers : Processes; None: one for each core.
    """
    missing = missing_cells(plan, rows)
    scale = time_scale(plan.cells, rows) or 1.0
    costs = [cell_cost(cell) for cell in missing]
    seconds = [scale * cost.seconds for cost in costs]
    memory = sorted((cost.memory_bytes for cost in costs), reverse=True)
    count = max(1, min(cores() if workers is None else workers, len(missing)))
    known = Counter(row.status for row in rows.values())
    there = ", ".join(f"{number} {status}" for status, number in known.items()) or "none"
    refused = sum(bool(cell.reason) for cell in missing)
    scaled = f"scaled by {known[DONE]} cells of the folder" if known[DONE] else "expected"
    whole, largest = sum(memory[:count]), max(memory, default=0.0)
    longest = duration_text(max(seconds, default=0.0))
    source = f"{scaled}; less where full-wave solutions are kept from before"
    summary = (
        f"{len(plan.cells)} cells: {_sizes(plan)}",
        f"computed already: {there}",
        f"to compute: {len(missing)}, of them {refused} that cannot be built",
        f"time: {duration_text(sum(seconds) / count)} with {count} workers ({source})",
        f"the longest cell: {longest}",
        f"memory: {gigabytes_text(whole)} in all, {gigabytes_text(largest)} for the largest cell",
    )
    cells = [_cell_line(cell, rows, scale) for cell in plan.cells[:MOST_LINES]]
    if len(plan.cells) > MOST_LINES:
        cells.append(f"  ... and {len(plan.cells) - MOST_LINES} more")
    return (*summary, *cells)


def _sizes(plan: SweepPlan) -> str:
    lists = plan.setting.study.sweep
    sizes = [f"{name} ({len({repr(cell.values[name]) for cell in plan.cells})})" for name in lists]
    return " x ".join(sizes) or "the reader as it stands"


def _cell_line(cell: PlannedCell, rows: Mapping[str, CellRow], scale: float) -> str:
    row = rows.get(cell.key)
    if row is not None:
        return f"  {cell.label}: {row.status}"
    if cell.reason:
        return f"  {cell.label}: {cell.reason}"
    cost = cell_cost(cell)
    unknowns = f"{cost.unknowns} unknowns, " if cost.unknowns else ""
    size = gigabytes_text(cost.memory_bytes)
    return f"  {cell.label}: {unknowns}{duration_text(scale * cost.seconds)}, {size}"
