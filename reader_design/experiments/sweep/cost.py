"""What a sweep will take, before anything is meshed: cells, unknowns, memory and time.

The figures are rough on purpose, a third off in unknowns and a factor of two in time on a machine
of 2024, and are scaled by the cells that a folder holds already.
"""

import math
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from octant.em.blocks import cores
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.band import NODES
from octant.em.reader.fullwave.surroundings import surroundings_size
from octant.reader_design.experiments.sweep.plan import PlannedCell, SweepPlan
from octant.reader_design.experiments.sweep.table import DONE, CellRow, missing_cells
from octant.reader_design.setting.design import FULLWAVE
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.reader import Reader

UNKNOWNS_PER_ELEMENT = 2.9
"""Unknowns [-] for every square of the mesh's edge length on the reader's sheets."""
UNKNOWNS_OF_ANTENNA = {"dipole": 45.0, "monopole": 170.0, "monopole on its own plane": 290.0}
"""Unknowns [-] of an antenna and of the finer mesh around its foot."""
UNKNOWNS_UNDER_FOOT = 88.0
"""Further unknowns [-] below each dipole whose gap is ``CLOSE_GAP_M`` or less."""
CLOSE_GAP_M = 0.005
"""Gap [m] below which the mesh under a dipole is as fine as it gets."""
SECTORS = {"square": 4, "octagon": 8}
"""Rotations [-] that a ground plane has; a round one has as many as there are antennas."""

PROCESS_BYTES = 450e6
"""Memory [B] of a process with all libraries and a small room."""
PATTERN_S, ASSEMBLY_S, FACTORS_S = 0.2, 4e-7, 1.5e-10
"""Time [s] of a solution: patterns; times N^2/s; times N^3/s^2, for N unknowns in s sectors."""
APPROXIMATE_S = {"rays": 1.5, "isolated": 0.05, "files": 1.0}
"""Time [s] of the responses that need no solution."""
FREE_S, SAMPLE_S = 0.05, 4e-7
"""Time [s] of the scores in free space, and of one path to one place of the room."""


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


def unknowns_of(design: Reader, *, edge_m: float) -> int:
    """Return about how many unknowns the moment method has for a reader, within a third.

    Parameters
    ----------
    design : Its sheets and antennas; `surroundings_size` counts what stands beside it.
    edge_m : Edge length of its mesh [m].
    """
    side_m, count = design.ground_plane_m, design.antennas
    filled = {"square": 1.0, "round": math.pi / 4.0, "octagon": 0.83}[design.ground_plane_shape]
    at_axis_m = design.plate_height_axis_m
    height_m = (
        design.plate_height_m + (design.plate_height_m if at_axis_m is None else at_axis_m)
    ) / 2
    reach_m = design.plate_outer_radius_m or side_m / 2.0
    area_m2 = filled * side_m**2 + count * reach_m * height_m
    kind: str = design.antenna
    foot = 0.0
    if kind == "dipole":
        foot = UNKNOWNS_UNDER_FOOT * min(1.0, CLOSE_GAP_M / design.gap_m) ** 2
    elif design.monopole_plane_m > 0.0:
        kind = "monopole on its own plane"
        area_m2 += count * design.monopole_plane_m**2
    each = UNKNOWNS_OF_ANTENNA[kind] + foot
    return round(UNKNOWNS_PER_ELEMENT * area_m2 / edge_m**2 + count * each)


def cell_cost(planned: PlannedCell) -> CellCost:
    """Return what a cell is expected to take; nothing for a cell that is refused.

    N unknowns in s equal sectors need a matrix of 16 N^2/s bytes, and as much again while a mode is
    factorised. The room costs one sample for every tag, place, channel and path, whose number is
    that of the images in a box.

    Parameters
    ----------
    planned : The cell.
    """
    if planned.reason:
        return CellCost(unknowns=0, memory_bytes=0.0, seconds=0.0)
    study, design = planned.setting.study, planned.design
    model, channels = study.reader.response, len(study.radio.frequencies_hz)
    unknowns, memory, seconds = 0, PROCESS_BYTES, FREE_S + _room_seconds(planned.setting)
    if model == FULLWAVE:
        count = design.antennas
        shortest_m = SPEED_OF_LIGHT_M_PER_S / max(study.radio.frequencies_hz)
        edge_m = shortest_m / study.reader.cells_per_wavelength
        beside, turns = surroundings_size(design.surroundings, edge_m=edge_m, antennas=count)
        unknowns = unknowns_of(design, edge_m=edge_m) + beside
        sectors = math.gcd(count, turns, SECTORS.get(design.ground_plane_shape, count))
        memory += 2.0 * 16.0 * unknowns**2 / sectors
        once = PATTERN_S + ASSEMBLY_S * unknowns**2 / sectors
        seconds += min(channels, NODES) * (once + FACTORS_S * unknowns**3 / sectors**2)
    else:
        seconds += channels * APPROXIMATE_S[model]
    return CellCost(unknowns=unknowns, memory_bytes=memory, seconds=seconds)


def _room_seconds(setting: Setting) -> float:
    if not setting.has_room:
        return 0.0
    study, sampling = setting.study, setting.sampling
    size_m = np.ptp(setting.scene.bounds_m, axis=0)
    places = float(size_m[0] * size_m[1]) / sampling.room_spacing_m**2
    azimuths = study.reader.antennas * sampling.room_azimuths
    images = 1 + sum(4 * order**2 + 2 for order in range(1, study.solver.max_reflections + 1))
    channels = len(study.radio.frequencies_hz)
    return SAMPLE_S * len(study.tags) * places * azimuths * channels * images


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
