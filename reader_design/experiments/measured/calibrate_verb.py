"""``octant calibrate``: values of a study fitted to a measured log."""

from pathlib import Path
from typing import Literal

import click

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.measured.compare_verb import (
    antenna_option,
    cell_option,
    least_option,
    log_option,
)
from octant.reader_design.options import Ended, RunOptions, experiment


@click.command()
@log_option
@click.option(
    "--fit",
    "names",
    metavar="NAMES",
    required=True,
    multiple=True,
    help="What to fit, with commas between: level, diffuse, tilt:TAG, place:TAG (without a TAG: "
    "of each tag of the log), antenna_level, eps_r:MATERIAL, sigma:MATERIAL, thickness:MATERIAL, "
    "height.",
)
@click.option(
    "--prior",
    "priors",
    metavar="NAME=MEAN:SD",
    multiple=True,
    help="What is known beforehand of a value, in its unit, such as sigma:walls=0.02:0.01.",
)
@click.option(
    "--folds",
    metavar="anchors|N",
    help="What is held out: one anchor at a time, or N times a part of the floor; default: anchors "
    "where three or more share a value, else 5.",
)
@antenna_option
@cell_option
@least_option
@experiment(workers=False)
def calibrate(
    *,
    study: Path | None,
    options: RunOptions,
    log_file: Path | None,
    names: tuple[str, ...],
    priors: tuple[str, ...],
    folds: str | None,
    antenna: str,
    cell_m: float,
    least: int,
) -> Ended:
    """Fit values of STUDY to a log of readings: levels, materials, places, tilts.

    Paths are traced once and only the waves along them computed again. What the log cannot tell
    apart is refused by name. The headline is the error on what was held out. Writes fitted.toml
    (the study with the fitted values), calibrated.csv (each value with its 95 % interval), figures,
    study.toml and report.html; the same command again goes on where the last one stopped.
    """
    from octant.geometries.files import write_text
    from octant.reader_design.experiments.measured.calibrate import (
        CASES,
        Problem,
        Wanted,
        calibrated,
    )
    from octant.reader_design.experiments.measured.calibrate_page import (
        OUTPUTS,
        calibrate_lines,
        write_calibrated,
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

    loaded = with_log(options.seeded(load_study(study)))
    measured = measured_log(loaded, build_setting(loaded).scene, file=log_file)
    problem = Problem(
        study=loaded,
        log=measured.log,
        wanted=Wanted(
            names=tuple(one for text in names for one in text.split(",") if one.strip()),
            priors=dict(map(_prior, priors)),
            antenna=antenna,
            folds=_folds(folds),
            cell_m=cell_m,
            least=least,
        ),
        progress=options.progress,
    )
    problem.priors  # noqa: B018  refused before anything is traced
    if options.dry_run:
        fitted = ", ".join(p.name for p in problem.parameters)
        how, fold = problem.held_out
        line = (
            f"would fit {fitted} to {len(problem.observations)} local means, and again "
            f"{fold.max() + 1} times with {how} held out."
        )
        return Ended(lines=(line,))
    options.approve(field_cost(loaded, len(measured.log), tags=1, causes=("the log's readings",)))
    text = to_toml(loaded, relative_to=options.out)
    refuse_another(options.out, text, force=options.force, outputs=OUTPUTS)
    options.out.mkdir(parents=True, exist_ok=True)
    write_text(options.out / STUDY_FILE, text)
    for note in measured.notes:
        options.progress.say(note)
    found = calibrated(problem, options.out, options.progress)
    write_once(
        options.out / CASES / "finished.json",
        [text, measured.log, problem.wanted],
        lambda: write_calibrated(found, options.out),
        force=options.force,
        progress=options.progress,
    )
    return Ended(
        lines=calibrate_lines(found),
        written=files_of(options.out, OUTPUTS),
        tables=(options.out / "calibrated.csv",),
    )


def _prior(text: str) -> tuple[str, tuple[float, float]]:
    """Return the name, mean and standard deviation of a prior."""
    name, _, numbers = text.partition("=")
    mean, _, sd = numbers.partition(":")
    try:
        return name.strip(), (float(mean), float(sd))
    except ValueError as exc:
        msg = f"--prior {text!r} is none; write NAME=MEAN:SD, such as sigma:walls=0.02:0.01."
        raise ConfigError(msg) from exc


def _folds(text: str | None) -> Literal["anchors"] | int | None:
    """Return how observations are held out."""
    if text is None:
        return None
    if text == "anchors":
        return "anchors"
    if not text.isdigit() or not 2 <= int(text) <= 100:
        msg = f"--folds is {text!r}; write anchors, or a number from 2 to 100."
        raise ConfigError(msg)
    return int(text)
