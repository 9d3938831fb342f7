"""What a tracking study stores: the runs of each method in each task, and its tables."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.navigation.tracking.closed_loop import TrackingRecord
from octant.reader_design.showing.netcdf import dataset, variable

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

COLUMNS = (
    "chapter",
    "task",
    "method",
    "runs",
    "average_m_median",
    "average_m_90",
    "within_m_90_of_time_median",
    "within_m_90_of_time_90",
    "final_m_median",
    "final_m_90",
    "final_heading_deg_median",
    "final_heading_deg_90",
)
"""Columns of tracking.csv: medians and 90 % quantiles over the runs [m, deg]."""
SLAM_COLUMNS = (
    "wheel_sigma_rad_per_s",
    "runs",
    "final_m_median",
    "final_m_90",
    "dead_reckoning_m_median",
    "nees_mean",
    "diverged",
)
"""Columns of slam.csv [rad/s, m]."""
MEASURE_UNITS = {
    "average_m": ("m", "distance to the desired place, averaged over time"),
    "within_m_90_of_time": ("m", "distance not exceeded for 90 % of the time"),
    "final_m": ("m", "distance to the desired place at the end"),
    "final_heading_deg": ("degree", "size of the heading error at the end"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """The runs of one method in one task.

    Parameters
    ----------
    chapter : ``feedback``, ``nominal``, ``neighbouring`` or ``room``.
    task, method : Trajectory (or tags), and controller with estimator.
    runs : Poses [m, rad] and wheel rates [rad/s]; figures show run 0.
    """

    chapter: str
    task: str
    method: str
    runs: TrackingRecord

    def measures(self) -> dict[str, FloatArray]:
        """Return (r,) errors of every run [m], [deg], as `MEASURE_UNITS`; ``average_m``: (3.11)."""
        return {
            "average_m": self.runs.average_error_m,
            "within_m_90_of_time": self.runs.share_within_m(0.9),
            "final_m": self.runs.final_error_m,
            "final_heading_deg": np.degrees(self.runs.final_heading_error_rad),
        }

    def row(self) -> tuple[object, ...]:
        """Return the row of tracking.csv, as `COLUMNS` [m, deg]."""
        numbers: list[float] = []
        for values in self.measures().values():
            numbers += [float(np.median(values)), float(np.quantile(values, 0.9))]
        return self.chapter, self.task, self.method, len(self.runs.poses), *numbers


def slam_row(sigma: float, record: SlamRecord) -> tuple[object, ...]:
    """Return a row of slam.csv, as `SLAM_COLUMNS` [rad/s, m].

    Parameters
    ----------
    sigma, record : Noise of the wheels [rad/s], and the runs with it.
    """
    error = record.final_error_m
    return (
        sigma,
        len(error),
        float(np.median(error)),
        float(np.quantile(error, 0.9)),
        float(np.median(record.reckoned_error_m)),
        float(record.nees.mean()),
        int(record.diverged.sum()),
    )


def tracking_dataset(
    outcomes: Sequence[Outcome],
    slam: Sequence[tuple[float, SlamRecord]],
    *,
    study_toml: str,
    seed: int,
    name: str,
) -> "xr.Dataset":
    """Return the errors of every run and the ways of run 0, NaN beyond a task's own runs and steps.

    Parameters
    ----------
    outcomes, slam : All tasks and methods ([m], [rad]); wheel noise [rad/s] and runs of SLAM.
    study_toml, seed, name : The resolved study, its seed and its name.
    """
    labels = [f"{o.chapter}: {o.task}, {o.method}" for o in outcomes]
    variables = {}
    if outcomes:
        for key, (unit, words) in MEASURE_UNITS.items():
            rows = [o.measures()[key] for o in outcomes]
            variables[key] = variable(
                ["outcome", "run"],
                _padded(rows),
                units=unit,
                long_name=words,
                missing="fewer runs, or without such a value",
            )
        runs = [o.runs for o in outcomes]
        steps = {
            "time_s": ("s", "time", [r.desired.time_s for r in runs]),
            "desired_x_m": ("m", "desired x", [r.desired.poses[:, 0] for r in runs]),
            "desired_y_m": ("m", "desired y", [r.desired.poses[:, 1] for r in runs]),
            "x_m": ("m", "x of run 0", [r.poses[0, :, 0] for r in runs]),
            "y_m": ("m", "y of run 0", [r.poses[0, :, 1] for r in runs]),
            "heading_rad": ("rad", "heading of run 0", [r.poses[0, :, 2] for r in runs]),
            "right_rad_per_s": ("rad/s", "right wheel", [r.wheel_rates[0, :, 0] for r in runs]),
            "left_rad_per_s": ("rad/s", "left wheel", [r.wheel_rates[0, :, 1] for r in runs]),
        }
        for key, (unit, words, rows) in steps.items():
            length = max(len(r.desired.time_s) for r in runs)
            table = _padded(rows, length)
            variables[key] = variable(
                ["outcome", "step"], table, units=unit, long_name=words, missing="already ended"
            )
    if slam:
        for key, unit, words, rows in (
            ("slam_final_m", "m", "error of the place", [r.final_error_m for _, r in slam]),
            ("slam_nees", "1", "normalised error squared of the pose", [r.nees for _, r in slam]),
        ):
            variables[key] = variable(
                ["slam", "slam_run"],
                _padded(rows),
                units=unit,
                long_name=words,
                missing="fewer runs",
            )
    coordinates = {
        "outcome": variable(["outcome"], labels, units="1", long_name="chapter, task and method"),
        "slam": variable(
            ["slam"], [s for s, _ in slam], units="rad/s", long_name="noise of the wheels in SLAM"
        ),
    }
    used = {dim for item in variables.values() for dim in item.dims}
    return dataset(
        variables,
        coordinates={key: item for key, item in coordinates.items() if key in used},
        study_toml=study_toml,
        seed=seed,
        title=f"Octant tracking study {name}",
    )


def _padded(rows: Sequence[FloatArray], length: int | None = None) -> FloatArray:
    table = np.full((len(rows), length or max(len(row) for row in rows)), np.nan)
    for line, row in zip(table, rows, strict=True):
        line[: len(row)] = row
    return table
