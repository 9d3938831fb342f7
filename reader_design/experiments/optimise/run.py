"""The search for a reader end to end: evaluations on disk, tables, figures, drawing, report."""

from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from octant.geometries.errors import ConfigError, SweepStateError
from octant.geometries.files import write_text
from octant.reader_design.experiments.optimise.drawing import drawing, save_drawing
from octant.reader_design.experiments.optimise.evaluation import (
    Bench,
    Evaluation,
    bench,
    evaluate,
    rss_over_azimuth,
)
from octant.reader_design.experiments.optimise.evaluation_files import (
    read_evaluation,
    write_evaluation,
)
from octant.reader_design.experiments.optimise.figures import (
    comparison_figure,
    convergence_figure,
    pareto_figure,
    survey_figure,
)
from octant.reader_design.experiments.optimise.goals import column_names, goal_name, value_text
from octant.reader_design.experiments.optimise.page import (
    Confirmed,
    SearchContent,
    design_text,
    gain_sentence,
    optimise_report,
)
from octant.reader_design.experiments.optimise.search import (
    Search,
    Trial,
    planned_evaluations,
    search,
)
from octant.reader_design.experiments.optimise.shortlist import front, short_list
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.design import FULLWAVE, ReaderDesign
from octant.reader_design.showing.pages import render_report
from octant.reader_design.showing.style import save_figure
from octant.reader_design.showing.tables import put_table
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Reader, Study

