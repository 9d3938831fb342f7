"""What a study's report says: from results to sections, tables and sentences."""

import math
from dataclasses import dataclass
from pathlib import Path

from octant.em.reader.comparison import ResponseDifference
from octant.reader_design.experiments.choice.score_tables import (
    SCORE_MEANINGS,
    merit_table,
    score_table,
)
from octant.reader_design.experiments.choice.thesis_claims import (
    Claim,
    claim_sentence,
    claim_table,
    thesis_claims,
)
from octant.reader_design.experiments.choice.thesis_setup import ThesisSetup
from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.approximations import approximation_table
from octant.reader_design.experiments.study.mission_sections import (
    mission_section,
    mission_sentence,
    shortlist_table,
)
from octant.reader_design.experiments.study.rfid_section import rfid_section
from octant.reader_design.experiments.study.shortlist import DrivenDesign
from octant.reader_design.experiments.study.verdict import Verdict, study_verdict
from octant.reader_design.keeping.versions import versions
from octant.reader_design.setting.design import FULLWAVE
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import Candidate, Choice
from octant.reader_design.setting.reasons import rule_sentences
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.pages import (
    Report,
    ReportFigure,
    ReportSection,
    ReportTable,
    embedded_figures,
)
from octant.reader_design.study_file.schema import Solver


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyContent:
    """Everything that a study's report is made of.

    Attributes
    ----------
    setting : Study, room and sampling.
    cells, candidates, choice : All cells, failed ones too; the scored ones; their ranking.
    driven : The designs that drove the missions, the chosen one first.
    notes : What the user should know: tags that were moved, validity of models.
    approximations : How far the approximate responses are off for the chosen reader ([dB],).
    as_built : What tolerances do to the chosen reader ([mm], [deg]); None: no tolerances.
    thesis : What the thesis' designs among the cells receive in its set-up [W]; None: not asked.
    study_toml, quick, seconds : The resolved study; whether a quick look; time since start [s].
    """

    setting: Setting
    cells: tuple[Cell, ...]
    candidates: tuple[Candidate, ...]
    choice: Choice
    driven: tuple[DrivenDesign, ...]
    notes: tuple[str, ...]
    study_toml: str
    quick: bool
    seconds: float
    approximations: tuple[ResponseDifference, ...] = ()
    as_built: ReportSection | None = None
    thesis: ThesisSetup | None = None

    @property
    def chosen(self) -> Candidate:
        """The chosen design with its scores ([rad], [dB], [W],)."""
        return self.candidates[self.choice.chosen]

    @property
    def missions(self) -> tuple[RoomMission, ...]:
        """Missions of the chosen design, one for each room ([s], [m], [rad], [W])."""
        return self.driven[0].missions

    @property
    def claims(self) -> tuple[Claim, ...]:
        """Claims of the thesis that the sweep tests, numbers with their units."""
        if self.thesis is None:
            return ()
        return thesis_claims(self.cells, self.candidates, self.choice, self.thesis)

    @property
    def verdict(self) -> Verdict:
        """What the study came to: one sentence, judged numbers, and what to try ([deg], [%])."""
        mission = self.setting.study.mission
        return study_verdict(
            self.chosen,
            self.chosen_cell.design.antennas,
            self.missions,
            0 if mission is None else len(mission.tags),
        )

    @property
    def chosen_cell(self) -> Cell:
        """The chosen design's cell, RSS in [W]."""
        return next(cell for cell in self.cells if cell.key == self.chosen.key)


