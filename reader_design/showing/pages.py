"""The report as one HTML file that opens from disk: no network, no script, images inside.

The content is plain data; `render_report` puts it into ``report.html.j2`` and escapes every text.
"""

import base64
import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jinja2 import Environment


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
    """

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    best: int | None = None
    words: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportFigure:
    """A figure of the report.

    Attributes
    ----------
    title : Name, also the alternative text of the image.
    caption : One sentence that says what to see in it.
    png : The image.
    """

    title: str
    caption: str
    png: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportSection:
    """A section of the report; its parts appear in the order of the fields.

    Attributes
    ----------
    heading, paragraphs, tables, figures : What it shows.
    warnings : Sentences that are highlighted.
    points : A list.
    folded : Long texts behind a line that opens them: line, text.
    """

    heading: str
    paragraphs: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    points: tuple[str, ...] = ()
    tables: tuple[ReportTable, ...] = ()
    figures: tuple[ReportFigure, ...] = ()
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
    """

    title: str
    subtitle: str
    summary: tuple[str, ...]
    warnings: tuple[str, ...]
    facts: tuple[tuple[str, str], ...]
    sections: tuple[ReportSection, ...]


def embedded_figures(
    figures: Mapping[str, Sequence[tuple[str, str, Path]]], section: str
) -> tuple[ReportFigure, ...]:
    """Return the figures of a section with their images read in.

    Parameters
    ----------
    figures : By section: title, caption and PNG file of each figure.
    section : Which.
    """
    return tuple(
        ReportFigure(title=title, caption=caption, png=path.read_bytes())
        for title, caption, path in figures.get(section, ())
    )


def render_report(report: Report) -> str:
    """Return the report as one self-contained HTML page in the reader's light or dark theme.

    Parameters
    ----------
    report : The content; every text is escaped.
    """
    return _environment().get_template("report.html.j2").render(report=report)


@cache
def _environment() -> "Environment":
    """Return where the templates are, and how texts get into them."""
    from jinja2 import Environment, PackageLoader
    from markupsafe import Markup

    def plain(value: str) -> Markup:
        return Markup(html.escape(value))  # noqa: S704  # escaped here

    def words(value: str) -> Markup:
        """Return escaped text with r_a and h_p as subscripts."""
        marked = re.sub(r"\b([rh])_([ap])\b", r"<i>\1</i><sub>\2</sub>", html.escape(value))
        return Markup(marked)  # noqa: S704  # escaped here

    environment = Environment(
        loader=PackageLoader(__package__, "."),
        autoescape=True,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["plain"] = plain
    environment.filters["words"] = words
    environment.filters["base64"] = lambda data: base64.b64encode(data).decode("ascii")
    return environment
