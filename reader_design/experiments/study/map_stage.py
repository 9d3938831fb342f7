"""Maps of the chosen reader over the room, kept in a file named by the hash of their input."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.power.backscatter import Answers, BackscatterLink, Link
from octant.em.power.radio_map import RadioMap, map_backscatter, map_reader
from octant.geometries.errors import OctantError, PhysicsWarning
from octant.reader_design.experiments.study.error_maps import (
    FloorGrid,
    TagErrors,
    error_maps,
    tag_errors,
)
from octant.reader_design.keeping.keeper import map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.small_netcdf import DatasetCodec
from octant.reader_design.keeping.workers import Crew, begun
from octant.reader_design.setting.evaluation import room_samples_w
from octant.reader_design.setting.map_grid import map_axes_m
from octant.reader_design.setting.read_range import read_range
from octant.reader_design.setting.rfid import is_woken
from octant.reader_design.setting.samples import grid_azimuths_rad, standing_room
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.netcdf import dataset, variable
from octant.reader_design.showing.wake import wake_variables
from octant.reader_design.study_file.loading import to_toml

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

LEFT_OUT = (
    "MapCase.progress",
    "MapCase.crew",
    "Setting.layout",
    "Setting.notes",
    *(
        f"Study.{table}"
        for table in (
            "sweep", "scoring", "choice", "sensor", "track", "dock", "optimise", "tolerance",
            "layouts", "report",
        )
    ),
)  # fmt: skip
"""What cannot change a map, so that its key does not contain it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapCase:
    """What the maps of a study are made of.

    Attributes
    ----------
    setting, progress : The chosen reader in its room, and the sampling; shows receivers.
    crew : Workers that share the tags where there are enough of these; None: this process maps.
    """

    setting: Setting
    progress: Progress
    crew: Crew | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _TagMaps:
    """The maps of one tag: RSS [W], what its chip gets, and the reader's errors."""

    radio: RadioMap
    answers: Answers | None
    errors: TagErrors


def map_stage(case: MapCase, folder: Path) -> "xr.Dataset":
    """Return the maps of the chosen reader for every tag, read or computed; powers in [W].

    ``rss_w`` and ``local_mean_rss_w`` (tag, x, y, antenna), ``path_count`` (tag, x, y),
    ``standing`` (x, y), those of `error_maps`, ``sample_rss_w`` (sample, sample_azimuth, antenna).

    Parameters
    ----------
    case, folder : What they are made of, and where stages are kept.
    """
    kept = map_cases(
        mapped,
        [case],
        context=None,
        folder=folder,
        codec=DatasetCodec(),
        leave_out=LEFT_OUT,
        progress=replace(case.progress, bars=False),
        label="maps",
        raises=(OctantError,),
    )
    data: xr.Dataset = kept[0].value
    return data


