"""The report of a search for a reader: what was sought, what was found, and how to build it."""

from dataclasses import dataclass
from pathlib import Path

from octant.reader_design.experiments.optimise.goals import Targets, goal_name, value_text
from octant.reader_design.experiments.optimise.search import Search, Trial
from octant.reader_design.experiments.optimise.shortlist import Listed, goal_words
from octant.reader_design.showing.pages import Report, ReportSection, ReportTable, embedded_figures
from octant.reader_design.study_file.reader import Reader


@dataclass(frozen=True, slots=True, kw_only=True)
class Confirmed:
    """A design solved with a finer mesh.

    Attributes
    ----------
    name : Which design.
    rough, fine : Score of each goal with the search's mesh, and the finer one [score's unit].
    """

    name: str
    rough: tuple[float, ...]
    fine: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchContent:
    """Everything that a search's report is made of.

    Attributes
    ----------
    name, study_toml : Name of the study, and the study resolved.
    search, listed : The trials and the short list.
    on_front : Designs on the Pareto front.
    confirmed : Reader and winner with both meshes.
    cells_per_wavelength : Both meshes [-].
    frequency_hz : Frequency [Hz].
    """

    name: str
    search: Search
    listed: tuple[Listed, ...]
    on_front: int
    confirmed: tuple[Confirmed, ...]
    cells_per_wavelength: tuple[float, float]
    frequency_hz: float
    study_toml: str

    @property
    def winner(self) -> Trial:
        """The chosen design."""
        return self.search.winner


def design_text(design: Reader, frequency_hz: float) -> str:
    """Return the dimensions of a design in one line [mm], [ohm].

    Parameters
    ----------
    design : The design.
    frequency_hz : Frequency at which antennas without a length are cut [Hz].
    """
    body = design.body()
    length = 1e3 * (design.element(frequency_hz).length_m or 0.0)
    plates = "no plates"
    if body.has_plates:
        between = "".join(
            f", {1e3 * h:.1f} mm at {1e3 * r:.1f} mm" for r, h in body.plate_outline_m[1:-1]
        )
        plates = (
            f"plates {1e3 * body.plate_height_axis_m:.1f} mm high at the axis{between} and "
            f"{1e3 * body.plate_height_m:.1f} mm at the rim, "
            f"{1e3 * body.plate_outer_radius_m:.1f} mm long"
        )
    own = ""
    if design.antenna == "monopole" and body.fitted_monopole_plane_m:
        own = f", each on its own square plane of {1e3 * body.fitted_monopole_plane_m:.1f} mm"
    return (
        f"{design.antennas} {design.antenna}s of {length:.1f} mm{own} at r_a = "
        f"{1e3 * design.antenna_radius_m:.1f} mm, gap {1e3 * design.gap_m:.1f} mm; {plates}; "
        f"{design.ground_plane_shape} plane of {1e3 * design.ground_plane_m:.1f} mm; load "
        f"{design.load_ohm:g} ohm"
    )


def gain_sentence(search: Search) -> str:
    """Return what the refinement gained over the best design of the survey, in numbers.

    Parameters
    ----------
    search : A finished search.
    """
    start, end = search.best_of("survey"), search.best_of("refinement")
    if start is None or end is None:
        return "The best design of the survey was not refined."
    targets = search.targets
    pairs = zip(
        targets.goals,
        targets.scores(start.evaluation),
        targets.scores(end.evaluation),
        strict=True,
    )
    moved = ", ".join(
        f"{goal_words(goal)} from {value_text(goal, a)} to {value_text(goal, b)}"
        for goal, a, b in pairs
    )
    count = sum(t.stage == "refinement" for t in search.trials)
    verdict = "raised" if end.attainment > start.attainment else "did not raise"
    return (
        f"The refinement ({count} designs) {verdict} the attainment of the best design from "
        f"{start.attainment:+.2f} to {end.attainment:+.2f}: {moved}."
    )