def study_report(content: StudyContent, figures: dict[str, list[tuple[str, str, Path]]]) -> Report:
    """Return the report of a study; numbers carry their units [m, dB, deg, s].

    Parameters
    ----------
    content, figures : The results; by section: title, caption and file of each figure.
    """
    study, chosen = content.setting.study, content.chosen
    failed = [c for c in content.cells if c.reason]
    claims = content.claims
    verdict = content.verdict
    advice = () if verdict.advice is None else (verdict.advice.text(),)
    summary = (
        verdict.sentence,
        *advice,
        *content.choice.reason[:-1],
        *((claim_sentence(claims),) if claims else ()),
        *(() if content.as_built is None else content.as_built.paragraphs),
        *(mission_sentence(m) for m in content.missions),
    )
    count = len(content.cells)
    subtitle = (
        f"Octant study “{study.name}”: {count} design{'' if count == 1 else 's'} at "
        f"{study.radio.frequency_hz / 1e9:g} GHz"
        + (", quick look with coarse sampling" if content.quick else "")
    )
    warnings = [content.choice.reason[-1]]
    if failed:
        warnings.append(f"{len(failed)} of {count} designs have no scores; see “The sweep”.")
    return Report(
        title=f"{study.name}: {chosen.label}",
        subtitle=subtitle,
        summary=summary,
        warnings=tuple(warnings),
        facts=_facts(content),
        sections=tuple(
            section
            for section in (
                _sweep_section(content, embedded_figures(figures, "sweep")),
                ReportSection(
                    heading="The chosen reader",
                    points=_design_points(content),
                    tables=(approximation_table(content.approximations),)
                    if content.approximations
                    else (),
                    figures=embedded_figures(figures, "reader"),
                ),
                content.as_built,
                ReportSection(
                    heading="The room",
                    points=_room_points(content),
                    figures=embedded_figures(figures, "room"),
                ),
                rfid_section(content.setting, embedded_figures(figures, "rfid")),
                mission_section(
                    content.missions, study.mission, embedded_figures(figures, "mission")
                ),
                _scores_section(content),
                _validity_section(content),
                _study_section(content),
            )
            if section is not None
        ),
    )


def _facts(content: StudyContent) -> tuple[tuple[str, str], ...]:
    chosen = content.chosen
    facts = [("chosen design", chosen.label)]
    places = [("free space", chosen.free), ("in the room", chosen.room)]
    for name, scores in places:
        if scores is not None:
            facts.append((f"right antenna, {name}", f"{scores.right_share:.0%}"))
            rms = math.degrees(scores.vector_rms_rad)
            facts.append((f"vector-sum bearing, {name}", f"{rms:.1f}° rms"))
    for mission in content.missions:
        if mission.data is None:
            facts.append((f"mission, {mission.name}", "not driven"))
        else:
            success = mission.data["success"].values
            facts.append(
                (f"mission, {mission.name}", f"{int(success.sum())} of {success.size} runs")
            )
    return tuple(facts)


def _sweep_section(content: StudyContent, figures: tuple[ReportFigure, ...]) -> ReportSection:
    tables = [
        merit_table(content.candidates, content.choice),
        shortlist_table(content.candidates, content.choice, content.driven),
    ]
    failed = tuple((c.label, c.reason) for c in content.cells if c.reason)
    if failed:
        tables.append(
            ReportTable(
                caption="Designs without scores.",
                header=("design", "reason"),
                rows=failed,
                words=True,
            )
        )
    if claims := content.claims:
        tables.append(claim_table(claims))
    sampling = content.setting.sampling
    text = (
        f"Every design is scored at horizontal distances of {sampling.nearest_m:g} to "
        f"{sampling.farthest_m:g} m and at all azimuths of the tag, in free space and, with every "
        "tag and every place of the floor where the reader fits, in the room. RSS is the coherent "
        f"sum over paths without noise; usable means at least {content.setting.usable_dbm:g} dBm."
    )
    return ReportSection(
        heading="The sweep",
        paragraphs=(text, "The choice follows these rules, in this order:"),
        points=rule_sentences(content.choice.rules),
        tables=tuple(tables),
        figures=figures,
    )


def _scores_section(content: StudyContent) -> ReportSection:
    tables = [
        score_table(
            content.candidates,
            content.choice,
            place,
            caption=f"Scores {where}, best design first, more columns to the right; * marks the "
            "Pareto front of share, error, margin and level.",
        )
        for place, where in (("free", "in free space"), ("room", "in the room"))
    ]
    return ReportSection(
        heading="All scores",
        points=SCORE_MEANINGS,
        tables=tuple(t for t in tables if t is not None),
    )


