"""Files of the missions: one row a run, and one run's trajectory; columns fixed for outsiders."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.records import MissionResult

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
    "outcome",
    "contacts",
    "near_miss",
    "start_x_m",
    "start_y_m",
    "start_heading_deg",
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
    """Write one row for each run.

    `arrivals_m` lists the arrival error of each tag [m], separated by semicolons, nothing where it
    was not reached; `success`, `captured` and `collided` of `metrics.MissionMetrics` are 1 or 0.

    Parameters
    ----------
    path : File to write; an existing one is replaced in one move, never left half written.
    results : The runs, run 0 first.
    success_radius_m : Distance at which an arrival counts [m]; None: twice the arrival radius.
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
                number_text(metrics.time_s),
                number_text(metrics.path_m),
                number_text(metrics.rmse_m),
                number_text(metrics.p90_position_m),
                number_text(math.degrees(metrics.p90_heading_rad)),
                ";".join(number_text(error) for error in metrics.arrival_errors_m),
                int(metrics.captured),
                int(metrics.collided),
                metrics.outcome,
                metrics.contacts,
                int(metrics.near_miss),
                number_text(result.mission.start_m[0]),
                number_text(result.mission.start_m[1]),
                number_text(math.degrees(result.mission.heading_rad)),
            )
        )
    write_csv(Path(path), MISSION_COLUMNS, rows)


def write_trajectory_csv(path: str | Path, result: MissionResult) -> None:
    """Write one row for each sample of a run.

    `heading_deg` lies in (-180, 180]; `target` is the tag's ID; antenna 1 stands at azimuth 0.

    Parameters
    ----------
    path : File to write; an existing one is replaced in one move, never left half written.
    result : The run.
    """
    antennas = result.rss_w.shape[1]
    header = (*TRAJECTORY_COLUMNS, *(f"rss_{i + 1}_w" for i in range(antennas)))
    heading_deg = np.degrees(wrap_angle(result.poses[:, 2]))
    rows = (
        (
            number_text(result.time_s[k]),
            number_text(result.poses[k, 0]),
            number_text(result.poses[k, 1]),
            number_text(heading_deg[k]),
            result.modes[k],
            result.mission.tag_ids[result.targets[k]],
            *(number_text(value) for value in result.rss_w[k]),
        )
        for k in range(len(result.time_s))
    )
    write_csv(Path(path), header, rows)
