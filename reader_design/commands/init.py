"""``octant init``: a first study of a room from its mesh file."""

from pathlib import Path
from typing import Literal

import click

from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options, number
from octant.reader_design.study_file.quantities import Distance, Extent


@click.command(name="init")
@click.argument("mesh", type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="The study file to write; by default NAME.toml of MESH in the current folder.",
)
@click.option(
    "--geometry",
    type=click.Choice(["visual", "collision"]),
    default="visual",
    show_default=True,
    help="Of SDF and URDF: what is seen, or what robots collide with.",
)
@click.option(
    "--height-m", type=number(Extent), help="Height of the walls of a floor plan [m]; default 2.5."
)
@click.option(
    "--metres-per-pixel",
    type=number(Distance),
    metavar="M",
    help="Scale of a floor plan that is a picture [m].",
)
@click.option(
    "--resource-path",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A folder in which SDF and URDF find their models; repeatable.",
)
@common_options
def init(
    *,
    mesh: Path,
    out: Path | None,
    geometry: Literal["visual", "collision"],
    height_m: float | None,
    metres_per_pixel: float | None,
    resource_path: tuple[Path, ...],
    force: bool,
    quiet: bool,
) -> None:
    """Write a first study of the room in MESH, and draw it.

    MESH is a GLB, STL, OBJ, PLY, DAE ... file, a Sionna or Mitsuba XML, an SDF world, a URDF, or
    a floor plan: the YAML of a ROS map, a picture or a DXF. Unit and vertical axis are guessed with
    reasons; every body gets a material from its name; tags and start are put on free floor. What is
    guessed is marked so in the file. Writes NAME.toml and NAME.png (a plan where the mesh is
    dense).
    """
    from octant.geometries.files import refuse_overwrite, write_text
    from octant.geometries.mesh_files import Reading
    from octant.reader_design.drafting.draft import draft_study
    from octant.reader_design.drafting.picture import MOST_DRAWN, plan_picture
    from octant.reader_design.face.room import scene_picture
    from octant.reader_design.showing.style import save_figure

    study = out if out is not None else Path(f"{mesh.stem}.toml")
    if study.suffix.lower() != ".toml":
        msg = f"--out is {study}, but a study is a .toml file; name it so."
        raise click.UsageError(msg)
    picture = study.with_suffix(".png")
    if picture.resolve() == mesh.resolve():  # a plan that is a picture stays
        picture = study.with_name(f"{study.stem}_room.png")
    refuse_overwrite(study, picture, force=force)
    reading = Reading(
        geometry=geometry,
        height_m=height_m,
        metres_per_pixel=metres_per_pixel,
        resource_path=tuple(str(folder) for folder in resource_path),
    )
    draft = draft_study(mesh, study, reading=reading)
    write_text(study, draft.text)
    progress = Progress(quiet=quiet)
    for line in draft.said:
        progress.say(line)
    triangles = sum(len(body.faces) for body in draft.setting.scene.bodies)
    dense = triangles > MOST_DRAWN
    save_figure((plan_picture if dense else scene_picture)(draft.setting), picture)
    click.echo(f"written: {study} and {picture}")
    progress.say(f"next: octant map {study}, octant navigate {study}")
