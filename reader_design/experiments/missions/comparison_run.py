"""A comparison from end to end: cells driven or read, table, figures, report."""

import itertools
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from octant.geometries.files import refuse_overwrite, write_text
from octant.reader_design.experiments.missions.comparison_cells import (
    ComparisonCell,
    plan_comparison,
)
from octant.reader_design.experiments.missions.comparison_file import Comparison
from octant.reader_design.experiments.missions.comparison_outcomes import (
    COLUMNS,
    CellOutcome,
    outcome_of,
)
from octant.reader_design.experiments.missions.mission_stage import mission_stage
from octant.reader_design.experiments.missions.placements import first_placement
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.design import content_hash
from octant.reader_design.setting.links import study_responses
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.showing.tables import put_table

CELLS = "cells"
"""Folder of the cells' files, each named by the hash of its whole input."""


def run_comparison(
    comparison: Comparison, out_dir: Path, *, force: bool = False, progress: Progress | None = None
) -> tuple[CellOutcome, ...]:
    """Return the outcome of every cell; write compare.csv, report.html and figures.

    Parameters
    ----------
    comparison : Comparison
        What is compared.
    out_dir : Path
        Folder for results. Cells that lie there already are read, not driven again.
    force : bool
        Overwrite table and report of an earlier comparison.
    progress : Progress or None
        Told about cells and runs.
    """
    progress = progress or Progress()
    cells = plan_comparison(comparison)
    table, page = out_dir / "compare.csv", out_dir / "report.html"
    refuse_overwrite(table, page, force=force)
    outcomes: list[CellOutcome] = []
    figures: dict[str, list[tuple[str, str, Path]]] = {}
    for outcome, built in progress.track(
        _outcomes(cells, out_dir / CELLS, progress), total=len(cells), label="cells"
    ):
        outcomes.append(outcome)
        progress.say(_sentence(outcome))
        figures.setdefault(outcome.cell.layout, []).extend(
            _cell_figures(outcome, built, out_dir / "figures")
        )
    put_table(str(table), COLUMNS, [outcome.row() for outcome in outcomes], force=True)
    _write_report(comparison, outcomes, figures, out_dir)
    return tuple(outcomes)


def _outcomes(
    cells: Sequence[ComparisonCell], folder: Path, progress: Progress
) -> Iterator[tuple[CellOutcome, Setting]]:
    """Yield each cell's outcome and room; cells that share room and reader build them once."""
    for _, group in itertools.groupby(cells, key=lambda c: (c.layout, c.link, c.reader)):
        alike = list(group)
        study = alike[0].study
        built = build_setting(study)
        responses = study_responses(study)
        for cell in alike:
            mission = mission_stage(
                cell.study,
                built,
                responses,
                design_key=content_hash(study.reader.as_dict()),
                name=cell.layout,
                slug=_slug(cell.layout),
                runs=cell.study.mission.runs if cell.study.mission else 0,
                folder=folder,
                progress=progress,
            )
            yield outcome_of(cell, mission), built


def _slug(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "layout"


def _sentence(outcome: CellOutcome) -> str:
    cell = outcome.cell
    if outcome.mission.reason:
        return f"{cell.layout}, {cell.label}: not driven, because {outcome.mission.reason}"
    return (
        f"{cell.layout}, {cell.label}: {outcome.successes} of {outcome.runs} reached every tag, "
        f"median RMSE {outcome.rmse_m:.3f} m"
    )


def _cell_figures(
    outcome: CellOutcome, built: Setting, folder: Path
) -> Iterator[tuple[str, str, Path]]:
    """Draw one cell's first run, unless it is drawn already; yield title, caption and file."""
    drive, mission = outcome.mission.drive, outcome.cell.study.mission
    if drive is None or mission is None:
        return
    path = folder / f"{outcome.mission.folder.name.removeprefix('mission-')}.png"
    if not path.exists():
        from octant.reader_design.experiments.missions.figures import drive_figure
        from octant.reader_design.showing.plan import plan_of
        from octant.reader_design.showing.style import save_figure

        if mission.placement_m > 0.0:
            built = first_placement(outcome.cell.study, None, runs=mission.runs)
        figure = drive_figure(
            drive,
            plan_of(built.scene, built.reader_z_m),
            {tag_id: built.tag(tag_id).point_m for tag_id in mission.tags},
            title=f"{outcome.cell.layout}: {outcome.cell.label}",
        )
        save_figure(figure, path)
    data = outcome.mission.data
    end = "" if data is None else f" It ended because {data['ended_because'].values[0]}."
    yield (
        outcome.cell.label,
        f"Run 0 of {outcome.runs}, of which {outcome.successes} reached every tag.{end}",
        path,
    )


def _write_report(
    comparison: Comparison,
    outcomes: Sequence[CellOutcome],
    figures: dict[str, list[tuple[str, str, Path]]],
    out_dir: Path,
) -> None:
    from octant.reader_design.experiments.missions.comparison_page import comparison_report
    from octant.reader_design.experiments.missions.figures import comparison_figure
    from octant.reader_design.showing.pages import render_report
    from octant.reader_design.showing.style import save_figure

    overview = out_dir / "figures" / "overview.png"
    save_figure(comparison_figure(outcomes, title=comparison.name), overview)
    report = comparison_report(comparison, outcomes, figures, overview)
    write_text(out_dir / "report.html", render_report(report))
