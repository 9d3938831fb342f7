"""``octant map``: received power over the floor of a study's room."""

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    from octant.em.power.radio_map import RadioMap

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
@click.option("--local-mean-disc", is_flag=True, help="Add the mean over a disc of one wavelength.")
@click.option("--spreads", is_flag=True, help="Add delay spread and angular spreads.")
@click.option(
    "--figures",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for figures of everything that is mapped; adds the power sum.",
)
@common_options
def radio_map(
    *,
    study: Path,
    out: Path,
    tag_ids: tuple[str, ...],
    antenna: int | None,
    isotropic: bool,
    local_mean: bool,
    local_mean_disc: bool,
    spreads: bool,
    figures: Path | None,
    force: bool,
    quiet: bool,
) -> None:
    """Map what the reader of STUDY receives from its tags, over the floor of the room.

    The robot's heading is that of the mission, or 90 degrees. Writes rss_w (coherent) and
    path_count, and for the whole reader the strongest antenna and the bearing error of the
    RSS-weighted vector sum; 0 W where no path arrives. Spreads are those of the channel between the
    tag and an isotropic_theta antenna at the carrier.
    """
    from octant.em.power.disc_mean import DISC_PLACES
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.commands.map.layers import (
        TagLayers,
        disc_map,
        map_dataset,
        spread_map,
        tag_map,
    )
    from octant.reader_design.setting.links import study_responses
    from octant.reader_design.setting.map_grid import map_axes_m
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.showing.netcdf import write_dataset
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    if antenna is not None and isotropic:
        msg = "--antenna and --isotropic are both given, but a map has one receiver; give one."
        raise ConfigError(msg)
    if antenna is not None and antenna > loaded.reader.antennas:
        msg = f"--antenna is {antenna}, but the reader has antennas 1 to {loaded.reader.antennas}."
        raise ConfigError(msg)
    refuse_overwrite(out, *_pages(figures), force=force)
    built = build_setting(loaded)
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
    layers = []
    places = axes[0].size * axes[1].size
    for tag in tags:
        with progress.count(places, label=f"tag {tag.id}") as done:
            one = tag_map(loaded, built, tag, responses, axes=axes, told=done)
        disc = spread = None
        if local_mean_disc:
            with progress.count(DISC_PLACES, label=f"tag {tag.id}, discs") as done:
                disc = disc_map(loaded, built, tag, responses, axes=axes, told=done)
        if spreads:
            with progress.count(places, label=f"tag {tag.id}, spreads") as done:
                spread = spread_map(loaded, built, tag, axes=axes, told=done)
        layers.append(TagLayers(tag=tag, power=one, disc_mean_w=disc, spreads=spread))
    data = map_dataset(
        loaded, layers, antenna=antenna, local_mean=local_mean or figures is not None
    )
    write_dataset(data, out, force=force)
    if figures is not None:
        from octant.reader_design.commands.map.figures import map_pages
        from octant.reader_design.showing.style import save_figure

        for name, figure in map_pages(data, built):
            save_figure(figure, figures / name)
    for layer in layers:
        click.echo(_summary_line(layer.tag.id, layer.power))
    click.echo(f"written: {out}")


def _refuse_huge(
    study: Study, axes: tuple[FloatArray, FloatArray], *, tags: int, receivers: int
) -> None:
    from octant.reader_design.setting.map_grid import LARGEST_MAP

    values = axes[0].size * axes[1].size * tags * receivers
    if values > LARGEST_MAP:
        msg = (
            f"map.spacing_m is {study.map.spacing_m:g} m, which with {tags} tags and {receivers} "
            f"antennas makes {values:.3g} values; choose a coarser grid, or one --tag or --antenna."
        )
        raise ConfigError(msg)


def _pages(folder: Path | None) -> list[Path]:
    """Return the figures that may be written."""
    if folder is None:
        return []
    from octant.reader_design.commands.map.figures import PAGES

    return [folder / name for name in PAGES]


def _summary_line(tag_id: str, one: "RadioMap") -> str:
    strongest = one.coherent_w.max(axis=-1) if one.coherent_w.ndim == 3 else one.coherent_w
    heard = strongest[one.path_count > 0]
    if heard.size == 0 or heard.max() <= 0.0:
        return f"tag {tag_id}: no path to any of {one.path_count.size} places."
    dbm = power_dbm(heard)
    return (
        f"tag {tag_id}: {one.path_count.size} places, {int((one.path_count == 0).sum())} without a "
        f"path; strongest antenna {dbm.min():.1f} to {dbm.max():.1f} dBm, median "
        f"{np.median(dbm):.1f} dBm; {int(one.path_count.sum())} paths."
    )
