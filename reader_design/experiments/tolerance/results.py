"""What a tolerance study leaves: netCDF, CSV, figures, report."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.geometries.files import write_text
from octant.reader_design.experiments.tolerance.figures import (
    distribution_figure,
    explained_figure,
    slope_figure,
)
from octant.reader_design.experiments.tolerance.page import tolerance_section
from octant.reader_design.experiments.tolerance.study import ToleranceStudy
from octant.reader_design.setting.design import canonical_json
from octant.reader_design.showing.netcdf import dataset, variable, write_dataset
from octant.reader_design.showing.pages import (
    Report,
    ReportFigure,
    ReportSection,
    read_figure,
    render_report,
)
from octant.reader_design.showing.style import save_figure
from octant.reader_design.showing.tables import put_table
from octant.reader_design.study_file.loading import to_toml

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

FILES = ("tolerance.nc", "tolerance.csv", "report.html", "study.toml")

CSV_HEADER = (
    "design",
    "score",
    "unit",
    "drawn",
    "median",
    "median_low",
    "median_high",
    "p05",
    "p05_low",
    "p05_high",
    "p95",
    "p95_low",
    "p95_high",
    "yield",
    "yield_low",
    "yield_high",
    "samples",
    "not_built",
)


def write_results(result: ToleranceStudy, out: Path) -> ReportSection:
    """Write all files, and return the report's section, its paragraphs the summary for people.

    Parameters
    ----------
    result, out : The study and the folder.
    """
    figures = _figures(result, out / "figures")
    write_dataset(tolerance_dataset(result), out / "tolerance.nc", force=True)
    put_table(str(out / "tolerance.csv"), CSV_HEADER, csv_rows(result), force=True)
    write_text(out / "study.toml", to_toml(result.study, relative_to=out))
    section = tolerance_section(result, figures)
    report = Report(
        title=f"{result.study.name}: as built",
        subtitle=f"Tolerances of {result.chosen.design.label()}, seed {result.study.seed}",
        summary=(),
        warnings=(),
        facts=(),
        sections=(section,),
    )
    write_text(out / "report.html", render_report(report))
    return section


def csv_rows(result: ToleranceStudy) -> Iterator[tuple[object, ...]]:
    """Yield one row for each design and score, as ``CSV_HEADER`` names them [score's unit].

    Parameters
    ----------
    result : The study.
    """
    for one in (result.chosen, *result.rivals):
        for view, spread in zip(result.shown, one.spreads, strict=True):
            numbers = [x for i in (*spread, one.good) for x in (i.value, i.low, i.high)]
            yield (
                one.name,
                view.name,
                view.unit,
                view.of(one.nominal),
                *numbers,
                len(one.samples),
                one.not_built,
            )


def tolerance_dataset(result: ToleranceStudy) -> "xr.Dataset":
    """Return every sample's scores and errors, and the slopes by parameter, with units.

    Parameters
    ----------
    result : The study.
    """
    designs = (result.chosen, *result.rivals)
    variables = {}
    for v, view in enumerate(result.shown):
        variables[view.name] = variable(
            ["design", "sample"],
            np.stack([one.values[:, v] for one in designs]),
            units=view.unit,
            long_name=view.title,
            missing="it cannot be built",
        )
        variables[f"{view.name}_drawn"] = variable(
            ["design"],
            [view.of(one.nominal) for one in designs],
            units=view.unit,
            long_name=f"{view.title}, as drawn",
            missing="it cannot be built",
        )
    for name in ("radial_m", "azimuth_rad", "gap_m", "length_m", "tilt_rad", "tilt_azimuth_rad"):
        variables[f"error_{name}"] = _errors(result, name, "antenna")
    for name in ("plate_azimuth_rad", "plate_height_m"):
        variables[f"error_{name}"] = _errors(result, name, "plate")
    variables["error_ground_plane_m"] = variable(
        ["sample"],
        [d.build.ground_plane_m for d in result.deviations],
        units="m",
        long_name="error of the ground plane's size",
    )
    for kind in ("frequency", "permittivity", "conductivity"):
        factors = [getattr(d, f"{kind}_factor") for d in result.deviations]
        variables[f"factor_{kind}"] = variable(
            ["sample"], factors, units="1", long_name=f"{kind} over the study's"
        )
    variables.update(_slope_variables(result))
    variables.update(_linear_variables(result))
    names = {
        "design": [one.name for one in designs],
        "parameter": [p.name for p in result.parameters],
    }
    coordinates = {
        name: variable([name], texts, units="1", long_name=name) for name, texts in names.items()
    }
    return dataset(
        variables,
        coordinates=coordinates,
        study_toml=to_toml(result.study),
        seed=result.study.seed,
        title="tolerance study",
        attributes={
            "yield_by_design": canonical_json(
                [[one.good.value, one.good.low, one.good.high] for one in designs]
            ),
            "confidence_by_rival": canonical_json(
                [[c.value, c.low, c.high] for c in result.confidence]
            ),
            "confidence_over_places_by_rival": canonical_json(
                [[c.value, c.low, c.high] for c in result.confidence_places]
            ),
        },
    )


def _errors(result: ToleranceStudy, name: str, of: str) -> "xr.Variable":
    words = name.rsplit("_", 1)
    return variable(
        ["sample", of],
        np.stack([getattr(d.build, name) for d in result.deviations]),
        units=words[1],
        long_name=f"error: {words[0].replace('_', ' ')}",
    )


def _slope_variables(result: ToleranceStudy) -> "dict[str, xr.Variable]":
    """Return the slopes of every score by parameter; per mm or per degree, as parameters have."""
    out = {}
    for view in result.shown:
        mine = [s for s in result.slopes if s.score == view.name]
        for kind in ("up", "down", "central", "doubt") if mine else ():
            out[f"slope_{kind}_{view.name}"] = variable(
                ["parameter"],
                [getattr(s, kind) for s in mine],
                units=f"{view.change_unit} per mm or per degree",
                long_name=f"slope ({kind}) of the {view.title}",
                missing="no slope",
            )
    return out


def _linear_variables(result: ToleranceStudy) -> "dict[str, xr.Variable]":
    """Return the scores of ports to first order; nothing without derivatives."""
    if result.linear is None:
        return {}
    return {
        f"linear_{view.name}": variable(
            ["draw"],
            column,
            units=view.unit,
            long_name=f"{view.title}, ports to first order",
        )
        for view, column in zip(result.shown, result.linear.T, strict=True)
        if not np.isnan(column).any()
    }


def _figures(result: ToleranceStudy, folder: Path) -> tuple[ReportFigure, ...]:
    """Return the figures for the report, once written."""
    designs = [
        (one.name, np.array([view.of(one.nominal) for view in result.shown]), one.values)
        for one in (result.chosen, *result.rivals)
    ]
    label = result.chosen.design.label()
    drawn = {
        "distributions": (
            distribution_figure(result.shown, designs, title=f"Scores as built: {label}"),
            "Distribution of every score",
            "Steps: share of readers below a value; dashed: the drawing; shaded: 5 % to 95 %.",
        ),
        "sensitivity": (
            slope_figure(result.shown, result.slopes, title=f"Sensitivity: {label}"),
            "Sensitivity to errors that all antennas or plates share",
            "What one millimetre or one degree more, and less, does to each score.",
        ),
        "variance": (
            explained_figure(
                result.shown, result.explained, title=f"What explains the spread: {label}"
            ),
            "Share of the variance explained by each kind of error",
            "Linear regression on mean and scatter of each kind; R² also for readers left out.",
        ),
    }
    out = []
    for name, (figure, title, caption) in drawn.items():
        if figure is not None:
            path = folder / f"{name}.png"
            save_figure(figure, path)
            out.append(read_figure(title, caption, path))
    return tuple(out)