EVALUATIONS = "evaluations"
"""Folder of the evaluations' files, in the folder of the results."""
DESIGN_COLUMNS = (
    "antenna",
    "ground_plane_shape",
    "antennas",
    "antenna_length_m",
    "antenna_radius_m",
    "plate_height_m",
    "plate_height_axis_m",
    "plate_outer_radius_m",
    "ground_plane_m",
    "gap_m",
    "monopole_plane_m",
    "load_ohm",
)
"""Parameters of a design in the tables, in the unit that each name carries [m], [ohm], [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOutcome:
    """What a search leaves.

    Attributes
    ----------
    content : SearchContent
        Trials, short list, confirmation.
    report : Path
        The report.
    """

    content: SearchContent
    report: Path

    def lines(self) -> tuple[str, ...]:
        """Return what a person wants to read at the end; numbers carry their units [mm, dB, deg].

        Returns
        -------
        tuple of str
            The short list with reasons, what the refinement gained, where the report is.
        """
        frequency = self.content.frequency_hz
        listed = [
            f"{design_text(entry.trial.evaluation.design, frequency)}. {entry.reason}"
            for entry in self.content.listed
        ]
        return (*listed, gain_sentence(self.content.search), f"Report: {self.report}")


def run_optimise(
    study: Study, out_dir: Path, *, force: bool = False, progress: Progress | None = None
) -> SearchOutcome:
    """Return the outcome of the search of a study's ``[optimise]`` and leave its files.

    Parameters
    ----------
    study : Study
        With a table ``[optimise]`` [m], [Hz].
    out_dir : Path
        Folder of the results; made when missing. Each evaluation is kept there, so that the same
        call goes on where the last one ended.
    force : bool
        Replace the results of another search in that folder.
    progress : Progress, optional
        Told what happens.

    Returns
    -------
    SearchOutcome
        Also when the goals are not met.

    Raises
    ------
    ConfigError
        When the study has no search, or the folder holds another one and ``force`` is false.
    SweepStateError
        When no design is feasible.
    KeyboardInterrupt
        Passed on; evaluations are kept.
    """
    progress = progress or Progress()
    place = bench(study)
    text = to_toml(study, relative_to=out_dir)
    _claim(out_dir, text, force=force)
    write_text(out_dir / "study.toml", text)
    planned = planned_evaluations(study, place.table)
    folder = out_dir / EVALUATIONS
    with progress.count(planned, label="designs") as tell:
        done = [0]

        def kept(design: ReaderDesign) -> Evaluation:
            result = kept_evaluation(place, design, folder, progress)
            done[0] += 1
            tell(done[0])
            return result

        found = search(study, kept)
    content = SearchContent(
        name=study.name,
        search=found,
        listed=short_list(found, place.table.shortlist),
        on_front=len(front(found)),
        confirmed=_confirmed(study, found, folder, progress),
        cells_per_wavelength=(
            study.reader.cells_per_wavelength,
            place.table.confirm_cells_per_wavelength,
        ),
        frequency_hz=study.radio.frequency_hz,
        study_toml=text,
    )
    _write_tables(content, out_dir)
    write_text(out_dir / "best.toml", _best_study(study, found.winner))
    figures = _write_figures(place, content, out_dir / "figures")
    report = out_dir / "report.html"
    write_text(report, render_report(optimise_report(content, figures)))
    return SearchOutcome(content=content, report=report)


def plan_lines(study: Study, out_dir: Path) -> tuple[str, ...]:
    """Return what a search would do, computing nothing; lengths in [mm].

    Parameters
    ----------
    study : Study
        With a table ``[optimise]``.
    out_dir : Path
        Folder of the results, where evaluations may be kept already.

    Returns
    -------
    tuple of str
        Number of designs, goals, limits.

    Raises
    ------
    ConfigError
        When the study has no search.
    """
    table = bench(study).table
    kept = len(list((out_dir / EVALUATIONS).glob("*.json")))
    goals = "; ".join(f"{goal_name(g)} {value_text(g, g.value)}" for g in table.goals)
    varied = ", ".join((*table.parameters.given(), *table.choices.given()))
    most = planned_evaluations(study, table)
    model = study.reader.response
    return (
        f"At most {most} designs, response {model!r}; {kept} evaluations are kept in {out_dir}.",
        f"Varied: {varied}.",
        f"Goals: {goals}.",
        f"Limits: footprint {1e3 * table.footprint_m:g} mm, height {1e3 * table.height_m:g} mm.",
    )


def kept_evaluation(
    place: Bench, design: ReaderDesign, folder: Path, progress: Progress
) -> Evaluation:
    """Return a design's evaluation, read from its file or computed and written.

    Parameters
    ----------
    place : Bench
        Where it is evaluated.
    design : ReaderDesign
        The design.
    folder : Path
        Folder of the evaluations.
    progress : Progress
        Told about files that cannot be read.

    Returns
    -------
    Evaluation
        The same bits from disk as computed.
    """
    key = place.key(design)
    try:
        known = read_evaluation(folder, key, design)
    except SweepStateError as exc:
        progress.say(f"{exc} It is computed again.")
        known = None
    if known is None:
        known = evaluate(place, design)
        write_evaluation(folder, known)
    return known


def _claim(out_dir: Path, text: str, *, force: bool) -> None:
    """Refuse a folder with another search's results."""
    there = out_dir / "study.toml"
    if out_dir.exists() and not out_dir.is_dir():
        msg = f"{out_dir} is a file, but the results need a folder; give another --out."
        raise ConfigError(msg)
    if there.is_file() and there.read_text("utf-8") != text and not force:
        msg = (
            f"{out_dir} holds the results of another study (or another version of this one); "
            "give another --out, or --force to replace them."
        )
        raise ConfigError(msg)


def _confirmed(
    study: Study, found: Search, folder: Path, progress: Progress
) -> tuple[Confirmed, ...]:
    """Return the scores of reader and winner with both meshes; none for the approximate models."""
    assert study.optimise is not None  # noqa: S101  `bench` let no other study pass
    if study.reader.response != FULLWAVE:
        return ()
    finer = msgspec.structs.replace(
        study.reader, cells_per_wavelength=study.optimise.confirm_cells_per_wavelength
    )
    place = bench(msgspec.structs.replace(study, reader=finer))
    trials = {"chosen design": found.winner, "the study's reader": found.reader}
    fine = {
        name: kept_evaluation(place, trial.evaluation.design, folder, progress)
        for name, trial in trials.items()
        if trial.evaluation.feasible
    }
    targets = found.targets
    finer_targets = replace(targets, reference=fine.get("the study's reader"))
    return tuple(
        Confirmed(
            name=name,
            rough=targets.scores(trials[name].evaluation),
            fine=finer_targets.scores(evaluation),
        )
        for name, evaluation in fine.items()
    )


