"""The report as one HTML file that opens from disk: no network, no script, images inside.

The content is plain data; :func:`render_report` is the only place that writes HTML, and escapes
every text it is given.
"""

import base64
import html
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

STYLE = """
:root { color-scheme: light dark; --ink: #1c2126; --soft: #5c6670; --line: #dfe3e7;
  --page: #ffffff; --card: #f5f7f8; --accent: #2b4c7e; --warn: #9a5b00; --warn-bg: #fdf4e3; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e7ea; --soft: #a2abb4; --line: #3a424a; --page: #171b1f; --card: #20262b;
    --accent: #9dbbe8; --warn: #f0c067; --warn-bg: #322a1a; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 62rem; margin: 0 auto; padding: 2.5rem 1.5rem 4rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; letter-spacing: -.01em; }
h2 { font-size: 1.3rem; margin: 3rem 0 .8rem; padding-top: 1rem;
  border-top: 1px solid var(--line); }
h3 { font-size: 1.02rem; margin: 1.8rem 0 .5rem; }
p { margin: .5rem 0; max-width: 46rem; }
.sub { color: var(--soft); margin-bottom: 1.6rem; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(13rem, 1fr)); gap: .8rem;
  margin: 1.4rem 0; padding: 0; }
.facts div { background: var(--card); border-radius: 8px; padding: .8rem 1rem; }
.facts dt { color: var(--soft); font-size: .85rem; }
.facts dd { margin: .15rem 0 0; font-size: 1.12rem; font-weight: 600; }
.warn { background: var(--warn-bg); border-left: 4px solid var(--warn); border-radius: 4px;
  padding: .6rem 1rem; margin: 1rem 0; }
.warn p { margin: .3rem 0; max-width: none; }
ul { padding-left: 1.2rem; } li { margin: .25rem 0; max-width: 46rem; }
.scroll { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--soft); padding: 0 0 .5rem; font-size: .9rem; }
th, td { padding: .35rem .65rem; border-bottom: 1px solid var(--line); text-align: right;
  vertical-align: bottom; }
th { font-weight: 600; color: var(--soft); }
th:first-child, td:first-child { text-align: left; }
td { white-space: nowrap; }
td:first-child, th:first-child { position: sticky; left: 0; background: var(--page); }
table.words td, table.words th { text-align: left; vertical-align: top; white-space: normal; }
sub { font-size: .7em; line-height: 0; }
tr.best td, tr.best td:first-child { background: var(--card); font-weight: 600;
  color: var(--accent); }
figure { margin: 1.4rem 0 2rem; }
figure img { max-width: 100%; height: auto; display: block; background: #fff; padding: .6rem;
  border: 1px solid var(--line); border-radius: 8px; }
figcaption { color: var(--soft); font-size: .93rem; margin-top: .5rem; max-width: 46rem; }
pre { background: var(--card); border-radius: 8px; padding: 1rem; overflow-x: auto;
  font: .82rem/1.5 ui-monospace, "SF Mono", Menlo, Consolas, monospace; }
details summary { cursor: pointer; color: var(--accent); }
@media print { main { max-width: none; } figure, tr { break-inside: avoid; } }
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportTable:
    """A table of the report; all cells are text that already carries its unit or stands under it.

    Attributes
    ----------
    caption : str
        One sentence above the table.
    header : tuple of str
        Column headings, with units in brackets.
    rows : tuple of tuple of str
        Cells.
    best : int or None
        Row that is set off.
    words : bool
        True: cells hold words, set flush left.
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
    title : str
        Name, also for readers who cannot see it.
    caption : str
        One sentence that says what to see in it.
    png : bytes
        The image.
    """

    title: str
    caption: str
    png: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportSection:
    """A section of the report; its parts appear in the order of the fields.

    Attributes
    ----------
    heading : str
        Heading.
    paragraphs : tuple of str
        Text.
    warnings : tuple of str
        Sentences that are set off, because the reader must not miss them.
    points : tuple of str
        A list.
    tables : tuple of ReportTable
        Tables.
    figures : tuple of ReportFigure
        Figures.
    folded : tuple of (str, str)
        Long texts behind a line that opens them: line, text.
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
    title : str
        Title.
    subtitle : str
        Line below it.
    summary : tuple of str
        What a hurried reader must know, first of all.
    warnings : tuple of str
        What limits it.
    facts : tuple of (str, str)
        Names and values with their units, as tiles.
    sections : tuple of ReportSection
        The rest.
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
    figures : mapping of str to sequence of (str, str, Path)
        By section: title, caption and PNG file of each figure.
    section : str
        Which.
    """
    return tuple(
        ReportFigure(title=title, caption=caption, png=path.read_bytes())
        for title, caption, path in figures.get(section, ())
    )


def _text(value: str) -> str:
    """Return escaped text with r_a and h_p as subscripts."""
    return re.sub(r"\b([rh])_([ap])\b", r"<i>\1</i><sub>\2</sub>", html.escape(value))


def _paragraphs(values: Iterable[str]) -> str:
    return "".join(f"<p>{_text(v)}</p>\n" for v in values)


def _warnings(values: Sequence[str]) -> str:
    return f'<div class="warn" role="note">\n{_paragraphs(values)}</div>\n' if values else ""


def _table(table: ReportTable) -> str:
    head = "".join(f'<th scope="col">{_text(h)}</th>' for h in table.header)
    body = "".join(
        ('<tr class="best">' if i == table.best else "<tr>")
        + "".join(f"<td>{_text(cell)}</td>" for cell in row)
        + "</tr>\n"
        for i, row in enumerate(table.rows)
    )
    kind = ' class="words"' if table.words else ""
    return (
        f'<div class="scroll"><table{kind}><caption>{_text(table.caption)}</caption>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n"
    )


def _figure(figure: ReportFigure) -> str:
    data = base64.b64encode(figure.png).decode("ascii")
    return (
        f'<figure><img alt="{html.escape(figure.title, quote=True)}" '
        f'src="data:image/png;base64,{data}">\n'
        f"<figcaption><b>{_text(figure.title)}.</b> {_text(figure.caption)}</figcaption></figure>\n"
    )


def _section(section: ReportSection) -> str:
    points = "".join(f"<li>{_text(p)}</li>\n" for p in section.points)
    return "".join(
        (
            f"<section>\n<h2>{_text(section.heading)}</h2>\n",
            _paragraphs(section.paragraphs),
            _warnings(section.warnings),
            f"<ul>\n{points}</ul>\n" if points else "",
            *(_table(t) for t in section.tables),
            *(_figure(f) for f in section.figures),
            *(
                f"<details><summary>{_text(line)}</summary>\n"
                f"<pre>{html.escape(text)}</pre></details>\n"
                for line, text in section.folded
            ),
            "</section>\n",
        )
    )


def render_report(report: Report) -> str:
    """Return the report as one self-contained HTML page; numbers keep the units they come with.

    Parameters
    ----------
    report : Report
        The content; every text is escaped.

    Returns
    -------
    str
        HTML without script, external link or font, that follows the reader's light or dark theme.
    """
    facts = "".join(
        f"<div><dt>{_text(name)}</dt><dd>{_text(value)}</dd></div>\n"
        for name, value in report.facts
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(report.title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f'<main>\n<h1>{_text(report.title)}</h1>\n<p class="sub">{_text(report.subtitle)}</p>\n'
        + _paragraphs(report.summary)
        + (f'<dl class="facts">\n{facts}</dl>\n' if facts else "")
        + _warnings(report.warnings)
        + "".join(_section(s) for s in report.sections)
        + "</main>\n</body>\n</html>\n"
    )
