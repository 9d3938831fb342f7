"""The results file of a tracking study, and its tables."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.reader_design.experiments.tracking.chapter7 import NominalRun
from octant.reader_design.experiments.tracking.costs import CostRow
from octant.reader_design.experiments.tracking.outcomes import Outcome
from octant.reader_design.showing.netcdf import dataset, variable

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

MEASURE_UNITS = {
    "average_m": ("m", "distance to the desired place, averaged over time"),
    "within_m_90_of_time": ("m", "distance not exceeded for 90 % of the time"),
    "final_m": ("m", "distance to the desired place at the end"),
    "final_heading_deg": ("degree", "size of the heading error at the end"),
}
COST_COLUMNS = (
    "method",
    "claimed",
    "offline_s",
    "step_us",
    "line_m",
    "lemniscate_m",
    "knows_tags",
)
"""Columns of costs.csv [s, µs, m]."""
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


def tracking_dataset(
    outcomes: Sequence[Outcome],
    slam: Sequence[tuple[float, SlamRecord]],
    *,
    study_toml: str,
    seed: int,
    name: str,
) -> "xr.Dataset":
    """Return the errors of every run and the ways of run 0, each variable with its unit.

    Parameters
    ----------
    outcomes : sequence of Outcome
        All tasks and methods ([m], [rad]).
    slam : sequence of (float, SlamRecord)
        Wheel noise [rad/s] and runs of SLAM.
    study_toml : str
        The resolved study.
    seed : int
        Its seed.
    name : str
        Its name.

    Returns
    -------
    xarray.Dataset
        Dimensions ``outcome``, ``run`` and ``step`` (NaN beyond a task's own), ``slam``,
        ``slam_run``.
    """
    labels = [f"{o.chapter}: {o.task}, {o.method}" for o in outcomes]
    variables = {}
    if outcomes:
        for key, (unit, words) in MEASURE_UNITS.items():
            rows = [o.measures()[key] for o in outcomes]
            variables[key] = variable(
                ["outcome", "run"], _padded(rows), units=unit, long_name=words
            )
        steps = {
            "time_s": ("s", "time", [o.desired.time_s for o in outcomes]),
            "desired_x_m": ("m", "desired x", [o.desired.poses[:, 0] for o in outcomes]),
            "desired_y_m": ("m", "desired y", [o.desired.poses[:, 1] for o in outcomes]),
            "x_m": ("m", "x of run 0", [o.poses[0, :, 0] for o in outcomes]),
            "y_m": ("m", "y of run 0", [o.poses[0, :, 1] for o in outcomes]),
            "heading_rad": ("rad", "heading of run 0", [o.poses[0, :, 2] for o in outcomes]),
            "right_rad_per_s": ("rad/s", "right wheel", [o.example_rates[:, 0] for o in outcomes]),
            "left_rad_per_s": ("rad/s", "left wheel", [o.example_rates[:, 1] for o in outcomes]),
        }
        for key, (unit, words, rows) in steps.items():
            length = max(len(o.desired.time_s) for o in outcomes)
            table = _padded(rows, length)
            variables[key] = variable(["outcome", "step"], table, units=unit, long_name=words)
    if slam:
        for key, unit, words, rows in (
            ("slam_final_m", "m", "error of the place", [r.final_error_m for _, r in slam]),
            ("slam_nees", "1", "normalised error squared of the pose", [r.nees for _, r in slam]),
        ):
            variables[key] = variable(
                ["slam", "slam_run"], _padded(rows), units=unit, long_name=words
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


def slam_row(sigma: float, record: SlamRecord) -> tuple[object, ...]:
    """Return a row of slam.csv, as `SLAM_COLUMNS` [rad/s, m].

    Parameters
    ----------
    sigma : float
        Noise of the wheels [rad/s].
    record : SlamRecord
        The runs.
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


def cost_row(row: CostRow) -> tuple[object, ...]:
    """Return a row of costs.csv, as `COST_COLUMNS` [s, µs, m].

    Parameters
    ----------
    row : CostRow
        One method.
    """
    offline = "" if row.offline_s is None else row.offline_s
    known = "yes" if row.knows_tags else "no"
    return row.method, row.claimed, offline, row.step_us, row.line_m, row.lemniscate_m, known


def solver_rows(runs: Sequence[NominalRun]) -> tuple[tuple[object, ...], ...]:
    """Return task, method, iterations, cost and average error [m] of nominal solutions.

    Parameters
    ----------
    runs : sequence of NominalRun
        The solutions.
    """
    return tuple(
        (
            run.outcome.task,
            run.outcome.method,
            run.solution.iterations,
            run.solution.cost,
            float(np.median(run.outcome.measures()["average_m"])),
        )
        for run in runs
    )