def _design_points(content: StudyContent) -> tuple[str, ...]:
    design = content.chosen_cell.design
    if design.response == "files":
        turn = ", turned to each antenna's azimuth" if design.pattern_turn == "each" else ""
        return (
            f"{design.antennas} antennas, given by {design.label()} from the axis{turn}",
            f"{100 * design.height_m:.4g} cm above the floor",
        )
    element = design.element(content.setting.study.radio.frequency_hz)
    points = [
        (
            f"{design.antennas} vertical {design.antenna}s, each {100 * element.length_m:.3g} cm "
            f"long, at r_a = {100 * design.antenna_radius_m:.4g} cm from the axis"
        ),
        f"plates h_p = {100 * design.plate_height_m:.4g} cm high between them"
        if design.plate_height_m > 0.0
        else "no plates between them",
        (
            f"{design.ground_plane_shape} ground plane of {100 * design.ground_plane_m:.4g} cm, "
            f"{100 * design.height_m:.4g} cm above the floor"
        ),
    ]
    if design.antenna == "dipole":
        points.append(f"lower end of the dipoles {1000 * design.gap_m:.3g} mm above the plane")
    elif own_m := design.body().fitted_monopole_plane_m:
        points.append(
            f"each monopole on its own plane of {100 * own_m:.3g} cm, {1000 * design.gap_m:.3g} mm "
            "above the ground plane"
        )
    if content.setting.study.reader.response == FULLWAVE:
        points.append(
            f"wire of {1000 * design.wire_radius_m:.3g} mm radius, feeds of "
            f"{1000 * design.feed_gap_m:.3g} mm, loads of {design.load_ohm:g} ohm"
        )
    points += list(design.notes())
    return tuple(points)


def _room_points(content: StudyContent) -> tuple[str, ...]:
    scene, study = content.setting.scene, content.setting.study
    if not scene.bodies:
        return ("Free space: no walls and no objects.",)
    size = scene.bounds_m[1] - scene.bounds_m[0]
    return (
        (
            f"{len(scene.bodies)} bodies ({', '.join(b.name for b in scene.bodies[:12])}"
            f"{', ...' if len(scene.bodies) > 12 else ''}) within {size[0]:.4g} x {size[1]:.4g} x "
            f"{size[2]:.4g} m, of {', '.join(scene.material_names)}"
        ),
        _paths_point(study.solver),
    )


def _paths_point(solver: Solver) -> str:
    """Return in words which paths the room's model includes."""
    over = "no diffraction"
    if solver.diffraction:
        over = f"up to {solver.max_diffractions} of them over edges (uniform theory of diffraction)"
    through = "through sheets with a thickness" if solver.transmission else "none through walls"
    how = f", as far as {solver.rays:g} rays find them" if solver.search == "rays" else ""
    return f"paths of up to {solver.max_reflections} bends, {over}, {through}{how}"


def _validity_section(content: StudyContent) -> ReportSection:
    notes = dict.fromkeys(
        (
            content.choice.reason[-1],
            *(n for c in content.cells for n in c.notes),
            *(n for m in content.missions for n in m.notes),
            *content.notes,
        )
    )
    return ReportSection(
        heading="Warnings and validity",
        paragraphs=("What the models leave out, and what was changed to make them apply:",),
        points=tuple(notes),
    )


def _study_section(content: StudyContent) -> ReportSection:
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    return ReportSection(
        heading="The study",
        paragraphs=(
            f"Seed {content.setting.study.seed}; versions: {found}.",
            (
                f"Computing time of the cells {sum(c.seconds for c in content.cells):.0f} s, of "
                f"this run of the study {content.seconds:.0f} s."
            ),
        ),
        folded=(("The study with every default resolved (study.toml)", content.study_toml),),
    )
