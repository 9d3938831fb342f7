"""The report of ``octant reader``: the reader to scale, its patterns and its ports."""

import math
from collections.abc import Sequence
from pathlib import Path

from octant.reader_design.face.reader import SolvedReader
from octant.reader_design.face.reader_measured import MeasuredReader
from octant.reader_design.keeping.versions import versions
from octant.reader_design.showing.pages import (
    Judgement,
    Mark,
    Report,
    ReportFigure,
    ReportLink,
    ReportSection,
    Verdict,
    read_figure,
)
from octant.reader_design.showing.pattern_view import pattern_widget, peak_dbi
from octant.reader_design.showing.port_tables import port_tables
from octant.reader_design.showing.reader_svg import reader_drawing
from octant.reader_design.study_file.loading import to_toml

MATCHED_DB, USABLE_DB = 10.0, 6.0
"""Return losses from which an antenna counts as matched well, and passably [dB]."""
FIGURES = {
    "element": ("A single antenna", "Its gain alone, as a solid and over the elevation."),
    "cuts": ("Gain over azimuth", "Realised gain of all antennas at four elevations."),
    "gain_antenna_1": ("Antenna 1", "Its realised gain as a solid."),
    "s_matrix": ("S-matrix", "Reflection on the diagonal, coupling beside it."),
    "currents_antenna_1": ("Currents", "Surface current on the reader, antenna 1 driven."),
    "measured": ("Patterns", "Gains over the azimuth, measured and computed."),
    "return_loss": ("Over the band", "Return loss and impedance over the frequency."),
    "smith": ("Smith chart", "Reflection of every antenna over the frequency."),
}
"""Title and caption of each figure, by its file."""
MODELS = {"fullwave": "full wave", "rays": "by rays", "isolated": "antennas without its body"}
"""What the models are called."""
STANDS_FOR = {"pattern": ("cuts", "gain_antenna_1")}
"""Figures in whose place something stands to play with."""
BAND_AND_CURRENTS = ("return_loss", "smith", "currents_antenna_1")


def reader_report(
    solved: SolvedReader,
    folder: Path,
    lines: Sequence[str],
    *,
    beside: MeasuredReader | None = None,
) -> Report:
    """Return the report of a reader at its first frequency ([ohm], [dB], [dBi]).

    Parameters
    ----------
    solved, folder, lines : The solution, where its files lie, what is said about it.
    beside : What was measured of it; None: nothing.
    """
    study, design, response = solved.study, solved.design, solved.responses[0]
    result = solved.results[0] if solved.results else None
    carrier = f"{response.frequency_hz / 1e9:g} GHz"
    kept = STANDS_FOR["pattern"]
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    files = sorted(
        path.name for path in folder.iterdir() if path.is_file() and path.name != "report.html"
    )
    return Report(
        title=f"{study.name}: {design.label()}",
        subtitle=f"The reader by itself at {carrier}, {MODELS.get(response.model, response.model)}",
        summary=(),
        warnings=tuple(response.warnings),
        facts=(),
        verdict=_verdict(solved),
        sections=(
            ReportSection(
                heading="Patterns",
                widgets=(pattern_widget(response, fallback=_figures(folder, kept)),),
                figures=_figures(folder, ("element",)),
            ),
            *(
                ()
                if result is None
                else (
                    ReportSection(
                        heading="Ports",
                        tables=port_tables(result),
                        figures=_figures(folder, BAND_AND_CURRENTS),
                    ),
                )
            ),
            *(
                ()
                if beside is None
                else (
                    ReportSection(
                        heading="Measured beside computed",
                        paragraphs=tuple(beside.lines()),
                        tables=beside.tables(),
                        figures=_figures(folder, ("measured",)),
                    ),
                )
            ),
            ReportSection(heading="In words", points=tuple(lines)),
            ReportSection(
                heading="Reproduce it",
                paragraphs=(f"Versions: {found}.",),
                links=tuple(ReportLink(file=name, what=_what(name)) for name in files),
                folded=(
                    ("The command", "octant reader study.toml --out again"),
                    (
                        "The study with every default resolved (study.toml)",
                        to_toml(study, relative_to=folder),
                    ),
                ),
            ),
        ),
    )


def _verdict(solved: SolvedReader) -> Verdict:
    design, carrier_hz = solved.design, solved.responses[0].frequency_hz
    gain = peak_dbi(solved.responses[0])
    judged = [Judgement(name="greatest gain", value=f"{gain:.1f} dBi", said="of any antenna")]
    sentence = f"The antennas reach {gain:.1f} dBi."
    mark: Mark = "none"
    if solved.results:
        result = solved.results[0]
        loss_db = -10.0 * math.log10(max(float(result.reflected_share.max()), 1e-20))
        mark = "good" if loss_db >= MATCHED_DB else "fair" if loss_db >= USABLE_DB else "poor"
        words = {"good": "well", "fair": "passably", "poor": "badly"}[mark]
        radiated = float(result.radiated_share.mean())
        sentence = (
            f"The antennas are {words} matched to {design.loads_text()}, radiate "
            f"{100.0 * radiated:.0f} % of the power they are offered, and reach {gain:.1f} dBi."
        )
        judged = [
            Judgement(
                name="return loss",
                value=f"{loss_db:.1f} dB",
                said=f"{mark} (good from {MATCHED_DB:g} dB, fair from {USABLE_DB:g} dB)",
                mark=mark,
            ),
            Judgement(
                name="radiated",
                value=f"{100.0 * radiated:.0f} %",
                said=f"{100.0 * float(result.coupled_share.mean()):.2g} % ends in the other "
                "antennas' loads",
            ),
            *judged,
        ]
    drawn = design.drawn
    return Verdict(
        sentence=sentence,
        mark=mark,
        judgements=tuple(judged),
        drawing=reader_drawing(design, carrier_hz) if drawn else "",
        drawn="The reader to scale: from above, with its front up, and from the side.",
    )


def _figures(folder: Path, names: Sequence[str]) -> tuple[ReportFigure, ...]:
    paths = {name: folder / "figures" / f"{name}.png" for name in names}
    return tuple(read_figure(*FIGURES[n], path) for n, path in paths.items() if path.is_file())


def _what(name: str) -> str:
    if name.endswith(".ffe"):
        return f"far field of antenna {name.removesuffix('.ffe').rpartition('_')[2]} for FEKO"
    if name.endswith("p"):
        return "S-matrix as Touchstone"
    return {
        "reader.nc": "patterns, impedances and S-matrix",
        "study.toml": "the resolved study",
        "band.csv": "impedance and return loss over the band",
    }.get(name, "written by this command")
