"""What a sweep would do, said before it does it: cells, what is there, time and memory."""

from collections import Counter
from collections.abc import Mapping

from octant.em.blocks import cores
from octant.reader_design.experiments.sweep.cost import cell_cost, time_scale
from octant.reader_design.experiments.sweep.plan import PlannedCell, SweepPlan
from octant.reader_design.experiments.sweep.table import DONE, CellRow, missing_cells

MOST_LINES = 40
"""Cells that are listed one by one at most [-]."""


def plan_lines(
    plan: SweepPlan, rows: Mapping[str, CellRow], *, workers: int | None = None
) -> tuple[str, ...]:
    """Return what a sweep would do: its cells, what is there, time [s] and memory [GB].

    Parameters
    ----------
    plan : SweepPlan
        What the sweep consists of.
    rows : mapping of str to CellRow
        What is there, by key.
    workers : int or None
        Processes; None: one for each core.

    Returns
    -------
    tuple of str
        A summary, then one line for each cell, at most ``MOST_LINES``.
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
    longest = _duration(max(seconds, default=0.0))
    source = f"{scaled}; less where full-wave solutions are kept from before"
    summary = (
        f"{len(plan.cells)} cells: {_sizes(plan)}",
        f"computed already: {there}",
        f"to compute: {len(missing)}, of them {refused} that cannot be built",
        f"time: {_duration(sum(seconds) / count)} with {count} workers ({source})",
        f"the longest cell: {longest}",
        f"memory: {_gigabytes(whole)} in all, {_gigabytes(largest)} for the largest cell",
    )
    cells = [_cell_line(cell, rows, scale) for cell in plan.cells[:MOST_LINES]]
    if len(plan.cells) > MOST_LINES:
        cells.append(f"  ... and {len(plan.cells) - MOST_LINES} more")
    return (*summary, *cells)


def _sizes(plan: SweepPlan) -> str:
    lists = plan.context.study.sweep
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
    size = _gigabytes(cost.memory_bytes)
    return f"  {cell.label}: {unknowns}{_duration(scale * cost.seconds)}, {size}"


def _gigabytes(memory_bytes: float) -> str:
    return f"{memory_bytes / 1e9:.2g} GB"


def _duration(seconds: float) -> str:
    """Return a time as people say it."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.2g} s"
