"""What a cell will take, before anything is meshed: unknowns, memory and time.

The figures are rough on purpose, a third off in unknowns and a factor of two in time on a machine
of 2024, and are scaled by the cells that a folder holds already.
"""

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.band import NODES
from octant.reader_design.experiments.sweep.plan import PlannedCell
from octant.reader_design.experiments.sweep.table import DONE, CellRow
from octant.reader_design.setting.design import FULLWAVE, ReaderDesign
from octant.reader_design.setting.evaluation import SweepContext

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
PATTERN_S, ASSEMBLY_S, FACTORS_S = 0.6, 4e-7, 1.5e-10
"""Time [s] of a solution: patterns; times N^2/s; times N^3/s^2, for N unknowns in s sectors."""
APPROXIMATE_S = {"rays": 1.5, "isolated": 0.05, "files": 1.0}
"""Time [s] of the responses that need no solution."""
FREE_S, SAMPLE_S = 0.05, 4e-7
"""Time [s] of the scores in free space, and of one path to one place of the room."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellCost:
    """What one cell is expected to take.

    Attributes
    ----------
    unknowns : int
        Of the moment method; 0 for the models that have none.
    memory_bytes : float
        Of the process that computes it [B].
    seconds : float
        Time of one core [s], nothing known from before.
    """

    unknowns: int
    memory_bytes: float
    seconds: float


def unknowns_of(design: ReaderDesign, frequency_hz: float, *, cells_per_wavelength: float) -> int:
    """Return roughly how many unknowns the moment method will have for a reader.

    Parameters
    ----------
    design : ReaderDesign
        The reader; metal around it is not counted.
    frequency_hz : float
        Frequency that its mesh is made for [Hz].
    cells_per_wavelength : float
        Elements per wavelength [-].

    Returns
    -------
    int
        From the area of its sheets and the number of its antennas, within about a third.
    """
    edge_m = SPEED_OF_LIGHT_M_PER_S / frequency_hz / cells_per_wavelength
    side_m, count = design.ground_plane_m, design.antennas
    filled = {"square": 1.0, "round": math.pi / 4.0, "octagon": 0.83}[design.ground_plane_shape]
    at_axis_m = design.plate_height_axis_m
    height_m = (
        design.plate_height_m + (design.plate_height_m if at_axis_m is None else at_axis_m)
    ) / 2
    reach_m = design.plate_outer_radius_m or side_m / 2.0
    area_m2 = filled * side_m**2 + count * reach_m * height_m
    kind = design.antenna
    foot = 0.0
    if kind == "dipole":
        foot = UNKNOWNS_UNDER_FOOT * min(1.0, CLOSE_GAP_M / design.gap_m) ** 2
    elif design.monopole_plane_m > 0.0:
        kind = "monopole on its own plane"
        area_m2 += count * design.monopole_plane_m**2
    each = UNKNOWNS_OF_ANTENNA[kind] + foot
    return round(UNKNOWNS_PER_ELEMENT * area_m2 / edge_m**2 + count * each)


def cell_cost(planned: PlannedCell) -> CellCost:
    """Return what a cell is expected to take: unknowns, memory [B], time [s].

    Parameters
    ----------
    planned : PlannedCell
        The cell.

    Returns
    -------
    CellCost
        Nothing for a cell that is refused.

    Notes
    -----
    N unknowns in s equal sectors need a matrix of 16 N^2/s bytes, and as much again while a mode is
    factorised. The room costs one sample for every tag, place, channel and path, whose number is
    that of the images in a box.
    """
    if planned.reason:
        return CellCost(unknowns=0, memory_bytes=0.0, seconds=0.0)
    study, design = planned.context.study, planned.design
    model, channels = study.reader.response, len(study.radio.frequencies_hz)
    unknowns, memory, seconds = 0, PROCESS_BYTES, FREE_S + _room_seconds(planned.context)
    if model == FULLWAVE:
        cells = study.reader.cells_per_wavelength
        highest_hz = max(study.radio.frequencies_hz)
        unknowns = unknowns_of(design, highest_hz, cells_per_wavelength=cells)
        sectors = math.gcd(design.antennas, SECTORS.get(design.ground_plane_shape, design.antennas))
        memory += 2.0 * 16.0 * unknowns**2 / sectors
        once = PATTERN_S + ASSEMBLY_S * unknowns**2 / sectors
        seconds += min(channels, NODES) * (once + FACTORS_S * unknowns**3 / sectors**2)
    else:
        seconds += channels * APPROXIMATE_S[model]
    return CellCost(unknowns=unknowns, memory_bytes=memory, seconds=seconds)


def _room_seconds(context: SweepContext) -> float:
    if not context.has_room:
        return 0.0
    study, sampling = context.study, context.sampling
    size_m = np.ptp(context.built.scene.bounds_m, axis=0)
    places = float(size_m[0] * size_m[1]) / sampling.room_spacing_m**2
    azimuths = study.reader.antennas * sampling.room_azimuths
    images = 1 + sum(4 * order**2 + 2 for order in range(1, study.solver.max_reflections + 1))
    channels = len(study.radio.frequencies_hz)
    return SAMPLE_S * len(study.tags) * places * azimuths * channels * images


def time_scale(cells: Sequence[PlannedCell], rows: Mapping[str, CellRow]) -> float | None:
    """Return how much longer cells take than expected, by those that are there [-].

    Parameters
    ----------
    cells : sequence of PlannedCell
        The sweep.
    rows : mapping of str to CellRow
        What is computed, by key.

    Returns
    -------
    float or None
        Median ratio of measured and expected time; None where nothing is computed.
    """
    ratios = [
        row.seconds / cell_cost(cell).seconds
        for cell in cells
        if (row := rows.get(cell.key)) is not None and row.status == DONE
    ]
    return statistics.median(ratios) if ratios else None
