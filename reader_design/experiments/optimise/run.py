"""The search for a reader end to end: evaluations on disk, tables, figures, drawing, report."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from octant.geometries.files import write_text
from octant.reader_design.experiments.optimise.evaluation import (
    Bench,
    Evaluation,
    SlopeCase,
    Slopes,
    bench,
    kept_evaluations,
    kept_slopes,
    rss_over_azimuth,
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
    table_of,
)
from octant.reader_design.experiments.optimise.shortlist import front, short_list
from octant.reader_design.keeping.keeper import RecordCodec
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import STUDY_FILE, refuse_another, write_once
from octant.reader_design.keeping.workers import Crew, open_crew
from octant.reader_design.setting.design import FULLWAVE
from octant.reader_design.showing.pages import render_report
from octant.reader_design.showing.style import save_figure
from octant.reader_design.showing.tables import put_table
from octant.reader_design.showing.workshop import drawing, save_drawing
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.optimise import Optimise
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study

EVALUATIONS = "evaluations"
"""Folder of the evaluations' files, in the folder of the results."""
OUTPUTS = ("optimise.csv", "pareto.csv", "best.toml", "report.html", "figures/*.*")
"""What a search leaves for people, besides study.toml."""
DESIGN_COLUMNS = (
    "antenna",
    "ground_plane_shape",
    "antennas",
    "antenna_length_m",
    "antenna_radius_m",
    "plate_height_m",
    "plate_height_axis_m",
    "plate_profile_m",
    "plate_outer_radius_m",
    "ground_plane_m",
    "gap_m",
    "monopole_plane_m",
    "load_ohm",
)
"""Parameters of a design in the tables, in the unit that each name carries [m], [ohm], [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOutcome:
    """What a search leaves: trials, short list and confirmation, and its report.

    Attributes
    ----------
    content, report : What was found, and the report's file.
    """

    content: SearchContent
    report: Path

    def lines(self) -> tuple[str, ...]:
        """Return what a person wants to read at the end, numbers with units [mm, dB, deg]."""
        frequency = self.content.frequency_hz
        listed = [
            f"{design_text(entry.trial.evaluation.design, frequency)}. {entry.reason}"
            for entry in self.content.listed
        ]
        return (*listed, gain_sentence(self.content.search), f"Report: {self.report}")


def run_optimise(
    study: Study,
    out_dir: Path,
    *,
    force: bool = False,
    workers: int | None = 1,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> SearchOutcome:
    """Return the outcome of the search of a study's ``[optimise]`` and leave its files.

    Refuses a study whose search finds no feasible design. Evaluations are kept, so that the same
    call goes on where an interrupted one ended.

    Parameters
    ----------
    study : With a table ``[optimise]``.
    out_dir : Folder of the results; made when missing.
    force : Replace the results of another search in that folder; else refused.
    workers : Processes that compute the survey; None: one for each core. The refinement needs each
        score before the next design.
    cluster : Address of a dask scheduler, or ``local:N``, in place of ``workers``.
    progress : Shows what happens.
    """
    progress = progress or Progress()
    place, table = bench(study), table_of(study)
    text = to_toml(study, relative_to=out_dir)
    refuse_another(out_dir, text, force=force, outputs=OUTPUTS)
    folder = out_dir / EVALUATIONS
    with open_crew(workers=workers, cluster=cluster) as crew:
        write_text(out_dir / STUDY_FILE, text)
        found = _searched(place, table, folder, crew=crew, progress=progress)
    content = SearchContent(
        name=study.name,
        search=found,
        listed=short_list(found, table.shortlist),
        on_front=len(front(found)),
        confirmed=_confirmed(study, table, found, folder, progress),
        cells_per_wavelength=(
            study.reader.cells_per_wavelength,
            table.confirm_cells_per_wavelength,
        ),
        frequency_hz=study.radio.frequency_hz,
        study_toml=text,
    )
    report = out_dir / "report.html"

    def write() -> list[Path]:
        _write_tables(content, out_dir)
        write_text(out_dir / "best.toml", _best_study(study, found.winner))
        figures = _write_figures(place, table, content, out_dir / "figures")
        write_text(report, render_report(optimise_report(content, figures)))
        return [path for one in OUTPUTS for path in sorted(out_dir.glob(one))]

    write_once(
        folder / "finished.json",
        [text, [trial.evaluation for trial in found.trials]],
        write,
        force=force,
        progress=progress,
    )
    return SearchOutcome(content=content, report=report)


def _searched(
    place: Bench, table: Optimise, folder: Path, *, crew: Crew | None, progress: Progress
) -> Search:
    """Return the search, each evaluation read from its file or computed and kept."""
    found: dict[Reader, Evaluation] = {}
    done: set[Reader] = set()
    messages = replace(progress, bars=False)

    def survey(designs: Sequence[Reader]) -> None:
        kept = kept_evaluations(
            place, designs, folder, crew=crew, progress=progress, label="survey"
        )
        found.update(zip(designs, kept, strict=True))

    with progress.count(planned_evaluations(place.study, table), label="designs") as tell:

        def evaluated(design: Reader) -> Evaluation:
            if design not in found:
                found[design] = kept_evaluations(place, (design,), folder, progress=messages)[0]
            done.add(design)
            tell(len(done))
            return found[design]

        def slopes(design: Reader, names: tuple[str, ...]) -> Slopes:
            case = SlopeCase(design=design, names=names)
            return kept_slopes(place, case, folder, progress=messages)

        return search(place.study, table, evaluated, survey, slopes=slopes)


def plan_lines(study: Study, out_dir: Path) -> tuple[str, ...]:
    """Return what a search would do, computing nothing; lengths in [mm].

    Parameters
    ----------
    study : With a table ``[optimise]``.
    out_dir : Folder of the results, where evaluations may be kept already.
    """
    bench(study)
    table = table_of(study)
    kept = len(list((out_dir / EVALUATIONS).glob(f"[!.]*{RecordCodec.suffix}")))
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


def _confirmed(
    study: Study, table: Optimise, found: Search, folder: Path, progress: Progress
) -> tuple[Confirmed, ...]:
    """Return the scores of reader and winner with both meshes; none for the approximate models."""
    if study.reader.response != FULLWAVE:
        return ()

    def finer(reader: Reader) -> Reader:
        cells = table.confirm_cells_per_wavelength
        return msgspec.structs.replace(reader, cells_per_wavelength=cells)

    place = bench(msgspec.structs.replace(study, reader=finer(study.reader)))
    trials = {"chosen design": found.winner, "the study's reader": found.reader}
    names = [name for name, trial in trials.items() if trial.evaluation.feasible]
    designs = [finer(trials[name].evaluation.design) for name in names]
    kept = kept_evaluations(place, designs, folder, progress=progress, label="finer meshes")
    fine = dict(zip(names, kept, strict=True))
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
            *(_cell(value) for value in values),
            evaluation.footprint_m,
            evaluation.height_m,
            evaluation.reason,
        )

    for name, trials in (("optimise", content.search.trials), ("pareto", front(content.search))):
        put_table(str(out_dir / f"{name}.csv"), header, map(row, trials), force=True)


def _cell(value: object) -> object:
    """Return a value as a table holds it: nothing for None, several beside each other."""
    if isinstance(value, tuple):
        return ";".join(f"{one:g}" for one in value)
    return "" if value is None else value


def _best_study(study: Study, winner: Trial) -> str:
    """Return the study with the winner as its reader, without the search."""
    name, reader = f"{study.name}: best", winner.evaluation.design
    best = msgspec.structs.replace(study, name=name, reader=reader, optimise=None)
    return to_toml(best)


def _write_figures(
    place: Bench, table: Optimise, content: SearchContent, folder: Path
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
    for name in _numeric_choices(table):
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
                place.setting, trial.evaluation.design, place.distances_m
            )
            rows.append((name, rss))
    title = "Received power against the tag's azimuth"
    figure = comparison_figure(azimuths, rows, place.distances_m, title=title)
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


def _numeric_choices(table: Optimise) -> list[str]:
    """Return the choice that a figure can have as its abscissa: the only one that is a number."""
    choices = table.choices.given()
    numeric = [n for n, values in choices.items() if not isinstance(values[0], str)]
    alone = len(numeric) == 1 and not table.parameters.given()
    return numeric if alone and len(choices[numeric[0]]) > 1 else []


def _words(name: str) -> str:
    """Return a parameter's name in words, without its unit."""
    return name.removesuffix("_m").removesuffix("_ohm").replace("_", " ")
