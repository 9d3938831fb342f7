"""Maps of the chosen reader over the room, kept in a file named by the hash of their input."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from octant.em.antennas.embedded import ReaderResponse
from octant.em.power.radio_map import map_reader
from octant.reader_design.experiments.study.error_maps import error_maps
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.design import content_hash
from octant.reader_design.setting.evaluation import room_samples_w
from octant.reader_design.setting.links import tag_link
from octant.reader_design.setting.map_grid import map_axes_m
from octant.reader_design.setting.samples import grid_azimuths_rad, standing_room
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.netcdf import dataset, read_dataset, variable, write_dataset
from octant.reader_design.study_file.loading import to_toml

if TYPE_CHECKING:
    import xarray as xr


MAP_FORMAT = 2
"""Raised when the meaning of a map changes, so that old files are computed again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RoomMap:
    """RSS of the chosen reader over the room, and the samples behind its room scores.

    Attributes
    ----------
    data : xarray.Dataset
        ``rss_w`` and ``local_mean_rss_w`` (tag, x, y, antenna) [W], ``path_count`` (tag, x, y),
        ``standing`` (x, y), the maps of :func:`error_maps`,
        ``sample_rss_w`` (sample, sample_azimuth, antenna) [W].
    """

    data: "xr.Dataset"


def map_stage(
    context: Setting,
    responses: tuple[ReaderResponse, ...],
    *,
    cell_key: str,
    folder: Path,
    progress: Progress,
) -> RoomMap:
    """Return the maps of the chosen reader for every tag, read or computed; powers in [W].

    Parameters
    ----------
    context : Setting
        Study, room and sampling.
    responses : tuple of ReaderResponse
        Of the chosen reader.
    cell_key : str
        Its cell, which stands for everything that its RSS depends on.
    folder : Path
        Where stages are kept.
    progress : Progress
        Told about receivers.

    Returns
    -------
    RoomMap
        The robot's heading is that of the mission's start, or 90 degrees.
    """
    study = context.study
    heading_rad = np.radians(90.0 if study.mission is None else study.mission.heading_deg)
    key = content_hash(
        {
            "stage": "map",
            "format": MAP_FORMAT,
            "cell": cell_key,
            "spacing_m": study.map.spacing_m,
            "h": heading_rad,
        }
    )
    path = folder / f"map-{key[:16]}.nc"
    if path.exists():
        return RoomMap(data=read_dataset(path))
    data = _mapped(context, responses, float(heading_rad), progress)
    write_dataset(data, path, force=True)
    return RoomMap(data=data)


def _mapped(
    context: Setting,
    responses: tuple[ReaderResponse, ...],
    heading_rad: float,
    progress: Progress,
) -> "xr.Dataset":
    study, built = context.study, context
    x, y = map_axes_m(study, built)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    standing = standing_room(
        built.scene,
        grid,
        reader_z_m=built.reader_z_m,
        clearance_m=study.reader.ground_plane_m / 2.0,
    ).reshape(x.size, y.size)
    maps = []
    for tag in built.tags:
        link = tag_link(study, built, tag, responses)
        with progress.count(x.size * y.size, label=f"map of tag {tag.id}") as done:
            maps.append(
                map_reader(
                    link,
                    x_m=x,
                    y_m=y,
                    heading_rad=heading_rad,
                    progress=lambda rows, _, done=done: done(rows),  # type: ignore[misc]
                )
            )
    n = responses[0].antennas
    variables = {
        **error_maps(context, responses, grid.reshape(*standing.shape, 2), standing, progress),
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
        "standing": variable(
            ["x", "y"], standing.astype(np.int8), units="1", long_name="1 where the reader fits"
        ),
    }
    coordinates = {
        "x": variable(["x"], x, units="m", long_name="x of the reader"),
        "y": variable(["y"], y, units="m", long_name="y of the reader"),
        "tag": variable(["tag"], [t.id for t in built.tags], units="1", long_name="tag"),
        "antenna": variable(["antenna"], np.arange(1, n + 1), units="1", long_name="antenna"),
    }
    if context.has_room:
        azimuths = grid_azimuths_rad(n, context.sampling.room_azimuths)
        variables["sample_rss_w"] = variable(
            ["sample", "sample_azimuth", "antenna"],
            room_samples_w(context, responses, azimuths).astype(np.float32),
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
