"""``octant map``: received power over the floor of a study's room."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.config.schema import Study
from octant.reader_design.progress import Progress
from octant.reader_design.rooms.map_grid import LARGEST_MAP, map_axes_m
from octant.reader_design.verbs.arguments import common_options

if TYPE_CHECKING:
    import xarray as xr

    from octant.em.blocks import Progress as BlockProgress
    from octant.em.radio_map import RadioMap
    from octant.em.reader_response import ReaderResponse
    from octant.reader_design.rooms.study_scene import PlacedTag, StudyScene

FloatArray = npt.NDArray[np.float64]


@click.command(name="map")
@click.argument("study", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path), required=True, help="The netCDF file to write."
)
@click.option("--tag", "tag_ids", multiple=True, help="Tag to map; default: all of the study.")
@click.option("--antenna", type=click.IntRange(min=1), help="Only this antenna of the reader.")
@click.option("--isotropic", is_flag=True, help="One isotropic_theta antenna, no reader.")
@click.option("--local-mean", is_flag=True, help="Add the power sum over paths.")
@common_options
def radio_map(
    *,
    study: Path,
    out: Path,
    tag_ids: tuple[str, ...],
    antenna: int | None,
    isotropic: bool,
    local_mean: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Map what the reader of STUDY receives from its tags, over the floor of the room.

    The robot's heading is that of the mission, or 90 degrees. Writes rss_w (coherent) and
    path_count; 0 W where no path arrives.
    """
    from octant.reader_design.config.loading import load_study
    from octant.reader_design.rooms.study_scene import build_study_scene
    from octant.reader_design.store import refuse_overwrite, write_dataset
    from octant.reader_design.study.missions import study_responses

    loaded = load_study(study)
    if antenna is not None and isotropic:
        msg = "--antenna and --isotropic are both given, but a map has one receiver; give one."
        raise ConfigError(msg)
    if antenna is not None and antenna > loaded.reader.antennas:
        msg = f"--antenna is {antenna}, but the reader has antennas 1 to {loaded.reader.antennas}."
        raise ConfigError(msg)
    refuse_overwrite(out, force=force)
    built = build_study_scene(loaded)
    tags = [built.tag(tag_id) for tag_id in tag_ids] or list(built.tags)
    if not tags:
        msg = "the study has no [[tag]], so there is nothing that transmits; add one."
        raise ConfigError(msg)
    axes = map_axes_m(loaded, built)
    receivers = 1 if isotropic or antenna is not None else loaded.reader.antennas
    _refuse_huge(loaded, axes, tags=len(tags), receivers=receivers)
    progress = Progress(quiet=quiet)
    for note in built.notes:
        progress.say(note)
    responses = () if isotropic else study_responses(loaded)
    maps = []
    for tag in tags:
        with progress.count(axes[0].size * axes[1].size, label=f"tag {tag.id}") as done:

            def told(rows: int, _: int) -> None:
                done(rows)

            maps.append(_tag_map(loaded, built, tag, responses, axes=axes, told=told))
    data = _dataset(loaded, tags, maps, antenna=antenna, local_mean=local_mean)
    write_dataset(data, out, force=force)
    for tag, one in zip(tags, maps, strict=True):
        click.echo(_summary_line(tag.id, one))
    click.echo(f"written: {out}")


def _refuse_huge(
    study: Study, axes: tuple[FloatArray, FloatArray], *, tags: int, receivers: int
) -> None:
    values = axes[0].size * axes[1].size * tags * receivers
    if values > LARGEST_MAP:
        msg = (
            f"map.spacing_m is {study.map.spacing_m:g} m, which with {tags} tags and {receivers} "
            f"antennas makes {values:.3g} values; choose a coarser grid, or one --tag or --antenna."
        )
        raise ConfigError(msg)


