"""The missions of a reader in one room, with their tables."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from octant.geometries.errors import ConfigError, OctantError, PhysicsWarning
from octant.navigation.missions.files import write_missions_csv, write_trajectory_csv
from octant.navigation.missions.metrics import MissionMetrics, measure
from octant.navigation.missions.records import MissionResult
from octant.reader_design.experiments.missions.advice import Advice, advise
from octant.reader_design.experiments.missions.compute import drive, mission_runs
from octant.reader_design.experiments.missions.drive_figures import Drive
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.seeded import runs_key
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.mapping.pose_filter import MapStore
from octant.reader_design.setting.design import content_hash
from octant.reader_design.setting.setting import Setting, mission_table
from octant.reader_design.showing.netcdf import dataset, variable
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import xarray as xr


RUNS = "runs"
"""Folder of the runs, a few to a file."""
MAPS = "field_maps"
"""Folder of the field maps."""
TABLES = ("missions.csv", "trajectory.csv")
"""Tables of one room."""


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Yield a list that holds each PhysicsWarning once, after the block; pass others on."""
    found: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PhysicsWarning)
        yield found
    found += dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, PhysicsWarning))
    for other in caught:
        if not issubclass(other.category, PhysicsWarning):
            warnings.warn_explicit(other.message, other.category, other.filename, other.lineno)


@dataclass(frozen=True, slots=True, kw_only=True)
class RoomMission:
    """All runs of the mission in one room.

    Attributes
    ----------
    name, slug : Name of the room or layout, and the same fit for file names.
    reason, notes : Why the mission could not be driven, empty when it was; models' warnings.
    data : Metrics by ``run``, and run 0 by ``step`` ([s], [m], [rad], [W]).
    folder, setting : Where its `TABLES` lie; the room of run 0, with its objects as placed.
    results : Every run, run 0 first ([s], [m], [rad], [W]).
    advice : What to try where runs failed; None: nearly all reached every tag, or none was driven.
    """

    name: str
    slug: str
    reason: str
    notes: tuple[str, ...]
    data: "xr.Dataset | None"
    folder: Path
    setting: Setting | None = None
    results: tuple[MissionResult, ...] = ()
    advice: Advice | None = None

    @property
    def metrics(self) -> tuple[MissionMetrics, ...]:
        """How well each run went ([s], [m], [rad])."""
        return tuple(measure(result) for result in self.results)

    @property
    def drive(self) -> Drive | None:
        """Run 0 as the figures take it ([s], [m], [rad], [W]); None when there is none."""
        if self.data is None:
            return None
        d = self.data
        return Drive(
            time_s=d["t_s"].values,
            path_m=np.column_stack([d["x_m"].values, d["y_m"].values]),
            heading_rad=d["heading_rad"].values,
            rss_w=d["rss_w"].values,
            target=d["target"].values,
            position_error_m=d["position_error_m"].values,
            heading_error_rad=d["heading_error_rad"].values,
        )


def mission_stage(
    setting: Setting,
    *,
    name: str,
    slug: str,
    runs: int,
    folder: Path,
    progress: Progress,
    crew: Crew | None = None,
) -> RoomMission:
    """Return the missions in one room; runs that the folder holds are read ([s], [m], [rad], [W]).

    A mission that cannot be driven with this reader carries the reason: that is a result.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission.
    name, slug : Name of the room, and the same fit for file names.
    runs, folder, progress : Number of runs; where runs and tables are kept; shows runs.
    crew : Workers that share the runs; None: this process drives.
    """
    reason, data = "", None
    results: tuple[MissionResult, ...] = ()
    place = folder / f"mission-{slug}"
    with collected_warnings() as notes:
        try:
            maps = MapStore(folder=folder / MAPS, crew=crew, progress=progress)
            shares = mission_runs(setting, runs=runs, maps=maps)
            label = f"missions in {name}"
            results = drive(shares, folder=folder / RUNS, crew=crew, progress=progress, label=label)
        except ConfigError:
            raise
        except OctantError as exc:
            reason = str(exc)
        else:
            setting = shares[0].setting
            keys = [runs_key(one.job, runs=one.runs, seed=one.seed) for one in shares]
            place = folder / f"mission-{slug}-{content_hash(keys)[:16]}"
    if results:
        _write_tables(place, results)
        data = _dataset(setting.study, name, results)
    return RoomMission(
        name=name,
        slug=slug,
        reason=reason,
        notes=tuple(notes),
        data=data,
        folder=place,
        setting=setting,
        results=results,
        advice=advise(setting, results) if results else None,
    )


def _write_tables(place: Path, results: Sequence[MissionResult]) -> None:
    if not all((place / name).is_file() for name in TABLES):
        place.mkdir(parents=True, exist_ok=True)
        write_missions_csv(place / TABLES[0], results)
        write_trajectory_csv(place / TABLES[1], results[0])


def _dataset(study: Study, name: str, results: Sequence[MissionResult]) -> "xr.Dataset":
    metrics = [measure(result) for result in results]
    return dataset(
        {
            **_run_variables(metrics, [m.reason for m in metrics]),
            **_step_variables(metrics[0], results[0]),
        },
        coordinates={
            "target_tag": variable(
                ["target_tag"],
                list(mission_table(study).tags),
                units="1",
                long_name="tag, in order of the visit",
            )
        },
        study_toml=to_toml(study),
        seed=study.seed,
        title=f"missions in {name}",
    )


def _run_variables(
    metrics: list[MissionMetrics], reasons: list[str]
) -> "Mapping[str, xr.Variable]":
    def column(name: str, units: str, long_name: str) -> "xr.Variable":
        values = np.array([getattr(m, name) for m in metrics])
        values = values.astype(np.int8) if values.dtype == np.bool_ else values
        return variable(["run"], values, units=units, long_name=long_name)

    return {
        "success": column("success", "1", "1 when every tag was reached"),
        "captured": column("captured", "1", "1 when the field held the robot at a wrong place"),
        "collided": column("collided", "1", "1 when the robot ran into something"),
        "time_s": column("time_s", "s", "duration"),
        "path_m": column("path_m", "m", "length of the way"),
        "rmse_m": column("rmse_m", "m", "rms distance to the straight segments"),
        "p90_position_m": column("p90_position_m", "m", "position error of 90 % of the time"),
        "p90_heading_rad": column("p90_heading_rad", "rad", "heading error of 90 % of the time"),
        "arrival_error_m": variable(
            ["run", "target_tag"],
            np.array([m.arrival_errors_m for m in metrics]),
            units="m",
            long_name="distance from the tag's point on arrival",
        ),
        "ended_because": variable(["run"], reasons, units="1", long_name="why the run ended"),
    }


def _step_variables(metrics: MissionMetrics, result: MissionResult) -> "Mapping[str, xr.Variable]":
    rows = {
        "t_s": (result.time_s, "s", "time"),
        "x_m": (result.poses[:, 0], "m", "x of the robot"),
        "y_m": (result.poses[:, 1], "m", "y of the robot"),
        "heading_rad": (result.poses[:, 2], "rad", "heading of the robot"),
        "target": (result.targets, "1", "index of the tag in force"),
        "position_error_m": (metrics.position_errors_m, "m", "distance to the straight segment"),
        "heading_error_rad": (metrics.heading_errors_rad, "rad", "angle to the segment"),
    }
    out = {
        name: variable(["step"], values, units=units, long_name=f"{long_name}, run 0")
        for name, (values, units, long_name) in rows.items()
    }
    out["rss_w"] = variable(
        ["step", "antenna"], result.rss_w, units="W", long_name="reading of every antenna, run 0"
    )
    return out