def mapped(_context: None, case: MapCase) -> "xr.Dataset":
    """Return the maps, as `map_stage` does; the robot heads as at the mission's start, or 90°.

    Parameters
    ----------
    case : What they are made of.
    """
    setting, progress = case.setting, case.progress
    study = setting.study
    heading_rad = float(np.radians(90.0 if study.mission is None else study.mission.heading_deg))
    x, y = map_axes_m(setting)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    standing = standing_room(
        setting.scene,
        grid,
        reader_z_m=setting.reader_z_m,
        clearance_m=study.reader.ground_plane_m / 2.0,
    ).reshape(x.size, y.size)
    floor = FloorGrid(
        places_m=grid.reshape(*standing.shape, 2), standing=standing, heading_rad=heading_rad
    )
    found = _tags_mapped(setting, (x, y), floor, progress, case.crew)
    maps, answers = [one.radio for one in found], [one.answers for one in found]
    ranges = [read_range(setting, tag) if is_woken(study, tag) else None for tag in setting.tags]
    n = setting.reader.antennas
    variables = {
        **error_maps(setting, floor, [one.errors for one in found]),
        "rss_w": variable(
            ["tag", "x", "y", "antenna"],
            np.array([m.coherent_w for m in maps], dtype=np.float32),
            units="W",
            long_name="coherent RSS of the chosen reader",
        ),
        "local_mean_rss_w": variable(
            ["tag", "x", "y", "antenna"],
            np.array([m.local_mean_w for m in maps], dtype=np.float32),
            units="W",
            long_name="power sum over paths at the chosen reader",
        ),
        "path_count": variable(
            ["tag", "x", "y"],
            np.array([m.path_count for m in maps], dtype=np.int32),
            units="1",
            long_name="number of paths",
        ),
        **wake_variables(answers, ranges),
        "standing": variable(
            ["x", "y"], standing.astype(np.int8), units="1", long_name="1 where the reader fits"
        ),
    }
    coordinates = {
        "x": variable(["x"], x, units="m", long_name="x of the reader"),
        "y": variable(["y"], y, units="m", long_name="y of the reader"),
        "tag": variable(["tag"], [t.id for t in setting.tags], units="1", long_name="tag"),
        "antenna": variable(["antenna"], np.arange(1, n + 1), units="1", long_name="antenna"),
    }
    if setting.has_room:
        azimuths = grid_azimuths_rad(n, setting.sampling.room_azimuths)
        variables["sample_rss_w"] = variable(
            ["sample", "sample_azimuth", "antenna"],
            room_samples_w(setting, azimuths).astype(np.float32),
            units="W",
            long_name="RSS over places, tags and azimuths of the room, for the scores",
        )
        coordinates["sample_azimuth"] = variable(
            ["sample_azimuth"],
            np.degrees(azimuths),
            units="deg",
            long_name="azimuth of the tag in the reader frame",
        )
    return dataset(
        variables,
        coordinates=coordinates,
        study_toml=to_toml(study),
        seed=study.seed,
        title="maps of the chosen reader",
        attributes={"heading_deg": float(np.degrees(heading_rad))},
    )


def _tags_mapped(
    setting: Setting,
    axes: tuple[FloatArray, FloatArray],
    floor: FloorGrid,
    progress: Progress,
    crew: Crew | None,
) -> list[_TagMaps]:
    """Return the maps of each tag, by workers if each gets one: here, one tag takes all cores."""
    count = len(setting.tags)
    if crew is None or count < crew.size:
        return [_tag_mapped(setting, axes, floor, number, progress) for number in range(count)]
    silent = Progress(quiet=True)
    begins = [
        begun(crew, _tag_mapped, setting, axes, floor, number, silent) for number in range(count)
    ]
    with progress.count(count, label="maps of tags") as done:
        found = []
        for one in begins:
            found.append(one())
            done(len(found))
    return found


def _tag_mapped(
    setting: Setting,
    axes: tuple[FloatArray, FloatArray],
    floor: FloorGrid,
    number: int,
    progress: Progress,
) -> _TagMaps:
    tag = setting.tags[number]
    grid = floor.places_m.reshape(-1, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)  # the designs carry what must be known
        with progress.count(len(grid), label=f"map of tag {tag.id}") as done:
            link = setting.link(tag, places_m=grid)
            radio, answers = _map_of(link, axes, floor.heading_rad, done)
        standing = int(floor.standing.sum())
        with progress.count(standing, label=f"bearing errors of tag {tag.id}") as done:
            errors = tag_errors(setting, floor, number, done)
    return _TagMaps(radio=radio, answers=answers, errors=errors)


def _map_of(
    link: Link,
    axes: tuple[FloatArray, FloatArray],
    heading_rad: float,
    done: Callable[[int], None],
) -> tuple[RadioMap, Answers | None]:
    x, y = axes

    def rows_done(rows: int, _: int) -> None:
        done(rows)

    if isinstance(link, BackscatterLink):
        return map_backscatter(link, x_m=x, y_m=y, heading_rad=heading_rad, progress=rows_done)
    return map_reader(link, x_m=x, y_m=y, heading_rad=heading_rad, progress=rows_done), None
