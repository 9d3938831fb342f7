"""``octant map``: received power over the floor of a study's room."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import (
    POINT,
    approve,
    common_options,
    dry_run_option,
    json_option,
    number,
    out_option,
    print_plan,
    quick_option,
    study_argument,
    written_line,
)
from octant.reader_design.study_file.quantities import Angle, Distance, Level, Power
from octant.reader_design.terminal.completion import (
    PATTERN_FILES,
    built_in_antennas,
    tags,
)
from octant.reader_design.terminal.completion import files as completed_files

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr

    from octant.reader_design.face.map_files import Export
    from octant.reader_design.face.rss_map import MapWanted
    from octant.reader_design.setting.cost import Cost
    from octant.reader_design.setting.setting import Setting
    from octant.reader_design.study_file.schema import Study

QUICK_SPACING_M = 0.2
"""Least spacing of a quick map [m]."""


@click.command(name="map")
@study_argument
@out_option("octant-map", "Folder for map.nc and figures, or one netCDF file .nc.")
@click.option(
    "--tag",
    "tag_ids",
    metavar="TAG",
    shell_complete=tags,
    multiple=True,
    help="Tag to map; default: all of the study.",
)
@click.option(
    "--antenna", type=click.IntRange(1, 100), metavar="N", help="Only this antenna of the reader."
)
@click.option("--isotropic", is_flag=True, help="One isotropic_theta antenna, no reader.")
@click.option("--local-mean", is_flag=True, help="Add the power sum over paths.")
@click.option("--local-mean-disc", is_flag=True, help="Add the mean over a disc of one wavelength.")
@click.option("--spreads", is_flag=True, help="Add delay spread and angular spreads.")
@click.option(
    "--figures",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for figures of everything that is mapped; adds the power sum. Default: figures in "
    "the folder --out, none beside a file.",
)
@click.option(
    "--spacing-m", type=number(Distance), metavar="M", help="In place of map.spacing_m [m]."
)
@click.option(
    "--height-m",
    type=number(Distance),
    metavar="M",
    help="Of the receivers, in place of map.height_m [m].",
)
@click.option(
    "--heading-deg",
    type=number(Angle),
    metavar="DEG",
    help="Of the robot, in place of the mission's [deg].",
)
@click.option(
    "--power-w",
    type=number(Power),
    metavar="W",
    help="What tags send, in place of radio.tag_power_w, or the reader, of rfid.power_w [W].",
)
@click.option("--power-dbm", type=number(Level), metavar="DBM", help="The same in dBm.")
@click.option("--tx", type=POINT, help="A transmitter of yours [m], in place of the tags.")
@click.option(
    "--tx-antenna",
    metavar="KIND|FILE",
    shell_complete=completed_files(*PATTERN_FILES, names=built_in_antennas),
    default="dipole",
    show_default=True,
    help="Its antenna: a kind as of [[tag]], or a pattern file.",
)
@click.option(
    "--threshold-dbm",
    type=number(Level),
    metavar="DBM",
    help="Say on how much of the floor this level is reached, and draw its line in figures.",
)
@click.option(
    "--export",
    "exports",
    type=click.Choice(["csv", "mat", "png", "geotiff", "map-server"]),
    multiple=True,
    help="Write the map in this form too, beside OUT; may be repeated.",
)
@quick_option
@dry_run_option
@json_option
@common_options
def radio_map(
    *,
    study: Path | None,
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
    quick: bool,
    dry_run: bool,
    as_json: bool,
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
    from octant.reader_design.face.map_files import export_names
    from octant.reader_design.face.rss_map import MapWanted
    from octant.reader_design.study_file.loading import load_study

    if out.suffix.lower() != ".nc" and not out.is_file():
        out, figures = out / "map.nc", figures or out / "figures"
    given = load_study(study)
    if quick and spacing_m is None:
        spacing_m = max(given.map.spacing_m, QUICK_SPACING_M)
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
    files = _MapFiles(out=out, figures=figures, exports=named, threshold_dbm=threshold_dbm)
    data = _mapped(
        loaded, wanted, files, force=force, dry_run=dry_run, as_json=as_json, quiet=quiet
    )
    _show(data, files, study, as_json=as_json)


@dataclass(frozen=True, slots=True, kw_only=True)
class _MapFiles:
    """Where a map goes, and what is made of it.

    Parameters
    ----------
    out, figures, exports : The netCDF file, the folder of figures (None: none), other forms.
    threshold_dbm : Level whose line and share are shown [dBm].
    """

    out: Path
    figures: Path | None
    exports: "Sequence[tuple[Export, Path, str, str]]"
    threshold_dbm: float | None

    @property
    def written(self) -> list[Path]:
        """Files and folders that hold the map."""
        files = [file for _, file, _, _ in self.exports]
        pages = [] if self.figures is None else [self.figures]
        pages += [] if self.report is None else [self.report]
        return [self.out, *files, *pages]

    @property
    def report(self) -> Path | None:
        """The page to look at; None where the map has no folder to itself."""
        own = self.figures is not None and self.figures == self.out.parent / "figures"
        return self.out.with_name("report.html") if own else None

    @property
    def stamp(self) -> str:
        """What says that all of them belong together."""
        from octant.reader_design.keeping.keys import digest

        return digest([self.threshold_dbm, [path.name for path in self.written]])

    def all_there(self, data: "xr.Dataset") -> bool:
        """Return whether everything that is made of a map is there, and for the same level.

        Parameters
        ----------
        data : The map, as read.
        """
        folder = self.figures or self.out.parent
        pages = [folder / name for name in data.attrs.get("pages", "").split()]
        same = data.attrs.get("drawn") == self.stamp
        return same and all(path.exists() for path in (*self.written, *pages))

    def refuse_overwrite(self, *, force: bool) -> None:
        """Refuse files that are there already, unless forced.

        Parameters
        ----------
        force : Whether they may be replaced.
        """
        from octant.geometries.files import refuse_overwrite
        from octant.reader_design.face.map_figures import PAGES

        pages = [] if self.figures is None else [self.figures / name for name in PAGES]
        files = [file for _, file, _, _ in self.exports]
        pages += [] if self.report is None else [self.report]
        refuse_overwrite(self.out, *pages, *files, force=force)

    def finish(self, data: "xr.Dataset", setting: "Setting", progress: Progress) -> "xr.Dataset":
        """Return the map, once it and everything that is made of it is written.

        Parameters
        ----------
        data, setting, progress : The map, its room; shows that figures are drawn.
        """
        from octant.geometries.files import write_text
        from octant.reader_design.face.map_figures import save_pages
        from octant.reader_design.face.map_files import write_exports
        from octant.reader_design.face.map_page import map_report
        from octant.reader_design.showing.netcdf import write_dataset
        from octant.reader_design.showing.pages import render_report

        pages: list[Path] = []
        if self.figures is not None:
            with progress.during("figures"):
                pages = save_pages(data, setting, self.figures, threshold_dbm=self.threshold_dbm)
                if self.report is not None:
                    page = map_report(data, setting, pages, self.out)
                    write_text(self.report, render_report(page))
        write_exports(data, self.exports, threshold_dbm=self.threshold_dbm)
        data = data.assign_attrs(drawn=self.stamp, pages=" ".join(page.name for page in pages))
        write_dataset(data, self.out, force=True)
        return data


def _mapped(
    study: "Study",
    wanted: "MapWanted",
    files: _MapFiles,
    *,
    force: bool,
    dry_run: bool,
    as_json: bool,
    quiet: bool,
) -> "xr.Dataset":
    """Return the map, read or computed, with its files written; a dry run ends here."""
    from octant.reader_design.face.rss_map import map_rss, summary_lines, unreached_places
    from octant.reader_design.keeping.keys import digest
    from octant.reader_design.keeping.results import complete_line
    from octant.reader_design.keeping.versions import versions
    from octant.reader_design.setting.advice import opaque_sheet_note, opaque_wall_note
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.showing.netcdf import inputs_of, read_dataset, write_dataset

    progress, inputs = Progress(quiet=quiet), digest([study, wanted, versions()])
    if not force and not dry_run and inputs_of(files.out) == inputs:
        data = read_dataset(files.out)
        if files.all_there(data):
            progress.say(complete_line(files.out))
            return data
        progress.say(f"{files.out} is complete already; only what is made of it is written.")
        return files.finish(data, build_setting(study), progress)

    def approved(cost: "Cost") -> None:
        if dry_run:
            print_plan(f"{cost.text()}.", as_json=as_json)
            raise click.exceptions.Exit(0)
        approve(cost, progress)

    if not dry_run:
        files.refuse_overwrite(force=force)
    data, setting, layers = map_rss(study, wanted, progress=progress, approve=approved)
    data = data.assign_attrs(inputs=inputs, summary="\n".join(summary_lines(layers)))
    write_dataset(data, files.out, force=True)
    data = files.finish(data, setting, progress)
    dark = opaque_wall_note(study, setting.scene, unreached_places(layers))
    if advice := dark or opaque_sheet_note(study, setting.scene):
        progress.say(advice)
    return data


def _show(data: "xr.Dataset", files: _MapFiles, study: Path | None, *, as_json: bool) -> None:
    """Print what a map says: a line for each tag, or a document."""
    from octant.reader_design.face.map_files import coverage_lines
    from octant.reader_design.face.map_texts import map_document
    from octant.reader_design.terminal.documents import json_text

    level = files.threshold_dbm
    lines = data.attrs.get("summary", "").splitlines()
    lines += [] if level is None else coverage_lines(data, level)
    if as_json:
        document = map_document(data, threshold_dbm=level)
        more = {"study": study, "summary": lines, "written": files.written}
        click.echo(json_text({"verb": "map", **document, **more}))
        return
    for line in (*lines, written_line(files.written)):
        click.echo(line)


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
