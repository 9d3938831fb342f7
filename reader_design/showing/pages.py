"""The report as one HTML file that opens from disk: no network, everything inside.

The content is plain data; `render_report` puts it into the templates of ``page`` and escapes every
text. Without scripts, and on paper, tables and figures show what the scripts would.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from octant.reader_design.showing.page.render import page

Mark = Literal["good", "fair", "poor", "none"]
"""How a number is judged."""
PAPER_COLUMNS = 9
"""Columns that a sheet of paper holds; a wider table is printed in parts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportTable:
    """A table of the report; all cells are text that already carries its unit or stands under it.

    Attributes
    ----------
    caption : One sentence above the table.
    header : Column headings, with units in brackets.
    rows : Cells.
    best : Row that is highlighted.
    words : True: cells hold words, set flush left.
    first : Columns that are shown at first, where a script can show the others; 0: all.
    """

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    best: int | None = None
    words: bool = False
    first: int = 0

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]:
        """Columns of each part that paper holds; the first column stands in all."""
        count = len(self.header)
        if count <= PAPER_COLUMNS:
            return (tuple(range(count)),)
        parts = -(-(count - 1) // (PAPER_COLUMNS - 1))
        each = -(-(count - 1) // parts)
        return tuple(
            (0, *range(start, min(start + each, count))) for start in range(1, count, each)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportFigure:
    """A figure of the report.

    Attributes
    ----------
    title : Name.
    caption : One sentence that says what to see in it.
    png : The image.
    alt : What it shows, for those who do not see it; empty: title and caption.
    """

    title: str
    caption: str
    png: bytes
    alt: str = ""

    @property
    def described(self) -> str:
        """What it shows, in words."""
        return self.alt or f"{self.title}. {self.caption}"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportWidget:
    """A part of the report to play with; where no script runs, its figures stand in its place.

    Attributes
    ----------
    kind : What shows it: ``map``, ``drive``, ``designs``, ``room`` or ``pattern``.
    title, caption : Name; what it shows and how to use it.
    alt : What it shows, for those who do not see it.
    data : What the script needs.
    fallback : What stands in its place without scripts and on paper.
    """

    kind: Literal["map", "drive", "designs", "room", "pattern"]
    title: str
    caption: str
    alt: str
    data: Mapping[str, object]
    fallback: tuple[ReportFigure, ...] = ()

    @property
    def library(self) -> str:
        """The library that it needs; empty: none."""
        return {"room": "space", "pattern": "space", "designs": "charts"}.get(self.kind, "")


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """A number of the first screen with what it means.

    Attributes
    ----------
    name, value : What it is; the number with its unit.
    said, mark : A plain judgement in a few words; whether that is good.
    """

    name: str
    value: str
    said: str
    mark: Mark = "none"


@dataclass(frozen=True, slots=True, kw_only=True)
class PasteAdvice:
    """What to try next.

    Attributes
    ----------
    why : One sentence.
    lines : Lines for the study file.
    """

    why: str
    lines: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """The first screen of a report.

    Attributes
    ----------
    sentence, further : What came out, in one plain sentence; what else belongs to it.
    mark : Whether that is good.
    judgements, advice : The three numbers that matter most; what to try where it failed.
    drawing, drawn : The reader as an SVG picture, made of numbers alone; what it shows.
    """

    sentence: str
    further: tuple[str, ...] = ()
    mark: Mark = "none"
    judgements: tuple[Judgement, ...] = ()
    advice: tuple[PasteAdvice, ...] = ()
    drawing: str = ""
    drawn: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportLink:
    """A file that lies beside the report.

    Attributes
    ----------
    file, what : Its name, and what it holds.
    """

    file: str
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportSection:
    """A section of the report; its parts appear in the order of the fields.

    Attributes
    ----------
    heading, paragraphs, widgets, tables, figures : What it shows.
    warnings : Sentences that are highlighted.
    points : A list.
    links : Files beside the report.
    folded : Long texts behind a line that opens them: line, text.
    """

    heading: str
    paragraphs: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    points: tuple[str, ...] = ()
    widgets: tuple[ReportWidget, ...] = ()
    tables: tuple[ReportTable, ...] = ()
    figures: tuple[ReportFigure, ...] = ()
    links: tuple[ReportLink, ...] = ()
    folded: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """The whole report.

    Attributes
    ----------
    title, subtitle : Title and line below it.
    summary : The most important results, in short.
    warnings : What limits it.
    facts : Names and values with their units, as tiles.
    sections : The rest.
    verdict : The first screen; None: title and summary open the report.
    """

    title: str
    subtitle: str
    summary: tuple[str, ...]
    warnings: tuple[str, ...]
    facts: tuple[tuple[str, str], ...]
    sections: tuple[ReportSection, ...]
    verdict: Verdict | None = None


FigureFiles = Mapping[str, Sequence[tuple[str, str, Path]]]
"""By section: title, caption and PNG file of each figure."""


def embedded_figures(
    figures: FigureFiles, section: str, *, only: str = "", without: str = ""
) -> tuple[ReportFigure, ...]:
    """Return the figures of a section with their images read in.

    Parameters
    ----------
    figures, section : All figures; which section's.
    only, without : Patterns of file names that are wanted, and that are not.
    """
    return tuple(
        read_figure(*one)
        for one in figures.get(section, ())
        if re.search(only, one[2].name) and not (without and re.search(without, one[2].name))
    )


def read_figure(title: str, caption: str, path: Path) -> ReportFigure:
    """Return a figure with its image read in.

    Parameters
    ----------
    title, caption, path : Name, what to see in it, its PNG file.
    """
    return ReportFigure(title=title, caption=caption, png=path.read_bytes())


def render_report(report: Report) -> str:
    """Return the report as one self-contained HTML page in the reader's light or dark theme.

    Parameters
    ----------
    report : The content; every text is escaped.
    """
    widgets = [widget for section in report.sections for widget in section.widgets]
    return page(
        report,
        headings=[section.heading for section in report.sections],
        libraries=[widget.library for widget in widgets if widget.library],
    )
