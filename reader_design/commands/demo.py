"""``octant demo``: the whole chain within a minute, from data in the package."""

from pathlib import Path

import click

from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import common_options, out_option

_FRAMES = 30  # the whole is to take a minute, compilation included


@click.command()
@out_option("octant-demo")
@common_options
def demo(*, out: Path, force: bool, quiet: bool) -> None:
    """Show the whole chain within a minute: room, map, moving robot, report.

    A robot with a reader that is solved already visits three tags in the furnished office. Paths
    have at most one reflection, and walls let nothing through; `octant study` is the same in full.
    Writes report.html, drive.gif (the robot, what its antennas receive, the field), room.png and
    the files of a quick `octant study`.
    """
    from octant.reader_design.experiments.missions.verb import write_animation
    from octant.reader_design.experiments.study.run import run_study
    from octant.reader_design.face.room import scene_picture
    from octant.reader_design.showing.style import save_figure
    from octant.reader_design.study_file.loading import load_study

    progress = Progress(quiet=quiet)
    study = load_study("demo")
    outcome = run_study(study, out, quick=True, force=force, progress=progress)
    mission = outcome.content.missions[0]
    movie, picture = out / "drive.gif", out / "room.png"
    if force or not movie.is_file():
        assert mission.setting is not None  # noqa: S101  the built-in mission can be driven
        write_animation(movie, mission.setting, mission.results[0], progress, most_frames=_FRAMES)
        save_figure(scene_picture(mission.setting), picture)
    for line in outcome.lines()[:2]:
        click.echo(line)
    click.echo(f"written: {outcome.report}, {movie} and {picture}")
    progress.say("next: octant init YOUR_ROOM.glb, or octant study for the office in full")