def optimise_report(
    content: SearchContent, figures: dict[str, list[tuple[str, str, Path]]]
) -> Report:
    """Return the report of a search.

    Parameters
    ----------
    content : The search.
    figures : By section: title, caption and file of each figure.
    """
    search = content.search
    infeasible = [t for t in search.trials if not t.evaluation.feasible]
    sections = [
        ReportSection(
            heading="The chosen design",
            points=(design_text(content.winner.evaluation.design, content.frequency_hz),),
            tables=(_confirmed_table(content),),
            figures=embedded_figures(figures, "winner"),
        ),
        ReportSection(
            heading="The short list",
            paragraphs=(
                (
                    f"{content.on_front} of {len(search.trials)} designs lie on the Pareto front: "
                    "no other design is at least as good in every goal and better in one. Ranked "
                    "by the goal that each meets worst; near twins are left out."
                ),
            ),
            points=tuple(entry.reason for entry in content.listed),
            tables=(_short_table(content),),
            figures=embedded_figures(figures, "front"),
        ),
        ReportSection(
            heading="The search",
            paragraphs=(gain_sentence(search), _stages_sentence(search)),
            tables=(_infeasible_table(infeasible),) if infeasible else (),
            figures=embedded_figures(figures, "search"),
        ),
        ReportSection(
            heading="The study",
            folded=(("The study with every default resolved (study.toml)", content.study_toml),),
        ),
    ]
    return Report(
        title=f"{content.name}: search for a reader",
        subtitle=f"{len(search.trials)} designs at {content.frequency_hz / 1e9:g} GHz",
        summary=(content.listed[0].reason, gain_sentence(search)),
        warnings=tuple(content.winner.evaluation.notes),
        facts=_facts(search.targets, content.winner),
        sections=tuple(sections),
    )


def _facts(targets: Targets, winner: Trial) -> tuple[tuple[str, str], ...]:
    values = zip(targets.goals, targets.scores(winner.evaluation), strict=True)
    return tuple((goal_words(goal), value_text(goal, value)) for goal, value in values)


def _stages_sentence(search: Search) -> str:
    counts = {s: sum(t.stage == s for t in search.trials) for s in ("survey", "refinement")}
    met = sum(
        t.evaluation.feasible and all(search.targets.met(t.evaluation)) for t in search.trials
    )
    return (
        f"Tried: the study's reader, {counts['survey']} designs of the survey and "
        f"{counts['refinement']} of the refinement; {met} of them meet every goal."
    )


def _confirmed_table(content: SearchContent) -> ReportTable:
    goals = content.search.targets.goals
    rough, fine = content.cells_per_wavelength
    rows = []
    for entry in content.confirmed:
        for cells, scores in ((rough, entry.rough), (fine, entry.fine)):
            texts = [value_text(goal, v) for goal, v in zip(goals, scores, strict=True)]
            rows.append((entry.name, f"{cells:g}", *texts))
    return ReportTable(
        caption="The chosen design and the study's reader, with the search's mesh and a finer one; "
        "gains refer to the reader with the same mesh.",
        header=("design", "cells per wavelength", *(goal_words(g) for g in goals)),
        rows=tuple(rows),
    )


def _short_table(content: SearchContent) -> ReportTable:
    targets = content.search.targets
    rows = []
    for place, entry in enumerate(content.listed, 1):
        trial = entry.trial
        values = zip(targets.goals, targets.scores(trial.evaluation), strict=True)
        rows.append(
            (
                f"{place}",
                f"{trial.attainment:+.2f}",
                *(value_text(goal, value) for goal, value in values),
                design_text(trial.evaluation.design, content.frequency_hz),
            )
        )
    return ReportTable(
        caption="The best designs of the Pareto front.",
        header=("place", "attainment", *(goal_name(g) for g in targets.goals), "design"),
        rows=tuple(rows),
        best=0,
    )


def _infeasible_table(trials: list[Trial]) -> ReportTable:
    reasons = dict.fromkeys(t.evaluation.reason for t in trials)
    rows = tuple(
        (str(sum(t.evaluation.reason == reason for t in trials)), reason) for reason in reasons
    )
    return ReportTable(
        caption="Designs that cannot be built or are too large.",
        header=("designs", "reason"),
        rows=rows,
        words=True,
    )
