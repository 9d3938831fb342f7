"""``octant map``: received power over the floor of a study's room."""

from pathlib import Path

import click

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import approve, common_options


@click.command(name="map")
@click.argument("study", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path), required=True, help="The netCDF file to write."
)
@click.option("--tag", "tag_ids", multiple=True, help="Tag to map; default: all of the study.")
@click.option("--antenna", type=click.IntRange(1, 100), help="Only this antenna of the reader.")
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
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.map_figures import PAGES, save_pages
    from octant.reader_design.face.rss_map import (
        MapWanted,
        map_rss,
        summary_lines,
        unreached_places,
    )
    from octant.reader_design.keeping.keys import digest
    from octant.reader_design.keeping.results import complete_line
    from octant.reader_design.keeping.versions import versions
    from octant.reader_design.setting.advice import opaque_wall_note
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.showing.netcdf import inputs_of, read_dataset, write_dataset
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    if antenna is not None and isotropic:
        msg = "--antenna and --isotropic are both given, but a map has one receiver; give one."
        raise ConfigError(msg)
    if antenna is not None and antenna > loaded.reader.antennas:
        msg = f"--antenna is {antenna}, but the reader has antennas 1 to {loaded.reader.antennas}."
        raise ConfigError(msg)
    pages = [] if figures is None else [figures / name for name in PAGES]
    wanted = MapWanted(
        tag_ids=tag_ids,
        antennas=None if antenna is None else (antenna,),
        isotropic=isotropic,
        local_mean=local_mean or figures is not None,
        local_mean_disc=local_mean_disc,
        spreads=spreads,
    )
    progress, inputs = Progress(quiet=quiet), digest([loaded, wanted, versions()])
    if not force and inputs_of(out) == inputs:
        progress.say(complete_line(out))
        if figures is not None:
            save_pages(read_dataset(out), build_setting(loaded), figures)
        return
    refuse_overwrite(out, *pages, force=force)
    data, setting, layers = map_rss(
        loaded,
        wanted,
        progress=progress,
        approve=lambda cost: approve(cost, progress),
    )
    write_dataset(data.assign_attrs(inputs=inputs), out, force=True)
    if figures is not None:
        save_pages(data, setting, figures)
    for line in summary_lines(layers):
        click.echo(line)
    if advice := opaque_wall_note(loaded, setting.scene, unreached_places(layers)):
        progress.say(advice)
    click.echo(f"written: {out}")
