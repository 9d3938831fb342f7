"""``octant map``: received power over the floor of a study's room."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, approve, common_options, number
from octant.reader_design.study_file.quantities import Angle, Distance, Level, Power

if TYPE_CHECKING:
    import xarray as xr

    from octant.reader_design.face.map_files import Export
    from octant.reader_design.study_file.schema import Study


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
@click.option("--spacing-m", type=number(Distance), help="In place of map.spacing_m [m].")
@click.option(
    "--height-m", type=number(Distance), help="Of the receivers, in place of map.height_m [m]."
)
@click.option("--heading-deg", type=number(Angle), help="Of the robot, in place of the mission's.")
@click.option(
    "--power-w",
    type=number(Power),
    help="What tags send, in place of radio.tag_power_w, or the reader, of rfid.power_w [W].",
)
@click.option("--power-dbm", type=number(Level), help="The same in dBm.")
@click.option("--tx", type=POINT, help="A transmitter of yours [m], in place of the tags.")
@click.option(
    "--tx-antenna",
    default="dipole",
    show_default=True,
    help="Its antenna: a kind as of [[tag]], or a pattern file.",
)
@click.option(
    "--threshold-dbm",
    type=number(Level),
    help="Say on how much of the floor this level is reached, and draw its line in figures.",
)
@click.option(
    "--export",
    "exports",
    type=click.Choice(["csv", "mat", "png", "geotiff", "map-server"]),
    multiple=True,
    help="Write the map in this form too, beside OUT; may be repeated.",
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
    spacing_m: float | None,
    height_m: float | None,
    heading_deg: float | None,
    power_w: float | None,
    power_dbm: float | None,
    tx: tuple[float, float, float] | None,
    tx_antenna: str,
    threshold_dbm: float | None,
    exports: tuple[str, ...],
    force: bool,
    quiet: bool,
) -> None:
    """Map what the reader of STUDY receives from its tags, over the floor of the room.

    The robot's heading is that of the mission, or 90 degrees. Writes rss_w (coherent) and
    path_count, and for the whole reader the strongest antenna and the bearing error of the
    RSS-weighted vector sum; 0 W where no path arrives. Spreads are those of the channel between the
    tag and an isotropic_theta antenna at the carrier.

    --export csv and mat hold everything, in W and dBm. png (with a world file), geotiff (float32)
    and map-server (pgm and yaml for ROS, and the parameters of a Nav2 costmap filter, whose value
    is base + multiplier x mask) hold one layer a file: power of the strongest antenna, local means,
    absolute bearing error and, with --threshold-dbm, where that level is reached.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.map_figures import PAGES, save_pages
    from octant.reader_design.face.map_files import coverage_lines, export_names, write_exports
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
    from octant.reader_design.setting.setting import Setting, build_setting
    from octant.reader_design.showing.netcdf import inputs_of, read_dataset, write_dataset
    from octant.reader_design.study_file.loading import load_study

    given = load_study(study)
    if heading_deg is None and given.mission is not None:
        heading_deg = given.mission.heading_deg
    loaded = _changed(
        given,
        power_w=_power_w(power_w, power_dbm),
        spacing_m=spacing_m,
        height_m=height_m,
        tx=tx,
        tx_antenna=tx_antenna,
    )
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
        heading_deg=heading_deg,
        isotropic=isotropic,
        local_mean=local_mean or figures is not None,
        local_mean_disc=local_mean_disc,
        spreads=spreads,
    )
    named = export_names(
        out,
        cast("tuple[Export, ...]", tuple(dict.fromkeys(exports))),
        wanted.raster_layers(threshold=threshold_dbm is not None),
        tag_ids or [tag.id for tag in loaded.tags],
    )
    files = [file for _, file, _, _ in named]

    def finish(data: "xr.Dataset", setting: Setting) -> None:
        if figures is not None:
            save_pages(data, setting, figures, threshold_dbm=threshold_dbm)
        write_exports(data, named, threshold_dbm=threshold_dbm)
        if threshold_dbm is not None:
            for line in coverage_lines(data, threshold_dbm):
                click.echo(line)

    progress, inputs = Progress(quiet=quiet), digest([loaded, wanted, versions()])
    if not force and inputs_of(out) == inputs:
        progress.say(complete_line(out))
        finish(read_dataset(out), build_setting(loaded))
        return
    refuse_overwrite(out, *pages, *files, force=force)
    data, setting, layers = map_rss(
        loaded,
        wanted,
        progress=progress,
        approve=lambda cost: approve(cost, progress),
    )
    write_dataset(data.assign_attrs(inputs=inputs), out, force=True)
    finish(data, setting)
    for line in summary_lines(layers):
        click.echo(line)
    if advice := opaque_wall_note(loaded, setting.scene, unreached_places(layers)):
        progress.say(advice)
    shown = [str(path) for path in (out, *files, *([figures] if figures is not None else []))]
    click.echo(f"written: {', '.join(shown)}")


def _power_w(power_w: float | None, power_dbm: float | None) -> float | None:
    """Return the power that was asked for, in either unit [W]."""
    if power_w is not None and power_dbm is not None:
        msg = "--power-w and --power-dbm are both given, but there is one power; give one."
        raise ConfigError(msg)
    return power_w if power_dbm is None else 1e-3 * 10.0 ** (0.1 * power_dbm)


def _changed(
    study: "Study",
    *,
    power_w: float | None,
    spacing_m: float | None,
    height_m: float | None,
    tx: tuple[float, float, float] | None,
    tx_antenna: str,
) -> "Study":
    """Return a study with what the command line says in place of its own keys [W], [m]."""
    from octant.reader_design.study_file.loading import vary

    changes: dict[str, Any] = {}
    if tx is not None:
        changes["tag"] = [{"id": "tx", "position_m": tx, "antenna": tx_antenna}]
        changes |= dict.fromkeys(("mission", "rfid", "dock", "track", "optimise", "tolerance"))
    woken = tx is None and any(tag.kind != "active" for tag in study.tags)
    for path, value in (
        ("rfid.power_w" if woken else "radio.tag_power_w", power_w),
        ("map.spacing_m", spacing_m),
        ("map.height_m", height_m),
    ):
        if value is not None:
            changes[path] = value
    return vary(study, changes, directory=Path.cwd()) if changes else study
