"""``octant dock``: docking missions of a study, and the docking paper's experiments."""

from pathlib import Path

import click

from octant.reader_design.progress import Progress
from octant.reader_design.verbs.arguments import POWER_KERNELS, common_options, kernels_for

LEAST_REPETITIONS = 20
"""Repetitions of the filter experiments below which errors cannot be tested for a Gaussian [-]."""


@click.command()
@click.argument("study", type=click.Path(path_type=Path), required=False)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("octant-dock"),
    show_default=True,
    help="Folder for results.",
)
@click.option("--runs", type=click.IntRange(min=1), help="Runs in each room; default: the study's.")
@click.option(
    "--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Processes."
)
@common_options
def dock(
    *, study: Path | None, out: Path, runs: int | None, workers: int, force: bool, quiet: bool
) -> None:
    """Dock at the station of STUDY from random starts, in its room and in every layout.

    The bearing-sensitive reader brings the robot to the staging place under the station's tag, the
    landmark filter and the docking law finish. Without STUDY a built-in station in a concrete room
    is used. Writes docking.csv (one row a run), trajectory.csv (run 0), study.toml, figures of the
    missions and of the docking paper's experiments, and report.html.
    """
    from octant.navigation.docking_files import write_docking_csv, write_docking_trajectory_csv
    from octant.reader_design.config.loading import load_study, to_toml
    from octant.reader_design.docking.experiments import (
        docking_experiment,
        filter_experiment,
        straight_experiment,
    )
    from octant.reader_design.docking.figures import (
        filter_figures,
        law_figures,
        mission_figures,
        save_figures,
    )
    from octant.reader_design.docking.missions import (
        dock_table,
        docking_job,
        docking_space,
        run_dockings,
    )
    from octant.reader_design.report.dock import docking_report, summary_lines
    from octant.reader_design.report.html import render_report
    from octant.reader_design.rooms.study_scene import build_study_scene
    from octant.reader_design.store import refuse_overwrite, write_text
    from octant.reader_design.study.missions import study_responses

    loaded = load_study(study, built_in="dock_study")
    table = dock_table(loaded)
    names = ("docking.csv", "trajectory.csv", "study.toml", "report.html")
    files = {name: out / name for name in names}
    refuse_overwrite(*files.values(), force=force)
    scenes = [build_study_scene(loaded, layout) for layout in (None, *loaded.layouts)]
    for scene in scenes:
        docking_space(loaded, scene)  # a bad station is refused before anything is computed
    progress = Progress(quiet=quiet)
    for note in dict.fromkeys(note for scene in scenes for note in scene.notes):
        progress.say(note)
    progress.announce_compilation(kernels_for(loaded.reader.response, *POWER_KERNELS))
    responses = study_responses(loaded)
    jobs = {scene.name: docking_job(loaded, scene, responses) for scene in scenes}
    number = table.runs if runs is None else runs
    results = {}
    for name, job in jobs.items():
        with progress.count(number, label=name) as done:
            results[name] = run_dockings(loaded, job, runs=number, workers=workers, progress=done)
    first = jobs[scenes[0].name]
    progress.say("the docking paper's experiments")
    dockings = docking_experiment(
        first.task, first.setting.camera, seed=loaded.seed, runs=min(number, 100), workers=workers
    )
    repetitions = min(max(number, LEAST_REPETITIONS), 100)
    experiment = filter_experiment(seed=loaded.seed, repetitions=repetitions)
    figures = {
        **mission_figures(
            {scene.name: (scene, results[scene.name]) for scene in scenes},
            dockings,
            tag_id=table.tag,
        ),
        **filter_figures(experiment, straight_experiment(seed=loaded.seed)),
        **law_figures(first.task.fine.law),
    }
    paths = save_figures(figures, out / "figures")
    write_text(files["study.toml"], to_toml(loaded, relative_to=out))
    write_docking_csv(files["docking.csv"], results)
    write_docking_trajectory_csv(files["trajectory.csv"], results[scenes[0].name][0])
    report = docking_report(results, experiment, dockings, name=loaded.name, figures=paths)
    write_text(files["report.html"], render_report(report))
    for line in summary_lines(results):
        click.echo(line)
    click.echo(f"written: {', '.join(str(p) for p in files.values())} and {out / 'figures'}")
