"""``octant scene``: the room of a study as a GLB file and as a picture, with paths drawn."""

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from octant.geometries.errors import ConfigError
from octant.reader_design.commands.paths import command_link, path_options
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, common_options, number
from octant.reader_design.study_file.quantities import Angle

if TYPE_CHECKING:
    from octant.reader_design.face.paths import End


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--glb", type=click.Path(path_type=Path), help="Write the room as GLB here.")
@click.option("--picture", type=click.Path(path_type=Path), help="Write a PNG here.")
@click.option("--tx", type=POINT, help="Transmitter of the paths [m].")
@click.option("--rx", type=POINT, help="Receiver of the paths [m].")
@click.option(
    "--strongest",
    "most",
    type=click.IntRange(1, 10**6),
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
    "--azimuth-deg", type=number(Angle), default=-60.0, show_default=True, help="View from [deg]."
)
@click.option(
    "--elevation-deg", type=number(Angle), default=35.0, show_default=True, help="View from [deg]."
)
@path_options
@common_options
def scene(
    *,
    study: Path,
    glb: Path | None,
    picture: Path | None,
    tx: tuple[float, float, float] | None,
    rx: tuple[float, float, float] | None,
    most: int,
    colour_by: str,
    azimuth_deg: float,
    elevation_deg: float,
    antennas: tuple["End", "End"],
    max_reflections: int | None,
    force: bool,
    quiet: bool,
) -> None:
    """Show the room of STUDY: as a GLB file for any viewer, as a picture, or both.

    With --tx and --rx the strongest paths between them are drawn; the GLB then holds them as tubes
    and is for looking only. Without them it is the room alone, with its materials by name, and may
    stand as a mesh in a study file.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.paths import Paths
    from octant.reader_design.face.room import scene_picture
    from octant.reader_design.face.scene_glb import write_scene
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.showing.scene_picture import View
    from octant.reader_design.showing.style import save_figure
    from octant.reader_design.study_file.loading import load_study

    if glb is None and picture is None:
        msg = "nothing is to be written; give --glb FILE.glb, --picture FILE.png, or both."
        raise ConfigError(msg)
    if (tx is None) != (rx is None):
        msg = "paths need both ends, but only one is given; give --tx and --rx, or neither."
        raise ConfigError(msg)
    for file, suffix in ((glb, ".glb"), (picture, ".png")):
        if file is not None and file.suffix.lower() != suffix:
            msg = f"{file} ends in {file.suffix!r}, but it will be a {suffix} file; name it so."
            raise ConfigError(msg)
    files = [file for file in (glb, picture) if file is not None]
    refuse_overwrite(*files, force=force)
    setting = build_setting(load_study(study))
    found = None
    if tx is not None and rx is not None:
        link = command_link(
            study,
            tx,
            np.array([rx]),
            antennas=antennas,
            max_reflections=max_reflections,
            progress=Progress(quiet=quiet),
        )
        found = Paths(link=link, blocks=tuple(link.blocks()))
        drawn = found.strongest(most)
        click.echo(f"{len(drawn.order)} strongest of {drawn.of} paths drawn.")
    if glb is not None:
        write_scene(
            setting.scene,
            glb,
            paths=None if found is None else found.strongest(most),
            ends_m={} if found is None else found.ends_m(),
        )
    if picture is not None:
        figure = scene_picture(
            setting,
            found=found,
            most=most,
            colour_by="order" if colour_by == "order" else "gain",
            view=View(azimuth_deg=azimuth_deg, elevation_deg=elevation_deg),
        )
        save_figure(figure, picture)
    for file in files:
        click.echo(f"written: {file}")