def _tag_map(
    study: Study,
    built: "StudyScene",
    tag: "PlacedTag",
    responses: Sequence["ReaderResponse"],
    *,
    axes: tuple[FloatArray, FloatArray],
    told: "BlockProgress",
) -> "RadioMap":
    from dataclasses import replace

    from octant.em.antennas import make_antenna
    from octant.em.image_search import search_images
    from octant.em.radio_map import map_antenna, map_reader
    from octant.reader_design.study.missions import tag_link

    x_m, y_m = axes
    if responses:
        link = tag_link(study, built, tag, responses, height_m=study.map.height_m)
        heading = math.radians(_heading_deg(study))
        return map_reader(link, x_m=x_m, y_m=y_m, heading_rad=heading, progress=told)
    tree = search_images(built.scene, tag.position_m, study.solver.max_reflections)
    maps = [
        map_antenna(
            radio,
            tree,
            x_m=x_m,
            y_m=y_m,
            z_m=built.map_z_m,
            transmitter=sender,
            receiver=make_antenna("isotropic_theta", radio.frequency_hz),
            power_w=study.radio.tag_power_w,
            progress=told,
        )
        for radio, sender in zip(built.radios, tag.antennas, strict=True)
    ]
    return replace(
        maps[0],
        coherent_w=np.mean([m.coherent_w for m in maps], axis=0),
        local_mean_w=np.mean([m.local_mean_w for m in maps], axis=0),
    )


def _heading_deg(study: Study) -> float:
    return 90.0 if study.mission is None else study.mission.heading_deg


def _dataset(
    study: Study,
    tags: Sequence["PlacedTag"],
    maps: Sequence["RadioMap"],
    *,
    antenna: int | None,
    local_mean: bool,
) -> "xr.Dataset":
    from octant.reader_design.config.loading import to_toml
    from octant.reader_design.store import dataset, variable

    of_reader = maps[0].coherent_w.ndim == 3
    chosen = slice(None) if antenna is None else slice(antenna - 1, antenna)
    dims = ["tag", "x", "y", "antenna"] if of_reader else ["tag", "x", "y"]

    def stacked(name: str) -> FloatArray:
        values = np.stack([getattr(one, name) for one in maps])
        return np.asarray(values[..., chosen] if of_reader else values)

    first = maps[0]
    coordinates = {
        "tag": variable(["tag"], [tag.id for tag in tags], units="1", long_name="tag"),
        "x": variable(["x"], first.x_m, units="m", long_name="x in the room"),
        "y": variable(["y"], first.y_m, units="m", long_name="y in the room"),
        "z": variable([], first.z_m, units="m", long_name="height of the receiver"),
    }
    variables = {
        "rss_w": variable(
            dims, stacked("coherent_w"), units="W", long_name="received power, coherent sum"
        ),
        "path_count": variable(
            dims[:3],
            np.stack([one.path_count for one in maps]),
            units="1",
            long_name="number of paths that arrive",
        ),
    }
    if of_reader:
        numbers = np.arange(1, study.reader.antennas + 1)[chosen]
        coordinates["antenna"] = variable(
            ["antenna"], numbers, units="1", long_name="antenna of the reader"
        )
        coordinates["heading"] = variable(
            [], _heading_deg(study), units="degree", long_name="heading of the robot"
        )
    if local_mean:
        variables["rss_local_mean_w"] = variable(
            dims, stacked("local_mean_w"), units="W", long_name="received power, sum over paths"
        )
    return dataset(
        variables,
        coordinates=coordinates,
        study_toml=to_toml(study),
        seed=study.seed,
        title=f"{study.name}: received power over the floor",
        attributes={"receiver": "reader" if of_reader else "isotropic_theta"},
    )


def _summary_line(tag_id: str, one: "RadioMap") -> str:
    strongest = one.coherent_w.max(axis=-1) if one.coherent_w.ndim == 3 else one.coherent_w
    heard = strongest[one.path_count > 0]
    if heard.size == 0 or heard.max() <= 0.0:
        return f"tag {tag_id}: no path to any of {one.path_count.size} places."
    with np.errstate(divide="ignore"):
        dbm = 10.0 * np.log10(heard) + 30.0
    return (
        f"tag {tag_id}: {one.path_count.size} places, {int((one.path_count == 0).sum())} without a "
        f"path; strongest antenna {dbm.min():.1f} to {dbm.max():.1f} dBm, median "
        f"{np.median(dbm):.1f} dBm; {int(one.path_count.sum())} paths."
    )
