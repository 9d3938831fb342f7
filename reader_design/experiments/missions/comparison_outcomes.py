"""What the cells of a comparison showed: shares and medians with confidence intervals."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.statistics import bootstrap, bootstrap_rng, wilson
from octant.reader_design.experiments.missions.comparison_cells import ComparisonCell
from octant.reader_design.experiments.missions.mission_stage import RoomMission

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

COLUMNS = (
    "layout",
    "link",
    "reader",
    "controller",
    "runs",
    "successes",
    "success_low",
    "success_high",
    "captured",
    "collided",
    "rmse_median_m",
    "rmse_low_m",
    "rmse_high_m",
    "published_rmse_m",
    "arrival_median_m",
    "arrival_p90_m",
    "time_median_s",
    "path_median_m",
    "cell",
    "failed_because",
)
"""Columns of compare.csv: 95 % intervals after Wilson (shares) and by the bootstrap (medians)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellOutcome:
    """One cell and what its runs showed; NaN where nothing was driven or no tag was reached.

    Attributes
    ----------
    cell : ComparisonCell
        The combination.
    mission : RoomMission
        Its runs.
    runs, successes, captured, collided : int
        Number of runs, and of those that ended so.
    success_interval : (2,) tuple of float
        95 % interval of the probability of success [-].
    rmse_m : float
        Median RMSE to the straight segments over all runs [m].
    rmse_interval_m : (2,) tuple of float
        Its 95 % interval [m].
    arrival_m, arrival_p90_m : float
        Median and 90th percentile of the distances from the tags' points on arrival [m].
    time_s, path_m : float
        Median duration [s] and way [m].
    """

    cell: ComparisonCell
    mission: RoomMission
    runs: int
    successes: int
    captured: int
    collided: int
    success_interval: tuple[float, float]
    rmse_m: float
    rmse_interval_m: tuple[float, float]
    arrival_m: float
    arrival_p90_m: float
    time_s: float
    path_m: float

    def row(self) -> tuple[object, ...]:
        """Return the cell's line of compare.csv: `COLUMNS`, empty where there is no value."""
        cell = self.cell
        values = (
            cell.layout,
            cell.link,
            cell.reader,
            cell.controller,
            self.runs,
            self.successes,
            *self.success_interval,
            self.captured,
            self.collided,
            self.rmse_m,
            *self.rmse_interval_m,
            math.nan if cell.published_rmse_m is None else cell.published_rmse_m,
            self.arrival_m,
            self.arrival_p90_m,
            self.time_s,
            self.path_m,
            self.mission.folder.name,
            self.mission.reason,
        )
        return tuple("" if isinstance(v, float) and math.isnan(v) else v for v in values)


def outcome_of(cell: ComparisonCell, mission: RoomMission) -> CellOutcome:
    """Return what a cell's runs showed [m], [s].

    Parameters
    ----------
    cell : ComparisonCell
        The combination.
    mission : RoomMission
        Its runs.
    """
    data = mission.data
    if data is None:
        nan = math.nan
        return CellOutcome(
            cell=cell,
            mission=mission,
            runs=0,
            successes=0,
            captured=0,
            collided=0,
            success_interval=(nan, nan),
            rmse_m=nan,
            rmse_interval_m=(nan, nan),
            arrival_m=nan,
            arrival_p90_m=nan,
            time_s=nan,
            path_m=nan,
        )
    runs = int(data.sizes["run"])
    successes, captured, collided = (
        int(data[name].values.sum()) for name in ("success", "captured", "collided")
    )
    success = wilson(successes, runs)
    rmse = np.asarray(data["rmse_m"].values, dtype=np.float64)
    (median,) = bootstrap(rmse, lambda drawn: np.median(drawn, axis=-1)[None], bootstrap_rng())
    return CellOutcome(
        cell=cell,
        mission=mission,
        runs=runs,
        successes=successes,
        captured=captured,
        collided=collided,
        success_interval=(success.low, success.high),
        rmse_m=median.value,
        rmse_interval_m=(median.low, median.high),
        arrival_m=_percentile(data, 50.0),
        arrival_p90_m=_percentile(data, 90.0),
        time_s=float(np.median(data["time_s"].values)),
        path_m=float(np.median(data["path_m"].values)),
    )


def layouts_of(outcomes: Sequence[CellOutcome]) -> dict[str, list[CellOutcome]]:
    """Return the outcomes by layout.

    Parameters
    ----------
    outcomes : sequence of CellOutcome
        Of all cells.
    """
    found: dict[str, list[CellOutcome]] = {}
    for outcome in outcomes:
        found.setdefault(outcome.cell.layout, []).append(outcome)
    return found


def _percentile(data: "xr.Dataset", percent: float) -> float:
    arrivals = np.asarray(data["arrival_error_m"].values, dtype=np.float64)
    known = arrivals[np.isfinite(arrivals)]
    return float(np.percentile(known, percent)) if known.size else math.nan
