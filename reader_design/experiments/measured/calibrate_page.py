"""What a calibration leaves: the fitted study, a table of values, figures, the page."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from octant.geometries.files import write_text
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.statistics import Interval
from octant.reader_design.experiments.measured.calibrate import Calibrated
from octant.reader_design.experiments.measured.calibrate_names import Parameter
from octant.reader_design.experiments.measured.compare_figures import (
    against_figure,
    compare_figures,
    residual_maps,
)
from octant.reader_design.experiments.measured.compare_page import laws_table, save_figures
from octant.reader_design.experiments.measured.sight import straight_lines
from octant.reader_design.showing.pages import (
    Report,
    ReportSection,
    ReportTable,
    read_figure,
    render_report,
)
from octant.reader_design.showing.style import NamedFigure
from octant.reader_design.study_file.loading import to_toml

COLUMNS = ("parameter", "unit", "before", "value", "low", "high")
"""Columns of calibrated.csv, one row a fitted value with the ends of its 95 % interval."""
FITTED = "fitted.toml"
OUTPUTS = ("calibrated.csv", FITTED, "figures/*.png", "report.html")


def value_text(parameter: Parameter, found: Interval) -> str:
    """Return a value with its interval and unit.

    Parameters
    ----------
    parameter, found : What it is; its value and interval, in its unit [any].
    """
    unit = "" if parameter.unit == "-" else f" {parameter.unit}"
    if not (math.isfinite(found.low) and math.isfinite(found.high)):
        return f"{found.value:.4g}{unit} (not told by the log)"
    digits = max(2, min(6, 2 - math.floor(math.log10(max(found.high - found.low, 1e-9)))))
    if parameter.unit in {"dB", "deg"}:
        digits = 2
    low, value, high = (f"{x:.{digits}f}" for x in (found.low, found.value, found.high))
    return f"{value} ({low} to {high}){unit}"


def headline(found: Calibrated) -> str:
    """Return the held-out error in one sentence [dB].

    Parameters
    ----------
    found : The calibration.
    """
    law = min(found.baselines, key=lambda one: one.sd_db)
    what = (
        "each anchor in turn held out, its own numbers fitted to itself and shared ones to the "
        "others"
        if found.how == "anchors"
        else f"{found.folds} times a part of the floor held out"
    )
    return (
        f"Held-out error {found.held_out_sd_db:.2f} dB ({what}); before {found.before_sd_db:.2f} "
        f"dB with levels free; best law {law.sd_db:.2f} dB ({law.name})."
    )


def calibrate_lines(found: Calibrated) -> tuple[str, ...]:
    """Return what a person wants to read at the end ([dB], and units of the values).

    Parameters
    ----------
    found : The calibration.
    """
    pairs = zip(found.problem.parameters, found.values, strict=True)
    lines = [headline(found)]
    lines += [f"{p.name}: {value_text(p, v)}" for p, v in pairs]
    return (*lines, *doubts(found))


def doubts(found: Calibrated) -> tuple[str, ...]:
    """Return what limits a calibration, a sentence each.

    Parameters
    ----------
    found : The calibration.
    """
    out = []
    for names in (*found.told.unknown, *found.told.weak):
        what = " and ".join(names)
        out.append(
            f"The log hardly tells {what} apart: their intervals say how far."
            if len(names) > 1
            else f"The log tells little of {what}: its interval says how far."
        )
    for p, v in zip(found.problem.parameters, found.values, strict=True):
        span = p.inward(p.high) - p.inward(p.low)
        x = p.inward(v.value)
        if min(x - p.inward(p.low), p.inward(p.high) - x) <= 1e-3 * span:
            out.append(f"{p.name} ends at its bound, {v.value:.4g} {p.unit}: the model is wrong.")
    rows = found.problem.rows
    lost = int(rows.log.censored.sum())
    if lost and rows.log.threshold_dbm is None:
        out.append(
            f"{lost} times a source was not heard; no threshold is known, so that these are left "
            "out: give log.threshold_dbm to count them as weak."
        )
    return tuple(dict.fromkeys(out))


def _values_table(found: Calibrated) -> ReportTable:
    rows = tuple(
        (p.name, "–" if math.isnan(p.start) else f"{p.start:.4g} {p.unit}", value_text(p, v))
        for p, v in zip(found.problem.parameters, found.values, strict=True)
    )
    return ReportTable(
        caption="Fitted values with their 95 % intervals, robust to unequal doubts (HC3).",
        header=("value", "before", "fitted"),
        rows=rows,
        words=True,
    )


def calibrate_report(found: Calibrated, figures: Sequence[NamedFigure], folder: Path) -> Report:
    """Return the report of a calibration.

    Parameters
    ----------
    found, figures, folder : The calibration; its figures, and where their files are.
    """
    o = found.problem.observations
    fitted = found.whole.residual_db[np.isfinite(found.whole.residual_db)]
    models = [
        ("the study before", "1 a source", found.before_sd_db),
        ("the fit, on what it was fitted to", "as below", float(np.sqrt(np.mean(fitted**2)))),
        ("the fit, held out", "as below", found.held_out_sd_db),
    ]
    sections = (
        ReportSection(
            heading="What it is worth",
            paragraphs=(
                (
                    f"Besides the scatter of readings ({found.whole.scatter_db:.2f} dB) the model "
                    f"errs by {found.whole.model_error_db:.2f} dB: furniture, antennas and all "
                    "that the mesh lacks."
                ),
            ),
            tables=(laws_table(models, found.baselines, o.scatter_db),),
        ),
        ReportSection(heading="Values", tables=(_values_table(found),)),
        ReportSection(
            heading="What is left",
            figures=tuple(
                read_figure(f.title, f.caption, folder / "figures" / f.file) for f in figures
            ),
        ),
        ReportSection(
            heading="The fitted study",
            folded=(("The study with the fitted values (fitted.toml)", to_toml(found.study)),),
        ),
    )
    return Report(
        title=f"{found.problem.study.name}: calibrated",
        subtitle=f"{len(found.problem.rows.log)} readings, {len(o)} local means",
        summary=(headline(found),),
        warnings=doubts(found),
        facts=(
            ("held-out error", f"{found.held_out_sd_db:.2f} dB"),
            ("before", f"{found.before_sd_db:.2f} dB"),
            ("readings within a cell", f"{o.scatter_db:.2f} dB"),
        ),
        sections=sections,
    )


def write_calibrated(found: Calibrated, out: Path) -> tuple[Path, ...]:
    """Return the files of a calibration, written: values, fitted study, figures, page.

    Parameters
    ----------
    found, out : The calibration; folder of the results.
    """
    problem = found.problem
    pairs = zip(problem.parameters, found.values, strict=True)
    rows = [
        (p.name, p.unit, *map(number_text, (p.start, v.value, v.low, v.high))) for p, v in pairs
    ]
    write_csv(out / "calibrated.csv", COLUMNS, rows)
    head = "".join(
        f"# {p.name}: {value_text(p, v)}\n"
        for p, v in zip(problem.parameters, found.values, strict=True)
    )
    intro = f"# Fitted to a log, with 95 % intervals. {headline(found)}\n"
    write_text(out / FITTED, intro + head + "\n" + to_toml(found.study, relative_to=out))
    distance, walls = straight_lines(problem.setting, problem.rows, problem.observations)
    figures = compare_figures(
        {
            "residuals": residual_maps(
                problem.setting,
                problem.rows,
                problem.observations,
                found.held_out_db,
                title="Local means, held out: measured less predicted",
            ),
            "against": against_figure(
                distance, walls, found.held_out_db, title="What residuals follow, held out"
            ),
        }
    )
    files = save_figures(figures, out)
    page = out / "report.html"
    write_text(page, render_report(calibrate_report(found, figures, out)))
    return (out / "calibrated.csv", out / FITTED, *files, page)