def _write_tables(content: SearchContent, out_dir: Path) -> None:
    """Write all trials, and those on the Pareto front."""
    targets = content.search.targets
    header = (
        "number",
        "stage",
        "attainment",
        *column_names(targets.goals),
        *DESIGN_COLUMNS,
        "footprint_m",
        "height_m",
        "reason",
    )

    def row(trial: Trial) -> tuple[object, ...]:
        evaluation = trial.evaluation
        scores: tuple[object, ...] = ("",) * len(targets.goals)
        if evaluation.feasible:
            scores = targets.scores(evaluation)
        values = [getattr(evaluation.design, name) for name in DESIGN_COLUMNS]
        return (
            trial.number,
            trial.stage,
            trial.attainment if evaluation.feasible else "",
            *scores,
            *("" if value is None else value for value in values),
            evaluation.footprint_m,
            evaluation.height_m,
            evaluation.reason,
        )

    for name, trials in (("optimise", content.search.trials), ("pareto", front(content.search))):
        put_table(str(out_dir / f"{name}.csv"), header, map(row, trials), force=True)


def _best_study(study: Study, winner: Trial) -> str:
    """Return the study with the winner as its reader, without the search."""
    design = winner.evaluation.design.as_dict()
    names = [n for n in Reader.__struct_fields__ if n in design]
    reader = msgspec.structs.replace(study.reader, **{name: design[name] for name in names})
    best = msgspec.structs.replace(study, name=f"{study.name}: best", reader=reader, optimise=None)
    return to_toml(best)


def _write_figures(
    place: Bench, content: SearchContent, folder: Path
) -> dict[str, list[tuple[str, str, Path]]]:
    """Draw everything, and return the figures of the report by section."""
    found, study = content.search, place.study
    figures: dict[str, list[tuple[str, str, Path]]] = {"front": [], "search": [], "winner": []}

    def keep(section: str, name: str, title: str, caption: str) -> Path:
        path = folder / f"{name}.png"
        figures[section].append((title, caption, path))
        return path

    path = keep(
        "front",
        "pareto",
        "The goals against each other",
        "Each point is a design; dashed lines are the goals, circles mark the Pareto front.",
    )
    save_figure(pareto_figure(found, title="Designs in the plane of two goals"), path)
    path = keep(
        "search",
        "convergence",
        "Convergence",
        "How well each design reaches the goals, and how the best one so far meets each of them.",
    )
    save_figure(convergence_figure(found, title="Convergence of the search"), path)
    for name in _numeric_choices(place):
        path = keep(
            "search",
            f"survey_{name}",
            f"Scores over {_words(name)}",
            "How each score depends on this choice, all else equal.",
        )
        save_figure(survey_figure(found, name, title=f"Scores over {_words(name)}"), path)
    path = keep(
        "winner",
        "comparison",
        "RSS of all antennas over azimuth",
        "Above the chosen design, below the study's reader: received power of each antenna.",
    )
    rows = []
    azimuths = np.zeros(0)
    for name, trial in (("chosen design", found.winner), ("study's reader", found.reader)):
        if trial.evaluation.feasible:
            rss, azimuths, _, _ = rss_over_azimuth(
                study, place.built, trial.evaluation.design, place.table.distances_m
            )
            rows.append((name, rss))
    title = "Received power against the tag's azimuth"
    figure = comparison_figure(azimuths, rows, place.table.distances_m, title=title)
    save_figure(figure, path)
    path = keep(
        "winner", "drawing", "Drawing", "The chosen design to scale, all lengths in millimetres."
    )
    sheet = drawing(
        found.winner.evaluation.design, frequency_hz=content.frequency_hz, title=study.name
    )
    for file in (path, path.with_suffix(".svg"), path.with_suffix(".pdf")):
        save_drawing(sheet, file)
    return figures


def _numeric_choices(place: Bench) -> list[str]:
    """Return the choice that a figure can have as its abscissa: the only one that is a number."""
    choices = place.table.choices.given()
    numeric = [n for n, values in choices.items() if not isinstance(values[0], str)]
    alone = len(numeric) == 1 and not place.table.parameters.given()
    return numeric if alone and len(choices[numeric[0]]) > 1 else []


def _words(name: str) -> str:
    """Return a parameter's name in words, without its unit."""
    return name.removesuffix("_m").removesuffix("_ohm").replace("_", " ")
