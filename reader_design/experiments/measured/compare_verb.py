"""``octant compare``: a measured log beside what the study predicts."""

from pathlib import Path

import click

from octant.reader_design.options import Ended, RunOptions, experiment, number
from octant.reader_design.study_file.quantities import Count, Distance
from octant.reader_design.terminal.completion import PATTERN_FILES, built_in_antennas, files

KEPT = "kept"
"""Folder of the stamp that says that results are complete."""

log_option = click.option(
    "--log",
    "log_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    shell_complete=files(".csv"),
    help="The log, read as the table [log] says; default: log.file of the study.",
)
antenna_option = click.option(
    "--antenna",
    default="dipole",
    show_default=True,
    metavar="KIND|FILE",
    shell_complete=files(*PATTERN_FILES, names=built_in_antennas),
    help="The robot's antenna where the log numbers none: a kind as of [[tag]], or a pattern file.",
)
cell_option = click.option(
    "--cell-m",
    type=number(Distance),
    default=0.5,
    show_default=True,
    metavar="M",
    help="Side of the cells of local means [m].",
)
least_option = click.option(
    "--least",
    type=number(Count),
    default=5,
    show_default=True,
    metavar="N",
    help="Readings that make a local mean.",
)


@click.command()
@log_option
@antenna_option
@cell_option
@least_option
@experiment(workers=False, seed=False)
def compare(
    *,
    study: Path | None,
    options: RunOptions,
    log_file: Path | None,
    antenna: str,
    cell_m: float,
    least: int,
) -> Ended:
    """Compare a log of readings with what STUDY predicts, as local means and as single readings.

    Beside the prediction stand laws of distance and walls fitted to the same log, and the scatter
    of readings within a cell, which no map can beat. Readings that say "not heard" count where the
    log's threshold is known. Writes compare.csv (one row a local mean), figures (residuals on the
    floor plan, against distance and walls), study.toml and report.html.
    """
    from octant.geometries.files import write_text
    from octant.reader_design.experiments.measured.compare import compared
    from octant.reader_design.experiments.measured.compare_page import (
        OUTPUTS,
        compare_lines,
        write_compared,
    )
    from octant.reader_design.keeping.results import (
        STUDY_FILE,
        files_of,
        refuse_another,
        write_once,
    )
    from octant.reader_design.setting.cost import field_cost
    from octant.reader_design.setting.measured import measured_log, with_log
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.study_file.loading import load_study, to_toml

    loaded = with_log(load_study(study))
    setting = build_setting(loaded)
    measured = measured_log(loaded, setting.scene, file=log_file)
    if options.dry_run:
        line = f"would predict {len(measured.log)} readings of {measured.file}."
        return Ended(lines=(line,))
    options.approve(field_cost(loaded, len(measured.log), tags=1, causes=("the log's readings",)))
    text = to_toml(loaded, relative_to=options.out)
    refuse_another(options.out, text, force=options.force, outputs=OUTPUTS)
    options.out.mkdir(parents=True, exist_ok=True)
    for note in measured.notes:
        options.progress.say(note)
    found = compared(
        setting,
        measured.log,
        antenna=antenna,
        cell_m=cell_m,
        least=least,
        progress=options.progress,
    )
    write_text(options.out / STUDY_FILE, text)
    write_once(
        options.out / KEPT / "finished.json",
        [text, measured.log, antenna, cell_m, least],
        lambda: write_compared(found, options.out),
        force=options.force,
        progress=options.progress,
    )
    return Ended(
        lines=compare_lines(found),
        written=files_of(options.out, OUTPUTS),
        tables=(options.out / "compare.csv",),
    )
