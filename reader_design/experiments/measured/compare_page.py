"""The report of a comparison, its tables and what it says at the end."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from octant.geometries.files import write_text
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.statistics import Interval
from octant.reader_design.experiments.measured.agreement import Agreement
from octant.reader_design.experiments.measured.baselines import Baseline
from octant.reader_design.experiments.measured.compare import Compared, link_rows
from octant.reader_design.experiments.measured.compare_figures import (
    against_figure,
    compare_figures,
    levels_figure,
    residual_maps,
)
from octant.reader_design.showing.pages import (
    Report,
    ReportSection,
    ReportTable,
    read_figure,
    render_report,
)
from octant.reader_design.showing.style import NamedFigure, save_figure

COLUMNS = (
    "id",
    "antenna",
    "x_m",
    "y_m",
    "readings",
    "not_heard",
    "measured_dbm",
    "predicted_dbm",
    "residual_db",
    "distance_m",
    "walls",
)
"""Columns of compare.csv, one row a local mean."""
OUTPUTS = ("compare.csv", "figures/*.png", "report.html")


def db_cell(interval: Interval, unit: str = "dB") -> str:
    """Return a number with its interval, a dash where there is none.

    Parameters
    ----------
    interval, unit : The number, and its unit [any].
    """
    if not math.isfinite(interval.value):
        return "–"
    end = f" {unit}" if unit else ""
    if not (math.isfinite(interval.low) and math.isfinite(interval.high)):
        return f"{interval.value:.2f}{end}"
    return f"{interval.value:.2f} ({interval.low:.2f} to {interval.high:.2f}){end}"


def agreement_table(rows: Sequence[Agreement], caption: str) -> ReportTable:
    """Return a table of agreements [dB].

    Parameters
    ----------
    rows, caption : One a line; what they are.
    """
    unheard = any(one.unheard[1] for one in rows)
    header = ("source", "count", "bias", "standard deviation", "correlation", "5 %", "95 %")
    lines = []
    for one in rows:
        cells = (
            one.name,
            str(one.count),
            db_cell(one.bias_db),
            db_cell(one.sd_db),
            db_cell(one.correlation, ""),
            db_cell(one.percentiles_db[0]),
            db_cell(one.percentiles_db[-1]),
        )
        more = (f"{one.unheard[0]} of {one.unheard[1]}",) if unheard else ()
        lines.append((*cells, *more))
    return ReportTable(
        caption=caption,
        header=(*header, *(("not heard, and predicted so",) if unheard else ())),
        rows=tuple(lines),
    )


def laws_table(
    found: Sequence[tuple[str, str, float]], laws: Sequence[Baseline], scatter_db: float
) -> ReportTable:
    """Return the table of the model beside standing laws and the scatter that none can beat [dB].

    Parameters
    ----------
    found : The model's lines: name, numbers fitted, standard deviation [dB].
    laws : Baselines.
    scatter_db : Of readings within a cell [dB].
    """
    rows = [(name, fitted, f"{sd:.2f} dB") for name, fitted, sd in found]
    rows += [
        (law.name, f"{law.own} a source" + (f", {law.shared} shared" if law.shared else ""),
         f"{law.sd_db:.2f} dB")
        for law in laws
    ]  # fmt: skip
    rows.append(
        ("readings about their local mean (no map can beat it)", "–", f"{scatter_db:.2f} dB")
    )
    return ReportTable(
        caption="Standard deviation of local means. Of laws, what sources share is fitted to the "
        "others; the last line is of single readings.",
        header=("model", "fitted numbers", "standard deviation"),
        rows=tuple(rows),
        words=True,
    )


def compare_lines(found: Compared) -> tuple[str, ...]:
    """Return what a person wants to read at the end [dB].

    Parameters
    ----------
    found : The comparison.
    """
    o = found.observations
    best = min(found.baselines, key=lambda law: law.sd_db)
    first = (
        f"{len(o)} local means: {found.sd_free_db:.2f} dB about the prediction with a free level "
        f"for each source and antenna; best law: {best.sd_db:.2f} dB ({best.name}); readings "
        f"within a cell: {o.scatter_db:.2f} dB."
    )
    lines = [
        f"{one.name}: bias {one.bias_db.value:+.2f} dB, sd {one.sd_db.value:.2f} dB, correlation "
        f"{one.correlation.value:.2f} over {one.count}"
        for one in found.links
    ]
    return (first, *lines, *found.notes)


def compare_report(found: Compared, figures: Sequence[NamedFigure], folder: Path) -> Report:
    """Return the report of a comparison.

    Parameters
    ----------
    found, figures, folder : The comparison; its figures, and where their files are.
    """
    study = found.setting.study
    law = min(found.baselines, key=lambda one: one.sd_db)
    free = f"{found.sd_free_db:.2f} dB"
    below = "below" if found.sd_free_db < law.sd_db else "above"
    sections = (
        ReportSection(
            heading="How well it fits",
            tables=(
                laws_table(
                    [("this study, levels free", "1 a source and antenna", found.sd_free_db)],
                    found.baselines,
                    found.observations.scatter_db,
                ),
                agreement_table(
                    found.links,
                    "Local means: measured less predicted. In brackets 95 % intervals (bootstrap "
                    "over cells); percentiles are about the bias.",
                ),
                agreement_table(found.readings, "The same of single readings that were heard."),
                agreement_table(
                    found.by_walls, "Local means by what stands between, levels of sources free."
                ),
            ),
        ),
        ReportSection(
            heading="Where it does not",
            figures=tuple(
                read_figure(f.title, f.caption, folder / "figures" / f.file) for f in figures
            ),
        ),
    )
    return Report(
        title=f"{study.name}: measured against predicted",
        subtitle=f"{len(found.rows.log)} readings, {len(found.observations)} local means",
        summary=(
            (
                f"Local means scatter by {free} about the prediction when each source's level is "
                f"free, which is {below} the best law's {law.sd_db:.2f} dB ({law.name})."
            ),
            (
                "Predicted are power sums over the paths, the mean over fast fading; measured are "
                "means of levels in dB, which under Rayleigh fading lie 2.5 dB lower."
            ),
        ),
        warnings=found.notes,
        facts=(
            ("local means, levels free", free),
            ("best law", f"{law.sd_db:.2f} dB"),
            ("readings within a cell", f"{found.observations.scatter_db:.2f} dB"),
        ),
        sections=sections,
    )


def write_compared(found: Compared, out: Path) -> tuple[Path, ...]:
    """Return the files of a comparison, written: table, figures, page.

    Parameters
    ----------
    found, out : The comparison; folder of the results.
    """
    o = found.observations
    names = [_group(found, int(s), int(a)) for s, a in zip(o.sources, o.antennas, strict=True)]
    figures = compare_figures(
        {
            "residuals": residual_maps(
                found.setting,
                found.rows,
                o,
                found.residual_db,
                title="Local means: measured less predicted, levels free",
            ),
            "against": against_figure(
                found.distance_m, found.walls, found.residual_db, title="What residuals follow"
            ),
            "levels": levels_figure(o.level_dbm, found.predicted_dbm, names, title="Local means"),
        }
    )
    files = save_figures(figures, out)
    table = out / "compare.csv"
    write_csv(table, COLUMNS, _rows(found))
    page = out / "report.html"
    write_text(page, render_report(compare_report(found, figures, out)))
    return (table, *files, page)


def save_figures(figures: Sequence[NamedFigure], out: Path) -> tuple[Path, ...]:
    """Return the files of figures, written.

    Parameters
    ----------
    figures, out : The figures; the folder that ``figures`` is in.
    """
    (out / "figures").mkdir(parents=True, exist_ok=True)
    files = tuple(out / "figures" / one.file for one in figures)
    for one, file in zip(figures, files, strict=True):
        save_figure(one.figure, file)
    return files


def _group(found: Compared, source: int, antenna: int) -> str:
    keys = list(link_rows(found.observations))
    return found.links[keys.index((source, antenna))].name


def _rows(found: Compared) -> list[tuple[object, ...]]:
    o, residual = found.observations, found.residual_db
    return [
        (
            found.rows.log.ids[int(o.sources[i])],
            int(o.antennas[i]) or "-",
            *(number_text(float(v)) for v in o.places[i]),
            int(o.heard[i]),
            int(o.censored[i]),
            number_text(float(o.level_dbm[i])),
            number_text(float(found.predicted_dbm[i])),
            number_text(float(residual[i])),
            number_text(float(found.distance_m[i])),
            int(found.walls[i]),
        )
        for i in np.arange(len(o))
    ]
