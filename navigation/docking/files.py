"""Files of docking missions: one row a run, and one run's trajectory; columns fixed."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from octant.navigation.angles import wrap_angle
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.docking.task import DockingResult

DOCKING_COLUMNS = (
    "layout",
    "run",
    "success",
    "outcome",
    "tries",
    "contacts",
    "time_s",
    "path_m",
    "staged_m",
    "position_error_m",
    "lateral_error_m",
    "heading_error_deg",
    "reason",
)
"""Columns of docking.csv: times [s], lengths [m], angles [deg], success 0 or 1 [-]."""

TRAJECTORY_COLUMNS = (
    "t_s",
    "x_m",
    "y_m",
    "heading_deg",
    "phase",
    "v_m_per_s",
    "w_rad_per_s",
    "e_m",
    "alpha_rad",
    "phi_rad",
    "linear_slip_m_per_s",
    "angular_slip_rad_per_s",
    "seen",
)
"""Columns of trajectory.csv: true pose, command, estimates [m], [deg], [s], and whether it saw."""


def write_docking_csv(path: str | Path, results: Mapping[str, Sequence[DockingResult]]) -> None:
    """Write one row for each run.

    Parameters
    ----------
    path : File to write; an existing one is replaced in one move.
    results : Runs by the name of their layout, run 0 first.
    """
    rows = [
        (
            layout,
            run,
            int(result.success),
            result.outcome,
            result.tries,
            result.contacts,
            number_text(result.time_s[-1]),
            number_text(result.path_m),
            number_text(result.staged_m),
            number_text(result.position_error_m),
            number_text(result.lateral_error_m),
            number_text(math.degrees(abs(result.final[2]))),
            result.reason,
        )
        for layout, runs in results.items()
        for run, result in enumerate(runs)
    ]
    write_csv(Path(path), DOCKING_COLUMNS, rows)


def write_docking_trajectory_csv(path: str | Path, result: DockingResult) -> None:
    """Write one row for each sample of a run.

    Parameters
    ----------
    path : File to write; an existing one is replaced in one move.
    result : The run. Estimates are empty in the phases that have none.
    """
    table = np.column_stack(
        [
            result.time_s,
            result.poses[:, :2],
            np.degrees(wrap_angle(result.poses[:, 2])),
            result.twist,
            result.polar,
            result.slips,
        ]
    )
    rows = (
        (
            *(number_text(value) for value in table[k, :4]),
            result.phases[k],
            *(number_text(value) for value in table[k, 4:]),
            int(result.seen[k]),
        )
        for k in range(len(table))
    )
    write_csv(Path(path), TRAJECTORY_COLUMNS, rows)
