"""The report's sections on designs: all of them side by side, and the chosen reader."""

from octant.reader_design.experiments.choice.score_tables import (
    SCORE_MEANINGS,
    design_columns,
)
from octant.reader_design.experiments.choice.thesis_claims import claim_sentence, claim_table
from octant.reader_design.experiments.study.content import StudyContent
from octant.reader_design.experiments.study.mission_sections import driven_texts, shortlist_table
from octant.reader_design.setting.design import FULLWAVE, solutions
from octant.reader_design.setting.reasons import rule_sentences
from octant.reader_design.setting.scale import scale_note
from octant.reader_design.showing.designs_view import designs_table, designs_widget
from octant.reader_design.showing.matching_lines import Behind, matching_lines
from octant.reader_design.showing.pages import (
    FigureFiles,
    ReportSection,
    ReportTable,
    embedded_figures,
)
from octant.reader_design.showing.pattern_view import pattern_widget
from octant.reader_design.showing.port_tables import port_tables

COMPARED = r"^sweep_pa"
"""Figures that the plots to play with stand for."""


def designs_section(content: StudyContent, figures: FigureFiles) -> ReportSection:
    """Return all designs side by side, why one is chosen, and what drove ([%], [deg], [dB], [cm]).

    Parameters
    ----------
    content, figures : The results, and the figures by section.
    """
    columns = design_columns(
        content.candidates, content.choice, driven_texts(content.candidates, content.driven)
    )
    ranked = [content.candidates[index].label for index in content.choice.ranking]
    widget = designs_widget(
        ranked,
        columns,
        front=[bool(content.choice.pareto[index]) for index in content.choice.ranking],
        fallback=embedded_figures(figures, "sweep", only=COMPARED),
    )
    tables = [
        designs_table(
            [f"{rank + 1}. {label}" for rank, label in enumerate(ranked)],
            columns,
            caption="All designs, best first. Click a heading to sort; “Columns” has all other "
            "scores, in the room and in free space.",
            best=0,
        )
    ]
    if len(content.candidates) > 1:
        tables.append(shortlist_table(content.candidates, content.choice, content.driven))
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
    sampling = content.setting.sampling
    text = (
        f"Every design is scored at horizontal distances of {sampling.nearest_m:g} m to "
        f"{sampling.farthest_m:g} m and at all azimuths of the tag, in free space and, with every "
        "tag and every place of the floor where the reader fits, in the room. RSS is the coherent "
        f"sum over paths without noise; usable means at least {content.setting.usable_dbm:g} dBm."
    )
    several = len(content.candidates) > 1
    rules = ("The choice follows these rules, in this order:",) if several else ()
    return ReportSection(
        heading="Designs",
        paragraphs=(*content.choice.reason[:-1], text, *rules),
        points=rule_sentences(content.choice.rules) if several else (),
        widgets=() if widget is None else (widget,),
        tables=tuple(tables),
        figures=embedded_figures(figures, "sweep", without=COMPARED if widget else ""),
        folded=(("What the scores mean", "\n\n".join(SCORE_MEANINGS)),),
    )


def reader_section(content: StudyContent, figures: FigureFiles) -> ReportSection:
    """Return the chosen reader by itself: body, patterns, ports, bearing ([cm], [dBi], [dB]).

    Parameters
    ----------
    content, figures : The results, and the figures by section.
    """
    setting, design = content.setting, content.chosen_cell.design
    carrier_hz = setting.study.radio.frequency_hz
    tables: tuple[ReportTable, ...] = ()
    matched: tuple[str, ...] = ()
    if design.has_ports:
        ports = solutions(design, (carrier_hz,))[0].ports
        tables = port_tables(ports)
        matched = tuple(
            matching_lines(
                ports.admittance_s[None],
                carrier_hz,
                at_hz=carrier_hz,
                load_ohm=design.load_ohm,
                behind=Behind.of(design, (ports,)),
            )
        )
    outside = scale_note(design, carrier_hz)
    return ReportSection(
        heading="The reader",
        warnings=(f"{outside[:1].upper()}{outside[1:]}.",) if outside else (),
        points=(*_design_points(content), *matched),
        widgets=(
            pattern_widget(
                setting.responses[0],
                fallback=embedded_figures(figures, "reader", only="^rss_azimuth"),
            ),
        ),
        tables=tables,
        figures=embedded_figures(figures, "reader", without="^rss_azimuth"),
    )


def thesis_section(content: StudyContent, figures: FigureFiles) -> ReportSection | None:
    """Return the claims of the thesis against the results; None where the study does not ask.

    Parameters
    ----------
    content, figures : The results, and the figures by section.
    """
    claims = content.claims
    if not claims:
        return None
    return ReportSection(
        heading="Claims of the thesis",
        paragraphs=(claim_sentence(claims),),
        tables=(claim_table(claims),),
        figures=embedded_figures(figures, "thesis"),
    )


def _design_points(content: StudyContent) -> tuple[str, ...]:
    design = content.chosen_cell.design
    if design.response == "metal":
        plane = ", over an infinite plane" if design.ground == "infinite" else ""
        return (f"{design.antennas} ports on metal: {design.label()}{plane}",)
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
            f"{1000 * design.feed_gap_m:.3g} mm, loads of {design.loads_text()}"
        )
    points += list(design.notes())
    return tuple(points)
