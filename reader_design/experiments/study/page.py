"""What a study's report says: the first screen, and the order of the sections."""

from typing import TYPE_CHECKING

from octant.reader_design.experiments.study.content import StudyContent
from octant.reader_design.experiments.study.design_sections import (
    designs_section,
    reader_section,
    thesis_section,
)
from octant.reader_design.experiments.study.mission_sections import mission_section
from octant.reader_design.experiments.study.rfid_section import rfid_section
from octant.reader_design.experiments.study.room_section import room_section
from octant.reader_design.experiments.study.sure_sections import (
    reproduce_section,
    sure_section,
)
from octant.reader_design.showing.pages import (
    FigureFiles,
    Judgement,
    Mark,
    PasteAdvice,
    Report,
    embedded_figures,
)
from octant.reader_design.showing.pages import Verdict as FirstScreen
from octant.reader_design.showing.reader_svg import reader_drawing

if TYPE_CHECKING:
    import xarray as xr


def study_report(content: StudyContent, room_map: "xr.Dataset", figures: FigureFiles) -> Report:
    """Return the report of a study; numbers carry their units [m, dB, deg, s].

    Parameters
    ----------
    content, room_map : The results; the maps of the chosen reader.
    figures : By section: title, caption and file of each figure.
    """
    study, chosen = content.setting.study, content.chosen
    count = len(content.cells)
    subtitle = (
        f"Octant study “{study.name}”: {count} design{'' if count == 1 else 's'} at "
        f"{study.radio.frequency_hz / 1e9:g} GHz"
        + (", quick look: coarse sampling, few runs and pictures" if content.quick else "")
    )
    failed = sum(bool(c.reason) for c in content.cells)
    warnings = (f"{failed} of {count} designs have no scores; see “Designs”.",) if failed else ()
    sections = (
        room_section(content, room_map, figures),
        rfid_section(content.setting, embedded_figures(figures, "rfid")),
        mission_section(content.missions, study.mission, figures),
        designs_section(content, figures),
        reader_section(content, figures),
        sure_section(content),
        content.as_built,
        reproduce_section(content),
        thesis_section(content, figures),
    )
    return Report(
        title=f"{study.name}: {chosen.label}",
        subtitle=subtitle,
        summary=(),
        warnings=warnings,
        facts=(),
        sections=tuple(section for section in sections if section is not None),
        verdict=_first_screen(content),
    )


def _first_screen(content: StudyContent) -> FirstScreen:
    verdict, study = content.verdict, content.setting.study
    design = content.chosen_cell.design
    grades: list[Mark] = ["poor", "fair", "good"]
    marks = [number.grade for number in verdict.numbers]
    drawn = design.drawn
    advice = verdict.advice
    further = content.choice.reason[:1] if len(content.cells) > 1 else (_one_design(content),)
    return FirstScreen(
        sentence=verdict.sentence,
        further=(*further, *(() if content.as_built is None else content.as_built.paragraphs[:1])),
        mark=grades[min(grades.index(mark) for mark in marks)] if marks else "none",
        judgements=tuple(
            Judgement(
                name=number.name,
                value=number.text,
                said=f"{number.grade} ({number.rule})",
                mark=number.grade,
            )
            for number in verdict.numbers
        ),
        advice=()
        if advice is None
        else (PasteAdvice(why=advice.sentence, lines="\n".join(advice.lines)),),
        drawing=reader_drawing(design, study.radio.frequency_hz) if drawn else "",
        drawn="The reader to scale: from above, with its front up, and from the side.",
    )


def _one_design(content: StudyContent) -> str:
    return f"The reader: {content.chosen.label}."
