"""The missions of the chosen reader in one room, kept in files named by the hash of their input."""

import json
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from octant.em.antennas.embedded import ReaderResponse
from octant.geometries.errors import ConfigError, OctantError, PhysicsWarning
from octant.navigation.missions.files import write_missions_csv, write_trajectory_csv
from octant.navigation.missions.metrics import MissionMetrics, measure
from octant.navigation.missions.records import MissionResult
from octant.reader_design.experiments.missions.drive_figures import Drive
from octant.reader_design.experiments.missions.drives import drive_missions
from octant.reader_design.experiments.missions.placements import drive_placements
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.versions import versions
from octant.reader_design.setting.design import content_hash, response_inputs
from octant.reader_design.setting.keys import CELL_FORMAT, scene_fingerprint
from octant.reader_design.setting.links import mission_table
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.netcdf import dataset, read_dataset, variable, write_dataset
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Layout, Study

if TYPE_CHECKING:
    import xarray as xr


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Yield a list that holds each PhysicsWarning once, as text, when the block is left.

    Warnings of other classes are passed on then.
    """
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
    name : str
        Name of the room or layout.
    slug : str
        The same, fit for file names.
    reason : str
        Why the mission could not be driven at all; empty when it was.
    notes : tuple of str
        Warnings of models.
    data : xarray.Dataset or None
        Metrics by ``run``, and run 0 by ``step`` ([s], [m], [rad], [W]).
    folder : Path
        Where its ``missions.csv`` and ``trajectory.csv`` lie.
    """

    name: str
    slug: str
    reason: str
    notes: tuple[str, ...]
    data: "xr.Dataset | None"
    folder: Path

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
    study: Study,
    built: Setting,
    responses: tuple[ReaderResponse, ...],
    *,
    design_key: str,
    name: str,
    slug: str,
    runs: int,
    folder: Path,
    progress: Progress,
    layout: Layout | None = None,
) -> RoomMission:
    """Return the missions in one room, read or driven ([s], [m], [rad], [W]).

    Parameters
    ----------
    study : Study
        With a mission.
    built : Setting
        The room.
    responses : tuple of ReaderResponse
        Of the chosen reader.
    design_key : str
        Hash of the chosen design.
    name : str
        Name of the room.
    slug : str
        The same, fit for file names.
    runs : int
        Number of runs.
    folder : Path
        Where stages are kept.
    progress : Progress
        Told about runs.
    layout : Layout or None
        The room as the study tells it, for random placements of its objects; None: the study's own.

    Returns
    -------
    RoomMission
        A mission that cannot be driven with this reader carries the reason: that is a result.
    """
    key = content_hash(
        {
            "stage": "mission",
            "format": CELL_FORMAT,
            "octant": versions()["octant_version"],
            "design": design_key,
            **response_inputs(study),
            "scene": scene_fingerprint(built),
            "mission": msgspec.to_builtins(mission_table(study)),
            "sensor": msgspec.to_builtins(study.sensor),
            "radio": msgspec.to_builtins(study.radio),
            "solver": msgspec.to_builtins(study.solver),
            "seed": study.seed,
            "runs": runs,
        }
    )
    place = folder / f"mission-{slug}-{key[:16]}"
    path = place / "mission.nc"
    if not path.exists():
        with collected_warnings() as notes:
            data = _driven(
                study,
                built,
                responses,
                name=name,
                runs=runs,
                place=place,
                progress=progress,
                layout=layout,
            )
        data.attrs["notes"] = json.dumps(notes)
        write_dataset(data, path, force=True)
    data = read_dataset(path)
    reason = str(data.attrs["failed_because"])
    return RoomMission(
        name=name,
        slug=slug,
        reason=reason,
        notes=tuple(json.loads(data.attrs["notes"])),
        data=None if reason else data,
        folder=place,
    )


def _driven(
    study: Study,
    built: Setting,
    responses: tuple[ReaderResponse, ...],
    *,
    name: str,
    runs: int,
    place: Path,
    progress: Progress,
    layout: Layout | None,
) -> "xr.Dataset":
    table = mission_table(study)
    reason, variables = "", {}
    try:
        with progress.count(runs, label=f"missions in {name}") as done:
            if table.placement_m > 0.0:
                results, _ = drive_placements(study, layout, responses, runs=runs, progress=done)
            else:
                results = drive_missions(study, built, responses, runs=runs, progress=done)
    except ConfigError:
        raise
    except OctantError as exc:
        reason = str(exc)
    else:
        place.mkdir(parents=True, exist_ok=True)
        write_missions_csv(place / "missions.csv", results)
        write_trajectory_csv(place / "trajectory.csv", results[0])
        metrics = [measure(result) for result in results]
        variables = {
            **_run_variables(metrics, [r.reason for r in results]),
            **_step_variables(metrics[0], results[0]),
        }
    return dataset(
        variables,
        coordinates={
            "target_tag": variable(
                ["target_tag"], list(table.tags), units="1", long_name="tag, in order of the visit"
            )
        },
        study_toml=to_toml(study),
        seed=study.seed,
        title=f"missions in {name}",
        attributes={"failed_because": reason},
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
