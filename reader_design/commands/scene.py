"""``octant scene``: the room of a study as a GLB file and as a picture, with paths drawn."""

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from octant.geometries.errors import ConfigError
from octant.reader_design.commands.ends import Place, command_link, path_options, tx_option
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import (
    POINT,
    common_options,
    json_option,
    number,
    study_argument,
    written_line,
)
from octant.reader_design.study_file.quantities import Angle

if TYPE_CHECKING:
    from octant.geometries.bodies import Body
    from octant.reader_design.face.paths import End
    from octant.reader_design.setting.setting import Setting

FOLDER = "octant-scene"


@click.command()
@study_argument
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Folder for scene.glb and scene.png, or one file .glb or .png; default: octant-scene, "
    "unless --glb or --picture says where.",
)
@click.option("--glb", type=click.Path(path_type=Path), help="Write the room as GLB here.")
@click.option("--picture", type=click.Path(path_type=Path), help="Write a PNG here.")
@tx_option(required=False)
@click.option("--rx", type=POINT, help="Receiver of the paths [m].")
@click.option(
    "--strongest",
    "most",
    type=click.IntRange(1, 10**6),
    metavar="N",
    default=30,
    show_default=True,
    help="Draw at most so many paths.",
)
@click.option(
    "--colour-by",
    type=click.Choice(["gain", "order"]),
    default="gain",
    show_default=True,
    help="What the colour of a path shows.",
)
@click.option(
    "--azimuth-deg",
    type=number(Angle),
    metavar="DEG",
    default=-60.0,
    show_default=True,
    help="View from this azimuth [deg].",
)
@click.option(
    "--elevation-deg",
    type=number(Angle),
    metavar="DEG",
    default=35.0,
    show_default=True,
    help="View from this elevation [deg].",
)
@click.option(
    "--with",
    "what",
    type=click.Choice(["tags", "reader", "axes"]),
    multiple=True,
    help="Put these into the GLB file too, as nodes by name; may be repeated.",
)
@click.option(
    "--trajectory",
    type=click.Path(path_type=Path),
    help="Put this way into the GLB file: a CSV file with x_m and y_m, as trajectory.csv.",
)
@path_options
@json_option
@common_options
def scene(
    *,
    study: Path | None,
    out: Path | None,
    glb: Path | None,
    picture: Path | None,
    tx: Place | None,
    rx: tuple[float, float, float] | None,
    most: int,
    colour_by: str,
    azimuth_deg: float,
    elevation_deg: float,
    what: tuple[str, ...],
    trajectory: Path | None,
    antennas: tuple["End", "End"],
    max_reflections: int | None,
    as_json: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Show the room of STUDY: as a GLB file for any viewer, as a picture, or both.

    With --tx and --rx the strongest paths between them are drawn; the GLB then holds them as tubes
    and is for looking only. Without them it is the room alone, with its materials by name, and may
    stand as a mesh in a study file. --with tags, reader (at the mission's start) and axes, and
    --trajectory, put further nodes into the GLB file, which then too is for looking only.
    """
    from octant.geometries.files import put_finished
    from octant.reader_design.face.paths import Paths
    from octant.reader_design.face.room import scene_picture
    from octant.reader_design.keeping.results import complete_line
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.showing.scene_glb import write_scene
    from octant.reader_design.showing.scene_picture import View
    from octant.reader_design.showing.style import save_figure
    from octant.reader_design.study_file.loading import load_study
    from octant.reader_design.terminal.documents import json_text

    glb, picture = _places(out, glb, picture)
    if (tx is None) != (rx is None):
        msg = "paths need both ends, but only one is given; give --tx and --rx, or neither."
        raise ConfigError(msg)
    for file, suffix in ((glb, ".glb"), (picture, ".png")):
        if file is not None and file.suffix.lower() != suffix:
            msg = f"{file} ends in {file.suffix!r}, but it will be a {suffix} file; name it so."
            raise ConfigError(msg)
    places = [file for file in (glb, picture) if file is not None]
    progress = Progress(quiet=quiet)
    setting = build_setting(load_study(study))
    if glb is None and (what or trajectory is not None):
        msg = "--with and --trajectory are for the GLB file, but none is written; name it by --glb."
        raise ConfigError(msg)
    shown = _shown(setting, what, trajectory)
    found, drawn = None, None
    if tx is not None and rx is not None:
        link = command_link(
            study,
            tx,
            np.array([rx]),
            antennas=antennas,
            max_reflections=max_reflections,
            progress=progress,
        )
        found = Paths(link=link, blocks=tuple(link.blocks()))
        drawn = found.strongest(most)
    with tempfile.TemporaryDirectory() as folder:
        made = {file: Path(folder) / f"scene{file.suffix}" for file in places}
        if glb is not None:
            ends_m = {} if found is None else found.ends_m()
            write_scene(setting.scene, made[glb], paths=drawn, ends_m=ends_m, shown=shown)
        if picture is not None:
            figure = scene_picture(
                setting,
                found=found,
                most=most,
                colour_by="order" if colour_by == "order" else "gain",
                view=View(azimuth_deg=azimuth_deg, elevation_deg=elevation_deg),
            )
            save_figure(figure, made[picture])
        if not put_finished(made, force=force):
            progress.say(complete_line(*places))
    if as_json:
        document = {
            "verb": "scene",
            "study": study,
            "paths": None if drawn is None else drawn.of,
            "paths_drawn": None if drawn is None else len(drawn.order),
            "written": places,
        }
        click.echo(json_text(document))
        return
    if drawn is not None:
        click.echo(f"{len(drawn.order)} strongest of {drawn.of} paths drawn.")
    click.echo(written_line(places))


def _shown(setting: "Setting", what: tuple[str, ...], trajectory: Path | None) -> list["Body"]:
    """Return what stands in the GLB file besides the room."""
    from octant.reader_design.showing.scene_glb import (
        axes_bodies,
        reader_bodies,
        tag_bodies,
        way_body,
    )
    from octant.reader_design.showing.tables import read_columns

    study, extent_m = setting.study, max(setting.scene.extent_m, 1.0)
    shown: list[Body] = []
    if "tags" in what:
        shown += tag_bodies({tag.id: tag.position_m for tag in setting.tags}, extent_m)
    if "reader" in what:
        if study.mission is None:
            msg = (
                "--with reader needs a place: give the study a [mission], at whose start it stands."
            )
            raise ConfigError(msg)
        shown += reader_bodies(
            setting.reader,
            (*study.mission.start_m, math.radians(study.mission.heading_deg)),
            setting.reader_z_m,
            frequency_hz=study.radio.frequency_hz,
        )
    if "axes" in what:
        shown += axes_bodies(extent_m)
    if trajectory is not None:
        places = read_columns(trajectory, ("x_m", "y_m"))
        floor_m = setting.scene.floor_height_m
        shown.append(way_body(places, floor_m, extent_m, name=f"trajectory {trajectory.stem}"))
    return shown


def _places(
    out: Path | None, glb: Path | None, picture: Path | None
) -> tuple[Path | None, Path | None]:
    """Return where the GLB file and the picture go; None: it is not written."""
    if out is None and (glb is not None or picture is not None):
        return glb, picture
    out = out or Path(FOLDER)
    if out.suffix.lower() == ".glb":
        return glb or out, picture
    if out.suffix.lower() == ".png":
        return glb, picture or out
    return glb or out / "scene.glb", picture or out / "scene.png"
