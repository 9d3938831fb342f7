"""``octant scene``: the room of a study as a GLB file and as a picture, with paths drawn."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.commands.ends import EndAntenna, path_options, study_link
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, common_options

if TYPE_CHECKING:
    from octant.reader_design.commands.scene.drawing import DrawnPaths
    from octant.reader_design.setting.setting import Setting
    from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--glb", type=click.Path(path_type=Path), help="Write the room as GLB here.")
@click.option("--picture", type=click.Path(path_type=Path), help="Write a PNG here.")
@click.option("--tx", type=POINT, help="Transmitter of the paths [m].")
@click.option("--rx", type=POINT, help="Receiver of the paths [m].")
@click.option(
    "--strongest",
    "most",
    type=click.IntRange(min=1),
    default=30,
    show_default=True,
    help="Draw at most so many paths.",
)
@click.option(
    "--colour-by",
    type=click.Choice(["gain", "order"]),
    default="gain",
    show_default=True,
    help="What the colour of a path tells.",
)
@click.option(
    "--azimuth-deg", type=float, default=-60.0, show_default=True, help="View from [deg]."
)
@click.option(
    "--elevation-deg", type=float, default=35.0, show_default=True, help="View from [deg]."
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
    antennas: tuple[EndAntenna, EndAntenna],
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
    from octant.reader_design.setting.setting import build_setting
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
    loaded = load_study(study)
    built = build_setting(loaded)
    ends: dict[str, FloatArray] = {}
    paths = None
    if tx is not None and rx is not None:
        ends, paths = _paths(
            study,
            (tx, rx),
            antennas=antennas,
            max_reflections=max_reflections,
            most=most,
            quiet=quiet,
        )
        click.echo(f"{len(paths.order)} strongest of {paths.of} paths drawn.")
    if glb is not None:
        from octant.reader_design.commands.scene.glb import write_scene

        write_scene(built.scene, glb, paths=paths, ends_m=ends)
    if picture is not None:
        from octant.reader_design.commands.scene.picture import View, scene_figure
        from octant.reader_design.showing.style import save_figure

        figure = scene_figure(
            built.scene,
            title=_title(built, loaded, paths),
            tags={tag.id: tag.position_m for tag in built.tags},
            ends_m=ends,
            reader_m=_reader_triangles(loaded, built),
            paths=paths,
            colour_by="order" if colour_by == "order" else "gain",
            view=View(azimuth_deg=azimuth_deg, elevation_deg=elevation_deg),
        )
        save_figure(figure, picture)
    for file in files:
        click.echo(f"written: {file}")


def _paths(
    study: Path,
    places: tuple[tuple[float, float, float], tuple[float, float, float]],
    *,
    antennas: tuple[EndAntenna, EndAntenna],
    max_reflections: int | None,
    most: int,
    quiet: bool,
) -> "tuple[dict[str, FloatArray], DrawnPaths]":
    """Return the ends, where they stand, and the strongest paths between them."""
    from octant.em.decibels import decibels
    from octant.em.fields.gains import path_gains
    from octant.em.paths.tracing import trace_paths
    from octant.reader_design.commands.scene.drawing import DrawnPaths

    link = study_link(
        study,
        places[0],
        np.array([places[1]]),
        antennas=antennas,
        max_reflections=max_reflections,
        progress=Progress(quiet=quiet),
    )
    found = trace_paths(link.radio, link.candidates, link.receivers_m)
    gains = path_gains(link.radio, found, transmitter=link.transmitter, receiver=link.receiver)
    gain_db = decibels(np.abs(gains.gain) ** 2)
    chosen = np.argsort(-gain_db, kind="stable")[:most]
    drawn = DrawnPaths(
        vertices_m=tuple(found.vertices_of(int(k)) for k in chosen),
        gain_db=gain_db[chosen],
        order=found.order[chosen],
        of=len(found),
    )
    return {"transmitter": found.source_m, "receiver": link.receivers_m[0]}, drawn


def _title(built: "Setting", study: "Study", paths: "DrawnPaths | None") -> str:
    if paths is None:
        return built.name
    frequency = f"{study.radio.frequency_hz / 1e9:g} GHz"
    shown = len(paths.order)
    what = f"all {shown} paths" if shown == paths.of else f"{shown} strongest of {paths.of} paths"
    return f"{built.name}: {what}, {frequency}"


def _reader_triangles(study: "Study", built: "Setting") -> FloatArray | None:
    """Return the reader's body where the mission starts, or None where there is no mission."""
    from octant.geometries.bodies import place

    if study.mission is None:
        return None
    body = study.reader.body().body
    turn = math.radians(study.mission.heading_deg - 90.0)
    where = (*study.mission.start_m, built.reader_z_m)
    return place(body, position_m=where, yaw_rad=turn).triangles_m
