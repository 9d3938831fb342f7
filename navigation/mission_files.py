"""Files of the missions: one row a run, and one run's trajectory; columns fixed for outsiders."""

import csv
import io
import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from octant.geometries.errors import NavigationError
from octant.navigation.bearing import wrap_angle
from octant.navigation.metrics import measure
from octant.navigation.mission_records import MissionResult

MISSION_COLUMNS = (
    "run",
    "success",
    "time_s",
    "path_m",
    "rmse_m",
    "p90_position_m",
    "p90_heading_deg",
    "arrivals_m",
    "captured",
    "collided",
)
"""Columns of missions.csv: times [s], lengths [m], angles [deg], flags 0 or 1 [-]."""

TRAJECTORY_COLUMNS = ("t_s", "x_m", "y_m", "heading_deg", "mode", "target")
"""First columns of trajectory.csv [s], [m], [deg]; rss_1_w ... rss_n_w [W] follow."""


def write_missions_csv(
    path: str | Path,
    results: Sequence[MissionResult],
    *,
    success_radius_m: float | None = None,
) -> None:
    """Write one row for each run; return nothing.

    Parameters
    ----------
    path : str or Path
        File to write; an existing one is replaced in one move, never left half written.
    results : sequence of MissionResult
        The runs, run 0 first.
    success_radius_m : float or None
        How far from a tag's point an arrival counts [m]; None for twice the arrival radius.

    Raises
    ------
    NavigationError
        When there is no run, or the success radius is not positive.

    Notes
    -----
    `arrivals_m` lists the arrival error of each tag [m], separated by semicolons, `nan` where the
    tag was not reached. `success`, `captured` and `collided` are 1 or 0 as `metrics.MissionMetrics`
    defines them. Numbers are written so that they read back to the same bits.
    """
    if not results:
        msg = "there are no runs to write, but missions.csv has one row for each: run the mission."
        raise NavigationError(msg)
    rows = []
    for run, result in enumerate(results):
        metrics = measure(result, success_radius_m=success_radius_m)
        rows.append(
            (
                run,
                int(metrics.success),
                _number(metrics.time_s),
                _number(metrics.path_m),
                _number(metrics.rmse_m),
                _number(metrics.p90_position_m),
                _number(math.degrees(metrics.p90_heading_rad)),
                ";".join(_number(error) for error in metrics.arrival_errors_m),
                int(metrics.captured),
                int(metrics.collided),
            )
        )
    _write_csv(Path(path), MISSION_COLUMNS, rows)


def write_trajectory_csv(path: str | Path, result: MissionResult) -> None:
    """Write one row for each sample of a run; return nothing.

    Parameters
    ----------
    path : str or Path
        File to write; an existing one is replaced in one move, never left half written.
    result : MissionResult
        The run.

    Notes
    -----
    `heading_deg` lies in (-180, 180]; `target` is the tag's ID; antenna 1 stands at reader azimuth
    0. Numbers are written so that they read back to the same bits.
    """
    antennas = result.rss_w.shape[1]
    header = (*TRAJECTORY_COLUMNS, *(f"rss_{i + 1}_w" for i in range(antennas)))
    heading_deg = np.degrees(wrap_angle(result.poses[:, 2]))
    rows = (
        (
            _number(result.time_s[k]),
            _number(result.poses[k, 0]),
            _number(result.poses[k, 1]),
            _number(heading_deg[k]),
            result.modes[k],
            result.mission.tag_ids[result.targets[k]],
            *(_number(value) for value in result.rss_w[k]),
        )
        for k in range(len(result.time_s))
    )
    _write_csv(Path(path), header, rows)


def _number(value: float) -> str:
    return repr(float(value))


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("w", encoding="utf-8", newline="") as file:
            file.write(text.getvalue())
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
